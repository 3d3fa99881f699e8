//! How much of its area a quad turns back on itself, and how much it may.
//!
//! A cell is drawn as the bilinear surface through its corners. At a reflex corner that surface runs out over the border of
//! the cell and comes back. Seen along the mean normal of the quad, the area element J(u, v) is linear in u and v; J = 0
//! cuts a triangle off the parameter square, and there the surface faces backwards:
//!
//! ```text
//!      v
//!      q3 ─────────── q2      legs         u₀ = −J₀ / (J₁ − J₀),  v₀ = −J₀ / (J₃ − J₀)
//!      │               │      folded area  ∫ −J = −J₀ u₀ v₀ / 6   over the triangle
//!   v₀ ┤╲  J > 0       │
//!      │ ╲             │      J₀ … J₃: the element at the corners, for a planar quad
//!      │− ╲            │      the cross product of the two sides that meet there
//!      q0 ─┴────────── q1 u
//!          u₀
//! ```
//!
//! Integrators sample such a face on both sides of J = 0 or miss the triangle altogether, and the area of the model comes
//! out wrong by up to twice the folded area.

use crate::mesh::{Triangles, by_position};
use glam::DVec3;
use rayon::prelude::*;

/// Largest folded area of a large cell, as a share of the area of the mesh.
///
/// The area of the model is what readers compare, hence the share of the whole: twenty cells that just pass put it wrong by
/// 2e-5 at worst. A limit on the corner alone would also refuse the many cells that are reflex by a few degrees and fold
/// by next to nothing.
const FOLD_SHARE: f64 = 5e-7;

/// Cells up to this share of the area of the mesh may fold as they like.
///
/// Above it are the cells of coarse CAD models, of which a handful carry all the error. Below it are the cells of scans:
/// each folds by little, and refusing them would cost patches all over the surface.
const LARGE_CELL: f64 = 5e-4;

/// Largest folded area of a cell that becomes a face of a CAD model, as a share of its own area: all of them together put
/// the area of the model wrong by 2e-6 at worst.
const SLIGHT: f64 = 1e-6;

/// How much the cells of one mesh may fold.
pub(super) struct FoldLimit {
    /// Length that counts as one, so that products of tiny or huge coordinates neither vanish nor overflow.
    unit: f64,
    /// Area of the mesh in square units.
    area: f64,
}

impl FoldLimit {
    pub fn new(triangles: Triangles) -> Self {
        let corners = |t: u32| [3 * t, 3 * t + 1, 3 * t + 2].map(|c| triangles.point(c));
        let unit = (0..triangles.len() as u32).into_par_iter().map(|t| extent(corners(t))).reduce(|| 0.0, f64::max);
        // Whole numbers: their sum is the same in any order, on any number of threads.
        let sum: u128 = (0..triangles.len() as u32).into_par_iter().map(|t| fixed_point(area(corners(t), unit))).sum();
        FoldLimit { unit, area: sum as f64 / ONE }
    }

    /// Whether this quad, given by its corners in cyclic order, is large and folds noticeably.
    pub fn is_exceeded(&self, corners: [DVec3; 4]) -> bool {
        let [area, folded] = areas(corners, self.unit);
        area > LARGE_CELL * self.area && folded > FOLD_SHARE * self.area
    }

    /// Whether this quad folds so little that it may be a face.
    pub fn is_slight(&self, corners: [DVec3; 4]) -> bool {
        let [area, folded] = areas(corners, self.unit);
        folded <= SLIGHT * area
    }
}

/// Largest coordinate difference within a triangle; zero where it is too large for a double.
fn extent(p: [DVec3; 3]) -> f64 {
    let longest = (0..3).map(|k| (p[(k + 1) % 3] - p[k]).abs().max_element()).fold(0.0, f64::max);
    if longest.is_finite() { longest } else { 0.0 }
}

/// Area in square units, to the last bit the same for any numbering of the corners.
fn area(mut p: [DVec3; 3], unit: f64) -> f64 {
    p.sort_by(|a, b| by_position(*a, *b));
    0.5 * ((p[1] - p[0]) / unit).cross((p[2] - p[0]) / unit).length()
}

/// One square unit in fixed point. A triangle has at most about one, so 2³² of them do not overflow.
const ONE: f64 = (1u128 << 80) as f64;

fn fixed_point(area: f64) -> u128 {
    if area < 4.0 { (area * ONE) as u128 } else { 0 }
}

/// The area of the quad with these corners, in cyclic order, seen along its mean normal, and how much of its bilinear surface
/// faces backwards there; in square units. The latter is zero for a convex quad.
///
/// Half a turn of the corners, from one triangle to the other, changes no bit. Two neighbouring corners can turn back only
/// where the triangles bend by more than 90°; the folded area is a lower bound then.
fn areas(q: [DVec3; 4], unit: f64) -> [f64; 2] {
    let from_to = |a: usize, b: usize| (q[b % 4] - q[a]) / unit;
    let normal = from_to(0, 2).cross(from_to(1, 3));
    let direction = normal.normalize_or_zero();
    let element: [f64; 4] = std::array::from_fn(|k| from_to(k, k + 1).cross(from_to(k, k + 3)).dot(direction));
    let folded = |k: usize| {
        let back = -element[k];
        let leg = |other: f64| if other > 0.0 { back / (back + other) } else { 1.0 };
        if back > 0.0 { back * leg(element[(k + 1) % 4]) * leg(element[(k + 3) % 4]) / 6.0 } else { 0.0 }
    };
    [0.5 * normal.length(), (0..4).map(folded).fold(0.0, f64::max)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::context::Context;
    use crate::mesh::SurfaceMesh;
    use crate::patch::{PatchOptions, Strategy, decompose};
    use glam::DMat3;
    use proptest::prelude::*;

    /// Area and folded area of a quad in the plane z = 0 by quadrature: midpoints in u, and for each the exact integral
    /// over v, along which J is linear.
    fn quadrature(q: [DVec3; 4]) -> [f64; 2] {
        let element = |u: f64, v: f64| {
            let du = (q[1] - q[0]).lerp(q[2] - q[3], v);
            let dv = (q[3] - q[0]).lerp(q[2] - q[1], u);
            du.cross(dv).z
        };
        let parts = |from: f64, to: f64| match (from < 0.0, to < 0.0) {
            (false, false) => 0.0,
            (true, true) => -0.5 * (from + to),
            (true, false) => 0.5 * from * from / (to - from),
            (false, true) => 0.5 * to * to / (from - to),
        };
        let steps = 4000;
        let sum = (0..steps).map(|i| (f64::from(i) + 0.5) / f64::from(steps)).fold([0.0; 2], |[net, folded], u| {
            let (from, to) = (element(u, 0.0), element(u, 1.0));
            [net + 0.5 * (from + to), folded + parts(from, to)]
        });
        sum.map(|s| s / f64::from(steps))
    }

    /// A quad in the plane z = 0, counter-clockwise, whose first corner is drawn in along the diagonal: reflex for `depth`
    /// below 0, and still two triangles of positive area for `depth` above -0.5.
    fn dart(depth: f64, skew: f64) -> [DVec3; 4] {
        let tip = DVec3::new(0.5 - depth + skew * (0.5 + depth), 0.5 - depth, 0.0);
        [tip, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y]
    }

    /// Two meshes in one: the dart, cut along its inner diagonal, and far away a square of this area.
    fn dart_and_square(dart: [DVec3; 4], square: f64) -> SurfaceMesh {
        let side = square.sqrt();
        let far =
            [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| DVec3::new(x * side + 5.0, y * side, 0.0));
        let points = dart.into_iter().chain(far).collect();
        SurfaceMesh::from_triangles(points, &[[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]]).unwrap()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn areas_are_those_of_quadrature_in_any_position(
            depth in -0.45..0.45, skew in -0.4..0.4, turn in 0usize..4, angle in 0.0..6.0, exponent in -200i32..200,
        ) {
            let flat = dart(depth, skew);
            let [area, folded] = quadrature(flat);
            let place = DMat3::from_rotation_z(angle) * DMat3::from_rotation_x(0.4 * angle);
            let unit = 10f64.powi(exponent);
            let mut moved = flat.map(|p| unit * (place * p));
            moved.rotate_left(turn);
            let [found_area, found] = areas(moved, unit);
            prop_assert!((found_area - area).abs() < 1e-9, "{found_area} {area}");
            prop_assert!((found - folded).abs() < 1e-6 + 1e-3 * folded, "{found} {folded}");
            moved.rotate_left(2);
            prop_assert_eq!(areas(moved, unit), [found_area, found]);
        }

        /// The same dart is a cell where it is small or its fold is, and triangles where it matters to the whole.
        #[test]
        fn a_dart_is_refused_just_where_its_fold_matters(
            depth in -0.45..0.05, skew in -0.4..0.4, exponent in -2.0..7.0, grow in any::<bool>(),
        ) {
            let dart = dart(depth, skew);
            let square = 10f64.powf(exponent);
            let [area, folded] = quadrature(dart);
            let [area, folded] = [area, folded].map(|a| a / (area + square));
            // Not where the quadrature cannot tell.
            prop_assume!((area / 5e-4 - 1.0).abs() > 0.01 && (folded / 5e-7 - 1.0).abs() > 0.01);
            let strategy = if grow { Strategy::Grow } else { Strategy::Matching };
            let options = PatchOptions { strategy, min_cells: 1, q_max: 180.0, ..PatchOptions::default() };
            let result = decompose(&dart_and_square(dart, square), &options, &Context::new()).unwrap();
            let expected = if area > 5e-4 && folded > 5e-7 { 1 } else { 2 };
            prop_assert_eq!(result.figures.cells, expected, "area {} folded {}", area, folded);
        }
    }

    /// As faces, darts are triangles wherever their bilinear surface has another area than they, however small they are.
    #[test]
    fn a_dart_that_folds_is_no_face() {
        for (depth, expected) in [(-0.3, 1), (-0.05, 1), (-1e-3, 2), (0.1, 2)] {
            let mesh = dart_and_square(dart(depth, 0.0), 1e6);
            let options = PatchOptions { min_cells: 1, q_max: 180.0, faces: true, ..PatchOptions::default() };
            let result = decompose(&mesh, &options, &Context::new()).unwrap();
            assert_eq!(result.figures.cells, expected, "depth {depth}");
        }
    }

    #[test]
    fn the_numbering_does_not_change_the_limit() {
        let point = |k: u32| (f64::from(k) * DVec3::new(1.7, 2.9, 4.3)).map(f64::sin) * 1e3;
        let triangles: Vec<[u32; 3]> = (0..500).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        let turned: Vec<[u32; 3]> = triangles.iter().rev().map(|&[a, b, c]| [b, c, a]).collect();
        let limit = |triangles: &[[u32; 3]]| {
            let mesh = SurfaceMesh::from_triangles((0..1500).map(point).collect(), triangles).unwrap();
            let limit = FoldLimit::new(Triangles::of(&mesh).unwrap());
            (limit.unit, limit.area)
        };
        let (unit, area) = limit(&triangles);
        assert_eq!(limit(&turned), (unit, area));
        let expected: f64 =
            triangles.iter().map(|t| t.map(point)).map(|[a, b, c]| (b - a).cross(c - a).length() / 2.0).sum();
        assert!((area * unit * unit / expected - 1.0).abs() < 1e-12);
    }
}
