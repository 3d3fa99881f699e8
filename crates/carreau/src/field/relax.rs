//! Relaxation of orthogonality, equations 4 and 5: the second branch may lean by ρ. The matchings stay as they are, so the
//! numbers of quads do, too.
//!
//! The paper clips |ρ| afterwards, which can raise the energy. Here a ρ beyond the limit is held there and the others are
//! solved for again, until next to none is beyond it; what would still be dearer than the orthogonal field is not taken.

use super::dual::Dual;
use super::matching::rotation;
use crate::context::Context;
use crate::error::Result;
use crate::mesh::NONE;
use crate::numeric::sparse::{LeastSquares, Plan};
use std::f64::consts::{FRAC_PI_2, PI};

/// ε of the term that favours orthogonality, for an edge of weight 1: small, because it is to decide only where edges
/// hardly do.
const ORTHOGONALITY_WEIGHT: f64 = 1e-2;
/// A count: most solves of a relaxation, because each that holds one more ρ costs as much as the first. Where they do
/// not suffice the orthogonal field stays.
const RELAXATION_ROUNDS: usize = 12;
/// A count: from this round on a few new ρ beyond the limit are clipped as in the paper, if that is cheaper, because
/// they change next to nothing.
const EXACT_ROUNDS: usize = 2;
/// A count: a few are fewer than one in so many triangles, because a clipped one moves only the field around it.
const TRIANGLES_A_CLIP: usize = 500;
/// Radians: a turn from here on is made to share with others, because beyond half a turn p does not tell which way it
/// goes.
const MOST_TURN: f64 = 0.95 * PI;
/// A factor: what the edge of such a turn weighs more in the next solve, enough for few solves to spread it.
const STEEP_FACTOR: f64 = 8.0;
/// Weight that holds a ρ at the limit, for an edge of weight 1: a weight, because the matrix then has its entries in
/// the same places in every round and is planned once.
const HELD_WEIGHT: f64 = 1e6;

/// A field whose second branch is at α + π/2 + ρ.
pub struct Relaxed {
    pub alpha: Vec<f64>,
    pub rho: Vec<f64>,
}

/// Σ w (r⁰² + r¹²).
pub fn energy(dual: &Dual<'_>, alpha: &[f64], rho: &[f64], p: &[i32]) -> f64 {
    let of = |e: u32| {
        let [r0, r1] = turns(dual, alpha, rho, p, e);
        dual.weight[e as usize] * (r0 * r0 + r1 * r1)
    };
    (0..dual.edges.len() as u32).map(of).sum()
}

/// r⁰ and r¹ of an edge, equation 4.
fn turns(dual: &Dual<'_>, alpha: &[f64], rho: &[f64], p: &[i32], e: u32) -> [f64; 2] {
    let [i, j] = dual.ends(e as usize).map(|t| rho[t as usize]);
    let r = rotation(dual, alpha, p, e);
    if p[e as usize] % 2 == 0 { [r, r - i + j] } else { [r + j, r - i] }
}

/// Makes the edges heavier across which a branch turns by half a turn or nearly; returns whether there are any.
fn weigh_steep(dual: &Dual<'_>, of: &Relaxed, p: &[i32], weight: &mut [f64]) -> bool {
    let is_steep = |&e: &u32| turns(dual, &of.alpha, &of.rho, p, e).iter().any(|r| r.abs() > MOST_TURN);
    let steep: Vec<u32> = (0..dual.edges.len() as u32).filter(is_steep).collect();
    steep.iter().for_each(|&e| weight[e as usize] *= STEEP_FACTOR);
    !steep.is_empty()
}

/// The orthogonal field itself; where it turns by half a turn or nearly across an edge, the smoothest one with these matchings
/// that does not, if there is one.
pub fn evened(dual: &Dual<'_>, alpha: Vec<f64>, p: &[i32], context: &Context) -> Result<Vec<f64>> {
    let n = dual.triangles.len();
    let mut weight = dual.weight.clone();
    let mut found = Relaxed { alpha, rho: vec![0.0; n] };
    let (held, mut plan) = (vec![Some(0.0); n], None);
    for _ in 0..RELAXATION_ROUNDS {
        if !weigh_steep(dual, &found, p, &mut weight) {
            break;
        }
        context.check()?;
        found.alpha = solve(dual, &found.alpha, p, &weight, &held, &mut plan)?.alpha;
    }
    Ok(found.alpha)
}

/// The relaxed field, |ρ| ≤ `most` (radians).
pub fn relax(dual: &Dual<'_>, alpha: &[f64], p: &[i32], most: f64, context: &Context) -> Result<Relaxed> {
    let n = dual.triangles.len();
    let orthogonal = Relaxed { alpha: alpha.to_vec(), rho: vec![0.0; n] };
    let before = energy(dual, alpha, &orthogonal.rho, p);
    let mut held: Vec<Option<f64>> = vec![None; n];
    let mut weight = dual.weight.clone();
    let mut plan = None;
    for round in 1..=RELAXATION_ROUNDS {
        context.check()?;
        let mut found = solve(dual, alpha, p, &weight, &held, &mut plan)?;
        let mut beyond = 0;
        for (held, rho) in held.iter_mut().zip(&mut found.rho) {
            if held.is_none() && rho.abs() > most {
                *held = Some(most.copysign(*rho));
                beyond += 1;
            }
            *rho = rho.clamp(-most, most);
        }
        let is_steep = weigh_steep(dual, &found, p, &mut weight);
        let is_settled = !is_steep && (beyond == 0 || (round >= EXACT_ROUNDS && beyond * TRIANGLES_A_CLIP <= n));
        if is_settled && energy(dual, &found.alpha, &found.rho, p) <= before {
            return Ok(found);
        }
        if beyond == 0 && !is_steep {
            break;
        }
    }
    Ok(orthogonal)
}

/// The best field with some ρ held, for these weights of the edges.
fn solve(
    dual: &Dual<'_>,
    alpha: &[f64],
    p: &[i32],
    weight: &[f64],
    held: &[Option<f64>],
    plan: &mut Option<Plan>,
) -> Result<Relaxed> {
    let n = dual.triangles.len();
    let mut alpha_of = vec![NONE; n];
    let anchored = dual.constrained.contains(&true);
    // ρ_i is unknown i, the α follow.
    let mut count = n as u32;
    for i in 0..n {
        if !dual.constrained[i] && (anchored || i > 0) {
            alpha_of[i] = count;
            count += 1;
        }
    }
    let mut system = LeastSquares::new(count as usize);
    for e in 0..dual.edges.len() {
        let [i, j] = dual.ends(e);
        let (mut terms, mut constant) = ([(0, 0.0); 4], dual.turn[e] + f64::from(p[e]) * FRAC_PI_2);
        let mut len = 0;
        for (t, factor) in [(i, -1.0), (j, 1.0)] {
            match alpha_of[t as usize] {
                NONE => constant += factor * alpha[t as usize],
                number => {
                    terms[len] = (number, factor);
                    len += 1;
                }
            }
        }
        // Equation 4: the branch that leans in j is the second of i, or, after an odd number of quarter turns, the first.
        let mut add = |more: &[(u32, f64)]| {
            terms[len..len + more.len()].copy_from_slice(more);
            system.add(weight[e], &terms[..len + more.len()], constant);
        };
        if p[e] % 2 == 0 {
            add(&[]);
            add(&[(i, -1.0), (j, 1.0)]);
        } else {
            add(&[(j, 1.0)]);
            add(&[(i, -1.0)]);
        }
    }
    for (i, held) in (0u32..).zip(held) {
        match held {
            Some(rho) => system.add(HELD_WEIGHT, &[(i, 1.0)], -rho),
            None => system.add(ORTHOGONALITY_WEIGHT, &[(i, 1.0)], 0.0),
        }
    }
    let free = (0..n).filter(|&i| alpha_of[i] != NONE);
    for (i, (beta, weight)) in free.filter_map(|i| Some((i, dual.wanted_near(i, alpha[i])?))) {
        system.add(weight, &[(alpha_of[i], 1.0)], -beta);
    }
    // A triangle among features alone has no edge to say what its direction is.
    for (i, &number) in alpha_of.iter().enumerate().filter(|(_, number)| **number != NONE) {
        system.add(1e-9, &[(number, 1.0)], -alpha[i]);
    }
    let x = system.solve(plan)?;
    let alpha_found = |(&number, &before): (&u32, &f64)| if number == NONE { before } else { x[number as usize] };
    Ok(Relaxed { alpha: alpha_of.iter().zip(alpha).map(alpha_found).collect(), rho: x[..n].to_vec() })
}
