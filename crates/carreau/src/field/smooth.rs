//! The smoothest orthogonal field for a target rotation, by representation vectors (equation 3): z = e^{4iα},
//! min Σ w |z_j − z_i e^{4i(ω − c)}|² with z = 1 where a feature gives the direction, plus what draws it to others (`align`). The lengths of z, small beside singular
//! points, are evened out by a few steps of diffusion.

use super::dual::Dual;
use crate::context::Context;
use crate::error::Result;
use crate::mesh::NONE;
use crate::numeric::sparse::{Complex, Factor, Matrix, Plan};

/// A count: steps of diffusion, few because the lengths of z are even after some.
const DIFFUSION_STEPS: usize = 4;
/// Weight t of the masses in a step of diffusion, as a multiple of the smallest eigenvalue: well above 1, because a
/// step is to even out lengths and leave the field what it is.
const DIFFUSION_WEIGHT: f64 = 20.0;
/// A count: steps of inverse iteration for that eigenvalue, few because only its size is needed.
const EIGEN_STEPS: usize = 6;
/// A count: steps of inverse iteration for the field where no feature gives a direction, more because the eigenvector
/// is the field.
const FREE_STEPS: usize = 30;
/// A share of the mean diagonal: what is added to the diagonal where no feature gives a direction, because the matrix
/// may be singular then.
const DIAGONAL_SHIFT: f64 = 1e-6;

/// α of every triangle, in (−π/4, π/4]. The plan of elimination is the same for every ω.
pub fn smoothest(dual: &Dual<'_>, omega: &[f64], plan: &mut Option<Plan>, context: &Context) -> Result<Vec<f64>> {
    let n = dual.triangles.len();
    let mut unknown = vec![NONE; n];
    let free: Vec<u32> = (0..n as u32).filter(|&i| !dual.constrained[i as usize]).collect();
    (0u32..).zip(&free).for_each(|(k, &i)| unknown[i as usize] = k);
    if free.is_empty() {
        return Ok(vec![0.0; n]);
    }
    let system = System::new(dual, omega, &unknown, free.len());
    let mass: Vec<f64> = free.iter().map(|&i| dual.areas[i as usize].max(1e-12 * dual.areas[0])).collect();
    let is_drawn = free.iter().any(|&i| dual.wanted_near(i as usize, 0.0).is_some());
    let shift = if free.len() < n || is_drawn { 0.0 } else { DIAGONAL_SHIFT * system.mean_diagonal() };
    let mean_mass = mass.iter().sum::<f64>() / mass.len() as f64;
    let mass: Vec<f64> = mass.iter().map(|m| m / mean_mass).collect();
    let factor = system.matrix(&mass, shift).factor(plan)?;
    context.check()?;
    let (lambda, eigenvector) = smallest(&factor, &mass, if shift > 0.0 { FREE_STEPS } else { EIGEN_STEPS })?;
    context.check()?;
    let mut z = if shift > 0.0 { eigenvector } else { factor.solve(&system.rhs)? };
    // (L + t M) z ← t M z / |z|
    let t = DIFFUSION_WEIGHT * lambda;
    let diffusion = system.matrix(&mass, t).factor(plan)?;
    for _ in 0..DIFFUSION_STEPS {
        context.check()?;
        let rhs: Vec<Complex> = (0..z.len()).map(|k| unit(z[k]) * (t * mass[k]) + system.rhs[k]).collect();
        z = diffusion.solve(&rhs)?;
    }
    let mut alpha = vec![0.0; n];
    free.iter().zip(&z).for_each(|(&i, z)| alpha[i as usize] = z.im.atan2(z.re) / 4.0);
    Ok(alpha)
}

fn unit(z: Complex) -> Complex {
    let size = z.re.hypot(z.im);
    if size > 0.0 { Complex::new(z.re / size, z.im / size) } else { Complex::new(1.0, 0.0) }
}

/// The smallest eigenvalue of the matrix relative to the masses, and its vector, by inverse iteration.
fn smallest(factor: &Factor<Complex>, mass: &[f64], steps: usize) -> Result<(f64, Vec<Complex>)> {
    // Some vector without symmetry.
    let mut x: Vec<Complex> = (0..mass.len()).map(|k| Complex::new(1.0, (k % 7) as f64 / 7.0)).collect();
    let mut lambda = 1.0;
    for _ in 0..steps {
        let size = x.iter().zip(mass).map(|(x, m)| m * (x.re * x.re + x.im * x.im)).sum::<f64>().sqrt();
        let rhs: Vec<Complex> = x.iter().zip(mass).map(|(x, m)| *x * (m / size)).collect();
        x = factor.solve(&rhs)?;
        let product: f64 = x.iter().zip(&rhs).map(|(x, r)| x.re * r.re + x.im * r.im).sum();
        lambda = 1.0 / product.max(f64::MIN_POSITIVE);
    }
    Ok((lambda, x))
}

/// The Hermitian matrix of the energy over the free triangles, and the right side of the others.
struct System {
    n: usize,
    diagonal: Vec<f64>,
    beside: Vec<(u32, u32, Complex)>,
    rhs: Vec<Complex>,
}

impl System {
    fn new(dual: &Dual<'_>, omega: &[f64], unknown: &[u32], n: usize) -> Self {
        let (mut diagonal, mut beside, mut rhs) = (vec![0.0; n], Vec::new(), vec![Complex::new(0.0, 0.0); n]);
        for e in 0..dual.edges.len() {
            let [i, j] = dual.ends(e).map(|t| unknown[t as usize]);
            let (w, (sin, cos)) = (dual.weight[e], (4.0 * (omega[e] - dual.turn[e])).sin_cos());
            // z_j = turn z_i
            let turn = Complex::new(cos, sin);
            for k in [i, j].into_iter().filter(|&k| k != NONE) {
                diagonal[k as usize] += w;
            }
            match (i != NONE, j != NONE) {
                (true, true) if j > i => beside.push((j, i, turn * -w)),
                (true, true) => beside.push((i, j, turn.conj() * -w)),
                (true, false) => rhs[i as usize] += turn.conj() * w,
                (false, true) => rhs[j as usize] += turn * w,
                (false, false) => {}
            }
        }
        for (i, &k) in unknown.iter().enumerate().filter(|(_, k)| **k != NONE) {
            if let Some((_, weight)) = dual.wanted_near(i, 0.0) {
                diagonal[k as usize] += weight;
                rhs[k as usize] += dual.wanted[i];
            }
        }
        System { n, diagonal, beside, rhs }
    }

    fn mean_diagonal(&self) -> f64 {
        self.diagonal.iter().sum::<f64>() / self.n.max(1) as f64
    }

    /// L + t M.
    fn matrix(&self, mass: &[f64], t: f64) -> Matrix<Complex> {
        let mut matrix = Matrix::new(self.n);
        for k in 0..self.n {
            // A triangle among features alone has no edge; any direction does.
            let own = if self.diagonal[k] > 0.0 { self.diagonal[k] } else { 1.0 };
            matrix.add(k as u32, k as u32, Complex::new(own + t * mass[k], 0.0));
        }
        self.beside.iter().for_each(|&(row, column, value)| matrix.add(row, column, value));
        matrix
    }
}
