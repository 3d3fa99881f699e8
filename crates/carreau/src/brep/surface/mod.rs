//! Surfaces: what faces lie on.
//!
//! | file | holds |
//! |---|---|
//! | `mod` | the kinds, their parameters, periods |
//! | `evaluate` | point, derivatives, normal, principal curvatures |
//! | `project` | the parameters of the nearest point |
//!
//! Parameters are those of ISO 10303-42 (E = origin of the frame, ρ(u) = cos u x + sin u y), and so are normals, ∂S/∂u × ∂S/∂v:
//!
//! | kind | point at (u, v) | normal points |
//! |---|---|---|
//! | plane | E + u x + v y | along z |
//! | cylinder | E + r ρ(u) + v z | away from the axis |
//! | cone | E + (r + v tan α) ρ(u) + v z | away from the axis |
//! | sphere | E + r cos v ρ(u) + r sin v z | away from the centre |
//! | torus | E + (R + r cos v) ρ(u) + r sin v z | out of the tube |
//! | extrusion | C(u) + v d | along C' × d |
//! | revolution | C(v) turned by u about z | to the right of the profile, seen with x to the right and z up |
//! | spline | B-spline of degree 1 to 3, clamped | along S_u × S_v |

mod evaluate;
mod project;

use super::curve::Curve;
use super::frame::{Frame, Motion};
use crate::geometry::bspline::BSplineSurface;
use crate::geometry::primitive::Primitive;
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, TAU};

/// An oriented surface.
#[derive(Debug, Clone, PartialEq)]
pub enum Surface {
    /// The plane z = 0 of a frame.
    Plane {
        /// Origin, normal, and the direction of u.
        frame: Frame,
    },
    /// A circular cylinder around z.
    Cylinder {
        /// A point of the axis, its direction, and where u is 0.
        frame: Frame,
        /// Above 0.
        radius: f64,
    },
    /// The nappe of a circular cone around z that widens upwards.
    Cone {
        /// A point of the axis, its direction away from the apex, and where u is 0.
        frame: Frame,
        /// At the origin of the frame; not below 0, and 0 where that is the apex.
        radius: f64,
        /// Between axis and generators, above 0 and below π/2.
        half_angle: f64,
    },
    /// A sphere.
    Sphere {
        /// Centre, the direction of the pole with v = π/2, and where u is 0.
        frame: Frame,
        /// Above 0.
        radius: f64,
    },
    /// A circle revolved around z. Where the minor radius exceeds the major one, the part of the tube on the far side of
    /// the axis (the inner leaf) belongs to no face.
    Torus {
        /// Centre, axis, and where u is 0.
        frame: Frame,
        /// Distance of the tube's centre from the axis, above 0.
        major_radius: f64,
        /// Of the tube, above 0.
        minor_radius: f64,
    },
    /// A curve moved along a straight line.
    Extrusion {
        /// In a plane perpendicular to the direction.
        profile: Curve,
        /// A unit vector.
        direction: DVec3,
    },
    /// A curve turned around a line.
    Revolution {
        /// In the half plane y = 0, x ≥ 0 of the frame.
        profile: Curve,
        /// A point of the axis, its direction, and the profile's plane.
        frame: Frame,
    },
    /// A B-spline surface. Its parameters are not periodic, even where it is closed.
    Spline(BSplineSurface),
}

/// The kinds of surfaces, simplest first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum SurfaceKind {
    /// A plane.
    Plane,
    /// A circular cylinder.
    Cylinder,
    /// A circular cone.
    Cone,
    /// A sphere.
    Sphere,
    /// A torus.
    Torus,
    /// A surface of linear extrusion.
    Extrusion,
    /// A surface of revolution.
    Revolution,
    /// A B-spline surface.
    Spline,
}

impl SurfaceKind {
    /// Every kind, simplest first.
    pub const ALL: [SurfaceKind; 8] = [
        SurfaceKind::Plane,
        SurfaceKind::Cylinder,
        SurfaceKind::Cone,
        SurfaceKind::Sphere,
        SurfaceKind::Torus,
        SurfaceKind::Extrusion,
        SurfaceKind::Revolution,
        SurfaceKind::Spline,
    ];

    /// The name in records and of faces: `plane`, `cylinder`, `cone`, `sphere`, `torus`, `extrusion`, `revolution` or
    /// `bspline`.
    pub fn name(self) -> &'static str {
        match self {
            SurfaceKind::Plane => "plane",
            SurfaceKind::Cylinder => "cylinder",
            SurfaceKind::Cone => "cone",
            SurfaceKind::Sphere => "sphere",
            SurfaceKind::Torus => "torus",
            SurfaceKind::Extrusion => "extrusion",
            SurfaceKind::Revolution => "revolution",
            SurfaceKind::Spline => "bspline",
        }
    }
}

impl Surface {
    /// A primitive as a surface, with its u = 0 anywhere. Normals are those of the primitive.
    pub fn of_primitive(primitive: &Primitive) -> Self {
        match *primitive {
            Primitive::Plane { origin, normal } => Surface::Plane { frame: Frame::along(origin, normal) },
            Primitive::Cylinder { origin, axis, radius } => {
                Surface::Cylinder { frame: Frame::along(origin, axis), radius }
            }
            Primitive::Cone { apex, axis, half_angle } => {
                Surface::Cone { frame: Frame::along(apex, axis), radius: 0.0, half_angle }
            }
            Primitive::Sphere { center, radius } => Surface::Sphere { frame: Frame::along(center, DVec3::Z), radius },
            Primitive::Torus { center, axis, major_radius, minor_radius } => {
                Surface::Torus { frame: Frame::along(center, axis), major_radius, minor_radius }
            }
        }
    }

    /// Which kind this is.
    pub fn kind(&self) -> SurfaceKind {
        match self {
            Surface::Plane { .. } => SurfaceKind::Plane,
            Surface::Cylinder { .. } => SurfaceKind::Cylinder,
            Surface::Cone { .. } => SurfaceKind::Cone,
            Surface::Sphere { .. } => SurfaceKind::Sphere,
            Surface::Torus { .. } => SurfaceKind::Torus,
            Surface::Extrusion { .. } => SurfaceKind::Extrusion,
            Surface::Revolution { .. } => SurfaceKind::Revolution,
            Surface::Spline(_) => SurfaceKind::Spline,
        }
    }

    /// The lengths in u and v after which the surface repeats itself.
    pub fn periods(&self) -> [Option<f64>; 2] {
        match self {
            Surface::Plane { .. } | Surface::Spline(_) => [None, None],
            Surface::Cylinder { .. } | Surface::Cone { .. } | Surface::Sphere { .. } => [Some(TAU), None],
            Surface::Torus { .. } => [Some(TAU), Some(TAU)],
            Surface::Extrusion { profile, .. } => [profile.period(), None],
            Surface::Revolution { profile, .. } => [Some(TAU), profile.period()],
        }
    }

    /// First and last u, first and last v: infinite where there is no end, one period from 0 on (from the beginning of a
    /// closed spline) where the surface is periodic.
    pub fn domain(&self) -> [[f64; 2]; 2] {
        const ALL: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];
        const TURN: [f64; 2] = [0.0, TAU];
        match self {
            Surface::Plane { .. } => [ALL, ALL],
            Surface::Cylinder { .. } => [TURN, ALL],
            Surface::Cone { radius, half_angle, .. } => [TURN, [-radius / half_angle.tan(), f64::INFINITY]],
            Surface::Sphere { .. } => [TURN, [-FRAC_PI_2, FRAC_PI_2]],
            Surface::Torus { major_radius, minor_radius, .. } if minor_radius > major_radius => {
                let end = (-major_radius / minor_radius).acos();
                [TURN, [-end, end]]
            }
            Surface::Torus { .. } => [TURN, TURN],
            Surface::Extrusion { profile, .. } => [profile.domain(), ALL],
            Surface::Revolution { profile, .. } => [TURN, profile.domain()],
            Surface::Spline(s) => s.knots().map(|k| k.domain()),
        }
    }

    /// The surface after a motion.
    pub fn moved(&self, by: &Motion) -> Self {
        let s = by.scale;
        match self {
            Surface::Plane { frame } => Surface::Plane { frame: frame.moved(by) },
            Surface::Cylinder { frame, radius } => Surface::Cylinder { frame: frame.moved(by), radius: s * radius },
            Surface::Cone { frame, radius, half_angle } => {
                Surface::Cone { frame: frame.moved(by), radius: s * radius, half_angle: *half_angle }
            }
            Surface::Sphere { frame, radius } => Surface::Sphere { frame: frame.moved(by), radius: s * radius },
            Surface::Torus { frame, major_radius, minor_radius } => Surface::Torus {
                frame: frame.moved(by),
                major_radius: s * major_radius,
                minor_radius: s * minor_radius,
            },
            Surface::Extrusion { profile, direction } => {
                Surface::Extrusion { profile: profile.moved(by), direction: by.rotation * *direction }
            }
            Surface::Revolution { profile, frame } => {
                Surface::Revolution { profile: profile.moved(by), frame: frame.moved(by) }
            }
            Surface::Spline(surface) => Surface::Spline(surface.mapped(|p| by.point(p))),
        }
    }

    /// Whether every number is finite and every radius, angle and direction is in its range.
    pub fn is_sound(&self) -> bool {
        let positive = |x: &f64| *x > 0.0 && x.is_finite();
        match self {
            Surface::Plane { frame } => frame.is_sound(),
            Surface::Cylinder { frame, radius } | Surface::Sphere { frame, radius } => {
                frame.is_sound() && positive(radius)
            }
            Surface::Cone { frame, radius, half_angle } => {
                let narrow = *half_angle > 0.0 && *half_angle < FRAC_PI_2;
                frame.is_sound() && *radius >= 0.0 && radius.is_finite() && narrow
            }
            Surface::Torus { frame, major_radius, minor_radius } => {
                frame.is_sound() && positive(major_radius) && positive(minor_radius)
            }
            Surface::Extrusion { profile, direction } => profile.is_sound() && (direction.length() - 1.0).abs() < 1e-9,
            Surface::Revolution { profile, frame } => profile.is_sound() && frame.is_sound(),
            Surface::Spline(s) => s.points().iter().all(|p| p.is_finite()),
        }
    }
}
