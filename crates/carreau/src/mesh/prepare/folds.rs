//! Triangles of fans that lie on each other: both go.
//!
//! ```text
//!        b                two quads a c b d and a d b e share the sides b d and d a, for d lies beside them. Their fans from a
//!       ╱│╲               have the triangle a d b in common, once in each sense: with one of them the edge a b would have
//!      ╱ │ ╲              three faces, with both four. Without them the surface is as closed as the quads are.
//!     c  │d e
//!      ╲ │ ╱              Two triangles that a file has like this are another matter: they are a wall, or a face that is
//!       ╲│╱               there twice (`doubles`).
//!        a
//! ```

use super::super::duplicates::first_on_same_vertices;
use super::super::repair::Soup;
use super::doubles::is_reversed;

/// Pairs of triangles that lie on each other in opposite senses, the second one's first; `polygon`: that of every face of the file.
/// Polygons that go altogether are there twice, and no folds.
pub(super) fn folded(soup: &Soup, polygon: &[u32]) -> Vec<[u32; 2]> {
    let first = first_on_same_vertices(&soup.faces, &soup.faces_with_repeats());
    let mut size = vec![0u32; first.len()];
    first.iter().for_each(|&l| size[l as usize] += 1);
    let of = |f: u32| polygon[soup.face_source[f as usize] as usize];
    let mut has_own = vec![false; polygon.iter().max().map_or(0, |&p| p as usize + 1)];
    for (f, _) in (0u32..).zip(&first).filter(|(_, l)| size[**l as usize] == 1) {
        has_own[of(f) as usize] = true;
    }
    let is_fold = |f: u32, l: u32| {
        let polygons = [of(f), of(l)];
        let is_part = polygons.iter().all(|&p| has_own[p as usize]);
        is_part && polygons[0] != polygons[1] && is_reversed(soup.faces.face(l as usize), soup.faces.face(f as usize))
    };
    let pairs = (0u32..).zip(&first).filter(|&(f, &l)| f != l && size[l as usize] == 2);
    pairs.filter(|&(f, &l)| is_fold(f, l)).map(|(f, &l)| [f, l]).collect()
}
