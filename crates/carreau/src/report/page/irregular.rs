//! Finds the vertices and edges at which quads and hexahedra are not arranged as on a chessboard.

use crate::mesh::{HalfEdges, Polygons, boundary_faces, irregular_hex_edges};

/// Inner vertices whose number of quads is not four, with that number; nothing for meshes that are not all of quads.
pub fn irregular_vertices(faces: &Polygons, vertices: usize) -> Vec<(u32, i32)> {
    if faces.is_empty() || faces.iter().any(|f| f.len() != 4) {
        return Vec::new();
    }
    let mut valence = vec![0; vertices];
    faces.corners().iter().for_each(|&v| valence[v as usize] += 1);
    for edge in HalfEdges::new(faces, vertices).groups().filter(|e| e.len() != 2) {
        edge.ends.iter().for_each(|&v| valence[v as usize] = 0);
    }
    let found = (0..).zip(valence).filter(|&(_, n)| n != 0 && n != 4);
    found.collect()
}

/// Inner edges whose number of hexahedra is not four.
pub fn irregular_edges(hexes: &[[u32; 8]]) -> Vec<[u32; 2]> {
    let quads: Vec<[u32; 4]> = boundary_faces(hexes).into_iter().map(|(quad, _)| quad).collect();
    irregular_hex_edges(hexes, &quads).into_iter().map(|(edge, _)| edge).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sectors of a disc around vertex 0, each a quad.
    fn disc(sectors: u32) -> Vec<[u32; 4]> {
        let ring = |k: u32| 1 + k % (2 * sectors);
        (0..sectors).map(|k| [0, ring(2 * k), ring(2 * k + 1), ring(2 * k + 2)]).collect()
    }

    #[test]
    fn only_unusual_inner_vertices_are_found() {
        for sectors in 3..7 {
            let quads = disc(sectors);
            let faces: Polygons = quads.iter().map(|q| &q[..]).collect();
            let found = irregular_vertices(&faces, 2 * sectors as usize + 1);
            let want = if sectors == 4 { vec![] } else { vec![(0, sectors as i32)] };
            assert_eq!(found, want);
        }
        let mixed: Polygons = [&[0, 1, 2, 3][..], &[0, 3, 4]].into_iter().collect();
        assert!(irregular_vertices(&mixed, 5).is_empty());
    }

    #[test]
    fn only_unusual_inner_edges_are_found() {
        for sectors in 3..7 {
            let layer = 2 * sectors + 1;
            let lift = |q: [u32; 4], by: u32| q.map(|v| v + by * layer);
            let hexes: Vec<[u32; 8]> = (0..2)
                .flat_map(|level| disc(sectors).into_iter().map(move |q| (lift(q, level), lift(q, level + 1))))
                .map(|(low, high)| std::array::from_fn(|k| if k < 4 { low[k] } else { high[k - 4] }))
                .collect();
            let want = if sectors == 4 { vec![] } else { vec![[0, layer], [layer, 2 * layer]] };
            assert_eq!(irregular_edges(&hexes), want);
        }
    }
}
