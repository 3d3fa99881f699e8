//! Hexahedral meshes with tagged boundary.

use super::attributes::Column;
use super::polygons::Polygons;
use super::raw::{Cells, RawMesh};
use glam::DVec3;
use rayon::prelude::*;

/// Faces of a hexahedron in VTK corner order, counter-clockwise from outside.
pub const HEX_FACES: [[usize; 4]; 6] =
    [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];
/// Edges of a hexahedron: four along each of its axes.
pub const HEX_EDGES: [[usize; 2]; 12] =
    [[0, 1], [3, 2], [4, 5], [7, 6], [0, 3], [1, 2], [4, 7], [5, 6], [0, 4], [1, 5], [3, 7], [2, 6]];

/// Hexahedra in VTK corner order with their boundary.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct HexMesh {
    /// Positions of the vertices.
    pub points: Vec<DVec3>,
    /// Corners of the cells.
    pub hexes: Vec<[u32; 8]>,
    /// Boundary faces, outward.
    pub quads: Vec<[u32; 4]>,
    /// Reference number of every boundary face.
    pub tags: Vec<i32>,
}

impl From<HexMesh> for RawMesh {
    fn from(mesh: HexMesh) -> Self {
        let mut faces = Polygons::new();
        mesh.quads.iter().for_each(|q| faces.push(q));
        let cells = Cells { tags: vec![0; mesh.hexes.len()], hexes: mesh.hexes, ..Cells::default() };
        let mut raw = RawMesh { points: mesh.points, faces, cells, ..RawMesh::default() };
        raw.attributes.face.insert("ref".into(), Column::Label(mesh.tags));
        raw
    }
}

/// The faces that only one hexahedron has, outward, each with that hexahedron, in the order of the hexahedra.
pub fn boundary_faces(hexes: &[[u32; 8]]) -> Vec<([u32; 4], u32)> {
    let face = |k: usize| HEX_FACES[k % 6].map(|c| hexes[k / 6][c]);
    let keyed = |k: usize| {
        let mut key = face(k);
        key.sort_unstable();
        (key, k)
    };
    let mut faces: Vec<([u32; 4], usize)> = (0..6 * hexes.len()).into_par_iter().map(keyed).collect();
    faces.par_sort_unstable();
    let mut outer: Vec<usize> = faces.chunk_by(|a, b| a.0 == b.0).filter(|c| c.len() == 1).map(|c| c[0].1).collect();
    outer.sort_unstable();
    outer.into_iter().map(|k| (face(k), (k / 6) as u32)).collect()
}

/// The edges off the boundary that other than four hexahedra have, ascending, with that number; `quads` are the boundary
/// faces.
pub fn irregular_hex_edges(hexes: &[[u32; 8]], quads: &[[u32; 4]]) -> Vec<([u32; 2], u32)> {
    let key = |a: u32, b: u32| [a.min(b), a.max(b)];
    let mut edges: Vec<[u32; 2]> =
        hexes.par_iter().flat_map_iter(|h| HEX_EDGES.iter().map(move |&[a, b]| key(h[a], h[b]))).collect();
    edges.par_sort_unstable();
    let mut outer: Vec<[u32; 2]> = quads.iter().flat_map(|q| (0..4).map(move |k| key(q[k], q[(k + 1) % 4]))).collect();
    outer.par_sort_unstable();
    let unusual = edges.chunk_by(|a, b| a == b).filter(|same| same.len() != 4);
    unusual.filter(|same| outer.binary_search(&same[0]).is_err()).map(|same| (same[0], same.len() as u32)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_boundary_of_two_cells_is_ten_faces() {
        let hexes = [[0, 1, 2, 3, 4, 5, 6, 7], [4, 5, 6, 7, 8, 9, 10, 11]];
        let faces = boundary_faces(&hexes);
        assert_eq!(faces.len(), 10);
        assert!(faces.iter().all(|(q, h)| q.iter().all(|v| hexes[*h as usize].contains(v))));
        assert!(!faces.iter().any(|(q, _)| q.iter().all(|v| (4..8).contains(v))));
        let mesh = HexMesh {
            points: (0..12).map(|k| DVec3::splat(f64::from(k))).collect(),
            hexes: hexes.to_vec(),
            quads: faces.iter().map(|f| f.0).collect(),
            tags: vec![1; 10],
        };
        let raw = RawMesh::from(mesh);
        assert!(raw.check().is_ok() && raw.cells.hexes.len() == 2 && raw.faces.len() == 10);
    }
}
