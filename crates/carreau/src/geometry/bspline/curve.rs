//! B-spline curves in space.

use super::knots::Knots;
use super::tuning::{MAX_HALVINGS, MAX_STEPS, TINY};
use crate::error::{Error, Result};
use glam::DVec3;

/// A clamped B-spline curve: it begins at its first and ends at its last control point.
#[derive(Debug, Clone, PartialEq)]
pub struct BSplineCurve {
    knots: Knots,
    points: Vec<DVec3>,
}

/// Turns in [`BSplineCurve::pull_through`]: what is missing falls to a tenth or less in each.
const SWEEPS: usize = 12;

impl BSplineCurve {
    /// A curve with one control point per basis function.
    ///
    /// # Errors
    /// [`Error::Bug`] if points and knots do not fit.
    pub fn new(knots: Knots, points: Vec<DVec3>) -> Result<Self> {
        if knots.count() != points.len() {
            return Err(Error::Bug(format!("{} control points on {} basis functions", points.len(), knots.count())));
        }
        Ok(BSplineCurve { knots, points })
    }

    /// A polyline with the parameters 0, 1, 2, … at its points (two at least).
    ///
    /// # Errors
    /// [`Error::Bug`] for fewer than two points.
    pub fn polyline(points: Vec<DVec3>) -> Result<Self> {
        Self::new(Knots::index(points.len().saturating_sub(1) as u32), points)
    }

    /// The knots.
    pub fn knots(&self) -> &Knots {
        &self.knots
    }

    /// The control points.
    pub fn points(&self) -> &[DVec3] {
        &self.points
    }

    /// The point at a parameter.
    pub fn point(&self, t: f64) -> DVec3 {
        let (first, n) = self.knots.basis(t);
        (0..=self.knots.degree()).map(|j| n[j] * self.points[first + j]).sum()
    }

    /// Point, first and second derivative.
    pub fn derivatives(&self, t: f64) -> [DVec3; 3] {
        let (first, n) = self.knots.derivatives(t);
        n.map(|row| (0..=self.knots.degree()).map(|j| row[j] * self.points[first + j]).sum())
    }

    /// The first and the last point.
    pub fn ends(&self) -> [DVec3; 2] {
        [self.points[0], self.points[self.points.len() - 1]]
    }

    /// The same curve run backwards, over the same domain.
    pub fn reversed(&self) -> Self {
        BSplineCurve { knots: self.knots.reversed(), points: self.points.iter().rev().copied().collect() }
    }

    /// The curve with every control point mapped; affine maps map all points of the curve so.
    pub(crate) fn mapped(&self, map: impl Fn(DVec3) -> DVec3) -> Self {
        BSplineCurve { knots: self.knots.clone(), points: self.points.iter().map(|&p| map(p)).collect() }
    }

    /// The same curve over another parameter domain.
    pub fn rescaled(self, domain: [f64; 2]) -> Self {
        BSplineCurve { knots: self.knots.rescaled(domain), points: self.points }
    }

    /// A curve of degree 1 as one of degree 3 with triple knots: the same points at the same parameters. Curves of
    /// another degree are returned as they are.
    ///
    /// ```text
    /// P0 ────────── P1        P0 ── · ── · ── P1     · at 1/3 and 2/3
    /// ```
    ///
    /// # Errors
    /// [`Error::Bug`] if the elevated points and knots do not fit.
    pub fn elevated(&self) -> Result<Self> {
        if self.knots.degree() != 1 {
            return Ok(self.clone());
        }
        let mut points = vec![self.points[0]];
        for w in self.points.windows(2) {
            points.extend([w[0].lerp(w[1], 1.0 / 3.0), w[0].lerp(w[1], 2.0 / 3.0), w[1]]);
        }
        let breaks = self.knots.breaks();
        let last = breaks.len() - 1;
        let times = |k: usize| if k == 0 || k == last { 4 } else { 3 };
        let values = breaks.iter().enumerate().flat_map(|(k, &t)| std::iter::repeat_n(t, times(k))).collect();
        // Inner knots of a clamped curve of degree 1 are simple, so breaks and points correspond one to one.
        Self::new(Knots::new(3, values)?, points)
    }

    /// Inserts the inner knot `t` once (eq. 5.15); the curve does not change.
    pub fn insert(&mut self, t: f64) {
        let (p, k, u) = (self.knots.degree(), self.knots.span(t), self.knots.values());
        let mut points = Vec::with_capacity(self.points.len() + 1);
        points.extend_from_slice(&self.points[..=k - p]);
        for i in k - p + 1..=k {
            let share = (t - u[i]) / (u[i + p] - u[i]);
            points.push(if share >= 1.0 { self.points[i] } else { self.points[i - 1].lerp(self.points[i], share) });
        }
        points.extend_from_slice(&self.points[k..]);
        self.knots = self.knots.with(t);
        self.points = points;
    }

    /// The parts before and behind an inner parameter, over their parts of the domain.
    ///
    /// # Errors
    /// [`Error::Bug`] where the parameter is not inside.
    pub fn split(&self, t: f64) -> Result<[Self; 2]> {
        let [low, high] = self.knots.domain();
        if !(low < t && t < high) {
            return Err(Error::Bug("a curve was split at its end".into()));
        }
        let mut whole = self.clone();
        let degree = whole.knots.degree();
        for _ in whole.knots.multiplicity(t)..degree {
            whole.insert(t);
        }
        let values = whole.knots.values();
        let at = values.partition_point(|&x| x < t);
        let before = values[..at + degree].iter().copied().chain([t]).collect();
        let behind = [t].into_iter().chain(values[at..].iter().copied()).collect();
        Ok([
            Self::new(Knots::new(degree, before)?, whole.points[..at].to_vec())?,
            Self::new(Knots::new(degree, behind)?, whole.points[at - 1..].to_vec())?,
        ])
    }

    /// Moves inner control points by as little as it takes for the curve to go through points, each at a parameter. For curves
    /// that nearly do: points whose control points overlap are taken in turn.
    pub fn pull_through(&mut self, points: &[(f64, DVec3)]) {
        let last = self.points.len() - 1;
        for _ in 0..SWEEPS {
            for &(t, target) in points {
                let (first, basis) = self.knots.basis(t);
                let missing = target - self.point(t);
                let inner: Vec<(usize, f64)> =
                    (first..).zip(basis).take(self.knots.degree() + 1).filter(|(k, _)| (1..last).contains(k)).collect();
                let weight: f64 = inner.iter().map(|(_, b)| b * b).sum();
                if weight > 0.0 {
                    inner.into_iter().for_each(|(k, b)| self.points[k] += b / weight * missing);
                }
            }
        }
    }

    /// The same curve with another first and last point.
    pub fn between(mut self, [first, last]: [DVec3; 2]) -> Self {
        let end = self.points.len() - 1;
        (self.points[0], self.points[end]) = (first, last);
        self
    }

    /// The same curve on a knot vector that contains its own.
    ///
    /// # Errors
    /// [`Error::Bug`] for knots that do not contain the curve's own.
    pub fn refined_to(&self, target: &Knots) -> Result<Self> {
        let mut out = self.clone();
        for (t, wanted) in target.distinct() {
            for _ in out.knots.multiplicity(t)..wanted {
                out.insert(t);
            }
        }
        if out.knots != *target {
            return Err(Error::Bug("a curve was refined to knots that do not contain its own".into()));
        }
        Ok(out)
    }

    /// Joins curves of the same degree end to end, over the union of their domains: each must begin where, and at the
    /// parameter at which, the one before ends. The joints get knots of the degree's multiplicity.
    ///
    /// # Errors
    /// [`Error::Bug`] for no curves, or curves that do not meet.
    pub fn joined(pieces: &[BSplineCurve]) -> Result<Self> {
        let Some((first, rest)) = pieces.split_first() else {
            return Err(Error::Bug("no curve to join".into()));
        };
        let degree = first.knots.degree();
        let (mut values, mut points) = (first.knots.values().to_vec(), first.points.clone());
        for piece in rest {
            let touches = piece.points.first() == points.last() && piece.knots.values().first() == values.last();
            if !touches || piece.knots.degree() != degree {
                return Err(Error::Bug("curves that do not meet cannot be joined".into()));
            }
            values.pop();
            values.extend_from_slice(&piece.knots.values()[degree + 1..]);
            points.extend_from_slice(&piece.points[1..]);
        }
        Self::new(Knots::new(degree, values)?, points)
    }

    /// The parameter of a point of the curve near `target`, by Newton steps from `start` (eq. 6.3); never farther from
    /// the target than the start is.
    pub fn project(&self, target: DVec3, start: f64) -> f64 {
        let [low, high] = self.knots.domain();
        let mut t = start;
        for _ in 0..MAX_STEPS {
            let [c, d, dd] = self.derivatives(t);
            let r = c - target;
            let curved = d.length_squared() + r.dot(dd);
            // Where the Hessian is not positive, the Gauss-Newton one is.
            let step = r.dot(d) / if curved > 0.0 { curved } else { d.length_squared() };
            if step.abs() <= TINY * (high - low) {
                break;
            }
            let next = (0..=MAX_HALVINGS).map(|k| (t - 0.5f64.powi(k) * step).clamp(low, high));
            let nearer = |&s: &f64| self.point(s).distance_squared(target) < r.length_squared();
            let Some(next) = next.into_iter().find(nearer) else { break };
            t = next;
        }
        t
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn cubic() -> impl Strategy<Value = BSplineCurve> {
        (prop::collection::vec(0.1f64..1.0, 1..6), any::<u64>()).prop_map(|(steps, seed)| {
            let mut breaks = vec![0.0];
            for s in steps {
                breaks.push(breaks[breaks.len() - 1] + s);
            }
            let knots = Knots::from_breaks(3, &breaks, 1).unwrap();
            let mut x = seed | 1;
            let mut random = || {
                x ^= x << 13;
                x ^= x >> 7;
                x ^= x << 17;
                (x >> 11) as f64 / (1u64 << 53) as f64
            };
            let points = (0..knots.count()).map(|_| DVec3::new(random(), random(), random())).collect();
            BSplineCurve::new(knots, points).unwrap()
        })
    }

    fn same(a: &BSplineCurve, b: &BSplineCurve, tolerance: f64) -> bool {
        let [low, high] = a.knots.domain();
        (0..=50).map(|k| low + (high - low) * f64::from(k) / 50.0).all(|t| a.point(t).distance(b.point(t)) < tolerance)
    }

    proptest! {
        #[test]
        fn insertion_reversal_and_joining_keep_the_curve(c in cubic(), s in 0.01f64..0.99) {
            let t = s * c.knots.domain()[1];
            let mut split = c.clone();
            for times in 1..=3 {
                split.insert(t);
                prop_assert_eq!(split.knots.multiplicity(t), times);
                prop_assert!(same(&c, &split, 1e-12));
            }
            prop_assert!(split.points.iter().any(|p| p.distance(c.point(t)) < 1e-12));
            prop_assert_eq!(split.ends(), c.ends());
            let back = c.reversed();
            let end = c.knots.domain()[1];
            prop_assert!(back.point(end - t).distance(c.point(t)) < 1e-10);
            let next = back.clone().rescaled([end, 2.0 * end]);
            let both = BSplineCurve::joined(&[c.clone(), next]).unwrap();
            prop_assert!(same(&c, &both, 1e-12));
            prop_assert!(both.point(2.0 * end - t).distance(c.point(t)) < 1e-10);
            let target = c.knots.union(&split.knots);
            prop_assert!(same(&c, &c.refined_to(&target).unwrap(), 1e-12));
            prop_assert!(split.refined_to(&c.knots).is_err());
        }

        #[test]
        fn projection_finds_points_of_the_curve(c in cubic(), s in 0.0f64..=1.0) {
            let end = c.knots.domain()[1];
            let p = c.point(s * end);
            let t = c.project(p, (s * end + 1e-3 * end).min(end));
            prop_assert!(c.point(t).distance(p) <= c.point((s * end + 1e-3 * end).min(end)).distance(p));
        }
    }

    #[test]
    fn elevation_keeps_a_polyline_at_every_parameter() {
        let points = vec![DVec3::ZERO, DVec3::X, DVec3::new(1.0, 2.0, 0.0), DVec3::Z];
        let line = BSplineCurve::polyline(points.clone()).unwrap();
        let cubic = line.elevated().unwrap();
        assert_eq!(cubic.knots.degree(), 3);
        assert!(same(&line, &cubic, 1e-14));
        for (k, p) in points.iter().enumerate() {
            assert_eq!(line.point(k as f64), *p);
            assert_eq!(cubic.points()[3 * k], *p);
        }
    }
}
