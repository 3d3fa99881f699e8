//! The surfaces themselves: planes, spheres, cylinders, cones and tori.

use glam::{DVec2, DVec3};

/// A surface. Directions are unit vectors, radii positive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Primitive {
    /// All points with (p − origin)·normal = 0.
    Plane {
        /// A point of the plane.
        origin: DVec3,
        /// Unit normal.
        normal: DVec3,
    },
    /// An infinite circular cylinder.
    Cylinder {
        /// A point of the axis.
        origin: DVec3,
        /// Unit direction of the axis.
        axis: DVec3,
        /// Distance of the surface from the axis.
        radius: f64,
    },
    /// One nappe of a circular cone.
    Cone {
        /// The tip.
        apex: DVec3,
        /// Unit direction from the apex into the nappe.
        axis: DVec3,
        /// Angle between axis and generators in radians, above 0 and below π/2.
        half_angle: f64,
    },
    /// A sphere.
    Sphere {
        /// Its centre.
        center: DVec3,
        /// Its radius.
        radius: f64,
    },
    /// A circle revolved around an axis in its plane.
    ///
    /// Where `minor_radius` exceeds `major_radius` the circle crosses the axis (a spindle torus); the surface meant is then
    /// the outer part, the apple: the circle's points on the centre's side of the axis. The inner part, the lemon, is
    /// not a primitive.
    Torus {
        /// The point of the axis in the plane of symmetry.
        center: DVec3,
        /// Unit direction of the axis.
        axis: DVec3,
        /// Distance of the circle's centre from the axis.
        major_radius: f64,
        /// Radius of the circle.
        minor_radius: f64,
    },
}

/// The five kinds of primitives, simplest first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Kind {
    /// A plane.
    Plane,
    /// A sphere.
    Sphere,
    /// A circular cylinder.
    Cylinder,
    /// A circular cone.
    Cone,
    /// A torus.
    Torus,
}

impl Kind {
    /// Every kind, simplest first.
    pub const ALL: [Kind; 5] = [Kind::Plane, Kind::Sphere, Kind::Cylinder, Kind::Cone, Kind::Torus];

    /// Number of parameters that determine a surface of this kind: 3 to 7.
    pub fn parameters(self) -> usize {
        match self {
            Kind::Plane => 3,
            Kind::Sphere => 4,
            Kind::Cylinder => 5,
            Kind::Cone => 6,
            Kind::Torus => 7,
        }
    }

    /// The name in records: `plane`, `sphere`, `cylinder`, `cone` or `torus`.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Plane => "plane",
            Kind::Sphere => "sphere",
            Kind::Cylinder => "cylinder",
            Kind::Cone => "cone",
            Kind::Torus => "torus",
        }
    }
}

impl Primitive {
    /// Which of the five kinds this is.
    pub fn kind(&self) -> Kind {
        match self {
            Primitive::Plane { .. } => Kind::Plane,
            Primitive::Cylinder { .. } => Kind::Cylinder,
            Primitive::Cone { .. } => Kind::Cone,
            Primitive::Sphere { .. } => Kind::Sphere,
            Primitive::Torus { .. } => Kind::Torus,
        }
    }

    /// The surface where its points and lengths are mapped, by a similarity that turns nothing.
    pub(crate) fn moved(self, point: impl Fn(DVec3) -> DVec3, length: impl Fn(f64) -> f64) -> Primitive {
        match self {
            Primitive::Plane { origin, normal } => Primitive::Plane { origin: point(origin), normal },
            Primitive::Sphere { center, radius } => Primitive::Sphere { center: point(center), radius: length(radius) },
            Primitive::Cylinder { origin, axis, radius } => {
                Primitive::Cylinder { origin: point(origin), axis, radius: length(radius) }
            }
            Primitive::Cone { apex, axis, half_angle } => Primitive::Cone { apex: point(apex), axis, half_angle },
            Primitive::Torus { center, axis, major_radius, minor_radius } => Primitive::Torus {
                center: point(center),
                axis,
                major_radius: length(major_radius),
                minor_radius: length(minor_radius),
            },
        }
    }

    /// Signed distance of a point, in the unit of the points: positive on the side of [`Primitive::normal`], which is
    /// outside the ball, the cylinder, the solid cone and the tube.
    pub fn distance(&self, p: DVec3) -> f64 {
        match *self {
            Primitive::Plane { origin, normal } => normal.dot(p - origin),
            Primitive::Sphere { center, radius } => length(p - center) - radius,
            Primitive::Cylinder { origin, axis, radius } => split(p - origin, axis).0 - radius,
            Primitive::Cone { apex, axis, half_angle } => {
                let (rho, z, _) = split(p - apex, axis);
                let (sin, cos) = half_angle.sin_cos();
                if rho * sin + z * cos > 0.0 { rho * cos - z * sin } else { length(p - apex) }
            }
            Primitive::Torus { center, axis, major_radius, minor_radius } => {
                let (rho, z, _) = split(p - center, axis);
                (rho - major_radius).hypot(z) - minor_radius
            }
        }
    }

    /// Unit normal at the surface point next to `p`, pointing away from the centre, the axis or the centre circle of the
    /// tube; zero where that point is not unique (centre, axis, centre circle) or has no normal (apex).
    pub fn normal(&self, p: DVec3) -> DVec3 {
        match *self {
            Primitive::Plane { normal, .. } => normal,
            Primitive::Sphere { center, .. } => unit(p - center),
            Primitive::Cylinder { origin, axis, .. } => split(p - origin, axis).2,
            Primitive::Cone { apex, axis, half_angle } => {
                let (rho, z, radial) = split(p - apex, axis);
                let (sin, cos) = half_angle.sin_cos();
                let smooth = rho > 0.0 && rho * sin + z * cos > 0.0;
                if smooth { radial * cos - axis * sin } else { DVec3::ZERO }
            }
            Primitive::Torus { center, axis, major_radius, .. } => {
                let (rho, z, radial) = split(p - center, axis);
                let tube = unit(DVec3::new(rho - major_radius, z, 0.0));
                if rho > 0.0 { radial * tube.x + axis * tube.y } else { DVec3::ZERO }
            }
        }
    }

    /// Whether every number is finite and every radius and angle is in its range.
    pub(crate) fn is_sound(&self) -> bool {
        let positive = |x: f64| x > 0.0 && x.is_finite();
        let direction = |d: DVec3| (d.length() - 1.0).abs() < 1e-9;
        match *self {
            Primitive::Plane { origin, normal } => origin.is_finite() && direction(normal),
            Primitive::Sphere { center, radius } => center.is_finite() && positive(radius),
            Primitive::Cylinder { origin, axis, radius } => origin.is_finite() && direction(axis) && positive(radius),
            Primitive::Cone { apex, axis, half_angle } => {
                apex.is_finite() && direction(axis) && positive(half_angle) && half_angle < std::f64::consts::FRAC_PI_2
            }
            Primitive::Torus { center, axis, major_radius, minor_radius } => {
                center.is_finite() && direction(axis) && positive(major_radius) && positive(minor_radius)
            }
        }
    }
}

/// Distance from the axis, height along it, and the unit radial direction (zero on the axis) of an offset.
#[inline]
pub fn split(offset: DVec3, axis: DVec3) -> (f64, f64, DVec3) {
    let z = offset.dot(axis);
    let radial = offset - axis * z;
    (length(radial), z, unit(radial))
}

/// In the (distance from the axis, height) half plane.
#[inline]
pub fn profile_point(offset: DVec3, axis: DVec3) -> DVec2 {
    let z = offset.dot(axis);
    DVec2::new((offset - axis * z).length(), z)
}

/// The length of a vector, also where its square is out of range.
#[inline]
pub fn length(v: DVec3) -> f64 {
    let square = v.length_squared();
    if (1e-280..1e280).contains(&square) {
        return square.sqrt();
    }
    let largest = v.abs().max_element();
    if largest > 0.0 && largest.is_finite() { (v / largest).length() * largest } else { largest }
}

/// The direction of a vector, zero for the zero vector.
#[inline]
pub fn unit(v: DVec3) -> DVec3 {
    let l = length(v);
    // Two divisions: the reciprocal of a tiny length is out of range.
    if l > 0.0 && l.is_finite() { (v / l).normalize_or_zero() } else { DVec3::ZERO }
}
