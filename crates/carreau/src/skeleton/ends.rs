//! Extends branches to flat ends.
//!
//! The flow draws the end of a tube inwards by about its radius, and the last nodes may leave the axis. Where the axis, seen
//! from a radius and more inside, meets a flat end, the last nodes go onto it, up to the end:
//!
//! ```text
//!   ┌───────────────────         ┌───────────────────
//!   │    ╭──•──•──•──•──    →    •──•──•──•──•──•──•─
//!   └────•──────────────         └───────────────────
//!        tip      a
//! ```
//!
//! Round ends have no such place: their branches end where the paper's do.

use super::body::Body;
use super::lids::{LEAST_WIDTH, Lid};
use super::sections::{middle_of_section, room, section};
use crate::mesh::{CurveNet, Incidence};
use glam::DVec3;
use std::f64::consts::TAU;

/// Distances from the tip, in radii, between which the axis is taken, because nearer to the tip the flow bends it. Where the tube
/// itself bends close to its end, a shorter piece, the second one, may still lead there.
const AXES: [[f64; 2]; 2] = [[1.0, 3.0], [0.7, 1.7]];
/// Distance, in radii, from where the axis is taken, within which an end is looked for.
const END_REACH: f64 = 4.0;
/// Distance from the axis, in radii, of the rays by which an end is told to be flat.
const RING: f64 = 0.6;
/// Largest difference, in radii, between the place where the axis meets a flat end and those where the rays do: a
/// half sphere is off by a fifth.
const FLAT_END: f64 = 0.05;
/// Number of these rays.
const END_RAYS: usize = 8;
/// Largest distance of a known end ahead of a tip, in the end's radii.
const AHEAD: f64 = 2.5;
/// Largest distance of a tip from the axis of a known end, in the end's radii.
const ASIDE: f64 = 1.0;
/// Least cosine between the axis and the normal of an end: what is more oblique is a side.
const FACES: f64 = 0.5;
/// The last node stays inside by this share of the radius.
const INSIDE: f64 = 0.02;

/// Distance before an end, in radii, within which a second short leaf branch is no end of its own.
const BEFORE: f64 = 1.5;
/// Distance from the axis of the end, in radii, for the same.
const BESIDE: f64 = 1.1;
/// Length of a short leaf branch, in radii.
const SHORT_LEAF: f64 = 3.0;

/// Which flat ends branches are led to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reach {
    /// All.
    All,
    /// Those with a sharp rim: cells meet the others by themselves.
    Sharp,
}

/// Flat ends that are known beforehand: lids of open ends, and plane pieces with a sharp rim.
pub struct Known<'a> {
    /// The ends.
    pub lids: &'a [Lid],
    /// Whether branches are led to them alone.
    pub alone: bool,
}

/// Moves the last nodes of branches that stop before a flat end, one branch for each; their radii are those of the sections across.
/// Returns the ends.
pub fn reach_ends(net: &mut CurveNet, body: &Body, known: &Known) -> Vec<End> {
    let counts = |end: &End| {
        let is_in = |lid: &Lid| {
            let to = end.at - lid.centre;
            to.dot(lid.normal).abs() < FLAT_END * lid.radius && to.length() < lid.radius
        };
        !known.alone || known.lids.iter().any(is_in)
    };
    let around = net.incidence();
    let mut ends: Vec<End> = Vec::new();
    for tip in around.tips() {
        let found = AXES.into_iter().find_map(|axis| {
            let nodes = inward(net, &around, tip, axis[1], body);
            let end = end(net, &nodes, axis[0], body).filter(counts)?;
            Some((nodes, end))
        });
        let found = found.or_else(|| {
            let nodes = inward(net, &around, tip, AXES[0][1], body);
            let end = known_end(net, &nodes, known.lids, body)?;
            Some((nodes, end))
        });
        let Some((nodes, mut end)) = found else { continue };
        if ends.iter().any(|known| known.at.distance(end.at) < known.radius) {
            continue;
        }
        lead(net, &nodes, &end, body);
        end.at = net.points[tip as usize];
        ends.push(end);
    }
    ends
}

/// Puts the last nodes of a branch, the tip first, onto the way to its end.
fn lead(net: &mut CurveNet, nodes: &[u32], end: &End, body: &Body) {
    let last = nodes.iter().position(|&v| v == end.from).unwrap_or(0);
    let [a, b] = [net.points[end.from as usize], end.at];
    let axis = (b - a).normalize_or_zero();
    // A section across a tilted axis would cut the end.
    let across = |share: f64| end.normal.lerp(axis, share).normalize_or(axis);
    for (k, &v) in nodes[..last].iter().enumerate() {
        let share = k as f64 / last as f64;
        net.points[v as usize] = middle_of_section(b.lerp(a, share), across(share), body.tree);
    }
    // The end may be nearer than the wall; one that is tilted would make a section too large.
    for (k, &v) in nodes.iter().enumerate() {
        let p = net.points[v as usize];
        if k >= last && (end.at - p).dot(end.normal) > end.radius {
            break;
        }
        let along = match (k, nodes.get(k + 1)) {
            (0, _) | (_, None) => end.normal,
            (_, Some(&next)) => net.points[nodes[k - 1] as usize] - net.points[next as usize],
        };
        let radius = section(p, along, body);
        net.radii[v as usize] = if radius.is_finite() { radius } else { end.radius };
    }
}

/// The known end that a branch stops before, where its axis does not lead there.
fn known_end(net: &CurveNet, nodes: &[u32], lids: &[Lid], body: &Body) -> Option<End> {
    let point = |v: u32| net.points[v as usize];
    let (tip, inner) = (point(nodes[0]), point(nodes[nodes.len() - 1]));
    let heading = (tip - inner).try_normalize()?;
    let widest = nodes.iter().map(|&v| net.radii[v as usize]).fold(0.0, f64::max);
    let is_before = |lid: &&Lid| {
        let to = lid.centre - tip;
        let ahead = to.dot(lid.normal);
        (0.0..AHEAD * lid.radius).contains(&ahead)
            && (to - lid.normal * ahead).length() < ASIDE * lid.radius
            && heading.dot(lid.normal) > FACES
            && lid.radius > LEAST_WIDTH * widest
    };
    let far = |lid: &Lid| lid.centre.distance_squared(tip);
    let lid = lids.iter().filter(is_before).min_by(|a, b| far(a).total_cmp(&far(b)))?;
    let at = lid.centre - lid.normal * (INSIDE * lid.radius);
    let from = nodes.iter().copied().find(|&v| point(v).distance(tip) >= lid.radius)?;
    (room(point(from), at, body) > 0.0).then_some(End { from, at, normal: lid.normal, radius: lid.radius })
}

/// Where a branch ends.
pub struct End {
    /// The node from which the axis leads there.
    from: u32,
    at: DVec3,
    normal: DVec3,
    radius: f64,
}

impl End {
    /// Whether a short leaf branch stops before this end, beside the one that leads there: it is no end of its own. Given its tip
    /// and how far it gets from its branching.
    ///
    /// ```text
    ///   ┌───────────────
    ///   │  ╭──·
    ///   •──•──────•─────      of the two branches that stop before the flat end the one that leads there stays
    ///   └───────────────
    /// ```
    pub fn has_beside(&self, tip: DVec3, reach: f64) -> bool {
        let to = tip - self.at;
        let ahead = to.dot(self.normal);
        let beside = (to - self.normal * ahead).length();
        tip != self.at
            && ahead.abs() < BEFORE * self.radius
            && beside < BESIDE * self.radius
            && reach < SHORT_LEAF * self.radius
    }
}

/// The nodes from a tip to the first branching or beyond the part in which the axis is taken.
fn inward(net: &CurveNet, around: &Incidence, tip: u32, far: f64, body: &Body) -> Vec<u32> {
    let mut nodes = vec![tip];
    let start = net.points[tip as usize];
    let mut widest = body.tree.distance(start);
    let mut edge = around.of(tip).first();
    while let Some(&[id, node]) = edge {
        nodes.push(node);
        widest = widest.max(net.radii[node as usize]);
        if around.valence(node) != 2 || net.points[node as usize].distance(start) > far * widest {
            break;
        }
        edge = around.of(node).iter().find(|e| e[0] != id);
    }
    nodes
}

fn end(net: &CurveNet, nodes: &[u32], near: f64, body: &Body) -> Option<End> {
    let point = |v: u32| net.points[v as usize];
    let start = point(nodes[0]);
    let radius = nodes.iter().map(|&v| net.radii[v as usize]).fold(0.0, f64::max);
    let at = nodes.iter().position(|&v| point(v).distance(start) >= near * radius)?;
    let (from, inner) = (nodes[at], nodes[nodes.len() - 1]);
    let axis = (point(from) - point(inner)).try_normalize()?;
    let radius = Some(section(point(from), axis, body)).filter(|r| r.is_finite() && *r > 0.0)?;
    let hit = body.tree.first_hit(point(from), axis).filter(|hit| !hit.front && hit.t < END_REACH * radius)?;
    let (centre, normal) = (point(from) + axis * hit.t, body.normals[hit.triangle as usize]);
    if normal.dot(axis) < FACES {
        return None;
    }
    let (u, v) = axis.any_orthonormal_pair();
    let is_flat = (0..END_RAYS).all(|k| {
        let (sin, cos) = (k as f64 * TAU / END_RAYS as f64).sin_cos();
        let from = point(from) + (u * cos + v * sin) * (RING * radius);
        let off = body.tree.first_hit(from, axis).map(|hit| (from + axis * hit.t - centre).dot(normal).abs());
        off.is_some_and(|off| off < FLAT_END * radius)
    });
    is_flat.then(|| End { from, at: centre - axis * (INSIDE * radius), normal, radius })
}
