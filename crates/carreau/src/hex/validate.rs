//! Checks any hexahedral mesh: conformity, quality, certificate.

use super::figures::HexQuality;
use crate::context::Context;
use crate::error::Result;
use crate::mesh::{HEX_FACES, HexMesh, boundary_faces};
use rayon::prelude::*;
use serde::Serialize;

/// What is to be known of a hexahedral mesh; its boundary is a surface and looked at as such.
#[derive(Debug, Clone, Serialize)]
pub struct Validity {
    /// Whether every face belongs to one or two cells, which see it from opposite sides.
    pub conforming: bool,
    /// Number of faces that violate this.
    pub bad_faces: usize,
    /// Cells with two equal corners.
    pub degenerate: usize,
    /// Vertices without a cell.
    pub unused_vertices: usize,
    /// Faces of one cell.
    pub boundary_quads: usize,
    /// What the cells are worth.
    #[serde(flatten)]
    pub quality: HexQuality,
}

impl Validity {
    /// Looks at a mesh; its list of boundary faces is not used. Corners must be valid.
    ///
    /// # Errors
    /// [`Error::Cancelled`](crate::Error::Cancelled), [`Error::Deadline`](crate::Error::Deadline).
    pub fn of(mesh: &HexMesh, context: &Context) -> Result<Validity> {
        let HexMesh { points, hexes, .. } = mesh;
        let quads: Vec<[u32; 4]> = boundary_faces(hexes).into_iter().map(|f| f.0).collect();
        let bad_faces = bad_faces(hexes);
        let mut used = vec![false; points.len()];
        hexes.as_flattened().iter().for_each(|&v| used[v as usize] = true);
        let is_degenerate = |h: &&[u32; 8]| (1..8).any(|k| h[..k].contains(&h[k]));
        Ok(Validity {
            conforming: bad_faces == 0,
            bad_faces,
            degenerate: hexes.iter().filter(is_degenerate).count(),
            unused_vertices: used.iter().filter(|u| !**u).count(),
            boundary_quads: quads.len(),
            quality: HexQuality::of(points, hexes, &quads, context)?,
        })
    }
}

/// Faces of more than two cells, or of two that do not see them from opposite sides.
fn bad_faces(hexes: &[[u32; 8]]) -> usize {
    let keyed = |k: usize| {
        let face = HEX_FACES[k % 6].map(|c| hexes[k / 6][c]);
        let mut key = face;
        key.sort_unstable();
        let start = (0..4).find(|&c| face[c] == key[0]).unwrap_or(0);
        (key, [face[(start + 1) % 4], face[(start + 2) % 4], face[(start + 3) % 4]])
    };
    let mut faces: Vec<([u32; 4], [u32; 3])> = (0..6 * hexes.len()).into_par_iter().map(keyed).collect();
    faces.par_sort_unstable();
    let is_bad = |same: &&[([u32; 4], [u32; 3])]| match same {
        [_] => false,
        [(_, [a, b, c]), (_, other)] => *other != [*c, *b, *a],
        _ => true,
    };
    faces.chunk_by(|a, b| a.0 == b.0).filter(is_bad).count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// Cells of side 1 in a row, the corners of each its own by position.
    fn row(n: u32) -> HexMesh {
        let at = |k: u32, c: u32| 4 * k + c;
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let points = (0..=n).flat_map(|k| square.map(|[x, y]| DVec3::new(x, y, f64::from(k)))).collect();
        let hex = |k: u32| std::array::from_fn(|c| at(k + c as u32 / 4, c as u32 % 4));
        HexMesh { points, hexes: (0..n).map(hex).collect(), ..HexMesh::default() }
    }

    #[test]
    fn a_row_is_fine_and_what_is_done_to_it_is_seen() {
        let of = |mesh: &HexMesh| Validity::of(mesh, &Context::new()).unwrap();
        let v = of(&row(3));
        assert!(v.conforming && v.quality.certified && v.quality.irregular_edges.is_empty(), "{v:?}");
        assert_eq!((v.boundary_quads, v.unused_vertices, v.degenerate, v.quality.inverted), (14, 0, 0, 0));
        assert!((v.quality.volume - 3.0).abs() < 1e-12 && (v.quality.scaled_jacobian_min - 1.0).abs() < 1e-12);
        let mut twisted = row(3);
        twisted.hexes[1] = [4, 7, 6, 5, 8, 11, 10, 9];
        let v = of(&twisted);
        assert!(!v.conforming && v.bad_faces == 2 && v.quality.uncertified == [1] && v.quality.inverted == 1, "{v:?}");
        let mut third = row(3);
        third.hexes.push(third.hexes[1]);
        third.points.push(DVec3::ONE);
        let v = of(&third);
        assert!(v.bad_faces >= 2 && v.unused_vertices == 1);
    }

    /// A row that turns back into itself: its last cells lie where its first are.
    #[test]
    fn cells_that_lie_where_others_are_are_counted() {
        let of = |mesh: &HexMesh| Validity::of(mesh, &Context::new()).unwrap().quality;
        let bent = |turn: f64| {
            let mut mesh = row(60);
            for p in &mut mesh.points {
                let (sin, cos) = (p.z / 60.0 * turn).sin_cos();
                *p = DVec3::new((5.0 + p.x) * cos, p.y, (5.0 + p.x) * sin);
            }
            mesh
        };
        let (open, closed) = (of(&bent(6.2)), of(&bent(7.0)));
        assert!(open.overlapping.is_empty() && open.overlap == 0.0 && open.certified, "{open:?}");
        assert!(closed.certified, "each cell by itself is fine");
        // 7 - 2 pi of 7, at both ends.
        let share = 2.0 * (7.0 - std::f64::consts::TAU) / 7.0;
        assert!((closed.overlap - share).abs() < 0.04, "{} {share}", closed.overlap);
        assert!(closed.overlapping.contains(&0) && closed.overlapping.contains(&59));
    }
}
