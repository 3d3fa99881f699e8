//! Judges a model: what OpenCASCADE's checker looks at, and what it does not.
//!
//! A closed model of consistent topology may still be nonsense: a spline that swings between the points it was fitted to, a
//! wrong branch of an intersection, two faces that cross. So a model that stands for a mesh is compared with it, region by region.
//! Every finding names the face (or edge, or vertex), what was measured and what was allowed, so that the cause can be mended.
//!
//! | file | what is judged |
//! |---|---|
//! | `topology` | uses of edges, Euler characteristic |
//! | `gaps` | edges on both surfaces, vertices at the ends of edges, sizes of tolerances |
//! | `loops` | loops in the parameter plane: closed, simple, the outer one around the holes |
//! | `distance` | from the mesh to the faces of its regions and back, normals, volume |
//! | `region` | the regions of the mesh that this is about |
//! | `crossing` | faces that cross |

mod crossing;
mod distance;
mod gaps;
mod loops;
mod region;
#[cfg(test)]
mod tests;
mod topology;

use super::Brep;
use super::boundary::EdgeSamples;
use super::tessellate::{Fineness, Tessellation, sample_edges_each, tessellate_samples};
use crate::context::Context;
use crate::error::Result;
use crate::mesh::SurfaceMesh;
use glam::DVec3;
use std::ops::ControlFlow;

/// What is wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Fault {
    /// In a closed shell, an edge that is not used twice, in opposite senses; measured is the number of uses.
    EdgeUses,
    /// V − E + F − holes is not that of the mesh.
    EulerCharacteristic,
    /// A loop that does not close in the parameter plane: it winds round the surface without a seam.
    OpenLoop,
    /// A loop that crosses itself or another.
    CrossedLoop,
    /// The outer loop runs the wrong way round, or a hole is outside of it.
    InvertedLoop,
    /// An edge is farther from the surface of a face than its tolerance says.
    EdgeOffSurface,
    /// A vertex is farther from the end of an edge than its tolerance says.
    VertexOffEdge,
    /// A tolerance is larger than allowed.
    LargeTolerance,
    /// An edge is not longer than the tolerances at its ends.
    ShortEdge,
    /// A vertex of the mesh is too far from the face of its region.
    MeshOffFace,
    /// A point of a face is too far from its region.
    FaceOffMesh,
    /// The share of a face's area whose normal is turned against that of its region by more than the limit.
    TurnedNormal,
    /// A region of the mesh has no face.
    MissingFace,
    /// The volume differs from that of the mesh by more than the facets can cut off.
    Volume,
    /// Two faces cross.
    CrossingFaces,
}

impl Fault {
    /// What is measured, in words.
    pub fn name(self) -> &'static str {
        match self {
            Fault::EdgeUses => "number of uses of an edge",
            Fault::EulerCharacteristic => "Euler characteristic",
            Fault::OpenLoop => "gap of a loop in the parameter plane",
            Fault::CrossedLoop => "a loop that crosses itself or another",
            Fault::InvertedLoop => "a loop that runs the wrong way round",
            Fault::EdgeOffSurface => "distance of an edge from a surface",
            Fault::VertexOffEdge => "distance of a vertex from the end of an edge",
            Fault::LargeTolerance => "tolerance",
            Fault::ShortEdge => "length of an edge",
            Fault::MeshOffFace => "distance of the mesh from a face",
            Fault::FaceOffMesh => "distance of a face from the mesh",
            Fault::TurnedNormal => "share of a face with turned normals",
            Fault::MissingFace => "a region without a face",
            Fault::Volume => "difference of volumes",
            Fault::CrossingFaces => "faces that cross",
        }
    }
}

/// Something wrong, and where.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Finding {
    /// What is wrong.
    pub fault: Fault,
    /// The face it is about.
    pub face: Option<u32>,
    /// The other face, of two that cross.
    pub other: Option<u32>,
    /// The edge it is about.
    pub edge: Option<u32>,
    /// The vertex it is about.
    pub vertex: Option<u32>,
    /// What was measured, in the unit of the fault.
    pub measured: f64,
    /// What was allowed.
    pub bound: f64,
    /// Where the worst of it is.
    pub at: DVec3,
}

impl Finding {
    fn new(fault: Fault, measured: f64, bound: f64, at: DVec3) -> Self {
        Finding { fault, face: None, other: None, edge: None, vertex: None, measured, bound, at }
    }

    fn of_face(self, face: u32) -> Self {
        Finding { face: Some(face), ..self }
    }

    fn of_edge(self, edge: u32) -> Self {
        Finding { edge: Some(edge), ..self }
    }

    fn of_vertex(self, vertex: u32) -> Self {
        Finding { vertex: Some(vertex), ..self }
    }
}

/// The mesh that a model stands for.
#[derive(Debug, Clone, Copy)]
pub struct Reference<'a> {
    /// Triangles.
    pub mesh: &'a SurfaceMesh,
    /// The region of each triangle; faces name theirs in [`super::Face::region`].
    pub region_of: &'a [u32],
}

/// What is allowed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Distance between mesh and model, besides what facets cut off.
    pub distance: f64,
    /// Tolerance of a vertex or an edge.
    pub tolerance: f64,
    /// Angle between the normals of a face and its region, in radians.
    pub angle: f64,
    /// Share of a face where it may be larger.
    pub turned_share: f64,
}

impl Limits {
    /// The limits for a model of this size: tolerances of 1e-5 of the diagonal, normals within 60° on 95 % of a face.
    pub fn new(diagonal: f64, distance: f64) -> Self {
        Limits { distance, tolerance: 1e-5 * diagonal, angle: 60f64.to_radians(), turned_share: 0.05 }
    }
}

/// Judges a model that [`Brep::check`] has passed. No finding means that it is valid, and near its mesh if one is given. Findings
/// come by kind, then by the number of the face or edge.
///
/// # Errors
/// [`Error::Cancelled`](crate::Error::Cancelled), [`Error::Deadline`](crate::Error::Deadline).
pub fn validate(
    brep: &Brep,
    reference: Option<&Reference>,
    limits: &Limits,
    context: &Context,
) -> Result<Vec<Finding>> {
    let mut findings = Vec::new();
    let all = |found: Vec<Finding>| {
        findings.extend(found);
        ControlFlow::Continue(())
    };
    judge(brep, reference, limits, all, context)?;
    Ok(findings)
}

/// The first of the findings of [`validate`], without the work for the kinds after it; none for a valid model.
///
/// # Errors
/// As [`validate`].
pub fn first_finding(
    brep: &Brep,
    reference: Option<&Reference>,
    limits: &Limits,
    context: &Context,
) -> Result<Option<Finding>> {
    let mut first = None;
    let until_one = |found: Vec<Finding>| {
        first = found.first().copied();
        if first.is_some() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    judge(brep, reference, limits, until_one, context)?;
    Ok(first)
}

/// Hands the findings of one kind after the other over, as long as they are wanted.
fn judge(
    brep: &Brep,
    reference: Option<&Reference>,
    limits: &Limits,
    mut take: impl FnMut(Vec<Finding>) -> ControlFlow<()>,
    context: &Context,
) -> Result<()> {
    let mut of_topology = topology::edge_uses(brep);
    of_topology.extend(reference.and_then(|r| topology::euler_characteristic(brep, r.mesh)));
    if take(of_topology).is_break() || take(gaps::gaps(brep, limits, context)?).is_break() {
        return Ok(());
    }
    let chord = 0.25 * limits.distance;
    let (samples, tessellation) = triangles(brep, chord, context)?;
    if take(loops::loops(brep, &samples, &tessellation, context)?).is_break() {
        return Ok(());
    }
    if let Some(reference) = reference
        && take(distance::compare(brep, &tessellation, reference, limits, chord, context)?).is_break()
    {
        return Ok(());
    }
    // Nothing comes after it.
    let _ = take(crossing::crossings(brep, &tessellation, chord, context)?);
    Ok(())
}

/// Halvings of the angle (and quarterings of the chord) along the edges of a face whose polygons cross, each of which costs a whole
/// tessellation with twice the points there.
const FINER: u32 = 3;

/// Triangles of the model, with chords near enough to its edges that loops which do not cross have polygons that do not, either:
/// where those of a thin face cross, its edges are sampled again at half the angle.
fn triangles(brep: &Brep, chord: f64, context: &Context) -> Result<(Vec<EdgeSamples>, Tessellation)> {
    let fineness = Fineness { chord, angle: 20f64.to_radians() };
    let mut finer = vec![0i32; brep.edges.len()];
    let mut round = 0;
    loop {
        let of_edge = |e: usize| Fineness {
            chord: fineness.chord * 0.25f64.powi(finer[e]),
            angle: fineness.angle * 0.5f64.powi(finer[e]),
        };
        let samples = sample_edges_each(brep, of_edge);
        let tessellation = tessellate_samples(brep, &samples, &fineness, context)?;
        if tessellation.crossed.is_empty() || round == FINER {
            return Ok((samples, tessellation));
        }
        round += 1;
        for &f in &tessellation.crossed {
            brep.faces[f as usize].uses().for_each(|of| finer[of.edge as usize] = round as i32);
        }
    }
}

/// Where a face is looked at: the parameters of the middle of one of its triangles, whose area counts for it.
fn middle(tessellation: &Tessellation, triangle: usize) -> (glam::DVec2, f64) {
    let [a, b, c] = tessellation.triangles[triangle].map(|v| tessellation.points[v as usize]);
    let uv = tessellation.places[triangle];
    ((uv[0] + uv[1] + uv[2]) / 3.0, 0.5 * (b - a).cross(c - a).length())
}
