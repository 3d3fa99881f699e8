//! The least scaled Jacobian itself, as a smooth function.
//!
//! The energy of a cell (energy.rs) is least for a box. A cell that cannot become one, for example a wedge in a narrow cleft, has
//! a large energy whatever its angles, and the worst energy is not where the worst angle is. Where that energy is as small as it
//! gets, patches with poor cells minimise
//!
//! E = Σ exp(β (s₀ − s)) over all corners, s their scaled Jacobians, s₀ a value near to the least of them,
//!
//! which the worst corners make up nearly alone: β (s₀ − s) is large for them only.

use crate::geometry::hexes::{CORNERS, Corners};
use glam::DVec3;

/// E of one cell, and its gradient at the corners.
pub fn corner_energy(p: &Corners, beta: f64, usual: f64) -> (f64, [DVec3; 8]) {
    let (mut value, mut gradient) = (0.0, [DVec3::ZERO; 8]);
    for (c, ends) in CORNERS.into_iter().enumerate() {
        let edges = ends.map(|n| p[n] - p[c]);
        let lengths = edges.map(|e| e.length().max(f64::MIN_POSITIVE));
        let unit: [DVec3; 3] = std::array::from_fn(|k| edges[k] / lengths[k]);
        let s = unit[0].dot(unit[1].cross(unit[2]));
        let share = (beta * (usual - s)).exp();
        value += share;
        for k in 0..3 {
            // The slope of s along an edge's end.
            let slope = (unit[(k + 1) % 3].cross(unit[(k + 2) % 3]) - unit[k] * s) / lengths[k];
            let pull = slope * (-beta * share);
            gradient[ends[k]] += pull;
            gradient[c] -= pull;
        }
    }
    (value, gradient)
}

#[cfg(test)]
mod tests {
    use super::super::slopes::is_slope;
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_gradient_is_the_slope(moves in prop::collection::vec(-0.4f64..0.4, 24), beta in 1.0f64..8.0) {
            is_slope(&moves, |p| corner_energy(p, beta, 0.3))?;
        }
    }
}
