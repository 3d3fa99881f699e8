//! Relaxation of orthogonality, equations 4 and 5: the second branch may lean by ρ. The matchings stay as they are, so the
//! numbers of quads do, too.
//!
//! The paper clips |ρ| afterwards, which can raise the energy. Here a ρ beyond the limit is held there and the others are
//! solved for again, until none is beyond it; what would still be dearer than the orthogonal field is not taken.

use super::dual::Dual;
use super::matching::rotation;
use super::sparse::LeastSquares;
use crate::context::Context;
use crate::error::Result;
use crate::mesh::NONE;

/// ε of the term that favours orthogonality.
const EPSILON: f64 = 1e-2;
const MOST_ROUNDS: usize = 12;

/// A field whose second branch is at α + π/2 + ρ.
pub struct Relaxed {
    pub alpha: Vec<f64>,
    pub rho: Vec<f64>,
}

/// Σ w (r⁰² + r¹²).
pub fn energy(dual: &Dual<'_>, alpha: &[f64], rho: &[f64], p: &[i32]) -> f64 {
    let of = |e: u32| {
        let [i, j] = dual.ends(e as usize).map(|t| rho[t as usize]);
        let r = rotation(dual, alpha, p, e);
        let (r0, r1) = if p[e as usize] % 2 == 0 { (r, r - i + j) } else { (r + j, r - i) };
        dual.weight[e as usize] * (r0 * r0 + r1 * r1)
    };
    (0..dual.edges.len() as u32).map(of).sum()
}

/// The relaxed field, |ρ| ≤ `most` (radians).
pub fn relax(dual: &Dual<'_>, alpha: &[f64], p: &[i32], most: f64, context: &Context) -> Result<Relaxed> {
    let n = dual.triangles.len();
    let orthogonal = Relaxed { alpha: alpha.to_vec(), rho: vec![0.0; n] };
    let before = energy(dual, alpha, &orthogonal.rho, p);
    let mut held: Vec<Option<f64>> = vec![None; n];
    for _ in 0..MOST_ROUNDS {
        context.check()?;
        let found = solve(dual, alpha, p, &held)?;
        let mut beyond = false;
        for (held, &rho) in held.iter_mut().zip(&found.rho) {
            if held.is_none() && rho.abs() > most {
                *held = Some(most.copysign(rho));
                beyond = true;
            }
        }
        if !beyond {
            let cheaper = energy(dual, &found.alpha, &found.rho, p) <= before;
            return Ok(if cheaper { found } else { orthogonal });
        }
    }
    Ok(orthogonal)
}

/// The best field with some ρ held.
fn solve(dual: &Dual<'_>, alpha: &[f64], p: &[i32], held: &[Option<f64>]) -> Result<Relaxed> {
    let n = dual.triangles.len();
    let mut unknown = [vec![NONE; n], vec![NONE; n]];
    let mut count = 0u32;
    let anchored = dual.constrained.contains(&true);
    for i in 0..n {
        let free = [!dual.constrained[i] && (anchored || i > 0), held[i].is_none()];
        for (list, _) in unknown.iter_mut().zip(free).filter(|(_, free)| *free) {
            list[i] = count;
            count += 1;
        }
    }
    let [alpha_of, rho_of] = &unknown;
    let mut system = LeastSquares::new(count as usize);
    let mut terms = Vec::with_capacity(4);
    let mut add = |weight: f64, form: &[(bool, u32, f64)], constant: f64| {
        terms.clear();
        let mut constant = constant;
        for &(is_rho, i, factor) in form.iter().filter(|f| f.2 != 0.0) {
            let (number, value) = match is_rho {
                true => (rho_of[i as usize], held[i as usize].unwrap_or(0.0)),
                false => (alpha_of[i as usize], alpha[i as usize]),
            };
            if number == NONE { constant += factor * value } else { terms.push((number, factor)) }
        }
        system.add(weight, &terms, constant);
    };
    for e in 0..dual.edges.len() {
        let [i, j] = dual.ends(e);
        let c = dual.turn[e] + f64::from(p[e]) * std::f64::consts::FRAC_PI_2;
        let odd = f64::from(p[e].rem_euclid(2));
        let both = [(false, i, -1.0), (false, j, 1.0)];
        add(dual.weight[e], &[both[0], both[1], (true, j, odd)], c);
        add(dual.weight[e], &[both[0], both[1], (true, i, -1.0), (true, j, 1.0 - odd)], c);
    }
    (0..n as u32).for_each(|i| add(EPSILON, &[(true, i, 1.0)], 0.0));
    // A triangle among features alone has no edge to say what its direction is.
    (0..n as u32).for_each(|i| add(1e-9, &[(false, i, 1.0)], -alpha[i as usize]));
    let x = system.solve()?;
    let value = |number: u32, other: f64| if number == NONE { other } else { x[number as usize] };
    Ok(Relaxed {
        alpha: (0..n).map(|i| value(alpha_of[i], alpha[i])).collect(),
        rho: (0..n).map(|i| value(rho_of[i], held[i].unwrap_or(0.0))).collect(),
    })
}
