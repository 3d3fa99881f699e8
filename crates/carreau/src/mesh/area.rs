//! Area and shape of faces.

use glam::DVec3;

/// √3, which has no constant function.
const SQRT_3: f64 = 1.732_050_807_568_877_2;

/// Area vector of a face: its length is the area, its direction the normal (Newell's for polygons that are not flat).
///
/// Differences to one corner are used, so that a place far from the origin does not cost digits. In triangles that
/// corner is the one between the two shorter edges: the cross product of the shortest edges has the smallest error,
/// which is what keeps the normals of slivers usable.
pub fn area_vector(points: &[DVec3], face: &[u32]) -> DVec3 {
    let p = |k: usize| points[face[k] as usize];
    if let [_, _, _] = face {
        return triangle_area_vector(p(0), p(1), p(2));
    }
    let origin = p(0);
    let doubled = (1..face.len() - 1).fold(DVec3::ZERO, |sum, k| sum + (p(k) - origin).cross(p(k + 1) - origin));
    0.5 * doubled
}

/// [`area_vector`] of a triangle.
#[inline]
pub fn triangle_area_vector(a: DVec3, b: DVec3, c: DVec3) -> DVec3 {
    let (ab, bc, ca) = (b - a, c - b, a - c);
    let (l_ab, l_bc, l_ca) = (ab.length_squared(), bc.length_squared(), ca.length_squared());
    0.5 * if l_bc >= l_ab && l_bc >= l_ca {
        ca.cross(ab)
    } else if l_ca >= l_ab {
        ab.cross(bc)
    } else {
        bc.cross(ca)
    }
}

/// Length of a vector without overflow or underflow of its square.
#[inline]
pub fn safe_length(v: DVec3) -> f64 {
    let scale = v.abs().max_element();
    if scale > 0.0 && scale.is_finite() { scale * (v / scale).length() } else { scale }
}

/// Mean ratio of a triangle, 4√3 A / Σ l²: 1 equilateral, 0 flat.
pub fn mean_ratio(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    let Some([a, b, c]) = unit_sized([a, b, c]) else { return 0.0 };
    let squares = a.distance_squared(b) + b.distance_squared(c) + c.distance_squared(a);
    4.0 * SQRT_3 * triangle_area_vector(a, b, c).length() / squares
}

/// The triangle moved to its first corner and scaled to an extent of one; `None` for a point.
pub(crate) fn unit_sized([a, b, c]: [DVec3; 3]) -> Option<[DVec3; 3]> {
    let scale = (b - a).abs().max_element().max((c - a).abs().max_element());
    (scale > 0.0 && scale.is_finite()).then(|| [DVec3::ZERO, (b - a) / scale, (c - a) / scale])
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn polygons_and_their_fans_agree() {
        let points = [(0., 0.), (4., 0.), (4., 1.), (1., 1.), (1., 3.), (0., 3.)].map(|(x, y)| DVec3::new(x, y, 7.0));
        let fan: DVec3 = (1..5).map(|k| area_vector(&points, &[0, k, k + 1])).sum();
        assert_eq!(area_vector(&points, &[0, 1, 2, 3, 4, 5]), DVec3::Z * 6.0);
        assert_eq!(fan, DVec3::Z * 6.0);
    }

    proptest! {
        #[test]
        fn a_triangle_turns_with_its_corners(p in prop::array::uniform3(prop::array::uniform3(-1.0f64..1.0))) {
            let [a, b, c] = p.map(DVec3::from_array);
            let v = triangle_area_vector(a, b, c);
            prop_assert!((v - triangle_area_vector(b, c, a)).length() < 1e-15);
            prop_assert!((v + triangle_area_vector(b, a, c)).length() < 1e-15);
            prop_assert!((v - 0.5 * (b - a).cross(c - a)).length() < 1e-14);
            prop_assert!((safe_length(v) - v.length()).abs() < 1e-15);
        }
    }
}
