//! Orthogonal least squares from a start: the sum of squared distances, minimised by Levenberg–Marquardt.

use super::anchored::{Anchored, Distances};
use super::shape::{Kind, Primitive};
use super::unit::UnitBox;
use crate::numeric::levenberg::{Stop, minimise};
use glam::DVec3;

/// A sum of squares below this per point, in the unit box, is rounding.
const ROUNDING: f64 = 1e-31;
/// A step that promises less than this share of the cost changes the distances by nothing that matters.
const GAIN: f64 = 1e-7;

/// A surface with the distances of its points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fit {
    /// The surface.
    pub primitive: Primitive,
    /// Root of the (weighted) mean squared distance.
    pub rms: f64,
    /// Largest distance of a point (of positive weight).
    pub max: f64,
}

/// The surface of the start's kind with the least sum of squared distances that the method reaches from the start.
///
/// `weights`, where given, holds one finite weight ≥ 0 per point. `None` where there are fewer points (of positive weight)
/// than parameters, a number is not finite or out of range, or the minimum is not of the kind any more: a cylinder that
/// became a plane, a cone without an angle.
pub fn refine(start: Primitive, points: &[DVec3], weights: Option<&[f64]>, iterations: usize) -> Option<Fit> {
    let sound = |w: &[f64]| w.len() == points.len() && w.iter().all(|x| *x >= 0.0 && x.is_finite());
    if !weights.is_none_or(sound) {
        return None;
    }
    let unit = UnitBox::of(points)?;
    let inside: Vec<DVec3> = points.iter().map(|p| unit.enter(*p)).collect();
    let start = Anchored::of(&unit.enter_surface(start)?, central(&inside)?)?;
    let data = Distances { points: &inside, weights };
    let (surface, _) = descend(&data, start, Effort::full(iterations, 0.0))?;
    measured(&data, &surface)?.leave(&unit)
}

/// How far a minimisation goes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Effort {
    /// Most steps.
    pub iterations: usize,
    /// A sum of squares that will do.
    pub floor: f64,
    /// It stops where a step promises to lower the sum by less than this share.
    pub gain: f64,
}

impl Effort {
    /// Down to the minimum.
    pub fn full(iterations: usize, floor: f64) -> Self {
        Effort { iterations, floor, gain: GAIN }
    }
}

/// Minimises over the parameters of the start's kind, at most down to rounding. Returns the surface and the sum.
pub(super) fn descend(data: &Distances, start: Anchored, effort: Effort) -> Option<(Anchored, f64)> {
    if data.count() < start.kind.parameters() {
        return None;
    }
    let floor = effort.floor.max(ROUNDING * data.points.len() as f64);
    let stop = Stop { iterations: effort.iterations, floor, gain: effort.gain };
    match start.kind {
        Kind::Plane => minimise::<3, _>(data, start, stop),
        Kind::Sphere => minimise::<4, _>(data, start, stop),
        Kind::Cylinder => minimise::<5, _>(data, start, stop),
        Kind::Cone => minimise::<6, _>(data, start, stop),
        Kind::Torus => minimise::<7, _>(data, start, stop),
    }
}

/// The distances of the points from a surface in its usual form.
pub(super) fn measured(data: &Distances, surface: &Anchored) -> Option<Fit> {
    let primitive = surface.primitive()?;
    let (mut sum, mut total, mut max) = (0.0, 0.0, 0.0f64);
    for (k, p) in data.points.iter().enumerate() {
        let weight = data.weights.map_or(1.0, |w| w[k]);
        if weight > 0.0 {
            let d = primitive.distance(*p).abs();
            (sum, total, max) = (sum + weight * d * d, total + weight, max.max(d));
        }
    }
    let rms = (sum / total).sqrt();
    rms.is_finite().then_some(Fit { primitive, rms, max })
}

impl Fit {
    /// Out of the box.
    pub(super) fn leave(self, unit: &UnitBox) -> Option<Fit> {
        let primitive = unit.leave(self.primitive)?;
        Some(Fit { primitive, rms: unit.length_outside(self.rms), max: unit.length_outside(self.max) })
    }
}

impl Distances<'_> {
    /// Number of points that count.
    pub fn count(&self) -> usize {
        self.weights.map_or(self.points.len(), |w| w.iter().filter(|x| **x > 0.0).count())
    }
}

/// The point next to the mean of all.
pub(super) fn central(points: &[DVec3]) -> Option<DVec3> {
    let mean = points.iter().sum::<DVec3>() / points.len() as f64;
    points.iter().copied().min_by(|a, b| a.distance_squared(mean).total_cmp(&b.distance_squared(mean)))
}
