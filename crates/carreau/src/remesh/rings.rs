//! The neighbours of all vertices in one array, for what looks at every ring of the source again and again: a walk around a
//! vertex touches six triangles for six neighbours.

use crate::mesh::EditMesh;

/// The ring of every vertex.
#[derive(Clone)]
pub struct Rings {
    /// Where the ring of every vertex begins.
    first: Vec<u32>,
    neighbours: Vec<u32>,
    /// Length of the edge to every neighbour.
    lengths: Vec<f64>,
}

impl Rings {
    /// The rings of a mesh; removed vertices have none.
    pub fn new(mesh: &EditMesh) -> Self {
        let edges = mesh.half_edge_slots() as usize;
        let mut out =
            Rings { first: vec![0], neighbours: Vec::with_capacity(edges), lengths: Vec::with_capacity(edges) };
        for v in 0..mesh.vertex_slots() {
            let p = mesh.points[v as usize];
            mesh.for_neighbours(v, |w| {
                out.neighbours.push(w);
                out.lengths.push(p.distance(mesh.points[w as usize]));
            });
            out.first.push(out.neighbours.len() as u32);
        }
        out
    }

    /// How many vertices there are.
    pub fn len(&self) -> u32 {
        self.first.len() as u32 - 1
    }

    /// The neighbours of a vertex, counter-clockwise.
    #[inline]
    pub fn of(&self, v: u32) -> &[u32] {
        &self.neighbours[self.first[v as usize] as usize..self.first[v as usize + 1] as usize]
    }

    /// The lengths of the edges to them.
    #[inline]
    pub fn lengths(&self, v: u32) -> &[f64] {
        &self.lengths[self.first[v as usize] as usize..self.first[v as usize + 1] as usize]
    }

    /// Neighbours with the lengths of the edges to them.
    #[inline]
    pub fn edges(&self, v: u32) -> impl Iterator<Item = (u32, f64)> + '_ {
        self.of(v).iter().copied().zip(self.lengths(v).iter().copied())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::test_models::{grid, torus};

    #[test]
    fn rings_are_what_a_walk_finds() {
        for mesh in [torus(8, 5), grid(4)] {
            let edit = EditMesh::new(&mesh).unwrap();
            let rings = Rings::new(&edit);
            assert_eq!(rings.len(), edit.vertex_slots());
            for v in 0..edit.vertex_slots() {
                let mut walked = Vec::new();
                edit.for_neighbours(v, |w| walked.push(w));
                assert_eq!(rings.of(v), walked);
                let far = |w: u32| edit.points[v as usize].distance(edit.points[w as usize]);
                assert!(rings.edges(v).all(|(w, d)| d == far(w)));
            }
        }
    }
}
