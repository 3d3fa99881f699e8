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
//! | relocation | `relocate` | §3, "bougé de points" |
//! | the worst first | `polish` | – |
//! | the order of all this | `adapt` | §3 |
//! | a wanted number of triangles | `target` | – |
//! | attributes | `transfer` | – |
//! | figures | `quality` | §4 |

mod adapt;
mod curves;
mod decimate;
mod divide;
mod features;
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
use crate::mesh::{
    Column, CornerId, EditMesh, NONE, RepairOptions, Side, SurfaceMesh, area_vector, gather_columns, repair,
    safe_length,
};
use curves::{Curves, Kind};
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
    /// What was repaired before, one sentence each.
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
    let (cleaned, repaired) = clean(mesh, context)?;
    let enriched = match options.enrich {
        Some(deviation) => {
            let first = RemeshOptions { deviation, enrich: None, triangles: None, distance: None, ..options.clone() };
            enrich(&cleaned, &first, context)?.mesh
        }
        None => cleaned,
    };
    let mut source = Source::new(&enriched, options, context)?;
    let out = match (options.distance, options.triangles) {
        (Some(distance), _) => within_distance(mesh, &enriched, &mut source, options, distance, context)?,
        (None, Some(wanted)) => {
            let mut aim = wanted as f64;
            let mut best: Option<SurfaceMesh> = None;
            let miss = |m: &SurfaceMesh| m.face_count().abs_diff(wanted);
            for _ in 0..TARGET_RUNS {
                let scale = target::find_scale(&mut source, options, aim, context)?;
                let options = RemeshOptions { scale, ..options.clone() };
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
const TARGET_RUNS: usize = 6;
const TARGET_SLACK: f64 = 0.008;

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
    Ok((finish(mesh, source, &work)?, natural))
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
    finish(mesh, source, &work)
}

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
    let look = DistanceOptions { samples: 20_000, refinements: 200_000 };
    for _ in 0..DISTANCE_RUNS {
        let options = RemeshOptions { scale, triangles: None, ..options.clone() };
        source.set_sizes(&options, context)?;
        let out = run(mesh, source, &options, false, context)?;
        let distance = compare(input, &out, &look, context)?.distance.max_upper;
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
    best.map(|b| b.1).ok_or_else(|| {
        Error::Numeric(format!("no mesh within the distance {limit} was found; enrich first, or allow more"))
    })
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
    is_scan: bool,
}

impl Source {
    fn new(mesh: &SurfaceMesh, options: &RemeshOptions, context: &Context) -> Result<Self> {
        let _stage = context.stage("support");
        if mesh.faces().is_empty() {
            return Err(Error::input("the mesh has no faces", "", ""));
        }
        let marks = features::mark(mesh, options)?;
        let mut edit = EditMesh::new(mesh).ok_or_else(|| Error::Bug("polygons in a triangulated mesh".into()))?;
        // Borders are read at the scale of the size map, which is known only roughly before the curves are.
        let scale = vec![0.01 * mesh.diagonal(); edit.vertex_slots() as usize];
        let curves = Curves::trace(&mut edit, &marks, &scale);
        let support = Support::new(edit);
        let radius = support.radii(&curves.rank);
        let curve_radius = curve_radii(&curves, radius.len());
        Ok(Source {
            support,
            curves,
            radius,
            curve_radius,
            diagonal: mesh.diagonal(),
            is_scan: features::is_scan(mesh)?,
        })
    }

    /// The size map of the options, graded; normals fitted at its scale.
    fn set_sizes(&mut self, options: &RemeshOptions, context: &Context) -> Result<()> {
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
        self.support.fit_normals(0.5, 6);
        if self.is_scan {
            self.support.fit_points(&self.curves.rank, 1.0, 0.1);
        }
        Ok(())
    }

    fn limits(&self, options: &RemeshOptions) -> Limits {
        // The angle that the scaled sizes stand for.
        let theta = (options.deviation.to_radians().sin() * options.scale).min(0.9).asin();
        let on_sphere = (2.0 * theta.sin() / 3f64.sqrt()).min(0.95).asin();
        // Noise needs room; clean models do without.
        let (least, most, cap) = if self.is_scan { (45.0, 60.0, 60.0) } else { (10.0, 20.0, 25.0) };
        let allowed = (1.25 * on_sphere).clamp(f64::to_radians(least), f64::to_radians(most));
        Limits {
            cos_allowed: allowed.cos(),
            cos_cap: f64::to_radians(cap).cos(),
            curve_sag_share: (0.75 * (0.5 * theta).tan()).max(0.12),
            ridge_sag: options.ridge_tolerance * self.diagonal,
            border_sag: f64::INFINITY,
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

/// The result as a surface mesh: cut vertices are joined again, face attributes follow their triangle.
fn finish(mesh: &SurfaceMesh, source: &Source, work: &Work) -> Result<SurfaceMesh> {
    let compact = work.mesh.compact();
    let mut first = vec![NONE; mesh.vertex_count()];
    let mut id = vec![0u32; compact.vertices.len()];
    let mut kept = Vec::new();
    for (k, &v) in compact.vertices.iter().enumerate() {
        let origin = work.mesh.origin[v as usize];
        let known = if origin == NONE { NONE } else { first[origin as usize] };
        id[k] = if known != NONE { known } else { kept.len() as u32 };
        if known == NONE {
            if origin != NONE {
                first[origin as usize] = kept.len() as u32;
            }
            kept.push(v);
        }
    }
    let faces: Vec<[u32; 3]> = compact.faces.iter().map(|f| f.map(|v| id[v as usize])).collect();
    let points = kept.iter().map(|&v| work.mesh.points[v as usize]).collect();
    let mut out = SurfaceMesh::from_triangles(points, &faces)?;
    if !mesh.attributes.face.is_empty() {
        let under = |&t: &u32| {
            let [a, b, c] = work.mesh.positions(t);
            source.support.locate(work.seat[work.mesh.wedge(3 * t) as usize], (a + b + c) / 3.0).0.triangle
        };
        let parents: Vec<u32> = compact.triangles.iter().map(under).collect();
        out.attributes.face = gather_columns(&mesh.attributes.face, &parents);
    }
    if !mesh.attributes.vertex.is_empty() {
        let seat = |&v: &u32| {
            let wedge = work.mesh.around(v).next().map_or(0, |h| work.mesh.wedge(h));
            source.support.locate(work.seat[wedge as usize], work.mesh.points[v as usize]).0
        };
        let seats: Vec<_> = kept.iter().map(seat).collect();
        out.attributes.vertex = transfer::at_seats(&mesh.attributes.vertex, &source.support, &seats);
    }
    out.attributes.names = mesh.attributes.names.clone();
    let size = kept.iter().map(|&v| work.size[v as usize] / work.scale).collect();
    out.attributes.vertex.insert("size".into(), Column::Scalar(size));
    Ok(out)
}
