//! Branches are led to flat ends.
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

use super::lids::Lid;
use super::limbs::section;
use super::tidy::Body;
use crate::mesh::{CurveNet, Incidence};
use glam::DVec3;
use std::f64::consts::TAU;

/// The axis is taken between so many radii and so many from the tip: nearer to it the flow bends it.
const AXIS: [f64; 2] = [1.0, 3.0];
/// An end is looked for within so many radii of where the axis is taken.
const FAR: f64 = 4.0;
/// An end is flat where rays around the axis, at this share of the radius from it, meet the plane that the axis meets within
/// that share of the radius: a half sphere is off by a fifth.
const RING: f64 = 0.6;
const FLAT: f64 = 0.05;
const RAYS: usize = 8;
/// Least cosine between the axis and the normal of an end: what is more oblique is a side.
const FACES: f64 = 0.5;
/// The last node stays inside by this share of the radius.
const INSIDE: f64 = 0.02;

/// Which flat ends branches are led to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reach {
    /// All.
    All,
    /// Those with a sharp rim: cells meet the others by themselves.
    Sharp,
}

/// Moves the last nodes of branches that stop before a flat end; their radii are those of the sections across. Where only
/// some ends count, these are the `lids`.
pub fn reach_ends(net: &mut CurveNet, body: &Body, lids: Option<&[Lid]>) {
    let counts = |at: DVec3| {
        let is_in = |lid: &Lid| {
            let to = at - lid.centre;
            to.dot(lid.normal).abs() < FLAT * lid.radius && to.length() < lid.radius
        };
        lids.is_none_or(|lids| lids.iter().any(is_in))
    };
    let around = net.incidence();
    for tip in around.tips() {
        let nodes = inward(net, &around, tip, body);
        let Some(end) = end(net, &nodes, body).filter(|end| counts(end.at)) else { continue };
        let last = nodes.iter().position(|&v| v == end.from).unwrap_or(0);
        let [a, b] = [net.points[end.from as usize], end.at];
        let axis = (b - a).normalize_or_zero();
        for (k, &v) in nodes[..last].iter().enumerate() {
            let p = b.lerp(a, k as f64 / last as f64);
            let radius = section(p, axis, body);
            net.points[v as usize] = p;
            net.radii[v as usize] = if radius.is_finite() { radius } else { end.radius };
        }
    }
}

/// Where a branch is to end.
struct End {
    /// The node from which the axis leads there.
    from: u32,
    at: DVec3,
    radius: f64,
}

/// The nodes from a tip to the first branching or beyond the part in which the axis is taken.
fn inward(net: &CurveNet, around: &Incidence, tip: u32, body: &Body) -> Vec<u32> {
    let mut nodes = vec![tip];
    let start = net.points[tip as usize];
    let mut widest = body.tree.distance(start);
    let mut edge = around.of(tip).first();
    while let Some(&[id, node]) = edge {
        nodes.push(node);
        widest = widest.max(net.radii[node as usize]);
        if around.valence(node) != 2 || net.points[node as usize].distance(start) > AXIS[1] * widest {
            break;
        }
        edge = around.of(node).iter().find(|e| e[0] != id);
    }
    nodes
}

fn end(net: &CurveNet, nodes: &[u32], body: &Body) -> Option<End> {
    let point = |v: u32| net.points[v as usize];
    let start = point(nodes[0]);
    let radius = nodes.iter().map(|&v| net.radii[v as usize]).fold(0.0, f64::max);
    let at = nodes.iter().position(|&v| point(v).distance(start) >= AXIS[0] * radius)?;
    let (from, inner) = (nodes[at], nodes[nodes.len() - 1]);
    let axis = (point(from) - point(inner)).try_normalize()?;
    let radius = Some(section(point(from), axis, body)).filter(|r| r.is_finite() && *r > 0.0)?;
    let hit = body.tree.first_hit(point(from), axis).filter(|hit| !hit.front && hit.t < FAR * radius)?;
    let (centre, normal) = (point(from) + axis * hit.t, body.normals[hit.triangle as usize]);
    if normal.dot(axis) < FACES {
        return None;
    }
    let (u, v) = axis.any_orthonormal_pair();
    let is_flat = (0..RAYS).all(|k| {
        let (sin, cos) = (k as f64 * TAU / RAYS as f64).sin_cos();
        let from = point(from) + (u * cos + v * sin) * (RING * radius);
        let off = body.tree.first_hit(from, axis).map(|hit| (from + axis * hit.t - centre).dot(normal).abs());
        off.is_some_and(|off| off < FLAT * radius)
    });
    is_flat.then(|| End { from, at: centre - axis * (INSIDE * radius), radius })
}
