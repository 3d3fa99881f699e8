//! The parameter of the point of a curve that is nearest to a given one.

use super::Curve;
use crate::geometry::bspline::BSplineCurve;
use glam::DVec3;
use std::f64::consts::TAU;

/// Most Newton steps.
const MAX_STEPS: usize = 30;
/// Most halvings of one step.
const MAX_STEP_HALVINGS: i32 = 20;
/// Samples of an ellipse, among which the start of a search is chosen.
const SAMPLES: usize = 16;
/// Samples of a span of a spline, for the same.
const CURVE_SPAN_SAMPLES: usize = 4;
/// Samples of a spline from which Newton's method is tried.
const CURVE_STARTS: usize = 3;

impl Curve {
    /// The parameter of the nearest point of the whole curve: in [−π, π] on circles and ellipses, in the domain on splines.
    pub fn project(&self, p: DVec3) -> f64 {
        match self {
            Curve::Line { origin, direction } => (p - origin).dot(*direction),
            Curve::Circle { frame, .. } => frame.angle(p),
            Curve::Ellipse { .. } => {
                let samples = (0..SAMPLES).map(|k| TAU * k as f64 / SAMPLES as f64);
                let t = self.nearest(p, samples, 1);
                if t > 0.5 * TAU { t - TAU } else { t }
            }
            Curve::Parabola { frame, focal } => {
                let local = frame.local(p);
                // Beyond the centre of curvature of the apex the nearest point is on either side.
                let side = ((local.x / focal - 2.0).max(0.0)).sqrt();
                self.nearest(p, [0.5 * local.y / focal, side, -side].into_iter(), CURVE_STARTS)
            }
            Curve::Hyperbola { frame, radii: [a, b] } => {
                let local = frame.local(p);
                let side = (local.x * a / (a * a + b * b)).max(1.0).acosh();
                self.nearest(p, [(local.y / b).asinh(), side, -side].into_iter(), CURVE_STARTS)
            }
            Curve::Spline(s) => self.nearest(p, near_samples(s, p).into_iter(), CURVE_STARTS),
        }
    }

    /// The parameter of a nearest point, searched from `start`; on periodic curves the one nearest to `start`, whatever
    /// period that is in.
    pub fn project_near(&self, p: DVec3, start: f64) -> f64 {
        match self {
            Curve::Line { .. } => self.project(p),
            Curve::Circle { .. } => {
                let t = self.project(p);
                t + TAU * ((start - t) / TAU).round()
            }
            _ => self.newton(p, start),
        }
    }

    /// The distance of a point from the whole curve.
    pub fn distance(&self, p: DVec3) -> f64 {
        self.point(self.project(p)).distance(p)
    }

    /// The best of Newton's results from the best samples.
    fn nearest(&self, p: DVec3, samples: impl Iterator<Item = f64>, starts: usize) -> f64 {
        let mut sampled: Vec<(f64, f64)> = samples.map(|t| (self.point(t).distance_squared(p), t)).collect();
        sampled.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let found = sampled.iter().take(starts).map(|&(_, t)| self.newton(p, t));
        let measured = found.map(|t| (self.point(t).distance_squared(p), t));
        measured.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(0.0, |(_, t)| t)
    }

    /// Newton's method on the squared distance; never farther from the target than the start is. Open splines end at
    /// their ends.
    fn newton(&self, p: DVec3, start: f64) -> f64 {
        let [low, high] = match self {
            Curve::Spline(_) if self.period().is_none() => self.domain(),
            _ => [f64::NEG_INFINITY, f64::INFINITY],
        };
        let mut t = start.clamp(low, high);
        for _ in 0..MAX_STEPS {
            let [c, d, dd] = self.derivatives(t);
            let r = c - p;
            let curved = d.length_squared() + r.dot(dd);
            // Where the Hessian is not positive, the Gauss-Newton one is.
            let step = r.dot(d) / if curved > 0.0 { curved } else { d.length_squared() };
            if !(step.abs() > f64::EPSILON * t.abs().max(1e-3)) {
                break;
            }
            let next = (0..=MAX_STEP_HALVINGS).map(|k| (t - 0.5f64.powi(k) * step).clamp(low, high));
            let nearer = |&s: &f64| self.point(s).distance_squared(p) < r.length_squared();
            let Some(next) = next.into_iter().find(nearer) else { break };
            t = next;
        }
        t
    }
}

/// Samples of the spans that the nearest point may be on: a span is in the box of its control points, and no nearer than that.
fn near_samples(s: &BSplineCurve, p: DVec3) -> Vec<f64> {
    let (values, degree) = (s.knots().values(), s.knots().degree());
    let bound = |k: usize| {
        let points = &s.points()[k - degree..=k];
        let low = points.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let high = points.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
        p.clamp(low, high).distance_squared(p)
    };
    let spans = (degree..s.knots().count()).filter(|&k| values[k] < values[k + 1]);
    let mut spans: Vec<(f64, usize)> = spans.map(|k| (bound(k), k)).collect();
    spans.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut nearest = f64::INFINITY;
    let mut out = Vec::new();
    for (bound, k) in spans {
        if bound > nearest {
            break;
        }
        for j in 0..=CURVE_SPAN_SAMPLES {
            let t = values[k] + (values[k + 1] - values[k]) * j as f64 / CURVE_SPAN_SAMPLES as f64;
            nearest = nearest.min(s.point(t).distance_squared(p));
            out.push(t);
        }
    }
    out
}
