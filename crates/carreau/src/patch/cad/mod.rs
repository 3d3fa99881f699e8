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
mod divide;
mod exact;
mod faithful;
mod fit;
mod flat;
mod labels;
mod ladder;
#[cfg(test)]
pub(crate) mod models;
mod piece;
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
use crate::brep::{Brep, Curve, Edge, EdgeUse, Face, Surface, Vertex};
use crate::context::Context;
use crate::error::Result;
use crate::length::Length;
use crate::mesh::{FaceId, NONE, SurfaceMesh, VertexId};
use crate::patch::Patch;
use chain::{ChainUse, Chains};
pub(super) use divide::cell_weighs_right;
pub use faithful::{OffLimit, decompose_for_faces};
use flat::Flats;
use labels::Labels;
use piece::{Outline, Piece};
use scene::Scene;
use serde::{Deserialize, Serialize};
pub use trimmed::{QuadCell, QuadPolygon, to_trimmed_brep};

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

/// How many faces are what.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Faces {
    /// Planes.
    pub planes: usize,
    /// Surfaces of degree 3, in one direction at least.
    pub bicubic: usize,
    /// Surfaces of degree (1, 1).
    pub bilinear: usize,
    /// Largest distance of a vertex from its bicubic surface.
    pub deviation_max: f64,
}

/// A boundary representation of a mesh, and what is to be said about it.
#[derive(Debug, Clone)]
pub struct CadModel {
    /// The model; `brep.faces.len()` is the number of faces of the file.
    pub brep: Brep,
    /// Number of faces by kind.
    pub faces: Faces,
    /// Relative errors of area and volume when they are integrated by the default rule of OpenCASCADE.
    pub mass_error: [f64; 2],
    /// Warnings for the user, one sentence each: stray voids, degenerate triangles.
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
    /// Parameters of the vertices on the sides v = 0, u = 1, v = 1, u = 0; `None` where they are the indices themselves.
    border: Option<[Vec<f64>; 4]>,
    trimmed: bool,
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

/// Relative error of area and volume by the default rule from which on a user is told.
const MASS_ERROR: f64 = 1e-4;

/// Puts everything together and proves it.
fn finish(scene: Scene, pieces: &[Piece], chains: &Chains, geometry: Geometry, ctx: &Context) -> Result<CadModel> {
    let shells = shell::shells(&scene, pieces, chains, ctx)?;
    let mut brep = assemble(&scene, pieces, chains, geometry);
    (brep.shells, brep.solids) = (shells.shells, shells.solids);
    let labels = Labels::new(scene.mesh);
    let first: Option<Vec<usize>> = pieces.iter().map(|p| p.first(scene.patches).map(|t| t.index())).collect();
    if let Some(first) = first {
        brep.faces.iter_mut().zip(&first).for_each(|(face, &t)| labels.dress(face, t));
        labels.name_bodies(&mut brep, &first);
    }
    brep.check()?;
    ctx.check()?;
    let mut warnings = scene.warnings;
    if shells.stray_voids > 0 {
        warnings.push(format!(
            "{} closed component(s) are inside out and in no solid: written as surfaces; orient the faces outwards \
             (`carreau repair`) to make them solids",
            shells.stray_voids
        ));
    }
    let [area, volume] = ctx.install(|| weigh::weigh(&brep)).errors();
    // An open surface has no volume.
    let mass_error = [area, if brep.solids.is_empty() { 0.0 } else { volume }];
    if mass_error.iter().any(|&e| e > MASS_ERROR) {
        warnings.push(format!(
            "programs that integrate by the default rule of OpenCASCADE will show an area that is off by {:.1e} and a volume \
             that is off by {:.1e} of it, because faces bend inside; `--fit auto` divides them there",
            mass_error[0], mass_error[1]
        ));
    }
    Ok(CadModel { faces: Faces::of(&brep), brep, mass_error, warnings })
}

impl Faces {
    fn of(brep: &Brep) -> Self {
        let mut out = Faces::default();
        for face in &brep.faces {
            match brep.surface(face) {
                Surface::Plane { .. } => out.planes += 1,
                Surface::Spline(s) if s.knots().iter().any(|k| k.degree() > 1) => out.bicubic += 1,
                _ => out.bilinear += 1,
            }
        }
        out
    }
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
                brep.vertices.push(Vertex::exact(scene.point(v)));
            }
            *id
        });
        let range = match &curve {
            Curve::Spline(spline) => spline.knots().domain(),
            _ => [0.0, brep.point(ends[0]).distance(brep.point(ends[1]))],
        };
        brep.edges.push(Edge { curve, range, ends, tolerance: 0.0 });
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
        brep.faces.push(Face { trimmed: under.trimmed, ..Face::new(brep.surfaces.len() as u32, loops) });
        brep.surfaces.push(under.surface);
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
            let Some([bottom, right, top, left]) = &under.border else { return [f64::from(c), f64::from(r)] };
            let (c, r) = (c as usize, r as usize);
            let u = if r + 1 == right.len() { top[c] } else { bottom[c] };
            [u, if c + 1 == bottom.len() { right[r] } else { left[r] }]
        };
        match (stops, curve) {
            (Some(stops), _) if under.border.is_some() => parameters.extend(stops.iter().map(|&k| at(k))),
            // A break at every row lets readers integrate the face between the kinks that it may have there.
            (None, Curve::Spline(c)) if c.knots().degree() == 1 => parameters.extend((0..=last).map(at)),
            // A point at every knot, in proportion.
            (None, Curve::Spline(c)) => {
                let ([a, b], [low, high]) = ([at(0), at(last)], c.knots().domain());
                let share = |t: f64| (t - low) / (high - low);
                let on = |t: f64| [0, 1].map(|k| if t == high { b[k] } else { a[k] + share(t) * (b[k] - a[k]) });
                parameters.extend(c.knots().breaks().into_iter().map(on));
            }
            _ => parameters.extend([at(0), at(last)]),
        }
    }
    EdgeUse { edge: of.chain, reversed: of.reversed, parameters }
}
