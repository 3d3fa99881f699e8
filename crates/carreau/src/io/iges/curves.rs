//! Curves: 110 lines, 100 circles, 104 conics, 126 splines, 102 composites.

use super::records::{Entity, Head, Writer};
use super::words::{DEPENDENT, PARAMETRIC};
use crate::brep::{Brep, Curve, Edge, EdgeUse, Frame};
use crate::geometry::bspline::Knots;
use glam::DVec3;

impl Writer {
    /// An edge in its own sense, or against it.
    pub(super) fn edge_curve(&mut self, edge: &Edge, reversed: bool, brep: &Brep) -> Entity {
        if let Curve::Line { .. } = edge.curve {
            let [a, b] = edge.ends.map(|v| brep.point(v));
            return self.line(if reversed { [b, a] } else { [a, b] }, DEPENDENT);
        }
        if reversed {
            let (curve, range) = edge.curve.reversed(edge.range);
            return self.curve(&curve, range);
        }
        self.curve(&edge.curve, edge.range)
    }

    /// A piece of a curve.
    pub(super) fn curve(&mut self, curve: &Curve, range: [f64; 2]) -> Entity {
        // In the plane of the frame.
        let flat = |frame: &Frame, t: f64| {
            let l = frame.local(curve.point(t));
            [l.x, l.y]
        };
        match curve {
            Curve::Line { .. } => self.line(range.map(|t| curve.point(t)), DEPENDENT),
            Curve::Circle { frame, .. } => {
                let matrix = self.matrix(frame);
                self.record(&Head { kind: 100, matrix, ..Head::default() }, |w| {
                    // Height, centre, start, end, counter-clockwise.
                    w.reals([0.0, 0.0, 0.0]);
                    w.reals(range.into_iter().flat_map(|t| flat(frame, t)));
                })
            }
            Curve::Ellipse { frame, radii: [a, b] } => {
                let form = [1.0 / (a * a), 0.0, 1.0 / (b * b), 0.0, 0.0, -1.0];
                self.conic(frame, 1, form, range.map(|t| flat(frame, t)))
            }
            Curve::Hyperbola { frame, radii: [a, b] } => {
                let form = [1.0 / (a * a), 0.0, -1.0 / (b * b), 0.0, 0.0, -1.0];
                self.conic(frame, 2, form, range.map(|t| flat(frame, t)))
            }
            Curve::Parabola { frame, focal } => {
                self.conic(frame, 3, [0.0, 0.0, 1.0, -4.0 * focal, 0.0, 0.0], range.map(|t| flat(frame, t)))
            }
            Curve::Spline(spline) => self.spline_curve_over(spline.knots(), spline.points(), range, DEPENDENT),
        }
    }

    /// 104: A x² + B x y + C y² + D x + E y + F = 0.
    fn conic(&mut self, frame: &Frame, form: u32, coefficients: [f64; 6], ends: [[f64; 2]; 2]) -> Entity {
        let matrix = self.matrix(frame);
        self.record(&Head { kind: 104, form, matrix, ..Head::default() }, |w| {
            w.reals(coefficients);
            w.real(0.0);
            w.reals(ends.into_iter().flatten());
        })
    }

    /// 124: from the plane of a frame into space, row by row.
    fn matrix(&mut self, frame: &Frame) -> Entity {
        let (x, y, z, o) = (frame.x, frame.y(), frame.z, frame.origin);
        self.entity(124, DEPENDENT, |w| {
            for k in 0..3 {
                w.reals([x[k], y[k], z[k], o[k]]);
            }
        })
    }

    /// 102: curves end to end.
    pub(super) fn composite(&mut self, curves: &[Entity], status: &str) -> Entity {
        self.entity(102, status, |w| {
            w.integer(curves.len() as u32);
            w.integers(curves.iter().copied());
        })
    }

    pub(super) fn parameter_curve(&mut self, brep: &Brep, of: &EdgeUse) -> Option<Entity> {
        let mut points: Vec<DVec3> = of.parameters.iter().map(|&[u, v]| DVec3::new(u, v, 0.0)).collect();
        if of.reversed {
            points.reverse();
        }
        match (&points[..], &brep.edges[of.edge as usize].curve) {
            ([], _) => None,
            (&[a, b], _) => Some(self.line([a, b], PARAMETRIC)),
            // A point at every knot of the edge.
            (_, Curve::Spline(c)) => {
                let breaks = if of.reversed { c.reversed().knots().breaks() } else { c.knots().breaks() };
                let knots = Knots::from_breaks(1, &breaks, 1).ok()?;
                Some(self.spline_curve(&knots, &points, PARAMETRIC))
            }
            _ => None,
        }
    }

    /// 110
    pub(super) fn line(&mut self, ends: [DVec3; 2], status: &str) -> Entity {
        self.entity(110, status, |w| ends.into_iter().for_each(|p| w.point(p)))
    }

    /// 126
    fn spline_curve(&mut self, knots: &Knots, points: &[DVec3], status: &str) -> Entity {
        self.spline_curve_over(knots, points, knots.domain(), status)
    }

    fn spline_curve_over(&mut self, knots: &Knots, points: &[DVec3], range: [f64; 2], status: &str) -> Entity {
        let flat = u32::from(status == PARAMETRIC);
        self.entity(126, status, |w| {
            w.integers([points.len() as u32 - 1, knots.degree() as u32, flat, 0, 1, 0]);
            w.reals(knots.values().iter().copied());
            w.reals(std::iter::repeat_n(1.0, points.len()));
            points.iter().for_each(|&p| w.point(p));
            w.reals(range);
            w.reals([0.0, 0.0, f64::from(flat)]);
        })
    }
}
