//! From quad patches to a boundary representation: planes, bicubic surfaces and cells that weigh what they should.
//!
//! | file | stage |
//! |---|---|
//! | `scene` | the input is checked; triangles without area get some |
//! | `flat` | connected triangles in one plane |
//! | `labels` | names of bodies and faces, colours: what no face is mixed of |
//! | `ladder` | which face every triangle belongs to: plane → bicubic → divided → cell → triangle |
//! | `region`, `simple`, `crossed` | flat regions with their holes, cut until their borders are simple |
//! | `faithful` | quads whose bilinear surface encloses less or more than their triangles are refused, where that adds up |
//! | `fit` | cubic curves and surfaces within a tolerance of the vertices |
//! | `divide` | curved patches cut where they bend |
//! | `piece` | or, on request: one face a patch, cut until none touches itself |
//! | `trimmed` | or: one trimmed surface per rectilinear polygon |
//! | `chain`, `runs` | the borders of all pieces are cut at nodes into chains: the edges of the model |
//! | `exact` | lines, polylines, planes and surfaces of degree (1, 1) through the mesh vertices |
//! | `shell` | pieces connected by edges are shells; closed ones bound solids, or are voids in them |
//! | `weigh` | area and volume as other programs will show them, against the exact ones |
//!
//! Source: the trials behind the specification of quad patches (section 4, export) and of CAD models (section 2, numbers
//! that other programs show). Programs integrate over a face as if it were smooth, so a face must be: planes, splines
//! without bends, single cells. A surface of degree (1, 1) has straight isoparametric lines between its knots, so that the
//! border of a patch is exactly the polyline of its vertices: faces that share an edge agree on it without any tolerance, and
//! a closed mesh gives a closed solid.

#[cfg(test)]
mod auto_tests;
mod chain;
mod crossed;
mod cuts;
mod divide;
mod exact;
mod faithful;
mod fit;
mod flat;
mod labels;
mod ladder;
mod model;
#[cfg(test)]
pub(crate) mod models;
mod off_limit;
mod piece;
mod quad_polygon;
mod region;
mod runs;
mod scene;
mod shell;
mod simple;
#[cfg(test)]
mod tests;
mod trimmed;
mod weigh;

use crate::bounds::within;
use crate::context::Context;
use crate::error::Result;
use crate::length::Length;
use crate::mesh::{FaceId, NONE, SurfaceMesh, VertexId};
use crate::patch::Patch;
use flat::Flats;
use labels::Labels;
use model::finish;
use scene::Scene;
use serde::{Deserialize, Serialize};

pub use super::cad::quad_polygon::{QuadCell, QuadPolygon};
pub(super) use divide::cell_weighs_right;
pub use faithful::decompose_for_faces;
pub use model::{CadModel, Faces};
pub use off_limit::OffLimit;
pub use trimmed::to_trimmed_brep;

/// What the faces of patches are to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Fit {
    /// Planes where the mesh is flat; the rest through every vertex, divided at its bends so that every face weighs right.
    #[default]
    Auto,
    /// One surface of degree (1, 1) a patch, through every vertex. Bends inside make programs show wrong areas and volumes.
    Bilinear,
    /// As `Auto`, but curved patches become bicubic within a tolerance of the vertices where their borders allow it.
    Bicubic,
}

/// Choices of the export.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct BrepOptions {
    /// What kind of surface each patch becomes.
    pub fit: Fit,
    /// Largest distance of a vertex from a bicubic surface.
    pub tolerance: Length,
}

impl BrepOptions {
    /// Refuses a tolerance that is no length.
    ///
    /// # Errors
    /// [`crate::Error::Options`].
    pub fn validate(&self) -> Result<()> {
        within("tolerance", self.tolerance.resolve(1.0), 0.0..f64::INFINITY, "")
    }
}

impl Default for BrepOptions {
    fn default() -> Self {
        BrepOptions { fit: Fit::default(), tolerance: Length::OfDiagonal(0.001) }
    }
}

/// Builds the model of all patches and leftover triangles.
///
/// Patches that touch themselves (closed strips, tori, slits) become several faces, so there may be more faces than
/// patches. Edges with more than two faces, or with two that are oriented differently, are not shared: their shells are
/// open.
///
/// # Errors
/// [`Error::Input`](crate::Error::Input) if patches and leftovers do not fit the mesh,
/// [`Error::Options`](crate::Error::Options) for a tolerance that is no length,
/// [`Error::Cancelled`](crate::Error::Cancelled), [`Error::Deadline`](crate::Error::Deadline).
pub fn to_brep(
    mesh: &SurfaceMesh,
    patches: &[Patch],
    leftover: &[FaceId],
    options: &BrepOptions,
    ctx: &Context,
) -> Result<CadModel> {
    let mut scene = Scene::new(mesh, patches, leftover)?;
    if options.fit == Fit::Bilinear {
        scene.nudge(&scene.leftover.clone());
        let pieces = piece::pieces(&scene);
        let chains = chain::chains(&pieces, mesh.vertex_count());
        ctx.check()?;
        let geometry = exact::geometry(&scene, &pieces, &chains)?;
        return finish(scene, &pieces, &chains, geometry, ctx);
    }
    let _stage = ctx.stage("faces");
    let labels = Labels::new(mesh);
    let mut flats = Flats::new(mesh, &labels.of, ctx)?;
    let alone: Vec<FaceId> = scene.leftover.iter().copied().filter(|t| flats.of[t.index()] == NONE).collect();
    scene.nudge(&alone);
    let tolerance = (options.fit == Fit::Bicubic).then(|| options.tolerance.resolve(mesh.diagonal()));
    let built = ladder::build(&scene, &mut flats, &labels, tolerance, ctx)?;
    let mut model = finish(scene, &built.pieces, &built.chains, built.geometry, ctx)?;
    model.faces.deviation_max = built.deviation;
    Ok(model)
}

/// Edges of a mesh at which patches for a CAD file ought to end, besides sharp ones: the borders of flat regions that are
/// wide against what lies beside them, and between faces of different bodies, groups, materials or colours.
///
/// # Errors
/// [`Error::Cancelled`](crate::Error::Cancelled), [`Error::Deadline`](crate::Error::Deadline).
pub fn borders(mesh: &SurfaceMesh, ctx: &Context) -> Result<Vec<[VertexId; 2]>> {
    let labels = Labels::new(mesh);
    Ok(Flats::new(mesh, &labels.of, ctx)?.borders(mesh, &labels.of))
}
