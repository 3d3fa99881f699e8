//! Slivers have no vote on normals: where a triangle is no higher than the files of careless kernels are exact, its normal is
//! rounding. It gets that of the neighbour across its longest edge, which it lies on:
//!
//! ```text
//!          ____________                ____________
//!         ╱            ╲              ╱            ╲
//!        a──────m───────b      →     a──────m───────b     the cap (a, b, m) looks where the triangle below looks,
//!         ╲            ╱              ╲            ╱      and bends towards the two above as that does
//!          ‾‾‾‾‾‾‾‾‾‾‾‾                ‾‾‾‾‾‾‾‾‾‾‾‾
//! ```

use crate::mesh::{NONE, Triangles};
use glam::DVec3;

/// A share of the diagonal: height of a sliver, because vertices are off by up to a tenth of that in careless files,
/// which turns a triangle of this height by 0.1 radians.
const SLIVER_HEIGHT: f64 = 1e-6;
/// A count: rounds, because there are slivers beside slivers beside slivers.
pub const SLIVER_ROUNDS: usize = 8;

/// Triangles that are lower than this are slivers.
pub fn height(points: &[DVec3]) -> f64 {
    let Some(&first) = points.first() else { return 0.0 };
    let (low, high) = points.iter().fold((first, first), |(low, high), &p| (low.min(p), high.max(p)));
    SLIVER_HEIGHT * (high - low).length()
}

/// Replaces the normals of slivers.
pub fn borrow_normals(triangles: Triangles<'_>, areas: &[f64], normals: &mut [DVec3]) {
    let least = height(triangles.points());
    let length = |c: u32| triangles.point(c).distance(triangles.point(triangles.next(c)));
    let longest = |t: u32| (3 * t..3 * t + 3).map(length).fold(0.0, f64::max);
    let mut open: Vec<u32> =
        (0..areas.len() as u32).filter(|&t| 2.0 * areas[t as usize] < least * longest(t)).collect();
    let mut waiting = vec![false; if open.is_empty() { 0 } else { areas.len() }];
    open.iter().for_each(|&t| {
        waiting[t as usize] = true;
        normals[t as usize] = DVec3::ZERO;
    });
    for _ in 0..SLIVER_ROUNDS {
        let lender = |&t: &u32| {
            let known = |c: &u32| triangles.opposite(*c) != NONE && !waiting[triangles.opposite(*c) as usize / 3];
            let across =
                (3 * t..3 * t + 3).filter(known).max_by(|&a, &b| length(a).total_cmp(&length(b)).then(b.cmp(&a)));
            across.map(|c| (t, normals[triangles.opposite(c) as usize / 3]))
        };
        let found: Vec<(u32, DVec3)> = open.iter().filter_map(lender).collect();
        if found.is_empty() {
            return;
        }
        for (t, normal) in found {
            (normals[t as usize], waiting[t as usize]) = (normal, false);
        }
        open.retain(|&t| waiting[t as usize]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::normals::face_normals;
    use crate::mesh::SurfaceMesh;

    #[test]
    fn caps_and_needles_look_where_a_neighbour_looks() {
        // A square of two triangles; on the diagonal a cap, and a needle at its end.
        let e = 1e-9;
        let points = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.5, 0.5], [e, e]];
        let lift = [0.0, 0.0, 0.0, 0.0, 1e-8, 1e-8];
        let points = points.iter().zip(lift).map(|(&[x, y], z)| DVec3::new(x, y, z)).collect();
        let faces = [[0, 1, 5], [5, 1, 4], [4, 1, 2], [0, 2, 3], [0, 5, 4], [0, 4, 2]];
        let mesh = SurfaceMesh::from_triangles(points, &faces).unwrap();
        let triangles = Triangles::of(&mesh).unwrap();
        let mut normals = face_normals(&mesh);
        let areas: Vec<f64> = (0..6)
            .map(|t| {
                let [a, b, c] = [0, 1, 2].map(|k| triangles.point(3 * t + k));
                0.5 * (b - a).cross(c - a).length()
            })
            .collect();
        borrow_normals(triangles, &areas, &mut normals);
        assert!(normals.iter().all(|n| n.z > 0.999), "{normals:?}");
    }
}
