//! Triangles of a model, watertight: faces that share an edge use the same samples of it.
//!
//! | file | stage |
//! |---|---|
//! | `edges` | every edge is sampled until chords and angles are within the tolerances |
//! | `../boundary` | the samples are laid out in the parameter plane of each face |
//! | `chart` | the parameter plane is stretched to be nearly isometric |
//! | `face` | a constrained Delaunay triangulation in that plane |
//! | `refine` | points are added inside until the triangles follow the surface |

mod chart;
mod edges;
mod face;
mod refine;
#[cfg(test)]
mod tests;

use super::Brep;
use super::boundary::EdgeSamples;
use crate::context::Context;
use crate::error::Result;
use crate::mesh::{Column, SurfaceMesh};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

pub(crate) use edges::{sample_edges, sample_edges_each};

/// How closely triangles follow a model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fineness {
    /// Largest distance between a chord and the curve or surface over it.
    pub chord: f64,
    /// Largest angle in radians between tangents or normals at the ends of a chord.
    pub angle: f64,
}

impl Fineness {
    /// A chord of a thousandth of the model's diagonal, and 15°.
    pub fn of(brep: &Brep) -> Self {
        let [low, high] = brep.bounds();
        Fineness { chord: 1e-3 * low.distance(high), angle: 15f64.to_radians() }
    }
}

/// The triangles of a model.
#[derive(Debug, Clone, Default)]
pub struct Tessellation {
    /// The model's vertices, then inner samples of its edges, then points inside its faces.
    pub points: Vec<DVec3>,
    /// Counter-clockwise seen from the tip of the face's normal.
    pub triangles: Vec<[u32; 3]>,
    /// Parameters of the corners of each triangle on its face's surface.
    pub places: Vec<[DVec2; 3]>,
    /// The face of each triangle.
    pub face_of: Vec<u32>,
    /// Faces whose loops cross or do not close in the parameter plane; they may have no triangles, or wrong ones.
    pub crossed: Vec<u32>,
}

impl Tessellation {
    /// The triangles as a mesh with the face property `face`.
    ///
    /// # Errors
    /// [`Error::Numeric`](crate::Error::Numeric) for a face that cannot be triangulated;
    /// [`Error::Cancelled`](crate::Error::Cancelled), [`Error::Deadline`](crate::Error::Deadline).
    pub fn mesh(self) -> Result<SurfaceMesh> {
        let mut mesh = SurfaceMesh::from_triangles(self.points, &self.triangles)?;
        let labels = self.face_of.iter().map(|&f| f as i32).collect();
        mesh.attributes.face.insert("face".into(), Column::Label(labels));
        Ok(mesh)
    }
}

/// Triangulates every face.
///
/// # Errors
/// [`Error::Numeric`](crate::Error::Numeric) for a face that cannot be triangulated;
/// [`Error::Cancelled`](crate::Error::Cancelled), [`Error::Deadline`](crate::Error::Deadline).
pub fn tessellate(brep: &Brep, fineness: &Fineness, context: &Context) -> Result<Tessellation> {
    tessellate_samples(brep, &sample_edges(brep, fineness), fineness, context)
}

/// Triangulates every face between given samples of the edges.
pub(crate) fn tessellate_samples(
    brep: &Brep,
    samples: &[EdgeSamples],
    fineness: &Fineness,
    context: &Context,
) -> Result<Tessellation> {
    context.check()?;
    let faces: Vec<face::FaceTriangles> = context.install(|| {
        let one = |f: usize| {
            context.check()?;
            face::triangulate(brep, f, samples, fineness)
        };
        (0..brep.faces.len()).into_par_iter().map(one).collect::<Result<_>>()
    })?;
    Ok(joined(brep, samples, faces))
}

/// Puts the triangles of all faces together.
fn joined(brep: &Brep, samples: &[EdgeSamples], faces: Vec<face::FaceTriangles>) -> Tessellation {
    let mut out = Tessellation { points: brep.vertices.iter().map(|v| v.point).collect(), ..Default::default() };
    for along in samples {
        out.points.extend_from_slice(&along.points[1..along.points.len() - 1]);
    }
    let shared = out.points.len() as u32;
    for (f, face) in faces.into_iter().enumerate() {
        let first = out.points.len() as u32;
        let id = |k: u32| if k >= shared { first + (k - shared) } else { k };
        out.points.extend(face.inner);
        out.triangles.extend(face.triangles.iter().map(|t| t.map(id)));
        out.places.extend(face.places);
        out.face_of.extend(std::iter::repeat_n(f as u32, face.triangles.len()));
        if face.crossed {
            out.crossed.push(f as u32);
        }
    }
    out
}
