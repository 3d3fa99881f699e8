//! Triangles of the map that are turned over are turned back: a barrier against areas that vanish is added to what the map
//! minimises, and taken down by Newton's method under the same constraints.
//!
//! With Ĵ the derivative of the map where the frame is the unit, split into z (a turn with a factor) and w (a turn with a factor
//! of the mirror image), det Ĵ = |z|² − |w|², a triangle costs
//!
//! ```text
//! |z − 1|² + |w|² + μ ‖Ĵ‖² / χ(det Ĵ),    χ(D) = (D + √(D² + ε²)) / 2
//! ```
//!
//! The barrier is that of Garanzha, Kaporin, Kudryavtseva, Protais, Ray, Sokolov: *Foldover-free maps in 50 lines of code*, 2021.
//! It depends on |z| and |w| alone: its second derivatives are a block of two along z and w, and one number across each (as
//! those of isotropic energies in Smith, de Goes, Kim: *Analytic eigensystems for isotropic distortion energies*, 2019), so that
//! what is negative in them is left out exactly.

use super::seamless::System;
use super::tuning::{
    AREA_PROGRESS, BARRIER_WEIGHT, BARRIER_WIDTH, COST_DECREASE, LEAST_WIDTH, NEWTON_HALVINGS, NEWTON_PATIENCE,
    NEWTON_STEPS, SMALL_AREA,
};
use crate::context::Context;
use crate::error::Result;
use glam::DVec2;

/// The derivative of the map in one triangle, in the frame of the field.
#[derive(Clone, Copy)]
pub struct Derivative {
    pub z: DVec2,
    pub w: DVec2,
}

/// Gradient and second derivatives by z and w, without negative curvatures.
pub struct Model {
    pub gradient: [f64; 4],
    pub curvature: [[f64; 4]; 4],
}

impl Derivative {
    pub fn determinant(&self) -> f64 {
        self.z.length_squared() - self.w.length_squared()
    }

    /// What the triangle costs; `epsilon`: the width of the barrier.
    pub fn cost(&self, epsilon: f64) -> f64 {
        let fit = (self.z - DVec2::X).length_squared() + self.w.length_squared();
        let sum = self.z.length_squared() + self.w.length_squared();
        fit + BARRIER_WEIGHT * 2.0 * sum / Chi::new(self.determinant(), epsilon).value
    }

    pub fn model(&self, epsilon: f64) -> Model {
        let (r, s) = (self.z.length(), self.w.length());
        let along = |v: DVec2, length: f64| if length > 0.0 { v / length } else { DVec2::X };
        let (z, w) = (along(self.z, r), along(self.w, s));
        let (sum, chi) = (r * r + s * s, Chi::new(self.determinant(), epsilon));
        // 1/χ, and the first and second derivatives of −1/χ by the determinant.
        let (inverse, p, q) = (1.0 / chi.value, chi.p, chi.q);
        let across = [4.0 * inverse - 4.0 * sum * p, 4.0 * inverse + 4.0 * sum * p];
        let rr = across[0] - 16.0 * r * r * p - 8.0 * sum * r * r * q;
        let ss = across[1] + 16.0 * s * s * p - 8.0 * sum * s * s * q;
        let rs = 8.0 * sum * r * s * q;
        let along = positive([2.0 + BARRIER_WEIGHT * rr, BARRIER_WEIGHT * rs, 2.0 + BARRIER_WEIGHT * ss]);
        let across = across.map(|a| (2.0 + BARRIER_WEIGHT * a).max(LEAST_CURVATURE));
        let slope = [
            BARRIER_WEIGHT * r * (4.0 * inverse - 4.0 * sum * p),
            BARRIER_WEIGHT * s * (4.0 * inverse + 4.0 * sum * p),
        ];
        let [gz, gw] = [2.0 * (self.z - DVec2::X) + slope[0] * z, 2.0 * self.w + slope[1] * w];
        let mut curvature = [[0.0; 4]; 4];
        let (zs, ws) = (z.to_array(), w.to_array());
        let (zp, wp) = (z.perp().to_array(), w.perp().to_array());
        for i in 0..2 {
            for j in 0..2 {
                curvature[i][j] = along[0] * zs[i] * zs[j] + across[0] * zp[i] * zp[j];
                curvature[i + 2][j + 2] = along[2] * ws[i] * ws[j] + across[1] * wp[i] * wp[j];
                curvature[i][j + 2] = along[1] * zs[i] * ws[j];
                curvature[j + 2][i] = along[1] * zs[i] * ws[j];
            }
        }
        Model { gradient: [gz.x, gz.y, gw.x, gw.y], curvature }
    }
}

/// A curvature over that of the distance to the frame, which is 2: the least that is left to a model, because it is to
/// have a minimum.
const LEAST_CURVATURE: f64 = 1e-3;

/// χ, and the first and second derivatives of −1/χ.
struct Chi {
    value: f64,
    p: f64,
    q: f64,
}

impl Chi {
    fn new(d: f64, epsilon: f64) -> Self {
        let root = d.hypot(epsilon);
        // Without cancellation where d is negative.
        let value = if d >= 0.0 { 0.5 * (d + root) } else { 0.5 * epsilon * epsilon / (root - d) };
        let first = value / root;
        let second = 0.5 * epsilon * epsilon / root.powi(3);
        let p = first / (value * value);
        Chi { value, p, q: second / (value * value) - 2.0 * first * first / value.powi(3) }
    }
}

/// The symmetric matrix [a b; b c] with its eigenvalues made positive.
fn positive([a, b, c]: [f64; 3]) -> [f64; 3] {
    let (middle, half) = (0.5 * (a + c), 0.5 * (a - c));
    let radius = half.hypot(b);
    if middle - radius >= LEAST_CURVATURE {
        return [a, b, c];
    }
    let [high, low] = [middle + radius, middle - radius].map(|value| value.max(LEAST_CURVATURE));
    let turn = if radius > 0.0 { DVec2::new(half, b) / radius } else { DVec2::X };
    let (middle, radius) = (0.5 * (high + low), 0.5 * (high - low));
    [middle + radius * turn.x, radius * turn.y, middle - radius * turn.x]
}

/// Moves a map until all triangles have the area that they should at least have, or as far as that goes.
pub fn untangle(system: &System, uv: &mut Vec<f64>, context: &Context) -> Result<()> {
    let mut plan = None;
    let (mut fewest, mut largest, mut patience) = (usize::MAX, f64::NEG_INFINITY, NEWTON_PATIENCE);
    for _ in 0..NEWTON_STEPS {
        context.check()?;
        let smallest = system.smallest(uv);
        let small = system.smaller_than(SMALL_AREA, uv).count();
        tracing::debug!(target: "carreau::quad", small, smallest, "untangled");
        if small < fewest || smallest > largest + AREA_PROGRESS * largest.abs() {
            patience = NEWTON_PATIENCE;
        } else {
            patience -= 1;
        }
        (fewest, largest) = (fewest.min(small), largest.max(smallest));
        if small == 0 || patience == 0 {
            break;
        }
        let epsilon = LEAST_WIDTH.hypot(BARRIER_WIDTH * smallest.min(0.0));
        let Some(next) = system.newton(uv, epsilon, &mut plan, context)? else { break };
        if !search(system, uv, &next, epsilon) {
            break;
        }
    }
    Ok(())
}

/// Goes as far towards the next map as costs fall.
fn search(system: &System, uv: &mut Vec<f64>, next: &[f64], epsilon: f64) -> bool {
    let before = system.cost(uv, epsilon);
    let mut share = 1.0;
    for _ in 0..NEWTON_HALVINGS {
        let tried: Vec<f64> = uv.iter().zip(next).map(|(a, b)| a + share * (b - a)).collect();
        if system.cost(&tried, epsilon) < before * (1.0 - COST_DECREASE * share) {
            *uv = tried;
            return true;
        }
        share *= 0.5;
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn derivative(x: [f64; 4]) -> Derivative {
        Derivative { z: DVec2::new(x[0], x[1]), w: DVec2::new(x[2], x[3]) }
    }

    proptest! {
        #[test]
        fn models_have_the_slope_of_the_cost_and_a_minimum(
            x in prop::array::uniform4(-2.0f64..2.0),
            epsilon in 0.05f64..2.0,
            step in prop::array::uniform4(-1.0f64..1.0),
        ) {
            let model = derivative(x).model(epsilon);
            let h = 1e-6;
            for i in 0..4 {
                let moved = |by: f64| {
                    let mut x = x;
                    x[i] += by;
                    derivative(x).cost(epsilon)
                };
                let slope = (moved(h) - moved(-h)) / (2.0 * h);
                prop_assert!((slope - model.gradient[i]).abs() <= 1e-4 * (1.0 + slope.abs() + moved(0.0)));
            }
            let bent: f64 = (0..4).map(|i| (0..4).map(|j| step[i] * model.curvature[i][j] * step[j]).sum::<f64>()).sum();
            let length: f64 = step.iter().map(|s| s * s).sum();
            prop_assert!(bent >= 0.5 * LEAST_CURVATURE * length);
        }

        #[test]
        fn matrices_become_positive_and_positive_ones_stay(m in prop::array::uniform3(-3.0f64..3.0)) {
            let [a, b, c] = positive(m);
            prop_assert!(a > 0.0 && a * c - b * b > 0.0);
            if m[0] > 0.1 && m[0] * m[2] - m[1] * m[1] > 0.5 {
                prop_assert_eq!([a, b, c], m);
            }
        }
    }
}
