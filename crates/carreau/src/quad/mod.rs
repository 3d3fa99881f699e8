//! Room 4: all-quad meshes that keep every feature, for any surface.
//!
//! Quads are made by global parametrisation; where that fails triangles are paired, or become three quads each. A validator looks
//! at every result before it is shown.
//!
//! Where symmetry is asked for, all of this is done to one half (`symmetry`).
//!
//! | rung | method | file |
//! |---|---|---|
//! | | the methods in their order; what speaks against quads | `methods`; `judged` |
//! | 1 | global parametrisation: the seamless map of a frame field (Protais et al., as in room `field`), made whole on its singularities; its quads, put onto the surface | `map`; `mapped` |
//! | 3 | triangles of twice the size that keep the features, paired along the field, halved, smoothed | `coarse`, `pair`; `paired` |
//! | 4 | every triangle of the input becomes three quads; features stay to the bit | `halve` |
//!
//! | stages of rung 1 | file |
//! |---|---|
//! | the surface: its regions and feature curves; borders that lie on each other are sewn while quads are made | `source`, `curve`, `junction`; `scraps`; `sew` |
//! | what quads are led by besides: sizes, thin limbs, guides, planes that the surface was cut at | `guidance`; `sizes`, `limbs` |
//! | working mesh, field, map, whole numbers, quads | `coarse`; `map` |
//! | vertices go to where features bend, and where the surface comes to a point | `bends`, `apices` |
//! | smoothing; quads that are turned over | `smooth`, `straighten`, `around`, `ceiling`; `untangle` |
//! | where quads are no good: creases of a scan are let go; smaller quads, by other whole numbers; the last few are taken out | `mapped`; `release`; `collapse` |
//! | vertices where the surface bends, and off it where quads would be too far from it | `fit`, `gaps`, `lift`, `nearer` |
//! | the validator; figures | `validate`; `quality` |
//!
//! [`graph`] is the motorcycle graph of the same field (the second application that the paper makes of it), a result of its own.

mod apices;
mod around;
mod bends;
mod ceiling;
mod coarse;
mod collapse;
mod curve;
mod fit;
mod gaps;
pub mod graph;
mod guidance;
mod halve;
mod judged;
mod junction;
mod lift;
mod limbs;
mod map;
mod mapped;
mod methods;
mod nearer;
mod pair;
mod paired;
mod quality;
mod release;
mod scraps;
mod sew;
mod sizes;
mod smooth;
mod source;
mod straighten;
mod symmetry;
#[cfg(test)]
mod tests;
mod untangle;
mod validate;
mod work;

pub use graph::{GraphOptions, MotorcycleGraph, motorcycle_graph};
pub use quality::QuadQuality;
pub use symmetry::{MirrorPlane, Symmetry};

use crate::bounds::{positive, within};
use crate::context::Context;
use crate::error::{Error, Result};
use crate::field::MOST_CURVATURE_WEIGHT;
use crate::geometry::features::{FeatureOptions, FoundFeatures};
use crate::mesh::{Column, Polygons, SurfaceMesh, UnitScale, VertexId, divided};
use glam::DVec3;
use guidance::Guidance;
use judged::USELESS_STRAYING;
use lift::lift;
use mapped::ALL_ATTEMPTS;
use methods::Made;
use serde::{Deserialize, Serialize};
use source::Source;
use symmetry::Symmetric;
use work::Work;

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
    /// The last one: where none up to it gives quads there is an error.
    #[serde(skip)]
    pub last_rung: u32,
    /// How often quads are made of the map of rung 1 at most, over all working meshes: fewer where another method stands ready.
    #[serde(skip)]
    pub attempts: usize,
    /// Quads that are the same on both sides of a plane.
    pub symmetry: Symmetry,
    /// Smaller quads where the surface bends, larger ones where it is flat.
    pub adaptive: bool,
    /// Name of a vertex property that says how long the edges are to be, relative to each other; where it is a colour, red makes
    /// quads smaller.
    pub sizes: Option<String>,
    /// Weight of the directions of curvature in the field, see [`FieldOptions`](crate::field::FieldOptions::curvature): quads run along limbs
    /// with it, and have fewer irregular vertices without.
    pub curvature: f64,
    /// More quads are refused.
    pub max_quads: Option<usize>,
    /// Segments on the surface that rows of quads follow.
    #[serde(skip)]
    pub guides: Vec<[DVec3; 2]>,
}

impl Default for QuadOptions {
    fn default() -> Self {
        QuadOptions {
            features: FeatureOptions::auto(),
            quads: 3000,
            edge_length: None,
            rung: 1,
            last_rung: 4,
            attempts: ALL_ATTEMPTS,
            symmetry: Symmetry::Off,
            adaptive: false,
            sizes: None,
            curvature: CURVATURE,
            max_quads: None,
            guides: Vec::new(),
        }
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
    /// What was repaired before, and what could not be reached, one sentence each.
    pub warnings: Vec<String>,
    /// Tagged and listed edges that the mesh does not have.
    pub missing: Vec<[VertexId; 2]>,
    /// The features of the input, and sharp edges that are none at the size of the quads.
    pub features: FoundFeatures,
    /// The planes that the quads are mirrored in.
    pub symmetry: Vec<MirrorPlane>,
}

impl Quads {
    /// The worst rung.
    pub fn rung(&self) -> u32 {
        self.rungs.iter().map(|r| r.rung).max().unwrap_or(0)
    }
}

/// Weight of the directions of curvature in the field: little beside the smoothness, so that they turn the field along limbs and
/// make no singularities.
const CURVATURE: f64 = 0.03;
/// A share of the number: quads that are wanted are met within it, because features need what they need.
const NUMBER_WITHIN: f64 = 0.1;
/// A count: rounds in which quads that are no good go back to where they were, because each may spoil those beside it.
const TAKE_BACK_ROUNDS: usize = 30;

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
/// [`Error::Options`] for options out of range, or sizes that are no such property; [`Error::Input`] for a mesh without faces;
/// [`Error::Numeric`] for a surface without the symmetry that is asked for, more quads than are allowed, or none up to the last rung; [`Error::Cancelled`],
/// [`Error::Deadline`].
pub fn quads(mesh: &SurfaceMesh, options: &QuadOptions, context: &Context) -> Result<Quads> {
    options.validate()?;
    let scale = UnitScale::of_mesh(mesh);
    if let Some(mesh) = scale.mesh(mesh, &[]) {
        let edge_length = options.edge_length.map(|length| scale.length(length));
        let guides = options.guides.iter().map(|e| e.map(|p| scale.point(p))).collect();
        let made = quads(&mesh, &QuadOptions { edge_length, guides, ..options.clone() }, context)?;
        let mesh = scale.back().moved(made.mesh, &[]);
        let symmetry = made.symmetry.into_iter().map(|plane| plane.moved(scale.back())).collect();
        return Ok(Quads { mesh, features: made.features.moved(scale.back()), symmetry, ..made });
    }
    let mut warnings = Vec::new();
    if options.symmetry != Symmetry::Off {
        match symmetry::quads(mesh, options, context)? {
            Ok(Symmetric { source, made, planes }) => {
                return Ok(Quads { symmetry: planes, ..judged(&source, mesh, made, options, warnings, context)? });
            }
            Err(why) => warnings.push(why),
        }
    }
    let source = Source::new(mesh, &sized(&options.features, mesh, options.quads, options.edge_length), context)?;
    let source = guided(source, mesh, options, context)?;
    let (source, made) = methods::best(source, mesh, options, context)?;
    judged(&source, mesh, made, options, warnings, context)
}

/// A surface with what quads are led by besides.
fn guided(source: Source, mesh: &SurfaceMesh, options: &QuadOptions, context: &Context) -> Result<Source> {
    let length = options.edge_length.unwrap_or_else(|| (source.area / options.quads as f64).sqrt());
    let guidance = Guidance::new(&source, mesh, options, length, context)?;
    Ok(source.guided(guidance))
}

/// Quads with their figures, and what of them is not as it was asked for.
fn judged(
    source: &Source,
    mesh: &SurfaceMesh,
    made: Made,
    options: &QuadOptions,
    mut warnings: Vec<String>,
    context: &Context,
) -> Result<Quads> {
    let Made { work, method, warnings: more } = made;
    warnings.extend(more);
    let count = work.faces.len();
    if let Some(most) = options.max_quads.filter(|&most| count > most) {
        return Err(Error::Numeric(format!(
            "{count} quads were made, at most {most} are allowed: ask for fewer, or keep fewer features"
        )));
    }
    if options.edge_length.is_none() && off(count, options.quads) > NUMBER_WITHIN {
        warnings.push(format!(
            "{} quads were asked for, {count} were made: what the features need, or what is left where the map of the surface fails",
            options.quads
        ));
    }
    let mut quality = quality::measure(&work, source);
    if quality.feature_recall < validate::LEAST_RECALL
        && let (kept, Some(p)) = validate::recall(&work, source)
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
    let [mut found, mut bound] = quality::distance(&work, &source.surface.mesh, context)?;
    if let Some(fans) = other_triangles(mesh)? {
        let of_fans = quality::distance(&work, &fans, context)?;
        (found, bound) = (found.max(of_fans[0]), bound.max(of_fans[1]));
    }
    (quality.distance_found, quality.distance_max) = (Some(found), Some(bound));
    let edge = (source.area / count as f64).sqrt();
    if found * source.diagonal > USELESS_STRAYING * edge {
        warnings.push(format!(
            "the quads are up to {:.2} % of the diagonal from the surface: a part of it is thinner than they are; more quads are nearer",
            100.0 * found
        ));
    }
    finish(source, work, method.rung(), quality, warnings)
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
    /// [`Error::Options`].
    pub fn validate(&self) -> Result<()> {
        self.features.validate()?;
        check_size(self.quads, self.edge_length)?;
        within("curvature", self.curvature, 0.0..=MOST_CURVATURE_WEIGHT, "")?;
        if self.adaptive && self.sizes.is_some() {
            return Err(Error::Options("sizes: either adaptive or by a property, not both".into()));
        }
        within("rung", self.rung, 1..=4, "")?;
        within("last-rung", self.last_rung, self.rung..=4, "")
    }
}

/// Features at the size of the quads.
fn sized(features: &FeatureOptions, mesh: &SurfaceMesh, quads: usize, edge_length: Option<f64>) -> FeatureOptions {
    match edge_length {
        Some(length) => features.for_size(length),
        None => features.for_squares(mesh, quads as f64),
    }
}
/// A count: most quads that may be asked for, because more do not fit into memory.
const MOST_QUADS: usize = 100_000_000;

fn check_size(quads: usize, edge_length: Option<f64>) -> Result<()> {
    within("quads", quads, 1..=MOST_QUADS, "")?;
    edge_length.map_or(Ok(()), |length| positive("edge-length", length))
}

fn off(count: usize, wanted: usize) -> f64 {
    (count as f64 / wanted as f64 - 1.0).abs()
}

/// Lifts quads, but for those that would be no good then. Returns how far they are from the surface.
fn lifted(work: &mut Work, source: &Source, context: &Context) -> Result<f64> {
    let before = work.points.clone();
    let gap = lift(work, source, context)?;
    take_back(work, &before, source);
    Ok(gap)
}

/// Puts the vertices of quads that are no good to where they were before, as triangles have them or not yet lifted: no quad
/// was turned over there.
fn take_back(work: &mut Work, before: &[DVec3], source: &Source) {
    for _ in 0..TAKE_BACK_ROUNDS {
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

fn finish(source: &Source, mut work: Work, rung: u32, quality: QuadQuality, warnings: Vec<String>) -> Result<Quads> {
    drop_unused(&mut work);
    let mut mesh = work.to_mesh()?;
    let mut counts = vec![0; source.regions];
    work.region.iter().for_each(|&r| counts[r as usize] += 1);
    let rungs = counts.into_iter().zip(0u32..).filter(|&(quads, _)| quads > 0);
    let rungs = rungs.map(|(quads, region)| RegionRung { region, rung, quads }).collect();
    let labels = work.region.iter().map(|&r| r as i32).collect();
    mesh.attributes.face.insert("region".into(), Column::Label(labels));
    Ok(Quads {
        mesh,
        quality,
        rungs,
        warnings,
        missing: source.surface.missing.clone(),
        features: source.surface.found.clone(),
        symmetry: Vec::new(),
    })
}

/// Drops vertices without a face.
fn drop_unused(work: &mut Work) {
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
    work.features.iter_mut().for_each(|(ends, _)| *ends = ends.map(|v| number[v as usize]));
}
