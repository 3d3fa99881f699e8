//! Limited-memory BFGS (Nocedal, Wright, "Numerical Optimization", algorithm 7.4) over points in space.
//!
//! The function may be infinite outside the set it is minimised in: steps that leave the set are shortened, so the
//! iteration never does. Sums run over fixed chunks: the same bytes for any number of threads.

use crate::error::Result;
use glam::DVec3;
use rayon::prelude::*;
use std::collections::VecDeque;

/// Pairs of steps and gradient changes that are remembered.
const MEMORY: usize = 8;
/// Points per chunk of a sum, and of any task.
const CHUNK: usize = 4096;
/// Sufficient decrease (Armijo).
const DECREASE: f64 = 1e-4;
/// A step moves no point farther than this many of its scales.
const FARTHEST: f64 = 0.5;

/// When to stop.
#[derive(Debug, Clone, Copy)]
pub struct Stop {
    /// Largest number of iterations.
    pub iterations: usize,
    /// Stops when ten iterations together lessen the value by less than this share.
    pub decrease: f64,
}

/// Minimises a function from `x` on, in place; returns its value. Where it is infinite at `x`, nothing is done. `scale` is the
/// length over which the function changes at each point (zero: the point is fixed). `function` fills the gradient and returns
/// the value, or infinity.
///
/// # Errors
/// [`Error::Cancelled`](crate::Error::Cancelled), [`Error::Deadline`](crate::Error::Deadline).
pub fn minimise(
    x: &mut Vec<DVec3>,
    scale: &[f64],
    stop: Stop,
    mut function: impl FnMut(&[DVec3], &mut [DVec3]) -> Result<f64>,
) -> Result<f64> {
    let n = x.len();
    let mut gradient = vec![DVec3::ZERO; n];
    let mut value = function(x, &mut gradient)?;
    if !value.is_finite() {
        // From outside of the set no step is better than another.
        return Ok(value);
    }
    let mut memory: VecDeque<Pair> = VecDeque::with_capacity(MEMORY);
    let mut next = x.clone();
    let mut next_gradient = gradient.clone();
    let mut before = value;
    for iteration in 0..stop.iterations {
        let mut direction = two_loops(&gradient, scale, &memory);
        let mut slope = dot(&direction, &gradient);
        if !(slope < 0.0) {
            memory.clear();
            direction = gradient.par_iter().with_min_len(CHUNK).zip(scale).map(|(g, s)| -*g * s * s).collect();
            slope = dot(&direction, &gradient);
        }
        let reach = reach(&direction, scale);
        if !(slope < 0.0) || !reach.is_finite() || reach == 0.0 {
            break;
        }
        let step = (FARTHEST / reach).min(if memory.is_empty() { 0.1 / reach } else { 1.0 });
        let allowed = |step: f64| value + DECREASE * step * slope;
        let found = line_search(x, &direction, step, allowed, &mut next, |next| function(next, &mut next_gradient))?;
        let Some(there) = found else {
            if memory.is_empty() {
                break;
            }
            memory.clear();
            continue;
        };
        let pair = Pair::new(x, &next, &gradient, &next_gradient, scale);
        std::mem::swap(x, &mut next);
        std::mem::swap(&mut gradient, &mut next_gradient);
        value = there;
        if let Some(pair) = pair {
            if memory.len() == MEMORY {
                memory.pop_front();
            }
            memory.push_back(pair);
        }
        if iteration % 10 == 9 {
            if before - value <= stop.decrease * value.abs() {
                break;
            }
            before = value;
        }
    }
    Ok(value)
}

/// Goes along a direction, first by `step`, then by ever smaller ones, until the function is `allowed` there; the value at
/// `next`, the point where that is so.
fn line_search(
    x: &[DVec3],
    direction: &[DVec3],
    mut step: f64,
    allowed: impl Fn(f64) -> f64,
    next: &mut [DVec3],
    mut function: impl FnMut(&[DVec3]) -> Result<f64>,
) -> Result<Option<f64>> {
    for _ in 0..30 {
        next.par_iter_mut().with_min_len(CHUNK).zip(x).zip(direction).for_each(|((y, x), d)| *y = *x + *d * step);
        let there = function(next)?;
        if there <= allowed(step) {
            return Ok(Some(there));
        }
        step *= if there.is_finite() { 0.5 } else { 0.3 };
    }
    Ok(None)
}

/// A step, the change of the gradient over it, and 1 / (their product).
struct Pair {
    step: Vec<DVec3>,
    change: Vec<DVec3>,
    rho: f64,
    /// Product over the scaled square of the change: the size of the first guess of the inverse Hessian.
    gamma: f64,
}

impl Pair {
    /// `None` where the function is not convex along the step.
    fn new(x: &[DVec3], next: &[DVec3], g: &[DVec3], next_g: &[DVec3], scale: &[f64]) -> Option<Pair> {
        let step: Vec<DVec3> = next.par_iter().with_min_len(CHUNK).zip(x).map(|(a, b)| *a - *b).collect();
        let change: Vec<DVec3> = next_g.par_iter().with_min_len(CHUNK).zip(g).map(|(a, b)| *a - *b).collect();
        let product = dot(&step, &change);
        let square = sum(change.len(), |k| change[k].length_squared() * scale[k] * scale[k]);
        let length = sum(step.len(), |k| step[k].length_squared());
        (product > 1e-300 && square > 0.0 && length > 0.0 && product.is_finite()).then(|| Pair {
            step,
            change,
            rho: 1.0 / product,
            gamma: product / square,
        })
    }
}

/// The direction −H g by the two-loop recursion.
fn two_loops(gradient: &[DVec3], scale: &[f64], memory: &VecDeque<Pair>) -> Vec<DVec3> {
    let mut q: Vec<DVec3> = gradient.par_iter().with_min_len(CHUNK).map(|g| -*g).collect();
    let mut alphas = Vec::with_capacity(MEMORY);
    for pair in memory.iter().rev() {
        let alpha = pair.rho * dot(&pair.step, &q);
        q.par_iter_mut().with_min_len(CHUNK).zip(&pair.change).for_each(|(q, y)| *q -= *y * alpha);
        alphas.push(alpha);
    }
    let gamma = memory.back().map_or(1.0, |pair| pair.gamma);
    q.par_iter_mut().with_min_len(CHUNK).zip(scale).for_each(|(q, s)| *q *= gamma * s * s);
    for (pair, alpha) in memory.iter().zip(alphas.into_iter().rev()) {
        let beta = pair.rho * dot(&pair.change, &q);
        q.par_iter_mut().with_min_len(CHUNK).zip(&pair.step).for_each(|(q, s)| *q += *s * (alpha - beta));
    }
    q
}

/// The farthest that a direction moves a point, in its scale.
fn reach(direction: &[DVec3], scale: &[f64]) -> f64 {
    let share = |(d, s): (&DVec3, &f64)| if *s > 0.0 { d.length() / s } else { 0.0 };
    direction.par_iter().with_min_len(CHUNK).zip(scale).map(share).reduce(|| 0.0, f64::max)
}

fn dot(a: &[DVec3], b: &[DVec3]) -> f64 {
    sum(a.len(), |k| a[k].dot(b[k]))
}

/// A sum in a fixed order.
fn sum(n: usize, term: impl Fn(usize) -> f64 + Sync) -> f64 {
    let chunk = |c: usize| (c * CHUNK..((c + 1) * CHUNK).min(n)).map(&term).sum::<f64>();
    (0..n.div_ceil(CHUNK)).into_par_iter().map(chunk).collect::<Vec<f64>>().iter().sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rosenbrock's valley in every pair (x, y), a parabola in z.
    fn valley(x: &[DVec3], gradient: &mut [DVec3]) -> f64 {
        let mut value = 0.0;
        for (p, g) in x.iter().zip(gradient) {
            let (a, b) = (1.0 - p.x, p.y - p.x * p.x);
            value += a * a + 100.0 * b * b + p.z * p.z;
            *g = DVec3::new(-2.0 * a - 400.0 * p.x * b, 200.0 * b, 2.0 * p.z);
        }
        value
    }

    #[test]
    fn the_valley_is_followed_to_its_end() {
        let mut x = vec![DVec3::new(-1.2, 1.0, 3.0), DVec3::new(0.0, 2.0, -1.0)];
        let stop = Stop { iterations: 400, decrease: 0.0 };
        let value = minimise(&mut x, &[1.0, 1.0], stop, |x, g| Ok(valley(x, g))).unwrap();
        assert!(value < 1e-12, "{value}");
        assert!(x.iter().all(|p| p.distance(DVec3::new(1.0, 1.0, 0.0)) < 1e-5));
    }

    #[test]
    fn infinite_values_are_never_entered_and_fixed_points_stay() {
        // The minimum of (x − 2)² − log x-like barrier lies inside x < 1.
        let mut x = vec![DVec3::new(0.1, 0.0, 0.0), DVec3::splat(7.0)];
        let stop = Stop { iterations: 100, decrease: 0.0 };
        let function = |x: &[DVec3], g: &mut [DVec3]| {
            let t = x[0].x;
            g[0] = DVec3::new(2.0 * (t - 2.0) + 0.01 / (1.0 - t), 0.0, 0.0);
            g[1] = DVec3::ONE;
            Ok(if t < 1.0 { (t - 2.0).powi(2) - 0.01 * (1.0 - t).ln() } else { f64::INFINITY })
        };
        minimise(&mut x, &[1.0, 0.0], stop, function).unwrap();
        assert!(x[0].x < 1.0 && x[0].x > 0.98);
        assert_eq!(x[1], DVec3::splat(7.0));
        // From outside nothing moves: there every step would do.
        let mut x = vec![DVec3::new(3.0, 0.0, 0.0), DVec3::ZERO];
        let start = x.clone();
        assert_eq!(minimise(&mut x, &[1.0, 0.0], stop, function).unwrap(), f64::INFINITY);
        assert_eq!(x, start);
    }
}
