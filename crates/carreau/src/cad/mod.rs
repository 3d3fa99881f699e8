//! Room 6: a mesh becomes a CAD model, with the faces that the part really has.
//!
//! Lavoué, Dupont and Baskurt name it as the aim of their segmentation: sub-surfaces approximated by parametric surfaces.
//! The stages are those of reverse engineering (Várady, Martin, Cox: *Reverse engineering of geometric models*, CAD 29, 1997).
//!
//! | stage | file |
//! |---|---|
//! | regions and their surfaces | [`crate::segment`] |
//! | the map of its pieces | `regions` |
//! | neighbours on one surface made one, crumbs absorbed | `clean` |
//! | how exact the data is | `exact` |
//! | fillets of flat strips | `arcs` |
//! | triangles that lie on two surfaces | `ties` |
//! | extrusions and surfaces of revolution among the regions without a surface | `swept` |
//! | neighbours that may be parts of one of them | `unions` |
//! | directions and axes of sweeps | `axes` |
//! | their profiles, and the lines and arcs of these | `profile`, `runs` |
//! | pieces that fit in part | `misfits` |
//! | a few triangles in the wrong piece | `scraps` |
//! | edges that noise has made | `contract` |
//! | surfaces that touch or meet in one point, and all of them adjusted to that | `relations`, `adjust` |
//! | noisy vertices put on the surfaces around them | `project` |
//! | corners, edges and loops of the map | `topology` |
//! | curves of the edges: with a name | `curves`, `conics` |
//! | curves of the edges: traced | `trace` |
//! | curves of the edges beside spline surfaces | `borders` |
//! | corners | `corners` |
//! | regions laid out in a plane | `flatten` |
//! | spline surfaces between the curves around them | `spline` |
//! | the points that they are fitted to, and the fit on one grid | `points`, `grid` |
//! | loops in parameters and which is the outer one, spheres turned | `faces` |
//! | loops unrolled, and where the seam between them is | `seams` |
//! | the model while it is made | `draft` |
//! | extrusions as spline surfaces | `spelled` |
//! | one attempt, all of the above | `model` |
//! | what stays from one attempt to the next | `memory` |
//! | shells and bodies | `shells` |
//! | what a model must pass | `check` |
//! | pieces that are in the way go down a rung | `ladder` |
//! | the last rungs: plane facets | `facets` |
//! | regions that are too much for one spline surface | `halve` |
//! | smooth faces over all of a scan, without regions | `organic` |
//! | constants | `tuning` |

mod adjust;
mod arcs;
mod axes;
mod borders;
mod check;
mod clean;
mod conics;
mod contract;
mod corners;
mod curves;
mod draft;
mod exact;
mod faces;
mod facets;
mod flatten;
mod grid;
mod halve;
mod ladder;
mod memory;
mod misfits;
mod model;
mod organic;
mod points;
mod profile;
mod project;
mod regions;
mod relations;
mod runs;
mod scraps;
mod seams;
mod shells;
mod spelled;
mod spline;
mod swept;
#[cfg(test)]
mod tests;
mod ties;
mod topology;
mod trace;
mod tuning;
mod unions;

use crate::bounds::positive;
use crate::brep::Brep;
use crate::context::Context;
use crate::error::{Error, Result};
use crate::mesh::{SurfaceMesh, Triangles};
use crate::segment::{Rectify, SegmentOptions, Segmentation, segment};
use glam::DVec3;
use misfits::Share;
use organic::Effort;
use regions::Map;
use serde::{Deserialize, Serialize};
use tuning::{EXACT_TOLERANCE, MODEL_DISTANCE, NEARLY_ALL_AREA, SOME_AREA};

pub use ladder::Fallback;
pub use organic::{Angles, Smooth};
pub use regions::Rung;
pub use relations::Adjusted;

/// What a user should know where the default style gave up the surfaces that were found.
const INSTEAD_OF_FACETS: &str = "smooth faces were made over all of the surface, because with the surfaces that were found more than \
    half of it would be plane facets; the mechanical style gives that model";

/// Degrees: smooth faces that meet at more than this are no better than facets, because they may be folded there.
const MOST_KINK: f64 = 1.0;

/// What kind of model is made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Style {
    /// From the data.
    #[default]
    Auto,
    /// Faces on the surfaces of a part.
    Mechanical,
    /// Spline faces over all of a free surface.
    Organic,
}

/// Options of [`rebuild`].
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct CadOptions {
    /// What kind of model is made.
    pub style: Style,
    /// Largest distance of a vertex from its face, in the unit of the file; from the data by default.
    #[serde(skip)]
    pub tolerance: Option<f64>,
    /// Faces as given: one label per triangle.
    #[serde(skip)]
    pub labels: Option<Vec<u32>>,
    /// More faces than this are refused.
    pub max_faces: Option<u32>,
    /// Whether noisy surfaces are adjusted to each other: directions, axes, equal radii, round numbers.
    pub snap: Snap,
}

/// Whether noisy surfaces are adjusted to each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Snap {
    /// Parallel and perpendicular directions, axes on one line, equal radii, and lengths that are round numbers in the unit of the file.
    #[default]
    On,
    /// Every surface is fitted for itself; only surfaces that touch or meet in a point do so exactly.
    Off,
}

/// A CAD model with what is known about it.
#[derive(Debug, Clone)]
pub struct CadModel {
    /// The model. The face of every piece of the mesh has its number.
    pub brep: Brep,
    /// Face of every triangle of the mesh.
    pub face_of_triangle: Vec<u32>,
    /// Regions that fell down the ladder.
    pub fallback: Vec<Fallback>,
    /// What the regions were; none where smooth faces do without.
    pub segmentation: Option<Segmentation>,
    /// What is known of smooth faces, where the model is made of these.
    pub smooth: Option<Smooth>,
    /// What the surfaces were adjusted to.
    pub relations: Vec<Adjusted>,
    /// What a user should know, one sentence each.
    pub warnings: Vec<String>,
    /// Area of every face.
    pub areas: Vec<f64>,
    /// Area of the model.
    pub area: f64,
    /// Volume of its solids.
    pub volume: f64,
    /// Largest distance of a vertex of the mesh from the surface of its face.
    pub distance_max: f64,
    /// Root mean square of these distances.
    pub distance_rms: f64,
}

/// Makes a CAD model of a mesh: every closed body a solid, every open one a shell.
///
/// # Errors
/// Faces with more than three corners, no faces, an option without sense, or more faces than allowed.
pub fn rebuild(mesh: &SurfaceMesh, options: &CadOptions, context: &Context) -> Result<CadModel> {
    let Some(triangles) = Triangles::of(mesh) else {
        return Err(Error::input("the mesh has faces with more than three corners", "", "triangulate it first"));
    };
    if let Some(tolerance) = options.tolerance {
        positive("tolerance", tolerance)?;
    }
    if options.style == Style::Organic {
        if options.labels.is_some() {
            return Err(Error::Options("labels are faces of a part; style organic makes its own".into()));
        }
        return allowed(organic::organic(mesh, options, Effort::Full, context)?, options);
    }
    let wanted = SegmentOptions {
        labels: options.labels.clone(),
        tolerance: options.tolerance,
        rectify: if options.labels.is_some() { Rectify::None } else { Rectify::default() },
        ..SegmentOptions::default()
    };
    let (segmentation, mut map) = segmented(mesh, triangles, wanted, context)?;
    // Where there is no such model trimmed spline surfaces are tried.
    if map.is_free()
        && let Some(smooth) = smooth(mesh, options, Effort::Full, context)?
    {
        return allowed(smooth, options);
    }
    let mut relations = settle(&mut map, options.snap, context)?;
    let places = if map.is_noisy() { Some(map.projected(context)?) } else { None };
    let (map, brep, fallback) = descend(map, places.as_deref(), mesh, context)?;
    // Facets are a valid model, too, but nobody can edit them.
    if map.is_faceted()
        && let Some(smooth) = instead_of_facets(mesh, options, context)?
    {
        return allowed(smooth, options);
    }
    let (distance_max, distance_rms) = distances(&map);
    let masses = brep.face_masses(context)?;
    let areas: Vec<f64> = masses.iter().map(|m| m.area).collect();
    let area = areas.iter().sum();
    let volume = brep.solid_masses(&masses).iter().map(|m| m.volume).sum();
    let face_of_triangle = map.label;
    relations.iter_mut().flat_map(|r| &mut r.faces).for_each(|t| *t = face_of_triangle[*t as usize]);
    let model = CadModel {
        brep,
        face_of_triangle,
        fallback,
        segmentation: Some(segmentation),
        smooth: None,
        relations,
        warnings: far_vertices(distance_max / mesh.diagonal()).into_iter().collect(),
        areas,
        area,
        volume,
        distance_max,
        distance_rms,
    };
    allowed(model, options)
}

/// The regions of a mesh and the map of their pieces: as they are found by default, or as those of exact data.
fn segmented<'a>(
    mesh: &SurfaceMesh,
    triangles: Triangles<'a>,
    wanted: SegmentOptions,
    context: &Context,
) -> Result<(Segmentation, Map<'a>)> {
    let mut segmentation = segment(mesh, &wanted, context)?;
    let mut map = mapped(mesh, triangles, &segmentation, context)?;
    // Free surfaces in exact data look like noise, but with noise nothing would be exact.
    let share = map.exact_share();
    let doubtful = segmentation.chosen.noise > 0.0 && wanted.tolerance.is_none() && wanted.labels.is_none();
    if doubtful && (SOME_AREA..NEARLY_ALL_AREA).contains(&share) {
        let exact = SegmentOptions { tolerance: Some(EXACT_TOLERANCE * mesh.diagonal()), ..wanted };
        let other = segment(mesh, &exact, context)?;
        let other_map = mapped(mesh, triangles, &other, context)?;
        let known = |map: &Map<'_>| map.known_share();
        let is_better = other_map.exact_share() > share + SOME_AREA && known(&other_map) > known(&map) - SOME_AREA;
        if is_better || (other_map.is_exact() && other_map.exact_share() >= share) {
            (segmentation, map) = (other, other_map);
        }
    }
    Ok((segmentation, map))
}

/// Smooth faces over all of the surface, where the style is not given and there is a valid model of them.
fn smooth(mesh: &SurfaceMesh, options: &CadOptions, effort: Effort, context: &Context) -> Result<Option<CadModel>> {
    if options.style != Style::Auto || options.labels.is_some() {
        return Ok(None);
    }
    match organic::organic(mesh, options, effort, context) {
        Err(Error::Numeric(reason)) => {
            tracing::debug!(target: "carreau::cad", reason, "no smooth faces");
            Ok(None)
        }
        done => done.map(Some),
    }
}

/// Smooth faces that are worth more than facets: near enough, and not folded.
fn instead_of_facets(mesh: &SurfaceMesh, options: &CadOptions, context: &Context) -> Result<Option<CadModel>> {
    let most = options.tolerance.unwrap_or(MODEL_DISTANCE * mesh.diagonal());
    let is_sound = |m: &CadModel| {
        let kink = m.smooth.as_ref().map_or(f64::INFINITY, |s| s.angles.max);
        tracing::debug!(target: "carreau::cad", distance = m.distance_max, kink, "instead of facets");
        m.distance_max <= most && kink <= MOST_KINK
    };
    let mut found = smooth(mesh, options, Effort::Little, context)?.filter(is_sound);
    found.iter_mut().for_each(|m| m.warnings.push(INSTEAD_OF_FACETS.into()));
    Ok(found)
}

/// What a user should know where vertices are far off their faces, by a share of the diagonal.
fn far_vertices(share: f64) -> Option<String> {
    (share > MODEL_DISTANCE).then(|| {
        let percent = 100.0 * share;
        format!("vertices are up to {percent:.2} % of the diagonal off their faces, because the mesh has noise; set a smaller tolerance for nearer faces")
    })
}

/// Goes down the ladder with other places of the vertices, if there are any, and with those of the mesh if there is no model then.
fn descend<'a>(
    mut map: Map<'a>,
    places: Option<&'a [DVec3]>,
    mesh: &SurfaceMesh,
    context: &Context,
) -> Result<(Map<'a>, Brep, Vec<Fallback>)> {
    if let Some(places) = places {
        let mut moved = map.clone().with_vertices_of(map.t.with_points(places));
        match ladder::descend(&mut moved, mesh, context) {
            // Facets that were turned over do not make a model.
            Err(Error::Numeric(reason)) => tracing::debug!(target: "carreau::cad", reason, "no model on the surfaces"),
            done => return done.map(|(brep, fallback)| (moved, brep, fallback)),
        }
    }
    let (brep, fallback) = ladder::descend(&mut map, mesh, context)?;
    Ok((map, brep, fallback))
}

/// A model that has not more faces than allowed.
fn allowed(model: CadModel, options: &CadOptions) -> Result<CadModel> {
    let faces = model.brep.faces.len();
    match options.max_faces {
        Some(most) if faces > most as usize => Err(Error::Numeric(format!(
            "the model has {faces} faces, more than the {most} allowed; simplify the mesh first, or raise --max-faces"
        ))),
        _ => Ok(model),
    }
}

/// The pieces of a segmentation.
fn mapped<'a>(mesh: &SurfaceMesh, t: Triangles<'a>, segmentation: &Segmentation, context: &Context) -> Result<Map<'a>> {
    let _stage = context.stage("map");
    let mut map = Map::new(t, mesh.diagonal(), segmentation);
    map.unify();
    map.absorb_scraps();
    arcs::round(&mut map)?;
    map.measure_precision();
    if map.has_misfits() {
        map.part_misfits(Share::Most);
        if map.is_exact() {
            map.part_misfits(Share::Round);
        }
        map.settle_ties();
    }
    swept::sweep(&mut map)?;
    if map.has_misfits() && map.part_misfits(Share::Half) {
        swept::sweep(&mut map)?;
    }
    if map.is_exact() && map.part_flats() {
        swept::sweep(&mut map)?;
    }
    map.part_lids();
    map.unify();
    Ok(map)
}

/// What is known of pieces before there is a topology: surfaces that touch do, and those that meet in a point.
fn settle(map: &mut Map<'_>, snap: Snap, context: &Context) -> Result<Vec<Adjusted>> {
    let _stage = context.stage("map");
    map.tighten();
    map.contract()?;
    let relations = relations::relate(map, snap == Snap::On, context)?;
    map.tighten();
    Ok(relations)
}

/// Largest and root mean square distance of the vertices of all pieces from their surfaces.
fn distances(map: &Map<'_>) -> (f64, f64) {
    let (mut max, mut sum, mut count) = (0.0f64, 0.0, 0.0);
    for piece in &map.pieces {
        let vertices = regions::vertices(map.t, &piece.triangles).len() as f64;
        (max, sum, count) = (max.max(piece.max), sum + piece.square * vertices, count + vertices);
    }
    (max, (sum / f64::max(count, 1.0)).sqrt())
}
