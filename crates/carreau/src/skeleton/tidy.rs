//! Turns the curves into a skeleton: nodes outside are brought in, nodes get radii, branches within the ball of their
//! branching are dropped.

use super::body::Body;
use super::ends::{End, Known};
use super::limbs::{farthest, grow_limbs, leaves};
use super::mouths;
use super::sections::middle_of_section;
use crate::geometry::closest::closest_on_triangle;
use crate::geometry::search_tree::TriangleTree;
use crate::geometry::winding::WindingTree;
use crate::mesh::{CurveNet, Incidence, NONE, branches};
use glam::DVec3;
use rayon::prelude::*;

/// Poles that are tried for a node outside.
const TRIED: usize = 64;
/// Cycles of moving nodes to the middle and drawing them into line.
const CYCLES: usize = 3;
/// Steps of each cycle that move nodes to the middle.
const CENTRING: usize = 12;
/// Rounds of each cycle that draw nodes into line.
const ALIGNING: usize = 4;
/// A branching lies in a cleft where it has less than this share of a neighbour's room.
const CLEFT: f64 = 0.5;
/// Length of a way over that of the line between its ends from which on it is a curl.
const CURLED: f64 = 1.5;
/// Length, in radii, up to which ways are looked at.
const LONGEST_CURL: f64 = 8.0;
/// Branchings nearer to each other than this share of the larger radius are one.
const MERGED: f64 = 0.9;
/// A node within this share of the radius of a branch is in its middle.
const TWIN: f64 = 0.5;

/// Rounds of drawing them to their neighbours.
const RADIUS_ROUNDS: usize = 20;

/// Tidies the net of a body; returns how many nodes were brought in, and how many limbs got a branch. `preimage` is the node
/// of every vertex of the surface.
pub fn tidy(net: &mut CurveNet, preimage: &mut [u32], body: &Body, known: &Known, prune: bool) -> (usize, usize) {
    let brought_in = bring_in(net, body);
    centre(net, body.tree, body.inside);
    let radii = |net: &CurveNet| net.points.par_iter().map(|&p| body.tree.distance(p)).collect();
    net.radii = radii(net);
    mouths::straighten(net, body);
    let grown = regrow(net, preimage, body, known);
    if grown > 0 {
        centre(net, body.tree, body.inside);
        net.radii = radii(net);
    }
    if prune {
        drop_branches(net, preimage, is_stub);
        merge_branchings(net, preimage);
        net.radii = radii(net);
    }
    (brought_in, grown)
}

/// Gives limbs a branch that have none. What crosses the room between two limbs is in neither: it goes, if what grows
/// instead is not farther from the surface.
fn regrow(net: &mut CurveNet, preimage: &mut [u32], body: &Body, known: &Known) -> usize {
    let (mut other, mut other_preimage) = (net.clone(), preimage.to_vec());
    let before = net.points.len();
    let grown = grow_limbs(net, preimage, body, known);
    drop_branches(&mut other, &mut other_preimage, |net, branch, fork| {
        let way: Vec<u32> = branch.iter().copied().chain([fork]).collect();
        leaves(net, &way, body)
    });
    if other.points.len() < before {
        let regrown = grow_limbs(&mut other, &mut other_preimage, body, known);
        if farthest(&other, body) <= farthest(net, body) {
            *net = other;
            preimage.copy_from_slice(&other_preimage);
            return regrown;
        }
    }
    grown
}

/// Nodes outside go to the pole of the vertex nearest to them: the centres of inner balls are inside. Then they are drawn
/// to the middle of their neighbours, as far as that is inside.
fn bring_in(net: &mut CurveNet, &Body { surface, poles, inside, .. }: &Body) -> usize {
    let all = 0..net.points.len() as u32;
    let outside: Vec<u32> = all.into_par_iter().filter(|&v| !inside.contains(net.points[v as usize])).collect();
    for &v in &outside {
        let p = net.points[v as usize];
        let mut near: Vec<(f64, u32)> = surface.points().iter().map(|q| p.distance_squared(*q)).zip(0..).collect();
        let tried = TRIED.min(near.len());
        if tried < near.len() {
            near.select_nth_unstable_by(tried, |a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        }
        near.truncate(tried);
        near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        if let Some(&(_, q)) = near.iter().find(|n| inside.contains(poles[n.1 as usize])) {
            net.points[v as usize] = poles[q as usize];
        }
    }
    let around = net.incidence();
    for _ in 0..RADIUS_ROUNDS {
        for &v in &outside {
            let near = around.of(v);
            let middle = near.iter().map(|e| net.points[e[1] as usize]).sum::<DVec3>() / near.len().max(1) as f64;
            let moved = net.points[v as usize].lerp(middle, 0.5);
            if near.len() > 1 && inside.contains(moved) {
                net.points[v as usize] = moved;
            }
        }
    }
    outside.len()
}

/// Nodes near the surface move across their branch, away from it, as long as that takes them farther from the surface on all
/// sides; between that their neighbours draw them into line.
pub fn centre(net: &mut CurveNet, tree: &TriangleTree, inside: &WindingTree) {
    let around = net.incidence();
    for _ in 0..CYCLES {
        net.points = (0..net.points.len()).into_par_iter().map(|v| centred(net, &around, v, tree)).collect();
        uncurl(net, tree);
        for _ in 0..ALIGNING {
            align(net, &around, inside);
        }
    }
    net.points = (0..net.points.len()).into_par_iter().map(|v| centred(net, &around, v, tree)).collect();
    align(net, &around, inside);
    let in_middle = |v: usize| match *around.of(v as u32) {
        [[_, a], [_, b]] => {
            let along = net.points[b as usize] - net.points[a as usize];
            along.try_normalize().map_or(net.points[v], |along| middle_of_section(net.points[v], along, tree))
        }
        _ => net.points[v],
    };
    net.points = (0..net.points.len()).into_par_iter().map(in_middle).collect();
}

/// An articulation farther from the surface, across the direction of its branch; a branching in any direction, but not
/// farther than the surface was away: the tubes that meet there share a ball larger than theirs.
fn centred(net: &CurveNet, around: &Incidence, v: usize, tree: &TriangleTree) -> DVec3 {
    let mut p = net.points[v];
    let tangent = match *around.of(v as u32) {
        [] | [_] => return p,
        [[_, a], [_, b]] => (net.points[b as usize] - net.points[a as usize]).normalize_or_zero(),
        _ => DVec3::ZERO,
    };
    let Some(mut here) = tree.closest(p) else { return p };
    let leash = if tangent == DVec3::ZERO { leash(net, around, v, here.distance(), tree) } else { f64::INFINITY };
    let mut step = 0.5;
    for _ in 0..CENTRING {
        let away = p - here.point;
        let across = (away - tangent * tangent.dot(away)).normalize_or_zero();
        let tried = p + across * (step * here.distance());
        match tree.closest(tried) {
            Some(there)
                if there.distance_squared > here.distance_squared * 1.0001 && tried.distance(net.points[v]) < leash =>
            {
                (p, here) = (tried, there);
            }
            _ => step *= 0.5,
        }
    }
    p
}

/// How far a branching may move: as far as the surface is, or as far as it is from a neighbour where that has far more room,
/// as where fingers part and the flow has left the branching in the cleft between them.
fn leash(net: &CurveNet, around: &Incidence, v: usize, room: f64, tree: &TriangleTree) -> f64 {
    let rooms = around.of(v as u32).iter().map(|e| tree.distance(net.points[e[1] as usize]));
    let most = rooms.fold(0.0, f64::max);
    if room < CLEFT * most { most } else { room }
}

/// Where a branch takes a roundabout way to a node that lies in the inner ball of another, it goes straight: a ball holds
/// the lines between its points.
///
/// ```text
///        ╭──╮
///   ──i──│──│──       i and j in one ball, the way from one to the other far longer than the line
///        ╰──j
/// ```
fn uncurl(net: &mut CurveNet, tree: &TriangleTree) {
    let around = net.incidence();
    for branch in branches(net, &around).into_iter().filter(|b| !b.is_ring) {
        let nodes = &branch.nodes;
        let mut i = 0;
        while i + 2 < nodes.len() {
            let p = net.points[nodes[i] as usize];
            let radius = tree.distance(p);
            let (mut way, mut last) = (0.0, None);
            for j in i + 1..nodes.len() {
                way += net.points[nodes[j - 1] as usize].distance(net.points[nodes[j] as usize]);
                if way > LONGEST_CURL * radius {
                    break;
                }
                let line = p.distance(net.points[nodes[j] as usize]);
                if j > i + 1 && line < radius && way > CURLED * line && nodes[j] != nodes[i] {
                    last = Some(j);
                }
            }
            let Some(j) = last else {
                i += 1;
                continue;
            };
            let to = net.points[nodes[j] as usize];
            for k in i + 1..j {
                net.points[nodes[k] as usize] = p.lerp(to, (k - i) as f64 / (j - i) as f64);
            }
            i = j;
        }
    }
}

/// All nodes but extremities move half of the way to the middle of their neighbours, where that is inside.
fn align(net: &mut CurveNet, around: &Incidence, inside: &WindingTree) {
    let moved = |v: usize| {
        let near = around.of(v as u32);
        let middle = near.iter().map(|e| net.points[e[1] as usize]).sum::<DVec3>() / near.len().max(1) as f64;
        let moved = net.points[v].lerp(middle, 0.5);
        if near.len() > 1 && inside.contains(moved) { moved } else { net.points[v] }
    };
    net.points = (0..net.points.len()).into_par_iter().map(moved).collect();
}

/// Whether a leaf branch runs back in the middle of another: all of its nodes are near segments that are not its own.
fn is_twin(net: &CurveNet, branch: &[u32]) -> bool {
    let others = || net.edges.iter().filter(|e| !e.iter().any(|v| branch.contains(v)));
    let is_near = |p: DVec3| {
        others().any(|&[a, b]| {
            let [a, b] = [a, b].map(|v| v as usize);
            let on = closest_on_triangle(p, [net.points[a], net.points[b], net.points[b]]);
            on.distance(p) < TWIN * net.radii[a].max(net.radii[b])
        })
    };
    branch.iter().all(|&v| is_near(net.points[v as usize]))
}

/// Whether a leaf branch stays in the ball of its branching or in the middle of another branch.
fn is_stub(net: &CurveNet, branch: &[u32], fork: u32) -> bool {
    reach(net, branch, fork) < net.radii[fork as usize] || is_twin(net, branch)
}

/// Drops leaf branches that stop beside another before a flat end.
pub fn drop_beside(net: &mut CurveNet, preimage: &mut [u32], ends: &[End]) {
    drop_branches(net, preimage, |net, branch, fork| {
        let (tip, reach) = (net.points[branch[0] as usize], reach(net, branch, fork));
        ends.iter().any(|end| end.has_beside(tip, reach))
    });
}

/// How far a branch gets from its branching.
fn reach(net: &CurveNet, branch: &[u32], fork: u32) -> f64 {
    let centre = net.points[fork as usize];
    branch.iter().map(|&v| net.points[v as usize].distance(centre)).fold(0.0, f64::max)
}

/// Leaf branches go of which `goes` is true, given their nodes from the tip to before their branching, and that; the
/// shortest of each branching first.
fn drop_branches(net: &mut CurveNet, preimage: &mut [u32], goes: impl Fn(&CurveNet, &[u32], u32) -> bool) {
    loop {
        let around = net.incidence();
        let mut goes_into = vec![NONE; net.points.len()];
        let mut shortest: Vec<Option<(f64, Vec<u32>)>> = vec![None; net.points.len()];
        for tip in around.tips() {
            let Some((branch, fork)) = branch_to_fork(&around, tip) else { continue };
            let reach = reach(net, &branch, fork);
            let best = &mut shortest[fork as usize];
            if best.as_ref().is_none_or(|b| reach < b.0) && goes(net, &branch, fork) {
                *best = Some((reach, branch));
            }
        }
        for (fork, stub) in (0..).zip(&shortest) {
            stub.iter().flat_map(|s| &s.1).for_each(|&v| goes_into[v as usize] = fork);
        }
        if goes_into.iter().all(|&f| f == NONE) {
            return;
        }
        let keep: Vec<bool> = goes_into.iter().map(|&f| f == NONE).collect();
        let mut number = vec![NONE; keep.len()];
        (0..).zip((0..keep.len()).filter(|&v| keep[v])).for_each(|(k, v)| number[v] = k);
        for node in preimage.iter_mut() {
            let kept = if keep[*node as usize] { *node } else { goes_into[*node as usize] };
            *node = number[kept as usize];
        }
        net.retain_nodes(&keep);
    }
}

/// Branchings near each other become one, as those of a cross do, whose four tubes the flow lets part in two places.
fn merge_branchings(net: &mut CurveNet, preimage: &mut [u32]) {
    let (before, ids) = (net.points.clone(), net.ids.clone());
    net.ids = (0..before.len() as i64).collect();
    if net.merge_branchings(|[a, b]| MERGED * a.max(b)) > 0 {
        let nearest = |p: DVec3| {
            let off = |v: u32| net.points[v as usize].distance_squared(p);
            (0..net.points.len() as u32).min_by(|&a, &b| off(a).total_cmp(&off(b))).unwrap_or(0)
        };
        let mut number = vec![NONE; before.len()];
        (0..).zip(&net.ids).for_each(|(k, &old)| number[old as usize] = k);
        let number: Vec<u32> =
            number.iter().zip(&before).map(|(&k, &p)| if k == NONE { nearest(p) } else { k }).collect();
        preimage.iter_mut().for_each(|node| *node = number[*node as usize]);
    }
    net.ids = net.ids.iter().map(|&old| ids[old as usize]).collect();
}

/// The nodes from a tip to before the first branching, and that branching; none on a curve without branching.
fn branch_to_fork(around: &Incidence, tip: u32) -> Option<(Vec<u32>, u32)> {
    let mut branch = vec![tip];
    let mut edge = around.of(tip).first()?;
    loop {
        let [id, node] = *edge;
        match around.valence(node) {
            2 => branch.push(node),
            1 => return None,
            _ => return Some((branch, node)),
        }
        edge = around.of(node).iter().find(|e| e[0] != id)?;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Beside the axis of a tube with nine sides, and in a square one, which has no round section.
    #[test]
    fn in_a_round_section_a_node_goes_to_the_middle() {
        let tube = |sides: u32| {
            let mesh = crate::sample::open_cylinder(1.0, 4.0, sides, 1).unwrap().mesh.triangulated().unwrap();
            TriangleTree::new(mesh.points(), &mesh.faces().fan().0)
        };
        let beside = DVec3::new(0.2, -0.1, 2.0);
        let tilted = DVec3::new(0.05, 0.0, 1.0).normalize();
        let middle = middle_of_section(beside, tilted, &tube(9));
        assert!(middle.truncate().length() < 0.01, "{middle}");
        assert_eq!(middle_of_section(beside, tilted, &tube(4)), beside);
        assert_eq!(middle_of_section(beside + DVec3::X, tilted, &tube(9)), beside + DVec3::X);
    }

    /// A trunk along x, and a leaf branch of its middle that runs back beside it, or away from it.
    #[test]
    fn a_branch_that_runs_back_goes_and_one_that_leaves_stays() {
        for (to, left) in [(DVec3::new(-1.0, 0.1, 0.0), 9), (DVec3::new(0.3, 1.0, 0.0), 12)] {
            let mut points: Vec<DVec3> = (0..9).map(|k| DVec3::X * f64::from(k)).collect();
            points.extend((1..=3).map(|k| DVec3::X * 4.0 + to * f64::from(k)));
            let mut edges: Vec<[u32; 2]> = (1..9).map(|k| [k - 1, k]).collect();
            edges.extend([[4, 9], [9, 10], [10, 11]]);
            let mut net = CurveNet::new(points, vec![1.2; 12], edges);
            drop_branches(&mut net, &mut [0; 0], is_stub);
            assert_eq!(net.points.len(), left);
        }
    }
}
