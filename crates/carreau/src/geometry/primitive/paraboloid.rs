//! The paraboloid through a patch of points: normal, principal directions and curvatures without any normals given.

use super::axis::spread;
use crate::numeric::levenberg::solve_cholesky;
use glam::{DVec2, DVec3};

/// Added to the diagonal of the quadratic terms, relative to the number of points: of several paraboloids through too few
/// points, the flattest.
const RIDGE: f64 = 1e-9;

/// A patch to second order.
#[derive(Debug, Clone, Copy)]
pub(super) struct Paraboloid {
    pub foot: DVec3,
    pub normal: DVec3,
    /// Principal directions, the one of the smaller absolute curvature first.
    pub directions: [DVec3; 2],
    /// Positive where the patch bends away from the normal.
    pub curvatures: [f64; 2],
}

impl Paraboloid {
    /// Heights over the plane of least squares (or the one orthogonal to the mean normal, where the normals have a clear
    /// mean), as a quadratic polynomial; `None` for collinear points.
    pub fn through(points: &[DVec3], mean_normal: DVec3) -> Option<Self> {
        let (mean, spread) = spread(points);
        if !(spread.values[1] > 1e-14 * spread.values[2]) {
            return None;
        }
        let up = if mean_normal.length_squared() > 0.25 { mean_normal.normalize() } else { spread.vectors[0] };
        let u = (spread.vectors[2] - up * up.dot(spread.vectors[2])).try_normalize()?;
        let v = up.cross(u);
        let [c, cu, cv, uu, uv, vv] =
            coefficients(points.iter().map(|p| *p - mean).map(|d| (d.dot(u), d.dot(v), d.dot(up))))?;
        // Eigenvectors of the symmetric matrix (uu, uv/2; uv/2, vv) at half the angle of (uu − vv, uv).
        let (middle, half) = (0.5 * (uu + vv), 0.5 * (uu - vv).hypot(uv));
        let turn = DVec2::from_angle(0.5 * f64::atan2(uv, uu - vv));
        let normal = (up - u * cu - v * cv).normalize();
        let tangent = |d: DVec2| {
            let t = u * d.x + v * d.y;
            (t - normal * t.dot(normal)).normalize()
        };
        // z = ½ k x² bends towards the normal.
        let mut ends = [(turn.perp(), -2.0 * (middle - half)), (turn, -2.0 * (middle + half))];
        if ends[0].1.abs() > ends[1].1.abs() {
            ends.swap(0, 1);
        }
        let directions = ends.map(|(d, _)| tangent(d));
        Some(Paraboloid { foot: mean + up * c, normal, directions, curvatures: ends.map(|(_, k)| k) })
    }
}

/// Least squares for z = c₀ + c₁u + c₂v + c₃u² + c₄uv + c₅v².
fn coefficients(points: impl Iterator<Item = (f64, f64, f64)>) -> Option<[f64; 6]> {
    let (mut matrix, mut rhs) = ([[0.0; 6]; 6], [0.0; 6]);
    for (u, v, z) in points {
        let row = [1.0, u, v, u * u, u * v, v * v];
        for i in 0..6 {
            for j in 0..6 {
                matrix[i][j] += row[i] * row[j];
            }
            rhs[i] += row[i] * z;
        }
    }
    let count = matrix[0][0];
    for k in 3..6 {
        matrix[k][k] += RIDGE * count;
    }
    solve_cholesky(&matrix, &rhs)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_saddle_has_its_curvatures() {
        // In a frame that is not that of the coordinates.
        let (n, u) = (DVec3::new(1.0, 2.0, 2.0) / 3.0, DVec3::new(2.0, 1.0, -2.0) / 3.0);
        let v = n.cross(u);
        let points: Vec<DVec3> = (0..25)
            .map(|k| (0.5 * f64::from(k % 5 - 2), 0.5 * f64::from(k / 5 - 2)))
            .map(|(x, y)| u * x + v * y + n * (0.3 * x * x - 1.0 * y * y))
            .collect();
        let patch = Paraboloid::through(&points, n).unwrap();
        let sign = patch.normal.dot(n).signum();
        assert!((patch.curvatures[0] * sign + 0.6).abs() < 1e-6 && (patch.curvatures[1] * sign - 2.0).abs() < 1e-6);
        assert!(patch.directions[0].cross(u).length() < 1e-6 && patch.foot.length() < 1e-6);
    }

    #[test]
    fn collinear_points_have_none() {
        let points: Vec<DVec3> = (0..9).map(|k| DVec3::new(1.0, 2.0, 3.0) * f64::from(k)).collect();
        assert!(Paraboloid::through(&points, DVec3::ZERO).is_none());
    }
}
