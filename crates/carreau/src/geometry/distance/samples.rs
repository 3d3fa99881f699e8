//! Samples spread evenly over a surface.

use super::target::Target;
use crate::geometry::summary::sum;
use glam::DVec3;

/// A point on a surface and the triangle it lies on.
#[derive(Clone, Copy)]
pub struct Sample {
    pub(super) point: DVec3,
    pub(super) triangle: u32,
}

/// Samples spread evenly by area: sample k lies where the running total of the areas reaches (k + ½) / n, so that every
/// triangle gets its share to within one. In the triangle it is placed by the R2 sequence (Roberts 2018, "The
/// Unreasonable Effectiveness of Quasirandom Sequences"), folded from the square. Empty where nothing has an area. Returns how far
/// they are apart, too.
pub fn spread_samples(surface: &Target, n: usize) -> (Vec<Sample>, f64) {
    // Areas are doubled, and so is their total.
    let areas = surface.areas();
    let total = sum(&areas);
    let mut samples = Vec::with_capacity(if total > 0.0 { n } else { 0 });
    let mut running = 0.0;
    for (triangle, area) in (0u32..).zip(areas) {
        running += area;
        while samples.len() < n && (samples.len() as f64 + 0.5) * total <= running * n as f64 {
            let [a, b, c] = surface.corners(triangle);
            let (u, v) = r2(samples.len());
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            samples.push(Sample { point: a + u * (b - a) + v * (c - a), triangle });
        }
    }
    let apart = (0.5 * total / samples.len() as f64).sqrt();
    (samples, apart)
}

/// Point `k` of the R2 sequence in the unit square; its steps are the powers of the inverse of the plastic number.
pub fn r2(k: usize) -> (f64, f64) {
    const STEPS: (f64, f64) = (0.754_877_666_246_692_7, 0.569_840_290_998_053_3);
    ((0.5 + k as f64 * STEPS.0).fract(), (0.5 + k as f64 * STEPS.1).fract())
}
