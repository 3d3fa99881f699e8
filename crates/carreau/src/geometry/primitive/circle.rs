//! Circles and lines through points of a plane: profiles and cross sections of surfaces of revolution.

use glam::DVec2;

/// Newton steps for the circle: convergence from 0 is monotone, a handful is usual.
const CIRCLE_STEPS: usize = 20;

/// The circle of least Σ (|p − c|² − r²)² / Σ 4|p − c|², centre and radius; `None` where the points lie on a line.
///
/// Taubin, "Estimation of Planar Curves, Surfaces and Nonplanar Space Curves", PAMI 13 (1991), in the moment form of
/// Chernov, Circular and Linear Regression, CRC 2010, §5.8. Exact on points of a circle, and without the strong bias towards
/// small radii that the plain algebraic fit has on noisy short arcs.
pub(crate) fn circle(points: impl Iterator<Item = DVec2> + Clone) -> Option<(DVec2, f64)> {
    let (count, mean) = mean(points.clone())?;
    let (mut xx, mut xy, mut yy, mut xz, mut yz, mut zz) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    for p in points {
        let d = p - mean;
        let z = d.length_squared();
        xx += d.x * d.x;
        xy += d.x * d.y;
        yy += d.y * d.y;
        xz += d.x * z;
        yz += d.y * z;
        zz += z * z;
    }
    [&mut xx, &mut xy, &mut yy, &mut xz, &mut yz, &mut zz].into_iter().for_each(|m| *m /= count);
    let spread = xx + yy;
    let area = xx * yy - xy * xy;
    let variance = zz - spread * spread;
    // The characteristic polynomial 4 c1 … of the generalised eigenproblem; its smallest root is wanted.
    let a3 = 4.0 * spread;
    let a2 = -3.0 * spread * spread - zz;
    let a1 = variance * spread + 4.0 * area * spread - xz * xz - yz * yz;
    let a0 = xz * (xz * yy - yz * xy) + yz * (yz * xx - xz * xy) - variance * area;
    let mut root = 0.0;
    for _ in 0..CIRCLE_STEPS {
        let value = a0 + root * (a1 + root * (a2 + root * a3));
        let slope = a1 + root * (2.0 * a2 + root * 3.0 * a3);
        let next = root - value / slope;
        if !(next.is_finite() && next >= 0.0 && (next - root).abs() > 1e-14 * next.abs()) {
            break;
        }
        root = next;
    }
    let determinant = root * root - root * spread + area;
    let centre = DVec2::new(xz * (yy - root) - yz * xy, yz * (xx - root) - xz * xy) / (2.0 * determinant);
    let radius = (centre.length_squared() + spread).sqrt();
    (determinant.abs() > 1e-14 * spread * spread && radius.is_finite()).then_some((centre + mean, radius))
}

/// The line of least orthogonal distances: a point and a unit direction.
pub(super) fn line(points: impl Iterator<Item = DVec2> + Clone) -> Option<(DVec2, DVec2)> {
    let (_, mean) = mean(points.clone())?;
    let (mut difference, mut product) = (0.0, 0.0);
    for p in points {
        let d = p - mean;
        difference += d.x * d.x - d.y * d.y;
        product += 2.0 * d.x * d.y;
    }
    // The principal direction has half the angle of the second moment.
    let direction = DVec2::from_angle(0.5 * f64::atan2(product, difference));
    (difference != 0.0 || product != 0.0).then_some((mean, direction))
}

fn mean(points: impl Iterator<Item = DVec2>) -> Option<(f64, DVec2)> {
    let (count, sum) = points.fold((0.0, DVec2::ZERO), |(count, sum), p| (count + 1.0, sum + p));
    (count > 0.0).then(|| (count, sum / count))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn circles_through_points_of_an_arc(x in -3f64..3.0, y in -3f64..3.0, r in 0.1f64..5.0, from in 0f64..6.0, arc in 0.3f64..6.3) {
            let at = |k: u32| DVec2::new(x, y) + DVec2::from_angle(from + arc * f64::from(k) / 6.0) * r;
            let (centre, radius) = circle((0..7).map(at)).unwrap();
            prop_assert!(centre.distance(DVec2::new(x, y)) < 1e-7 * r / arc.powi(3).min(1.0));
            prop_assert!((radius - r).abs() < 1e-7 * r / arc.powi(3).min(1.0));
        }

        #[test]
        fn lines_through_collinear_points(x in -3f64..3.0, y in -3f64..3.0, angle in 0f64..6.3) {
            let (origin, along) = (DVec2::new(x, y), DVec2::from_angle(angle));
            let points = (0..5).map(|k| origin + along * f64::from(k * k));
            let (point, direction) = line(points.clone()).unwrap();
            prop_assert!(direction.perp_dot(along).abs() < 1e-12 && (point - origin).perp_dot(along).abs() < 1e-12);
            prop_assert!(circle(points).is_none_or(|(_, radius)| radius > 1e4));
        }
    }

    #[test]
    fn too_little_gives_nothing() {
        let none: [DVec2; 0] = [];
        assert!(circle(none.into_iter()).is_none() && line(none.into_iter()).is_none());
        assert!(circle([DVec2::ONE; 4].into_iter()).is_none() && line([DVec2::ONE; 4].into_iter()).is_none());
    }
}
