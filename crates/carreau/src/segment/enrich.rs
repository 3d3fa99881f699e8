//! Enrichment (§4.1): a triangle with three sharp vertices has no curvature of its own; a vertex at its centroid gives it
//! one. The vertex goes again at the end.
//!
//! ```text
//!        c                c
//!       ╱ ╲              ╱│╲
//!      ╱   ╲     →      ╱ m ╲        triangles (a,b,m), (b,c,m), (c,a,m)
//!     ╱     ╲          ╱╱   ╲╲
//!    a───────b        a───────b
//! ```

use super::surface::{Sharp, Surface};
use crate::error::Result;
use crate::geometry::curvature::Curvature;
use crate::mesh::{NONE, SurfaceMesh};
use glam::DVec3;

/// A mesh without triangles that have three sharp vertices.
pub struct Enriched {
    pub mesh: SurfaceMesh,
    /// The triangle of the input that each triangle is, or is a part of.
    pub parent: Vec<u32>,
    /// Per triangle of the input: it is in three parts.
    pub split: Vec<bool>,
}

/// Enriches a mesh; `None` where there is nothing to do.
pub fn enrich(surface: &Surface<'_>, sharp: &Sharp) -> Result<Option<Enriched>> {
    let t = surface.triangles;
    let closed = |k: u32| sharp.count(t.triangle(k)) == 3 && surface.areas[k as usize] > 0.0;
    let split: Vec<bool> = (0..t.len() as u32).map(closed).collect();
    if !split.contains(&true) {
        return Ok(None);
    }
    let mesh = surface.mesh.with_centers(&split)?;
    let parts = |(k, &split): (u32, &bool)| std::iter::repeat_n(k, if split { 3 } else { 1 });
    let parent = (0..).zip(&split).flat_map(parts).collect();
    Ok(Some(Enriched { mesh, parent, split }))
}

/// A part of a mesh, enough of it for the curvatures at some vertices.
pub struct Part {
    pub mesh: SurfaceMesh,
    /// Vertices and triangles of the whole, by those of the part.
    vertices: Vec<u32>,
    triangles: Vec<u32>,
    /// Per vertex of the part: its curvature is that of the whole.
    complete: Vec<bool>,
}

impl Part {
    /// What the corners of the whole have, for those of the part.
    pub fn of_corners(&self, whole: &[bool]) -> Vec<bool> {
        self.triangles.iter().flat_map(|&t| 3 * t..3 * t + 3).map(|c| whole[c as usize]).collect()
    }

    /// Curvatures of a mesh, with those of the part where it is complete; there may be more vertices than before.
    pub fn put_into(&self, whole: &Curvature, part: &Curvature) -> Curvature {
        let mut all = whole.clone();
        let count = self.vertices.iter().map(|&v| v as usize + 1).max().unwrap_or(0).max(all.kmin.len());
        all.kmin.resize(count, 0.0);
        all.kmax.resize(count, 0.0);
        all.dmin.resize(count, DVec3::ZERO);
        all.dmax.resize(count, DVec3::ZERO);
        all.border.resize(count, false);
        all.area.resize(count, 0.0);
        for (k, &v) in self.vertices.iter().enumerate().filter(|(k, _)| self.complete[*k]) {
            let v = v as usize;
            (all.kmin[v], all.kmax[v], all.area[v]) = (part.kmin[k], part.kmax[k], part.area[k]);
            (all.dmin[v], all.dmax[v], all.border[v]) = (part.dmin[k], part.dmax[k], part.border[k]);
        }
        all
    }
}

impl Enriched {
    /// Labels of the input: that of most children, of equally many the lowest.
    pub fn project(&self, label: &[u32], triangles: usize) -> Vec<u32> {
        let mut out = vec![0; triangles];
        let mut k = 0;
        for group in self.parent.chunk_by(|a, b| a == b) {
            let of = &label[k..k + group.len()];
            let votes = |l: u32| of.iter().filter(|&&x| x == l).count();
            let most = of.iter().copied().max_by(|&a, &b| votes(a).cmp(&votes(b)).then(b.cmp(&a)));
            out[group[0] as usize] = most.unwrap_or(0);
            k += group.len();
        }
        out
    }

    /// The part around the new vertices where the curvatures, measured on the faces around a vertex with the normals at their
    /// corners, are others than before; `None` where that is most of the mesh.
    pub fn surroundings(&self) -> Result<Option<Part>> {
        let triangles = || self.mesh.faces().corners().chunks_exact(3);
        let mut changed = vec![false; self.mesh.vertex_count()];
        // Here the normals change; one ring around, the measures of faces; one ring on there are the normals these need.
        for (corners, _) in triangles().zip(&self.parent).filter(|(_, parent)| self.split[**parent as usize]) {
            corners.iter().for_each(|&v| changed[v as usize] = true);
        }
        let ring = |marks: &[bool]| {
            let mut more = marks.to_vec();
            for corners in triangles().filter(|corners| corners.iter().any(|&v| marks[v as usize])) {
                corners.iter().for_each(|&v| more[v as usize] = true);
            }
            more
        };
        let wanted = ring(&changed);
        let needed = ring(&wanted);
        let touches = |(_, corners): &(u32, &[u32])| corners.iter().any(|&v| needed[v as usize]);
        let members: Vec<u32> = (0..).zip(triangles()).filter(touches).map(|(t, _)| t).collect();
        if 2 * members.len() > self.parent.len() {
            return Ok(None);
        }
        let mut number = vec![NONE; needed.len()];
        let mut vertices = Vec::new();
        let mut local = |v: u32| {
            if number[v as usize] == NONE {
                number[v as usize] = vertices.len() as u32;
                vertices.push(v);
            }
            number[v as usize]
        };
        let corners = self.mesh.faces().corners();
        let faces: Vec<[u32; 3]> =
            members.iter().map(|&t| [0, 1, 2].map(|k| local(corners[3 * t as usize + k]))).collect();
        let points = vertices.iter().map(|&v| self.mesh.points()[v as usize]).collect();
        let complete = vertices.iter().map(|&v| wanted[v as usize]).collect();
        Ok(Some(Part { mesh: SurfaceMesh::from_triangles(points, &faces)?, vertices, triangles: members, complete }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::context::Context;
    use crate::geometry::curvature::{CurvatureOptions, Estimator, curvature};
    use crate::mesh::Triangles;
    use crate::mesh::test_models::{moved, sphere};

    /// A ball that is rough around one pole: there are triangles with three sharp vertices.
    fn rough() -> SurfaceMesh {
        let height = |p: DVec3| 0.25 * (p.z - 0.75).max(0.0) * (31.0 * p.x).sin() * (27.0 * p.y).cos();
        moved(&sphere(4), |p| p * (1.0 + height(p)))
    }

    #[test]
    fn an_enriched_mesh_is_as_good_as_a_new_one() {
        let mesh = rough();
        let surface = Surface::new(&mesh, Triangles::of(&mesh).unwrap());
        let sharp = Sharp::new(&surface, 0.25);
        let enriched = enrich(&surface, &sharp).unwrap().unwrap();
        let faces: Vec<[u32; 3]> =
            enriched.mesh.faces().corners().chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect();
        let fresh = SurfaceMesh::from_triangles(enriched.mesh.points().to_vec(), &faces).unwrap();
        let triangles = Triangles::of(&enriched.mesh).unwrap();
        let (expected, found) =
            (Surface::new(&fresh, Triangles::of(&fresh).unwrap()), Surface::enriched(&surface, &enriched, triangles));
        assert!((0..3 * expected.len() as u32).all(|c| expected.triangles.opposite(c) == triangles.opposite(c)));
        assert_eq!(expected.normals, found.normals);
        assert_eq!(expected.areas, found.areas);
        assert_eq!(expected.bend, found.bend);
        assert_eq!(expected.total_area, found.total_area);
        assert_eq!(
            enriched.project(&enriched.parent, mesh.face_count()),
            (0..mesh.face_count() as u32).collect::<Vec<_>>()
        );
    }

    #[test]
    fn curvatures_of_the_surroundings_make_those_of_the_whole() {
        let mesh = rough();
        let surface = Surface::new(&mesh, Triangles::of(&mesh).unwrap());
        let sharp = Sharp::new(&surface, 0.25);
        let enriched = enrich(&surface, &sharp).unwrap().unwrap();
        let triangles = Triangles::of(&enriched.mesh).unwrap();
        let features = Sharp::new(&Surface::enriched(&surface, &enriched, triangles), 0.25).edge;
        let part = enriched.surroundings().unwrap().unwrap();
        for estimator in [Estimator::Corrected, Estimator::NormalCycle1Ring, Estimator::Mepp] {
            let of = |t: Triangles<'_>, features: &[bool]| {
                curvature(t, features, &CurvatureOptions { estimator, radius: None }, &Context::new()).unwrap()
            };
            let local = of(Triangles::of(&part.mesh).unwrap(), &part.of_corners(&features));
            let patched = part.put_into(&of(surface.triangles, &sharp.edge), &local);
            assert_eq!(patched, of(triangles, &features));
        }
    }
}
