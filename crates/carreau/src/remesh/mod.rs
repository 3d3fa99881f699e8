//! Room 2: enrich and simplify to an angle.
//!
//! Borouchaki, Frey: *Maillage géométrique de surfaces. Partie II : appauvrissement*, INRIA RR-3237, 1997; its first part,
//! enrichment, is not public and reconstructed here. A mesh is geometric when all its edges have length one in the metric
//! of the surface: the size at a point is h = α r, α = 2 sin θ, r the smallest principal radius.
//!
//! | stage | file | paper |
//! |---|---|---|
//! | edges that stay | `features`, `curves` | §4.5, §4.7 |
//! | the surface: normals, radii, walking | `support` | Part I |
//! | size map, gradation, lengths | `size` | §3, remark; H-shock |
//! | the mesh at work | `work` | – |
//! | collapses under constraints (1), (2), (4) | `decimate` | §3 |
//! | splits of long edges | `divide` | Part I |
//! | flips | `swap` | §2 |
//! | edges keep their nature | `creases` | – |
//! | relocation | `relocate` | §3, "bougé de points" |
//! | the worst first | `polish` | – |
//! | the order of all this | `adapt` | §3 |
//! | a wanted number of triangles | `target` | – |
//! | shapes left aside: least error first | `geometric` | – |
//! | the result, attributes | `output`, `transfer` | – |
//! | figures | `quality` | §4 |

mod adapt;
mod creases;
mod curves;
mod decimate;
mod divide;
mod features;
mod geometric;
mod output;
mod polish;
mod quality;
mod relocate;
mod size;
mod support;
mod swap;
mod target;
#[cfg(test)]
mod tests;
mod transfer;
mod work;

use crate::context::Context;
use crate::error::{Error, Result};
use crate::geometry::distance::{DistanceOptions, compare};
use crate::mesh::{Column, CornerId, EditMesh, RepairOptions, Side, SurfaceMesh, area_vector, repair, safe_length};
use creases::Dihedral;
use curves::{Curves, Kind};
use geometric::{Geometric, Goal};
use output::Made;
use serde::{Deserialize, Serialize};
use support::{Radius, Support};
use work::{Limits, Work};

pub use quality::RemeshQuality;

/// Options of [`enrich`] and [`simplify`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct RemeshOptions {
    /// θ: the angle between edges and the surface, in degrees.
    pub deviation: f64,
    /// β: largest ratio of sizes over one unit of length; `None`: not controlled.
    pub gradation: Option<f64>,
    /// Edges whose face normals differ by more are ridges, in degrees; 180: none.
    pub feature_angle: f64,
    /// Edges tagged in the file are ridges.
    pub tags: bool,
    /// A face property of integers: edges between two values are ridges.
    pub labels: Option<String>,
    /// Smallest size, as a share of the diagonal.
    #[serde(skip)]
    pub min_size: f64,
    /// Largest size, as a share of the diagonal.
    #[serde(skip)]
    pub max_size: f64,
    /// How far ridges may move, as a share of the diagonal.
    pub ridge_tolerance: f64,
    /// Factor on the sizes.
    pub scale: f64,
    /// A wanted number of triangles, met within 1 %: the sizes are scaled.
    pub triangles: Option<usize>,
    /// Largest distance from the source, in the unit of the file: the sizes are scaled until a bound of it is below.
    #[serde(skip)]
    pub distance: Option<f64>,
    /// Enriches to this angle first, in degrees.
    pub enrich: Option<f64>,
    /// Shapes and lengths are left aside: the collapses of least error, into the best points.
    pub geometric: bool,
}

impl Default for RemeshOptions {
    fn default() -> Self {
        RemeshOptions {
            deviation: 14.0,
            gradation: Some(1.5),
            feature_angle: 35.0,
            tags: true,
            labels: None,
            min_size: 2e-4,
            max_size: 0.2,
            ridge_tolerance: 4.5e-4,
            scale: 1.0,
            triangles: None,
            distance: None,
            enrich: None,
            geometric: false,
        }
    }
}

impl RemeshOptions {
    fn check(&self) -> Result<()> {
        if !(self.deviation > 0.0 && self.deviation < 90.0) {
            return Err(Error::Options(format!(
                "deviation is {}, it must be an angle between 0 and 90 degrees",
                self.deviation
            )));
        }
        if self.gradation.is_some_and(|b| !(b > 1.0 && b <= 1e6)) {
            return Err(Error::Options("gradation must be above 1, or off".into()));
        }
        Ok(())
    }
}

/// A mesh with its sizes and figures.
#[derive(Debug, Clone)]
pub struct Remeshed {
    /// The mesh, with the vertex property `size`.
    pub mesh: SurfaceMesh,
    /// What was achieved.
    pub quality: RemeshQuality,
    /// What was repaired before, and what could not be reached, one sentence each.
    pub repaired: Vec<String>,
}

/// Coarsens a surface to an angular deviation, a number of triangles or a distance.
///
/// ```
/// use carreau::{Context, remesh, sample};
/// let context = Context::new();
/// let mesh = sample::make("torus", None, &context)?;
/// let options = remesh::RemeshOptions { deviation: 20.0, ..Default::default() };
/// let result = remesh::simplify(&mesh, &options, &context)?;
/// assert!(result.mesh.face_count() < mesh.face_count() && result.quality.shape_min > 0.3);
/// # Ok::<(), carreau::Error>(())
/// ```
///
/// # Errors
/// [`Error::Options`] for options out of range, [`Error::Input`] for a mesh without faces, [`Error::Numeric`] where a
/// distance cannot be reached, [`Error::Cancelled`], [`Error::Deadline`].
pub fn simplify(mesh: &SurfaceMesh, options: &RemeshOptions, context: &Context) -> Result<Remeshed> {
    options.check()?;
    let (cleaned, mut repaired) = clean(mesh, context)?;
    let enriched = match options.enrich {
        Some(deviation) => {
            let first = RemeshOptions { deviation, enrich: None, triangles: None, distance: None, ..options.clone() };
            enrich(&cleaned, &first, context)?.mesh
        }
        None => cleaned,
    };
    let mut source = Source::new(&enriched, options, context)?;
    let out = match (options.distance, options.triangles) {
        _ if options.geometric => least_error(mesh, &enriched, &mut source, options, context)?,
        (Some(distance), _) => within_distance(mesh, &enriched, &mut source, options, distance, context)?,
        (None, Some(wanted)) => {
            let mut aim = wanted as f64;
            let mut best: Option<SurfaceMesh> = None;
            let miss = |m: &SurfaceMesh| m.face_count().abs_diff(wanted);
            for _ in 0..TARGET_RUNS {
                let scale = target::find_scale(&mut source, options, aim, context)?;
                let options = RemeshOptions { scale, ..options.clone() };
                source.set_sizes(&options, context)?;
                let (out, natural) = run_counted(&enriched, &source, &options, context)?;
                if best.as_ref().is_none_or(|b| miss(&out) <= miss(b)) {
                    best = Some(out);
                }
                let ratio = natural as f64 / wanted as f64;
                if (ratio - 1.0).abs() < TARGET_SLACK {
                    break;
                }
                aim /= ratio;
            }
            best.ok_or_else(|| Error::Bug("no run".into()))?
        }
        (None, None) => {
            source.set_sizes(options, context)?;
            run(&enriched, &source, options, false, context)?
        }
    };
    if let Some(wanted) = options.triangles.filter(|&n| out.face_count().abs_diff(n) as f64 > 0.01 * n as f64) {
        let reached = out.face_count();
        repaired.push(format!("{wanted} triangles were asked for, the curves and the surface allow {reached}"));
    }
    let quality = quality::measure(&out, &sizes(&out))?;
    Ok(Remeshed { mesh: out, quality, repaired })
}

/// Refines a surface to an angular deviation: long edges are split, with the new vertices on curved patches.
///
/// # Errors
/// As [`simplify`].
pub fn enrich(mesh: &SurfaceMesh, options: &RemeshOptions, context: &Context) -> Result<Remeshed> {
    options.check()?;
    let (mesh, repaired) = clean(mesh, context)?;
    let mut source = Source::new(&mesh, options, context)?;
    source.set_sizes(options, context)?;
    let out = run(&mesh, &source, options, true, context)?;
    let quality = quality::measure(&out, &sizes(&out))?;
    Ok(Remeshed { mesh: out, quality, repaired })
}

/// Runs with a corrected scale until the natural count is so near to the wanted one that trimming does no harm.
const TARGET_RUNS: usize = 5;
const TARGET_SLACK: f64 = target::WITHIN;

/// Adapts and trims; returns the number of triangles before trimming, too.
fn run_counted(
    mesh: &SurfaceMesh,
    source: &Source,
    options: &RemeshOptions,
    context: &Context,
) -> Result<(SurfaceMesh, usize)> {
    let mut work = Work::new(&source.support, &source.curves, source.limits(options));
    work.adapt(context)?;
    let natural = work.mesh.triangle_count();
    if let Some(wanted) = options.triangles {
        work.trim(wanted, context)?;
    }
    Ok((source.finish(mesh, &work)?, natural))
}

/// Adapts the source to its size map.
fn run(
    mesh: &SurfaceMesh,
    source: &Source,
    options: &RemeshOptions,
    curved: bool,
    context: &Context,
) -> Result<SurfaceMesh> {
    let mut work = Work::new(&source.support, &source.curves, source.limits(options));
    work.curved = curved;
    work.adapt(context)?;
    source.finish(mesh, &work)
}

/// How closely a distance is looked at where it is a promise: what counts is the upper bound.
const CLOSE_LOOK: DistanceOptions = DistanceOptions { samples: 20_000, refinements: 200_000 };
/// Runs of [`within_distance`] before it gives up.
const DISTANCE_RUNS: usize = 8;

/// The coarsest mesh of a few whose two-sided distance from the input is certainly below a limit.
fn within_distance(
    input: &SurfaceMesh,
    mesh: &SurfaceMesh,
    source: &mut Source,
    options: &RemeshOptions,
    limit: f64,
    context: &Context,
) -> Result<SurfaceMesh> {
    let mut scale = options.scale;
    let mut best: Option<(f64, SurfaceMesh)> = None;
    let mut too_large = f64::INFINITY;
    for _ in 0..DISTANCE_RUNS {
        let options = RemeshOptions { scale, triangles: None, ..options.clone() };
        source.set_sizes(&options, context)?;
        let out = run(mesh, source, &options, false, context)?;
        let distance = compare(input, &out, &CLOSE_LOOK, context)?.distance.max_upper;
        if distance <= limit {
            let reached = distance > 0.8 * limit || too_large < 1.15 * scale;
            best = Some((scale, out));
            if reached {
                break;
            }
        } else {
            too_large = too_large.min(scale);
        }
        // The sag grows with the square of the size.
        let wanted = scale * (0.9 * limit / distance.max(f64::MIN_POSITIVE)).sqrt().clamp(0.2, 4.0);
        let low = best.as_ref().map_or(0.0, |b| b.0);
        let between = if low > 0.0 { (low * too_large).sqrt() } else { 0.7 * too_large };
        scale = if wanted < too_large && wanted > low { wanted } else { between };
        if !scale.is_finite() || scale > 1e3 {
            break;
        }
    }
    best.map(|b| b.1).ok_or_else(|| out_of_reach(limit))
}

/// Halvings of the error in [`least_error`] in search of a distance.
const ERROR_RUNS: usize = 10;

/// The purely geometric mode. With a distance the error to stop at is found by halving: the order of the collapses does not
/// depend on it, so that every run is the beginning of the next coarser one.
fn least_error(
    input: &SurfaceMesh,
    mesh: &SurfaceMesh,
    source: &mut Source,
    options: &RemeshOptions,
    context: &Context,
) -> Result<SurfaceMesh> {
    source.set_sizes(options, context)?;
    let _stage = context.stage("decimate");
    let theta = options.deviation.to_radians();
    let with_target = options.triangles.is_some() || options.distance.is_some();
    let mut goal = Goal {
        triangles: options.triangles.unwrap_or(0),
        error: f64::INFINITY,
        cosine: if with_target { -1.0 } else { theta.cos() },
    };
    let run = |goal: &Goal| {
        let mut work = Geometric::new(&source.support, &source.curves);
        work.run(goal, context)?;
        let seat = |corner: u32| work.mesh.source[corner as usize / 3];
        let size = |v: u32| source.support.size[v as usize];
        output::assemble(mesh, &source.support, &Made { mesh: &work.mesh, seat: &seat, size: &size })
    };
    let Some(limit) = options.distance else { return run(&goal) };
    let (mut low, mut high) = (0.0, 2.0 * limit);
    let mut best = None;
    for _ in 0..ERROR_RUNS {
        goal.error = if low == 0.0 { 0.5 * high } else { 0.5 * (low + high) };
        let out = run(&goal)?;
        let distance = compare(input, &out, &CLOSE_LOOK, context)?.distance.max_upper;
        if distance <= limit {
            best = Some(out);
            low = goal.error;
            if distance > 0.95 * limit {
                break;
            }
        } else {
            high = goal.error;
        }
    }
    best.ok_or_else(|| out_of_reach(limit))
}

fn out_of_reach(limit: f64) -> Error {
    Error::Numeric(format!("no mesh within the distance {limit} was found; enrich first, or allow more"))
}

fn sizes(mesh: &SurfaceMesh) -> Vec<f64> {
    match mesh.attributes.vertex.get("size") {
        Some(Column::Scalar(size)) => size.clone(),
        _ => vec![1.0; mesh.vertex_count()],
    }
}

/// The source with everything that does not depend on the angle.
struct Source {
    support: Support,
    curves: Curves,
    /// Smallest principal radius at every vertex.
    radius: Vec<Radius>,
    /// Radius of the curves at every vertex of rank curve.
    curve_radius: Vec<f64>,
    diagonal: f64,
    /// There is noise to take out.
    noisy: bool,
}

impl Source {
    fn new(mesh: &SurfaceMesh, options: &RemeshOptions, context: &Context) -> Result<Self> {
        let _stage = context.stage("support");
        if mesh.faces().is_empty() {
            return Err(Error::input("the mesh has no faces", "", ""));
        }
        let features::Reading { marks, noisy } = features::read(mesh, options)?;
        let mut edit = EditMesh::new(mesh).ok_or_else(|| Error::Bug("polygons in a triangulated mesh".into()))?;
        // Borders are read at the scale of the size map, which is known only roughly before the curves are.
        let scale = vec![0.01 * mesh.diagonal(); edit.vertex_slots() as usize];
        let mut curves = Curves::trace(&mut edit, &marks, &scale);
        curves.find_sharp(&edit, options.feature_angle.to_radians().cos());
        let support = Support::new(edit);
        let radius = support.radii(&curves.rank);
        let curve_radius = curve_radii(&curves, radius.len());
        Ok(Source { support, curves, radius, curve_radius, diagonal: mesh.diagonal(), noisy })
    }

    /// The size map of the options, graded; normals and points fitted at its scale.
    fn set_sizes(&mut self, options: &RemeshOptions, context: &Context) -> Result<()> {
        self.set_size_map(options, context)?;
        self.support.fit_normals(0.5, 6);
        if self.noisy {
            self.support.fit_points(&self.curves.rank, 1.0, 0.1);
        }
        Ok(())
    }

    /// The size map alone.
    fn set_size_map(&mut self, options: &RemeshOptions, context: &Context) -> Result<()> {
        let _stage = context.stage("size map");
        let alpha = 2.0 * options.deviation.to_radians().sin() * options.scale;
        let (low, high) = (options.min_size * self.diagonal, options.max_size * self.diagonal);
        let tolerance = options.ridge_tolerance * self.diagonal;
        let size = |v: usize, radius: f64| {
            let r = self.curve_radius[v];
            // The sag of an arc is its squared chord over eight radii.
            let on_curve = (alpha * r).min((8.0 * r * tolerance).sqrt());
            (alpha * radius).min(on_curve).clamp(low, high)
        };
        self.support.size = self.radius.iter().enumerate().map(|(v, r)| size(v, r.at_scale(alpha))).collect();
        if let Some(beta) = options.gradation {
            size::grade(&self.support.mesh, &mut self.support.size, beta, context)?;
        }
        Ok(())
    }

    /// What was adapted, as a surface mesh.
    fn finish(&self, mesh: &SurfaceMesh, work: &Work) -> Result<SurfaceMesh> {
        let seat = |corner: u32| work.seat[work.mesh.wedge(corner) as usize];
        let size = |v: u32| work.size[v as usize] / work.scale;
        output::assemble(mesh, &self.support, &Made { mesh: &work.mesh, seat: &seat, size: &size })
    }

    fn limits(&self, options: &RemeshOptions) -> Limits {
        // The angle that the scaled sizes stand for.
        let theta = (options.deviation.to_radians().sin() * options.scale).min(0.9).asin();
        let on_sphere = (2.0 * theta.sin() / 3f64.sqrt()).min(0.95).asin();
        // Noise needs room; clean models do without.
        let (least, most, cap) = if self.noisy { (45.0, 60.0, 60.0) } else { (10.0, 20.0, 25.0) };
        let allowed = (1.25 * on_sphere).clamp(f64::to_radians(least), f64::to_radians(most));
        Limits {
            cos_allowed: allowed.cos(),
            cos_cap: f64::to_radians(cap).cos(),
            curve_sag_share: (0.75 * (0.5 * theta).tan()).max(0.12),
            ridge_sag: options.ridge_tolerance * self.diagonal,
            border_sag: f64::INFINITY,
            dihedral: (!self.noisy && options.feature_angle < 180.0).then(|| Dihedral::within(options.feature_angle)),
        }
    }
}

/// Radius of the circle through each curve vertex and its two neighbours on the curve.
fn curve_radii(curves: &Curves, vertices: usize) -> Vec<f64> {
    let mut radius = vec![f64::INFINITY; vertices];
    for chain in curves.chains.iter().filter(|c| c.kind != Kind::Seam) {
        let n = chain.points.len();
        let mut at = |v: u32, a: glam::DVec3, b: glam::DVec3, c: glam::DVec3| {
            let sine = (b - a).cross(c - b).length();
            let r = a.distance(b) * b.distance(c) * a.distance(c) / (2.0 * sine).max(f64::MIN_POSITIVE);
            radius[v as usize] = radius[v as usize].min(r);
        };
        for k in 1..n - 1 {
            at(chain.vertices[k], chain.points[k - 1], chain.points[k], chain.points[k + 1]);
        }
        if chain.closed && n > 2 {
            at(chain.vertices[0], chain.points[n - 2], chain.points[0], chain.points[1]);
        }
    }
    radius
}

/// Repairs what needs it: degenerate and repeated faces, inconsistent senses. A sound mesh is only copied.
fn clean(mesh: &SurfaceMesh, context: &Context) -> Result<(SurfaceMesh, Vec<String>)> {
    let _stage = context.stage("clean");
    let mesh = mesh.clone().triangulated()?;
    let diagonal = mesh.diagonal();
    let flat = |f: &[u32]| safe_length(area_vector(mesh.points(), f)) <= 1e-12 * diagonal * diagonal;
    let irregular = |c: usize| matches!(mesh.side(CornerId::new(c)), Side::Inconsistent | Side::NonManifold);
    let pillow = |f: usize| {
        let across = |k: usize| mesh.opposite(CornerId::new(3 * f + k)).map(|o| mesh.face_of(o));
        across(0).is_some() && across(0) == across(1) && across(1) == across(2)
    };
    let needed =
        mesh.faces().iter().any(flat) || (0..mesh.corner_count()).any(irregular) || (0..mesh.face_count()).any(pillow);
    if !needed {
        return Ok((mesh, Vec::new()));
    }
    let options = RepairOptions { weld: None, split: false, outward: false, ..RepairOptions::default() };
    let repaired = repair(&mesh, &options, context)?;
    let said = repaired.report.sentences();
    Ok((repaired.mesh.triangulated()?, said))
}
