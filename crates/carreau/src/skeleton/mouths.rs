//! Straightens the axis of a thick tube where the flow has drawn it aside, into the mouth of a thin one.
//!
//! ```text
//!   ═════════════════         ═════════════════
//!   ──╲         ╱────         ────────•────────      i and j have far more room than the branching between them, and the
//!   ═══i══╲ ╱══j═════    →    ══════╗ │ ╔══════      line from one to the other has it, too
//!         ║•║                       ║ │ ║
//! ```

use super::body::Body;
use super::sections::room;
use crate::mesh::{CurveNet, Incidence};
use glam::DVec3;

/// A branching lies in a mouth where it has less than this share of the room of the tube that passes by: one in the middle of that has
/// as much.
const MOUTH: f64 = 0.75;
/// The share of that room that the straight way must have.
const STRAIGHT_ROOM: f64 = 0.9;
/// Way from a branching, in radii of the thick tube, on which its axis may be drawn aside.
const DRAWN_WAY: f64 = 3.0;
/// Share of the largest room on that way from which on a node is on the axis again.
const BACK: f64 = 0.9;
/// Distance of the new nodes from each other, in radii of the thick tube.
const SIDE_STEP: f64 = 0.5;
/// The branching comes between these shares of the straight way.
const BETWEEN: [f64; 2] = [0.2, 0.8];

/// The way from a branching along one branch, to where that is on the axis of its tube.
struct Arm {
    /// From beside the branching on.
    nodes: Vec<u32>,
}

/// Straightens the net of a body at all branchings that lie in a mouth, and returns how many. Nodes need radii.
pub fn straighten(net: &mut CurveNet, body: &Body) -> usize {
    let mut count = 0;
    for fork in 0..net.points.len() as u32 {
        let around = net.incidence();
        if around.valence(fork) < 3 {
            continue;
        }
        let arms: Vec<Arm> = (0..around.of(fork).len()).map(|k| arm(net, &around, fork, k)).collect();
        if let Some([a, b]) = passing(net, fork, &arms, body) {
            let foot = foot(net, fork, &arms, [a, b]);
            let mut others = around.of(fork).iter().filter(|s| ![a, b].iter().any(|&k| arms[k].nodes[0] == s[1]));
            if others.all(|s| room(foot, net.points[s[1] as usize], body) > 0.0) {
                draw_back(net, fork, foot, &arms, [a, b], body);
                count += 1;
            }
        }
    }
    count
}

/// The arm on one of a branching's segments.
fn arm(net: &CurveNet, around: &Incidence, fork: u32, segment: usize) -> Arm {
    let [mut edge, mut node] = around.of(fork)[segment];
    let (mut last, mut way) = (fork, 0.0);
    let (mut nodes, mut widest) = (Vec::new(), net.radii[fork as usize]);
    loop {
        way += net.points[last as usize].distance(net.points[node as usize]);
        widest = widest.max(net.radii[node as usize]);
        if around.valence(node) > 2 || way > DRAWN_WAY * widest {
            break;
        }
        nodes.push(node);
        let Some(&next) = around.of(node).iter().find(|s| s[0] != edge) else { break };
        last = node;
        [edge, node] = next;
    }
    let most = nodes.iter().map(|&v| net.radii[v as usize]).fold(0.0, f64::max);
    let back = nodes.iter().position(|&v| net.radii[v as usize] >= BACK * most);
    nodes.truncate(back.map_or(0, |k| k + 1));
    Arm { nodes }
}

/// The two arms that belong to a thick tube beside the branching: of several pairs the one with most room.
fn passing(net: &CurveNet, fork: u32, arms: &[Arm], body: &Body) -> Option<[usize; 2]> {
    let end = |arm: &Arm| arm.nodes.last().map(|&v| (net.points[v as usize], net.radii[v as usize]));
    let mut best: Option<(f64, [usize; 2])> = None;
    for (b, second) in arms.iter().enumerate() {
        for (a, first) in arms[..b].iter().enumerate() {
            let (Some((p, r)), Some((q, s))) = (end(first), end(second)) else { continue };
            let thick = r.min(s);
            let is_best = best.is_none_or(|known| thick > known.0);
            if is_best && net.radii[fork as usize] < MOUTH * thick && room(p, q, body) >= STRAIGHT_ROOM * thick {
                best = Some((thick, [a, b]));
            }
        }
    }
    best.map(|b| b.1)
}

/// The ends of two arms.
fn ends(net: &CurveNet, arms: &[Arm], pair: [usize; 2]) -> [DVec3; 2] {
    pair.map(|k| net.points[arms[k].nodes[arms[k].nodes.len() - 1] as usize])
}

/// The place on the line between the ends of two arms where the others leave it.
fn foot(net: &CurveNet, fork: u32, arms: &[Arm], pair: [usize; 2]) -> DVec3 {
    let [from, to] = ends(net, arms, pair);
    let along = to - from;
    let share = (net.points[fork as usize] - from).dot(along) / along.length_squared().max(f64::MIN_POSITIVE);
    from.lerp(to, share.clamp(BETWEEN[0], BETWEEN[1]))
}

/// Puts the nodes of two arms onto the line between their ends, the branching to the foot of the others.
fn draw_back(net: &mut CurveNet, fork: u32, foot: DVec3, arms: &[Arm], pair: [usize; 2], body: &Body) {
    let [first, second] = pair.map(|k| &arms[k].nodes);
    let [from, to] = ends(net, arms, pair);
    let mut moved = vec![fork];
    net.points[fork as usize] = foot;
    for (nodes, end) in [(first, from), (second, to)] {
        for (k, &v) in nodes.iter().enumerate() {
            net.points[v as usize] = foot.lerp(end, (k + 1) as f64 / nodes.len() as f64);
        }
        moved.extend(nodes);
    }
    moved.iter().for_each(|&v| net.radii[v as usize] = body.tree.distance(net.points[v as usize]));
    let step = SIDE_STEP * net.radii[fork as usize];
    let stays = |edge: &[u32; 2]| pair.iter().any(|&k| edge.contains(&arms[k].nodes[0]));
    for edge in 0..net.edges.len() {
        let ends = net.edges[edge];
        if ends.contains(&fork) && !stays(&ends) {
            let away = if ends[0] == fork { ends[1] } else { ends[0] };
            net.edges[edge] = [lead_to(net, fork, net.points[away as usize], step, body), away];
        }
    }
}

/// Adds nodes on the way from a node to before a place, and returns the last of them.
fn lead_to(net: &mut CurveNet, from: u32, to: DVec3, step: f64, body: &Body) -> u32 {
    let start = net.points[from as usize];
    let count = (start.distance(to) / step.max(f64::MIN_POSITIVE)).ceil().clamp(1.0, 100.0) as usize;
    let mut last = from;
    for k in 1..count {
        let p = start.lerp(to, k as f64 / count as f64);
        let new = net.points.len() as u32;
        net.edges.push([last, new]);
        net.ids.push(i64::from(new));
        net.radii.push(body.tree.distance(p));
        net.points.push(p);
        last = new;
    }
    last
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::context::Context;
    use crate::geometry::normals::face_normals;
    use crate::geometry::search_tree::TriangleTree;
    use crate::geometry::winding::WindingTree;
    use crate::sample::{Tube, tubes};

    /// A thick tube along x with a thin one along y. The axis of the thick one makes a detour into the mouth of the thin one, and
    /// goes straight afterwards; one that is straight stays.
    #[test]
    fn the_axis_of_a_thick_tube_leaves_the_mouth_of_a_thin_one() {
        let thick = Tube { ends: [-DVec3::X * 4.0, DVec3::X * 4.0], radii: [1.0; 2] };
        let thin = Tube { ends: [DVec3::ZERO, DVec3::Y * 4.0], radii: [0.4; 2] };
        let surface = tubes(&[thick, thin], 0.1, 0.15, &Context::new()).unwrap().mesh.triangulated().unwrap();
        let tree = TriangleTree::new(surface.points(), &surface.faces().fan().0);
        let (normals, inside) = (face_normals(&surface), WindingTree::new(&tree));
        let body = Body { surface: &surface, poles: surface.points(), tree: &tree, normals: &normals, inside: &inside };
        let along = |detour: f64| {
            let of_axis =
                |k: i32| DVec3::new(0.5 * f64::from(k), detour * (1.0 - 0.4 * f64::from(k.abs())).max(0.0), 0.0);
            let of_side = |k: i32| DVec3::Y * (1.4 + 0.5 * f64::from(k));
            let points: Vec<DVec3> = (-6..=6).map(of_axis).chain((0..4).map(of_side)).collect();
            let mut edges: Vec<[u32; 2]> = (1..13).map(|k| [k - 1, k]).collect();
            edges.extend([[6, 13], [13, 14], [14, 15], [15, 16]]);
            let radii = points.iter().map(|&p| tree.distance(p)).collect();
            CurveNet::new(points, radii, edges)
        };
        let mut net = along(1.1);
        assert!(net.radii[6] < 0.6);
        assert_eq!(straighten(&mut net, &body), 1);
        assert!((0..13).all(|v| net.points[v].y.abs() < 1e-9 && net.radii[v] > 0.9), "{net:?}");
        assert!(net.points.len() > 17 && net.radii.len() == net.points.len() && net.ids.len() == net.points.len());
        let around = net.incidence();
        assert_eq!((around.tips().count(), around.valence(6), net.components().1), (3, 3, 1));
        let mut straight = along(0.0);
        assert_eq!((straighten(&mut straight, &body), straight), (0, along(0.0)));
    }
}
