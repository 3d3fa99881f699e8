//! Small dense non-linear least squares: Levenberg–Marquardt for at most a handful of parameters.
//!
//! Source: Marquardt, "An Algorithm for Least-Squares Estimation of Nonlinear Parameters", J. SIAM 11 (1963): the normal
//! equations (H + λ diag H) step = −g, with H = Σ w j jᵀ and g = Σ w r j over the residuals r and their derivatives j.
//! The damping λ falls by a fixed factor after a step that lowered the cost Σ w r² and rises after one that did not.
//!
//! The state need not be a vector: a step is taken in a chart around the state, which the problem supplies, so
//! directions and frames need neither constraints nor redundant parameters. A trial point is linearised at once, since
//! most trials are accepted; that makes one pass over the data per step. Everything lives on the stack.

use std::array::from_fn;

/// Damping of the first step, relative to the diagonal.
const FIRST_DAMPING: f64 = 1e-4;
/// Factor on the damping after a step that lowered the cost.
const DAMPING_AFTER_SUCCESS: f64 = 0.1;
/// Factor on the damping after one that did not.
const DAMPING_AFTER_FAILURE: f64 = 10.0;
/// Damping below which it is lost in rounding.
const SMALLEST_DAMPING: f64 = 1e-14;
/// Damping above which the step is lost in rounding.
const LARGEST_DAMPING: f64 = 1e8;

/// The quadratic model of a sum of squares around a state.
#[derive(Debug, Clone, Copy)]
pub struct System<const N: usize> {
    /// Sum of the weighted squared residuals.
    pub cost: f64,
    gradient: [f64; N],
    /// Lower triangle of H.
    hessian: [[f64; N]; N],
}

impl<const N: usize> System<N> {
    fn new() -> Self {
        System { cost: 0.0, gradient: [0.0; N], hessian: [[0.0; N]; N] }
    }

    /// Adds one residual with its derivatives by the parameters of the chart.
    #[inline]
    pub fn add(&mut self, residual: f64, row: &[f64; N], weight: f64) {
        self.cost += weight * residual * residual;
        for i in 0..N {
            let scaled = weight * row[i];
            self.gradient[i] += scaled * residual;
            for j in 0..=i {
                self.hessian[i][j] += scaled * row[j];
            }
        }
    }

    /// The damped Gauss–Newton step. The matrix is scaled to a unit diagonal first, so that the pivots of parameters
    /// of different units compare; a parameter without effect stays where it is.
    fn step(&self, damping: f64) -> Option<[f64; N]> {
        let scale: [f64; N] =
            from_fn(|i| if self.hessian[i][i] > 0.0 { self.hessian[i][i].sqrt().recip() } else { 0.0 });
        let matrix: [[f64; N]; N] = from_fn(|i| {
            from_fn(|j| if i == j { 1.0 + damping } else { self.hessian[i.max(j)][i.min(j)] * scale[i] * scale[j] })
        });
        let solution: [f64; N] = solve_cholesky(&matrix, &from_fn(|i| -self.gradient[i] * scale[i]))?;
        Some(from_fn(|i| solution[i] * scale[i]))
    }

    /// How much the quadratic model promises the cost to fall along a step.
    fn promise(&self, step: &[f64; N]) -> f64 {
        let mut fall = 0.0;
        for i in 0..N {
            let product: f64 = (0..N).map(|j| self.hessian[i.max(j)][i.min(j)] * step[j]).sum();
            fall -= step[i] * (2.0 * self.gradient[i] + product);
        }
        fall
    }
}

/// A sum of squares over states that are moved in charts of `N` parameters.
pub trait Problem<const N: usize> {
    /// What is looked for.
    type State: Copy;
    /// Adds every residual, with its derivatives by the chart around the state.
    fn linearise(&self, state: &Self::State, system: &mut System<N>);
    /// The state that a step of the chart leads to.
    fn moved(&self, state: &Self::State, step: &[f64; N]) -> Self::State;
}

/// When to stop.
#[derive(Debug, Clone, Copy)]
pub struct Stop {
    /// Most trial steps.
    pub iterations: usize,
    /// A cost that leaves nothing to gain, for example the rounding of the data.
    pub floor: f64,
    /// Stop when a step promises to lower the cost by less than this share.
    pub gain: f64,
}

/// The best state found and its cost; `None` where the cost of the start is not finite.
pub fn minimise<const N: usize, P: Problem<N>>(problem: &P, start: P::State, stop: Stop) -> Option<(P::State, f64)> {
    let linearised = |state: &P::State| {
        let mut system = System::new();
        problem.linearise(state, &mut system);
        system
    };
    let (mut state, mut system) = (start, linearised(&start));
    let mut damping = FIRST_DAMPING;
    for _ in 0..stop.iterations {
        if !(system.cost > stop.floor && damping < LARGEST_DAMPING) {
            break;
        }
        let Some(step) = system.step(damping) else {
            damping *= DAMPING_AFTER_FAILURE;
            continue;
        };
        if system.promise(&step) <= stop.gain * system.cost {
            break;
        }
        let trial = problem.moved(&state, &step);
        let trial_system = linearised(&trial);
        if trial_system.cost < system.cost {
            (state, system) = (trial, trial_system);
            damping = (damping * DAMPING_AFTER_SUCCESS).max(SMALLEST_DAMPING);
        } else {
            damping *= DAMPING_AFTER_FAILURE;
        }
    }
    system.cost.is_finite().then_some((state, system.cost))
}

/// Solves a symmetric positive definite system by Cholesky factorisation; `None` where the matrix is not positive definite
/// to the rounding of its diagonal.
pub fn solve_cholesky<const N: usize>(matrix: &[[f64; N]; N], rhs: &[f64; N]) -> Option<[f64; N]> {
    let (mut l, mut x) = (*matrix, *rhs);
    for i in 0..N {
        for j in 0..=i {
            let known: f64 = (0..j).map(|k| l[i][k] * l[j][k]).sum();
            let rest = l[i][j] - known;
            if j < i {
                l[i][j] = rest / l[j][j];
            } else if rest > f64::EPSILON * matrix[i][i] {
                l[i][i] = rest.sqrt();
            } else {
                return None;
            }
        }
        let known: f64 = (0..i).map(|k| l[i][k] * x[k]).sum();
        x[i] = (x[i] - known) / l[i][i];
    }
    for i in (0..N).rev() {
        let known: f64 = (i + 1..N).map(|k| l[k][i] * x[k]).sum();
        x[i] = (x[i] - known) / l[i][i];
    }
    x.iter().all(|v| v.is_finite()).then_some(x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const STOP: Stop = Stop { iterations: 100, floor: 1e-30, gain: 1e-12 };

    /// y = a exp(b x)
    struct Exponential(Vec<(f64, f64)>);

    impl Problem<2> for Exponential {
        type State = [f64; 2];
        fn linearise(&self, [a, b]: &[f64; 2], system: &mut System<2>) {
            for (x, y) in &self.0 {
                let e = (b * x).exp();
                system.add(a * e - y, &[e, a * x * e], 1.0);
            }
        }
        fn moved(&self, [a, b]: &[f64; 2], step: &[f64; 2]) -> [f64; 2] {
            [a + step[0], b + step[1]]
        }
    }

    /// Rosenbrock's valley as two residuals.
    struct Valley;

    impl Problem<2> for Valley {
        type State = [f64; 2];
        fn linearise(&self, [x, y]: &[f64; 2], system: &mut System<2>) {
            system.add(10.0 * (y - x * x), &[-20.0 * x, 10.0], 1.0);
            system.add(1.0 - x, &[-1.0, 0.0], 1.0);
        }
        fn moved(&self, [x, y]: &[f64; 2], step: &[f64; 2]) -> [f64; 2] {
            [x + step[0], y + step[1]]
        }
    }

    proptest! {
        #[test]
        fn exact_samples_give_their_parameters(a in 0.5f64..3.0, b in -2f64..2.0) {
            let samples = (0..8).map(|k| f64::from(k) / 7.0).map(|x| (x, a * (b * x).exp())).collect();
            let ([found_a, found_b], cost) = minimise(&Exponential(samples), [1.0, 0.0], STOP).unwrap();
            prop_assert!((found_a - a).abs() < 1e-10 && (found_b - b).abs() < 1e-10 && cost < 1e-24);
        }

        #[test]
        fn the_valley_is_followed_to_its_end(x in -3f64..3.0, y in -3f64..3.0) {
            let ([x, y], _) = minimise(&Valley, [x, y], STOP).unwrap();
            prop_assert!((x - 1.0).abs() < 1e-9 && (y - 1.0).abs() < 1e-9);
        }

        #[test]
        fn solutions_satisfy_the_system(rows in prop::array::uniform4(prop::array::uniform4(-1f64..1.0)),
                                        rhs in prop::array::uniform4(-1f64..1.0)) {
            // R Rᵀ + 1 is positive definite.
            let dot = |i: usize, j: usize| (0..4).map(|k| rows[i][k] * rows[j][k]).sum::<f64>();
            let matrix = from_fn(|i| from_fn(|j| dot(i, j) + f64::from(u8::from(i == j))));
            let x: [f64; 4] = solve_cholesky(&matrix, &rhs).unwrap();
            for i in 0..4 {
                let product: f64 = (0..4).map(|j| matrix[i][j] * x[j]).sum();
                prop_assert!((product - rhs[i]).abs() < 1e-13);
            }
        }

        #[test]
        fn a_stopped_search_is_no_worse_than_its_start(x in -3f64..3.0, y in -3f64..3.0, iterations in 0usize..6) {
            let cost = |[x, y]: [f64; 2]| 100.0 * (y - x * x).powi(2) + (1.0 - x).powi(2);
            let (end, reported) = minimise(&Valley, [x, y], Stop { iterations, ..STOP }).unwrap();
            prop_assert!(cost(end) <= cost([x, y]) && (cost(end) - reported).abs() <= 1e-9 * reported);
        }
    }

    #[test]
    fn impossible_requests_are_refused() {
        assert!(solve_cholesky(&[[1.0, 2.0], [2.0, 1.0]], &[1.0, 1.0]).is_none());
        assert!(solve_cholesky(&[[1.0, 1.0], [1.0, 1.0]], &[1.0, 1.0]).is_none());
        assert!(minimise(&Exponential(vec![(0.0, f64::NAN)]), [1.0, 0.0], STOP).is_none());
    }
}
