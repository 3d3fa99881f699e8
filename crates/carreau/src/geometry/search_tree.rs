//! A static tree of bounding boxes over triangles: closest point, neighbourhood, rays.
//!
//! Median split on the longest side of the centroids' box. Because the median decides, the shape of the tree follows
//! from the number of its items alone: a node needs nothing but its box, children are found by arithmetic, and the two
//! halves can be built in parallel into their own parts of one array. Ties are broken by triangle id, so the tree is the
//! same for any number of threads.
//!
//! Nodes in preorder; a node over `leaves` leaves is followed by its left child over the first half (rounded up), whose
//! subtree has `2 · left − 1` nodes, and then by its right child:
//!
//! ```text
//!             0 (5 leaves)
//!        ┌────┴─────┐
//!        1 (3)      6 (2)
//!      ┌─┴─┐      ┌─┴─┐
//!      2   5      7   8
//!     ┌┴┐
//!     3 4
//! ```

use super::closest::closest_on_triangle;
use super::ray::Ray;
use super::slabs::Slab;
use super::slices::{Slice, slices};
use glam::DVec3;
use rayon::prelude::*;

/// Triangles per leaf.
const TRIANGLES_PER_LEAF: usize = 4;
/// Subtrees with fewer triangles are built by one thread.
const SERIAL: usize = 8192;
/// Jobs that pairs of triangles are divided into.
const JOBS: usize = 2048;
/// Deeper than any tree over 2³² triangles.
const DEEPEST: usize = 34;

/// Bounding boxes over triangles. Coordinates are best between 1e-150 and 1e150: distances are squared.
pub struct TriangleTree {
    boxes: Vec<Box3>,
    /// Slabs of the nodes, or none.
    slabs: Vec<Slab>,
    /// Corners of the triangles, in the order of the leaves: once for each of their slices.
    corners: Vec<[DVec3; 3]>,
    /// The slices with the ids, in the same order.
    slices: Vec<Slice>,
    /// Number of triangles.
    len: usize,
}

/// The point of the triangles that is closest to a given one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Closest {
    /// Id of the triangle; the smallest of several at the same distance.
    pub triangle: u32,
    /// Where.
    pub point: DVec3,
    /// Squared distance.
    pub distance_squared: f64,
}

impl Closest {
    /// The distance.
    pub fn distance(&self) -> f64 {
        self.distance_squared.sqrt()
    }
}

/// Where a ray meets a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Id of the triangle.
    pub triangle: u32,
    /// Distance along the ray, in lengths of its direction.
    pub t: f64,
    /// The ray meets the front, against the normal.
    pub front: bool,
}

#[derive(Clone, Copy)]
struct Box3 {
    low: DVec3,
    high: DVec3,
}

/// A node during a descent.
#[derive(Clone, Copy)]
struct Node {
    index: u32,
    first_leaf: u32,
    leaves: u32,
}

impl Node {
    fn children(self) -> [Node; 2] {
        let left = self.leaves.div_ceil(2);
        [
            Node { index: self.index + 1, first_leaf: self.first_leaf, leaves: left },
            Node { index: self.index + 2 * left, first_leaf: self.first_leaf + left, leaves: self.leaves - left },
        ]
    }
}

impl TriangleTree {
    /// Builds the tree; triangle `k` has id `k`.
    ///
    /// # Panics
    /// If a triangle uses a point that does not exist; meshes guarantee that it does.
    pub fn new(points: &[DVec3], triangles: &[[u32; 3]]) -> Self {
        let corners_of = |id: u32| triangles[id as usize].map(|v| points[v as usize]);
        let slices = slices(triangles.len(), corners_of);
        let centre = |(item, slice): (usize, &Slice)| {
            let outline = slice.outline(corners_of(slice.id));
            let corners = if slice.is_whole() { &outline[..3] } else { &outline[..4] };
            (corners.iter().sum::<DVec3>() / corners.len() as f64, item as u32)
        };
        let mut items: Vec<(DVec3, u32)> = slices.par_iter().enumerate().map(centre).collect();
        let leaves = slices.len().div_ceil(TRIANGLES_PER_LEAF);
        let mut boxes = vec![Box3::EMPTY; (2 * leaves).saturating_sub(1)];
        if leaves > 0 {
            let outline = |item: u32| slices[item as usize].outline(corners_of(slices[item as usize].id));
            build(&mut boxes, &mut items, leaves, &outline);
        }
        let slices: Vec<Slice> = items.into_iter().map(|(_, item)| slices[item as usize]).collect();
        let corners = slices.par_iter().map(|slice| corners_of(slice.id)).collect();
        TriangleTree { boxes, slabs: Vec::new(), corners, slices, len: triangles.len() }
    }

    /// The same tree for points far from the surface, as in its middle: closest points are found sooner there. `normals` are
    /// those of the triangles, of any length.
    pub fn with_slabs(mut self, normals: &[DVec3]) -> Self {
        let nodes = self.nodes();
        let slab = |node: &Node| {
            let held = self.held(*node);
            let normal = self.slices[held.clone()].iter().map(|slice| normals[slice.id as usize]).sum();
            Slab::around(self.corners[held].iter().flatten().copied(), normal)
        };
        self.slabs = nodes.par_iter().map(slab).collect();
        self
    }

    /// The tree of segments, as triangles without width; segment `k` has id `k`.
    ///
    /// # Panics
    /// If a segment uses a point that does not exist.
    pub fn of_segments(points: &[DVec3], segments: impl IntoIterator<Item = [u32; 2]>) -> Self {
        let flat: Vec<[u32; 3]> = segments.into_iter().map(|[a, b]| [a, b, b]).collect();
        TriangleTree::new(points, &flat)
    }

    /// Number of triangles.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there is no triangle.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The closest point; `None` only for an empty tree.
    pub fn closest(&self, p: DVec3) -> Option<Closest> {
        self.closest_within(p, f64::INFINITY)
    }

    /// How far the closest point is; zero for an empty tree.
    pub fn distance(&self, p: DVec3) -> f64 {
        self.closest(p).map_or(0.0, |c| c.distance())
    }

    /// The closest point that is not farther than `radius`, if there is one.
    pub fn closest_within(&self, p: DVec3, radius: f64) -> Option<Closest> {
        self.closest_below(p, radius * radius)
    }

    /// The closest point, sooner: with the corners of one of the triangles that is thought to be near.
    pub fn closest_near(&self, p: DVec3, corners: [DVec3; 3]) -> Option<Closest> {
        // A box may seem farther than what is in it, by rounding.
        let limit = p.distance_squared(closest_on_triangle(p, corners)) * (1.0 + 1e-9);
        self.closest_below(p, limit).or_else(|| self.closest(p))
    }

    /// The closest point whose squared distance is not above a limit.
    fn closest_below(&self, p: DVec3, limit: f64) -> Option<Closest> {
        let mut best = Closest { triangle: u32::MAX, point: p, distance_squared: limit };
        self.nearest_first(p, limit, |found| {
            if (found.distance_squared, found.triangle) < (best.distance_squared, best.triangle) {
                best = found;
            }
            best.distance_squared
        });
        (best.triangle != u32::MAX).then_some(best)
    }

    /// The triangle that costs least of those within `radius` that have a cost, and its cost; the smallest id of several. A
    /// cost is never below the distance: what is farther than the best costs is not looked at.
    pub fn cheapest(&self, p: DVec3, radius: f64, cost: impl Fn(&Closest) -> Option<f64>) -> Option<(f64, Closest)> {
        let (mut best, within): (Option<(f64, Closest)>, f64) = (None, radius * radius);
        self.nearest_first(p, within, |found| {
            if found.distance_squared <= within
                && let Some(cost) = cost(&found)
                && best.is_none_or(|(least, b)| (cost, found.triangle) < (least, b.triangle))
            {
                best = Some((cost, found));
            }
            // The square of a root may be less than the number by rounding.
            best.map_or(within, |(least, _)| radius.min(least).powi(2) * (1.0 + 4.0 * f64::EPSILON))
        });
        best
    }

    /// Offers triangles, the nearer ones about first, with their closest points; what is farther than the limit, squared, may be
    /// left out. The limit is what is returned for the last one.
    fn nearest_first(&self, p: DVec3, mut limit: f64, mut offer: impl FnMut(Closest) -> f64) {
        let mut stack = Stack::new();
        let to = |node: Node| {
            let to_box = self.boxes[node.index as usize].distance_squared(p);
            self.slabs.get(node.index as usize).map_or(to_box, |slab| to_box.max(slab.distance_squared(p)))
        };
        self.root().into_iter().for_each(|root| stack.push(root, to(root)));
        'waiting: while let Some((mut node, bound)) = stack.pop() {
            if bound > limit {
                continue;
            }
            // Down to the nearest leaf; what is farther away waits.
            while node.leaves > 1 {
                let [a, b] = node.children();
                let (to_a, to_b) = (to(a), to(b));
                let (near, to_near, far, to_far) = if to_b < to_a { (b, to_b, a, to_a) } else { (a, to_a, b, to_b) };
                if to_near > limit {
                    continue 'waiting;
                }
                stack.push(far, to_far);
                node = near;
            }
            for k in self.leaf(node) {
                if Box3::around(self.corners[k]).distance_squared(p) > limit {
                    continue;
                }
                let point = closest_on_triangle(p, self.corners[k]);
                limit =
                    offer(Closest { triangle: self.slices[k].id, point, distance_squared: p.distance_squared(point) });
            }
        }
    }

    /// Calls `visit` for every triangle whose closest point is not farther than `radius`, in no particular but always
    /// the same order.
    pub fn within(&self, p: DVec3, radius: f64, mut visit: impl FnMut(Closest)) {
        let limit = radius * radius;
        self.descend(
            |b| b.distance_squared(p) <= limit,
            |k| {
                let point = closest_on_triangle(p, self.corners[k]);
                let distance_squared = p.distance_squared(point);
                if distance_squared <= limit && self.slices[k].holds(self.corners[k], point) {
                    visit(Closest { triangle: self.slices[k].id, point, distance_squared });
                }
            },
        );
    }

    /// Calls `visit` for every triangle that the ray meets up to `t_max`, in no particular but always the same order.
    ///
    /// A ray through an edge or a vertex meets at least one of the triangles there. Triangles that it only grazes, lying
    /// in their plane, are not met. Without a direction there is no ray, and nothing is met.
    pub fn along_ray(&self, origin: DVec3, direction: DVec3, t_max: f64, mut visit: impl FnMut(Hit)) {
        if !(direction.abs().max_element() > 0.0) {
            return;
        }
        let ray = Ray::new(origin, direction);
        // Triangles that were met in another slice.
        let mut met = Vec::new();
        self.descend(
            |b| b.meets_ray(origin, direction.recip(), t_max),
            |k| {
                if let Some((t, front)) = ray.meets(self.corners[k])
                    && t <= t_max
                    && (self.slices[k].is_whole() || !met.contains(&self.slices[k].id))
                {
                    if !self.slices[k].is_whole() {
                        met.push(self.slices[k].id);
                    }
                    visit(Hit { triangle: self.slices[k].id, t, front });
                }
            },
        );
    }

    /// The first triangle along a ray; the smallest id of several at the same place.
    pub fn first_hit(&self, origin: DVec3, direction: DVec3) -> Option<Hit> {
        let mut first: Option<Hit> = None;
        self.along_ray(origin, direction, f64::INFINITY, |hit| {
            if first.is_none_or(|known| (hit.t, hit.triangle) < (known.t, known.triangle)) {
                first = Some(hit);
            }
        });
        first
    }

    /// Pairs of triangles whose boxes meet, in jobs that can be done side by side: each calls for every pair, some of them twice.
    pub fn meeting_pairs(&self) -> MeetingPairs<'_> {
        let boxes = self.slices.par_iter().zip(&self.corners);
        let boxes = boxes.map(|(slice, &corners)| slice.outline(corners).into_iter().fold(Box3::EMPTY, Box3::with));
        let mut jobs: Vec<[Node; 2]> = self.root().into_iter().map(|root| [root, root]).collect();
        while !jobs.is_empty() && jobs.len() < JOBS && jobs.iter().any(|[a, b]| a.leaves > 1 || b.leaves > 1) {
            jobs = jobs.into_iter().flat_map(|job| self.divided(job)).collect();
        }
        MeetingPairs { boxes: boxes.collect(), tree: self, jobs }
    }

    /// A pair of nodes as pairs of their children; those that do not meet are left out.
    fn divided(&self, [a, b]: [Node; 2]) -> Vec<[Node; 2]> {
        let pairs = match (a.index == b.index, a.leaves > 1, b.leaves > 1) {
            (true, true, _) => {
                let [x, y] = a.children();
                vec![[x, x], [x, y], [y, y]]
            }
            (false, true, _) if a.leaves >= b.leaves => a.children().map(|x| [x, b]).to_vec(),
            (false, _, true) => b.children().map(|y| [a, y]).to_vec(),
            _ => vec![[a, b]],
        };
        let meet = |[a, b]: &[Node; 2]| {
            a.index == b.index || self.boxes[a.index as usize].meets(&self.boxes[b.index as usize])
        };
        pairs.into_iter().filter(meet).collect()
    }

    /// Ids and corners of all triangles in the order of the leaves: neighbours in it are neighbours in space.
    pub(super) fn in_order(&self) -> impl Iterator<Item = (u32, [DVec3; 3])> {
        let firsts = self.slices.iter().zip(&self.corners).filter(|(slice, _)| slice.number == 0);
        firsts.map(|(slice, corners)| (slice.id, *corners))
    }

    /// Ids of all triangles in the order of the leaves: every k-th of them are spread as all are.
    pub fn ids(&self) -> impl Iterator<Item = u32> {
        self.in_order().map(|(id, _)| id)
    }

    /// Visits the triangles, by position, of all leaves that are entered.
    fn descend(&self, enter: impl Fn(&Box3) -> bool, mut visit: impl FnMut(usize)) {
        let mut stack = Stack::new();
        self.root().into_iter().for_each(|root| stack.push(root, 0.0));
        while let Some((node, _)) = stack.pop() {
            if !enter(&self.boxes[node.index as usize]) {
                continue;
            }
            if node.leaves > 1 {
                let [left, right] = node.children();
                stack.push(right, 0.0);
                stack.push(left, 0.0);
            } else {
                self.leaf(node).for_each(&mut visit);
            }
        }
    }

    fn root(&self) -> Option<Node> {
        (!self.is_empty()).then(|| Node {
            index: 0,
            first_leaf: 0,
            leaves: self.slices.len().div_ceil(TRIANGLES_PER_LEAF) as u32,
        })
    }

    fn leaf(&self, node: Node) -> std::ops::Range<usize> {
        self.held(Node { leaves: 1, ..node })
    }

    /// The triangles of a node, by position.
    fn held(&self, node: Node) -> std::ops::Range<usize> {
        let first = node.first_leaf as usize * TRIANGLES_PER_LEAF;
        first..(first + node.leaves as usize * TRIANGLES_PER_LEAF).min(self.slices.len())
    }

    /// All nodes, in preorder.
    fn nodes(&self) -> Vec<Node> {
        let mut stack: Vec<Node> = self.root().into_iter().collect();
        let mut nodes = Vec::with_capacity(self.boxes.len());
        while let Some(node) = stack.pop() {
            nodes.push(node);
            if node.leaves > 1 {
                stack.extend(node.children().into_iter().rev());
            }
        }
        nodes
    }
}

/// Pairs of triangles that may meet; see [`TriangleTree::meeting_pairs`].
pub struct MeetingPairs<'a> {
    tree: &'a TriangleTree,
    boxes: Vec<Box3>,
    jobs: Vec<[Node; 2]>,
}

/// A triangle: its id and its corners.
pub type Placed<'a> = (u32, &'a [DVec3; 3]);

impl MeetingPairs<'_> {
    /// Number of jobs.
    pub fn jobs(&self) -> usize {
        self.jobs.len()
    }

    /// Offers the pairs of a job, always in the same order; triangles that are cut into slices come more than once.
    pub fn visit(&self, job: usize, mut offer: impl FnMut(Placed<'_>, Placed<'_>)) {
        let mut stack = vec![self.jobs[job]];
        while let Some([a, b]) = stack.pop() {
            if a.leaves > 1 || b.leaves > 1 {
                stack.extend(self.tree.divided([a, b]));
                continue;
            }
            for i in self.tree.leaf(a) {
                let others = if a.index == b.index { i + 1..self.tree.leaf(a).end } else { self.tree.leaf(b) };
                for j in others.filter(|&j| self.boxes[i].meets(&self.boxes[j])) {
                    let [x, y] = [i, j].map(|k| (self.tree.slices[k].id, &self.tree.corners[k]));
                    if x.0 != y.0 {
                        offer(x, y);
                    }
                }
            }
        }
    }
}

/// Sorts the items into leaves and fills the boxes of a subtree; returns its box.
fn build(
    boxes: &mut [Box3],
    items: &mut [(DVec3, u32)],
    leaves: usize,
    outline: &(impl Fn(u32) -> [DVec3; 5] + Sync),
) -> Box3 {
    boxes[0] = if leaves == 1 {
        items.iter().flat_map(|&(_, item)| outline(item)).fold(Box3::EMPTY, Box3::with)
    } else {
        let left = leaves.div_ceil(2);
        let axis = longest_axis(items);
        items.select_nth_unstable_by(left * TRIANGLES_PER_LEAF, |a, b| {
            a.0[axis].total_cmp(&b.0[axis]).then(a.1.cmp(&b.1))
        });
        let serial = items.len() < SERIAL;
        let (left_items, right_items) = items.split_at_mut(left * TRIANGLES_PER_LEAF);
        let (left_boxes, right_boxes) = boxes[1..].split_at_mut(2 * left - 1);
        let mut build_left = || build(left_boxes, left_items, left, outline);
        let mut build_right = || build(right_boxes, right_items, leaves - left, outline);
        let (a, b) = if serial { (build_left(), build_right()) } else { rayon::join(build_left, build_right) };
        a.with(b.low).with(b.high)
    };
    boxes[0]
}

fn longest_axis(items: &[(DVec3, u32)]) -> usize {
    let all = items.iter().fold(Box3::EMPTY, |b, &(centre, _)| b.with(centre));
    (all.high - all.low).max_position()
}

impl Box3 {
    const EMPTY: Box3 = Box3 { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY };

    #[inline]
    fn around([a, b, c]: [DVec3; 3]) -> Box3 {
        Box3 { low: a.min(b).min(c), high: a.max(b).max(c) }
    }

    fn with(self, p: DVec3) -> Box3 {
        Box3 { low: self.low.min(p), high: self.high.max(p) }
    }

    #[inline]
    fn meets(&self, other: &Box3) -> bool {
        self.low.cmple(other.high).all() && other.low.cmple(self.high).all()
    }

    #[inline]
    fn distance_squared(&self, p: DVec3) -> f64 {
        p.distance_squared(p.clamp(self.low, self.high))
    }

    /// The slab test; the order of the arguments of min and max drops the NaN of 0 · ∞.
    #[inline]
    fn meets_ray(&self, origin: DVec3, inverse: DVec3, t_max: f64) -> bool {
        let (mut enter, mut leave) = (0f64, t_max);
        for k in 0..3 {
            let (a, b) = ((self.low[k] - origin[k]) * inverse[k], (self.high[k] - origin[k]) * inverse[k]);
            // A box is widened by a few rounding errors: it must not be missed where its triangle is met.
            let slack = 4.0 * f64::EPSILON * a.abs().max(b.abs());
            enter = (a.min(b) - slack).max(enter);
            leave = (a.max(b) + slack).min(leave);
        }
        enter <= leave
    }
}

/// Nodes still to visit, with a bound each.
struct Stack {
    nodes: [(Node, f64); DEEPEST],
    len: usize,
}

impl Stack {
    fn new() -> Self {
        Stack { nodes: [(Node { index: 0, first_leaf: 0, leaves: 0 }, 0.0); DEEPEST], len: 0 }
    }

    #[inline]
    fn push(&mut self, node: Node, bound: f64) {
        self.nodes[self.len] = (node, bound);
        self.len += 1;
    }

    #[inline]
    fn pop(&mut self) -> Option<(Node, f64)> {
        self.len = self.len.checked_sub(1)?;
        Some(self.nodes[self.len])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::SurfaceMesh;
    use crate::mesh::test_models::*;
    use proptest::prelude::*;

    fn fans(mesh: &SurfaceMesh) -> Vec<[u32; 3]> {
        mesh.faces().fan().0
    }

    fn tree_of(mesh: &SurfaceMesh) -> TriangleTree {
        TriangleTree::new(mesh.points(), &fans(mesh))
    }

    /// The distance triangle by triangle: inside by the normal equations, on the edges by halving, as the distance is convex.
    fn oracle(points: &[DVec3], triangles: &[[u32; 3]], p: DVec3) -> f64 {
        let inside = |a: DVec3, u: DVec3, v: DVec3| {
            let (uu, uv, vv) = (u.dot(u), u.dot(v), v.dot(v));
            let (pu, pv, det) = ((p - a).dot(u), (p - a).dot(v), uu * vv - uv * uv);
            let (s, t) = ((pu * vv - pv * uv) / det, (pv * uu - pu * uv) / det);
            (s >= 0.0 && t >= 0.0 && s + t <= 1.0).then(|| p.distance(a + s * u + t * v))
        };
        let along = |a: DVec3, b: DVec3| {
            let (mut low, mut high) = (0.0, 1.0);
            for _ in 0..100 {
                let middle = 0.5 * (low + high);
                let is_left = (a.lerp(b, middle) - p).dot(b - a) > 0.0;
                (low, high) = if is_left { (low, middle) } else { (middle, high) };
            }
            p.distance(a.lerp(b, 0.5 * (low + high)))
        };
        let distance = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|k| points[k as usize]);
            let edges = [along(a, b), along(b, c), along(c, a)];
            edges.into_iter().chain(inside(a, b - a, c - a)).fold(f64::INFINITY, f64::min)
        };
        triangles.iter().map(distance).fold(f64::INFINITY, f64::min)
    }

    fn point() -> impl Strategy<Value = DVec3> {
        prop::array::uniform3(-1.0f64..1.0).prop_map(DVec3::from_array)
    }

    fn soup() -> impl Strategy<Value = (Vec<DVec3>, Vec<[u32; 3]>)> {
        (prop::collection::vec(point(), 4..40), 1usize..200).prop_flat_map(|(points, n)| {
            let index = 0..points.len() as u32;
            (Just(points), prop::collection::vec(prop::array::uniform3(index), n))
        })
    }

    /// A soup, or a fan of needles, which the tree cuts.
    fn soup_or_fan() -> impl Strategy<Value = (Vec<DVec3>, Vec<[u32; 3]>)> {
        let fan = (50u32..300, point()).prop_map(|(n, apex)| {
            let rim = (0..n).map(|k| {
                let angle = f64::from(k) / f64::from(n);
                DVec3::new(angle.cos(), angle.sin(), 0.5 * angle)
            });
            let points = std::iter::once(apex).chain(rim).collect();
            (points, (1..n).map(|k| [0, k, k % n + 1]).collect())
        });
        prop_oneof![soup(), fan]
    }

    proptest! {
        #[test]
        fn closest_agrees_with_the_oracle((points, triangles) in soup_or_fan(), queries in prop::collection::vec(point(), 20)) {
            let tree = TriangleTree::new(&points, &triangles);
            for p in queries.into_iter().map(|p| p * 2.0) {
                let found = tree.closest(p).unwrap();
                prop_assert!((found.distance() - oracle(&points, &triangles, p)).abs() < 1e-9);
                let own = triangles[found.triangle as usize].map(|k| points[k as usize]);
                prop_assert_eq!(found.point, closest_on_triangle(p, own));
                for hint in &triangles {
                    let near = tree.closest_near(p, hint.map(|k| points[k as usize])).unwrap();
                    prop_assert!((near.distance() - found.distance()).abs() < 1e-9);
                }
                // Of triangles that share the closest point, either may be found, with the rounding of its own plane.
                let within = tree.closest_within(p, found.distance() * (1.0 + 1e-12)).unwrap();
                prop_assert!(within.point.distance(found.point) <= 1e-12 && within.distance() <= found.distance() * (1.0 + 1e-12));
                prop_assert_eq!(tree.closest_within(p, found.distance() * 0.999 - 1e-12), None);
            }
        }

        /// Whatever the normals are said to be.
        #[test]
        fn slabs_change_no_answer(
            (points, triangles) in soup_or_fan(),
            queries in prop::collection::vec(point(), 20),
            normals in prop::collection::vec(point(), 300),
        ) {
            let tree = TriangleTree::new(&points, &triangles);
            let with_slabs = TriangleTree::new(&points, &triangles).with_slabs(&normals);
            for p in queries {
                let (plain, found) = (tree.closest(p).unwrap(), with_slabs.closest(p).unwrap());
                prop_assert!((plain.distance() - found.distance()).abs() < 1e-12);
            }
        }

        #[test]
        fn the_cheapest_is_the_cheapest_of_those_within(
            (points, triangles) in soup_or_fan(),
            p in point(),
            radius in 0.0f64..2.0,
        ) {
            let tree = TriangleTree::new(&points, &triangles);
            let cost = |c: &Closest| (!c.triangle.is_multiple_of(3)).then(|| c.distance() * f64::from(1 + c.triangle % 7));
            let mut expected: Option<(f64, u32)> = None;
            tree.within(p, radius, |c| {
                if let Some(cost) = cost(&c)
                    && expected.is_none_or(|e| (cost, c.triangle) < e)
                {
                    expected = Some((cost, c.triangle));
                }
            });
            prop_assert_eq!(tree.cheapest(p, radius, cost).map(|(cost, c)| (cost, c.triangle)), expected);
        }

        #[test]
        fn within_finds_exactly_the_near_triangles((points, triangles) in soup_or_fan(), p in point(), radius in 0.0f64..0.5) {
            let tree = TriangleTree::new(&points, &triangles);
            let mut found = Vec::new();
            tree.within(p, radius, |c| found.push(c.triangle));
            found.sort_unstable();
            let near = |t: &[u32; 3]| p.distance(closest_on_triangle(p, t.map(|k| points[k as usize]))) <= radius;
            let expected: Vec<u32> = (0u32..).zip(&triangles).filter(|(_, t)| near(t)).map(|(k, _)| k).collect();
            prop_assert_eq!(found, expected);
        }

        #[test]
        fn rays_enter_and_leave_a_closed_surface(origin in point(), toward in point()) {
            // Aimed at a vertex: the worst case for watertightness.
            let mesh = sphere(2);
            let tree = tree_of(&mesh);
            let vertex = mesh.points()[(toward.x.abs() * 160.0) as usize];
            let inside = origin * 0.9 / 1.8;
            let first = tree.first_hit(inside, vertex - inside).unwrap();
            prop_assert!((first.t - 1.0).abs() < 1e-9 && !first.front);
            let outside = origin.normalize_or(DVec3::X) * 3.0;
            prop_assert!(tree.first_hit(outside, toward * 0.4 - outside).unwrap().front);
            prop_assert!(tree.first_hit(outside, outside).is_none());
            // Without a direction there is nothing along it, wherever it begins.
            prop_assert!([inside, outside].into_iter().all(|p| tree.first_hit(p, DVec3::ZERO).is_none()));
        }

        #[test]
        fn rays_hit_what_lies_on_them((points, triangles) in soup_or_fan(), origin in point(), weights in prop::array::uniform3(0.05f64..1.0)) {
            let tree = TriangleTree::new(&points, &triangles);
            let [a, b, c] = triangles[0].map(|k| points[k as usize]);
            let w = weights.iter().sum::<f64>();
            let target = (a * weights[0] + b * weights[1] + c * weights[2]) / w;
            let mut hit = None;
            let mut times = vec![0; triangles.len()];
            tree.along_ray(origin, target - origin, 2.0, |h| {
                hit = hit.or((h.triangle == 0).then_some(h.t));
                times[h.triangle as usize] += 1;
            });
            prop_assert!(times.iter().all(|&n| n <= 1));
            let volume = (a - origin).dot((b - origin).cross(c - origin)).abs();
            prop_assert!(volume < 1e-6 || (hit.unwrap() - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn the_tree_does_not_depend_on_the_number_of_threads() {
        let mesh = torus(150, 60);
        let build = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| tree_of(&mesh)).slices
        };
        assert_eq!(build(1), build(3));
    }

    #[test]
    fn an_empty_tree_has_no_answers() {
        let tree = TriangleTree::new(&[], &[]);
        assert!(
            tree.is_empty() && tree.closest(DVec3::ZERO).is_none() && tree.first_hit(DVec3::ZERO, DVec3::X).is_none()
        );
    }
}
