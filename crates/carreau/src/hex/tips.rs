//! Prepares the skeleton of a surface for meshing: centres its branches, and extends extremities to the surface.
//!
//! Skeletons stop short of the surface. The branch is prolonged along its direction to where it leaves the surface:
//!
//! ```text
//!      ╭────────╮         a round tip: the last ring lies where the tip is about 0.7 of the branch's radius,
//!   ───·───→  ┊  │        its cap bulges out to the tip
//!      ╰────────╯
//! ```
//!
//! An end that meets a lid lies in it, at its middle.

use super::target::Target;
use crate::mesh::{CurveNet, Incidence};
use glam::DVec3;

/// Rounds of filling in radii.
const FILLING_ROUNDS: usize = 30;
/// Radius of the last ring of a round tip, as a share of the branch's.
const RING: f64 = 0.7;
/// Distance of that ring from the tip, in radii.
const DEPTH: f64 = 0.35;
/// Distance from a tip, in radii, from which on its direction is taken.
const REACH: f64 = 1.2;
/// Least number of nodes that the direction of a tip is taken over.
const LEAST_NODES: usize = 3;
/// An end meets a lid within this many radii of it.
const LID_REACH: f64 = 1.5;

/// Centres the branches and prolongs them; gives the nodes radii, and says which lid (from 1) each node lies in.
pub fn ready(net: &mut CurveNet, target: &Target) -> Vec<u32> {
    let around = net.incidence();
    target.centre(net);
    net.radii = net.points.iter().map(|&p| target.room(p)).collect();
    fill_dips(net, &around);
    let mut lid_of = vec![0; net.points.len()];
    let mut taken = vec![false; target.lids().len()];
    for tip in around.tips() {
        let (direction, radius) = heading(net, &around, tip);
        let from = net.points[tip as usize];
        let near = |k: &usize| {
            let lid = &target.lids()[*k];
            let off = (lid.centre - from).dot(lid.normal);
            lid.centre.distance(from) < off.abs() + LID_REACH * lid.radius.max(radius)
                && lid.ends(from, direction, radius)
                || lid.centre.distance(from) < lid.radius
        };
        let free = (0..taken.len()).filter(|&k| !taken[k]).filter(near);
        let lid = free.min_by(|&a, &b| {
            let far = |k: usize| target.lids()[k].centre.distance_squared(from);
            far(a).total_cmp(&far(b))
        });
        if let Some(k) = lid {
            taken[k] = true;
            lid_of[tip as usize] = k as u32 + 1;
            net.points[tip as usize] = target.lids()[k].centre;
            net.radii[tip as usize] = target.lids()[k].radius;
            continue;
        }
        if let Some(depth) = target.leaves(from, direction) {
            let ring = RING * radius;
            net.points[tip as usize] = from + direction * (depth - DEPTH * radius.min(depth + radius));
            net.radii[tip as usize] = ring.max(1e-3 * radius);
        }
    }
    lid_of
}

/// The direction in which a branch ends, from about a radius before its tip, and the largest radius on the way.
pub fn heading(net: &CurveNet, around: &Incidence, tip: u32) -> (DVec3, f64) {
    let from = net.points[tip as usize];
    let mut radius = net.radii[tip as usize];
    let (mut node, mut edge) = (tip, u32::MAX);
    for step in 1..net.points.len() {
        let Some(&[e, next]) = around.of(node).iter().find(|s| s[0] != edge) else { break };
        (node, edge) = (next, e);
        let away = from.distance(net.points[node as usize]);
        if away > REACH * radius && step > LEAST_NODES || around.valence(node) != 2 {
            break;
        }
        radius = radius.max(net.radii[node as usize]);
    }
    ((from - net.points[node as usize]).normalize_or(DVec3::X), radius)
}

/// Where a skeleton runs nearer to the surface than on both sides, the radius of the steps is filled in from there.
fn fill_dips(net: &mut CurveNet, around: &Incidence) {
    for _ in 0..FILLING_ROUNDS {
        let old = net.radii.clone();
        for v in 0..net.points.len() as u32 {
            if let &[[_, a], [_, b]] = around.of(v) {
                let middle = 0.49 * (old[a as usize] + old[b as usize]);
                net.radii[v as usize] = old[v as usize].max(middle);
            }
        }
    }
}
