//! From quad patches to a boundary representation: one face per patch, one plane face per leftover triangle.
//!
//! | file | stage |
//! |---|---|
//! | `scene` | the input is checked; triangles without area get some |
//! | `piece` | patches are cut until none touches itself; leftovers are pieces, too |
//! | `chain` | the borders of all pieces are cut at nodes into chains: the edges of the model |
//! | `fit` | instead, on request: cubic curves and surfaces within a tolerance of the vertices |
//! | `exact` | lines, polylines, planes and surfaces of degree (1, 1) through the mesh vertices |
//! | `trimmed` | instead of patches: one trimmed surface per rectilinear polygon |
//! | `shell` | pieces connected by edges are shells; closed ones bound solids, or are voids in them |
//!
//! Source: the trials behind the specification of quad patches (section 4, export). A surface of degree (1, 1) has
//! straight isoparametric lines between its knots, so that the border of a patch is exactly the polyline of its vertices:
//! faces that share an edge agree on it without any tolerance, and a closed mesh gives a closed solid.

mod chain;
mod exact;
mod fit;
#[cfg(test)]
pub(crate) mod models;
mod piece;
mod scene;
mod shell;
#[cfg(test)]
mod tests;
mod trimmed;

use crate::bounds::within;
use crate::context::Context;
use crate::error::Result;
use crate::geometry::brep::{Brep, Curve, Edge, EdgeUse, Face, Surface};
use crate::length::Length;
use crate::mesh::{FaceId, SurfaceMesh};
use crate::patch::Patch;
use chain::{ChainUse, Chains};
use piece::{Outline, Piece};
use scene::Scene;
use serde::{Deserialize, Serialize};
pub use trimmed::{QuadCell, QuadPolygon, to_trimmed_brep};

/// What the faces of patches are to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Fit {
    /// Surfaces of degree (1, 1) through every vertex.
    #[default]
    Bilinear,
    /// Bicubic surfaces within a tolerance, where they are smaller; planes where the mesh is flat.
    Bicubic,
}

/// Choices of the export.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct BrepOptions {
    /// What the faces of patches are to be.
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
        BrepOptions { fit: Fit::Bilinear, tolerance: Length::OfDiagonal(0.001) }
    }
}

/// What the face of a patch is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Rung {
    /// Of degree (1, 1), through every vertex.
    Bilinear,
    /// Of degree 3, in one direction at least, within the tolerance.
    Bicubic,
    /// A plane; only its border is fitted.
    #[default]
    Plane,
}

/// What the fit of one patch came to; of the worst of its faces where it has several.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct PatchFit {
    /// The rung reached.
    pub rung: Rung,
    /// Largest distance of a vertex.
    pub deviation: f64,
    /// Number of control points.
    pub control_points: usize,
}

/// A boundary representation of a mesh, and what is to be said about it.
#[derive(Debug, Clone)]
pub struct CadModel {
    /// The model; `brep.faces.len()` is the number of faces of the file.
    pub brep: Brep,
    /// Per patch, with [`Fit::Bicubic`]; else empty.
    pub fits: Vec<PatchFit>,
    /// What a user should know: stray voids, degenerate triangles.
    pub warnings: Vec<String>,
}

/// The shape of every edge and face to be.
struct Geometry {
    /// One per chain, in its sense.
    curves: Vec<Curve>,
    /// The vertices of a chain at the ends of the segments of its line or polyline; `None` for a spline, and where every
    /// vertex is one.
    stops: Vec<Option<Vec<u32>>>,
    /// One per piece.
    surfaces: Vec<PieceSurface>,
}

/// The surface under a piece.
struct PieceSurface {
    surface: Surface,
    /// Parameter u of every column, and v of every row; `None` where they are the indices themselves.
    scale: Option<[Vec<f64>; 2]>,
    trimmed: bool,
}

/// Builds the model of all patches and leftover triangles.
///
/// Patches that touch themselves (closed strips, tori, slits) become several faces, so there may be more faces than
/// patches. Edges with more than two faces, or with two that are oriented differently, are not shared: their shells are
/// open. Fails with [`crate::Error::Input`] where patches and leftovers do not fit the mesh.
pub fn to_brep(
    mesh: &SurfaceMesh,
    patches: &[Patch],
    leftover: &[FaceId],
    options: &BrepOptions,
    ctx: &Context,
) -> Result<CadModel> {
    let scene = Scene::new(mesh, patches, leftover)?;
    let pieces = piece::pieces(&scene);
    let chains = chain::chains(&pieces, mesh.vertex_count());
    ctx.check()?;
    let (geometry, fits) = match options.fit {
        Fit::Bilinear => (exact::geometry(&scene, &pieces, &chains)?, Vec::new()),
        Fit::Bicubic => {
            let _stage = ctx.stage("fit");
            fit::geometry(&scene, &pieces, &chains, options.tolerance.resolve(mesh.diagonal()), ctx)?
        }
    };
    finish(scene, &pieces, &chains, geometry, fits, ctx)
}

/// Puts everything together and proves it.
fn finish(
    scene: Scene,
    pieces: &[Piece],
    chains: &Chains,
    geometry: Geometry,
    fits: Vec<PatchFit>,
    ctx: &Context,
) -> Result<CadModel> {
    let shells = shell::shells(&scene, pieces, chains, ctx)?;
    let mut brep = assemble(&scene, pieces, chains, geometry);
    (brep.shells, brep.solids) = (shells.shells, shells.solids);
    brep.check()?;
    let mut warnings = scene.warnings;
    if shells.stray_voids > 0 {
        warnings.push(format!(
            "{} closed component(s) are inside out and in no solid: written as surfaces; orient the faces outwards \
             (`carreau repair`) to make them solids",
            shells.stray_voids
        ));
    }
    Ok(CadModel { brep, fits, warnings })
}

/// Puts vertices, edges and faces together.
fn assemble(scene: &Scene, pieces: &[Piece], chains: &Chains, geometry: Geometry) -> Brep {
    let mut brep = Brep::default();
    let mut vertex_of = vec![u32::MAX; scene.points.len()];
    let (stops, curves) = (geometry.stops, geometry.curves);
    for (path, curve) in chains.paths.iter().zip(curves) {
        let ends = [path[0], path[path.len() - 1]].map(|v| {
            let id = &mut vertex_of[v as usize];
            if *id == u32::MAX {
                *id = brep.vertices.len() as u32;
                brep.vertices.push(scene.point(v));
            }
            *id
        });
        brep.edges.push(Edge { ends, curve });
    }
    for ((piece, uses), under) in pieces.iter().zip(&chains.loops).zip(geometry.surfaces) {
        let of_loop = |(outline, uses): (&Outline, &Vec<ChainUse>)| {
            let edge = |of: &ChainUse| {
                let nodes = chains.paths[of.chain as usize].len() as u32;
                let curve = &brep.edges[of.chain as usize].curve;
                edge_use(outline, of, nodes, curve, stops[of.chain as usize].as_deref(), &under)
            };
            uses.iter().map(edge).collect()
        };
        let loops = piece.loops.iter().zip(uses).map(of_loop).collect();
        brep.faces.push(Face { loops, trimmed: under.trimmed, surface: under.surface });
    }
    brep
}

/// A chain as an edge of a loop, with its way in the parameter plane: between two corners the border is straight there.
/// A polyline on a surface whose parameters are not indices needs all its stops, for it does not advance evenly.
fn edge_use(
    outline: &Outline,
    of: &ChainUse,
    nodes: u32,
    curve: &Curve,
    stops: Option<&[u32]>,
    under: &PieceSurface,
) -> EdgeUse {
    let mut parameters = Vec::new();
    if let (false, Surface::Spline(_)) = (outline.at.is_empty(), &under.surface) {
        let last = nodes - 1;
        let at = |k: u32| {
            let along = if of.reversed { last - k } else { k };
            let [c, r] = outline.at[(of.start + along) as usize % outline.at.len()];
            match &under.scale {
                Some([u, v]) => [u[c as usize], v[r as usize]],
                None => [f64::from(c), f64::from(r)],
            }
        };
        match (stops, curve) {
            (Some(stops), _) if under.scale.is_some() => parameters.extend(stops.iter().map(|&k| at(k))),
            // A break at every row lets readers integrate the face between the kinks that it may have there.
            (None, Curve::Spline(c)) if c.knots().degree() == 1 => parameters.extend((0..=last).map(at)),
            _ => parameters.extend([at(0), at(last)]),
        }
    }
    EdgeUse { edge: of.chain, reversed: of.reversed, parameters }
}
