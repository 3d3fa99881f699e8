//! Symmetric tensors in space, their restriction to tangent planes, and its eigenvectors.

use glam::DVec3;
use std::ops::AddAssign;

/// A symmetric 3 × 3 matrix.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Tensor {
    xx: f64,
    xy: f64,
    xz: f64,
    yy: f64,
    yz: f64,
    zz: f64,
}

impl Tensor {
    /// The symmetric part of a bᵀ.
    #[inline]
    pub fn product(a: DVec3, b: DVec3) -> Self {
        Tensor {
            xx: a.x * b.x,
            yy: a.y * b.y,
            zz: a.z * b.z,
            xy: 0.5 * (a.x * b.y + a.y * b.x),
            xz: 0.5 * (a.x * b.z + a.z * b.x),
            yz: 0.5 * (a.y * b.z + a.z * b.y),
        }
    }

    /// The tensor on a tangent plane.
    #[inline]
    pub fn on(&self, plane: &Frame) -> Form {
        let times = |v: DVec3| {
            DVec3::new(
                self.xx * v.x + self.xy * v.y + self.xz * v.z,
                self.xy * v.x + self.yy * v.y + self.yz * v.z,
                self.xz * v.x + self.yz * v.y + self.zz * v.z,
            )
        };
        let (first, second) = (times(plane.first), times(plane.second));
        Form { a: plane.first.dot(first), b: plane.first.dot(second), c: plane.second.dot(second) }
    }
}

impl AddAssign for Tensor {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        self.xx += other.xx;
        self.xy += other.xy;
        self.xz += other.xz;
        self.yy += other.yy;
        self.yz += other.yz;
        self.zz += other.zz;
    }
}

/// Two orthonormal vectors that span a tangent plane.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame {
    first: DVec3,
    second: DVec3,
}

impl Frame {
    /// A frame of the plane across a unit vector (Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 2017).
    #[inline]
    pub fn across(n: DVec3) -> Self {
        let sign = 1f64.copysign(n.z);
        let a = -1.0 / (sign + n.z);
        let b = n.x * n.y * a;
        Frame {
            first: DVec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x),
            second: DVec3::new(b, sign + n.y * n.y * a, -n.y),
        }
    }

    /// The form u ↦ (u · v)² of a vector.
    #[inline]
    pub fn square(&self, v: DVec3) -> Form {
        let (x, y) = (self.first.dot(v), self.second.dot(v));
        Form { a: x * x, b: x * y, c: y * y }
    }

    /// [`Frame::square`] of a vector laid into the plane in its full length. Steep vectors, which have no direction to
    /// speak of in the plane, are lengthened no more than twofold.
    #[inline]
    pub fn laid_square(&self, v: DVec3) -> Form {
        let flat = self.square(v);
        let (full, seen) = (v.length_squared(), flat.a + flat.c);
        let stretch = if full < 4.0 * seen { full / seen } else { 4.0 };
        Form { a: stretch * flat.a, b: stretch * flat.b, c: stretch * flat.c }
    }

    /// This frame of the plane across `from`, turned with it by the smallest rotation that takes `from` to `to`.
    pub fn carried(&self, from: DVec3, to: DVec3) -> Self {
        let w = 1.0 + from.dot(to);
        if w < 1e-9 {
            // Opposite normals: no rotation is the smallest.
            return Frame::across(to);
        }
        let carry = |v: DVec3| v - v.dot(to) / w * (from + to);
        Frame { first: carry(self.first), second: carry(self.second) }
    }
}

/// Eigenvalues are equal whose difference squared is below this, the end of the range of exact squares.
const EQUAL_SQUARED: f64 = 1e-290;

/// A quadratic form on a tangent plane: a x² + 2 b x y + c y² in the coordinates of a [`Frame`].
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Form {
    a: f64,
    b: f64,
    c: f64,
}

impl Form {
    /// Eigenvalues, the smaller first, and their unit eigenvectors; these are zero where the eigenvalues are equal.
    #[inline]
    pub fn eigen(&self, plane: &Frame) -> ([f64; 2], [DVec3; 2]) {
        let (mean, half) = (0.5 * (self.a + self.c), 0.5 * (self.a - self.c));
        let square = half * half + self.b * self.b;
        let radius = square.sqrt();
        if !(square > EQUAL_SQUARED) {
            return ([mean - radius, mean + radius], [DVec3::ZERO; 2]);
        }
        // Of the two equivalent formulas the one without cancellation.
        let (x, y) = if half >= 0.0 { (half + radius, self.b) } else { (self.b, radius - half) };
        let unit = 1.0 / (x * x + y * y).sqrt();
        let (x, y) = (x * unit, y * unit);
        let (small, large) = (x * plane.second - y * plane.first, x * plane.first + y * plane.second);
        ([mean - radius, mean + radius], [small, large])
    }

    /// The sum with another form times a weight.
    #[inline]
    pub fn plus(self, weight: f64, other: Form) -> Form {
        Form { a: self.a + weight * other.a, b: self.b + weight * other.b, c: self.c + weight * other.c }
    }

    /// The form turned by a right angle: each eigenvalue gets the other's eigenvector.
    #[inline]
    pub fn turned(self) -> Form {
        Form { a: self.c, b: -self.b, c: self.a }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::normals::unit;
    use proptest::prelude::*;

    fn direction() -> impl Strategy<Value = DVec3> {
        prop::array::uniform3(-1.0f64..1.0).prop_map(DVec3::from_array).prop_filter("short", |v| v.length() > 0.1)
    }

    proptest! {
        #[test]
        fn frames_are_orthonormal_and_stay_so(n in direction(), m in direction()) {
            let [n, m] = [n, m].map(unit);
            let frame = Frame::across(n);
            for (f, n) in [(frame, n), (frame.carried(n, m), m), (frame.carried(n, -n), -n)] {
                let all = [f.first, f.second, n];
                for i in 0..3 {
                    for j in 0..3 {
                        prop_assert!((all[i].dot(all[j]) - f64::from(u8::from(i == j))).abs() < 1e-7);
                    }
                }
            }
        }

        #[test]
        fn eigenvectors_satisfy_their_equation(n in direction(), d in direction(), k in prop::array::uniform2(-5.0f64..5.0)) {
            let n = unit(n);
            let plane = Frame::across(n);
            let u = unit(d.cross(n));
            prop_assume!(u != DVec3::ZERO && (k[0] - k[1]).abs() > 1e-3);
            let v = n.cross(u);
            let mut tensor = Tensor::product(k[0] * u, u);
            tensor += Tensor::product(k[1] * v, v);
            let (values, vectors) = tensor.on(&plane).eigen(&plane);
            prop_assert!(values[0] <= values[1]);
            let (small, large) = if k[0] < k[1] { (u, v) } else { (v, u) };
            prop_assert!((values[0] - k[0].min(k[1])).abs() < 1e-12 && (values[1] - k[0].max(k[1])).abs() < 1e-12);
            prop_assert!(vectors[0].cross(small).length() < 1e-9 && vectors[1].cross(large).length() < 1e-9);
            let (_, swapped) = tensor.on(&plane).turned().eigen(&plane);
            prop_assert!(swapped[0].cross(large).length() < 1e-9);
        }
    }
}
