//! Tensor-product B-spline surfaces in space.

use super::curve::BSplineCurve;
use super::knots::{Basis, Knots};
use super::tuning::{MAX_HALVINGS, MAX_STEPS, TINY};
use crate::error::{Error, Result};
use glam::DVec3;

/// A clamped tensor-product surface S(u, v).
///
/// Control points are stored with u running fastest: `points[j * u.count() + i]`. The normal is ∂S/∂u × ∂S/∂v, so the
/// border runs counter-clockwise, seen from outside, through S(0,0), S(1,0), S(1,1), S(0,1).
#[derive(Debug, Clone, PartialEq)]
pub struct BSplineSurface {
    u: Knots,
    v: Knots,
    points: Vec<DVec3>,
}

/// Position, first derivatives (u, v) and second derivatives (uu, uv, vv).
#[derive(Debug, Clone, Copy)]
pub struct Jet {
    /// S
    pub point: DVec3,
    /// S_u, S_v
    pub first: [DVec3; 2],
    /// S_uu, S_uv, S_vv
    pub second: [DVec3; 3],
}

impl BSplineSurface {
    /// A surface with one control point per pair of basis functions.
    ///
    /// # Errors
    /// [`Error::Bug`] if points and knots do not fit.
    pub fn new(u: Knots, v: Knots, points: Vec<DVec3>) -> Result<Self> {
        if u.count() * v.count() != points.len() {
            return Err(Error::Bug(format!(
                "{} control points on {} × {} functions",
                points.len(),
                u.count(),
                v.count()
            )));
        }
        Ok(BSplineSurface { u, v, points })
    }

    /// The knots in u and in v.
    pub fn knots(&self) -> [&Knots; 2] {
        [&self.u, &self.v]
    }

    /// The control points, u fastest.
    pub fn points(&self) -> &[DVec3] {
        &self.points
    }

    /// The control point of basis functions `i` in u and `j` in v.
    pub fn control(&self, i: usize, j: usize) -> DVec3 {
        self.points[j * self.u.count() + i]
    }

    /// The point at a pair of parameters.
    pub fn point(&self, u: f64, v: f64) -> DVec3 {
        let ((i, a), (j, b)) = (self.u.basis(u), self.v.basis(v));
        let mut sum = DVec3::ZERO;
        for (row, &weight) in b.iter().enumerate().take(self.v.degree() + 1) {
            sum += weight * self.along((j + row) * self.u.count() + i, &a);
        }
        sum
    }

    /// The sum of control points from one on, of one row, with the weights of basis functions.
    #[inline]
    fn along(&self, first: usize, weights: &Basis) -> DVec3 {
        match self.points[first..=first + self.u.degree()] {
            [p, q, r, s] => p * weights[0] + q * weights[1] + r * weights[2] + s * weights[3],
            ref few => few.iter().zip(weights).map(|(&p, &w)| w * p).sum(),
        }
    }

    /// The surface with every control point mapped; affine maps map all points of the surface so.
    pub(crate) fn mapped(&self, map: impl Fn(DVec3) -> DVec3) -> Self {
        let points = self.points.iter().map(|&p| map(p)).collect();
        BSplineSurface { u: self.u.clone(), v: self.v.clone(), points }
    }

    /// Position and derivatives.
    pub fn jet(&self, u: f64, v: f64) -> Jet {
        let ((i, a), (j, b)) = (self.u.derivatives(u), self.v.derivatives(v));
        let mut jet = Jet { point: DVec3::ZERO, first: [DVec3::ZERO; 2], second: [DVec3::ZERO; 3] };
        for k in 0..=self.v.degree() {
            let along = a.map(|n| self.along((j + k) * self.u.count() + i, &n));
            let [b, db, ddb] = b.map(|row| row[k]);
            jet.point += b * along[0];
            jet.first[0] += b * along[1];
            jet.first[1] += db * along[0];
            jet.second[0] += b * along[2];
            jet.second[1] += db * along[1];
            jet.second[2] += ddb * along[0];
        }
        jet
    }

    /// The border curves: v = min, u = max, v = max, u = min; each in the sense of growing parameters.
    ///
    /// # Errors
    /// [`Error::Bug`] if points and knots of a side do not fit.
    pub fn sides(&self) -> Result<[BSplineCurve; 4]> {
        let (m, n) = (self.u.count(), self.v.count());
        let row = |j: usize| (0..m).map(|i| self.control(i, j)).collect();
        let column = |i: usize| (0..n).map(|j| self.control(i, j)).collect();
        Ok([
            BSplineCurve::new(self.u.clone(), row(0))?,
            BSplineCurve::new(self.v.clone(), column(m - 1))?,
            BSplineCurve::new(self.u.clone(), row(n - 1))?,
            BSplineCurve::new(self.v.clone(), column(0))?,
        ])
    }

    /// Parameters of a point of the surface near `target`, by Newton steps from `start` (eq. 6.7); never farther from
    /// the target than the start is.
    pub fn project(&self, target: DVec3, start: [f64; 2]) -> [f64; 2] {
        let (du, dv) = (self.u.domain(), self.v.domain());
        let tiny = |s: [f64; 2]| s[0].abs() <= TINY * (du[1] - du[0]) && s[1].abs() <= TINY * (dv[1] - dv[0]);
        let mut at = start;
        for _ in 0..MAX_STEPS {
            let jet = self.jet(at[0], at[1]);
            let r = jet.point - target;
            let newton = newton_step(&jet, r);
            // Halved until it helps, and along one parameter where nothing else does: creases are isoparametric, and
            // derivatives say nothing of their other side.
            let alone = jet.first.map(|d| -r.dot(d) / d.length_squared());
            let steps = newton.into_iter().chain([[alone[0], 0.0], [0.0, alone[1]]]);
            let shorter = steps.flat_map(|s| (0..=MAX_HALVINGS).map(move |k| s.map(|x| 0.5f64.powi(k) * x)));
            let moved = |[su, sv]: [f64; 2]| [(at[0] + su).clamp(du[0], du[1]), (at[1] + sv).clamp(dv[0], dv[1])];
            let nearer = |p: &[f64; 2]| self.point(p[0], p[1]).distance_squared(target) < r.length_squared();
            // The last step counts as well: what is left after it is of second order.
            let last = newton.is_some_and(tiny);
            let next = if last { newton.map(moved).filter(nearer) } else { shorter.map(moved).find(nearer) };
            at = next.unwrap_or(at);
            if last || next.is_none() {
                break;
            }
        }
        at
    }
}

/// The step towards the foot point; Gauss-Newton where the full Hessian is not positive definite.
fn newton_step(jet: &Jet, r: DVec3) -> Option<[f64; 2]> {
    let [su, sv] = jet.first;
    let gradient = [r.dot(su), r.dot(sv)];
    let gram = [su.dot(su), su.dot(sv), sv.dot(sv)];
    let full = [0, 1, 2].map(|k| gram[k] + r.dot(jet.second[k]));
    let determinant = |h: [f64; 3]| h[0] * h[2] - h[1] * h[1];
    let positive = |h: [f64; 3]| h[0] > 0.0 && h[2] > 0.0 && determinant(h) > 1e-12 * h[0] * h[2];
    let h = [full, gram].into_iter().find(|&h| positive(h))?;
    let d = determinant(h);
    let step = [(h[1] * gradient[1] - h[2] * gradient[0]) / d, (h[1] * gradient[0] - h[0] * gradient[1]) / d];
    (step[0].is_finite() && step[1].is_finite()).then_some(step)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A bicubic surface over [0, 3] × [0, 2].
    fn hill() -> BSplineSurface {
        let u = Knots::from_breaks(3, &[0.0, 1.0, 2.0, 3.0], 1).unwrap();
        let v = Knots::from_breaks(3, &[0.0, 0.5, 2.0], 1).unwrap();
        let points = (0..v.count() * u.count())
            .map(|k| {
                let (i, j) = ((k % u.count()) as f64, (k / u.count()) as f64);
                DVec3::new(i, j + 0.1 * i, (0.7 * i).sin() + 0.3 * (1.3 * j).cos())
            })
            .collect();
        BSplineSurface::new(u, v, points).unwrap()
    }

    #[test]
    fn derivatives_agree_with_differences() {
        let s = hill();
        let h = 1e-5;
        for (u, v) in [(0.3, 0.2), (1.7, 0.4), (2.4, 1.1), (0.9, 1.9)] {
            let jet = s.jet(u, v);
            let at = |a: f64, b: f64| s.point(u + a * h, v + b * h);
            assert!(jet.point.distance(s.point(u, v)) < 1e-14);
            assert!(jet.first[0].distance((at(1.0, 0.0) - at(-1.0, 0.0)) / (2.0 * h)) < 1e-8);
            assert!(jet.first[1].distance((at(0.0, 1.0) - at(0.0, -1.0)) / (2.0 * h)) < 1e-8);
            assert!(jet.second[0].distance((at(1.0, 0.0) - 2.0 * at(0.0, 0.0) + at(-1.0, 0.0)) / (h * h)) < 1e-4);
            let mixed = at(1.0, 1.0) - at(1.0, -1.0) - at(-1.0, 1.0) + at(-1.0, -1.0);
            assert!(jet.second[1].distance(mixed / (4.0 * h * h)) < 1e-4);
            assert!(jet.second[2].distance((at(0.0, 1.0) - 2.0 * at(0.0, 0.0) + at(0.0, -1.0)) / (h * h)) < 1e-4);
        }
    }

    #[test]
    fn sides_are_the_border() {
        let s = hill();
        let [bottom, right, top, left] = s.sides().unwrap();
        for k in 0..=10 {
            let (u, v) = (0.3 * f64::from(k), 0.2 * f64::from(k));
            assert!(bottom.point(u).distance(s.point(u, 0.0)) < 1e-14);
            assert!(top.point(u).distance(s.point(u, 2.0)) < 1e-14);
            assert!(right.point(v).distance(s.point(3.0, v)) < 1e-14);
            assert!(left.point(v).distance(s.point(0.0, v)) < 1e-14);
        }
    }

    #[test]
    fn projection_is_orthogonal() {
        let s = hill();
        for (u, v) in [(0.5, 0.5), (1.5, 1.0), (2.5, 1.5)] {
            let jet = s.jet(u, v);
            let normal = jet.first[0].cross(jet.first[1]).normalize();
            let found = s.project(jet.point + 0.05 * normal, [u + 0.1, v - 0.1]);
            assert!((found[0] - u).abs() < 1e-7 && (found[1] - v).abs() < 1e-7, "{found:?}");
        }
    }
}
