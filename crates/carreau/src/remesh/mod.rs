//! Graded triangles: enrich and simplify a surface to an angle.
//!
//! Borouchaki, Frey: *Maillage géométrique de surfaces. Partie II : appauvrissement*, INRIA RR-3237, 1997. Its first part,
//! enrichment, is not public and is reconstructed here. A mesh is geometric if all its edges have length one in the metric of
//! the surface: the size at a point is h = α r, with α = 2 sin θ and r the smallest principal radius.
//!
//! | stage, in the order of the calls | file | paper |
//! |---|---|---|
//! | options | `options` | – |
//! | polygons that are not plane are divided | `warped` | – |
//! | the edges that stay (ridges), also where they fade out | `features`, `fading`, `curves` | §4.5, §4.7 |
//! | vertices where the surface comes to a point | `tips` | – |
//! | the surface as curved patches: normals, radii, walking | `support`, `smoothed`, `radii` | Part I |
//! | the size map: sizes, gradation, lengths in the metric | `source`, `size`, `rings` | §3, remark; H-shock |
//! | smaller sizes where sheets are close to each other | `sheets` | – |
//! | longer edges where the surface bends less | `anisotropy` | announced |
//! | the mesh being changed | `work` | – |
//! | **the loop of local operations**, which calls the next ten | `adapt` | §3 |
//! | collapses under constraints (1), (2), (4) | `decimate` | §3 |
//! | splits of long edges | `divide` | Part I |
//! | flips | `swap` | §2 |
//! | few, even edges along ridges | `spacing` | – |
//! | edges across which the surface is smooth stay so | `creases`, `dihedral` | – |
//! | relocation of vertices | `relocate` | §3, "bougé de points" |
//! | the same for all vertices at once, in classes without neighbours | `sweep` | – |
//! | the worst triangles one by one | `polish` | – |
//! | new vertices where the surface is farthest from the mesh | `gaps` | – |
//! | vertices moved to where the mesh is nearest to the surface | `fit` | – |
//! | scaling the sizes until a number of triangles or a distance is met | `search`, `target`, `predicted` | – |
//! | without regard to shape: collapses of least quadric error, from a priority queue | `geometric`, `buckets` | – |
//! | the result with the input's attributes; its figures | `output`; `quality` | §4 |

mod adapt;
mod anisotropy;
mod buckets;
mod creases;
mod curves;
mod decimate;
mod dihedral;
mod divide;
mod fading;
mod features;
mod fit;
mod gaps;
mod geometric;
mod options;
mod output;
mod polish;
mod predicted;
mod quality;
mod radii;
mod relocate;
mod rings;
mod search;
mod sheets;
mod size;
mod smoothed;
mod source;
mod spacing;
mod support;
mod swap;
mod sweep;
mod target;
#[cfg(test)]
mod tests;
mod tips;
mod warped;
mod work;

use crate::context::Context;
use crate::error::Result;
use crate::geometry::features::{FeatureOptions, FoundFeatures, feature_edges};
use crate::mesh::{Column, RepairOptions, SurfaceMesh, TaggedEdge, UnitScale, VertexId, is_flawed, repair};
use source::Source;

pub(crate) use curves::RIDGE_TURN_DEG;
pub use options::RemeshOptions;
pub use quality::RemeshQuality;

/// The result of [`enrich`] and [`simplify`].
#[derive(Debug, Clone)]
pub struct Remeshed {
    /// The mesh, with the vertex property `size`.
    pub mesh: SurfaceMesh,
    /// Shapes, lengths, deviation and distance of the result.
    pub quality: RemeshQuality,
    /// What was repaired before, and what could not be reached, one sentence each.
    pub repaired: Vec<String>,
    /// The ridges that were kept, and sharp edges that are no ridges at this size.
    pub features: FoundFeatures,
    /// Listed edges that do not exist in the mesh.
    pub missing: Vec<[VertexId; 2]>,
}

impl Remeshed {
    fn with_missing(self, missing: Vec<[VertexId; 2]>) -> Self {
        Remeshed { missing, ..self }
    }
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
/// [`Error::Options`](crate::Error::Options) for options out of range, [`Error::Input`](crate::Error::Input) for a mesh without faces, [`Error::Numeric`](crate::Error::Numeric) where a
/// distance cannot be reached, [`Error::Cancelled`](crate::Error::Cancelled), [`Error::Deadline`](crate::Error::Deadline).
pub fn simplify(mesh: &SurfaceMesh, options: &RemeshOptions, context: &Context) -> Result<Remeshed> {
    options.validate()?;
    if let Some(found) = in_unit_scale(mesh, options, |mesh, options| simplify(mesh, options, context)) {
        return found;
    }
    if let Some((mesh, options, missing)) = with_listed(mesh, options)? {
        return simplify(&mesh, &options, context).map(|found| found.with_missing(missing));
    }
    let (cleaned, mut repaired) = clean(mesh, context)?;
    let enriched = match options.enrich {
        Some(deviation) => {
            let first = RemeshOptions { deviation, enrich: None, triangles: None, distance: None, ..options.clone() };
            first.validate()?;
            enriched(&cleaned, &first, context)?.0
        }
        None => cleaned,
    };
    let mut source = Source::new(&enriched, options, context)?;
    let out = match (options.distance, options.triangles) {
        _ if options.geometric => search::least_error(mesh, &enriched, &mut source, options, context)?,
        (Some(distance), _) => search::within_distance(mesh, &enriched, &mut source, options, distance, context)?,
        (None, Some(wanted)) => {
            let (out, tolerance) = search::to_count(&enriched, &mut source, options, wanted, context)?;
            repaired.extend(looser_ridges(tolerance, options.ridge_tolerance, wanted));
            out
        }
        (None, None) => {
            source.set_sizes(options, context)?;
            source.adapted(&enriched, options, false, context)?
        }
    };
    if let Some(wanted) = options.triangles.filter(|&n| out.face_count().abs_diff(n) as f64 > 0.01 * n as f64) {
        let reached = out.face_count();
        repaired.push(format!("{wanted} triangles were asked for, but the ridges and the surface allow only {reached}; a larger feature angle keeps fewer ridges"));
    }
    repaired.extend(grown(mesh, &out, options));
    let quality = quality::measure(&out)?;
    Ok(Remeshed { mesh: out, quality, repaired, features: source.found, missing: Vec::new() })
}

/// What is to be told where ridges are farther off than they should be.
fn looser_ridges(tolerance: f64, usual: f64, wanted: usize) -> Option<String> {
    let share = 100.0 * tolerance;
    (tolerance > usual).then(|| {
        format!("ridges may be off by {share:.2} % of the diagonal, because {wanted} triangles are too few to follow them more closely")
    })
}

/// What is to be told of a mesh with more triangles than before.
fn grown(before: &SurfaceMesh, after: &SurfaceMesh, options: &RemeshOptions) -> Option<String> {
    let of = before.faces().iter().map(|face| face.len().saturating_sub(2)).sum::<usize>();
    let is_wanted = options.triangles.is_some_and(|n| n > of) || options.enrich.is_some();
    if after.face_count() <= of || is_wanted {
        return None;
    }
    let why = match (options.triangles, options.distance) {
        (Some(_), _) => "the curves need as many".to_string(),
        (None, Some(_)) => "the distance asks for even triangles that are smaller than those of the input".to_string(),
        (None, None) => format!(
            "a deviation of {}° and even triangles ask for shorter edges than the input has; a larger deviation or a number of triangles gives fewer",
            options.deviation
        ),
    };
    Some(format!("the result has {} triangles, more than the {of} before, because {why}", after.face_count()))
}

/// Refines a surface to an angular deviation: long edges are split, with the new vertices on curved patches.
///
/// # Errors
/// As [`simplify`].
pub fn enrich(mesh: &SurfaceMesh, options: &RemeshOptions, context: &Context) -> Result<Remeshed> {
    options.validate()?;
    if let Some(found) = in_unit_scale(mesh, options, |mesh, options| enrich(mesh, options, context)) {
        return found;
    }
    if let Some((mesh, options, missing)) = with_listed(mesh, options)? {
        return enrich(&mesh, &options, context).map(|found| found.with_missing(missing));
    }
    let (mesh, repaired) = clean(mesh, context)?;
    let (out, features) = enriched(&mesh, options, context)?;
    let quality = quality::measure(&out)?;
    Ok(Remeshed { mesh: out, quality, repaired, features, missing: Vec::new() })
}

/// The same on a mesh of a usual size, where the given one is far from it.
fn in_unit_scale(
    mesh: &SurfaceMesh,
    options: &RemeshOptions,
    run: impl FnOnce(&SurfaceMesh, &RemeshOptions) -> Result<Remeshed>,
) -> Option<Result<Remeshed>> {
    let scale = UnitScale::of_mesh(mesh);
    let sizes = options.sizes.as_deref().filter(|name| *name != "size");
    let given: Vec<&str> = options.sizes.as_deref().into_iter().collect();
    let made: Vec<&str> = sizes.into_iter().chain(["size"]).collect();
    let mesh = scale.mesh(mesh, &given)?;
    let options = RemeshOptions { distance: options.distance.map(|d| scale.length(d)), ..options.clone() };
    Some(run(&mesh, &options).map(|found| Remeshed {
        mesh: scale.back().moved(found.mesh, &made),
        features: found.features.moved(scale.back()),
        ..found
    }))
}

/// The same with the listed edges as tagged ones, and those that the mesh does not have; `None` where none is listed. Tags stay
/// with their edges while the mesh is repaired.
fn with_listed(mesh: &SurfaceMesh, options: &RemeshOptions) -> Result<Option<WithListed>> {
    if options.feature_edges.is_empty() {
        return Ok(None);
    }
    let edges = options.feature_edges.clone();
    let listed = FeatureOptions { angle_deg: None, borders: false, tags: false, edges, ..FeatureOptions::default() };
    let listed = feature_edges(mesh, &listed)?;
    let mut mesh = mesh.clone();
    if !options.tags {
        mesh.tagged_edges.clear();
    }
    mesh.tagged_edges.extend(options.feature_edges.iter().map(|&ends| TaggedEdge { ends, tag: 1 }));
    mesh.tagged_edges.retain(|edge| !listed.missing.contains(&edge.ends));
    Ok(Some((mesh, RemeshOptions { tags: true, feature_edges: Vec::new(), ..options.clone() }, listed.missing)))
}

type WithListed = (SurfaceMesh, RemeshOptions, Vec<[VertexId; 2]>);

/// A clean mesh, refined.
fn enriched(mesh: &SurfaceMesh, options: &RemeshOptions, context: &Context) -> Result<(SurfaceMesh, FoundFeatures)> {
    let mut source = Source::new(mesh, options, context)?;
    source.support.ready_for_patches(source.noisy);
    source.set_sizes(options, context)?;
    Ok((source.adapted(mesh, options, true, context)?, source.found))
}

/// Triangles in the order of space, repaired where they need it. Polygons are looked at before they are cut: two that are the same may be cut in
/// two ways.
fn clean(mesh: &SurfaceMesh, context: &Context) -> Result<(SurfaceMesh, Vec<String>)> {
    let _stage = context.stage("clean");
    let (mut mesh, mut said) = repaired_if_needed(mesh.clone(), context)?;
    if !mesh.is_triangular() {
        let polygons = (0..mesh.face_count() as i32).collect();
        mesh.attributes.face.insert(features::POLYGON.into(), Column::Label(polygons));
        let (triangles, more) = repaired_if_needed(warped::with_middles(mesh)?.triangulated()?, context)?;
        mesh = triangles;
        said.extend(more);
    }
    Ok((mesh.in_space_order()?, said))
}

/// Faces with less area, relative to the squared diagonal, count as flat.
const FLAT_FACE: f64 = 1e-12;

/// Repairs degenerate and repeated faces and inconsistent senses. A sound mesh is returned as it is.
fn repaired_if_needed(mesh: SurfaceMesh, context: &Context) -> Result<(SurfaceMesh, Vec<String>)> {
    if !is_flawed(&mesh, FLAT_FACE) {
        return Ok((mesh, Vec::new()));
    }
    let options = RepairOptions { weld: None, split: false, outward: false, ..RepairOptions::default() };
    let repaired = repair(&mesh, &options, context)?;
    let said = repaired.report.sentences();
    Ok((repaired.mesh, said))
}
