//! Curves in which two surfaces meet that have a name: candidates, which the caller checks against both surfaces.
//!
//! Every pair offers the closed forms of its kind, whether they apply or not quite: what is near to parallel or to tangent is
//! decided by the distance of the candidate, not by an angle.

use super::tuning::PARALLEL_ANGLE;
use crate::brep::{Curve, Frame, Surface};
use crate::geometry::primitive::Primitive;
use glam::{DVec2, DVec3};

/// Sine, or the same as a share of a radius: below it a direction is tried as parallel as well, because what does not
/// fit is refused by its distance.
const NEARLY_PARALLEL: f64 = 1e-3;

/// Candidates for the curve of two surfaces near the points of an edge, the exact ones first.
pub fn candidates(a: &Primitive, b: &Primitive, points: &[DVec3]) -> Vec<Curve> {
    let mut found = Vec::new();
    pair(a, b, points, &mut found);
    pair(b, a, points, &mut found);
    if let Some(axis) = common_axis(a, b) {
        found.extend(coaxial_circle(a, b, axis, points));
    }
    for p in [a, b] {
        own_lines(p, points, &mut found);
    }
    found.retain(Curve::is_sound);
    found
}

fn mean(points: &[DVec3]) -> DVec3 {
    points.iter().sum::<DVec3>() / points.len().max(1) as f64
}

fn pair(a: &Primitive, b: &Primitive, points: &[DVec3], out: &mut Vec<Curve>) {
    use Primitive as P;
    match (*a, *b) {
        (P::Plane { origin, normal }, P::Plane { origin: o, normal: n }) => {
            out.extend(plane_plane((origin, normal), (o, n), mean(points)));
        }
        (P::Plane { origin, normal }, P::Cylinder { origin: o, axis, radius }) => {
            plane_cylinder((origin, normal), (o, axis, radius), out);
        }
        (P::Plane { origin, normal }, P::Sphere { center, radius }) => {
            let h = normal.dot(origin - center);
            let r = (radius * radius - h * h).max(0.0).sqrt();
            out.push(Curve::Circle { frame: Frame::along(center + h * normal, normal), radius: r });
        }
        (P::Plane { origin, normal }, P::Cone { apex, axis, half_angle }) => {
            plane_cone((origin, normal), (apex, axis, half_angle), out);
        }
        (P::Plane { normal, .. }, P::Torus { center, axis, major_radius, minor_radius }) => {
            let across = axis.cross(normal);
            for sign in [1.0, -1.0] {
                let center = center + sign * major_radius * across.normalize_or_zero();
                out.push(Curve::Circle { frame: Frame::along(center, normal), radius: minor_radius });
            }
        }
        (P::Cylinder { origin, axis, radius }, P::Cylinder { origin: o, axis: d, radius: r }) => {
            if axis.cross(d).length() < NEARLY_PARALLEL {
                parallel_cylinders((origin, axis, radius), (o, r), out);
            } else if (radius - r).abs() < NEARLY_PARALLEL * radius {
                let d = if axis.dot(d) < 0.0 { -d } else { d };
                // The point in the middle between the axes.
                let n = axis.cross(d);
                let t = (o - origin).cross(d).dot(n) / n.length_squared();
                let s = (o - origin).cross(axis).dot(n) / n.length_squared();
                let x = 0.5 * (origin + t * axis + o + s * d);
                for normal in [axis - d, axis + d] {
                    plane_cylinder((x, normal.normalize_or_zero()), (origin, axis, radius), out);
                }
            }
        }
        (P::Cylinder { axis, .. }, P::Torus { center, axis: z, major_radius, minor_radius }) => {
            // The end of a bend of a pipe.
            let outward = z.cross(axis).normalize_or_zero();
            for sign in [1.0, -1.0] {
                let center = center + sign * major_radius * outward;
                out.push(Curve::Circle { frame: Frame::along(center, axis), radius: minor_radius });
            }
        }
        _ => {}
    }
}

fn plane_plane(a: (DVec3, DVec3), b: (DVec3, DVec3), near: DVec3) -> Option<Curve> {
    let direction = a.1.cross(b.1);
    if direction.length() < 1e-7 {
        return None;
    }
    let direction = direction.normalize();
    // The point next to `near`: the steps along both normals.
    let c = a.1.dot(b.1);
    let (da, db) = (a.1.dot(a.0 - near), b.1.dot(b.0 - near));
    let s = 1.0 - c * c;
    let origin = near + a.1 * ((da - c * db) / s) + b.1 * ((db - c * da) / s);
    Some(Curve::Line { origin, direction })
}

fn plane_cylinder(plane: (DVec3, DVec3), cylinder: (DVec3, DVec3, f64), out: &mut Vec<Curve>) {
    let ((origin, n), (o, axis, radius)) = (plane, cylinder);
    let c = n.dot(axis);
    if c.abs() < NEARLY_PARALLEL {
        // Lines along the axis; one where the plane touches.
        let across = axis.cross(n).normalize_or_zero();
        let down = across.cross(axis);
        let h = n.dot(origin - o) / n.dot(down);
        if (h.abs() - radius).abs() < NEARLY_PARALLEL * radius {
            out.push(Curve::Line { origin: o + down * radius.copysign(h), direction: axis });
            out.push(Curve::Line { origin: o + down * h, direction: axis });
        }
        let w = (radius * radius - h * h).max(0.0).sqrt();
        for sign in [1.0, -1.0] {
            out.push(Curve::Line { origin: o + down * h + sign * w * across, direction: axis });
        }
        return;
    }
    let center = o + axis * (n.dot(origin - o) / c);
    if n.cross(axis).length() < NEARLY_PARALLEL {
        out.push(Curve::Circle { frame: Frame::along(center, axis), radius });
    }
    let along = axis - n * c;
    if along.length() > PARALLEL_ANGLE {
        out.push(Curve::Ellipse { frame: Frame::new(center, n, along), radii: [radius / c.abs(), radius] });
    }
}

/// Lines through the apex, or a conic; lengths in the plane of symmetry, which the axis and the normal span.
fn plane_cone(plane: (DVec3, DVec3), cone: (DVec3, DVec3, f64), out: &mut Vec<Curve>) {
    let ((origin, mut n), (apex, z, alpha)) = (plane, cone);
    if n.dot(z) < 0.0 {
        n = -n;
    }
    let h = n.dot(origin - apex);
    let (sin, cos) = alpha.sin_cos();
    let tilt = n - z * n.dot(z);
    if tilt.length() < NEARLY_PARALLEL {
        let center = apex + z * (h / n.dot(z));
        out.push(Curve::Circle { frame: Frame::along(center, z), radius: h.abs() * alpha.tan() });
        if tilt.length() < PARALLEL_ANGLE {
            return;
        }
    }
    let w = tilt.normalize_or_zero();
    let m = z.cross(w);
    // Generators z cos α + (w cos φ + m sin φ) sin α in the plane's direction.
    let (nz, nw) = (n.dot(z), n.dot(w));
    let turn = -nz * cos / (nw * sin);
    if turn.abs() <= 1.0 + NEARLY_PARALLEL {
        let phi = turn.clamp(-1.0, 1.0).acos();
        for phi in [phi, -phi] {
            let direction = z * cos + (w * phi.cos() + m * phi.sin()) * sin;
            out.push(Curve::Line { origin: apex, direction: direction.normalize_or_zero() });
        }
    }
    let generators = [z * cos + w * sin, z * cos - w * sin];
    let inward = (z - n * nz).normalize_or_zero();
    let [p, q] = generators.map(|g| n.dot(g));
    let square = |x: DVec3| {
        let (height, radial) = ((x - apex).dot(z), (x - apex).dot(w));
        alpha.tan().powi(2) * height * height - radial * radial
    };
    if p.min(q).abs() < 1e-9 {
        let (g, s) = if p.abs() > q.abs() { (generators[0], p) } else { (generators[1], q) };
        let vertex = apex + g * (h / s);
        let inside = if square(vertex + inward * h.abs()) > 0.0 { inward } else { -inward };
        let focal = square(vertex + inside * h.abs()) / (4.0 * h.abs());
        out.push(Curve::Parabola { frame: Frame::new(vertex, n, inside), focal });
        return;
    }
    let [a, b] = [apex + generators[0] * (h / p), apex + generators[1] * (h / q)];
    let (center, half) = (0.5 * (a + b), 0.5 * a.distance(b));
    let s = square(center);
    if p * q > 0.0 && s > 0.0 {
        let (frame, radii) = if half >= s.sqrt() {
            (Frame::new(center, n, a - center), [half, s.sqrt()])
        } else {
            (Frame::new(center, n, m), [s.sqrt(), half])
        };
        out.push(Curve::Ellipse { frame, radii });
    } else if p * q < 0.0 && s < 0.0 {
        let vertex = if h * p > 0.0 { a } else { b };
        out.push(Curve::Hyperbola { frame: Frame::new(center, n, vertex - center), radii: [half, (-s).sqrt()] });
    }
}

fn parallel_cylinders(a: (DVec3, DVec3, f64), b: (DVec3, f64), out: &mut Vec<Curve>) {
    let ((origin, axis, r), (o, s)) = (a, b);
    let offset = (o - origin) - axis * (o - origin).dot(axis);
    let d = offset.length();
    let x = offset.normalize_or_zero();
    let along = (d * d + r * r - s * s) / (2.0 * d);
    let w = (r * r - along * along).max(0.0).sqrt();
    if w < NEARLY_PARALLEL.sqrt() * r {
        out.push(Curve::Line { origin: origin + x * r.copysign(along), direction: axis });
    }
    for sign in [1.0, -1.0] {
        out.push(Curve::Line { origin: origin + x * along + axis.cross(x) * (sign * w), direction: axis });
    }
}

/// The axis of a surface of revolution; a sphere has any through its centre.
fn axis_of(p: &Primitive) -> Option<(DVec3, Option<DVec3>)> {
    match *p {
        Primitive::Plane { .. } => None,
        Primitive::Cylinder { origin, axis, .. } => Some((origin, Some(axis))),
        Primitive::Cone { apex, axis, .. } => Some((apex, Some(axis))),
        Primitive::Sphere { center, .. } => Some((center, None)),
        Primitive::Torus { center, axis, .. } => Some((center, Some(axis))),
    }
}

/// An axis that both surfaces are round about, or nearly.
fn common_axis(a: &Primitive, b: &Primitive) -> Option<(DVec3, DVec3)> {
    match (a, b) {
        (Primitive::Plane { normal, .. }, other) | (other, Primitive::Plane { normal, .. }) => {
            let (origin, axis) = axis_of(other)?;
            let axis = axis.unwrap_or(*normal);
            (axis.cross(*normal).length() < NEARLY_PARALLEL).then_some((origin, axis))
        }
        _ => {
            let ((p, u), (q, v)) = (axis_of(a)?, axis_of(b)?);
            let axis = u.or(v).or((q - p).try_normalize())?;
            let parallel = v.is_none_or(|v| axis.cross(v).length() < NEARLY_PARALLEL);
            let origin = if u.is_some() { p } else { q };
            let offset = (q - p) - axis * (q - p).dot(axis);
            (parallel && offset.length() < NEARLY_PARALLEL * (size(a) + size(b))).then_some((origin, axis))
        }
    }
}

fn size(p: &Primitive) -> f64 {
    match *p {
        Primitive::Cylinder { radius, .. } | Primitive::Sphere { radius, .. } => radius,
        Primitive::Torus { major_radius, minor_radius, .. } => major_radius + minor_radius,
        _ => 0.0,
    }
}

/// The circle of two coaxial surfaces: their profiles' intersection, or contact, next to the points.
fn coaxial_circle(a: &Primitive, b: &Primitive, axis: (DVec3, DVec3), points: &[DVec3]) -> Option<Curve> {
    let frame = Frame::along(axis.0, axis.1);
    let start = points.iter().map(|&p| frame.profile(p)).sum::<DVec2>() / points.len().max(1) as f64;
    let mut q = start;
    for _ in 0..60 {
        let p = frame.origin + q.x * frame.x + q.y * frame.z;
        let flat = |n: DVec3| DVec2::new(n.dot(frame.x), n.dot(frame.z));
        let (m, n) = (flat(a.normal(p)), flat(b.normal(p)));
        let (da, db) = (a.distance(p), b.distance(p));
        let cross = m.perp_dot(n);
        let step = if cross.abs() > 1e-6 {
            DVec2::new(da * n.y - db * m.y, db * m.x - da * n.x) / -cross
        } else {
            -(m * da + n * db) / (m.length_squared() + n.length_squared()).max(f64::MIN_POSITIVE)
        };
        if !step.is_finite() {
            return None;
        }
        q += step;
        if step.length() <= 1e-16 * (q.length() + start.length()) {
            break;
        }
    }
    let q = contact(a, b, &frame, q).unwrap_or(q);
    (q.x > 0.0).then(|| Curve::Circle { frame: Frame::along(frame.origin + q.y * frame.z, frame.z), radius: q.x })
}

/// Where profiles touch: lines and circles of the half plane, by their centres.
fn contact(a: &Primitive, b: &Primitive, frame: &Frame, near: DVec2) -> Option<DVec2> {
    let p = frame.origin + near.x * frame.x + near.y * frame.z;
    if a.normal(p).dot(b.normal(p)).abs() < 1.0 - 1e-5 {
        return None;
    }
    let center = |s: &Primitive| match *s {
        Primitive::Sphere { center, radius } => Some((DVec2::new(0.0, frame.local(center).z), radius)),
        Primitive::Torus { center, major_radius, minor_radius, .. } => {
            Some((DVec2::new(major_radius, frame.local(center).z), minor_radius))
        }
        _ => None,
    };
    match (center(a), center(b)) {
        (Some((c, r)), None) => {
            let n = b.normal(p);
            let n = DVec2::new(n.dot(frame.x), n.dot(frame.z)).normalize_or_zero();
            Some(c + n * r.copysign((near - c).dot(n)))
        }
        (None, Some(_)) => contact(b, a, frame, near),
        (Some((c, r)), Some((d, _))) => {
            let n = (d - c).normalize_or_zero();
            Some(c + n * r.copysign((near - c).dot(n)))
        }
        _ => None,
    }
}

/// Lines of curvature of one surface through the mean of the points: contacts that no pair knows.
fn own_lines(p: &Primitive, points: &[DVec3], out: &mut Vec<Curve>) {
    let middle = points[points.len() / 2];
    match *p {
        Primitive::Cylinder { origin, axis, radius } => {
            let height = axis.dot(mean(points) - origin);
            out.push(Curve::Circle { frame: Frame::along(origin + height * axis, axis), radius });
            let frame = Frame::along(origin, axis);
            out.push(Curve::Line { origin: origin + frame.radial(frame.angle(middle)) * radius, direction: axis });
        }
        Primitive::Cone { apex, axis, half_angle } => {
            let height = points.iter().map(|q| axis.dot(*q - apex)).sum::<f64>() / points.len() as f64;
            let radius = height * half_angle.tan();
            out.push(Curve::Circle { frame: Frame::along(apex + height * axis, axis), radius });
            let frame = Frame::along(apex, axis);
            let radial = frame.radial(frame.angle(middle));
            out.push(Curve::Line { origin: apex, direction: axis * half_angle.cos() + radial * half_angle.sin() });
        }
        Primitive::Torus { center, axis, major_radius, minor_radius } => {
            let frame = Frame::along(center, axis);
            // The angle of the meridian: the one from which points deviate least; the farthest from the axis knows best.
            let far = points.iter().max_by(|x, y| frame.profile(**x).x.total_cmp(&frame.profile(**y).x));
            let radial = frame.radial(frame.angle(*far.unwrap_or(&middle)));
            let meridian = Frame::new(center + radial * major_radius, axis.cross(radial), radial);
            out.push(Curve::Circle { frame: meridian, radius: minor_radius });
            let profile = points.iter().map(|&q| frame.profile(q)).sum::<DVec2>() / points.len() as f64;
            let tube = (profile - DVec2::new(major_radius, 0.0)).normalize_or_zero() * minor_radius;
            let around = Frame::along(center + tube.y * axis, axis);
            out.push(Curve::Circle { frame: around, radius: major_radius + tube.x });
        }
        _ => {}
    }
}

/// The seam of a surface at one of its parameters: a line, a circle, or the profile.
pub fn seam(surface: &Surface, across: usize, at: f64) -> Option<Curve> {
    Some(match (surface, across) {
        (Surface::Cylinder { .. } | Surface::Cone { .. }, 0) => {
            let (a, b) = (surface.point(at, 0.0), surface.point(at, 1.0));
            Curve::Line { origin: a, direction: (b - a).normalize_or_zero() }
        }
        (Surface::Extrusion { profile, direction }, 0) => {
            Curve::Line { origin: profile.point(at), direction: *direction }
        }
        (Surface::Sphere { frame, radius }, 0) => {
            let x = frame.radial(at);
            Curve::Circle { frame: Frame { origin: frame.origin, z: x.cross(frame.z), x }, radius: *radius }
        }
        (Surface::Torus { frame, major_radius, minor_radius }, 0) => {
            let x = frame.radial(at);
            let origin = frame.origin + x * *major_radius;
            Curve::Circle { frame: Frame { origin, z: x.cross(frame.z), x }, radius: *minor_radius }
        }
        (Surface::Torus { frame, major_radius, minor_radius }, 1) => {
            let (sin, cos) = at.sin_cos();
            let origin = frame.origin + frame.z * (minor_radius * sin);
            Curve::Circle { frame: Frame { origin, ..*frame }, radius: major_radius + minor_radius * cos }
        }
        (Surface::Revolution { profile, frame }, 1) => {
            let l = frame.local(profile.point(at));
            let origin = frame.origin + frame.z * l.z;
            Curve::Circle { frame: Frame { origin, ..*frame }, radius: l.x }
        }
        (Surface::Revolution { profile, frame }, 0) => {
            let turn = crate::brep::Motion {
                rotation: glam::DMat3::from_axis_angle(frame.z, at),
                scale: 1.0,
                translation: DVec3::ZERO,
            };
            let home = crate::brep::Motion { translation: -frame.origin, ..crate::brep::Motion::IDENTITY };
            let back = crate::brep::Motion { translation: frame.origin, ..crate::brep::Motion::IDENTITY };
            profile.moved(&home).moved(&turn).moved(&back)
        }
        _ => return None,
    })
}
