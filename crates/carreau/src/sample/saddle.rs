//! A hyperbolic paraboloid over a square: an open height field with negative Gaussian curvature everywhere.

use super::builder::Builder;
use super::limits::{affordable, at_least, positive};
use super::model::Model;
use super::shape::{Measure, Shape};
use crate::error::Result;
use glam::DVec3;
use std::f64::consts::FRAC_PI_4;

/// The graph of `z = (k/2)(x² − y²)` over the square `[−side/2, side/2]²`, `divisions` ≥ 1 quads along a side.
///
/// At the origin the principal curvatures are ±k, along x and y. Label 0: the graph (freeform).
///
/// # Errors
/// [`Error::Options`](crate::Error::Options) for sizes that make no such model, or one of too many triangles.
pub fn saddle(side: f64, k: f64, divisions: u32) -> Result<Model> {
    positive("side", side)?;
    positive("curvature", k)?;
    at_least("divisions", divisions, 1)?;
    affordable(2.0 * f64::from(divisions).powi(2))?;
    let mut b = Builder::default();
    let label = b.shape("saddle", Shape::Freeform);
    let place = |i: u32| side * (f64::from(i) / f64::from(divisions) - 0.5);
    let rows: Vec<Vec<u32>> = (0..=divisions)
        .map(|j| {
            let y = place(j);
            b.points((0..=divisions).map(place).map(|x| DVec3::new(x, y, 0.5 * k * (x * x - y * y))))
        })
        .collect();
    for pair in rows.windows(2) {
        b.band(label, &pair[0], &pair[1]);
    }
    b.finish(Measure::open(area(side, k)))
}

/// Area of the graph: ∫∫ √(1 + k²(x² + y²)).
///
/// With `r` = side/2 and `c` = kr it is 8r² times the integral over the triangle 0 ≤ y ≤ x ≤ 1 of √(1 + c²(x² + y²)). In
/// polar coordinates, with s = tan θ and a² = 1 + c²,
///
/// ∫₀¹ [(a² + c²s²)^{3/2} / (1 + s²) ds − π/4] / (3c²), and (a² + c²s²)/(1 + s²) = c² + 1/(1 + s²) splits the rest into
/// elementary integrals.
fn area(side: f64, k: f64) -> f64 {
    let (r, c) = (side / 2.0, k * side / 2.0);
    let a = 1f64.hypot(c);
    let q = a.hypot(c);
    let arc = (c / a).asinh();
    let root = 0.5 * q + a * a / (2.0 * c) * arc;
    8.0 * r * r * (c * c * root + c * arc + (1.0 / q).atan() - FRAC_PI_4) / (3.0 * c * c)
}
