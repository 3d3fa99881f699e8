//! The mesh under repair: points and polygons that remember where they come from.

use crate::error::Result;
use crate::mesh::attributes::{Attributes, gather_columns};
use crate::mesh::connectivity::faces_with_repeats;
use crate::mesh::half_edges::HalfEdges;
use crate::mesh::id::VertexId;
use crate::mesh::polygons::Polygons;
use crate::mesh::surface::{SurfaceMesh, TaggedEdge};
use crate::mesh::triangles::NONE;
use glam::DVec3;

/// Points and polygons without any promise, with the source of every vertex, face and corner in the original mesh.
pub struct Soup {
    pub points: Vec<DVec3>,
    pub faces: Polygons,
    pub tagged: Vec<TaggedEdge>,
    pub vertex_source: Vec<u32>,
    pub face_source: Vec<u32>,
    pub corner_source: Vec<u32>,
    /// The vertex that every one of the original mesh has become; [`NONE`] where it is gone.
    pub vertex_image: Vec<u32>,
}

impl Soup {
    pub fn of(mesh: &SurfaceMesh) -> Self {
        Soup {
            points: mesh.points().to_vec(),
            faces: mesh.faces().clone(),
            tagged: mesh.tagged_edges.clone(),
            vertex_source: (0..mesh.vertex_count() as u32).collect(),
            face_source: (0..mesh.face_count() as u32).collect(),
            corner_source: (0..mesh.corner_count() as u32).collect(),
            vertex_image: (0..mesh.vertex_count() as u32).collect(),
        }
    }

    pub fn half_edges(&self) -> HalfEdges {
        HalfEdges::new(&self.faces, self.points.len())
    }

    pub fn faces_with_repeats(&self) -> Vec<bool> {
        faces_with_repeats(&self.faces, self.points.len())
    }

    /// Replaces every vertex by its leader and drops the vertices that are not their own. Returns how many.
    pub fn merge_vertices(&mut self, leader: &[u32]) -> usize {
        self.faces.corners_mut().iter_mut().for_each(|v| *v = leader[*v as usize]);
        for edge in &mut self.tagged {
            edge.ends = edge.ends.map(|v| VertexId(leader[v.index()]));
        }
        self.tagged.retain(|edge| edge.ends[0] != edge.ends[1]);
        self.vertex_image.iter_mut().filter(|v| **v != NONE).for_each(|v| *v = leader[*v as usize]);
        let keep: Vec<bool> = leader.iter().enumerate().map(|(v, &l)| v == l as usize).collect();
        self.keep_vertices(&keep)
    }

    /// Drops vertices and renumbers the rest in order; tagged edges that lose an end go. Returns how many were dropped.
    pub fn keep_vertices(&mut self, keep: &[bool]) -> usize {
        let mut count = 0;
        let new_id: Vec<u32> = keep
            .iter()
            .map(|&k| {
                count += u32::from(k);
                count.wrapping_sub(1)
            })
            .collect();
        self.faces.corners_mut().iter_mut().for_each(|v| *v = new_id[*v as usize]);
        let moved = |v: u32| if v != NONE && keep[v as usize] { new_id[v as usize] } else { NONE };
        self.vertex_image.iter_mut().for_each(|v| *v = moved(*v));
        self.tagged.retain(|edge| edge.ends.iter().all(|v| keep[v.index()]));
        for edge in &mut self.tagged {
            edge.ends = edge.ends.map(|v| VertexId(new_id[v.index()]));
        }
        let mut at = keep.iter();
        self.points.retain(|_| at.next() == Some(&true));
        let mut at = keep.iter();
        self.vertex_source.retain(|_| at.next() == Some(&true));
        keep.len() - count as usize
    }

    /// Puts the vertices into the order of their sources; those that have no source of their own come last. Returns these.
    pub fn in_order_of_source(&mut self) -> Vec<u32> {
        let mut order: Vec<u32> = (0..self.points.len() as u32).collect();
        order.sort_by_key(|&v| (self.vertex_source[v as usize], v));
        let source = |v: u32| self.vertex_source[v as usize];
        let mut last = NONE;
        let (mut owners, mut copies) = (Vec::with_capacity(order.len()), Vec::new());
        for v in order {
            if source(v) == last {
                copies.push(v)
            } else {
                owners.push(v)
            }
            last = source(v);
        }
        copies.sort_unstable();
        let first_copy = owners.len() as u32;
        owners.extend(copies);
        let mut new_id = vec![0; owners.len()];
        (0u32..).zip(&owners).for_each(|(new, &old)| new_id[old as usize] = new);
        self.points = owners.iter().map(|&v| self.points[v as usize]).collect();
        self.vertex_source = owners.iter().map(|&v| self.vertex_source[v as usize]).collect();
        self.faces.corners_mut().iter_mut().for_each(|v| *v = new_id[*v as usize]);
        self.vertex_image.iter_mut().filter(|v| **v != NONE).for_each(|v| *v = new_id[*v as usize]);
        for edge in &mut self.tagged {
            edge.ends = edge.ends.map(|v| VertexId(new_id[v.index()]));
        }
        (first_copy..self.points.len() as u32).collect()
    }

    /// Drops the vertices that no face uses, and the tagged edges that end there. Returns how many vertices.
    pub fn drop_unreferenced(&mut self) -> usize {
        let mut used = vec![false; self.points.len()];
        self.faces.corners().iter().for_each(|&v| used[v as usize] = true);
        self.keep_vertices(&used)
    }

    /// Builds the faces anew: `rewrite` is given each face and hands its successors, as lists of corners of the old
    /// face, to the sink; none drops the face.
    pub fn rewrite_faces(&mut self, mut rewrite: impl FnMut(usize, &[u32], &mut dyn FnMut(&[u32]))) {
        let old = std::mem::take(&mut self.faces);
        let mut faces = Polygons::new();
        faces.reserve(old.len(), old.corners().len());
        let (mut face_source, mut corner_source) =
            (Vec::with_capacity(old.len()), Vec::with_capacity(old.corners().len()));
        for (f, face) in old.iter().enumerate() {
            let first = old.offsets()[f] as usize;
            rewrite(f, face, &mut |corners| {
                faces.push_iter(corners.iter().map(|&k| face[k as usize]));
                face_source.push(self.face_source[f]);
                corner_source.extend(corners.iter().map(|&k| self.corner_source[first + k as usize]));
            });
        }
        (self.faces, self.face_source, self.corner_source) = (faces, face_source, corner_source);
    }

    /// Drops the faces that are not to be kept. Returns how many.
    pub fn keep_faces(&mut self, keep: impl Fn(usize) -> bool) -> usize {
        let before = self.faces.len();
        let mut all = Vec::new();
        self.rewrite_faces(|f, face, out| {
            if keep(f) {
                all.clear();
                all.extend(0..face.len() as u32);
                out(&all);
            }
        });
        before - self.faces.len()
    }

    /// Turns faces over: the first corner stays first. Returns how many.
    pub fn turn_faces(&mut self, turn: impl Fn(usize) -> bool) -> usize {
        let Soup { faces, corner_source, .. } = self;
        let ranges: Vec<_> = faces.offsets().windows(2).map(|w| w[0] as usize + 1..w[1] as usize).collect();
        let mut count = 0;
        for range in ranges.into_iter().enumerate().filter(|(f, _)| turn(*f)).map(|(_, range)| range) {
            faces.corners_mut()[range.clone()].reverse();
            corner_source[range].reverse();
            count += 1;
        }
        count
    }

    /// The mesh, with the attributes that followed.
    pub fn into_mesh(self, original: &SurfaceMesh) -> Result<SurfaceMesh> {
        let from = &original.attributes;
        let mut mesh = SurfaceMesh::new(self.points, self.faces)?;
        mesh.attributes = Attributes {
            vertex: gather_columns(&from.vertex, &self.vertex_source),
            face: gather_columns(&from.face, &self.face_source),
            corner: gather_columns(&from.corner, &self.corner_source),
            names: from.names.clone(),
        };
        mesh.tagged_edges = self.tagged;
        Ok(mesh)
    }
}
