//! Quads by matching: the best choice of disjoint pairs over the whole mesh, instead of a greedy one.
//!
//! A pair of triangles is an edge of the dual graph, a choice of quads a matching. *Weighted*: the sum of the quads'
//! qualities plus a price for every triangle left over is minimal (Remacle et al. 2012, with a price
//! that was measured). *Cardinality*: as few triangles as possible are left over, and among those choices the
//! qualities are best.

use super::quality::Candidates;
use super::zones::Quads;
use crate::context::Context;
use crate::error::Result;
use crate::numeric::matching::{Edge, minimum_cost_matching};
use std::f64::consts::FRAC_PI_2;

/// Price of a left-over triangle, in right angles of quality. A quad costs `PAIR_PRICE + Q/(π/2)` as against twice this.
const TRIANGLE_PRICE: f64 = 4.0;
/// Price of a quad without its quality, in the same unit: less than that of two triangles.
const PAIR_PRICE: f64 = 6.0;
/// Steps to which qualities are rounded, per right angle; fewer where the sum of costs would not fit an integer.
const STEPS: f64 = 1e6;
/// Largest sum of costs: well within an `i64`.
const LARGEST_SUM: f64 = 1e18;

/// What a matching prefers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Preference {
    Quality,
    Cardinality,
}

/// The optimal choice of pairs.
pub(super) fn match_pairs(candidates: &Candidates, preference: Preference, context: &Context) -> Result<Quads> {
    let _stage = context.stage("matching");
    let triangles = candidates.triangles;
    let n = triangles.len();
    let cost = |h: u32| candidates.cost[h as usize] / FRAC_PI_2;
    let worst = candidates.order.iter().map(|&h| cost(h)).fold(0.0, f64::max);
    let (pair, triangle) = match preference {
        Preference::Quality => (PAIR_PRICE, TRIANGLE_PRICE),
        // One more pair outweighs any change of quality.
        Preference::Cardinality => (0.0, (n as f64 / 2.0 + 1.0) * (worst + 1.0)),
    };
    let scale = STEPS.min(LARGEST_SUM / (n as f64 * (pair + worst).max(triangle)).max(1.0));
    let steps = |x: f64| (x * scale).round() as i64;
    let edge = |&h: &u32| Edge { ends: [h / 3, triangles.opposite(h) / 3], cost: steps(pair + cost(h)) };
    let edges: Vec<Edge> = candidates.order.iter().map(edge).collect();
    let matching = minimum_cost_matching(&edges, &vec![steps(triangle); n], context)?;
    let mut quads = Quads::new(n);
    for (&h, edge) in candidates.order.iter().zip(0u32..) {
        if matching.matched_edge[h as usize / 3] == edge {
            quads.push(h, triangles.opposite(h));
        }
    }
    Ok(quads)
}
