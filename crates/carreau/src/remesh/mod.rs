//! Room 2: enrich and simplify to an angle.
//!
//! Borouchaki, Frey: *Maillage géométrique de surfaces. Partie II : appauvrissement*, INRIA RR-3237, 1997; its first part,
//! enrichment, is not public and reconstructed here. A mesh is geometric when all its edges have length one in the metric
//! of the surface: the size at a point is h = α r, α = 2 sin θ, r the smallest principal radius.
//!
//! | stage | file | paper |
//! |---|---|---|
//! | edges that stay | `features`, `fading`, `curves` | §4.5, §4.7 |
//! | the surface: normals, radii, walking | `support` | Part I |
//! | size map, gradation, lengths | `size` | §3, remark; H-shock |
//! | edges longer where the surface bends less | `anisotropy` | announced |
//! | the mesh at work | `work` | – |
//! | collapses under constraints (1), (2), (4) | `decimate` | §3 |
//! | splits of long edges | `divide` | Part I |
//! | flips | `swap` | §2 |
//! | edges keep their nature | `creases` | – |
//! | relocation | `relocate` | §3, "bougé de points" |
//! | the worst first | `polish` | – |
//! | the order of all this | `adapt` | §3 |
//! | a wanted number of triangles, a wanted distance | `search`, `target` | – |
//! | shapes left aside: least error first | `geometric` | – |
//! | the result, attributes | `output`, `transfer` | – |
//! | figures | `quality` | §4 |

mod adapt;
mod anisotropy;
mod creases;
mod curves;
mod decimate;
mod divide;
mod fading;
mod features;
mod fit;
mod geometric;
mod output;
mod polish;
mod quality;
mod relocate;
mod search;
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
use crate::mesh::{Column, CornerId, EditMesh, RepairOptions, Side, SurfaceMesh, area_vector, repair, safe_length};
use creases::Dihedral;
use curves::{Curves, Kind};
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
    /// Edges are longer where the surface bends less.
    pub anisotropic: bool,
    /// A vertex property of numbers: sizes are no larger than these, in the unit of the file.
    pub sizes: Option<String>,
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
            anisotropic: false,
            sizes: None,
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
        _ if options.geometric => search::least_error(mesh, &enriched, &mut source, options, context)?,
        (Some(distance), _) => search::within_distance(mesh, &enriched, &mut source, options, distance, context)?,
        (None, Some(wanted)) => search::to_count(&enriched, &mut source, options, wanted, context)?,
        (None, None) => {
            source.set_sizes(options, context)?;
            source.adapted(&enriched, options, false, context)?
        }
    };
    if let Some(wanted) = options.triangles.filter(|&n| out.face_count().abs_diff(n) as f64 > 0.01 * n as f64) {
        let reached = out.face_count();
        repaired.push(format!("{wanted} triangles were asked for, the curves and the surface allow {reached}"));
    }
    let quality = quality::measure(&out)?;
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
    let out = source.adapted(&mesh, options, true, context)?;
    let quality = quality::measure(&out)?;
    Ok(Remeshed { mesh: out, quality, repaired })
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
    /// Largest size at every vertex, where that was given.
    given: Option<Vec<f64>>,
}

/// Ridges get edges whose sag is this share of what they are allowed: there is room to move along the curve.
const SAG_SHARE: f64 = 0.7;
/// On clean models edges of the surface sag by no more than this many tolerances of the ridges.
const SURFACE_SAG: f64 = 4.0;
/// The same for stretched edges: along them normals change little, and the gap is what counts.
const STRETCHED_TILT: f64 = 0.1;
/// Corners of a ragged border are turns over so many sizes.
const BORDER_SCALE: f64 = 2.0;
/// Weight of the tilt of edges in the fit, where sin θ = 1: noise counts less the larger the sags are.
const TILT: f64 = 0.25;
/// Borders may be left by the sag of a circle of this radius, a share of the diagonal.
const BORDER_RADIUS: f64 = 0.07;

impl Source {
    fn new(mesh: &SurfaceMesh, options: &RemeshOptions, context: &Context) -> Result<Self> {
        let _stage = context.stage("support");
        if mesh.faces().is_empty() {
            return Err(Error::input("the mesh has no faces", "", ""));
        }
        let features::Reading { marks, noisy } = features::read(mesh, options)?;
        let mut edit = EditMesh::new(mesh).ok_or_else(|| Error::Bug("polygons in a triangulated mesh".into()))?;
        // Ragged borders are read at the scale of the size map, which is known only roughly before the curves are.
        let scale = vec![0.01 * mesh.diagonal(); edit.vertex_slots() as usize];
        let mut curves = Curves::trace(&mut edit, &marks, &scale);
        let sharp = options.feature_angle.to_radians().cos();
        curves.find_sharp(&edit, sharp);
        let support = Support::new(edit);
        let radius = support.radii(&curves.rank);
        let curve_radius = curves.radii(0.0);
        let given = given_sizes(mesh, &support.mesh, options)?;
        let mut source = Source { support, curves, radius, curve_radius, diagonal: mesh.diagonal(), noisy, given };
        if noisy && marks.contains(&Some(Kind::Border)) {
            source.set_size_map(options, context)?;
            let scale: Vec<f64> = source.support.size.iter().map(|h| BORDER_SCALE * h).collect();
            source.curves = Curves::trace(&mut source.support.mesh, &marks, &scale);
            source.curves.find_sharp(&source.support.mesh, sharp);
        }
        Ok(source)
    }

    /// The size map of the options, graded; normals and points fitted at its scale.
    fn set_sizes(&mut self, options: &RemeshOptions, context: &Context) -> Result<()> {
        self.support.stretch.clear();
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
        self.curve_radius = self.curves.radii(alpha);
        // Where a clean model is nearly flat an angle allows much: sizes follow the sag there.
        let sag = if self.noisy { f64::INFINITY } else { SURFACE_SAG * tolerance };
        let size = |v: usize, radius: f64| {
            let r = self.curve_radius[v];
            // The sag of an arc is its squared chord over eight radii.
            let on_curve = (alpha * r).min((8.0 * SAG_SHARE * r * tolerance).sqrt());
            let on_surface = (alpha * radius).min(options.scale * (8.0 * radius * sag).sqrt());
            let given = self.given.as_ref().map_or(f64::INFINITY, |given| options.scale * given[v]);
            on_surface.min(on_curve).min(given).clamp(low, high)
        };
        let mut radius: Vec<f64> = self.radius.iter().map(|r| r.at_scale(alpha)).collect();
        if self.noisy {
            radius = self.support.steady_radii(radius, &self.curves.rank, alpha);
        }
        self.support.size = radius.iter().enumerate().map(|(v, &r)| size(v, r)).collect();
        if let Some(beta) = options.gradation {
            size::grade(&self.support.mesh, &mut self.support.size, beta, context)?;
        }
        // A search for a scale does with those of its first step.
        if options.anisotropic && self.support.stretch.is_empty() {
            let rank = &self.curves.rank;
            let bend: Vec<glam::DVec3> = self.radius.iter().map(|r| r.bend).collect();
            self.support.stretch = anisotropy::stretches(&self.support, &bend, rank, options.gradation);
        }
        Ok(())
    }

    /// The source adapted to its size map.
    fn adapted(
        &self,
        mesh: &SurfaceMesh,
        options: &RemeshOptions,
        curved: bool,
        context: &Context,
    ) -> Result<SurfaceMesh> {
        let mut work = Work::new(&self.support, &self.curves, self.limits(options));
        work.curved = curved;
        work.adapt(options.triangles, context)?;
        self.finish(mesh, &work)
    }

    /// What was adapted, as a surface mesh.
    fn finish(&self, mesh: &SurfaceMesh, work: &Work) -> Result<SurfaceMesh> {
        let seat = |corner: u32| work.seat[work.mesh.wedge(corner) as usize];
        let size = |v: u32| work.size[v as usize] / work::BALANCE;
        output::assemble(
            mesh,
            &self.support,
            &Made { mesh: &work.mesh, seat: &seat, size: &size, stretch: &work.stretch },
        )
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
            curve_sag_share: 0.3,
            ridge_sag: options.ridge_tolerance * self.diagonal,
            border_sag: BORDER_RADIUS * self.diagonal * (1.0 - theta.cos()),
            tilt_weight: if options.anisotropic { STRETCHED_TILT } else { (TILT / theta.sin()).min(1.0) },
            dihedral: (!self.noisy && options.feature_angle < 180.0).then(|| Dihedral::within(options.feature_angle)),
        }
    }
}

/// The sizes that a vertex property asks for, at the vertices of the mesh at work.
fn given_sizes(mesh: &SurfaceMesh, edit: &EditMesh, options: &RemeshOptions) -> Result<Option<Vec<f64>>> {
    let Some(name) = &options.sizes else { return Ok(None) };
    let Some(Column::Scalar(given)) = mesh.attributes.vertex.get(name) else {
        return Err(Error::Options(format!("the mesh has no vertex property '{name}' of numbers")));
    };
    if let Some(v) = given.iter().position(|h| !(h.is_finite() && *h > 0.0)) {
        return Err(Error::Options(format!("'{name}' is {} at vertex {v}, sizes must be above 0", given[v])));
    }
    Ok(Some((0..edit.vertex_slots()).map(|v| given[edit.origin[v as usize] as usize]).collect()))
}

/// Triangles, repaired where they need it. Polygons are looked at before they are cut: two that are the same may be cut in
/// two ways.
fn clean(mesh: &SurfaceMesh, context: &Context) -> Result<(SurfaceMesh, Vec<String>)> {
    let _stage = context.stage("clean");
    let (mut mesh, mut said) = repaired_if_needed(mesh.clone(), context)?;
    if !mesh.is_triangular() {
        let (triangles, more) = repaired_if_needed(mesh.triangulated()?, context)?;
        mesh = triangles;
        said.extend(more);
    }
    Ok((mesh, said))
}

/// Repairs degenerate and repeated faces and inconsistent senses. A sound mesh is returned as it is.
fn repaired_if_needed(mesh: SurfaceMesh, context: &Context) -> Result<(SurfaceMesh, Vec<String>)> {
    let diagonal = mesh.diagonal();
    let flat = |f: &[u32]| safe_length(area_vector(mesh.points(), f)) <= 1e-12 * diagonal * diagonal;
    let irregular = |c: usize| matches!(mesh.side(CornerId::new(c)), Side::Inconsistent | Side::NonManifold);
    let pillow = |f: usize| {
        let across = |k: usize| mesh.opposite(CornerId::new(3 * f + k)).map(|o| mesh.face_of(o));
        across(0).is_some() && across(0) == across(1) && across(1) == across(2)
    };
    let needed = mesh.faces().iter().any(flat)
        || (0..mesh.corner_count()).any(irregular)
        || (mesh.is_triangular() && (0..mesh.face_count()).any(pillow));
    if !needed {
        return Ok((mesh, Vec::new()));
    }
    let options = RepairOptions { weld: None, split: false, outward: false, ..RepairOptions::default() };
    let repaired = repair(&mesh, &options, context)?;
    let said = repaired.report.sentences();
    Ok((repaired.mesh, said))
}
