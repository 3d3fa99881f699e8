//! Segments and triangles clipped by a ball around the origin, exactly.

use super::sectors::Face;
use glam::DVec3;

/// The part of the segment from `a` to `b` in the ball of squared radius `square`, as an interval of 0..=1; empty (0, 0)
/// where it misses. `distance`: squared lengths of `a` and `b`.
#[inline]
pub(super) fn clipped_part(a: DVec3, b: DVec3, distance: [f64; 2], square: f64) -> [f64; 2] {
    let [a_in, b_in] = distance.map(|d| d <= square);
    if a_in && b_in {
        return [0.0, 1.0];
    }
    // |a + s e|² = square: e² s² + 2 (a·e) s + a² − square = 0
    let e = b - a;
    let (ee, ae) = (e.length_squared(), a.dot(e));
    let discriminant = ae * ae - ee * (distance[0] - square);
    if !(discriminant > 0.0 && ee > 0.0) {
        // Only rounding can let a line miss the ball that an end of it lies in.
        return [0.0, 0.0];
    }
    let root = discriminant.sqrt();
    let from = if a_in { 0.0 } else { (-ae - root) / ee };
    let to = if b_in { 1.0 } else { (root - ae) / ee };
    if from < to && to > 0.0 && from < 1.0 { [from.max(0.0), to.min(1.0)] } else { [0.0, 0.0] }
}

/// Area of the part of a triangle in the ball of squared radius `square`; `parts` are the parts of its sides in it.
///
/// ```text
///       q₁╭──╮q₀         The plane cuts the ball in a disc with centre o. For every side a → b the signed area
///      ╱  │   ╲╲         between it and o is a triangle where the side is in the disc, and a sector of the disc
///   b •───┼────•─• a     where it is not; the sum over the sides is what the triangle covers.
///          ╲  ╱ ╱
///            o
/// ```
///
/// The angles of the sectors are added as products of complex numbers, at the price of one atan2: seen from outside the
/// triangle, they stay below π. Only where o is inside they need one each.
pub(super) fn clipped_area(p: [DVec3; 3], parts: [[f64; 2]; 3], face: &Face, square: f64) -> f64 {
    if !(face.area > 0.0) {
        return 0.0;
    }
    let normal = face.area_vector / face.area;
    let height = normal.dot(p[0]);
    let lift = height * height;
    let disc = square - lift;
    if !(disc > 0.0) {
        return 0.0;
    }
    // Products of vectors projected to the plane: the height drops out of the cross product.
    let cross = [normal.dot(p[0].cross(p[1])), normal.dot(p[1].cross(p[2])), normal.dot(p[2].cross(p[0]))];
    let centre_inside = cross[0] > 0.0 && cross[1] > 0.0 && cross[2] > 0.0;
    let (mut doubled, mut angle) = (0.0, 0.0);
    // Cosine and sine of the angle so far, times a positive number.
    let mut turn = (1.0, 0.0);
    let mut add = |cos: f64, sin: f64| {
        if centre_inside {
            angle += sin.atan2(cos);
        } else {
            turn = (turn.0 * cos - turn.1 * sin, turn.0 * sin + turn.1 * cos);
        }
    };
    for k in 0..3 {
        let (a, b, [from, to]) = (p[k], p[(k + 1) % 3], parts[k]);
        if !(to > from) {
            add(a.dot(b) - lift, cross[k]);
            continue;
        }
        doubled += (to - from) * cross[k];
        let e = b - a;
        if from > 0.0 {
            add(a.dot(a + from * e) - lift, from * cross[k]);
        }
        if to < 1.0 {
            add(b.dot(a + to * e) - lift, (1.0 - to) * cross[k]);
        }
    }
    angle += turn.1.atan2(turn.0);
    (0.5 * (doubled + disc * angle)).clamp(0.0, face.area)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::triangle_area_vector;
    use proptest::prelude::*;
    use std::f64::consts::PI;

    fn clipped(p: [DVec3; 3], radius: f64) -> f64 {
        let square = radius * radius;
        let parts = [0, 1, 2].map(|k| {
            let (a, b) = (p[k], p[(k + 1) % 3]);
            clipped_part(a, b, [a.length_squared(), b.length_squared()], square)
        });
        let vector = triangle_area_vector(p[0], p[1], p[2]);
        let face = Face { area_vector: vector, area: vector.length(), ..Face::default() };
        clipped_area(p, parts, &face, square)
    }

    #[test]
    fn a_ball_well_inside_covers_a_disc() {
        let p = [(-11.0, -7.0), (8.0, -6.0), (1.0, 9.0)].map(|(x, y)| DVec3::new(x, y, 3.0));
        assert!((clipped(p, 5.0) - 16.0 * PI).abs() < 1e-12);
        assert_eq!(clipped(p, 2.9), 0.0);
        assert_eq!(clipped(p, 100.0), triangle_area_vector(p[0], p[1], p[2]).length());
    }

    #[test]
    fn a_corner_at_the_centre_covers_its_angle() {
        let p = [DVec3::ZERO, DVec3::X * 9.0, DVec3::Y * 9.0];
        for p in [p, [p[1], p[2], p[0]], [p[2], p[0], p[1]]] {
            assert!((clipped(p, 2.0) - PI).abs() < 1e-12);
        }
    }

    fn point() -> impl Strategy<Value = DVec3> {
        prop::array::uniform3(-1.0f64..1.0).prop_map(DVec3::from_array)
    }

    /// Recursive halving of the longest side: pieces inside count, pieces outside do not.
    fn by_halving(p: [DVec3; 3], square: f64, depth: u32) -> f64 {
        let area = triangle_area_vector(p[0], p[1], p[2]).length();
        let inside = p.iter().filter(|p| p.length_squared() <= square).count();
        if inside == 3 {
            return area;
        }
        if depth == 0 {
            return area * inside as f64 / 3.0;
        }
        let k =
            (0..3).max_by(|&i, &j| p[i].distance(p[(i + 1) % 3]).total_cmp(&p[j].distance(p[(j + 1) % 3]))).unwrap();
        let (a, b, c) = (p[k], p[(k + 1) % 3], p[(k + 2) % 3]);
        let m = 0.5 * (a + b);
        by_halving([a, m, c], square, depth - 1) + by_halving([m, b, c], square, depth - 1)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(60))]
        #[test]
        fn triangles_are_clipped_as_their_pieces_are(p in prop::array::uniform3(point()), radius in 0.2f64..1.5) {
            prop_assert!((clipped(p, radius) - by_halving(p, radius * radius, 14)).abs() < 0.01);
        }

        #[test]
        fn a_split_triangle_covers_as_much(p in prop::array::uniform3(point()), s in 0.0f64..1.0, radius in 0.2f64..1.5) {
            let m = p[0].lerp(p[1], s);
            let halves = clipped([p[0], m, p[2]], radius) + clipped([m, p[1], p[2]], radius);
            prop_assert!((clipped(p, radius) - halves).abs() < 1e-9);
        }

        #[test]
        fn parts_of_segments_lie_in_the_ball(a in point(), b in point(), radius in 0.2f64..1.5) {
            let square = radius * radius;
            let [from, to] = clipped_part(a, b, [a.length_squared(), b.length_squared()], square);
            prop_assert!(0.0 <= from && from <= to && to <= 1.0);
            for k in 0..=100 {
                let s = f64::from(k) / 100.0;
                let inside = a.lerp(b, s).length() <= radius;
                let near = (s - from).abs() < 1e-6 || (s - to).abs() < 1e-6;
                prop_assert!(near || inside == (from <= s && s <= to && from < to));
            }
        }
    }
}
