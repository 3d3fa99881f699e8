//! Which branch continues which, and how many quads that gives every fan.
//!
//! p follows from r − ω, not from r: forgetting ω here makes the poles again that it is there to avoid. The number of quads of a
//! fan is k = (Θ − Σ r) 2/π, an integer: 4 at a regular inner vertex, 2 in a straight sector.

use super::dual::{Dual, Fan, Spoke};
use std::cmp::Reverse;
use std::f64::consts::FRAC_PI_2;

/// p of every edge.
pub fn matchings(dual: &Dual<'_>, alpha: &[f64], omega: &[f64]) -> Vec<i32> {
    let of = |e: usize| {
        let [i, j] = dual.ends(e).map(|t| alpha[t as usize]);
        -((j - i + dual.turn[e] - omega[e]) / FRAC_PI_2).round() as i32
    };
    (0..dual.edges.len()).map(of).collect()
}

/// r of an edge, equation 1.
pub fn rotation(dual: &Dual<'_>, alpha: &[f64], p: &[i32], e: u32) -> f64 {
    let [i, j] = dual.ends(e as usize).map(|t| alpha[t as usize]);
    j - i + dual.turn[e as usize] + f64::from(p[e as usize]) * FRAC_PI_2
}

/// k before rounding.
pub fn exact_quads(dual: &Dual<'_>, alpha: &[f64], p: &[i32], fan: &Fan) -> f64 {
    (fan.angle - dual.around(fan, |e| rotation(dual, alpha, p, e))) / FRAC_PI_2
}

/// k of every fan.
pub fn quads(dual: &Dual<'_>, alpha: &[f64], p: &[i32]) -> Vec<i32> {
    dual.fans.iter().map(|fan| exact_quads(dual, alpha, p, fan).round() as i32).collect()
}

/// The fewest quads that a fan may have: a sector one; an inner vertex three, since two are a doublet.
pub fn fewest(fan: &Fan) -> i32 {
    if fan.closed { 3 } else { 1 }
}

/// Gives fans with too few quads one at a time from the fan across an edge that can spare most; returns how many were given.
/// First come the sectors, which always get theirs: the edges that they cross end at inner vertices. These get theirs from fans
/// that keep enough.
pub fn operate(dual: &Dual<'_>, p: &mut [i32], quads: &mut [i32]) -> usize {
    let fans = || 0..dual.fans.len();
    let sectors = fans().filter(|&f| !dual.fans[f].closed);
    let inner = fans().filter(|&f| dual.fans[f].closed);
    let mut given = 0;
    for f in sectors.chain(inner) {
        let fan = &dual.fans[f];
        while quads[f] < fewest(fan) {
            let spare = |s: &Spoke| quads[s.far_fan as usize] - fewest(&dual.fans[s.far_fan as usize]);
            let Some(best) = dual.spokes(fan).max_by_key(|s| (spare(s), Reverse(s.edge))) else { break };
            if fan.closed && spare(&best) <= 0 {
                break;
            }
            // r falls by a quarter turn as this fan crosses the edge.
            p[best.edge as usize] -= best.sign as i32;
            quads[f] += 1;
            quads[best.far_fan as usize] -= 1;
            given += 1;
        }
    }
    given
}
