//! The boundary representation, from the surfaces of its pieces.

use super::chain::{ChainUse, Chains};
use super::labels::Labels;
use super::piece::{Outline, Piece};
use super::scene::Scene;
use super::{shell, weigh};
use crate::brep::{Brep, Curve, Edge, EdgeUse, Face, Surface, Vertex};
use crate::context::Context;
use crate::error::Result;
use serde::Serialize;

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
pub struct Geometry {
    /// One per chain, in its sense.
    pub(super) curves: Vec<Curve>,
    /// The vertices of a chain at the ends of the segments of its line or polyline; `None` for a spline, and where every
    /// vertex is one.
    pub(super) stops: Vec<Option<Vec<u32>>>,
    /// One per piece.
    pub(super) surfaces: Vec<PieceSurface>,
}

/// The surface under a piece.
pub struct PieceSurface {
    pub(super) surface: Surface,
    /// Parameters of the vertices on the sides v = 0, u = 1, v = 1, u = 0; `None` where they are the indices themselves.
    pub(super) border: Option<[Vec<f64>; 4]>,
    pub(super) trimmed: bool,
}

/// Relative error of area and volume by the default rule from which on a user is told.
pub const MASS_ERROR: f64 = 1e-4;

/// Puts everything together and proves it.
pub fn finish(scene: Scene, pieces: &[Piece], chains: &Chains, geometry: Geometry, ctx: &Context) -> Result<CadModel> {
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
    pub(super) fn of(brep: &Brep) -> Self {
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
pub fn assemble(scene: &Scene, pieces: &[Piece], chains: &Chains, geometry: Geometry) -> Brep {
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
pub fn edge_use(
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
