//! Compares a gradient with differences of the value, for tests.

use crate::geometry::hexes::Corners;
use glam::DVec3;
use proptest::prelude::*;

/// The corners of the unit cube.
pub fn unit_cube() -> Corners {
    let unit = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]];
    unit.map(|c: [i32; 3]| DVec3::from(c.map(f64::from)))
}

/// For the unit cube with its corners moved by 24 numbers: whether what `of` says of a cell is a value and its gradient.
pub fn is_slope(moves: &[f64], of: impl Fn(&Corners) -> (f64, [DVec3; 8])) -> Result<(), TestCaseError> {
    let mut p = unit_cube();
    p.iter_mut().enumerate().for_each(|(k, q)| *q += DVec3::from_slice(&moves[3 * k..3 * k + 3]));
    let (value, gradient) = of(&p);
    let step = 1e-6;
    for corner in 0..8 {
        for axis in 0..3 {
            let at = |by: f64| {
                let mut q = p;
                q[corner][axis] += by;
                of(&q).0
            };
            let slope = (at(step) - at(-step)) / (2.0 * step);
            let given = gradient[corner][axis];
            prop_assert!((slope - given).abs() < 1e-5 * (1.0 + value + slope.abs()), "{} {}", slope, given);
        }
    }
    Ok(())
}
