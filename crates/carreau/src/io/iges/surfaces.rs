//! Surfaces: 128 splines, 108 planes, 120 and 122 swept ones; and 190 to 198, the analytic ones of solids.

use super::records::{Entity, Head, Writer};
use super::words::DEPENDENT;
use crate::brep::{Curve, Frame, Surface};
use crate::geometry::bspline::{BSplineSurface, Knots};
use glam::DVec3;

impl Writer {
    /// A surface of a solid; `extent` are the ranges of u and v that its faces need.
    pub(super) fn surface(&mut self, surface: &Surface, extent: [[f64; 2]; 2]) -> Entity {
        match surface {
            Surface::Plane { frame } => self.placed(190, frame, &[]),
            Surface::Cylinder { frame, radius } => self.placed(192, frame, &[*radius]),
            Surface::Cone { frame, radius, half_angle } => self.placed(194, frame, &[*radius, half_angle.to_degrees()]),
            Surface::Torus { frame, major_radius, minor_radius } => {
                self.placed(198, frame, &[*major_radius, *minor_radius])
            }
            Surface::Sphere { frame, radius } => {
                let origin = self.location(frame.origin);
                let (axis, x) = (self.direction(frame.z), self.direction(frame.x));
                self.record(&Head { kind: 196, form: 1, ..Head::default() }, |w| {
                    w.integer(origin);
                    w.real(*radius);
                    w.integers([axis, x]);
                })
            }
            _ => self.swept(surface, extent),
        }
    }

    /// `location, axis, numbers, reference direction`
    fn placed(&mut self, kind: u32, frame: &Frame, numbers: &[f64]) -> Entity {
        let origin = self.location(frame.origin);
        let (axis, x) = (self.direction(frame.z), self.direction(frame.x));
        self.record(&Head { kind, form: 1, ..Head::default() }, |w| {
            w.integers([origin, axis]);
            w.reals(numbers.iter().copied());
            w.integer(x);
        })
    }

    /// 116
    fn location(&mut self, p: DVec3) -> Entity {
        self.entity(116, DEPENDENT, |w| {
            w.point(p);
            w.integer(0);
        })
    }

    /// 123
    fn direction(&mut self, d: DVec3) -> Entity {
        self.entity(123, DEPENDENT, |w| w.point(d))
    }

    /// A surface in the entities that every reader knows: 108, 120, 122, 128.
    pub(super) fn swept(&mut self, surface: &Surface, [u, v]: [[f64; 2]; 2]) -> Entity {
        match surface {
            Surface::Plane { frame } => self.plane(frame.origin, frame.z),
            Surface::Spline(spline) => self.spline_surface(spline, DEPENDENT),
            Surface::Extrusion { profile, direction } => {
                // 122: a curve, and where its first point goes.
                let base = moved(profile, v[0] * direction);
                let end = base.point(u[0]) + (v[1] - v[0]) * direction;
                let curve = self.curve(&base, u);
                self.entity(122, DEPENDENT, |w| {
                    w.integer(curve);
                    w.point(end);
                })
            }
            Surface::Revolution { profile, frame } => self.revolved(frame, profile, u, v),
            Surface::Cylinder { frame, radius } => {
                let (line, range) = generator(frame, [[*radius, v[0]], [*radius, v[1]]]);
                self.revolved(frame, &line, u, range)
            }
            Surface::Cone { frame, radius, half_angle } => {
                let at = |v: f64| [(radius + v * half_angle.tan()).max(0.0), v];
                let (line, range) = generator(frame, v.map(at));
                self.revolved(frame, &line, u, range)
            }
            Surface::Sphere { frame, radius } => self.revolved(frame, &meridian(frame, 0.0, *radius), u, v),
            Surface::Torus { frame, major_radius, minor_radius } => {
                self.revolved(frame, &meridian(frame, *major_radius, *minor_radius), u, v)
            }
        }
    }

    /// 120: axis, generatrix, start and end angle.
    fn revolved(&mut self, frame: &Frame, profile: &Curve, u: [f64; 2], v: [f64; 2]) -> Entity {
        let axis = self.line([frame.origin, frame.origin + frame.z], DEPENDENT);
        let curve = self.curve(profile, v);
        let turn = u[1] - u[0];
        let start = u[0].rem_euclid(std::f64::consts::TAU);
        self.entity(120, DEPENDENT, |w| {
            w.integers([axis, curve]);
            w.reals([start, start + turn.min(std::f64::consts::TAU)]);
        })
    }

    /// 108: A x + B y + C z = D, unbounded.
    pub(super) fn plane(&mut self, origin: DVec3, normal: DVec3) -> Entity {
        self.entity(108, DEPENDENT, |w| {
            w.point(normal);
            w.real(normal.dot(origin));
            w.integer(0);
            w.point(origin);
            w.real(0.0);
        })
    }

    /// 128, control points with u fastest.
    pub(super) fn spline_surface(&mut self, surface: &BSplineSurface, status: &str) -> Entity {
        let [u, v] = surface.knots();
        self.entity(128, status, |w| {
            w.integers([u.count() - 1, v.count() - 1, u.degree(), v.degree()].map(|k| k as u32));
            w.integers([0, 0, 1, 0, 0]);
            w.reals(u.values().iter().chain(v.values()).copied());
            w.reals(std::iter::repeat_n(1.0, surface.points().len()));
            surface.points().iter().for_each(|&p| w.point(p));
            w.reals([u, v].into_iter().flat_map(Knots::domain));
        })
    }
}

/// A curve moved along a vector.
fn moved(curve: &Curve, by: DVec3) -> Curve {
    curve.moved(&crate::brep::Motion { translation: by, ..crate::brep::Motion::IDENTITY })
}

/// The straight line between two points (distance from the axis, height) in the half plane of a frame.
fn generator(frame: &Frame, ends: [[f64; 2]; 2]) -> (Curve, [f64; 2]) {
    let [a, b] = ends.map(|[rho, z]| frame.global(DVec3::new(rho, 0.0, z)));
    Curve::segment(a, b)
}

/// The circle about a point of the x axis in the half plane of a frame, with the angle that v is.
fn meridian(frame: &Frame, distance: f64, radius: f64) -> Curve {
    let frame = Frame { origin: frame.origin + distance * frame.x, z: -frame.y(), x: frame.x };
    Curve::Circle { frame, radius }
}
