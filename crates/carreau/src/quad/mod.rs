//! Room 4: all-quad meshes that keep every feature, for any surface.
//!
//! A ladder of methods, the best first; a validator between the rungs decides whether a result is shown.
//!
//! | rung | file | method |
//! |---|---|---|
//! | 1 | `mapped`, `map` | on surfaces without features, or with creases that fade out, first, on others where the graph's first quads are no good: global parametrisation: the seamless map of a frame field (Protais et al., as in room `field`), made whole on its singularities |
//! | 1 | `attempts`, `tried`, `regular` | on other surfaces with features first, and where the map is refused: the field's motorcycle graph, grids and patterns in its patches |
//! | 2 | `attempts`, `regular` | the same, with triangles of twice the size, paired and halved, in patches that take neither |
//! | 3 | `third`, `pair` | triangles of twice the size that keep the features, paired along the frame field, halved, smoothed |
//! | 4 | `halve` | every triangle of the input becomes three quads; features stay to the bit |
//!
//! | stages of rung 1, by the graph | file |
//! |---|---|
//! | from the surface to its graph | `draw` |
//! | triangles that tracks are drawn into | `sheet` |
//! | the motorcycle graph; as a result of its own | `trace`; [`graph`] |
//! | patches, sides; numbers of quads; those that features need | `layout`; `quantise`; `chords` |
//! | grids, patterns, triangles | `fill`, `pattern`, `chart` |
//! | patches with holes cut open | `cut` |
//! | vertices where features bend, and where the surface comes to a point | `ticks`, `bends`, `tips` |
//! | regions that take the quads of rung 3 | `graft` |
//!
//! | shared | file |
//! |---|---|
//! | regions and feature curves of the source; borders that lie on each other | `source`; `junction` |
//! | the mesh at work, midpoint subdivision, smoothing | `work`, `halve`, `smooth`, `straighten` |
//! | borders that lie on each other are sewn while quads are made | `sew` |
//! | quads that stay turned over are taken out | `collapse` |
//! | vertices where the surface bends, and off it where quads would be too far from it | `fit`, `gaps`, `lift`, `nudge` |
//! | how good quads are, and can be between features | `around`, `ceiling` |
//! | the validator, figures | `validate`, `quality` |
//! | how much may be done on a rung | `budget` |

mod around;
mod attempts;
mod bends;
mod budget;
mod ceiling;
mod chart;
mod chords;
mod collapse;
mod cut;
mod draw;
mod fill;
mod fit;
mod gaps;
mod graft;
pub mod graph;
mod halve;
mod junction;
mod layout;
mod lift;
mod map;
mod mapped;
mod nudge;
mod pair;
mod pattern;
mod quality;
mod quantise;
mod regular;
mod sew;
mod sheet;
mod smooth;
mod source;
mod straighten;
#[cfg(test)]
mod tests;
mod third;
mod ticks;
mod tips;
mod trace;
mod tried;
mod validate;
mod work;

pub use graph::{GraphOptions, MotorcycleGraph, motorcycle_graph};
pub use quality::QuadQuality;

use crate::bounds::{positive, within};
use crate::context::Context;
use crate::error::Result;
use crate::geometry::features::{Creases, FeatureOptions, FoundFeatures};
use crate::mesh::{Column, Polygons, SurfaceMesh, UnitScale, VertexId, divided};
use attempts::Attempts;
use gaps::Gap;
use glam::DVec3;
use halve::{Middle, halve};
use lift::lift;
use regular::Made;
use serde::{Deserialize, Serialize};
use source::Source;
use tried::{STRAYS, Tried};
use work::{Place, Work};

/// Options of [`quads`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct QuadOptions {
    /// What has to stay.
    #[serde(skip)]
    pub features: FeatureOptions,
    /// Number of quads, met within 10 % where the features allow it.
    pub quads: usize,
    /// Length of the edges instead, in the unit of the file.
    #[serde(skip)]
    pub edge_length: Option<f64>,
    /// The first rung that is tried, 1 to 4.
    pub rung: u32,
}

impl Default for QuadOptions {
    fn default() -> Self {
        QuadOptions { features: FeatureOptions::auto(), quads: 3000, edge_length: None, rung: 1 }
    }
}

/// The rung that a region between features was made on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct RegionRung {
    /// Number of the region: the face column `region` of the mesh.
    pub region: u32,
    /// The rung.
    pub rung: u32,
    /// Its quads.
    pub quads: usize,
}

/// An all-quad mesh.
#[derive(Debug, Clone)]
pub struct Quads {
    /// The quads, with the face column `region`; the features are its tagged edges.
    pub mesh: SurfaceMesh,
    /// What was achieved.
    pub quality: QuadQuality,
    /// How.
    pub rungs: Vec<RegionRung>,
    /// Edges along the motorcycle graph that the quads were made in, by their ends: none on rungs 3 and 4.
    pub tracks: Vec<[u32; 2]>,
    /// What was repaired before, and what could not be reached, one sentence each.
    pub warnings: Vec<String>,
    /// Tagged and listed edges that the mesh does not have.
    pub missing: Vec<[VertexId; 2]>,
    /// The features of the input, and sharp edges that are none at the size of the quads.
    pub features: FoundFeatures,
}

impl Quads {
    /// The worst rung.
    pub fn rung(&self) -> u32 {
        self.rungs.iter().map(|r| r.rung).max().unwrap_or(0)
    }
}

/// Numbers of quads are met within this share.
const WITHIN: f64 = 0.1;
/// Rounds in which quads that are no good go back to where they were.
const TAKEN_BACK: usize = 30;
/// Quads farther from the surface than this share of their edges are for the next rung.
const LOST: f64 = 1.0;
const LEFT_OUT: &str = "it leaves part of the surface out";
/// Makes an all-quad mesh in which every feature is a path of edges.
///
/// ```
/// use carreau::{Context, quad, sample};
/// let context = Context::new();
/// let mesh = sample::make("bracket", None, &context)?;
/// let result = quad::quads(&mesh, &quad::QuadOptions::default(), &context)?;
/// assert!(result.mesh.faces().iter().all(|f| f.len() == 4));
/// assert_eq!(result.quality.inverted, 0);
/// # Ok::<(), carreau::Error>(())
/// ```
///
/// # Errors
/// [`Error::Options`](crate::Error::Options) for options out of range, [`Error::Input`](crate::Error::Input) for a mesh without faces, [`Error::Cancelled`](crate::Error::Cancelled),
/// [`Error::Deadline`](crate::Error::Deadline).
pub fn quads(mesh: &SurfaceMesh, options: &QuadOptions, context: &Context) -> Result<Quads> {
    options.validate()?;
    let scale = UnitScale::of_mesh(mesh);
    if let Some(mesh) = scale.mesh(mesh, &[]) {
        let edge_length = options.edge_length.map(|length| scale.length(length));
        let made = quads(&mesh, &QuadOptions { edge_length, ..options.clone() }, context)?;
        let mesh = scale.back().moved(made.mesh, &[]);
        return Ok(Quads { mesh, features: made.features.moved(scale.back()), ..made });
    }
    let source = Source::new(mesh, &sized(&options.features, mesh, options.quads, options.edge_length), context)?;
    let (source, made, mut warnings) = best(source, mesh, options, context)?;
    let count = made.work.faces.len();
    if options.edge_length.is_none() && off(count, options.quads) > WITHIN {
        let rung = made.rung.iter().max().copied().unwrap_or(0);
        warnings.push(format!("{} quads were asked for, the features and rung {rung} allow {count}", options.quads));
    }
    let mut quality = quality::measure(&made.work, &source);
    if quality.feature_recall < validate::RECALL
        && let (kept, Some(p)) = validate::recall(&made.work, &source)
    {
        warnings.push(format!(
            "{:.1} % of the features are kept, the first one is lost near {:.4} {:.4} {:.4}: it is too short or bends too much for the edges of the quads; more quads keep it",
            100.0 * kept, p.x, p.y, p.z
        ));
    }
    if quality.inverted > 0 {
        let inverted = quality.inverted;
        warnings.push(format!("{inverted} quads are turned over: the triangles that they come from have no area"));
    }
    let [mut found, mut bound] = quality::distance(&made.work, &source.surface.mesh, context)?;
    if let Some(fans) = other_triangles(mesh)? {
        let of_fans = quality::distance(&made.work, &fans, context)?;
        (found, bound) = (found.max(of_fans[0]), bound.max(of_fans[1]));
    }
    (quality.distance_found, quality.distance_max) = (Some(found), Some(bound));
    let edge = (source.area / count as f64).sqrt();
    if found * source.diagonal > STRAYS * edge {
        warnings.push(format!(
            "the quads are up to {:.2} % of the diagonal from the surface: a part of it is thinner than they are; more quads are nearer",
            100.0 * found
        ));
    }
    finish(&source, made, quality, warnings)
}

/// The best quads, with the surface whose features they keep, and what could not be reached.
fn best(
    source: Source,
    mesh: &SurfaceMesh,
    options: &QuadOptions,
    context: &Context,
) -> Result<(Source, Made, Vec<String>)> {
    if let Some((made, warnings)) = sewn_and_cut(&source, options, context)? {
        return Ok((source, made, warnings));
    }
    let tried = first_of_map(&source, options, context)?;
    let may_leave_out = options.rung == 1 && source.fades && options.features.creases == Creases::Auto;
    if may_leave_out
        && !tried.is_useful()
        && let Some(found) = without_creases(mesh, options, context)?
    {
        return Ok(found);
    }
    let (made, warnings) = made(&source, tried, options, context)?;
    Ok((source, made, warnings))
}

/// Creases that fade out may leave no room for so few quads: those of the map without any, if it has as many as were asked
/// for.
fn without_creases(
    mesh: &SurfaceMesh,
    options: &QuadOptions,
    context: &Context,
) -> Result<Option<(Source, Made, Vec<String>)>> {
    let features = FeatureOptions { angle_deg: None, ..options.features.clone() };
    let source = Source::new(mesh, &features, context)?;
    let tried = Attempts::new(&source, options, context).of_map(true, context)?;
    if !tried.meets_number() {
        return Ok(None);
    }
    let Some(made) = tried.best().0 else { return Ok(None) };
    let mut warnings = source.surface.repaired.clone();
    warnings.push(
        "the creases of the surface, which fade out, leave no room for so few quads and are not kept; more quads keep them, or an angle \
         from which on edges are features"
            .into(),
    );
    Ok(Some((source, made, warnings)))
}

/// What comes of the map where it is tried first. Between features the graph's grids are straighter; without any it has nothing to
/// start from, and between creases that fade out it does worse than the map, after minutes.
fn first_of_map(source: &Source, options: &QuadOptions, context: &Context) -> Result<Tried> {
    Attempts::new(source, options, context).of_map(options.rung == 1 && is_map_first(source), context)
}

fn is_map_first(source: &Source) -> bool {
    source.edges.is_empty() || source.fades
}

/// The best that the rungs give after a first try of the map, and what they could not reach.
fn made(source: &Source, mut tried: Tried, options: &QuadOptions, context: &Context) -> Result<(Made, Vec<String>)> {
    let mut warnings = source.surface.repaired.clone();
    let attempts = Attempts::new(source, options, context);
    let map_first = is_map_first(source);
    let is_done = map_first && tried.is_useful();
    if options.rung <= 2 && !is_done {
        let goes_on = attempts.first(&mut tried)?;
        if !map_first && goes_on {
            // Where the graph does not do at once, the map mostly does, and sooner than other fields.
            if options.rung == 1 && !tried.will_do() {
                attempts.map(&mut tried, context)?;
            }
            if !tried.will_do() && !tried.is_shaped() {
                attempts.others(&mut tried)?;
            }
        }
    }
    // What keeps to the number and leaves a part out is better than many times as many quads.
    let will_have_to_do = tried.is_useful() || map_first && tried.meets_number();
    if !will_have_to_do && let Some((work, gap)) = third::third(source, options, &mut warnings, context)? {
        attempts.graft(work, gap, &mut tried)?;
    }
    let (made, refused) = tried.best();
    if options.rung <= 2 && made.as_ref().is_none_or(|made| made.rung.iter().all(|&r| r == 3)) {
        warnings.push(format!("rungs 1 and 2 were refused: {refused}"));
    }
    let made = made.unwrap_or_else(|| {
        warnings.push("every triangle becomes three quads".into());
        Made::all_on(4, fourth(source), source)
    });
    Ok((made, warnings))
}

/// The same for a surface whose borders lie on each other, with these sewn while quads are made: both sides agree there. `None`
/// where there is nothing to sew, or the quads are not those of the surface after it.
fn sewn_and_cut(source: &Source, options: &QuadOptions, context: &Context) -> Result<Option<(Made, Vec<String>)>> {
    let Some(sewn) = source.sewn(context)? else { return Ok(None) };
    let (mut made, mut warnings) = made(&sewn, first_of_map(&sewn, options, context)?, options, context)?;
    sew::cut_open(&mut made.work, &mut made.tracks, |curve| sewn.is_sewn[curve as usize]);
    let refusal = validate::topology_refusal(&made.work.to_mesh()?, source);
    tracing::debug!(target: "carreau::quad", refusal, "cut open");
    warnings.splice(0..0, source.surface.repaired.iter().cloned());
    Ok(refusal.is_none().then_some((made, warnings)))
}

/// Polygons that are folded can be read as other triangles than ours: as fans, which most programs make of them.
fn other_triangles(mesh: &SurfaceMesh) -> Result<Option<SurfaceMesh>> {
    if mesh.is_triangular() {
        return Ok(None);
    }
    let fans = mesh.clone().fanned()?;
    Ok((fans.faces() != divided(mesh)?.faces()).then_some(fans))
}

impl QuadOptions {
    /// Refuses values out of range.
    ///
    /// # Errors
    /// [`Error::Options`](crate::Error::Options).
    pub fn validate(&self) -> Result<()> {
        self.features.validate()?;
        check_size(self.quads, self.edge_length)?;
        within("rung", self.rung, 1..=4, "")
    }
}

/// Features at the size of the quads.
fn sized(features: &FeatureOptions, mesh: &SurfaceMesh, quads: usize, edge_length: Option<f64>) -> FeatureOptions {
    match edge_length {
        Some(length) => features.for_size(length),
        None => features.for_squares(mesh, quads as f64),
    }
}
/// Most quads that may be asked for: more do not fit into memory.
const MOST_QUADS: usize = 100_000_000;

fn check_size(quads: usize, edge_length: Option<f64>) -> Result<()> {
    within("quads", quads, 1..=MOST_QUADS, "")?;
    edge_length.map_or(Ok(()), |length| positive("edge-length", length))
}

fn off(count: usize, wanted: usize) -> f64 {
    (count as f64 / wanted as f64 - 1.0).abs()
}

/// Lifts quads, but for those that would be no good then. Returns how far they are from the surface.
fn lifted(work: &mut Work, source: &Source, context: &Context) -> Result<Gap> {
    let before = work.points.clone();
    let gap = lift(work, source, context)?;
    take_back(work, &before, source);
    Ok(gap)
}

/// Puts the vertices of quads that are no good to where they were before, as triangles have them or not yet lifted: no quad
/// was turned over there.
fn take_back(work: &mut Work, before: &[DVec3], source: &Source) {
    for _ in 0..TAKEN_BACK {
        let bad: Vec<usize> = validate::faults(work, source).map(|(q, _)| q).collect();
        let mut moved = false;
        for v in bad.iter().flat_map(|&q| work.faces.face(q)).map(|&v| v as usize) {
            moved |= work.points[v] != before[v];
            work.points[v] = before[v];
        }
        if !moved {
            return;
        }
    }
}

/// Rung 4: always.
fn fourth(source: &Source) -> Work {
    let mesh = &source.surface.mesh;
    let mut place = vec![Place::Fixed; mesh.vertex_count()];
    for (c, &v) in mesh.faces().corners().iter().enumerate() {
        place[v as usize] = Place::Region(source.region[c / 3]);
    }
    let features: Vec<([u32; 2], u32)> = source.edges.iter().copied().zip(source.curve.iter().copied()).collect();
    features.iter().flat_map(|f| f.0).for_each(|v| place[v as usize] = Place::Fixed);
    let coarse = Work {
        points: mesh.points().to_vec(),
        place,
        faces: mesh.faces().clone(),
        region: source.region.clone(),
        features,
    };
    halve(&coarse, source, Middle::Straight)
}

fn finish(source: &Source, made: Made, quality: QuadQuality, warnings: Vec<String>) -> Result<Quads> {
    let Made { mut work, rung, mut tracks, .. } = made;
    drop_unused(&mut work, &mut tracks);
    let mut mesh = work.to_mesh()?;
    let mut counts = vec![0; source.regions];
    work.region.iter().for_each(|&r| counts[r as usize] += 1);
    let rungs = counts
        .into_iter()
        .zip(0u32..)
        .filter(|&(quads, _)| quads > 0)
        .map(|(quads, region)| RegionRung { region, rung: rung[region as usize], quads })
        .collect();
    let labels = work.region.iter().map(|&r| r as i32).collect();
    mesh.attributes.face.insert("region".into(), Column::Label(labels));
    Ok(Quads {
        mesh,
        quality,
        rungs,
        tracks,
        warnings,
        missing: source.surface.missing.clone(),
        features: source.surface.found.clone(),
    })
}

/// Drops vertices without a face; the edges in `tracks` are renumbered with the others.
fn drop_unused(work: &mut Work, tracks: &mut [[u32; 2]]) {
    let mut number = vec![u32::MAX; work.points.len()];
    work.faces.corners().iter().for_each(|&v| number[v as usize] = 0);
    if !number.contains(&u32::MAX) {
        return;
    }
    for (count, n) in (0..).zip(number.iter_mut().filter(|n| **n == 0)) {
        *n = count;
    }
    let used = |v: usize| number[v] != u32::MAX;
    work.points = (0..work.points.len()).filter(|&v| used(v)).map(|v| work.points[v]).collect();
    work.place = (0..work.place.len()).filter(|&v| used(v)).map(|v| work.place[v]).collect();
    let mut faces = Polygons::new();
    work.faces.iter().for_each(|f| faces.push_iter(f.iter().map(|&v| number[v as usize])));
    work.faces = faces;
    let edges = work.features.iter_mut().map(|(ends, _)| ends).chain(tracks);
    edges.for_each(|ends| *ends = ends.map(|v| number[v as usize]));
}
