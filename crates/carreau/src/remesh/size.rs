//! The size map: how long an edge should be at every vertex, and lengths measured by it.
//!
//! The size is h = α r, α = 2 sin θ, where r is the smallest principal radius (paper, the remark in section 3): a chord
//! that stands at the angle θ to the tangent of a circle of radius r has the length 2 r sin θ. Along an edge the size is
//! linear, so that the length of AB is the integral of 1/h:
//!
//! l(AB) = ‖AB‖ ln(h_B / h_A) / (h_B − h_A)
//!
//! Gradation: with a linear size the ratio of sizes over one unit of length, (h_B / h_A)^(1/l), is exp(|h_B − h_A| / ‖AB‖).
//! To keep it below β (the H-shock) is to keep |h_B − h_A| ≤ ‖AB‖ ln β: the largest such map below a given one is the
//! lower envelope of cones of that slope. It is found from the smallest sizes upwards, as shortest paths are; it does not
//! depend on the order of anything.

use super::buckets::Buckets;
use super::rings::Rings;
use crate::context::Context;
use crate::error::Result;
use glam::DVec3;

/// Buckets per octave of size, as a power of two: fewer go back to a vertex more often.
const SIZE_BITS: u32 = 5;
/// Number of octaves below the largest size within which all sizes lie.
const SIZE_OCTAVES: u16 = 24;

/// Length of an edge of Euclidean length `d` between two sizes.
#[inline]
pub fn metric_length(d: f64, a: f64, b: f64) -> f64 {
    // 2 artanh(x) = ln((1 + x) / (1 − x)), and its series where that is exact enough.
    let x = (b - a) / (a + b);
    let x2 = x * x;
    let mean = if x2 < 0.04 {
        1.0 + x2 * (1.0 / 3.0 + x2 * (0.2 + x2 * (1.0 / 7.0 + x2 * (1.0 / 9.0 + x2 / 11.0))))
    } else {
        x.atanh() / x
    };
    2.0 * d / (a + b) * mean
}

/// The metric at a vertex: the size, and the stretch w that makes it h / √(1 − |w|²) in the direction of w (see
/// `anisotropy`); zero where the size is the same in all directions.
#[derive(Debug, Clone, Copy)]
pub struct Metric {
    pub size: f64,
    pub stretch: DVec3,
}

impl Metric {
    /// The size in the direction of a vector of length `d`.
    #[inline]
    fn along(&self, way: DVec3, d: f64) -> f64 {
        if self.stretch == DVec3::ZERO {
            return self.size;
        }
        let across = d * d - self.stretch.dot(way).powi(2);
        self.size * d / across.max(f64::MIN_POSITIVE).sqrt()
    }
}

/// Length of a vector between two vertices.
#[inline]
pub fn length_between(way: DVec3, a: Metric, b: Metric) -> f64 {
    let d = way.length();
    metric_length(d, a.along(way, d), b.along(way, d))
}

/// Size quality, equation (3): how close a length is to one.
#[inline]
pub fn length_quality(l: f64) -> f64 {
    if l <= 1.0 { l } else { 1.0 / l }
}

/// Lowers sizes until no edge of the mesh has a shock above `beta`.
pub fn grade(rings: &Rings, size: &mut [f64], beta: f64, context: &Context) -> Result<()> {
    let slope = beta.ln();
    let largest = size.iter().copied().fold(0.0, f64::max);
    let mut queue = Buckets::new(rings.len(), 2.0 * largest, SIZE_BITS, SIZE_OCTAVES);
    // Only where a cone cuts into a neighbour there is something to do.
    for v in 0..rings.len() {
        let h = size[v as usize];
        if rings.edges(v).any(|(w, d)| size[w as usize] > h + slope * d) {
            queue.push(v, h);
        }
    }
    let mut step = 0;
    while let Some(v) = queue.pop() {
        step += 1;
        context.check_every(step)?;
        let h = size[v as usize];
        for (w, d) in rings.edges(v) {
            let bound = h + slope * d;
            if bound < size[w as usize] {
                size[w as usize] = bound;
                queue.push(w, bound);
            }
        }
    }
    Ok(())
}
