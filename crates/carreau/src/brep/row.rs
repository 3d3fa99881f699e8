//! A line v = const of a spline surface: its control points are summed up once, so that the many points of an integral along it cost
//! what those of a curve do.

use crate::geometry::bspline::{BSplineSurface, Knots};
use glam::DVec3;

/// The line, with the derivatives across it.
pub struct Row<'a> {
    knots: &'a Knots,
    points: Vec<DVec3>,
    across: Vec<DVec3>,
}

impl<'a> Row<'a> {
    /// The line of a surface at a parameter v.
    pub fn of(surface: &'a BSplineSurface, v: f64) -> Self {
        let [knots, other] = surface.knots();
        let (first, [values, slopes, _]) = other.derivatives(v);
        let sum = |weights: &[f64]| -> Vec<DVec3> {
            let rows = &weights[..=other.degree()];
            let at = |i: usize| rows.iter().enumerate().map(|(j, &w)| w * surface.control(i, first + j)).sum();
            (0..knots.count()).map(at).collect()
        };
        Row { knots, points: sum(&values), across: sum(&slopes) }
    }

    /// The point at a parameter u, and the first derivatives.
    pub fn at(&self, u: f64) -> (DVec3, [DVec3; 2]) {
        let (first, [values, slopes, _]) = self.knots.derivatives(u);
        let sum = |of: &[DVec3], weights: &[f64]| -> DVec3 {
            of[first..=first + self.knots.degree()].iter().zip(weights).map(|(&p, &w)| w * p).sum()
        };
        (sum(&self.points, &values), [sum(&self.points, &slopes), sum(&self.across, &values)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;

    #[test]
    fn a_line_has_the_points_and_derivatives_of_its_surface() {
        let breaks = [0.0, 0.2, 0.5, 1.0];
        let [u, v] = [3, 2].map(|degree| Knots::from_breaks(degree, &breaks, 1).unwrap());
        let bent = |k: usize| {
            let p = DVec2::new((k % 6) as f64, (k / 6) as f64);
            p.extend((p.x * p.y).sin())
        };
        let points = (0..u.count() * v.count()).map(bent).collect();
        let surface = BSplineSurface::new(u, v, points).unwrap();
        for (u, v) in [(0.0, 0.3), (0.3, 0.0), (0.5, 0.5), (0.99, 1.0)] {
            let (jet, (point, first)) = (surface.jet(u, v), Row::of(&surface, v).at(u));
            assert!(jet.point.distance(point) < 1e-14);
            assert!(jet.first.iter().zip(first).all(|(a, b)| a.distance(b) < 1e-12));
        }
    }
}
