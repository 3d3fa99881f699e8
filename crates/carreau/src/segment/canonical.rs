//! The mesh in an order of place: vertices sorted by their coordinates, triangles by their vertices. All stages visit it in
//! that order and add up in it, so the result does not depend on how the input numbers vertices and triangles.

use super::{SegmentOptions, Segmentation};
use crate::error::Result;
use crate::mesh::{SurfaceMesh, Triangles, VertexId};
use rayon::prelude::*;

/// A renumbered copy of a mesh.
pub struct Canonical {
    pub mesh: SurfaceMesh,
    /// Vertex and triangle of the input for each of the copy's.
    vertex: Vec<u32>,
    triangle: Vec<u32>,
}

impl Canonical {
    pub fn new(triangles: Triangles<'_>) -> Result<Self> {
        let points = triangles.points();
        let mut by_place: Vec<([f64; 3], u32)> = (0..).zip(points).map(|(v, p)| (p.to_array(), v)).collect();
        by_place.par_sort_unstable_by(|(a, v), (b, w)| {
            let by = |k: usize| a[k].total_cmp(&b[k]);
            by(0).then_with(|| by(1)).then_with(|| by(2)).then(v.cmp(w))
        });
        let vertex: Vec<u32> = by_place.into_iter().map(|(_, v)| v).collect();
        let mut number = vec![0; vertex.len()];
        (0..).zip(&vertex).for_each(|(new, &old)| number[old as usize] = new);
        let renumbered = |t: u32| {
            let mut corners = triangles.triangle(t).map(|v| number[v as usize]);
            let first = (0..3).min_by_key(|&k| corners[k]).unwrap_or(0);
            corners.rotate_left(first);
            (corners, t)
        };
        let mut by_vertices: Vec<([u32; 3], u32)> =
            (0..triangles.len() as u32).into_par_iter().map(renumbered).collect();
        by_vertices.par_sort_unstable();
        let (corners, triangle): (Vec<[u32; 3]>, Vec<u32>) = by_vertices.into_iter().unzip();
        let points = vertex.iter().map(|&v| points[v as usize]).collect();
        Ok(Canonical { mesh: SurfaceMesh::from_triangles(points, &corners)?, vertex, triangle })
    }

    /// Options whose labels are those of the copy's triangles.
    pub fn options(&self, options: &SegmentOptions) -> SegmentOptions {
        let reordered = |labels: &Vec<u32>| self.triangle.iter().map(|&t| labels[t as usize]).collect();
        SegmentOptions { labels: options.labels.as_ref().map(reordered), ..options.clone() }
    }

    /// The regions of the copy as regions of the input.
    pub fn restore(&self, mut found: Segmentation) -> Segmentation {
        let mut labels = vec![0; found.labels.len()];
        self.triangle.iter().zip(&found.labels).for_each(|(&t, &l)| labels[t as usize] = l);
        found.labels = labels;
        let on_lines = found.boundaries.iter_mut().flat_map(|b| &mut b.vertices);
        let vertices = on_lines.chain(found.junctions.iter_mut().map(|j| &mut j.vertex));
        vertices.for_each(|v| *v = VertexId(self.vertex[v.index()]));
        found
    }
}
