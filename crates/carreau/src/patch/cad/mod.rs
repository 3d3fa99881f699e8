//! From quad patches to a boundary representation: one face per patch, one plane face per leftover triangle.
//!
//! | file | stage |
//! |---|---|
//! | `scene` | the input is checked; triangles without area get some |
//! | `piece` | patches are cut until none touches itself; leftovers are pieces, too |
//! | `chain` | the borders of all pieces are cut at nodes into chains: the edges of the model |
//! | `exact` | lines, polylines, planes and surfaces of degree (1, 1) through the mesh vertices |
//! | `shell` | pieces connected by edges are shells; closed ones bound solids, or are voids in them |
//!
//! Source: the trials behind the specification of quad patches (section 4, export). A surface of degree (1, 1) has
//! straight isoparametric lines between its knots, so that the border of a patch is exactly the polyline of its vertices:
//! faces that share an edge agree on it without any tolerance, and a closed mesh gives a closed solid.

mod chain;
mod exact;
mod piece;
mod scene;
mod shell;

use crate::context::Context;
use crate::error::Result;
use crate::geometry::brep::{Brep, Curve, Edge, EdgeUse, Face, Surface};
use crate::mesh::{FaceId, SurfaceMesh};
use crate::patch::Patch;
use chain::{ChainUse, Chains};
use piece::{Outline, Piece};
use scene::Scene;

/// A boundary representation of a mesh, and what is to be said about it.
#[derive(Debug, Clone)]
pub struct CadModel {
    /// The model; `brep.faces.len()` is the number of faces of the file.
    pub brep: Brep,
    /// What a user should know: stray voids, degenerate triangles.
    pub warnings: Vec<String>,
}

/// The shape of every edge and face to be.
struct Geometry {
    /// One per chain, in its sense.
    curves: Vec<Curve>,
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
pub fn to_brep(mesh: &SurfaceMesh, patches: &[Patch], leftover: &[FaceId], ctx: &Context) -> Result<CadModel> {
    let mut scene = Scene::new(mesh, patches, leftover)?;
    let pieces = piece::pieces(&scene);
    let chains = chain::chains(&pieces, mesh.vertex_count());
    ctx.check()?;
    let geometry = exact::geometry(&scene, &pieces, &chains)?;
    let shells = shell::shells(&scene, &pieces, &chains, ctx)?;
    let mut brep = assemble(&scene, &pieces, &chains, geometry);
    (brep.shells, brep.solids) = (shells.shells, shells.solids);
    brep.check()?;
    let mut warnings = std::mem::take(&mut scene.warnings);
    if shells.stray_voids > 0 {
        warnings.push(format!(
            "{} closed component(s) are inside out and in no solid: written as surfaces; orient the faces outwards \
             (`carreau repair`) to make them solids",
            shells.stray_voids
        ));
    }
    Ok(CadModel { brep, warnings })
}

/// Puts vertices, edges and faces together.
fn assemble(scene: &Scene, pieces: &[Piece], chains: &Chains, geometry: Geometry) -> Brep {
    let mut brep = Brep::default();
    let mut vertex_of = vec![u32::MAX; scene.points.len()];
    for (path, curve) in chains.paths.iter().zip(geometry.curves) {
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
            uses.iter().enumerate().map(|(k, of)| edge_use(outline, uses, k, of, &under)).collect()
        };
        let loops = piece.loops.iter().zip(uses).map(of_loop).collect();
        brep.faces.push(Face { loops, trimmed: under.trimmed, surface: under.surface });
    }
    brep
}

/// A chain as an edge of a loop, with its end points in the parameter plane: between two corners the border is straight
/// there, and both it and the chain advance by one node per mesh edge.
fn edge_use(outline: &Outline, uses: &[ChainUse], k: usize, of: &ChainUse, under: &PieceSurface) -> EdgeUse {
    let mut parameters = Vec::new();
    if let (false, Surface::Spline(_)) = (outline.at.is_empty(), &under.surface) {
        let next = uses[(k + 1) % uses.len()].start;
        for node in [of.start, next] {
            let [c, r] = outline.at[node as usize];
            parameters.push(match &under.scale {
                Some([u, v]) => [u[c as usize], v[r as usize]],
                None => [f64::from(c), f64::from(r)],
            });
        }
        if of.reversed {
            parameters.reverse();
        }
    }
    EdgeUse { edge: of.chain, reversed: of.reversed, parameters }
}
