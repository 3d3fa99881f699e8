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
mod work;

use crate::context::Context;
use crate::error::{Error, Result};
use crate::mesh::{
    Column, CornerId, EditMesh, NONE, RepairOptions, Side, SurfaceMesh, area_vector, gather_columns, repair,
    safe_length,
};
use curves::{Curves, Kind};
use serde::{Deserialize, Serialize};
use support::Support;
use work::{Limits, Work};

pub use quality::RemeshQuality;

/// Curvatures are averaged over so many sizes.
const RADIUS_SCALE: f64 = 0.35;

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
    pub min_size: f64,
    /// Largest size, as a share of the diagonal.
    pub max_size: f64,
    /// How far ridges may move, as a share of the diagonal.
    pub ridge_tolerance: f64,
    /// Factor on the sizes.
    pub scale: f64,
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

/// Coarsens a surface to an angular deviation.
pub fn simplify(mesh: &SurfaceMesh, options: &RemeshOptions, context: &Context) -> Result<Remeshed> {
    options.check()?;
    let (mesh, repaired) = clean(mesh, context)?;
    if mesh.faces().is_empty() {
        return Err(Error::input("the mesh has no faces", "", ""));
    }
    let mut source = Source::new(&mesh, options, context)?;
    source.set_sizes(options, context)?;
    let mut work = Work::new(&source.support, &source.curves, source.limits(options));
    {
        let _stage = context.stage("simplify");
        work.adapt(context)?;
    }
    let out = finish(&mesh, &source, &work)?;
    let quality = quality::measure(&out, &sizes(&out))?;
    Ok(Remeshed { mesh: out, quality, repaired })
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
    radius: Vec<f64>,
    /// Radius of the curves at every vertex of rank curve.
    curve_radius: Vec<f64>,
    diagonal: f64,
}

impl Source {
    fn new(mesh: &SurfaceMesh, options: &RemeshOptions, context: &Context) -> Result<Self> {
        let _stage = context.stage("support");
        let marks = features::mark(mesh, options)?;
        let mut edit = EditMesh::new(mesh).ok_or_else(|| Error::Bug("polygons in a triangulated mesh".into()))?;
        // Borders are read at the scale of the size map, which is known only roughly before the curves are.
        let scale = vec![0.01 * mesh.diagonal(); edit.vertex_slots() as usize];
        let curves = Curves::trace(&mut edit, &marks, &scale);
        let support = Support::new(edit);
        let radius = support.radii(&curves.rank);
        let curve_radius = curve_radii(&curves, radius.len());
        Ok(Source { support, curves, radius, curve_radius, diagonal: mesh.diagonal() })
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
        let mesh = &self.support.mesh;
        let rough: Vec<f64> = self.radius.iter().map(|r| (alpha * r).clamp(low, high)).collect();
        let radius = support::smooth_radii(mesh, &self.radius, &rough, RADIUS_SCALE, 12);
        self.support.size = radius.iter().enumerate().map(|(v, &r)| size(v, r)).collect();
        if let Some(beta) = options.gradation {
            size::grade(&self.support.mesh, &mut self.support.size, beta, context)?;
        }
        self.support.fit_normals(0.5, 6);
        Ok(())
    }

    fn limits(&self, options: &RemeshOptions) -> Limits {
        let theta = options.deviation.to_radians();
        let on_sphere = (2.0 * theta.sin() / 3f64.sqrt()).min(0.95).asin();
        Limits {
            cos_allowed: (1.25 * on_sphere).max(20f64.to_radians()).min(60f64.to_radians()).cos(),
            cos_cap: 60f64.to_radians().cos(),
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
    let _ = source;
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
    let parents: Vec<u32> = compact.triangles.iter().map(|&t| work.mesh.source[t as usize]).collect();
    out.attributes.face = gather_columns(&mesh.attributes.face, &parents);
    out.attributes.names = mesh.attributes.names.clone();
    let size = kept.iter().map(|&v| work.size[v as usize]).collect();
    out.attributes.vertex.insert("size".into(), Column::Scalar(size));
    Ok(out)
}
