//! Makes one branching of several whose branches all aim at one point: the hub of a star.
//!
//! Tubes that leave a point side by side part far from it, and the curves of a skeleton run together on the way: by pairs and
//! threes, each in a branching of its own. Which pairs is chance, and cells along such detours fold or overlap.
//!
//! ```text
//!    ╲     ╱            ╲     ╱
//!     ╲___╱              ╲   ╱
//!    __│ │__       →     _╲ ╱_       the lines of the branches, where these are apart, meet in one point
//!      ╱ ╲                ╱ ╲
//!     ╱   ╲              ╱   ╲
//! ```

use super::junction_centres::{FROM, leaving, line, nearest_to};
use super::target::Target;
use crate::mesh::{CurveNet, DisjointSets, branches};
use glam::DVec3;

/// Longest branch between two branchings of one hub, in radii: tubes 30° apart touch each other up to four from their point.
const LONGEST_BETWEEN: f64 = 6.0;
/// The lines of the branches pass the hub within this share of its radius.
const LINE_PASSES: f64 = 0.5;
/// Least number of branches that a hub has.
const LEAST_BRANCHES: usize = 4;
/// The straight ways to a hub keep this share of the least room of its branchings.
const HUB_ROOM: f64 = 0.6;
/// Places at which they are looked at.
const WAY_PLACES: usize = 8;

/// Several branchings that may be one.
struct Hub {
    /// Where the lines of its branches meet.
    at: DVec3,
    /// Its branchings.
    forks: Vec<u32>,
    /// The nodes between them.
    between: Vec<u32>,
    /// The branches that leave it, each from its branching on, and how many nodes of it lie on the straight way.
    ways: Vec<(Vec<u32>, usize)>,
}

/// Joins the branchings of hubs; returns how many hubs were made. Nodes need radii.
pub fn gather(net: &mut CurveNet, target: &Target) -> usize {
    let mut count = 0;
    for cluster in clusters(net) {
        if let Some(hub) = hub(net, &cluster, target) {
            join(net, &hub);
            count += 1;
        }
    }
    let used = net.incidence();
    let keep: Vec<bool> = (0..net.points.len() as u32).map(|v| used.valence(v) > 0).collect();
    net.retain_nodes(&keep);
    count
}

/// Branchings that hang together by short branches, two or more.
fn clusters(net: &CurveNet) -> Vec<Vec<u32>> {
    let around = net.incidence();
    let mut sets = DisjointSets::new(net.points.len());
    for branch in branches(net, &around) {
        let [a, b] = branch.ends();
        let length: f64 = branch.edges.iter().map(|&e| net.length(e as usize)).sum();
        let radius = net.radii[a as usize].max(net.radii[b as usize]);
        if around.valence(a) > 2 && around.valence(b) > 2 && length < LONGEST_BETWEEN * radius {
            sets.union(a, b);
        }
    }
    let (set_of, count) = sets.labels();
    let mut found = vec![Vec::new(); count];
    let forks = (0..net.points.len() as u32).filter(|&v| around.valence(v) > 2);
    forks.for_each(|v| found[set_of[v as usize] as usize].push(v));
    found.retain(|forks| forks.len() > 1);
    found
}

/// The hub that a cluster is, if all of its branches aim at one point and there is room for straight ways from it.
fn hub(net: &CurveNet, forks: &[u32], target: &Target) -> Option<Hub> {
    let around = net.incidence();
    let all = branches(net, &around);
    let is_fork = |v: u32| forks.contains(&v);
    let middle = forks.iter().map(|&v| net.points[v as usize]).sum::<DVec3>() / forks.len() as f64;
    let room = forks.iter().map(|&v| net.radii[v as usize]).fold(0.0, f64::max);
    let least = forks.iter().map(|&v| net.radii[v as usize]).fold(f64::INFINITY, f64::min);
    let (mut between, mut lines, mut ways) = (Vec::new(), Vec::new(), Vec::new());
    for branch in &all {
        let [a, b] = branch.ends();
        if is_fork(a) && is_fork(b) {
            between.extend(&branch.nodes[1..branch.nodes.len() - 1]);
            continue;
        }
        for way in forks.iter().flat_map(|&v| leaving(branch, v)) {
            lines.extend(line(net, &way, middle, room));
            ways.push(way);
        }
    }
    // As many segments as make a tree: a cycle within a hub would be lost.
    let inner = all.iter().filter(|b| b.ends().into_iter().all(is_fork)).count();
    if inner + 1 != forks.len() || lines.len() < LEAST_BRANCHES {
        return None;
    }
    let at = nearest_to(&lines, middle)?;
    let passes = |&(p, d): &(DVec3, DVec3)| (at - p).reject_from_normalized(d).length() < LINE_PASSES * room;
    let ways: Vec<(Vec<u32>, usize)> = ways.into_iter().map(|way| straight(net, way, at, FROM * room)).collect();
    let is_free = |(way, count): &(Vec<u32>, usize)| {
        let end = net.points[way[*count] as usize];
        let own = HUB_ROOM * least.min(net.radii[way[*count] as usize]);
        (0..WAY_PLACES).all(|k| {
            let p = at.lerp(end, k as f64 / WAY_PLACES as f64);
            target.contains(p) && target.distance(p) > own
        })
    };
    let fits = lines.iter().all(passes) && ways.iter().all(is_free);
    fits.then(|| Hub { at, forks: forks.to_vec(), between, ways })
}

/// A way, and the first of its nodes that is as far from the hub, or the last.
fn straight(net: &CurveNet, way: Vec<u32>, at: DVec3, far: f64) -> (Vec<u32>, usize) {
    let end = (1..way.len()).find(|&k| net.points[way[k] as usize].distance(at) > far);
    let count = end.unwrap_or(way.len() - 1);
    (way, count)
}

/// Puts one branching in the place of all, with straight ways from it.
fn join(net: &mut CurveNet, hub: &Hub) {
    let centre = hub.forks[0];
    net.points[centre as usize] = hub.at;
    let goes = |v: &u32| hub.between.contains(v);
    let is_inner = |e: &[u32; 2]| e.iter().any(goes) || e.iter().all(|v| hub.forks.contains(v));
    net.edges.retain(|e| !is_inner(e));
    net.edges.iter_mut().for_each(|e| *e = e.map(|v| if hub.forks.contains(&v) { centre } else { v }));
    for (way, count) in &hub.ways {
        let end = net.points[way[*count] as usize];
        for k in 1..*count {
            net.points[way[k] as usize] = hub.at.lerp(end, k as f64 / *count as f64);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::context::Context;
    use crate::sample::{Tube, tubes};
    use crate::skeleton::closed;

    /// Five thin tubes from one point, and a net whose branches leave it from three places, by chance: they become one. A net of the same
    /// tubes from two points that are far apart stays.
    #[test]
    fn branchings_whose_branches_aim_at_one_point_become_one() {
        let directions = [DVec3::X, DVec3::new(0.8, 0.6, 0.0), -DVec3::X, DVec3::NEG_Y, DVec3::Z];
        let grown = |apart: f64| {
            let foot = |k: usize| DVec3::X * if k == 2 || k == 3 { -apart } else { 0.0 };
            let arm = |k: usize| Tube { ends: [foot(k), foot(k) + 3.0 * directions[k]], radii: [0.2; 2] };
            let mut all: Vec<Tube> = (0..5).map(arm).collect();
            all.push(Tube { ends: [DVec3::ZERO, DVec3::X * -apart.max(0.01)], radii: [0.2; 2] });
            let surface = tubes(&all, 0.03, 0.08, &Context::new()).unwrap().mesh.triangulated().unwrap();
            // The first two part late, the next two leave from another place.
            let forks = [DVec3::new(0.35, 0.1, 0.0), DVec3::new(-0.1 - apart, -0.05, 0.0), DVec3::new(0.0, 0.0, 0.05)];
            let mut net = CurveNet::new(forks.to_vec(), vec![0.2; 3], vec![[0, 2], [1, 2]]);
            for (k, fork) in [0, 0, 1, 1, 2].into_iter().enumerate() {
                let mut last = fork;
                for step in 2..=14 {
                    let p = foot(k) + directions[k] * (0.2 * f64::from(step));
                    net.edges.push([last, net.points.len() as u32]);
                    last = net.points.len() as u32;
                    net.points.push(p);
                    net.radii.push(0.2);
                    net.ids.push(i64::from(last));
                }
            }
            let closed = closed(&surface).unwrap();
            (gather(&mut net, &Target::new(&closed)), net)
        };
        let (count, net) = grown(0.0);
        let around = net.incidence();
        let forks: Vec<u32> = (0..net.points.len() as u32).filter(|&v| around.valence(v) > 2).collect();
        assert_eq!((count, forks.len(), around.valence(forks[0])), (1, 1, 5));
        assert!(net.points[forks[0] as usize].length() < 0.05, "{}", net.points[forks[0] as usize]);
        assert_eq!((around.tips().count(), net.components().1, net.cycles()), (5, 1, vec![0]));
        let (count, net) = grown(1.0);
        assert_eq!((count, net.incidence().tips().count()), (0, 5));
    }
}
