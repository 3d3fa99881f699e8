//! Rays that meet triangles.

use glam::DVec3;

/// A ray in coordinates where it starts at the origin and runs along z with unit speed (Woop, Benthin, Wald, "Watertight
/// Ray/Triangle Intersection", Journal of Computer Graphics Techniques 2013).
///
/// A corner has the same coordinates in all its triangles, and the sign of a difference of two rounded products is never
/// the opposite of the exact one: no ray slips between neighbours.
pub struct Ray {
    origin: DVec3,
    /// The axes that take the part of x, y and z.
    axes: [usize; 3],
    /// Slopes of the ray against the z axis, and the inverse of its speed along it.
    shear: DVec3,
}

impl Ray {
    /// A ray that starts at a point.
    pub fn new(origin: DVec3, direction: DVec3) -> Self {
        let z = direction.abs().max_position();
        let (mut x, mut y) = ((z + 1) % 3, (z + 2) % 3);
        // A reflection keeps the sense of the triangles where the axis points against the ray.
        if direction[z] < 0.0 {
            (x, y) = (y, x);
        }
        let shear = DVec3::new(direction[x], direction[y], 1.0) / direction[z];
        Ray { origin, axes: [x, y, z], shear }
    }

    /// Distance along the ray and whether it meets the front.
    #[inline]
    pub fn meets(&self, corners: [DVec3; 3]) -> Option<(f64, bool)> {
        let [x, y, z] = self.axes;
        let [a, b, c] = corners.map(|p| p - self.origin);
        let flat = |p: DVec3| (p[x] - self.shear.x * p[z], p[y] - self.shear.y * p[z]);
        let (a2, b2, c2) = (flat(a), flat(b), flat(c));
        let side = |p: (f64, f64), q: (f64, f64)| p.0 * q.1 - p.1 * q.0;
        let (u, v, w) = (side(b2, c2), side(c2, a2), side(a2, b2));
        let back = u >= 0.0 && v >= 0.0 && w >= 0.0;
        let front = u <= 0.0 && v <= 0.0 && w <= 0.0;
        let area = u + v + w;
        if !(front || back) || area == 0.0 {
            return None;
        }
        let t = self.shear.z * (u * a[z] + v * b[z] + w * c[z]) / area;
        (t >= 0.0).then_some((t, front))
    }
}
