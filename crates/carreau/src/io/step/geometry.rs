//! Points, curves and surfaces.

use super::writer::{Id, Writer};
use crate::brep::{Curve, Frame, Surface};
use crate::geometry::bspline::{BSplineCurve, BSplineSurface, Knots};
use crate::io::text::push_integer;
use glam::DVec3;

impl Writer<'_> {
    pub(super) fn coordinates(&mut self, kind: &str, x: &[f64]) -> Id {
        let id = self.begin();
        self.text(kind);
        self.text("('',");
        self.list(x, |w, &x| w.real(x));
        self.out.push(b')');
        self.end();
        id
    }

    /// The entity of a position; the same one wherever that position occurs.
    pub(super) fn point(&mut self, p: DVec3) -> Id {
        let key = p.to_array().map(f64::to_bits);
        if let Some(&id) = self.points.get(&key) {
            return id;
        }
        let id = self.coordinates("CARTESIAN_POINT", &p.to_array());
        self.points.insert(key, id);
        id
    }

    pub(super) fn point_2d(&mut self, p: [f64; 2]) -> Id {
        let key = p.map(f64::to_bits);
        if let Some(&id) = self.points_2d.get(&key) {
            return id;
        }
        let id = self.coordinates("CARTESIAN_POINT", &p);
        self.points_2d.insert(key, id);
        id
    }

    pub(super) fn direction(&mut self, d: DVec3) -> Id {
        self.coordinates("DIRECTION", &d.to_array())
    }

    pub(super) fn placement(&mut self, frame: &Frame) -> Id {
        let origin = self.point(frame.origin);
        let (z, x) = (self.direction(frame.z), self.direction(frame.x));
        self.entity("AXIS2_PLACEMENT_3D('',#,#,#)", &[origin, z, x])
    }

    /// `KIND('',#placement,number,…)`
    pub(super) fn placed(&mut self, kind: &str, frame: &Frame, numbers: &[f64]) -> Id {
        let placement = self.placement(frame);
        let id = self.begin();
        self.text(kind);
        self.text("('',");
        self.id(placement);
        for &x in numbers {
            self.out.push(b',');
            self.real(x);
        }
        self.out.push(b')');
        self.end();
        id
    }

    pub(super) fn curve(&mut self, curve: &Curve) -> Id {
        match curve {
            Curve::Line { origin, direction } => {
                let origin = self.point(*origin);
                let vector = self.vector(*direction);
                self.entity("LINE('',#,#)", &[origin, vector])
            }
            Curve::Circle { frame, radius } => self.placed("CIRCLE", frame, &[*radius]),
            Curve::Ellipse { frame, radii } => self.placed("ELLIPSE", frame, radii),
            Curve::Parabola { frame, focal } => self.placed("PARABOLA", frame, &[*focal]),
            Curve::Hyperbola { frame, radii } => self.placed("HYPERBOLA", frame, radii),
            Curve::Spline(spline) => self.spline_curve(spline),
        }
    }

    pub(super) fn vector(&mut self, direction: DVec3) -> Id {
        let direction = self.direction(direction);
        self.entity("VECTOR('',#,1.)", &[direction])
    }

    pub(super) fn spline_curve(&mut self, curve: &BSplineCurve) -> Id {
        let points: Vec<Id> = curve.points().iter().map(|&p| self.point(p)).collect();
        let id = self.begin();
        self.text("B_SPLINE_CURVE_WITH_KNOTS('',");
        push_integer(self.out, curve.knots().degree());
        self.out.push(b',');
        self.ids(points);
        self.text(if curve.knots().degree() == 1 { ",.POLYLINE_FORM." } else { ",.UNSPECIFIED." });
        self.text(",.F.,.F.,");
        self.multiplicities(curve.knots());
        self.out.push(b',');
        self.breaks(curve.knots());
        self.text(",.UNSPECIFIED.)");
        self.end();
        id
    }

    pub(super) fn surface(&mut self, surface: &Surface) -> Id {
        match surface {
            Surface::Spline(spline) => self.spline_surface(spline),
            Surface::Plane { frame } => self.placed("PLANE", frame, &[]),
            Surface::Cylinder { frame, radius } => self.placed("CYLINDRICAL_SURFACE", frame, &[*radius]),
            Surface::Cone { frame, radius, half_angle } => {
                self.placed("CONICAL_SURFACE", frame, &[*radius, *half_angle])
            }
            Surface::Sphere { frame, radius } => self.placed("SPHERICAL_SURFACE", frame, &[*radius]),
            Surface::Torus { frame, major_radius, minor_radius } => {
                self.placed("TOROIDAL_SURFACE", frame, &[*major_radius, *minor_radius])
            }
            Surface::Extrusion { profile, direction } => {
                let profile = self.curve(profile);
                let vector = self.vector(*direction);
                self.entity("SURFACE_OF_LINEAR_EXTRUSION('',#,#)", &[profile, vector])
            }
            Surface::Revolution { profile, frame } => {
                let profile = self.curve(profile);
                let (origin, z) = (self.point(frame.origin), self.direction(frame.z));
                let axis = self.entity("AXIS1_PLACEMENT('',#,#)", &[origin, z]);
                self.entity("SURFACE_OF_REVOLUTION('',#,#)", &[profile, axis])
            }
        }
    }

    /// The list of control points has u as its outer index.
    pub(super) fn spline_surface(&mut self, surface: &BSplineSurface) -> Id {
        let [u, v] = surface.knots();
        let points: Vec<Id> = surface.points().iter().map(|&p| self.point(p)).collect();
        let id = self.begin();
        self.text("B_SPLINE_SURFACE_WITH_KNOTS('',");
        push_integer(self.out, u.degree());
        self.out.push(b',');
        push_integer(self.out, v.degree());
        self.out.push(b',');
        self.list(0..u.count(), |w, i| {
            w.text("\n");
            w.ids((0..v.count()).map(|j| points[j * u.count() + i]));
        });
        self.text(",.UNSPECIFIED.,.F.,.F.,.F.,\n");
        self.multiplicities(u);
        self.out.push(b',');
        self.multiplicities(v);
        self.out.push(b',');
        self.breaks(u);
        self.out.push(b',');
        self.breaks(v);
        self.text(",.UNSPECIFIED.)");
        self.end();
        id
    }

    pub(super) fn multiplicities(&mut self, knots: &Knots) {
        self.list(knots.distinct(), |w, (_, m)| push_integer(w.out, m));
    }

    pub(super) fn breaks(&mut self, knots: &Knots) {
        self.list(knots.distinct(), |w, (t, _)| w.real(t));
    }
}
