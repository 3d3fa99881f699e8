//! Axes of surfaces of revolution from points and estimates of normals.

use crate::numeric::eigen3::{Eigen3, outer};
use glam::{DMat3, DVec3};

/// Eigenvalues below this share of the largest are directions in which the surface slides on itself.
const SLIPPABLE: f64 = 1e-9;

/// A line in space.
#[derive(Debug, Clone, Copy)]
pub(super) struct Axis {
    pub point: DVec3,
    /// Unit.
    pub direction: DVec3,
}

/// Mean and covariance (times the number) of vectors.
pub(super) fn spread(vectors: &[DVec3]) -> (DVec3, Eigen3) {
    let mean = vectors.iter().sum::<DVec3>() / vectors.len().max(1) as f64;
    (mean, Eigen3::new(vectors.iter().map(|v| outer(*v - mean)).sum()))
}

/// The line that the normals come closest to meeting.
///
/// Pottmann and Randrup, "Rotational and Helical Surface Approximation for Reverse Engineering", Computing 60 (1998): a
/// rotation with angular velocity a and velocity c at the origin leaves the surface in place where n·c + (p × n)·a = 0 for
/// all points p with normals n. The sum of squares is minimised over |a| = 1; its minimum over c is c = −A⁻¹ B a
/// with A = Σ n nᵀ and B = Σ n (p × n)ᵀ, which leaves the smallest eigenvector of C − Bᵀ A⁻¹ B, C = Σ (p × n)(p × n)ᵀ.
/// The inverse is that of the directions which are no translational symmetries; the pitch a·c is dropped.
pub(super) fn kinematic(points: &[DVec3], normals: &[DVec3]) -> Option<Axis> {
    let (mut a, mut b, mut c) = (DMat3::ZERO, DMat3::ZERO, DMat3::ZERO);
    for (p, n) in points.iter().zip(normals) {
        let m = p.cross(*n);
        a += outer(*n);
        b += DMat3::from_cols(*n * m.x, *n * m.y, *n * m.z);
        c += outer(m);
    }
    let a = Eigen3::new(a);
    if !(a.values[1] > SLIPPABLE * a.values[2]) {
        return None;
    }
    let shift = |v: DVec3| -a.solve(b * v, SLIPPABLE);
    let inner = DMat3::from_cols(shift(DVec3::X), shift(DVec3::Y), shift(DVec3::Z));
    let direction = Eigen3::new(symmetric(c + b.transpose() * inner)).vectors[0];
    Some(Axis { point: direction.cross(shift(direction)), direction })
}

/// The axis of the cone that the tangent planes come closest to touching: its direction has the same angle with all
/// normals, and the apex is on all planes.
pub(super) fn of_tangent_planes(points: &[DVec3], normals: &[DVec3]) -> Option<Axis> {
    let (_, normal_spread) = spread(normals);
    let (mut planes, mut offset) = (DMat3::ZERO, DVec3::ZERO);
    for (p, n) in points.iter().zip(normals) {
        planes += outer(*n);
        offset += *n * n.dot(*p);
    }
    let planes = Eigen3::new(planes);
    (planes.values[0] > SLIPPABLE * planes.values[2])
        .then(|| Axis { point: planes.solve(offset, SLIPPABLE), direction: normal_spread.vectors[0] })
}

/// The direction most nearly orthogonal to all normals; `None` where they are parallel.
pub(super) fn orthogonal_to_all(normals: &[DVec3]) -> Option<DVec3> {
    let spread = Eigen3::new(normals.iter().map(|n| outer(*n)).sum());
    (spread.values[1] > SLIPPABLE * spread.values[2]).then_some(spread.vectors[0])
}

/// The mean of a matrix and its transpose.
fn symmetric(m: DMat3) -> DMat3 {
    (m + m.transpose()) * 0.5
}

#[cfg(test)]
mod tests {
    use super::super::shape::Primitive;
    use super::*;

    /// Points and normals of a patch of a torus around the vertical axis through (1, 2, 0).
    fn patch() -> (Vec<DVec3>, Vec<DVec3>) {
        let center = DVec3::new(1.0, 2.0, 0.5);
        let torus = Primitive::Torus { center, axis: DVec3::Z, major_radius: 2.0, minor_radius: 0.7 };
        let angles = (0..20).map(|k| (0.2 * f64::from(k % 5), 0.3 * f64::from(k / 5)));
        let points: Vec<DVec3> = angles
            .map(|(u, v)| {
                let rho = 2.0 + 0.7 * v.cos();
                center + DVec3::new(rho * u.cos(), rho * u.sin(), 0.7 * v.sin())
            })
            .collect();
        let normals = points.iter().map(|p| torus.normal(*p)).collect();
        (points, normals)
    }

    #[test]
    fn normals_of_a_torus_meet_its_axis() {
        let (points, normals) = patch();
        let axis = kinematic(&points, &normals).unwrap();
        assert!(axis.direction.cross(DVec3::Z).length() < 1e-7);
        assert!((axis.point - DVec3::new(1.0, 2.0, 0.0)).cross(axis.direction).length() < 1e-6);
    }

    #[test]
    fn tangent_planes_of_a_cone_meet_in_its_apex() {
        let apex = DVec3::new(0.3, -0.2, 1.0);
        let cone = Primitive::Cone { apex, axis: DVec3::X, half_angle: 0.4 };
        let points: Vec<DVec3> = (0..12)
            .map(|k| (0.3 * f64::from(k % 4), 1.0 + f64::from(k / 4)))
            .map(|(u, x)| apex + DVec3::new(x, x * 0.4f64.tan() * u.cos(), x * 0.4f64.tan() * u.sin()))
            .collect();
        let normals: Vec<DVec3> = points.iter().map(|p| cone.normal(*p)).collect();
        let axis = of_tangent_planes(&points, &normals).unwrap();
        assert!(axis.direction.cross(DVec3::X).length() < 1e-7 && axis.point.distance(apex) < 1e-9);
    }

    #[test]
    fn parallel_and_missing_normals_give_no_axis() {
        let points = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::ONE];
        for normal in [DVec3::Z, DVec3::ZERO] {
            let normals = [normal; 4];
            assert!(orthogonal_to_all(&normals).is_none());
            assert!(of_tangent_planes(&points, &normals).is_none());
            assert!(kinematic(&points, &normals).is_none());
        }
    }
}
