//! Room 1: the faces of a part, with clean borders, and what surface each one is.
//!
//! Lavoué, Dupont, Baskurt: *Segmentation de maillages triangulaires et rectification directionnelle de frontières basées
//! sur les tenseurs de courbure*. Vertices are classified by curvature, regions grown and merged, and their boundaries
//! corrected along the lines of curvature.
//!
//! | stage | file | paper |
//! |---|---|---|
//! | renumbering by place | `canonical` | – |
//! | areas, sharp edges and vertices, the automatic sharp angle | `surface` | §4.1 |
//! | slivers taken out | `heal` | – |
//! | normals of slivers that are left | `slivers` | – |
//! | enrichment of triangles with three sharp vertices | `enrich` | §4.1 |
//! | classification of vertices | `classify` | §4.2 |
//! | growth of regions | `growth` | §4.3 |
//! | merging, with a dendrogram | `merge` | §4.4, equations 1–4 |
//! | the three in a row | `paper` | §4 |
//! | boundary scores | `score` | §5.2, equations 5–7 |
//! | contour following | `contour` | §5.3, equation 8 |
//! | rectification by minimum cuts | `cut` | – |
//! | planar facets | `facets` | – |
//! | recognition of curved surfaces | `recognise` | – |
//! | neighbourhoods of facets for that | `reach` | – |
//! | whether there are surfaces at all | `probe` | – |
//! | how exact the file is | `precision` | – |
//! | rows of flat strips | `strips` | – |
//! | all surfaces of a part, rung by rung | `surfaces` | – |
//! | what is left, and what is a piece of it | `rest` | – |
//! | surfaces that are not fitted again | `known` | – |
//! | parts whose vertices have noise | `noisy` | – |
//! | what a triangle costs in a region | `price` | – |
//! | regions with their figures and fits | `regions` | – |
//! | boundary polylines | `boundaries` | – |
//! | junctions, where they end | `junctions` | – |
//!
//! Where this departs from the paper:
//! - By default the surfaces of the part are recognised first ([`SegmentOptions::surfaces`]): the vertices of a tessellated
//!   part lie on them, exactly. Near-constant curvature is then asked only of meshes that lie on no surfaces: scans and
//!   organic shapes. The paper's regions fail on a coarse tessellation, which has no vertex inside a face, and where a torus
//!   runs into a cylinder. `SegmentOptions::paper()` gives the paper's pipeline.
//! - Curvatures are multiplied by a length, so that a threshold means the same at every scale.
//! - The curvature of a boundary is the full tensor across creases and the smooth one elsewhere; with one of them for both,
//!   either everything merges or nothing does.
//! - Vertices and triangles are renumbered by place first: how the input numbers them makes no difference.

mod boundaries;
mod canonical;
mod classify;
mod contour;
mod cut;
mod enrich;
mod facets;
mod growth;
mod heal;
mod junctions;
mod known;
mod merge;
mod noisy;
mod paper;
mod precision;
mod price;
mod probe;
mod reach;
mod recognise;
mod regions;
mod rest;
mod score;
mod slivers;
mod strips;
mod surface;
mod surfaces;
#[cfg(test)]
mod tests;

use crate::bounds::positive;
use crate::context::Context;
use crate::error::{Error, Result};
use crate::geometry::curvature::{Curvature, CurvatureOptions, Estimator, curvature, full_magnitudes};
use crate::geometry::primitive::{Fit, Kind};
use crate::mesh::{SurfaceMesh, Triangles, UnitScale};
use canonical::Canonical;
use known::Known;
use paper::{CurvatureRegions, Demand, curvature_regions};
use price::Prices;
use rayon::prelude::*;
use regions::Groups;
use score::Scores;
use serde::{Deserialize, Serialize};
use surface::{Sharp, Surface};

pub use boundaries::Boundary;
pub use junctions::Junction;
pub use merge::{Dendrogram, Merge};
pub use regions::Region;

/// How boundaries are corrected.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Rectify {
    /// Contour following, as in the paper.
    Paper,
    /// Minimum cuts that never lose a region nor raise the price of a triangle.
    #[default]
    Cut,
    /// Not at all.
    None,
}

/// The length that curvatures are multiplied by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Scale {
    /// The largest side of the bounding box, which the paper's thresholds fit.
    LargestSide,
    /// 0.673 times the root of the area: the same in every position, and as long as the side on the paper's Fandisk.
    #[default]
    RootArea,
}

/// Options of [`segment`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct SegmentOptions {
    /// Recognises planes, spheres, cylinders, cones and tori first.
    pub surfaces: bool,
    /// K, the number of clusters in the space of curvatures; from the data by default.
    pub clusters: Option<u32>,
    /// The largest distance D (equation 1) of regions that are merged; from the data by default.
    pub merge_threshold: Option<f64>,
    /// Merges down to this number of regions instead.
    pub regions: Option<u32>,
    /// How boundaries are corrected.
    pub rectify: Rectify,
    /// Edges that bend by more than this are sharp, in degrees; from the data by default, near 25.
    pub sharp_angle: Option<f64>,
    /// ST: boundary edges with a lower score (equation 5, 0 to 2) are correct, for [`Rectify::Paper`].
    pub score_threshold: f64,
    /// How curvatures are estimated.
    pub estimator: Estimator,
    /// Radius of the ball of [`Estimator::NormalCycleBall`], in the unit of the file.
    #[serde(skip)]
    pub radius: Option<f64>,
    /// The length that curvatures are multiplied by.
    pub scale: Scale,
    /// A_min of equation 4, as a share of the area.
    pub min_area: f64,
    /// Largest distance of a region's vertices from the surface it is given, in the unit of the file; from the data by
    /// default.
    #[serde(skip)]
    pub tolerance: Option<f64>,
    /// Starts from these labels, one per triangle, instead of finding regions.
    #[serde(skip)]
    pub labels: Option<Vec<u32>>,
}

impl Default for SegmentOptions {
    fn default() -> Self {
        SegmentOptions {
            surfaces: true,
            clusters: None,
            merge_threshold: None,
            regions: None,
            rectify: Rectify::default(),
            sharp_angle: None,
            score_threshold: 0.2,
            estimator: Estimator::default(),
            radius: None,
            scale: Scale::default(),
            min_area: 1e-3,
            tolerance: None,
            labels: None,
        }
    }
}

impl SegmentOptions {
    /// The paper's pipeline, with its threshold and the clusters of its Fandisk.
    pub fn paper() -> Self {
        SegmentOptions {
            surfaces: false,
            clusters: Some(18),
            merge_threshold: Some(5.0),
            sharp_angle: Some(25.0),
            rectify: Rectify::Paper,
            scale: Scale::LargestSide,
            ..SegmentOptions::default()
        }
    }

    /// Refuses values out of range.
    ///
    /// # Errors
    /// [`Error::Options`].
    pub fn validate(&self) -> Result<()> {
        let refuse = |what: String| Err(Error::Options(what));
        if self.clusters == Some(0) || self.regions == Some(0) {
            return refuse("clusters and regions are at least 1".into());
        }
        if self.clusters.is_some_and(|k| k > 256) {
            return refuse("at most 256 clusters make sense".into());
        }
        if self.merge_threshold.is_some_and(|t| !(t >= 0.0 && t.is_finite())) {
            return refuse("merge-threshold is a number from 0 on, or auto".into());
        }
        if self.sharp_angle.is_some_and(|a| !(0.0..=180.0).contains(&a)) {
            return refuse("sharp-angle is an angle in 0..180 degrees".into());
        }
        if self.tolerance.is_some_and(|t| !(t > 0.0 && t.is_finite())) {
            return refuse("tolerance is a length above 0".into());
        }
        if !(0.0..1.0).contains(&self.min_area) || !(self.score_threshold >= 0.0) {
            return refuse("min-area is a share below 1, score-threshold is not negative".into());
        }
        self.radius.map_or(Ok(()), |radius| positive("radius", radius))
    }

    fn check_labels(&self, triangles: usize) -> Result<()> {
        match &self.labels {
            Some(labels) if labels.len() != triangles => {
                Err(Error::Options(format!("{} labels were given for {triangles} triangles", labels.len())))
            }
            _ => Ok(()),
        }
    }
}

/// How the regions were found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Basis {
    /// From the surfaces of the part.
    Surfaces,
    /// From near-constant curvature.
    Curvature,
    /// From given labels.
    Labels,
}

/// What the automatic parameters were.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Chosen {
    /// How the regions were found.
    pub basis: Basis,
    /// Edges that bend by more are sharp, in degrees.
    pub sharp_angle_deg: f64,
    /// Number of clusters; 0 where none were needed.
    pub clusters: usize,
    /// Threshold on D; 0 where nothing was merged.
    pub merge_threshold: f64,
    /// Length that curvatures were multiplied by.
    pub scale: f64,
    /// Largest distance of a vertex from the surface of its region.
    pub tolerance: f64,
    /// Share of the area that lies on recognised surfaces.
    pub recognised: f64,
    /// Standard deviation of the vertices of a noisy part from their surfaces; 0 for all other meshes.
    pub noise: f64,
    /// Triangles that rectification gave to another region.
    pub rectified: usize,
}

/// The regions of a mesh.
#[derive(Debug, Clone)]
pub struct Segmentation {
    /// Region of every triangle, 0 the largest.
    pub labels: Vec<u32>,
    /// The regions, by decreasing area.
    pub regions: Vec<Region>,
    /// The lines between them.
    pub boundaries: Vec<Boundary>,
    /// Where the lines end.
    pub junctions: Vec<Junction>,
    /// All merges of the curvature regions; empty where there were none.
    pub dendrogram: Dendrogram,
    /// The parameters.
    pub chosen: Chosen,
}

impl Segmentation {
    /// The same for the mesh in another scale.
    fn in_scale(mut self, scale: UnitScale) -> Segmentation {
        for region in &mut self.regions {
            region.area = scale.back().area(region.area);
            [region.kmin, region.kmax] = [region.kmin, region.kmax].map(|k| scale.back().curvature(k));
            [region.rms, region.max] = [region.rms, region.max].map(|d| scale.length(d));
            region.primitive =
                region.primitive.map(|p| p.moved(|point| scale.point(point), |length| scale.length(length)));
        }
        for junction in &mut self.junctions {
            junction.position = scale.point(junction.position);
            junction.distance = scale.length(junction.distance);
        }
        let Chosen { scale: size, tolerance, noise, .. } = &mut self.chosen;
        [size, tolerance, noise].into_iter().for_each(|length| *length = scale.length(*length));
        self
    }
}

/// A share of the extent: largest distance of a vertex from the surface of its region, because careless kernels are
/// about that exact.
const EXACT_TOLERANCE: f64 = 3e-5;
/// A factor: across creases only regions smaller than A_min by this are merged first, because creases part small faces
/// as well.
const CREASE_DIVISOR: f64 = 50.0;
/// A count: clusters of curvature on scans, few because noise would make regions of more.
const SCAN_CLUSTERS: usize = 5;
/// A share of the area: A_min on scans, because smaller regions are noise.
const SCAN_AREA: f64 = 4e-3;
/// A count: rounds of averaging of curvature on scans, because it varies from vertex to vertex by noise.
const SCAN_SMOOTHING: usize = 12;
/// Multiple of the median bend from which edges of scans are sharp, because noise bends nearly all edges by less.
const SCAN_BENDS: f64 = 6.0;
/// Radians, 60°: edges of scans that bend by more are sharp in any case, because otherwise rough scans would have no
/// creases.
const SCAN_SHARPEST: f64 = 1.05;
/// A count: rounds of rectification, two because the first moves boundaries by nearly all.
const RECTIFICATION_ROUNDS: usize = 2;

/// Segments a triangle mesh.
///
/// ```
/// use carreau::{Context, sample, segment};
/// let context = Context::new();
/// let mesh = sample::make("cube-cylinders", None, &context)?;
/// let result = segment::segment(&mesh, &segment::SegmentOptions::default(), &context)?;
/// assert!(result.regions.iter().all(|region| region.primitive.is_some()));
/// # Ok::<(), carreau::Error>(())
/// ```
///
/// # Errors
/// [`Error::Options`] for options out of range, [`Error::Input`] for a mesh without faces or with polygons,
/// [`Error::Cancelled`], [`Error::Deadline`].
pub fn segment(mesh: &SurfaceMesh, options: &SegmentOptions, context: &Context) -> Result<Segmentation> {
    let Some(triangles) = Triangles::of(mesh) else {
        return Err(Error::input("the mesh has faces with more than three corners", "", "triangulate it first"));
    };
    if triangles.is_empty() {
        return Err(Error::input("the mesh has no faces", "", "segmentation needs triangles"));
    }
    options.validate()?;
    options.check_labels(triangles.len())?;
    // Digits of decimals are those of the file's unit.
    let rounding = precision::decimal(triangles.points()).unwrap_or_default();
    let scale = UnitScale::of(triangles);
    if let Some(mesh) = scale.mesh(mesh, &[]) {
        let [radius, tolerance] = [options.radius, options.tolerance].map(|l| l.map(|l| scale.length(l)));
        let options = SegmentOptions { radius, tolerance, ..options.clone() };
        return Ok(in_unit(&mesh, &options, scale.length(rounding), context)?.in_scale(scale.back()));
    }
    in_unit(mesh, options, rounding, context)
}

/// [`segment`] for a mesh whose size is about one and whose vertices are rounded to `rounding`.
fn in_unit(mesh: &SurfaceMesh, options: &SegmentOptions, rounding: f64, context: &Context) -> Result<Segmentation> {
    let canonical = Canonical::new(Triangles::of(mesh).ok_or_else(polygons)?)?;
    let found = without_slivers(&canonical.mesh, &canonical.options(options), rounding, context)?;
    Ok(canonical.restore(found))
}

fn polygons() -> Error {
    Error::Bug("triangles became polygons".into())
}

/// The regions of a mesh whose slivers were taken out, as regions of the mesh.
fn without_slivers(
    mesh: &SurfaceMesh,
    options: &SegmentOptions,
    rounding: f64,
    context: &Context,
) -> Result<Segmentation> {
    let triangles = Triangles::of(mesh).ok_or_else(polygons)?;
    let healed = if options.surfaces { heal::heal(mesh, triangles, context)? } else { None };
    let Some(healed) = healed else { return in_order_of_place(mesh, options, rounding, context) };
    let inside = Canonical::new(Triangles::of(&healed.mesh).ok_or_else(polygons)?)?;
    let labels = options.labels.as_ref().map(|labels| healed.project(labels));
    let options = SegmentOptions { labels, ..options.clone() };
    let found = inside.restore(in_order_of_place(&inside.mesh, &inside.options(&options), rounding, context)?);
    let surface = Surface::new(mesh, triangles);
    let label = healed.restore(&surface, &found.labels);
    let order: Vec<u32> = (0..surface.len() as u32).collect();
    let angle = found.chosen.sharp_angle_deg.to_radians();
    let known = Known::of(&label, |l| found.regions.get(l as usize).and_then(|region| region.primitive), true);
    let sharp = Sharp::new(&surface, angle);
    let segmenter =
        Segmenter { surface: &surface, order: &order, options: &options, context, sharp, angle, rounding, known };
    let curvature = segmenter.curvature(triangles, &segmenter.sharp.edge)?;
    segmenter.finish(label, &curvature, found.dendrogram, found.chosen)
}

/// Segments a mesh by visiting its triangles in the order of their numbers.
fn in_order_of_place(
    mesh: &SurfaceMesh,
    options: &SegmentOptions,
    rounding: f64,
    context: &Context,
) -> Result<Segmentation> {
    let triangles = Triangles::of(mesh).ok_or_else(polygons)?;
    let surface = {
        let _stage = context.stage("sharp edges");
        Surface::new(mesh, triangles)
    };
    let order: Vec<u32> = (0..surface.len() as u32).collect();
    let angle = match options.sharp_angle {
        Some(degrees) => degrees.to_radians(),
        None => surface::sharp_angle(&surface, context)?,
    };
    Segmenter {
        surface: &surface,
        order: &order,
        options,
        context,
        sharp: Sharp::new(&surface, angle),
        angle,
        rounding,
        known: Known::default(),
    }
    .run()
}

/// The inputs of all stages.
struct Segmenter<'a> {
    surface: &'a Surface<'a>,
    order: &'a [u32],
    options: &'a SegmentOptions,
    context: &'a Context,
    sharp: Sharp,
    angle: f64,
    /// What coordinates are rounded to; 0 where they are binary.
    rounding: f64,
    /// The surface that every triangle was given.
    known: Known,
}

impl Segmenter<'_> {
    fn run(mut self) -> Result<Segmentation> {
        let scale = self.scale();
        let extent = self.surface.extent();
        let tolerance = self.options.tolerance.unwrap_or(self.rounding.max(EXACT_TOLERANCE * extent));
        let mut chosen = Chosen {
            basis: Basis::Labels,
            sharp_angle_deg: self.angle.to_degrees(),
            clusters: 0,
            merge_threshold: 0.0,
            scale,
            tolerance,
            recognised: 0.0,
            noise: 0.0,
            rectified: 0,
        };
        let mut dendrogram = Dendrogram::default();
        let start = self.start(extent, &mut chosen)?;
        if start.is_none() && self.options.surfaces && self.options.sharp_angle.is_none() {
            self.angle = surface::noisy_sharp_angle(self.surface, SCAN_BENDS).clamp(self.angle, SCAN_SHARPEST);
            self.sharp = Sharp::new(self.surface, self.angle);
            chosen.sharp_angle_deg = self.angle.to_degrees();
        }
        let curvature = self.curvature(self.surface.triangles, &self.sharp.edge)?;
        let mut label = match start {
            Some(label) => label,
            None => {
                let found = self.by_curvature(&curvature, scale)?;
                (chosen.basis, chosen.clusters, chosen.merge_threshold) =
                    (Basis::Curvature, found.clusters, found.threshold);
                dendrogram = found.dendrogram;
                let mut label = found.label;
                // Boundaries are corrected in the order of the regions: not one of place.
                regions::by_size(self.surface, &mut label, self.order);
                label
            }
        };
        chosen.rectified = self.rectify(&mut label, &curvature, &chosen)?;
        self.finish(label, &curvature, dendrogram, chosen)
    }

    /// Given labels, or those of the surfaces of a part; `None` where there are neither.
    fn start(&mut self, extent: f64, chosen: &mut Chosen) -> Result<Option<Vec<u32>>> {
        if let Some(labels) = &self.options.labels {
            return Ok(Some(regions::dense(labels)));
        }
        if !self.options.surfaces {
            return Ok(None);
        }
        let _stage = self.context.stage("surfaces");
        let lengths = [extent, self.rounding];
        let mut found =
            surfaces::find(self.surface, self.order, lengths, self.angle, self.options.tolerance, self.context)?;
        chosen.recognised = found.share(self.surface);
        {
            let _stage = self.context.stage("surfaces with noise");
            let before = noisy::Before { exact: &found, share: chosen.recognised, tolerance: self.options.tolerance };
            if let Some(noisy) = noisy::find(self.surface, self.order, &before, self.context)? {
                return Ok(Some(self.take_noisy(noisy, chosen)));
            }
        }
        if chosen.recognised < surfaces::PART_SHARE {
            chosen.recognised = 0.0;
            return Ok(None);
        }
        chosen.basis = Basis::Surfaces;
        found.free_weak(self.surface);
        self.known = Known::of(&found.label, |l| found.primitives.get(l as usize).copied(), false);
        Ok(Some(found.complete(self.surface, self.order, self.angle)))
    }

    fn take_noisy(&mut self, found: noisy::Noisy, chosen: &mut Chosen) -> Vec<u32> {
        if !found.primitives.is_empty() {
            self.known = Known::of(&found.label, |l| found.primitives.get(l as usize).copied(), true);
        }
        chosen.basis = Basis::Surfaces;
        chosen.recognised = found.share;
        chosen.noise = found.sigma;
        if self.options.tolerance.is_none() {
            chosen.tolerance = found.tolerance();
        }
        found.label
    }

    fn scale(&self) -> f64 {
        let (low, high) = self.surface.mesh.bounds();
        match self.options.scale {
            Scale::LargestSide => (high - low).max_element(),
            Scale::RootArea => 0.673 * self.surface.total_area.sqrt(),
        }
    }

    fn curvature(&self, triangles: Triangles<'_>, sharp: &[bool]) -> Result<Curvature> {
        let _stage = self.context.stage("curvature");
        let options = CurvatureOptions { estimator: self.options.estimator, radius: self.options.radius };
        curvature(triangles, sharp, &options, self.context)
    }

    /// The paper's regions, on the enriched mesh where enrichment is needed.
    fn by_curvature(&self, curvature: &Curvature, scale: f64) -> Result<CurvatureRegions> {
        let Some(enriched) = enrich::enrich(self.surface, &self.sharp)? else {
            return self.regions_on(self.surface, &self.sharp, curvature, scale, self.order);
        };
        let Some(triangles) = Triangles::of(&enriched.mesh) else {
            return Err(Error::Bug("enrichment made a polygon".into()));
        };
        let surface = Surface::enriched(self.surface, &enriched, triangles);
        let sharp = Sharp::new(&surface, self.angle);
        let curvature = match enriched.surroundings()? {
            // In a ball there is more than the surroundings.
            Some(part) if self.options.estimator != Estimator::NormalCycleBall => {
                let Some(triangles) = Triangles::of(&part.mesh) else {
                    return Err(Error::Bug("enrichment made a polygon".into()));
                };
                part.put_into(curvature, &self.curvature(triangles, &part.of_corners(&sharp.edge))?)
            }
            _ => self.curvature(surface.triangles, &sharp.edge)?,
        };
        let order = surface.canonical_order();
        let found = self.regions_on(&surface, &sharp, &curvature, scale, &order)?;
        Ok(CurvatureRegions { label: enriched.project(&found.label, self.surface.len()), ..found })
    }

    fn regions_on(
        &self,
        surface: &Surface<'_>,
        sharp: &Sharp,
        curvature: &Curvature,
        scale: f64,
        order: &[u32],
    ) -> Result<CurvatureRegions> {
        // A mesh that was asked for surfaces and has none is a scan: its creases and the variation of curvature from vertex
        // to vertex are noise.
        let scan = self.options.surfaces;
        let demand = Demand {
            clusters: self.options.clusters.map(|k| k as usize).or(scan.then_some(SCAN_CLUSTERS)),
            threshold: self.options.merge_threshold,
            regions: self.options.regions.map(|n| n as usize),
            min_area: if scan { self.options.min_area.max(SCAN_AREA) } else { self.options.min_area },
            min_area_across_creases: if scan { SCAN_AREA } else { self.options.min_area / CREASE_DIVISOR },
            smoothing: if scan { SCAN_SMOOTHING } else { 0 },
        };
        // Only creases ask for it.
        let full = full_magnitudes(surface.triangles, &sharp.vertex, self.context)?;
        curvature_regions(surface, sharp, curvature, &full, scale, order, &demand, self.context)
    }

    /// Corrects the boundaries; returns how many triangles changed. Boundaries between recognised surfaces are exact.
    fn rectify(&self, label: &mut Vec<u32>, curvature: &Curvature, chosen: &Chosen) -> Result<usize> {
        if self.options.rectify == Rectify::None || chosen.basis == Basis::Surfaces {
            return Ok(0);
        }
        let _stage = self.context.stage("rectification");
        let scores = Scores { surface: self.surface, sharp: &self.sharp, curvature, scale: chosen.scale };
        let before = label.clone();
        if self.options.rectify == Rectify::Paper {
            *label = contour::follow(self.surface, &scores, label, self.options.score_threshold, self.context)?;
        } else {
            let prices = Prices::new(self.surface, label, curvature, chosen);
            let price = |t: u32, l: u32| prices.of(t, l);
            let guard = chosen.basis == Basis::Labels;
            let moved = cut::cut(
                self.surface,
                &scores,
                &self.sharp.edge,
                label,
                &price,
                RECTIFICATION_ROUNDS,
                guard,
                self.context,
            )?;
            if !guard && moved > 0 {
                // A cut may have parted a region outside of its band; the smaller parts go to their neighbours.
                regions::keep_largest_parts(self.surface, label, self.order);
                growth::fill(self.surface, &vec![false; 3 * label.len()], label, self.context)?;
            }
        }
        Ok(before.iter().zip(label.iter()).filter(|(a, b)| a != b).count())
    }

    /// Connected, numbered regions with their surfaces and boundaries.
    fn finish(
        &self,
        label: Vec<u32>,
        curvature: &Curvature,
        dendrogram: Dendrogram,
        chosen: Chosen,
    ) -> Result<Segmentation> {
        let _stage = self.context.stage("fit");
        let mut labels = regions::connected(self.surface, &label, self.order);
        let count = regions::by_size(self.surface, &mut labels, self.order);
        let groups = Groups::new(&labels, count);
        // Where surfaces were looked for and there are none, a region on a curved one is a few triangles that happen to fit.
        let scan = chosen.basis == Basis::Curvature && self.options.surfaces && self.options.tolerance.is_none();
        let kinds: &[Kind] = if scan { &[Kind::Plane] } else { &Kind::ALL };
        let fits: Vec<Option<Fit>> = (0..count as u32)
            .into_par_iter()
            .map(|l| self.known.fit(self.surface, groups.of(l), chosen.tolerance, kinds))
            .collect();
        self.context.check()?;
        let boundaries = boundaries::boundaries(self.surface, &labels, &self.sharp.edge);
        let regions = regions::describe(self.surface, &groups, &boundaries, curvature, &fits);
        let junctions = junctions::junctions(self.surface, &labels, &regions, &boundaries);
        Ok(Segmentation { labels, regions, boundaries, junctions, dendrogram, chosen })
    }
}
