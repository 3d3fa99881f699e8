//! Hexahedra of second order: a node in the middle of every edge, every face and the cell.

use super::hex_mesh::{HEX_FACES, HexMesh};
use super::middle_nodes::SecondOrder;
use super::raw::RawMesh;
use crate::error::{Error, Result};
use glam::DVec3;
use rayon::prelude::*;

/// The edges of a hexahedron in the order of VTK's nodes 8 to 19, as corners.
///
/// ```text
///    7──14──6
///   15│    13│        24 below, 25 above, 20 and 21 at the ends of the first axis,
///  4──12──5  18       22 and 23 at those of the second, 26 in the middle
///  │ 19   │  │
/// 16  3─10┼──2
///  │11    17 9
///  0───8──1
/// ```
pub const HEX_EDGE_NODES: [[usize; 2]; 12] =
    [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]];
/// The faces of a hexahedron in the order of VTK's nodes 20 to 25, as places in [`HEX_FACES`].
pub const HEX_FACE_NODES: [usize; 6] = [5, 3, 2, 4, 0, 1];

impl SecondOrder {
    /// The nodes of a mesh with straight edges, and their places, which follow the points of the mesh: edges, faces, cells, each in
    /// the order of their ascending corners.
    ///
    /// # Errors
    /// [`Error::Input`] where there would be more nodes than numbers for them.
    pub fn of(mesh: &HexMesh) -> Result<(SecondOrder, MiddleNodes)> {
        let edge = |a: u32, b: u32| [a.min(b), a.max(b)];
        let mut edges: Vec<[u32; 2]> = mesh
            .hexes
            .par_iter()
            .flat_map_iter(|h| HEX_EDGE_NODES.iter().map(move |&[a, b]| edge(h[a], h[b])))
            .collect();
        edges.par_sort_unstable();
        edges.dedup();
        let face = |h: &[u32; 8], k: usize| sorted(HEX_FACES[k].map(|c| h[c]));
        let mut faces: Vec<[u32; 4]> =
            mesh.hexes.par_iter().flat_map_iter(|h| (0..6).map(move |k| face(h, k))).collect();
        faces.par_sort_unstable();
        faces.dedup();
        let [of_edges, of_faces, of_cells] = [0, edges.len(), edges.len() + faces.len()].map(|k| mesh.points.len() + k);
        if of_cells + mesh.hexes.len() > u32::MAX as usize {
            return Err(Error::input("the mesh has too many nodes for cells of second order", "", "make fewer cells"));
        }
        let edge_node = |a: u32, b: u32| (of_edges + edges.binary_search(&edge(a, b)).unwrap_or(0)) as u32;
        let face_node = |key: [u32; 4]| (of_faces + faces.binary_search(&key).unwrap_or(0)) as u32;
        let cell = |(k, h): (usize, &[u32; 8])| {
            std::array::from_fn(|n| match n {
                0..12 => edge_node(h[HEX_EDGE_NODES[n][0]], h[HEX_EDGE_NODES[n][1]]),
                12..18 => face_node(face(h, HEX_FACE_NODES[n - 12])),
                _ => (of_cells + k) as u32,
            })
        };
        let quad = |q: &[u32; 4]| {
            std::array::from_fn(|k| if k < 4 { edge_node(q[k], q[(k + 1) % 4]) } else { face_node(sorted(*q)) })
        };
        let hexes = mesh.hexes.par_iter().enumerate().map(cell).collect();
        let quads = mesh.quads.par_iter().map(quad).collect();
        Ok((SecondOrder { hexes, quads }, MiddleNodes { edges, faces, first: mesh.points.len() as u32 }))
    }
}

/// What the nodes of second order stand in the middle of.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MiddleNodes {
    /// Ends of the edges, ascending.
    pub edges: Vec<[u32; 2]>,
    /// Corners of the faces, ascending.
    pub faces: Vec<[u32; 4]>,
    /// The first node.
    pub first: u32,
}

impl RawMesh {
    /// The same with the corners of its cells as the only nodes.
    pub fn first_order(&self) -> RawMesh {
        let mut mesh = RawMesh { second_order: None, ..self.clone() };
        let least = self.second_order.iter().flat_map(|s| s.hexes.as_flattened()).copied().min();
        if let Some(count) = least.map(|first| first as usize).filter(|_| mesh.attributes.vertex.is_empty()) {
            mesh.points.truncate(count);
        }
        mesh
    }

    /// The same with nodes of second order, whose places follow its points.
    pub fn with_second_order(mut self, nodes: SecondOrder, places: &[DVec3]) -> RawMesh {
        self.points.extend_from_slice(places);
        self.second_order = Some(nodes);
        self
    }
}

fn sorted(mut q: [u32; 4]) -> [u32; 4] {
    q.sort_unstable();
    q
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::test_models::bricks;

    #[test]
    fn cells_share_their_nodes() {
        let (points, hexes) = bricks([2, 1, 1]);
        let mesh = HexMesh { quads: vec![[0, 3, 9, 6]], tags: vec![1], points, hexes };
        let (second, nodes) = SecondOrder::of(&mesh).unwrap();
        assert_eq!((nodes.edges.len(), nodes.faces.len(), nodes.first), (20, 11, 12));
        // The right side of the one is the left side of the other.
        assert_eq!(second.hexes[0][13], second.hexes[1][12]);
        assert_eq!([9, 17, 18].map(|n| second.hexes[0][n - 8]), [11, 16, 19].map(|n| second.hexes[1][n - 8]));
        assert_eq!(second.hexes[1][18], 12 + 20 + 11 + 1);
        assert_eq!(second.quads[0][4], second.hexes[0][12]);
        // Every node lies in the middle of the corners that it stands for.
        for (k, [a, b]) in HEX_EDGE_NODES.into_iter().enumerate() {
            let [a, b] = [a, b].map(|c| mesh.hexes[0][c]);
            assert_eq!(nodes.edges[second.hexes[0][k] as usize - 12], [a.min(b), a.max(b)]);
        }
    }
}
