//! Gives limbs that the flow has lost a branch: short ones may be drawn into their branching before they are thin.
//!
//! A vertex of the surface that is far from the skeleton, in radii of the skeleton there, belongs to a limb without a
//! branch. The way along the surface from the farthest such vertex to where the skeleton is near again leads along the
//! limb, and the inner balls of the vertices on it have their centres in its middle:
//!
//! ```text
//!        v ·  ╮
//!          ┆  │          the way from v down the limb; the new branch goes through the centres of
//!    ──────╯  ╰─────     the balls that touch it
//!    ═══════╧════════    skeleton
//! ```
//!
//! The rim of a flat end is far from a branch that stops before it, but no limb: the branch will be led to the end.

use super::body::Body;
use super::ends::{Known, reach_ends};
use super::sections::{ROOM, room, section};
use crate::geometry::search_tree::TriangleTree;
use crate::mesh::{CurveNet, NONE, SurfaceMesh};
use glam::DVec3;
use rayon::prelude::*;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Distance from the skeleton, in radii, from which on a vertex may be in a limb that the flow has lost.
const LOST: f64 = 2.0;
/// Distance, in radii, below which it is not.
const NEAR: f64 = 1.2;
/// Largest width of sections across the way of a limb, over that of the largest ball where it stands: where a body
/// only bulges, sections cut the body.
const WIDE: f64 = 1.2;
/// The same over the sections nearer to its tip.
const WIDENS: f64 = 1.6;
/// Least length of a limb, in radii of circles as large as its sections.
const LEAST_LENGTH: f64 = 1.1;
/// Least radius of a limb's balls, as a share of that of the ball that it stands on.
const THIN: f64 = 0.1;
/// The section at the tip of a short limb is that of its ball, within this factor.
const ROUND_TIP: f64 = 1.3;

/// Distance, in radii, within which a limb's first point must have a node of the skeleton to start from.
const REACH: f64 = 3.0;

/// Most limbs that are looked for.
const LIMBS: usize = 64;
/// Rounds of smoothing of a new branch.
const SMOOTHING: usize = 10;

/// Gives lost limbs a branch; returns how many. `preimage` is the node of every vertex; nodes need radii.
pub fn grow_limbs(net: &mut CurveNet, preimage: &mut [u32], body: &Body, known: &Known) -> usize {
    let &Body { surface, poles, .. } = body;
    let neighbours = Neighbours::of(surface);
    let mut led = net.clone();
    reach_ends(&mut led, body, known);
    let mut given_up: Vec<bool> = distances(&led, surface.points()).into_iter().map(|far| far.0 < LOST).collect();
    let mut grown = 0;
    let mut far = distances(net, surface.points());
    for _ in 0..LIMBS {
        let farthest = (0..far.len()).filter(|&v| !given_up[v]).max_by(|&a, &b| far[a].0.total_cmp(&far[b].0));
        let Some(tip) = farthest.filter(|&v| far[v].0 > LOST) else { break };
        let way = neighbours.way(surface.points(), tip as u32, |v| far[v as usize].0 < NEAR);
        let branch = way.as_deref().and_then(|w| branch(net, w, far[*w.last()? as usize].1, body));
        let Some((root, points)) = branch else {
            // The whole limb would be tried in vain, vertex by vertex.
            let reach = surface.points()[tip].distance(poles[tip]);
            let close = |v: usize| surface.points()[v].distance(surface.points()[tip]) < reach;
            (0..far.len()).filter(|&v| close(v)).for_each(|v| given_up[v] = true);
            given_up[tip] = true;
            continue;
        };
        let first = net.points.len() as u32;
        let mut last = root;
        for p in points {
            net.edges.push([last, net.points.len() as u32]);
            last = net.points.len() as u32;
            net.ids.push(net.points.len() as i64);
            net.radii.push(body.tree.distance(p));
            net.points.push(p);
        }
        given_up[tip] = true;
        grown += 1;
        let nearest = |p: DVec3| {
            (first..=last).min_by(|&a, &b| {
                let off = |k: u32| net.points[k as usize].distance_squared(p);
                off(a).total_cmp(&off(b))
            })
        };
        for v in (0..far.len()).filter(|&v| far[v].0 >= NEAR) {
            let p = surface.points()[v];
            let known = net.points[preimage[v] as usize].distance_squared(p);
            if let Some(k) = nearest(p).filter(|&k| net.points[k as usize].distance_squared(p) < known) {
                preimage[v] = k;
            }
        }
        far = distances(net, surface.points());
    }
    grown
}

/// Distance of every point from the net, over the radius of the net there, and that radius.
pub fn distances(net: &CurveNet, points: &[DVec3]) -> Vec<(f64, f64)> {
    let segments = TriangleTree::of_segments(&net.points, net.edges.iter().copied());
    let of = |p: &DVec3| {
        let Some(near) = segments.closest(*p) else { return (0.0, 0.0) };
        let [a, b] = net.edges[near.triangle as usize].map(|v| net.radii[v as usize]);
        let radius = a.max(b).max(1e-300);
        (near.distance() / radius, radius)
    };
    points.par_iter().map(of).collect()
}

/// The largest distance of the surface from a net, in radii of the net.
pub fn farthest(net: &CurveNet, body: &Body) -> f64 {
    distances(net, body.surface.points()).into_iter().map(|f| f.0).fold(0.0, f64::max)
}

/// The node a limb starts from and the points of its branch from there to the tip, all inside; `way` goes down the limb
/// along the surface, to where the skeleton has a ball of the radius `ball`.
fn branch(net: &CurveNet, way: &[u32], ball: f64, body: &Body) -> Option<(u32, Vec<DVec3>)> {
    let mut points: Vec<DVec3> = way.iter().rev().map(|&v| body.poles[v as usize]).collect();
    for _ in 0..SMOOTHING {
        let old = points.clone();
        for k in 1..old.len().saturating_sub(1) {
            points[k] = 0.5 * old[k] + 0.25 * (old[k - 1] + old[k + 1]);
        }
    }
    // Nodes about half a radius apart.
    let tip = *points.last()?;
    let mut thinned = vec![points[0]];
    for &p in &points[1..] {
        let last = thinned[thinned.len() - 1];
        if p.distance(last) > 0.5 * body.tree.distance(p) {
            thinned.push(p);
        }
    }
    if thinned.len() < 2 {
        return None;
    }
    let end = thinned.len() - 1;
    thinned[end] = tip;
    let limb = limb(net, &thinned, largest_ball(net, way, ball, body), body)?;
    let (root, from) = root(net, limb, body)?;
    let is_sound = |w: &[DVec3]| w[0] != w[1] && room(w[0], w[1], body) > 0.0;
    limb[from..].windows(2).all(is_sound).then(|| (root, limb[from..].to_vec()))
}

/// The largest radius of the nodes that are as near to the foot of a way as the way is long, at least that at its foot: the
/// skeleton may go some way into a limb already.
fn largest_ball(net: &CurveNet, way: &[u32], at_foot: f64, body: &Body) -> f64 {
    let at = |k: usize| body.surface.points()[way[k] as usize];
    let length: f64 = (1..way.len()).map(|k| at(k - 1).distance(at(k))).sum();
    let foot = at(way.len() - 1);
    let near = (0..net.points.len()).filter(|&v| net.points[v].distance(foot) < length);
    near.map(|v| net.radii[v]).fold(at_foot, f64::max)
}

/// The part of a way, up to its end, on which it is in a limb: sections across it are not much wider than the ball of the
/// body and do not widen all at once, the part is longer than thick, and not too thin for cells.
fn limb<'a>(net: &CurveNet, way: &'a [DVec3], ball: f64, body: &Body) -> Option<&'a [DVec3]> {
    let end = way.len() - 1;
    let (mut length, mut widths, mut first) = (0.0, Vec::new(), end);
    let mut widest = f64::INFINITY;
    for k in (0..end).rev() {
        let across = section(way[k], way[k + 1] - way[k.saturating_sub(1)], body);
        if !(across < WIDE * ball && across < WIDENS * widest) {
            break;
        }
        widest = if widths.is_empty() { across } else { widest.max(across) };
        length += way[k].distance(way[k + 1]);
        widths.push(across);
        first = k;
    }
    let mut thickness: Vec<f64> = way[first..].iter().map(|&p| body.tree.distance(p)).collect();
    let at_tip = thickness[thickness.len() - 1];
    thickness.sort_unstable_by(f64::total_cmp);
    let is_thick = thickness[thickness.len() / 2] > THIN * ball;
    widths.sort_unstable_by(f64::total_cmp);
    let is_long = widths.get(widths.len() / 2).is_some_and(|width| length + at_tip > LEAST_LENGTH * width);
    (is_thick && (is_long || is_stub(net, way, at_tip, body))).then(|| &way[first..])
}

/// Whether a way ends in a short limb, of which nearly all sections cut what it stands on: its last ball sticks out of those of
/// the net by a radius and more, and the section there is round.
fn is_stub(net: &CurveNet, way: &[DVec3], radius: f64, body: &Body) -> bool {
    let tip = way[way.len() - 1];
    let off = (0..net.points.len()).map(|v| net.points[v].distance(tip) - net.radii[v]).fold(f64::INFINITY, f64::min);
    off > radius && section(tip, tip - way[way.len() - 2], body) < ROUND_TIP * radius
}

/// The node from which a limb is best reached, and the point of the limb that it is joined to: the nearest, straight on
/// rather than around a corner.
fn root(net: &CurveNet, limb: &[DVec3], body: &Body) -> Option<(u32, usize)> {
    for from in 0..limb.len().div_ceil(2) {
        let (q, next) = (limb[from], limb[(from + 1).min(limb.len() - 1)]);
        let own = body.tree.distance(q);
        let cost = |v: usize| {
            let to = q - net.points[v];
            let turn = to.normalize_or_zero().dot((next - q).normalize_or_zero());
            to.length() * (1.5 - 0.5 * turn)
        };
        let near = |v: &usize| net.points[*v].distance(q) < REACH * net.radii[*v].max(own);
        let mut nodes: Vec<(f64, usize)> = (0..net.points.len()).filter(near).map(|v| (cost(v), v)).collect();
        nodes.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let is_free = |v: usize| room(net.points[v], q, body) > ROOM * net.radii[v].min(own);
        if let Some(&(_, v)) = nodes.iter().find(|n| net.points[n.1] != q && is_free(n.1)) {
            return Some((v as u32, from));
        }
    }
    None
}

/// Whether a branch leaves the body between its nodes.
pub fn leaves(net: &CurveNet, branch: &[u32], body: &Body) -> bool {
    let is_outside = |w: &[u32]| room(net.points[w[0] as usize], net.points[w[1] as usize], body) <= 0.0;
    branch.windows(2).any(is_outside)
}

/// The vertices next to each.
struct Neighbours {
    offsets: Vec<u32>,
    list: Vec<u32>,
}

impl Neighbours {
    fn of(surface: &SurfaceMesh) -> Self {
        let triangles = surface.faces().fan().0;
        let mut offsets = vec![0u32; surface.points().len() + 1];
        triangles.as_flattened().iter().for_each(|&v| offsets[v as usize + 1] += 2);
        (1..offsets.len()).for_each(|v| offsets[v] += offsets[v - 1]);
        let mut next = offsets.clone();
        let mut list = vec![NONE; 6 * triangles.len()];
        for t in &triangles {
            for k in 0..3 {
                for other in [t[(k + 1) % 3], t[(k + 2) % 3]] {
                    list[next[t[k] as usize] as usize] = other;
                    next[t[k] as usize] += 1;
                }
            }
        }
        Neighbours { offsets, list }
    }

    fn at(&self, v: u32) -> &[u32] {
        &self.list[self.offsets[v as usize] as usize..self.offsets[v as usize + 1] as usize]
    }

    /// The shortest way along edges from a vertex to the first that is there (Dijkstra).
    fn way(&self, points: &[DVec3], from: u32, is_there: impl Fn(u32) -> bool) -> Option<Vec<u32>> {
        let mut length = vec![f64::INFINITY; points.len()];
        let mut before = vec![NONE; points.len()];
        let mut heap = BinaryHeap::from([Reverse((0u64, from))]);
        length[from as usize] = 0.0;
        while let Some(Reverse((bits, v))) = heap.pop() {
            // Lengths compare as their bits do: they are not negative.
            if f64::from_bits(bits) > length[v as usize] {
                continue;
            }
            if is_there(v) {
                let mut way = vec![v];
                while before[way[way.len() - 1] as usize] != NONE {
                    way.push(before[way[way.len() - 1] as usize]);
                }
                way.reverse();
                return Some(way);
            }
            for &w in self.at(v) {
                let there = length[v as usize] + points[v as usize].distance(points[w as usize]);
                if there < length[w as usize] {
                    (length[w as usize], before[w as usize]) = (there, v);
                    heap.push(Reverse((there.to_bits(), w)));
                }
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::super::poles::poles;
    use super::*;
    use crate::context::Context;
    use crate::geometry::normals::face_normals;
    use crate::geometry::winding::WindingTree;
    use crate::sample::{Tube, tubes};

    /// A trunk along x with its axis as a net, and a surface that may have a limb along y.
    fn grown(limb: f64, radius: f64) -> (CurveNet, Vec<u32>, SurfaceMesh, usize) {
        let context = Context::new();
        let mut parts = vec![Tube { ends: [DVec3::ZERO, DVec3::X * 6.0], radii: [0.5; 2] }];
        if limb > 0.0 {
            parts.push(Tube { ends: [DVec3::X * 3.0, DVec3::new(3.0, limb, 0.0)], radii: [radius; 2] });
        }
        let surface =
            tubes(&parts, 0.1, if radius < 0.3 { 0.08 } else { 0.12 }, &context).unwrap().mesh.triangulated().unwrap();
        let tree = TriangleTree::new(surface.points(), &surface.faces().fan().0);
        let centres = poles(&surface, &context).unwrap();
        let points: Vec<DVec3> = (0..=12).map(|k| DVec3::X * (0.5 * f64::from(k))).collect();
        let mut net = CurveNet::new(points, vec![0.5; 13], (1..13).map(|k| [k - 1, k]).collect());
        let nearest = |p: &DVec3| {
            (0..13).min_by(|&a, &b| {
                let off = |k: u32| net.points[k as usize].distance_squared(*p);
                off(a).total_cmp(&off(b))
            })
        };
        let mut preimage: Vec<u32> = surface.points().iter().map(|p| nearest(p).unwrap()).collect();
        let inside = WindingTree::new(&tree);
        let normals = face_normals(&surface);
        let body = Body { surface: &surface, poles: &centres, tree: &tree, normals: &normals, inside: &inside };
        let count = grow_limbs(&mut net, &mut preimage, &body, &Known { lids: &[], alone: false });
        assert!(net.points.iter().all(|&p| inside.contains(p)));
        assert!(preimage.iter().all(|&v| (v as usize) < net.points.len()));
        (net, preimage, surface, count)
    }

    #[test]
    fn lost_limbs_get_a_branch_and_their_vertices() {
        // As thick as the trunk, and far thinner.
        for radius in [0.4, 0.13] {
            let (net, preimage, surface, count) = grown(2.5, radius);
            assert_eq!(count, 1);
            let around = net.incidence();
            let tips: Vec<u32> = around.tips().collect();
            assert_eq!((tips.len(), net.cycles()), (3, vec![0]));
            let tip = net.points[tips[2] as usize];
            assert!(tip.distance(DVec3::new(3.0, 2.5, 0.0)) < 0.3, "{tip}");
            for (p, &node) in surface.points().iter().zip(&preimage) {
                if p.y > 1.2 {
                    assert!(node >= 13 && net.points[node as usize].distance(*p) < 1.0, "{p}");
                }
            }
        }
    }

    /// A knob that is wider than long is no limb, a stub that sticks out by more than its radius is one.
    #[test]
    fn a_stub_gets_a_branch_and_a_knob_gets_none() {
        assert_eq!((grown(0.5, 0.4).3, grown(1.1, 0.4).3), (0, 1));
    }

    /// A line that leaves one finger for another is outside between them.
    #[test]
    fn a_branch_between_two_fingers_is_outside() {
        let context = Context::new();
        let finger = |y: f64| Tube { ends: [DVec3::ZERO, DVec3::new(3.0, y, 0.0)], radii: [0.2; 2] };
        let surface = tubes(&[finger(1.0), finger(-1.0)], 0.05, 0.1, &context).unwrap().mesh.triangulated().unwrap();
        let tree = TriangleTree::new(surface.points(), &surface.faces().fan().0);
        let centres = poles(&surface, &context).unwrap();
        let inside = WindingTree::new(&tree);
        let normals = face_normals(&surface);
        let body = Body { surface: &surface, poles: &centres, tree: &tree, normals: &normals, inside: &inside };
        let points = [[0.0, 0.0], [3.0, 1.0], [2.5, -0.83]].map(|[x, y]| DVec3::new(x, y, 0.0)).to_vec();
        let net = CurveNet::new(points, vec![0.2; 3], vec![[0, 1], [1, 2]]);
        assert!(!leaves(&net, &[0, 1], &body) && leaves(&net, &[0, 1, 2], &body));
    }

    #[test]
    fn what_has_a_branch_gets_no_other() {
        let (net, _, _, count) = grown(0.0, 0.4);
        assert_eq!((count, net.points.len()), (0, 13));
    }
}
