//! What a user is told: how far the scan is from the faces, and the angles between these.

use super::blocks::{Block, Layout};
use super::control::{Sheet, from_part};
use super::feet::Sample;
use super::net::{Net, next};
use crate::brep::{Brep, Surface};
use crate::context::Context;
use crate::error::Result;
use crate::mesh::NONE;
use glam::DVec3;
use rayon::prelude::*;

/// A count: samples of an edge for every knot of its faces, because the angle between faces changes between knots.
const SAMPLES_A_KNOT: usize = 4;

/// Angles in degrees between the faces at smooth edges.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize)]
pub struct Angles {
    /// 99 % of the length of all edges are below this.
    pub p99: f64,
    /// The largest.
    pub max: f64,
}

/// The block of every quad with the column and row there, and the turn of the quad: its lower side.
pub fn places(net: &Net, blocks: &[Block]) -> Vec<(u32, [usize; 2], u32)> {
    let mut out = vec![(NONE, [0; 2], 0); net.quads.len()];
    for (b, block) in (0u32..).zip(blocks) {
        for (k, &lower) in block.lower.iter().enumerate() {
            out[lower as usize / 4] = (b, [k % block.size[0], k / block.size[0]], lower);
        }
    }
    out
}

/// Distances of samples from the faces that their feet are on.
pub fn distances(net: &Net, blocks: &[Block], brep: &Brep, samples: &[Sample], context: &Context) -> Result<Vec<f64>> {
    let places = places(net, blocks);
    let one = |(k, sample): (usize, &Sample)| {
        context.check_every(k)?;
        let (b, quad, lower) = places[sample.part as usize / 4];
        let quarter = (0..4).find(|&k| (0..k).fold(lower, |h, _| next(h)) == sample.part).unwrap_or(0);
        let [x, y] = from_part(quarter, sample.at);
        let start = [quad[0] as f64 + x, quad[1] as f64 + y];
        let surface = &brep.surfaces[b as usize];
        let [u, v] = surface.project_near(sample.point, start);
        Ok(surface.point(u, v).distance(sample.point))
    };
    context.install(|| samples.par_iter().enumerate().map(one).collect())
}

/// The angles at all edges between two faces that are no creases.
pub fn angles(net: &Net, blocks: &[Block], layout: &Layout, sheets: &[Sheet], brep: &Brep) -> Angles {
    let mut users: Vec<Vec<(usize, usize)>> = vec![Vec::new(); layout.arcs.len()];
    for (b, uses) in layout.uses.iter().enumerate() {
        uses.iter().enumerate().for_each(|(k, of)| users[of.arc as usize].push((b, k)));
    }
    let mut found: Vec<(f64, f64)> = Vec::new();
    for users in &users {
        let [(a, i), (b, j)] = users[..] else { continue };
        let of = &layout.uses[a][i];
        if net.opposite[blocks[a].side(of.side)[of.from] as usize] == NONE {
            continue;
        }
        let normal = |block: usize, k: usize, share: f64| {
            let of = &brep.faces[block].loops[0][k];
            let (Surface::Spline(s), Some([u, v])) = (&brep.surfaces[block], of.at_share(share)) else {
                return DVec3::ZERO;
            };
            let jet = s.jet(u, v);
            jet.first[0].cross(jet.first[1]).normalize_or_zero()
        };
        let knots = &sheets[a].knots[of.side % 2];
        let count = blocks[a].size[of.side % 2] as f64;
        let [from, to] = [of.from as f64, of.to as f64].map(|k| if of.side >= 2 { count - k } else { k });
        let (low, high) = (from.min(to), from.max(to));
        let breaks: Vec<f64> = knots.breaks().into_iter().filter(|&t| low <= t && t <= high).collect();
        let curve = &brep.edges[of.arc as usize];
        for w in breaks.windows(2) {
            for k in 0..=SAMPLES_A_KNOT {
                let t = w[0] + (w[1] - w[0]) * k as f64 / SAMPLES_A_KNOT as f64;
                // The edge runs like its first user, counter-clockwise.
                let share = (t - from) / (to - from);
                let share = if of.reversed { 1.0 - share } else { share };
                let (n, m) = (normal(a, i, share), normal(b, j, share));
                let angle = n.cross(m).length().atan2(n.dot(m)).to_degrees();
                let [_, speed, _] = curve.curve.derivatives(curve.parameter_at(share));
                found.push((angle, speed.length() * (w[1] - w[0])));
            }
        }
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    let total: f64 = found.iter().map(|f| f.1).sum();
    let mut sum = 0.0;
    let p99 = found.iter().find(|f| {
        sum += f.1;
        sum >= 0.99 * total
    });
    Angles { p99: p99.map_or(0.0, |f| f.0), max: found.last().map_or(0.0, |f| f.0) }
}
