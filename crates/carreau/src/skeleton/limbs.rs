//! Limbs that the flow has lost: short ones may be drawn into their branching before they are thin.
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

use super::tidy::Body;
use crate::geometry::search_tree::TriangleTree;
use crate::mesh::{CurveNet, NONE, SurfaceMesh};
use glam::DVec3;
use rayon::prelude::*;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// A vertex farther from the skeleton than this many radii is in a limb, one nearer than that many is not.
const LOST: f64 = 3.0;
const NEAR: f64 = 1.5;
/// Least radius of a limb, as a share of that of the ball it stands on, and least length outside of it, in its radii.
const THIN: f64 = 0.6;
const LONG: f64 = 1.0;
/// Limbs that are looked for.
const LIMBS: usize = 64;
/// Rounds of smoothing of a new branch, and points at which each of its segments must be inside.
const SMOOTHING: usize = 10;
const SAMPLES: usize = 8;

/// Gives lost limbs a branch; returns how many. `preimage` is the node of every vertex; nodes need radii.
pub fn grow_limbs(net: &mut CurveNet, preimage: &mut [u32], body: &Body) -> usize {
    let &Body { surface, poles, .. } = body;
    let neighbours = Neighbours::of(surface);
    let mut given_up = vec![false; poles.len()];
    let mut grown = 0;
    for _ in 0..LIMBS {
        let far = distances(net, surface.points());
        let farthest = (0..far.len()).filter(|&v| !given_up[v]).max_by(|&a, &b| far[a].total_cmp(&far[b]));
        let Some(tip) = farthest.filter(|&v| far[v] > LOST) else { break };
        let way = neighbours.way(surface.points(), tip as u32, |v| far[v as usize] < NEAR);
        let branch = way.as_deref().and_then(|w| branch(net, preimage, w, body));
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
        for v in (0..far.len()).filter(|&v| far[v] >= NEAR) {
            let p = surface.points()[v];
            let known = net.points[preimage[v] as usize].distance_squared(p);
            if let Some(k) = nearest(p).filter(|&k| net.points[k as usize].distance_squared(p) < known) {
                preimage[v] = k;
            }
        }
    }
    grown
}

/// Distance of every point from the net, over the radius of the net there.
fn distances(net: &CurveNet, points: &[DVec3]) -> Vec<f64> {
    let segments = TriangleTree::of_segments(&net.points, net.edges.iter().copied());
    let of = |p: &DVec3| {
        let Some(near) = segments.closest(*p) else { return 0.0 };
        let radius = net.edges[near.triangle as usize].map(|v| net.radii[v as usize]);
        near.distance() / radius[0].max(radius[1]).max(1e-300)
    };
    points.par_iter().map(of).collect()
}

/// The node a limb starts from and the points of its branch from there to the tip, all inside; `way` goes down the limb.
fn branch(
    net: &CurveNet,
    preimage: &[u32],
    way: &[u32],
    &Body { poles, tree, inside, .. }: &Body,
) -> Option<(u32, Vec<DVec3>)> {
    let root = preimage[*way.last()? as usize];
    let mut points: Vec<DVec3> = vec![net.points[root as usize]];
    points.extend(way.iter().rev().map(|&v| poles[v as usize]));
    for _ in 0..SMOOTHING {
        let old = points.clone();
        for k in 1..old.len() - 1 {
            points[k] = 0.5 * old[k] + 0.25 * (old[k - 1] + old[k + 1]);
        }
    }
    // Nodes about half a radius apart.
    let tip = *points.last()?;
    let mut thinned = vec![points[0]];
    for &p in &points[1..] {
        let last = thinned[thinned.len() - 1];
        if p.distance(last) > 0.5 * tree.closest(p)?.distance() {
            thinned.push(p);
        }
    }
    if thinned.len() < 2 {
        return None;
    }
    let end = thinned.len() - 1;
    thinned[end] = tip;
    // What sticks out of the ball at the root is longer than thick, and not much thinner than what it stands on: cells of
    // an ear on a head would be all stretched.
    let (centre, ball) = (thinned[0], net.radii[root as usize]);
    let out = thinned.iter().filter(|p| p.distance(centre) > ball);
    let mut thickness: Vec<f64> = out.filter_map(|p| Some(tree.closest(*p)?.distance())).collect();
    thickness.sort_unstable_by(f64::total_cmp);
    let radius = *thickness.get(thickness.len() / 2)?;
    if radius < THIN * ball || tip.distance(centre) - ball < LONG * radius {
        return None;
    }
    let is_inside = |w: &[DVec3]| (0..=SAMPLES).all(|k| inside.contains(w[0].lerp(w[1], k as f64 / SAMPLES as f64)));
    let sound = thinned.windows(2).all(|w| w[0] != w[1] && is_inside(w));
    thinned.remove(0);
    sound.then_some((root, thinned))
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
    use crate::geometry::winding::WindingTree;
    use crate::sample::{Tube, tubes};

    /// A trunk along x with its axis as a net, and a surface that may have a limb along y.
    fn grown(limb: f64) -> (CurveNet, Vec<u32>, SurfaceMesh, usize) {
        let context = Context::new();
        let mut parts = vec![Tube { ends: [DVec3::ZERO, DVec3::X * 6.0], radii: [0.5; 2] }];
        if limb > 0.0 {
            parts.push(Tube { ends: [DVec3::X * 3.0, DVec3::new(3.0, limb, 0.0)], radii: [0.4; 2] });
        }
        let surface = tubes(&parts, 0.1, 0.12, &context).unwrap().mesh.triangulated().unwrap();
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
        let body = Body { surface: &surface, poles: &centres, tree: &tree, inside: &inside };
        let count = grow_limbs(&mut net, &mut preimage, &body);
        assert!(net.points.iter().all(|&p| inside.contains(p)));
        assert!(preimage.iter().all(|&v| (v as usize) < net.points.len()));
        (net, preimage, surface, count)
    }

    #[test]
    fn a_lost_limb_gets_a_branch_and_its_vertices() {
        let (net, preimage, surface, count) = grown(2.5);
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

    #[test]
    fn what_has_a_branch_gets_no_other() {
        let (net, _, _, count) = grown(0.0);
        assert_eq!((count, net.points.len()), (0, 13));
    }
}
