//! The point of a triangle that is closest to another, and the point that is closest to lines.

use crate::numeric::eigen3::outer;
use glam::{DMat3, DVec3};

/// The point with the least sum of squared distances from lines, each by a point and a unit direction. `stay` draws it with a
/// weight beside that of a line: a little keeps it where the lines leave it free.
pub fn closest_to_lines(lines: impl IntoIterator<Item = (DVec3, DVec3)>, stay: DVec3, weight: f64) -> Option<DVec3> {
    let (mut matrix, mut right) = (DMat3::IDENTITY * weight, stay * weight);
    for (p, d) in lines {
        let across = DMat3::IDENTITY - outer(d);
        matrix += across;
        right += across * p;
    }
    let point = matrix.inverse() * right;
    point.is_finite().then_some(point)
}

/// The point of a triangle that is closest to `p`. Needles are treated as their edges: with a height of 1e-8 of the length that
/// is wrong by no more than the weights of the corners are, by rounding.
///
/// If the projection falls outside, the closest point lies on an edge that `p` is outside of: only those are tried.
/// Inside, the point is a weighted mean of the corners, so that it lies in the triangle whatever the rounding.
#[inline]
pub fn closest_on_triangle(p: DVec3, [a, b, c]: [DVec3; 3]) -> DVec3 {
    let (ab, bc, ca) = (b - a, c - b, a - c);
    let (ap, bp, cp) = (p - a, p - b, p - c);
    let normal = ca.cross(ab);
    // Twice the areas between the projection and each edge, times the length of the normal.
    let (w_c, w_a, w_b) = (ab.cross(ap).dot(normal), bc.cross(bp).dot(normal), ca.cross(cp).dot(normal));
    let longest = ab.length_squared().max(bc.length_squared()).max(ca.length_squared());
    let needle = normal.length_squared() <= 1e-16 * longest * longest;
    if w_a > 0.0 && w_b > 0.0 && w_c > 0.0 && !needle {
        return (a * w_a + b * w_b + c * w_c) / (w_a + w_b + w_c);
    }
    let mut best = (f64::INFINITY, a);
    let mut offer = |weight: f64, q: DVec3, along: DVec3, qp: DVec3| {
        if weight <= 0.0 || needle {
            let point = closest_on_segment(q, along, qp);
            let distance = p.distance_squared(point);
            if distance < best.0 {
                best = (distance, point);
            }
        }
    };
    offer(w_c, a, ab, ap);
    offer(w_a, b, bc, bp);
    offer(w_b, c, ca, cp);
    best.1
}

/// The closest point of the segment from `q` along `along` to `q + qp`.
#[inline]
fn closest_on_segment(q: DVec3, along: DVec3, qp: DVec3) -> DVec3 {
    let length_squared = along.length_squared();
    let t = if length_squared > 0.0 { (along.dot(qp) / length_squared).clamp(0.0, 1.0) } else { 0.0 };
    q + t * along
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn degenerate_triangles_are_edges_or_points() {
        let (a, b, c) = (DVec3::ZERO, DVec3::X * 2.0, DVec3::X);
        let p = DVec3::new(1.5, 1.0, 0.0);
        for t in [[a, b, c], [b, c, a], [c, a, b], [a, b, b], [a, b, a]] {
            assert_eq!(closest_on_triangle(p, t), DVec3::X * 1.5);
        }
        assert_eq!(closest_on_triangle(p, [b, b, b]), b);
        let needle = [a, DVec3::new(1e9, 1e-9, 0.0), DVec3::new(1e9, -1e-9, 0.0)];
        assert!(closest_on_triangle(DVec3::new(5.0, 3.0, 4.0), needle).distance(DVec3::X * 5.0) < 1e-6);
        // However thin one is, what lies on it is near it.
        let (along, across) = (DVec3::new(0.48, 0.6, 0.64), DVec3::new(0.8, 0.0, -0.6));
        for (height, share) in (4..16).flat_map(|k| [0.1, 0.37, 0.9].map(|share| (0.1f64.powi(k), share))) {
            let needle = [a, 0.3 * along + height * across, along];
            let on =
                [needle[0], needle[1], needle[2], needle[0].lerp(needle[1], share), needle[1].lerp(needle[2], share)];
            assert!(on.iter().all(|&p| closest_on_triangle(p, needle).distance(p) < 1e-7), "{height}");
        }
    }
}
