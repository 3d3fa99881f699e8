//! Points, derivatives, normals and curvatures of surfaces.

use super::Surface;
use crate::brep::frame::Frame;
use crate::geometry::bspline::Jet;
use glam::DVec3;

/// A profile in the (distance from the axis, height) half plane: values, first and second derivatives.
type Profile = [[f64; 2]; 3];

impl Surface {
    /// The point at a pair of parameters.
    pub fn point(&self, u: f64, v: f64) -> DVec3 {
        match self {
            Surface::Spline(s) => s.point(u, v),
            Surface::Plane { frame } => frame.origin + u * frame.x + v * frame.y(),
            Surface::Extrusion { profile, direction } => profile.point(u) + v * direction,
            Surface::Revolution { profile, frame } => {
                let l = frame.local(profile.point(v));
                frame.origin + l.x * frame.radial(u) + l.z * frame.z
            }
            _ => self.jet(u, v).point,
        }
    }

    /// Point, first and second derivatives.
    pub fn jet(&self, u: f64, v: f64) -> Jet {
        match self {
            Surface::Plane { frame } => Jet {
                point: frame.origin + u * frame.x + v * frame.y(),
                first: [frame.x, frame.y()],
                second: [DVec3::ZERO; 3],
            },
            Surface::Cylinder { frame, radius } => revolved(frame, u, [[*radius, v], [0.0, 1.0], [0.0, 0.0]]),
            Surface::Cone { frame, radius, half_angle } => {
                let slope = half_angle.tan();
                revolved(frame, u, [[radius + v * slope, v], [slope, 1.0], [0.0, 0.0]])
            }
            Surface::Sphere { frame, radius } => revolved(frame, u, circle(0.0, *radius, v)),
            Surface::Torus { frame, major_radius, minor_radius } => {
                revolved(frame, u, circle(*major_radius, *minor_radius, v))
            }
            Surface::Extrusion { profile, direction } => {
                let [c, d, dd] = profile.derivatives(u);
                Jet { point: c + v * direction, first: [d, *direction], second: [dd, DVec3::ZERO, DVec3::ZERO] }
            }
            Surface::Revolution { profile, frame } => {
                let [c, d, dd] = profile.derivatives(v);
                let flat = |a: DVec3| [a.dot(frame.x), a.dot(frame.z)];
                revolved(frame, u, [flat(c - frame.origin), flat(d), flat(dd)])
            }
            Surface::Spline(s) => s.jet(u, v),
        }
    }

    /// The unit normal along ∂S/∂u × ∂S/∂v; at poles and apexes its limit along the meridian of `u`. Zero where there is
    /// none.
    pub fn normal(&self, u: f64, v: f64) -> DVec3 {
        let turned = |frame: &Frame, [dx, dz]: [f64; 2]| (dz * frame.radial(u) - dx * frame.z).normalize_or_zero();
        match self {
            Surface::Plane { frame } => frame.z,
            Surface::Cylinder { frame, .. } => frame.radial(u),
            Surface::Cone { frame, half_angle, .. } => turned(frame, [half_angle.tan(), 1.0]),
            Surface::Sphere { frame, .. } | Surface::Torus { frame, .. } => turned(frame, [-v.sin(), v.cos()]),
            Surface::Revolution { profile, frame } => {
                let d = profile.derivatives(v)[1];
                turned(frame, [d.dot(frame.x), d.dot(frame.z)])
            }
            Surface::Extrusion { profile, direction } => {
                profile.derivatives(u)[1].cross(*direction).normalize_or_zero()
            }
            Surface::Spline(s) => {
                let [a, b] = s.jet(u, v).first;
                a.cross(b).normalize_or_zero()
            }
        }
    }

    /// Principal curvatures, the smaller one first; positive where the surface bends away from its normal, as a sphere
    /// does. Infinite at the apex of a cone.
    pub fn principal_curvatures(&self, u: f64, v: f64) -> [f64; 2] {
        let sorted = |a: f64, b: f64| [a.min(b), a.max(b)];
        match self {
            Surface::Plane { .. } => [0.0, 0.0],
            Surface::Cylinder { radius, .. } => [0.0, 1.0 / radius],
            Surface::Cone { radius, half_angle, .. } => {
                [0.0, half_angle.cos() / (radius + v * half_angle.tan()).max(0.0)]
            }
            Surface::Sphere { radius, .. } => [1.0 / radius; 2],
            Surface::Torus { major_radius, minor_radius, .. } => {
                sorted(1.0 / minor_radius, v.cos() / (major_radius + minor_radius * v.cos()))
            }
            _ => curvatures_of(&self.jet(u, v)),
        }
    }
}

/// A circle about (centre, 0) in the half plane.
fn circle(centre: f64, radius: f64, v: f64) -> Profile {
    let (sin, cos) = v.sin_cos();
    let (x, z) = (radius * cos, radius * sin);
    [[centre + x, z], [-z, x], [-x, -z]]
}

/// The jet of a profile turned by `u`.
fn revolved(frame: &Frame, u: f64, [p, d, dd]: Profile) -> Jet {
    let (out, across) = (frame.radial(u), frame.radial(u + std::f64::consts::FRAC_PI_2));
    let along = |[x, z]: [f64; 2]| x * out + z * frame.z;
    Jet {
        point: frame.origin + along(p),
        first: [p[0] * across, along(d)],
        second: [-p[0] * out, d[0] * across, along(dd)],
    }
}

/// Eigenvalues of the shape operator, from the two fundamental forms.
fn curvatures_of(jet: &Jet) -> [f64; 2] {
    let [su, sv] = jet.first;
    let normal = su.cross(sv).normalize_or_zero();
    let (e, f, g) = (su.dot(su), su.dot(sv), sv.dot(sv));
    let [l, m, n] = jet.second.map(|d| -d.dot(normal));
    let area = e * g - f * f;
    let mean = 0.5 * (e * n - 2.0 * f * m + g * l) / area;
    let gauss = (l * n - m * m) / area;
    let root = (mean * mean - gauss).max(0.0).sqrt();
    [mean - root, mean + root]
}
