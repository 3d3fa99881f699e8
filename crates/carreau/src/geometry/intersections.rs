//! Self-intersections: pairs of triangles with a common point that is no common corner or edge.
//!
//! Candidates come from a search tree that is walked against itself; whether two triangles meet is decided by the signs of
//! determinants, which are exact (Shewchuk, "Adaptive precision floating-point arithmetic and fast robust geometric
//! predicates", 1997). Corners are the same where they are at one place, whoever numbered them; a corner that lies on another
//! triangle is an intersection. Triangles without area take no part: they are defects of another kind.
//!
//! ```text
//!    two common corners      one common corner        none
//!    ╱│╲                     ╲     ╱                  an edge of one meets the other
//!   ╱ │ ╲  only where both    ╲   ╱  where the third
//!   ╲ │ ╱  lie in one plane    ╲ ╱   side of one
//!    ╲│╱   on the same side     •    meets the other
//! ```

use super::search_tree::TriangleTree;
use crate::context::Context;
use crate::error::Result;
use crate::mesh::{SurfaceMesh, UnitScale};
use glam::DVec3;
use rayon::prelude::*;
use robust::{Coord, Coord3D, orient2d, orient3d};
use serde::Serialize;

/// How many places are kept.
const PAIRS_KEPT: usize = 10;
/// Pairs that are counted one by one in a part of the surface: where there are more the number is a lower bound.
const MOST_PAIRS: usize = 1 << 16;

/// The self-intersections of a surface.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Intersections {
    /// Number of pairs of triangles.
    pub pairs: usize,
    /// There are more pairs than were counted.
    pub more: bool,
    /// The first pairs, by faces.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub places: Vec<[u32; 2]>,
}

impl Intersections {
    /// Finds the pairs of faces that meet; polygons are fans.
    ///
    /// # Errors
    /// [`crate::Error::Cancelled`], [`crate::Error::Deadline`].
    pub fn of(mesh: &SurfaceMesh, context: &Context) -> Result<Self> {
        Self::with(mesh, 0, context)
    }

    /// The pairs that have a face with this number or a later one.
    ///
    /// # Errors
    /// As [`Self::of`].
    pub fn with(mesh: &SurfaceMesh, from: u32, context: &Context) -> Result<Self> {
        let (triangles, face) = mesh.faces().fan();
        let scaled = UnitScale::of_mesh(mesh).points(mesh.points());
        let points = scaled.as_deref().unwrap_or(mesh.points());
        context.check()?;
        let tree = TriangleTree::new(points, &triangles);
        context.check()?;
        let pairs = tree.meeting_pairs();
        let found = (0..pairs.jobs()).into_par_iter().map(|job| {
            context.check()?;
            let (mut list, mut stopped) = (Vec::new(), Ok(()));
            let mut step = 0usize;
            pairs.visit(job, |(a, p), (b, q)| {
                step += 1;
                if stopped.is_ok() && step.is_multiple_of(4096) {
                    stopped = context.check();
                }
                let faces = [face[a as usize], face[b as usize]];
                if faces.iter().any(|&f| f >= from) && stopped.is_ok() && list.len() <= MOST_PAIRS && meet(p, q) {
                    list.push(faces);
                }
            });
            stopped.map(|()| list)
        });
        let found: Vec<Vec<[u32; 2]>> = found.collect::<Result<_>>()?;
        let more = found.iter().any(|list| list.len() > MOST_PAIRS);
        let mut all: Vec<[u32; 2]> =
            found.into_iter().flatten().filter(|[a, b]| a != b).map(|[a, b]| [a.min(b), a.max(b)]).collect();
        all.par_sort_unstable();
        all.dedup();
        Ok(Intersections { pairs: all.len(), more, places: all.into_iter().take(PAIRS_KEPT).collect() })
    }
}

type Triangle = [DVec3; 3];

/// Whether two triangles have a point in common besides their common corners and edges.
pub(crate) fn meet(p: &Triangle, q: &Triangle) -> bool {
    let (mut places, mut count) = ([[0; 2]; 3], 0);
    for k in 0..3 {
        if let Some(j) = q.iter().position(|b| *b == p[k]) {
            places[count] = [k, j];
            count += 1;
        }
    }
    let shared = &places[..count];
    // Both sides of a plane that the other does not reach: most pairs end here.
    if shared.len() < 3 && (is_beside(p, q, shared, 0) || is_beside(q, p, shared, 1)) {
        return false;
    }
    if is_flat(p) || is_flat(q) {
        return false;
    }
    match *shared {
        [] => sides(p).any(|side| reaches(side, q)) || sides(q).any(|side| reaches(side, p)),
        [[k, j]] => reaches(opposite(p, k), q) || reaches(opposite(q, j), p),
        [[k0, j0], [k1, j1]] => folds(p, q, [k0, k1], [j0, j1]),
        _ => true,
    }
}

fn sides(t: &Triangle) -> impl Iterator<Item = [DVec3; 2]> + '_ {
    (0..3).map(|k| [t[k], t[(k + 1) % 3]])
}

/// The side that a corner is not on.
fn opposite(t: &Triangle, k: usize) -> [DVec3; 2] {
    [t[(k + 1) % 3], t[(k + 2) % 3]]
}

fn sign(x: f64) -> i8 {
    i8::from(x > 0.0) - i8::from(x < 0.0)
}

fn above(t: &Triangle, p: DVec3) -> i8 {
    let c = |q: DVec3| Coord3D { x: q.x, y: q.y, z: q.z };
    sign(orient3d(c(t[0]), c(t[1]), c(t[2]), c(p)))
}

/// Whether all corners of `q` but the common ones are strictly on one side of the plane of `p`.
fn is_beside(p: &Triangle, q: &Triangle, shared: &[[usize; 2]], which: usize) -> bool {
    let is_common = |k: usize| shared.iter().any(|pair| pair[1 - which] == k);
    let mut side = 0;
    for k in (0..3).filter(|&k| !is_common(k)) {
        let own = above(p, q[k]);
        if own == 0 || own == -side {
            return false;
        }
        side = own;
    }
    side != 0
}

/// The triangle or the segment as seen along an axis.
fn along(axis: usize, p: DVec3) -> Coord<f64> {
    match axis {
        0 => Coord { x: p.y, y: p.z },
        1 => Coord { x: p.z, y: p.x },
        _ => Coord { x: p.x, y: p.y },
    }
}

fn turn(axis: usize, a: DVec3, b: DVec3, c: DVec3) -> i8 {
    sign(orient2d(along(axis, a), along(axis, b), along(axis, c)))
}

fn is_flat(t: &Triangle) -> bool {
    (0..3).all(|axis| turn(axis, t[0], t[1], t[2]) == 0)
}

/// Whether a segment has a point in common with a triangle.
fn reaches([a, b]: [DVec3; 2], t: &Triangle) -> bool {
    let (above_a, above_b) = (above(t, a), above(t, b));
    if above_a == 0 && above_b == 0 {
        return reaches_in_plane([a, b], t);
    }
    if above_a == above_b {
        return false;
    }
    let c = |q: DVec3| Coord3D { x: q.x, y: q.y, z: q.z };
    let around = [0, 1, 2].map(|k| sign(orient3d(c(a), c(b), c(t[k]), c(t[(k + 1) % 3]))));
    around.iter().all(|&s| s >= 0) || around.iter().all(|&s| s <= 0)
}

/// The same for a segment in the plane of the triangle.
fn reaches_in_plane([a, b]: [DVec3; 2], t: &Triangle) -> bool {
    let Some(axis) = (0..3).find(|&axis| turn(axis, t[0], t[1], t[2]) != 0) else { return false };
    let sense = turn(axis, t[0], t[1], t[2]);
    let is_inside = |p: DVec3| (0..3).all(|k| turn(axis, t[k], t[(k + 1) % 3], p) * sense >= 0);
    is_inside(a) || is_inside(b) || sides(t).any(|side| cross(axis, [a, b], side))
}

/// Whether two segments in a plane have a point in common.
fn cross(axis: usize, [a, b]: [DVec3; 2], [c, d]: [DVec3; 2]) -> bool {
    let [s, t, u, v] = [turn(axis, a, b, c), turn(axis, a, b, d), turn(axis, c, d, a), turn(axis, c, d, b)];
    if [s, t, u, v] == [0; 4] {
        let range = |p: f64, q: f64| (p.min(q), p.max(q));
        let overlap = |f: fn(Coord<f64>) -> f64| {
            let (own, other) =
                (range(f(along(axis, a)), f(along(axis, b))), range(f(along(axis, c)), f(along(axis, d))));
            own.0 <= other.1 && other.0 <= own.1
        };
        return overlap(|p| p.x) && overlap(|p| p.y);
    }
    s * t <= 0 && u * v <= 0
}

/// Whether two triangles with a common edge lie on each other.
fn folds(p: &Triangle, q: &Triangle, [k0, k1]: [usize; 2], [j0, j1]: [usize; 2]) -> bool {
    let (apex, other) = (p[3 - k0 - k1], q[3 - j0 - j1]);
    let axis = (0..3).find(|&axis| turn(axis, p[0], p[1], p[2]) != 0);
    let in_plane = above(p, other) == 0;
    in_plane && axis.is_some_and(|axis| turn(axis, p[k0], p[k1], apex) == turn(axis, p[k0], p[k1], other))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::test_models::*;
    use proptest::prelude::*;

    fn pairs(mesh: &SurfaceMesh) -> Intersections {
        Intersections::of(mesh, &Context::new()).unwrap()
    }

    /// Distance of two triangles by halving both, down to pieces whose boxes are apart: no determinant.
    fn oracle(p: &Triangle, q: &Triangle) -> bool {
        let near = |p: &Triangle, q: &Triangle| {
            let reach = |t: &Triangle| (t[0].min(t[1]).min(t[2]), t[0].max(t[1]).max(t[2]));
            let ((a, b), (c, d)) = (reach(p), reach(q));
            a.cmple(d).all() && c.cmple(b).all()
        };
        let halves = |t: &Triangle| {
            let k = (0..3).max_by(|&a, &b| {
                let length = |k: usize| t[k].distance_squared(t[(k + 1) % 3]);
                length(a).total_cmp(&length(b))
            });
            let k = k.unwrap();
            let (a, b, c) = (t[k], t[(k + 1) % 3], t[(k + 2) % 3]);
            [[a, 0.5 * (a + b), c], [0.5 * (a + b), b, c]]
        };
        let mut front = vec![(*p, *q)];
        for _ in 0..22 {
            let parts = |(p, q): (Triangle, Triangle)| {
                halves(&p).into_iter().flat_map(move |p| halves(&q).map(move |q| (p, q))).collect::<Vec<_>>()
            };
            front = front.into_iter().flat_map(parts).filter(|(p, q)| near(p, q)).take(3000).collect();
        }
        !front.is_empty()
    }

    fn place() -> impl Strategy<Value = DVec3> {
        prop::array::uniform3(-1.0f64..1.0).prop_map(DVec3::from_array)
    }

    fn lattice() -> impl Strategy<Value = DVec3> {
        prop::array::uniform3(-2i32..3).prop_map(|p| DVec3::from(p.map(f64::from)))
    }

    proptest! {
        #[test]
        fn two_triangles_meet_where_halving_finds_no_gap(p in prop::array::uniform3(place()), q in prop::array::uniform3(place())) {
            prop_assert_eq!(meet(&p, &q), oracle(&p, &q));
        }

        #[test]
        fn the_order_of_corners_and_triangles_does_not_matter(p in prop::array::uniform3(lattice()), q in prop::array::uniform3(lattice())) {
            let found = meet(&p, &q);
            prop_assert_eq!(meet(&q, &p), found);
            prop_assert_eq!(meet(&[p[2], p[0], p[1]], &[q[1], q[0], q[2]]), found);
            let moved = |t: Triangle| t.map(|p| DVec3::new(p.y, -p.x, p.z) * 4.0 + DVec3::splat(8.0));
            prop_assert_eq!(meet(&moved(p), &moved(q)), found);
        }

        #[test]
        fn the_tree_finds_what_all_pairs_tell(points in prop::collection::vec(lattice(), 3..30), picks in prop::collection::vec(prop::array::uniform3(0usize..30), 1..40)) {
            let t: Vec<[u32; 3]> = picks.iter().map(|t| t.map(|k| (k % points.len()) as u32)).collect();
            let at = |t: &[u32; 3]| t.map(|v| points[v as usize]);
            let mut all = Vec::new();
            for (a, p) in t.iter().enumerate() {
                for (b, q) in t.iter().enumerate().skip(a + 1).filter(|(_, q)| meet(&at(p), &at(q))) {
                    let _ = q;
                    all.push([a as u32, b as u32]);
                }
            }
            let found = pairs(&triangles(&points, &t));
            prop_assert_eq!(found.pairs, all.len());
            all.truncate(PAIRS_KEPT);
            prop_assert_eq!(found.places, all);
        }
    }

    #[test]
    fn closed_surfaces_have_none_and_two_that_cross_have_some() {
        for mesh in [sphere(3), torus(20, 12), cube(DVec3::ZERO, 1.0), grid(5), strip(12, 1), cubes_sharing_an_edge()] {
            assert_eq!(pairs(&mesh).pairs, 0);
        }
        let crossed = together(&[sphere(2), moved(&sphere(2), |p| p + DVec3::splat(0.3))]);
        assert!(pairs(&crossed).pairs > 20);
        // The second sphere with the first, and with itself; then nothing.
        let of_second = Intersections::with(&crossed, 320, &Context::new()).unwrap();
        assert_eq!((of_second.pairs, of_second.places), (pairs(&crossed).pairs, pairs(&crossed).places));
        assert_eq!(Intersections::with(&crossed, 640, &Context::new()).unwrap().pairs, 0);
        let apart = together(&[sphere(2), moved(&sphere(2), |p| p + 3.0 * DVec3::X)]);
        assert_eq!(pairs(&apart).pairs, 0);
    }

    #[test]
    fn copies_folds_and_corners_on_faces_count() {
        let twice = together(&[tetrahedron(), tetrahedron()]);
        // Every face of one with its copy alone: the others have an edge in common with it.
        assert_eq!(pairs(&twice).pairs, 4);
        let p = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::new(0.4, 0.4, 0.0)];
        assert_eq!(pairs(&triangles(&p, &[[0, 1, 2], [1, 0, 3]])).pairs, 1);
        let on = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::new(0.2, 0.2, 0.0), DVec3::Z, DVec3::ONE];
        assert_eq!(pairs(&triangles(&on, &[[0, 1, 2], [3, 4, 5]])).places, [[0, 1]]);
    }

    #[test]
    fn no_unit_hides_them() {
        let crossed = together(&[sphere(1), moved(&sphere(1), |p| p + DVec3::splat(0.3))]);
        let wanted = pairs(&crossed);
        for unit in [1e-150, 1e150] {
            assert_eq!(pairs(&moved(&crossed, |p| p * unit)).pairs, wanted.pairs, "{unit}");
        }
    }
}
