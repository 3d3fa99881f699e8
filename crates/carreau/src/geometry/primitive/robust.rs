//! Fits that outliers do not spoil: least squares, iterated with weights that fall with the distance.
//!
//! Weights are Tukey's biweight (Beaton and Tukey, Technometrics 16, 1974), (1 − (d/cσ)²)² up to cσ and 0 beyond, with
//! c = 4.685 (95 % efficiency under normal noise) and σ from the median distance, corrected for few degrees of freedom
//! (Rousseeuw and Leroy, Robust Regression and Outlier Detection, 1987, p. 202). The first scale comes from the fit to all
//! points, so it is wide, and narrows from round to round. With so wide a scale the biweight hardly tells outliers apart; the
//! first rounds use the weights of Geman and McClure (Bull. Int. Stat. Inst. 52, 1987), (1 + (d/σ)²)⁻², which fall faster.

use super::anchored::{Anchored, Distances};
use super::fit::{PATIENT, Scratch, best};
use super::refine::{Effort, Fit, central, descend, measured};
use super::shape::{Kind, Primitive};
use super::starts;
use glam::DVec3;
use std::ops::ControlFlow;

/// c of the biweight.
const TUKEY: f64 = 4.685;
/// Standard deviation of a normal distribution over its median absolute value.
const NORMAL_OVER_MEDIAN: f64 = 1.4826;
/// Most rounds of weights.
const WEIGHING_ROUNDS: usize = 20;
/// Rounds that look for the bulk of the points, before those that weigh it.
const SEARCH_ROUNDS: usize = 8;
/// Steps of the minimisation in each round.
const STEPS_PER_ROUND: usize = 8;
/// A relative change of the root mean square distance that ends the rounds.
const SETTLED: f64 = 1e-6;
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
///
/// Outliers bend the least-squares fit and may leave it at a wrong minimum, so every start is a start of its own here, and the
/// surface with the least median distance is the result. That takes several times as long as [`super::fit`].
pub fn fit_robust(kind: Kind, points: &[DVec3], normals: &[DVec3], scratch: &mut Scratch) -> Option<RobustFit> {
    let unit = scratch.enter(points, normals)?;
    let (mut weights, mut distances) = (std::mem::take(&mut scratch.weights), std::mem::take(&mut scratch.distances));
    let sample = scratch.sample();
    let mut winner: Option<(RobustFit, f64)> = None;
    let mut receiver = |start: Option<Anchored>| {
        let found = start.and_then(|start| converge(start, sample.points, &mut distances, &mut weights));
        if let Some((fit, scale)) = found
            && winner.is_none_or(|(_, least)| scale < least)
        {
            winner = Some((fit, scale));
        }
        match winner {
            Some((_, scale)) if scale <= SMALLEST_SCALE => ControlFlow::Break(()),
            _ => ControlFlow::Continue(()),
        }
    };
    let least_squares = best(kind, scratch, SMALLEST_SCALE, PATIENT).map(|fit| fit.primitive);
    let start = least_squares.and_then(|surface| Anchored::of(&surface, central(sample.points)?));
    // Broken off or not: the winner is what the search was for.
    let _ = receiver(start).is_continue() && starts::offer(kind, &sample, &mut receiver).is_continue();
    // The outliers are known now, but the minimum may still be a poor one: once more from all starts without them.
    if let Some((found, scale)) = winner.filter(|(_, scale)| *scale > SMALLEST_SCALE) {
        let inliers = scratch.without(|p| found.fit.primitive.distance(p).abs() > TUKEY * scale);
        let again = best(kind, &inliers, SMALLEST_SCALE, PATIENT)
            .and_then(|fit| Anchored::of(&fit.primitive, central(sample.points)?));
        let again = again.and_then(|start| converge(start, sample.points, &mut distances, &mut weights));
        winner = again.filter(|(_, other)| *other < scale).or(winner);
    }
    (scratch.weights, scratch.distances) = (weights, distances);
    let (found, _) = winner?;
    Some(RobustFit { fit: found.fit.leave(&unit)?, ..found })
}

/// Iterates from a start until the distances no longer change; returns also their scale.
fn converge(
    start: Anchored,
    points: &[DVec3],
    distances: &mut Vec<f64>,
    weights: &mut Vec<f64>,
) -> Option<(RobustFit, f64)> {
    let all = Distances { points, weights: None };
    // A start that is a limit of its kind, such as a cone without an angle, has to leave the limit first.
    let steps = if start.primitive().is_some() { 0 } else { STEPS_PER_ROUND };
    let (mut surface, _) = descend(&all, start, Effort::full(steps, 0.0))?;
    let mut fit = measured(&all, &surface)?;
    let mut inliers = 1.0;
    for round in 0..WEIGHING_ROUNDS {
        let weight = if round < SEARCH_ROUNDS { geman_mcclure } else { tukey };
        if reweigh(&fit.primitive, points, weight, distances, weights) <= SMALLEST_SCALE {
            break;
        }
        let data = Distances { points, weights: Some(weights) };
        let last = fit.rms;
        (surface, _) = descend(&data, surface, Effort::full(STEPS_PER_ROUND, 0.0))?;
        fit = measured(&data, &surface)?;
        inliers = data.count() as f64 / points.len() as f64;
        if round > SEARCH_ROUNDS && (fit.rms - last).abs() <= SETTLED * last {
            break;
        }
    }
    let scale = reweigh(&fit.primitive, points, tukey, distances, weights);
    // Exact for most points before the last weights were set: those farther away are outliers all the same.
    if scale <= SMALLEST_SCALE {
        let data = Distances { points, weights: Some(weights) };
        (fit, inliers) = (measured(&data, &surface)?, data.count() as f64 / points.len() as f64);
    }
    Some((RobustFit { fit, inliers }, scale))
}

/// Weights by the distances from a surface; returns their scale σ.
fn reweigh(
    surface: &Primitive,
    points: &[DVec3],
    weight_of: fn(f64) -> f64,
    distances: &mut Vec<f64>,
    weights: &mut Vec<f64>,
) -> f64 {
    distances.clear();
    distances.extend(points.iter().map(|p| surface.distance(*p).abs()));
    let freedom = points.len().saturating_sub(surface.kind().parameters()).max(1) as f64;
    weights.clear();
    weights.extend_from_slice(distances);
    let middle = points.len() / 2;
    let (_, median, _) = weights.select_nth_unstable_by(middle, f64::total_cmp);
    let scale = NORMAL_OVER_MEDIAN * (1.0 + 5.0 / freedom) * *median;
    for (weight, d) in weights.iter_mut().zip(distances) {
        *weight = weight_of(*d / scale.max(SMALLEST_SCALE));
    }
    scale
}

/// Weight at a distance in units of the scale.
fn tukey(x: f64) -> f64 {
    let x = x / TUKEY;
    if x < 1.0 { (1.0 - x * x).powi(2) } else { 0.0 }
}

/// Weight at a distance in units of the scale.
fn geman_mcclure(x: f64) -> f64 {
    (1.0 + x * x).powi(-2)
}
