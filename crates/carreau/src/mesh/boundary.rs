//! The boundary surface of a volume mesh.

use super::attributes::{Attributes, gather_columns};
use super::polygons::Polygons;
use super::raw::RawMesh;
use super::triangles::NONE;
use crate::error::{Error, Result};

/// Faces of tetrahedra, outward for cells of positive volume, in VTK corner order; see [`super::Cells`].
const TET: &[&[usize]] = &[&[0, 2, 1], &[0, 1, 3], &[1, 2, 3], &[2, 0, 3]];
/// The same for pyramids.
const PYRAMID: &[&[usize]] = &[&[0, 3, 2, 1], &[0, 1, 4], &[1, 2, 4], &[2, 3, 4], &[3, 0, 4]];
/// The same for wedges.
const WEDGE: &[&[usize]] = &[&[0, 2, 1], &[3, 4, 5], &[0, 1, 4, 3], &[1, 2, 5, 4], &[2, 0, 3, 5]];
/// The same for hexahedra.
const HEX: &[&[usize]] = &[&[0, 3, 2, 1], &[4, 5, 6, 7], &[0, 1, 5, 4], &[1, 2, 6, 5], &[2, 3, 7, 6], &[3, 0, 4, 7]];

/// A face with its vertices sorted, padded with [`NONE`]: equal for the two sides of an inner face.
type Key = [u32; 4];

fn key(face: &[u32]) -> Key {
    let mut key = [NONE; 4];
    key[..face.len()].copy_from_slice(face);
    key.sort_unstable();
    key
}

/// A side of a cell.
struct CellFace {
    key: Key,
    corners: [u32; 4],
    len: u8,
}

impl RawMesh {
    /// The faces that only one cell has, outward, as a surface on the vertices they use. Columns of the file's own faces
    /// are kept when the file lists every boundary face.
    ///
    /// # Errors
    /// [`Error::Input`] for a mesh without volume cells.
    pub fn boundary(&self) -> Result<RawMesh> {
        if self.cells.is_empty() {
            return Err(Error::input(
                "this is not a volume mesh: it has no cells whose boundary could be taken",
                "",
                "",
            ));
        }
        let mut faces = self.cell_faces();
        faces.sort_by_key(|f| f.key);
        let outer: Vec<&CellFace> =
            faces.chunk_by(|a, b| a.key == b.key).filter(|c| c.len() == 1).map(|c| &c[0]).collect();
        let mut out = RawMesh::default();
        let mut new_id = vec![NONE; self.points.len()];
        let mut kept = Vec::new();
        for face in &outer {
            for &v in &face.corners[..face.len as usize] {
                if new_id[v as usize] == NONE {
                    new_id[v as usize] = kept.len() as u32;
                    kept.push(v);
                }
            }
        }
        out.points = kept.iter().map(|&v| self.points[v as usize]).collect();
        out.faces = Polygons::new();
        for face in &outer {
            out.faces.push_iter(face.corners[..face.len as usize].iter().map(|&v| new_id[v as usize]));
        }
        let listed = self.listed_faces(&outer);
        out.attributes = Attributes {
            vertex: gather_columns(&self.attributes.vertex, &kept),
            face: listed.map(|source| gather_columns(&self.attributes.face, &source)).unwrap_or_default(),
            ..Attributes::words_of(&self.attributes)
        };
        Ok(out)
    }

    fn cell_faces(&self) -> Vec<CellFace> {
        let mut out = Vec::new();
        let cells = &self.cells;
        cells.tets.iter().for_each(|c| self.push_faces(c, TET, &mut out));
        cells.hexes.iter().for_each(|c| self.push_faces(c, HEX, &mut out));
        cells.wedges.iter().for_each(|c| self.push_faces(c, WEDGE, &mut out));
        cells.pyramids.iter().for_each(|c| self.push_faces(c, PYRAMID, &mut out));
        out
    }

    /// The faces of one cell; turned round when the cell is inside out.
    fn push_faces(&self, cell: &[u32], table: &[&[usize]], out: &mut Vec<CellFace>) {
        let p = |k: usize| self.points[cell[k] as usize] - self.points[cell[0] as usize];
        let triple = |f: [usize; 3]| p(f[0]).dot(p(f[1]).cross(p(f[2])));
        // The volume beneath a bilinear face is the mean of those beneath its two pairs of triangles. One pair alone may
        // give a cell that is twisted, but sound, a negative volume.
        let beneath = |f: &&[usize]| match **f {
            [a, b, c, d] => 0.5 * [[a, b, c], [a, c, d], [b, c, d], [b, d, a]].map(triple).iter().sum::<f64>(),
            [a, b, c] => triple([a, b, c]),
            _ => 0.0,
        };
        let inverted = table.iter().map(beneath).sum::<f64>() < 0.0;
        for side in table {
            let mut corners = [NONE; 4];
            side.iter().zip(&mut corners).for_each(|(&k, corner)| *corner = cell[k]);
            let len = side.len();
            if inverted {
                corners[..len].reverse();
            }
            out.push(CellFace { key: key(&corners[..len]), corners, len: len as u8 });
        }
    }

    /// The file's own face for every boundary face, when there is one for each.
    fn listed_faces(&self, outer: &[&CellFace]) -> Option<Vec<u32>> {
        let small = |f: &[u32]| (3..=4).contains(&f.len());
        let mut listed: Vec<(Key, u32)> =
            self.faces.iter().zip(0..).filter(|(f, _)| small(f)).map(|(f, k)| (key(f), k)).collect();
        listed.sort_unstable();
        let find = |face: &&CellFace| {
            let at = listed.binary_search_by_key(&face.key, |&(key, _)| key).ok()?;
            Some(listed[at].1)
        };
        outer.iter().map(find).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Cells, Column, SurfaceMesh};
    use glam::DVec3;

    /// Corners of the unit cube in hexahedron order.
    fn cube() -> Vec<DVec3> {
        let square = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(x, y)| (f64::from(x), f64::from(y)));
        [0.0, 1.0].iter().flat_map(|&z| square.map(|(x, y)| DVec3::new(x, y, z))).collect()
    }

    fn volume(mesh: &SurfaceMesh) -> f64 {
        let p = |v: u32| mesh.points()[v as usize];
        mesh.faces().fan().0.iter().map(|t| p(t[0]).dot(p(t[1]).cross(p(t[2]))) / 6.0).sum()
    }

    /// A cell of positive Jacobian everywhere whose volume is negative where all faces are cut along their first diagonals.
    #[test]
    fn a_twisted_cell_is_not_inside_out() {
        let points = [
            [0.0505, 0.0709, 0.0470],
            [0.0486, 0.0886, 0.0631],
            [0.0157, 0.1101, -0.0499],
            [0.0250, 0.0904, -0.0493],
            [-0.3380, -0.3002, -0.2484],
            [-0.3571, -0.2905, -0.2585],
            [-0.2894, -0.3214, -0.2964],
            [-0.2779, -0.3254, -0.2841],
        ]
        .map(DVec3::from);
        let faces = |points: &[DVec3]| {
            let cells = Cells { hexes: vec![[0, 1, 2, 3, 4, 5, 6, 7]], ..Cells::default() };
            RawMesh { points: points.to_vec(), cells, ..RawMesh::default() }.boundary().unwrap().faces
        };
        assert_eq!(faces(&points), faces(&cube()));
    }

    /// The boundary must be closed, outward, and hold the whole volume.
    fn check(cells: Cells, points: Vec<DVec3>, want: f64) {
        let surface = RawMesh { points, cells, ..RawMesh::default() }.boundary().unwrap().into_surface().unwrap();
        assert!((0..surface.corner_count()).all(|c| surface.opposite(crate::mesh::CornerId::new(c)).is_some()));
        assert!((volume(&surface) - want).abs() < 1e-12, "{}", volume(&surface));
    }

    #[test]
    fn boundaries_of_all_cells_are_closed_and_outward() {
        check(Cells { hexes: vec![[0, 1, 2, 3, 4, 5, 6, 7]], ..Cells::default() }, cube(), 1.0);
        check(Cells { hexes: vec![[0, 3, 2, 1, 4, 7, 6, 5]], ..Cells::default() }, cube(), 1.0);
        check(Cells { tets: vec![[0, 1, 3, 4]], ..Cells::default() }, cube(), 1.0 / 6.0);
        check(Cells { pyramids: vec![[0, 1, 2, 3, 4]], ..Cells::default() }, cube(), 1.0 / 3.0);
        check(Cells { wedges: vec![[0, 1, 3, 4, 5, 7], [3, 1, 2, 7, 5, 6]], ..Cells::default() }, cube(), 1.0);
    }

    #[test]
    fn columns_of_listed_faces_are_kept() {
        let cells = Cells { tets: vec![[0, 1, 2, 3]], ..Cells::default() };
        let points = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z, DVec3::ONE];
        let faces: Polygons = [&[0, 1, 2][..], &[3, 0, 1], &[1, 2, 3], &[2, 0, 3]].into_iter().collect();
        let mut raw = RawMesh { points, faces, cells, ..RawMesh::default() };
        raw.attributes.face.insert("ref".into(), Column::Label(vec![5, 6, 7, 8]));
        let surface = raw.boundary().unwrap();
        assert_eq!(surface.points.len(), 4);
        let Column::Label(refs) = &surface.attributes.face["ref"] else { panic!("labels stay labels") };
        let mut sorted = refs.clone();
        sorted.sort_unstable();
        assert_eq!(sorted, [5, 6, 7, 8]);
        for (face, want) in surface.faces.iter().zip(refs) {
            // The face with reference 7 is the one away from the origin.
            let has_origin = face.iter().any(|&v| surface.points[v as usize] == DVec3::ZERO);
            assert_eq!(*want == 7, !has_origin);
        }
    }
}
