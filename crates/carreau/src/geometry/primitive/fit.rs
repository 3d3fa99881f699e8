//! The best surface of a kind through points, and the simplest kind that will do.
//!
//! Every start takes a few steps of the minimisation; the best ones go on to the end. Trials stop as soon as one is good
//! enough, so that clean data pay for one start only.

use super::anchored::{Anchored, Distances};
use super::refine::{Effort, Fit, descend, measured};
use super::shape::{Kind, Primitive};
use super::starts::{self, Sample};
use super::unit::UnitBox;
use glam::DVec3;
use std::ops::ControlFlow;

/// Steps that a start has to show what it is worth.
const TRIAL_STEPS: usize = 4;
/// Steps of those that go on.
const FINAL_STEPS: usize = 60;
/// Number of starts that go on.
const FINALISTS: usize = 3;
/// The gain per step below which a minimisation stops, see [`Effort`]: at the minimum, or where it slows down.
pub(super) const PATIENT: f64 = 1e-10;
/// The same where a fit only has to be within a tolerance.
const HASTY: f64 = 0.02;
/// Costs that agree to this share are those of one minimum.
const SAME: f64 = 1e-4;
/// Where a limit of the kind, like a cylinder of infinite radius, has a sum of squares smaller by this factor, the points are
/// of that simpler kind.
const LIMIT_IS_BETTER: f64 = 4.0;
/// A root mean square distance in the unit box that says: exact samples, no start will do better.
const EXACT: f64 = 1e-13;
/// Of the tolerance: the root mean square distance at which no other start is tried.
const GOOD_ENOUGH: f64 = 0.35;

/// Memory that fits use again and again.
#[derive(Debug, Default)]
pub struct Scratch {
    /// All points, in the unit box.
    points: Vec<DVec3>,
    /// The points with a normal, and their normals.
    oriented: Vec<DVec3>,
    normals: Vec<DVec3>,
    pub(super) weights: Vec<f64>,
    pub(super) distances: Vec<f64>,
}

/// What [`simplest`] asks of a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Demand {
    /// Largest distance of a point.
    pub tolerance: f64,
    /// Largest angle in radians between a given normal and the surface's, whatever their signs; π/2 or more asks for
    /// nothing.
    pub angle: f64,
    /// Share of the points that may be farther away or of another direction.
    pub outliers: f64,
}

impl Demand {
    /// All points within a distance, whatever their normals.
    pub fn within(tolerance: f64) -> Self {
        Demand { tolerance, angle: std::f64::consts::PI, outliers: 0.0 }
    }

    /// Whether enough points and normals agree with a surface.
    pub fn is_met(&self, surface: &Primitive, points: &[DVec3], normals: &[DVec3]) -> bool {
        let least_cosine = if self.angle < std::f64::consts::FRAC_PI_2 { self.angle.cos() } else { -1.0 };
        let agrees = |(p, n): &(&DVec3, &DVec3)| {
            // Where either normal is missing the product is zero.
            let product = surface.normal(**p).dot(**n).abs();
            surface.distance(**p).abs() <= self.tolerance && (product == 0.0 || product >= least_cosine)
        };
        let outliers = points.iter().zip(normals).filter(|pair| !agrees(pair)).count();
        outliers as f64 <= self.outliers * points.len() as f64
    }
}

/// The surface of a kind with the least sum of squared distances, from the best of several starts.
///
/// `normals` holds for every point an estimate of the unit normal there, zero where there is none; they serve as starts only.
/// Signs must agree between neighbours but may be those of either side. `None` where the points do not determine a
/// surface of the kind: too few, coincident, flat for a curved kind, not finite; or the lists differ in length.
///
/// ```
/// use carreau::geometry::primitive::{fit, Kind, Primitive, Scratch};
/// use glam::DVec3;
/// let points: Vec<DVec3> = (0..6)
///     .map(|k| (f64::from(k % 3) * 0.2, f64::from(k / 3)))
///     .map(|(u, z)| DVec3::new(2.0 * u.cos(), 2.0 * u.sin(), z))
///     .collect();
/// let found = fit(Kind::Cylinder, &points, &[DVec3::ZERO; 6], &mut Scratch::default()).unwrap();
/// assert!(matches!(found.primitive, Primitive::Cylinder { radius, .. } if (radius - 2.0).abs() < 1e-9));
/// ```
pub fn fit(kind: Kind, points: &[DVec3], normals: &[DVec3], scratch: &mut Scratch) -> Option<Fit> {
    let unit = scratch.enter(points, normals)?;
    best(kind, scratch, EXACT, PATIENT)?.leave(&unit)
}

/// A surface of a kind within a distance of all points, where one is found quickly: the test of a hypothesis. What lies on
/// no such surface is given up as soon as the minimisation slows down, at a fraction of the cost of [`fit`].
pub fn fit_within(
    kind: Kind,
    points: &[DVec3],
    normals: &[DVec3],
    tolerance: f64,
    scratch: &mut Scratch,
) -> Option<Fit> {
    let unit = scratch.enter(points, normals)?;
    let enough = (unit.length_inside(tolerance) * GOOD_ENOUGH).max(EXACT);
    best(kind, scratch, enough, HASTY)?.leave(&unit).filter(|fit| fit.max <= tolerance)
}

/// The fit of the simplest kind that meets the demand.
///
/// Kinds are tried in the order of their number of parameters, each only where there are more points than parameters: fewer
/// points fit anything. `None` where no kind will do.
pub fn simplest(points: &[DVec3], normals: &[DVec3], demand: &Demand, scratch: &mut Scratch) -> Option<Fit> {
    let unit = scratch.enter(points, normals)?;
    let enough = (unit.length_inside(demand.tolerance) * GOOD_ENOUGH).max(EXACT);
    Kind::ALL.into_iter().filter(|kind| points.len() > kind.parameters()).find_map(|kind| {
        let found = best(kind, scratch, enough, PATIENT)?.leave(&unit)?;
        demand.is_met(&found.primitive, points, normals).then_some(found)
    })
}

impl Scratch {
    /// Takes points and normals in; `None` where there is no unit box or the lists differ in length.
    pub(super) fn enter(&mut self, points: &[DVec3], normals: &[DVec3]) -> Option<UnitBox> {
        if points.len() != normals.len() {
            return None;
        }
        let unit = UnitBox::of(points)?;
        self.points.clear();
        self.points.extend(points.iter().map(|p| unit.enter(*p)));
        self.oriented.clear();
        self.normals.clear();
        for (p, n) in self.points.iter().zip(normals) {
            if let Some(n) = n.try_normalize() {
                self.oriented.push(*p);
                self.normals.push(n);
            }
        }
        Some(unit)
    }

    /// A copy without some of the points.
    pub(super) fn without(&self, is_left_out: impl Fn(DVec3) -> bool) -> Scratch {
        let points = self.points.iter().copied().filter(|p| !is_left_out(*p)).collect();
        let pairs = self.oriented.iter().zip(&self.normals).filter(|(p, _)| !is_left_out(**p));
        let (oriented, normals) = pairs.unzip();
        Scratch { points, oriented, normals, ..Scratch::default() }
    }

    /// The points and normals that were taken in.
    pub(super) fn sample(&self) -> Sample<'_> {
        Sample { points: &self.points, oriented: &self.oriented, normals: &self.normals }
    }
}

/// The best fit of a kind to the points in the scratch memory, in the unit box; the search stops at a root mean square
/// distance that is good `enough`.
pub(super) fn best(kind: Kind, scratch: &Scratch, enough: f64, gain: f64) -> Option<Fit> {
    if scratch.points.len() < kind.parameters() {
        return None;
    }
    let data = Distances { points: &scratch.points, weights: None };
    let enough = enough * enough * scratch.points.len() as f64;
    let mut finalists = Finalists::default();
    // Broken off or not: the finalists are what the search was for.
    let _ = starts::offer(kind, &scratch.sample(), &mut |start: Option<Anchored>| match start
        .and_then(|start| descend(&data, start, Effort { iterations: TRIAL_STEPS, floor: enough, gain }))
    {
        Some((surface, cost)) => {
            finalists.insert(surface, cost);
            if cost <= enough && surface.primitive().is_some() {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        }
        None => ControlFlow::Continue(()),
    });
    let last = Effort { iterations: FINAL_STEPS, floor: if gain > PATIENT { enough } else { 0.0 }, gain };
    let (mut winner, mut least): (Option<Fit>, f64) = (None, f64::INFINITY);
    for (surface, _) in finalists.0.into_iter().flatten() {
        let Some((surface, cost)) = descend(&data, surface, last) else { continue };
        least = least.min(cost);
        winner = match (winner, measured(&data, &surface)) {
            (Some(a), Some(b)) => Some(if b.rms < a.rms { b } else { a }),
            (a, b) => a.or(b),
        };
        if winner.is_some_and(|w| w.cost(&data) <= enough) {
            break;
        }
    }
    winner.filter(|w| w.cost(&data) <= (least * LIMIT_IS_BETTER).max(enough))
}

impl Fit {
    /// Sum of the squared distances.
    fn cost(&self, data: &Distances) -> f64 {
        self.rms * self.rms * data.points.len() as f64
    }
}

/// The surfaces of least cost so far, best first; starts that arrive at the same minimum count once.
#[derive(Default)]
struct Finalists([Option<(Anchored, f64)>; FINALISTS]);

impl Finalists {
    fn insert(&mut self, surface: Anchored, cost: f64) {
        let known = |place: &Option<(Anchored, f64)>| place.is_some_and(|(_, old)| (cost - old).abs() <= SAME * old);
        if self.0.iter().any(known) {
            return;
        }
        let mut newcomer = Some((surface, cost));
        for place in &mut self.0 {
            let better = match (&newcomer, &*place) {
                (Some((_, new)), Some((_, old))) => new < old,
                (new, _) => new.is_some(),
            };
            if better {
                std::mem::swap(place, &mut newcomer);
            }
        }
    }
}
