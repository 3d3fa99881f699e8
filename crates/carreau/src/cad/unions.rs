//! Neighbouring pieces that may be parts of one surface: those without a surface, those whose surface does not fit (for a plane, to
//! the precision of the file: a curve that bends little is nearly flat), and crumbs between them, joined where they meet smoothly.
//!
//! ```text
//!      ______                      a surface of revolution with a free profile, taken for a torus and a sphere:
//!     ╱torus ╲                     each is off by far more than its vertices are from what they lie on
//!     │‾‾‾‾‾‾│
//!     ╲sphere╱
//! ```

use super::regions::{Map, Piece, Rung, area_vector};
use super::topology::{Chain, Graph};
use super::tuning::NAMED_DISTANCE;
use crate::geometry::normals::{angle_between, unit};
use crate::geometry::primitive::Kind;
use crate::mesh::{DisjointSets, NONE};

/// Radians: edges that bend by more are none of one smooth surface, because its facets bend by half a radian at most.
pub const UNION_BEND: f64 = 0.75;
/// Radians: the same for crumbs of exact data, because two sides of a triangle may bend by half a radian each.
const CRUMB_BEND: f64 = 1.2;
/// A count: most triangles of a crumb, because what is left over between regions is no larger.
pub const UNION_CRUMB: usize = 3;

/// Sets of pieces, each with one at least that is not flat; flat ones alone are left out.
pub fn unions(map: &Map<'_>, graph: &Graph) -> Vec<Vec<u32>> {
    let named = NAMED_DISTANCE * map.diagonal;
    let is_free = |p: &Piece| p.rung == Rung::Spline;
    let is_flat = |p: &Piece| p.primitive.is_some_and(|q| q.kind() == Kind::Plane);
    let is_doubtful = |p: &Piece| p.max > if is_flat(p) { named } else { map.precision.max(named) };
    let is_crumb = |p: &Piece| is_flat(p) && p.triangles.len() <= UNION_CRUMB;
    let wanted = |s: u32| {
        let piece = &map.pieces[s as usize];
        is_free(piece) || is_doubtful(piece) || is_crumb(piece)
    };
    let exact = map.is_exact();
    let mut sets = DisjointSets::new(map.pieces.len());
    for chain in graph.chains.iter().filter(|c| c.sides.iter().all(|&s| s != NONE && wanted(s))) {
        let crumb = exact && chain.sides.iter().any(|&s| map.pieces[s as usize].triangles.len() <= UNION_CRUMB);
        if bend(map, chain) < if crumb { CRUMB_BEND } else { UNION_BEND } {
            sets.union(chain.sides[0], chain.sides[1]);
        }
    }
    let (of, count) = sets.labels();
    let mut members = vec![Vec::new(); count];
    for p in (0..map.pieces.len() as u32).filter(|&p| wanted(p)) {
        members[of[p as usize] as usize].push(p);
    }
    members.retain(|m| m.iter().any(|&p| !is_flat(&map.pieces[p as usize])));
    members
}

/// The mean angle between the facets on both sides of a chain.
fn bend(map: &Map<'_>, chain: &Chain) -> f64 {
    let normal = |c: u32| unit(area_vector(map.t, c / 3));
    let angle = |c: u32| angle_between(normal(c), normal(map.t.opposite(c)));
    let length = |c: u32| map.t.point(c).distance(map.t.point(map.t.next(c)));
    let (sum, total) = chain.half_edges.iter().fold((0.0, 0.0), |(s, l), &c| (s + length(c) * angle(c), l + length(c)));
    sum / f64::max(total, f64::MIN_POSITIVE)
}
