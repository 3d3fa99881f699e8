//! Elements in the order of space: neighbours on the surface are neighbours in memory.
//!
//! Files number vertices as their makers went along: a subdivided mesh has its newest vertices last, a scan its strips side
//! by side. What walks over such a mesh waits for memory at every step. Here faces follow the Z-order curve of their centres
//! (Morton, "A computer oriented geodetic data base", 1966) and vertices their first face.

use super::attributes::{Attributes, gather_columns};
use super::id::VertexId;
use super::polygons::Polygons;
use super::surface::{SurfaceMesh, TaggedEdge};
use super::triangles::NONE;
use crate::error::Result;
use glam::DVec3;
use rayon::prelude::*;

/// Cells along an axis, as a power of two: three make one key.
const BITS: u32 = 21;

impl SurfaceMesh {
    /// The same mesh with faces and vertices in the order of space. Vertices of no face come last.
    ///
    /// # Errors
    /// None that the mesh itself did not have.
    pub fn in_space_order(&self) -> Result<SurfaceMesh> {
        let faces = self.face_order();
        let mut vertices = Vec::with_capacity(self.vertex_count());
        let mut id = vec![NONE; self.vertex_count()];
        let mut meet = |v: u32| {
            if id[v as usize] == NONE {
                id[v as usize] = vertices.len() as u32;
                vertices.push(v);
            }
        };
        faces.iter().for_each(|&f| self.faces().face(f as usize).iter().for_each(|&v| meet(v)));
        (0..self.vertex_count() as u32).for_each(meet);

        let offsets = self.faces().offsets();
        let corners = |&f: &u32| offsets[f as usize]..offsets[f as usize + 1];
        let mut polygons = Polygons::new();
        polygons.reserve(faces.len(), self.corner_count());
        faces.iter().for_each(|&f| polygons.push_iter(self.faces().face(f as usize).iter().map(|&v| id[v as usize])));
        let points = vertices.iter().map(|&v| self.points()[v as usize]).collect();
        let mut out = SurfaceMesh::new(points, polygons)?;
        let from = &self.attributes;
        out.attributes = Attributes {
            vertex: gather_columns(&from.vertex, &vertices),
            face: gather_columns(&from.face, &faces),
            corner: gather_columns(&from.corner, &faces.iter().flat_map(corners).collect::<Vec<u32>>()),
            ..Attributes::words_of(from)
        };
        let renamed = |edge: &TaggedEdge| TaggedEdge { ends: edge.ends.map(|v| VertexId(id[v.index()])), ..*edge };
        out.tagged_edges = self.tagged_edges.iter().map(renamed).collect();
        Ok(out)
    }

    /// Faces along the Z-order curve of their centres.
    fn face_order(&self) -> Vec<u32> {
        let (low, high) = self.bounds();
        let scale = f64::from(1u32 << BITS) / (high - low).max_element();
        let key = |f: usize| {
            let face = self.faces().face(f);
            let centre = face.iter().map(|&v| self.points()[v as usize] - low).sum::<DVec3>() / face.len() as f64;
            // Casts saturate, and a flat or endless box gives nothing but zeros.
            let [x, y, z] = (centre * scale).to_array().map(|c| spread((c as u64).min((1 << BITS) - 1)));
            (x | y << 1 | z << 2, f as u32)
        };
        let mut keyed: Vec<(u64, u32)> = (0..self.face_count()).into_par_iter().map(key).collect();
        keyed.par_sort_unstable();
        keyed.into_iter().map(|(_, f)| f).collect()
    }
}

/// The bits of a number below 2²¹, three places apart.
fn spread(x: u64) -> u64 {
    let steps = [
        (32, 0x001f_0000_0000_ffff),
        (16, 0x001f_0000_ff00_00ff),
        (8, 0x100f_00f0_0f00_f00f),
        (4, 0x10c3_0c30_c30c_30c3),
        (2, 0x1249_2492_4924_9249),
    ];
    steps.into_iter().fold(x, |x, (shift, mask)| (x | x << shift) & mask)
}

#[cfg(test)]
mod tests {
    use super::super::attributes::Column;
    use super::super::test_models::*;
    use super::*;
    use crate::mesh::Topology;
    use proptest::prelude::*;

    #[test]
    fn bits_are_spread_three_apart() {
        for k in 0..BITS {
            assert_eq!(spread(1 << k), 1 << (3 * k));
        }
        assert_eq!(spread((1 << BITS) - 1).count_ones(), BITS);
    }

    proptest! {
        #[test]
        fn the_mesh_is_the_same_and_does_not_depend_on_its_numbers(seed in any::<u64>()) {
            let mut mesh = torus(12, 7);
            mesh.attributes.vertex.insert("x".into(), Column::Scalar(mesh.points().iter().map(|p| p.x).collect()));
            let middle = |f: &[u32]| f.iter().map(|&v| mesh.points()[v as usize]).sum::<DVec3>().y;
            let middles = mesh.faces().iter().map(middle).collect();
            mesh.attributes.face.insert("y".into(), Column::Scalar(middles));
            mesh.tagged_edges = vec![TaggedEdge { ends: [VertexId(3), VertexId(4)], tag: 7 }];
            let ordered = mesh.in_space_order().unwrap();
            let p = |v: VertexId| ordered.point(v);
            prop_assert_eq!(ordered.tagged_edges[0].ends.map(p), [3, 4].map(|v| mesh.point(VertexId(v))));
            for (name, of) in [("x", &ordered.attributes.vertex), ("y", &ordered.attributes.face)] {
                let Some(Column::Scalar(values)) = of.get(name) else { panic!() };
                let expected: Vec<f64> = match name {
                    "x" => ordered.points().iter().map(|p| p.x).collect(),
                    _ => ordered.faces().iter().map(|f| f.iter().map(|&v| ordered.points()[v as usize]).sum::<DVec3>().y).collect(),
                };
                prop_assert_eq!(values, &expected);
            }
            let (a, b) = (Topology::of(&mesh), Topology::of(&ordered));
            prop_assert_eq!((a.components, a.genus, a.boundary_loops, a.edges), (b.components, b.genus, b.boundary_loops, b.edges));
            // Faces in any order give the same.
            let mut faces: Vec<Vec<u32>> = mesh.faces().iter().map(<[u32]>::to_vec).collect();
            let mut state = seed;
            for k in (1..faces.len()).rev() {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                faces.swap(k, (state >> 33) as usize % (k + 1));
            }
            let mut shuffled = Polygons::new();
            faces.iter().for_each(|f| shuffled.push(f));
            let shuffled = SurfaceMesh::new(mesh.points().to_vec(), shuffled).unwrap().in_space_order().unwrap();
            prop_assert_eq!(shuffled.points(), ordered.points());
            prop_assert_eq!(shuffled.faces(), ordered.faces());
        }
    }
}
