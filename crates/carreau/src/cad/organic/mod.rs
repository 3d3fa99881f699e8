//! Organic models: a scan becomes few bicubic faces that meet without a crease.
//!
//! | stage | file |
//! |---|---|
//! | how many quads | `counts` |
//! | quads | [`crate::quad`] |
//! | half-edges, fans, roles of the vertices | `net` |
//! | the motorcycle graph of the quads | `tracks` |
//! | the grids between its walls, and the edges between them | `blocks` |
//! | control points of Catmull–Clark's surface: one step, and around irregular vertices | `refine`, `disc` |
//! | its bicubic pieces | `limit` |
//! | points of the scan and their feet | `feet` |
//! | control points by least squares, in rounds; evened out | `fit`, `rounds`; `relax` |
//! | faces on graded knots | `control` |
//! | tangent planes at irregular vertices | `polish` |
//! | the model; distances and angles | `assemble`; `measure` |
//!
//! Catmull–Clark's surface (CAD 10, 1978) is C² but at irregular vertices. A block is a tensor product on the quads' parameters, so that
//! its face *is* this surface but for the cells next to irregular corners, whatever T-junctions are around it.

mod assemble;
mod blocks;
mod control;
mod counts;
mod disc;
mod feet;
mod fit;
mod limit;
mod measure;
mod net;
mod polish;
mod refine;
mod relax;
mod rounds;
#[cfg(test)]
mod tests;
mod tracks;

use super::shells::enclose;
use super::{CadModel, CadOptions, Style};
use crate::brep::Brep;
use crate::brep::validate::{Limits, Reference, first_finding};
use crate::context::Context;
use crate::error::{Error, Result};
use crate::geometry::features::FeatureOptions;
use crate::mesh::{SurfaceMesh, Triangles};
use crate::quad::{QuadOptions, quads};
use blocks::{Block, Layout, blocks, layout};
use control::{GRADES, Sheet, sheet};
use counts::counts;
use feet::{Sample, Scan, find_feet};
use glam::DVec3;
use limit::Limit;
pub use measure::Angles;
use net::Net;
use rounds::{Fitting, Goal, Turn, run};
use tracks::Walls;

/// A count: so many numbers of quads are tried for a model within the tolerance, more for one at all, because each takes as long.
const TRIES_FOR_TOLERANCE: usize = 2;
/// Degrees: from this angle between faces on a user is told, because it is what CAD systems take as smooth.
const KINK_DEGREES: f64 = 0.5;
/// A count: times that all quads are divided in four where the surface does not come near enough, because each takes
/// four times as long.
const DIVISIONS: usize = 2;
/// A count: quads with more are not divided, because time and files grow with them.
const MOST_DIVIDED: usize = 7000;
/// A share of the diagonal: how near the scan has to be by default, because scans are hardly more exact.
const ORGANIC_TOLERANCE: f64 = 1e-3;
/// Root mean square distance for a largest one of 1: more quads are taken above it, but not so many that they would
/// follow the facets.
const MEAN_DISTANCE: f64 = 0.1;
/// A factor: faces may be this much farther from the facets between vertices than vertices are from faces, because over
/// the facets of a coarse scan surfaces bulge.
const BULGE_FACTOR: f64 = 4.0;
/// A share of the diagonal: the same in any case, because facets bulge where all vertices are on the faces as well.
const LEAST_BULGE: f64 = 4e-3;
/// Radians: faces that differ by less from the facets near them are not turned over, because a smooth face that rounds a sharp rim
/// of the scan off differs from the facets on both sides by nearly as much.
const TURNED_OVER: f64 = std::f64::consts::FRAC_PI_2;
/// What is known of an organic model besides.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Smooth {
    /// Angles between the faces along smooth edges, in degrees.
    pub angles: Angles,
    /// Number of quads whose vertices are the control points.
    pub quads: usize,
    /// Number of irregular vertices.
    pub irregular: usize,
}

/// The surface while it is fitted.
struct Cage {
    net: Net,
    walls: Walls,
    points: Vec<DVec3>,
    /// Edges at which the surface stays sharp, by their ends, smaller first; ascending.
    creases: Vec<[u32; 2]>,
    /// How often the quads were divided.
    divisions: usize,
}

impl Cage {
    fn new(mesh: &SurfaceMesh, context: &Context) -> Result<Self> {
        let points = mesh.points().to_vec();
        let faces: Vec<[u32; 4]> = mesh.faces().iter().filter_map(|f| f.try_into().ok()).collect();
        let creases = sorted(mesh.tagged_edges.iter().map(|t| t.ends.map(|v| v.0)).collect());
        let net = Net::new(&points, faces, &creases)?;
        let mut walls = Walls::new(&net, &points, context)?;
        // Walls that blocks need.
        blocks(&net, &mut walls, context)?;
        Ok(Cage { net, walls, points, creases, divisions: 0 })
    }

    /// Every quad in four.
    fn divided(&self) -> Result<Self> {
        let refined = refine::refine(&self.net, &self.points);
        let first = self.points.len() as u32;
        let halves = |(edge, &[a, b]): (u32, &[u32; 2])| {
            let middle = first + edge;
            self.creases.binary_search(&[a, b]).map_or_else(|_| Vec::new(), |_| vec![[a, middle], [b, middle]])
        };
        let creases = sorted((0u32..).zip(&self.net.ends).flat_map(halves).collect());
        let points = [refined.vertex, refined.edge, refined.face].concat();
        let net = self.net.divided(refine::refined_quads(&self.net), &creases)?;
        let walls = self.walls.divided(&net);
        Ok(Cage { net, walls, points, creases, divisions: self.divisions + 1 })
    }

    /// Number of knots that are halved towards an irregular vertex.
    fn grades(&self) -> usize {
        GRADES[self.divisions.min(GRADES.len() - 1)]
    }

    /// The surface, divided towards irregular vertices twice as finely as the faces' knots, because feet near them are to be right.
    fn limit(&self) -> Limit<'_, DVec3> {
        Limit::new(&self.net, &self.points, self.grades() + 2)
    }
}

/// Edges with their smaller end first, ascending.
fn sorted(edges: Vec<[u32; 2]>) -> Vec<[u32; 2]> {
    let mut out: Vec<[u32; 2]> = edges.into_iter().map(|[a, b]| [a.min(b), a.max(b)]).collect();
    out.sort_unstable();
    out.dedup();
    out
}

/// How much is tried.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Effort {
    /// All that may lead to a model, because there is no other one.
    Full,
    /// The first numbers of quads, from few maps, not divided beyond what the vertices say.
    Little,
}

/// A count: maps of which quads are made for a stand-in, because a surface that needs more is full of irregular vertices, and each costs
/// a face.
const LITTLE_ATTEMPTS: usize = 1;

/// What a surface is to reach.
#[derive(Debug, Clone, Copy)]
struct Asked {
    /// Largest distance of the scan.
    tolerance: f64,
    /// A count: more quads than this are not divided.
    most_divided: usize,
    /// Whether a model that is farther from the scan is of no use.
    is_strict: bool,
}

/// Makes the model, from other quads where those at first make no valid one.
pub fn organic(mesh: &SurfaceMesh, options: &CadOptions, effort: Effort, context: &Context) -> Result<CadModel> {
    let tolerance = options.tolerance.unwrap_or(ORGANIC_TOLERANCE * mesh.diagonal());
    let most_divided = if effort == Effort::Full { MOST_DIVIDED } else { MOST_DIVIDED.min(mesh.vertex_count()) };
    let asked = Asked { tolerance, most_divided, is_strict: effort == Effort::Little };
    let tried = counts(mesh);
    let (mut best, mut last): (Option<CadModel>, _) = (None, None);
    // Quads that are not of the map have so many irregular vertices that anything else comes first.
    let all = tried.iter().map(|&count| (count, 1)).chain(tried.first().map(|&count| (count, 4)));
    for (k, (count, last_rung)) in
        all.take(if effort == Effort::Full { usize::MAX } else { TRIES_FOR_TOLERANCE }).enumerate()
    {
        if best.is_some() && (k >= TRIES_FOR_TOLERANCE || last_rung > 1) {
            break;
        }
        let wanted = quad_options(count, options.style);
        let attempts = if effort == Effort::Full { wanted.attempts } else { LITTLE_ATTEMPTS };
        let wanted = QuadOptions { last_rung, attempts, ..wanted };
        match attempt(mesh, asked, &wanted, context) {
            Ok(model) if model.distance_max <= tolerance => return Ok(model),
            Ok(model) if best.as_ref().is_none_or(|b| model.distance_max < b.distance_max) => best = Some(model),
            Ok(_) => {}
            Err(Error::Numeric(reason)) => last = Some(reason),
            Err(other) => return Err(other),
        }
    }
    if let Some(model) = best {
        return Ok(model);
    }
    Err(Error::Numeric(format!(
        "no valid model of smooth faces was found: {}; repair or smooth the mesh first (`carreau repair`, `carreau simplify`)",
        last.unwrap_or_default()
    )))
}

/// Creases are sought where the style is not given: a scan is smooth but for edges tagged in the file.
fn quad_options(quads: usize, style: Style) -> QuadOptions {
    let features = match style {
        Style::Organic => FeatureOptions { angle_deg: None, ..FeatureOptions::default() },
        Style::Auto | Style::Mechanical => FeatureOptions::auto(),
    };
    // Every irregular vertex costs faces.
    QuadOptions { features, quads, curvature: 0.0, ..QuadOptions::default() }
}

fn attempt(mesh: &SurfaceMesh, asked: Asked, wanted: &QuadOptions, context: &Context) -> Result<CadModel> {
    let made = {
        let _stage = context.stage("quads");
        quads(mesh, wanted, context)?
    };
    let mut model = over(mesh, &made.mesh, asked, context)?;
    if made.rung() > 2 {
        model.warnings.push("no regular quads were found, so that there are many faces".to_string());
    }
    Ok(model)
}

/// The model of a scan over given quads. Where it is not valid the surface may be turned over: then it is unfolded, which takes it away
/// from the scan.
fn over(mesh: &SurfaceMesh, quads: &SurfaceMesh, asked: Asked, context: &Context) -> Result<CadModel> {
    let tolerance = asked.tolerance;
    let scan = Scan::new(mesh);
    let mut vertices = scan.fitted(mesh);
    let mut cage = fitted(Cage::new(quads, context)?, (mesh, &scan), &mut vertices, asked, context)?;
    let mut model = match model(mesh, &scan, &mut cage, context) {
        Err(Error::Numeric(_)) => {
            Fitting::new(&cage.net, &scan, context).unfold(&mut cage.points, &mut vertices)?;
            model(mesh, &scan, &mut cage, context)?
        }
        made => made?,
    };
    if model.distance_max > tolerance {
        model.warnings.push(format!(
            "the scan is up to {:.3e} from the model, more than the tolerance of {tolerance:.3e}: where it bends within a \
             few of its triangles, smooth faces cut the bends off",
            model.distance_max
        ));
    }
    if let Some(angle) = model.smooth.as_ref().map(|s| s.angles.max).filter(|&a| a > KINK_DEGREES) {
        model.warnings.push(format!("faces meet at an angle of up to {angle:.2}°"));
    }
    Ok(model)
}

/// Why a surface is no use where only a near one is.
fn too_far(off: f64, tolerance: f64) -> Error {
    Error::Numeric(format!("smooth faces are {off:.1e} from the mesh, more than the tolerance of {tolerance:.1e}"))
}

/// The model of a surface, if it is valid.
fn model(mesh: &SurfaceMesh, scan: &Scan, cage: &mut Cage, context: &Context) -> Result<CadModel> {
    let blocks = blocks(&cage.net, &mut cage.walls, context)?;
    let layout = layout(&cage.net, &cage.walls, &blocks)?;
    let sheets = faces(cage, &blocks, context)?;
    let mut brep = assemble::assemble(&cage.net, &blocks, &layout, &sheets)?;
    let label = enclosed(cage, &blocks, &mut brep)?;
    finish((mesh, scan), cage, (&blocks, &layout, &sheets), brep, &label, context)
}

/// The control points, after as many divisions as the tolerance needs.
fn fitted(
    mut cage: Cage,
    (mesh, scan): (&SurfaceMesh, &Scan),
    vertices: &mut [Sample],
    Asked { tolerance, most_divided, is_strict }: Asked,
    context: &Context,
) -> Result<Cage> {
    let _stage = context.stage("surface");
    let goal = Goal { max: tolerance, rms: MEAN_DISTANCE * tolerance };
    for division in 0..=DIVISIONS {
        let has_finer = 4 * cage.net.quads.len() <= mesh.vertex_count();
        let turn = Turn {
            is_first: division == 0,
            is_last: division == DIVISIONS || cage.net.quads.len() > most_divided,
            has_finer,
        };
        let off = run(&cage.net, &mut cage.points, vertices, scan, (turn, goal), context)?;
        if turn.ends(goal, off) {
            return if is_strict && off[0] > tolerance { Err(too_far(off[0], tolerance)) } else { Ok(cage) };
        }
        cage = cage.divided()?;
    }
    Err(Error::Bug("no surface was fitted".into()))
}

fn faces(cage: &Cage, blocks: &[Block], context: &Context) -> Result<Vec<Sheet>> {
    let _stage = context.stage("faces");
    let (surface, grades) = (cage.limit(), cage.grades());
    let one = |block: &Block| {
        context.check()?;
        sheet(&cage.net, block, &surface, grades)
    };
    let mut sheets = blocks.iter().map(one).collect::<Result<Vec<Sheet>>>()?;
    polish::polish(&cage.net, blocks, &mut sheets, grades, context)?;
    Ok(sheets)
}

/// Shells and solids of the model, by the triangles of the quads. Returns the face of every quad.
fn enclosed(cage: &Cage, blocks: &[Block], brep: &mut Brep) -> Result<Vec<u32>> {
    let label: Vec<u32> = measure::places(&cage.net, blocks).into_iter().map(|p| p.0).collect();
    let triangles: Vec<[u32; 3]> = cage.net.quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let mesh = SurfaceMesh::from_triangles(cage.points.clone(), &triangles)?;
    let Some(t) = Triangles::of(&mesh) else { return Err(Error::Bug("triangles are none".into())) };
    let of_triangles: Vec<u32> = label.iter().flat_map(|&l| [l, l]).collect();
    enclose(t, &of_triangles, blocks.len(), brep)?;
    Ok(label)
}

/// The check, and everything that is measured.
fn finish(
    (mesh, scan): (&SurfaceMesh, &Scan),
    cage: &Cage,
    (blocks, layout, sheets): (&[Block], &Layout, &[Sheet]),
    brep: Brep,
    label: &[u32],
    context: &Context,
) -> Result<CadModel> {
    let _stage = context.stage("check");
    brep.check()?;
    let mut feet = scan.vertices();
    find_feet(&mut feet, &cage.limit(), &cage.net, &cage.points, context)?;
    let off = measure::distances(&cage.net, blocks, &brep, &feet, context)?;
    let off: Vec<f64> = off.into_iter().zip(feet::used(mesh)).filter(|v| v.1).map(|v| v.0).collect();
    let distance_max = off.iter().copied().fold(0.0, f64::max);
    let distance_rms = (off.iter().map(|d| d * d).sum::<f64>() / off.len().max(1) as f64).sqrt();
    check(mesh, &brep, distance_max, context)?;
    let masses = brep.face_masses(context)?;
    let areas: Vec<f64> = masses.iter().map(|m| m.area).collect();
    let area = areas.iter().sum();
    let volume = brep.solid_masses(&masses).iter().map(|m| m.volume).sum();
    let angles = measure::angles(&cage.net, blocks, layout, sheets, &brep);
    let irregular = cage.net.fans.iter().filter(|f| !cage.net.is_regular(f)).count();
    // The face of a triangle is that of its first vertex' foot.
    let face = |f: &[u32]| label[feet[f[0] as usize].part as usize / 4];
    let face_of_triangle = mesh.faces().iter().map(face).collect();
    Ok(CadModel {
        brep,
        face_of_triangle,
        fallback: Vec::new(),
        segmentation: None,
        smooth: Some(Smooth { angles, quads: cage.net.quads.len(), irregular }),
        relations: Vec::new(),
        warnings: Vec::new(),
        areas,
        area,
        volume,
        distance_max,
        distance_rms,
    })
}

/// What the validator of [`crate::brep`] has against a model that is so near to its scan.
fn check(mesh: &SurfaceMesh, brep: &Brep, near: f64, context: &Context) -> Result<()> {
    let region_of = vec![0; mesh.face_count()];
    let distance = (BULGE_FACTOR * near).max(LEAST_BULGE * mesh.diagonal());
    let limits = Limits { angle: TURNED_OVER, ..Limits::new(mesh.diagonal(), distance) };
    let reference = Reference { mesh, region_of: &region_of };
    let Some(f) = first_finding(brep, Some(&reference), &limits, context)? else { return Ok(()) };
    tracing::debug!(?f, "finding");
    Err(Error::Numeric(format!("of the {}: {:.1e}, {:.1e} allowed", f.fault.name(), f.measured, f.bound)))
}
