//! Primitives anchored at a point of the surface near the data, as the minimisation sees them.
//!
//! Radius and centre are poor unknowns for a small patch: both run to infinity together as the patch gets flat. Lukács,
//! Martin and Marshall, "Faithful Least-Squares Fitting of Spheres, Cylinders, Cones and Tori for Reliable Segmentation",
//! ECCV 1998, describe the surface near the data instead, by a foot point, directions there and curvatures; a plane is then
//! a sphere of curvature 0, in the middle of the parameter space. We do the same with one form for all five kinds, a
//! circle of curvature `bend` revolved around an axis whose distance from the foot is 1 / `reach`:
//!
//! ```text
//!            axis a          tangent t   normal n              n = e cos φ + a sin φ
//!             |                    \     /                     t = −e sin φ + a cos φ
//!             |                     \   /
//!             |                      \ / φ                     b = a × e
//!             |-----------------------f-------- e (radial)
//!             |       1/reach       .                          plane     reach = bend = 0
//!             |                .                               cylinder  bend = 0, φ = 0
//!             |          x  centre of the profile, f − n/bend  cone      bend = 0
//!             |                                                torus     all free
//! ```
//!
//! A sphere is a circle of curvature `reach` around the foot in every direction: the formulas of the cylinder without the
//! projection along the axis.
//!
//! Distances from a circle of curvature κ through the origin with unit normal n, without cancellation for small κ:
//! d = (κ|y|² + 2 y·n) / (1 + |κy + n|), with derivatives ∂d/∂y = (κy + n)/|κy + n| and ∂d/∂κ = ½ |y − d n|² / |κy + n|². It
//! is applied twice: with `reach` for the distance from the axis, with `bend` in the half plane.
//!
//! Derivatives by rigid motions follow from the gradient g alone: moving the surface with velocity c + ω × (p − f) changes
//! the distance of p by −g·c − ω·((p − f) × g). Motions that leave a kind invariant are no parameters.

use super::shape::{Kind, Primitive, split, unit};
use crate::numeric::levenberg::{Problem, System};
use glam::{DQuat, DVec2, DVec3};

/// Curvature, over that of the size of the data, below which a surface is a plane.
const SMALLEST_CURVATURE: f64 = 1e-6;
/// Half angle, in radians, below which a cone is a cylinder.
const SMALLEST_ANGLE: f64 = 1e-4;
/// Curvatures beyond this are steps gone astray: squares would overflow and make distances vanish.
const LARGEST_CURVATURE: f64 = 1e9;
/// A torus with a smaller ratio of major to minor radius is a sphere.
const SMALLEST_MAJOR: f64 = 1e-6;

/// Kinds with at most this many parameters have a profile that is a line parallel to the axis.
const UNTILTED: usize = 5;

/// See the module. `radial`, `along` = axis × radial and `axis` are orthonormal.
#[derive(Debug, Clone, Copy)]
pub(super) struct Anchored {
    pub kind: Kind,
    /// A point of the surface.
    pub foot: DVec3,
    /// e
    pub radial: DVec3,
    /// b
    along: DVec3,
    /// a
    pub axis: DVec3,
    /// Reciprocal of the signed distance of the foot from the axis; for a sphere of the radius.
    pub reach: f64,
    /// (cos φ, sin φ)
    pub tilt: DVec2,
    /// Curvature of the profile, positive where the surface bends away from n.
    pub bend: f64,
}

impl Anchored {
    /// A surface through `foot`; `axis` is made orthogonal to `radial`. `None` where the directions are parallel.
    pub fn new(
        kind: Kind,
        foot: DVec3,
        radial: DVec3,
        axis: DVec3,
        reach: f64,
        tilt: DVec2,
        bend: f64,
    ) -> Option<Self> {
        let radial = unit(radial);
        let axis = unit(axis - radial * axis.dot(radial));
        let sound = foot.is_finite() && radial != DVec3::ZERO && axis != DVec3::ZERO && reach.is_finite();
        let surface = Anchored { kind, foot, radial, along: axis.cross(radial), axis, reach, tilt, bend };
        (sound && tilt.is_finite() && bend.is_finite()).then_some(surface)
    }

    /// With the same normal and profile tangent t at the foot, the axis leaning by the tilt.
    pub fn from_tangents(
        kind: Kind,
        foot: DVec3,
        n: DVec3,
        t: DVec3,
        reach: f64,
        angle: f64,
        bend: f64,
    ) -> Option<Self> {
        let tilt = DVec2::from_angle(angle);
        Self::new(kind, foot, n * tilt.x - t * tilt.y, n * tilt.y + t * tilt.x, reach, tilt, bend)
    }

    /// A surface without direction of its own: a plane or a sphere.
    pub fn isotropic(kind: Kind, foot: DVec3, normal: DVec3, reach: f64) -> Option<Self> {
        Self::new(kind, foot, normal, normal.any_orthogonal_vector(), reach, DVec2::X, 0.0)
    }

    /// The primitive anchored at the surface point next to `near`, or at a regular one where that is singular.
    pub fn of(primitive: &Primitive, near: DVec3) -> Option<Self> {
        match *primitive {
            Primitive::Plane { origin, normal } => {
                Self::isotropic(Kind::Plane, near - normal * normal.dot(near - origin), normal, 0.0)
            }
            Primitive::Sphere { center, radius } => {
                let radial = radial_or_any(near - center, DVec3::ZERO);
                Self::isotropic(Kind::Sphere, center + radial * radius, radial, radius.recip())
            }
            Primitive::Cylinder { origin, axis, radius } => {
                let offset = near - origin;
                let radial = radial_or_any(offset, axis);
                let foot = origin + axis * axis.dot(offset) + radial * radius;
                Self::new(Kind::Cylinder, foot, radial, axis, radius.recip(), DVec2::X, 0.0)
            }
            Primitive::Cone { apex, axis, half_angle } => {
                let (rho, z, _) = split(near - apex, axis);
                let (sin, cos) = half_angle.sin_cos();
                let radial = radial_or_any(near - apex, axis);
                // A foot at the apex would be singular: keep away as far as the point that was asked for is.
                let slant = (rho * sin + z * cos).max(0.5 * rho.hypot(z));
                let foot = apex + (radial * sin + axis * cos) * slant;
                Self::new(Kind::Cone, foot, radial, axis, (slant * sin).recip(), DVec2::new(cos, -sin), 0.0)
            }
            Primitive::Torus { center, axis, major_radius, minor_radius } => {
                let (rho, z, _) = split(near - center, axis);
                let radial = radial_or_any(near - center, axis);
                let mut tilt = DVec2::new(rho - major_radius, z).normalize_or(DVec2::X);
                if major_radius + minor_radius * tilt.x < 0.1 * (major_radius + minor_radius) {
                    tilt = DVec2::X;
                }
                let from_axis = major_radius + minor_radius * tilt.x;
                let foot = center + radial * from_axis + axis * (minor_radius * tilt.y);
                Self::new(Kind::Torus, foot, radial, axis, from_axis.recip(), tilt, minor_radius.recip())
            }
        }
    }

    /// The surface in its usual form; `None` where it is none of its kind, for example a cylinder of infinite radius, a
    /// cone without an angle or the lemon of a spindle torus.
    pub fn primitive(&self) -> Option<Primitive> {
        let Anchored { foot, axis, .. } = *self;
        if self.kind == Kind::Plane {
            return Some(Primitive::Plane { origin: foot, normal: self.radial });
        }
        if !(self.reach.abs() > SMALLEST_CURVATURE) {
            return None;
        }
        let from_axis = self.reach.abs().recip();
        // With negative reach the axis is on the side of e: the same surface with e and φ mirrored.
        let (radial, tilt) =
            (self.radial * self.reach.signum(), DVec2::new(self.tilt.x * self.reach.signum(), self.tilt.y));
        let on_axis = foot - radial * from_axis;
        let found = match self.kind {
            Kind::Plane | Kind::Sphere => Primitive::Sphere { center: on_axis, radius: from_axis },
            Kind::Cylinder => Primitive::Cylinder { origin: on_axis, axis, radius: from_axis },
            Kind::Cone => {
                let half_angle = (tilt.y / tilt.x).atan().abs();
                // The generator through the foot meets the axis this far along a.
                let to_apex = from_axis * tilt.x / tilt.y;
                if !(half_angle > SMALLEST_ANGLE && to_apex.abs() > SMALLEST_CURVATURE) {
                    return None;
                }
                Primitive::Cone { apex: on_axis + axis * to_apex, axis: axis * -to_apex.signum(), half_angle }
            }
            Kind::Torus => {
                if !(self.bend.abs() > SMALLEST_CURVATURE) {
                    return None;
                }
                let to_centre = -tilt / self.bend;
                let (major_radius, minor_radius) = (from_axis + to_centre.x, self.bend.abs().recip());
                if !(major_radius > SMALLEST_MAJOR * minor_radius) {
                    return None;
                }
                Primitive::Torus { center: on_axis + axis * to_centre.y, axis, major_radius, minor_radius }
            }
        };
        found.is_sound().then_some(found)
    }

    /// n
    fn normal(&self) -> DVec3 {
        self.radial * self.tilt.x + self.axis * self.tilt.y
    }

    /// t
    fn tangent(&self) -> DVec3 {
        self.axis * self.tilt.x - self.radial * self.tilt.y
    }
}

/// The direction of an offset's part orthogonal to the axis, any such direction where there is none.
fn radial_or_any(offset: DVec3, axis: DVec3) -> DVec3 {
    match unit(offset - axis * axis.dot(offset)) {
        DVec3::ZERO if axis == DVec3::ZERO => DVec3::X,
        DVec3::ZERO => axis.any_orthonormal_vector(),
        radial => radial,
    }
}

/// Distance from the circle or sphere of a curvature through the origin with unit normal `n`, its gradient, and its derivative
/// by the curvature.
#[inline]
fn from_sphere(y: DVec3, n: DVec3, curvature: f64) -> (f64, DVec3, f64) {
    let w = y * curvature + n;
    let m = w.length();
    let d = (curvature * y.length_squared() + 2.0 * y.dot(n)) / (1.0 + m);
    let inverse = if m > 0.0 { m.recip() } else { 0.0 };
    (d, w * inverse, 0.5 * (y - n * d).length_squared() * inverse * inverse)
}

/// The same in the plane.
#[inline]
fn from_circle(y: DVec2, n: DVec2, curvature: f64) -> (f64, DVec2, f64) {
    let w = y * curvature + n;
    let m = w.length();
    let d = (curvature * y.length_squared() + 2.0 * y.dot(n)) / (1.0 + m);
    let inverse = if m > 0.0 { m.recip() } else { 0.0 };
    (d, w * inverse, 0.5 * (y - n * d).length_squared() * inverse * inverse)
}

/// The distances of weighted points from an anchored surface with `N` = [`Kind::parameters`] unknowns.
#[derive(Clone, Copy)]
pub(super) struct Distances<'a> {
    pub points: &'a [DVec3],
    /// One per point; all 1 where missing.
    pub weights: Option<&'a [f64]>,
}

impl<const N: usize> Problem<N> for Distances<'_> {
    type State = Anchored;

    /// Parameters: shift along n; rotations around b, t and n (not for the sphere); `reach`; φ with n held; `bend`.
    fn linearise(&self, s: &Anchored, system: &mut System<N>) {
        let (n, t) = (s.normal(), s.tangent());
        let is_sphere = s.kind == Kind::Sphere;
        if !(s.reach.abs() < LARGEST_CURVATURE && s.bend.abs() < LARGEST_CURVATURE) {
            // An infinite cost: the step is refused.
            system.add(f64::INFINITY, &[0.0; N], 1.0);
            return;
        }
        for (k, p) in self.points.iter().enumerate() {
            let q = *p - s.foot;
            let z = if is_sphere { 0.0 } else { q.dot(s.axis) };
            let (x, outward, x_reach) = from_sphere(q - s.axis * z, s.radial, s.reach);
            let (mut d, mut d_xz, mut d_bend) = (x, DVec2::X, 0.0);
            if N > UNTILTED {
                (d, d_xz, d_bend) = from_circle(DVec2::new(x, z), s.tilt, s.bend);
            }
            let g = outward * d_xz.x + s.axis * d_xz.y;
            let moment = g.cross(q);
            let (turn_b, turn_t, turn_n) = (moment.dot(s.along), moment.dot(t), moment.dot(n));
            let by_reach = d_xz.x * x_reach;
            // Turning the profile within its half plane, and the whole back.
            let by_tilt = d_xz.x * z - d_xz.y * x + turn_b;
            let mut row = [0.0; N];
            let all = [-g.dot(n), turn_b, turn_t, if is_sphere { by_reach } else { turn_n }, by_reach, by_tilt, d_bend];
            row.iter_mut().zip(all).for_each(|(entry, value)| *entry = value);
            system.add(d, &row, self.weights.map_or(1.0, |w| w[k]));
        }
    }

    fn moved(&self, s: &Anchored, step: &[f64; N]) -> Anchored {
        let mut all = [0.0; 7];
        all.iter_mut().zip(step).for_each(|(entry, value)| *entry = *value);
        let [shift, turn_b, turn_t, mut turn_n, mut by_reach, by_tilt, by_bend] = all;
        if s.kind == Kind::Sphere {
            (by_reach, turn_n) = (turn_n, 0.0);
        }
        let (n, t) = (s.normal(), s.tangent());
        let turn = DQuat::from_scaled_axis(s.along * (turn_b + by_tilt) + t * turn_t + n * turn_n);
        let radial = (turn * s.radial).normalize_or(s.radial);
        let axis = turn * s.axis;
        let axis = (axis - radial * axis.dot(radial)).normalize_or(s.axis);
        Anchored {
            foot: s.foot + n * shift,
            radial,
            along: axis.cross(radial),
            axis,
            reach: s.reach + by_reach,
            tilt: DVec2::from_angle(by_tilt).rotate(s.tilt).normalize_or(s.tilt),
            bend: s.bend + by_bend,
            ..*s
        }
    }
}
