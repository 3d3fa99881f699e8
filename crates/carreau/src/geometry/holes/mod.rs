//! Holes filled with faces that follow the surroundings.
//!
//! | stage | file | source |
//! |---|---|---|
//! | the border loops | `loops` | – |
//! | a triangulation of least area | `area` | Barequet, Sharir, "Filling gaps in the boundary of a polyhedron", 1995 |
//! | triangles of the size of those around | `refine` | Liepa, "Filling holes in meshes", SGP 2003, §4 |
//! | vertices where the surface goes on | `fair` | the same, §5, by one linear system |
//!
//! Where the faces around a hole lie in a plane, so does what fills it: nothing is faired there. New vertices and faces come after
//! all others, hole by hole; faces take the labels of a face beside the hole, vertices the values of the nearest border vertex.

mod area;
mod fair;
mod loops;
mod patch;
mod refine;
#[cfg(test)]
mod tests;

use crate::context::Context;
use crate::error::{Error, Result};
use crate::mesh::{Attributes, CornerId, Polygons, SurfaceMesh, UnitScale, gather_columns};
use glam::DVec3;
use loops::Loop;
use patch::Patch;
use serde::Serialize;

/// A hole that was filled.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Hole {
    /// Number of its border edges.
    pub edges: usize,
    /// The new faces: the first, and one after the last.
    pub faces: [u32; 2],
    /// The new vertices: the first, and one after the last.
    pub vertices: [u32; 2],
}

/// A surface whose holes were filled.
#[derive(Debug, Clone)]
pub struct Filled {
    /// The surface; the new faces are triangles.
    pub mesh: SurfaceMesh,
    /// The holes, in the order of their first border edges.
    pub holes: Vec<Hole>,
    /// Holes that were left: with more edges than asked for, or with a border that meets itself.
    pub left: usize,
}

/// Fills holes, all of them or those of up to a number of border edges.
///
/// # Errors
/// [`Error::Numeric`] where a system cannot be solved, [`Error::Cancelled`], [`Error::Deadline`].
pub fn fill(mesh: &SurfaceMesh, most: Option<usize>, context: &Context) -> Result<Filled> {
    let scale = UnitScale::of_mesh(mesh);
    if let Some(mesh) = scale.mesh(mesh, &[]) {
        let filled = fill(&mesh, most, context)?;
        return Ok(Filled { mesh: scale.back().moved(filled.mesh, &[]), ..filled });
    }
    let _stage = context.stage("fill holes");
    let borders = loops::loops(mesh);
    let is_wanted = |border: &&Loop| border.simple && most.is_none_or(|most| border.corners.len() <= most);
    let wanted: Vec<&Loop> = borders.iter().filter(is_wanted).collect();
    let left = borders.len() - wanted.len();
    let half_edges = mesh.half_edges();
    let mut filling = Filling::of(mesh);
    for border in wanted {
        context.check()?;
        let ring: Vec<u32> = border.corners.iter().map(|&c| mesh.vertex(CornerId(c)).0).collect();
        // The patch runs against the faces around.
        let against: Vec<u32> = ring.iter().rev().copied().collect();
        let Some(triangles) =
            area::least_area(mesh.points(), &against, |a, b| half_edges.find(a, b).is_some(), context)?
        else {
            continue;
        };
        let first = filling.points.len() as u32;
        let mut patch = Patch { points: Vec::new(), triangles };
        refine::refine(&mut patch, mesh, &ring, first, context)?;
        fair::fair(&mut patch, mesh, &ring, first, context)?;
        filling.add(mesh, border, &ring, &patch);
    }
    let (mesh, holes) = filling.finish(mesh)?;
    Ok(Filled { mesh, holes, left })
}

/// A surface while its holes are filled; where new elements come from.
struct Filling {
    points: Vec<DVec3>,
    faces: Polygons,
    holes: Vec<Hole>,
    vertex_source: Vec<u32>,
    face_source: Vec<u32>,
    corner_source: Vec<u32>,
}

impl Filling {
    fn of(mesh: &SurfaceMesh) -> Self {
        Filling {
            points: mesh.points().to_vec(),
            faces: mesh.faces().clone(),
            holes: Vec::new(),
            vertex_source: Vec::new(),
            face_source: Vec::new(),
            corner_source: Vec::new(),
        }
    }

    /// Fills a hole; new elements are like the nearest ones of its border, whose vertices are `ring`.
    fn add(&mut self, mesh: &SurfaceMesh, border: &Loop, ring: &[u32], patch: &Patch) {
        let first = self.points.len() as u32;
        let nearest = |p: DVec3| {
            let near = |a: usize, b: usize| {
                p.distance_squared(mesh.points()[ring[a] as usize])
                    < p.distance_squared(mesh.points()[ring[b] as usize])
            };
            (0..ring.len()).fold(0, |best, k| if near(k, best) { k } else { best })
        };
        let sources: Vec<usize> = patch.points.iter().map(|&p| nearest(p)).collect();
        let face = mesh.face_of(CornerId(border.corners[0])).0;
        let from = self.faces.len() as u32;
        for t in &patch.triangles {
            self.faces.push(t);
            self.face_source.push(face);
            self.corner_source.extend(t.iter().map(|&v| {
                let k =
                    if v >= first { Some(sources[(v - first) as usize]) } else { ring.iter().position(|&r| r == v) };
                border.corners[k.unwrap_or(0)]
            }));
        }
        self.vertex_source.extend(sources.into_iter().map(|k| ring[k]));
        self.points.extend(&patch.points);
        self.holes.push(Hole {
            edges: ring.len(),
            faces: [from, self.faces.len() as u32],
            vertices: [first, self.points.len() as u32],
        });
    }

    /// The filled surface, with the attributes of what its new elements come from.
    fn finish(self, mesh: &SurfaceMesh) -> Result<(SurfaceMesh, Vec<Hole>)> {
        if !self.faces.fits() {
            let what = "the filled surface has more corners than a mesh can number";
            return Err(Error::input(what, "", "fill fewer holes"));
        }
        let all = |n: usize, more: Vec<u32>| (0..n as u32).chain(more).collect::<Vec<u32>>();
        let from = &mesh.attributes;
        let attributes = Attributes {
            vertex: gather_columns(&from.vertex, &all(mesh.vertex_count(), self.vertex_source)),
            face: gather_columns(&from.face, &all(mesh.face_count(), self.face_source)),
            corner: gather_columns(&from.corner, &all(mesh.corner_count(), self.corner_source)),
            ..Attributes::words_of(from)
        };
        let mut out = SurfaceMesh::new(self.points, self.faces)?;
        (out.attributes, out.tagged_edges) = (attributes, mesh.tagged_edges.clone());
        Ok((out, self.holes))
    }
}
