//! Merges webs: a skeleton has a branch to each corner of an ear or a fin, but the room between these branches is
//! filled, and tubes beside each other would leave slits in it. Only the longest branch is kept: its tube becomes as
//! flat as the part ([`super::flat_sections`]).
//!
//! ```text
//!    ╭──────────╮         ╭──────────╮
//!    │   ╱      │         │          │
//!  ──│──v───────│─   →  ──│──v───────│─
//!    │   ╲      │         │          │
//!    ╰──────────╯         ╰──────────╯
//! ```

use super::resample::Curve;
use super::target::Target;
use crate::mesh::{CurveNet, branches};
use glam::DVec3;

/// Places on two branches, as shares of their lengths, between which the room is looked at.
const STATIONS: [f64; 4] = [0.25, 0.5, 0.75, 1.0];
/// Places between these, as shares of the way across, that must be inside of the surface.
const BETWEEN: [f64; 5] = [0.1, 0.3, 0.5, 0.7, 0.9];
/// Branches whose ends are seen at a wider angle lead to two sides of a part.
const WIDE_DEGREES: f64 = 120.0;
/// A branch with its end so near to a lid, in radii, leads to an open end: it stays.
const AT_LID: f64 = 2.0;

/// Of any two leaf branches of a node with filled room between them the longer one stays; returns how many went.
pub fn merge_webs(net: &mut CurveNet, target: &Target) -> usize {
    let mut merged = 0;
    while let Some(branch) = shorter_of_web(net, target) {
        let mut keep = vec![true; net.points.len()];
        branch[1..].iter().for_each(|&v| keep[v as usize] = false);
        net.retain_nodes(&keep);
        merged += 1;
    }
    merged
}

/// The nodes, from its branching on, of a branch that goes.
fn shorter_of_web(net: &CurveNet, target: &Target) -> Option<Vec<u32>> {
    let around = net.incidence();
    let mut leaves: Vec<(f64, Leaf)> = Vec::new();
    for branch in branches(net, &around).into_iter().filter(|b| b.is_leaf(&around)) {
        let mut curve = Curve::new(net, &branch.nodes);
        let length = curve.length();
        let places = STATIONS.map(|share| curve.at(share * length));
        let [start, end] = [places[0], places[STATIONS.len() - 1]];
        // What grows thicker towards its end is a knob, no corner: room beside it is filled because it is round.
        if end.1 <= start.1 {
            let worth = if is_at_lid(end.0, target) { f64::INFINITY } else { length };
            leaves.push((worth, Leaf { nodes: branch.nodes, places: places.map(|p| p.0) }));
        }
    }
    // The shortest go first; of the same length, the one that comes later.
    leaves.sort_by(|a, b| b.0.total_cmp(&a.0));
    let is_webbed = |k: usize| leaves[..k].iter().any(|(_, longer)| is_web(net, [longer, &leaves[k].1], target));
    let goes = (1..leaves.len()).rev().find(|&k| leaves[k].0.is_finite() && is_webbed(k))?;
    Some(leaves.swap_remove(goes).1.nodes)
}

/// A branch from a branching to an extremity.
struct Leaf {
    nodes: Vec<u32>,
    /// Points of it, up to its end.
    places: [DVec3; STATIONS.len()],
}

fn is_at_lid(end: DVec3, target: &Target) -> bool {
    let room = target.distance(end);
    target.lids().iter().any(|lid| lid.centre.distance(end) < AT_LID * lid.radius.max(room))
}

/// Whether two leaf branches have the same node, lead to one side, and the room between them is filled.
fn is_web(net: &CurveNet, [a, b]: [&Leaf; 2], target: &Target) -> bool {
    let from = net.points[a.nodes[0] as usize];
    let [to_a, to_b] = [a, b].map(|leaf| leaf.places[STATIONS.len() - 1] - from);
    a.nodes[0] == b.nodes[0]
        && to_a.angle_between(to_b) < WIDE_DEGREES.to_radians()
        && a.places.iter().zip(&b.places).all(|(p, q)| BETWEEN.iter().all(|&t| target.contains(p.lerp(*q, t))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::context::Context;
    use crate::mesh::test_models::{moved, sphere};
    use crate::skeleton;

    /// A stem and three prongs that end at these places.
    fn fork(ends: [[f64; 2]; 3]) -> CurveNet {
        let flat = |[x, y]: [f64; 2]| DVec3::new(x, y, 0.0);
        let points = [[0.0, 0.0], [-0.7, 0.0]].into_iter().chain(ends).map(flat).collect();
        CurveNet::new(points, vec![0.1; 5], vec![[0, 1], [0, 2], [0, 3], [0, 4]])
    }

    /// A disc is filled between the prongs; one that goes back along the stem is another side of it.
    #[test]
    fn of_the_prongs_in_a_disc_the_longest_stays() {
        let disc = moved(&sphere(4), |p| DVec3::new(p.x, p.y, 0.1 * p.z));
        let (closed, _) = skeleton::prepared(&disc, &Context::new()).unwrap();
        let target = Target::new(&closed);
        let mut net = fork([[0.4, 0.4], [0.8, 0.0], [0.4, -0.5]]);
        let longest = net.points[3];
        let mut knob = net.clone();
        knob.radii[2] = 0.2;
        assert_eq!(merge_webs(&mut knob, &target), 1);
        assert!(knob.points.contains(&net.points[2]) && knob.points.contains(&longest));
        assert_eq!(merge_webs(&mut net, &target), 2);
        assert_eq!((net.points.len(), net.edges.len()), (3, 2));
        assert!(net.points.contains(&longest) && net.points.contains(&(-0.7 * DVec3::X)));
        // What is out of the surface says that there are fingers.
        let mut fingers = fork([[0.8, 0.8], [0.8, 0.0], [0.8, -0.8]]);
        assert_eq!(merge_webs(&mut fingers, &target), 0);
        assert_eq!(fingers, fork([[0.8, 0.8], [0.8, 0.0], [0.8, -0.8]]));
    }
}
