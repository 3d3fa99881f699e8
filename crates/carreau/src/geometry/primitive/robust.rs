//! Fits that outliers do not spoil: least squares, iterated with weights that fall with the distance.
//!
//! Weights are Tukey's biweight (Beaton and Tukey, Technometrics 16, 1974), (1 − (d/cσ)²)² up to cσ and 0 beyond, with
//! c = 4.685 (95 % efficiency under normal noise) and σ from the median distance, corrected for few degrees of freedom
//! (Rousseeuw and Leroy, Robust Regression and Outlier Detection, 1987, p. 202). The first scale comes from the fit to all
//! points, so it is wide, and narrows from round to round.

use super::anchored::{Anchored, Distances};
use super::fit::{PATIENT, Scratch, best};
use super::refine::{Effort, Fit, central, descend, measured};
use super::{Kind, Primitive};
use glam::DVec3;

/// c of the biweight.
const TUKEY: f64 = 4.685;
/// Standard deviation of a normal distribution over its median absolute value.
const NORMAL_OVER_MEDIAN: f64 = 1.4826;
const ROUNDS: usize = 12;
const STEPS_PER_ROUND: usize = 8;
/// Scales below this in the unit box are rounding.
const SMALLEST_SCALE: f64 = 1e-15;

/// A fit to most of the points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RobustFit {
    /// The surface; `rms` weighted, `max` over the inliers.
    pub fit: Fit,
    /// Share of the points that have a say (weight above 0).
    pub inliers: f64,
}

/// The surface of a kind through most of the points; arguments as for [`super::fit`].
pub fn fit_robust(kind: Kind, points: &[DVec3], normals: &[DVec3], scratch: &mut Scratch) -> Option<RobustFit> {
    let unit = scratch.enter(points, normals)?;
    let start = best(kind, scratch, SMALLEST_SCALE, PATIENT)?;
    let mut surface = Anchored::of(&start.primitive, central(scratch.points())?)?;
    let (mut weights, mut distances) = (std::mem::take(&mut scratch.weights), std::mem::take(&mut scratch.distances));
    let mut found = RobustFit { fit: start, inliers: 1.0 };
    for _ in 0..ROUNDS {
        let Some(scale) = reweigh(&found.fit.primitive, scratch.points(), &mut distances, &mut weights) else { break };
        let data = Distances { points: scratch.points(), weights: Some(&weights) };
        let Some((moved, _)) = descend(&data, surface, Effort::full(STEPS_PER_ROUND, 0.0)) else { break };
        let Some(fit) = measured(&data, &moved) else { break };
        surface = moved;
        let settled = (fit.rms - found.fit.rms).abs() <= 1e-6 * scale;
        found = RobustFit { fit, inliers: data.count() as f64 / weights.len() as f64 };
        if settled {
            break;
        }
    }
    (scratch.weights, scratch.distances) = (weights, distances);
    Some(RobustFit { fit: found.fit.leave(&unit)?, ..found })
}

/// Weights by the distances from a surface; returns their scale σ, `None` where the surface is exact for most points.
fn reweigh(surface: &Primitive, points: &[DVec3], distances: &mut Vec<f64>, weights: &mut Vec<f64>) -> Option<f64> {
    distances.clear();
    distances.extend(points.iter().map(|p| surface.distance(*p).abs()));
    let freedom = points.len().saturating_sub(surface.kind().parameters()).max(1) as f64;
    weights.clear();
    weights.extend_from_slice(distances);
    let middle = points.len() / 2;
    let (_, median, _) = weights.select_nth_unstable_by(middle, f64::total_cmp);
    let scale = NORMAL_OVER_MEDIAN * (1.0 + 5.0 / freedom) * *median;
    for (weight, d) in weights.iter_mut().zip(distances) {
        let x = *d / (TUKEY * scale);
        *weight = if x < 1.0 { (1.0 - x * x).powi(2) } else { 0.0 };
    }
    (scale > SMALLEST_SCALE).then_some(scale)
}
