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

mod answers;
mod box3;
mod build;
mod stack;
#[cfg(test)]
mod tests;

use super::closest::closest_on_triangle;
use super::ray::Ray;
use super::slabs::Slab;
use super::slices::{Slice, slices};
use box3::Box3;
use build::{TRIANGLES_PER_LEAF, build};
use glam::DVec3;
use rayon::prelude::*;
use stack::{Node, Stack};

pub use answers::{Closest, Hit};

/// Jobs that pairs of triangles are divided into.
const JOBS: usize = 2048;

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
