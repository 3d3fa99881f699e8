//! Symmetric quads: the surface is cut in half at each plane of symmetry, the last part gets its quads, and these are mirrored.
//!
//! ```text
//!   surface           half             its quads          mirrored
//!    ╱‾╲│╱‾╲           │╱‾╲             ├┬┬╲              ╱┬┬┼┬┬╲
//!   │   │   │     →    │   │     →      ├┼┼┤       →      ├┼┼┼┼┼┤
//!    ╲_╱│╲_╱           │╲_╱             ├┴┴╱              ╲┴┴┼┴┴╱
//! ```
//!
//! The cut is a border of the half, so that quads have edges along it; their vertices there are in the plane to the bit.
//!
//! | stage | file |
//! |---|---|
//! | planes of symmetry | `planes` |
//! | the part on one side of a plane | `half` |
//! | quads and their mirror images | `mirror` |

mod half;
mod mirror;
mod planes;
#[cfg(test)]
mod tests;

use super::QuadOptions;
use super::guidance::Guidance;
use super::junction::{EdgePlace, edge_place};
use super::methods::Made;
use super::source::Source;
use super::validate::topology_refusal;
use super::{guided, methods, sized};
use crate::context::Context;
use crate::error::{Error, Result};
use crate::geometry::features::{FeatureOptions, length_of_squares};
use crate::mesh::{CornerId, SurfaceMesh, TaggedEdge, UnitScale, VertexId};
use glam::DVec3;
use half::{Part, half};
use mirror::{mirrored, on_source};
use planes::Found;
use rustc_hash::FxHashSet;
use serde::{Deserialize, Serialize, Serializer};

/// A share of the diagonal: border vertices so near to a plane are in it, because they were put onto its cut but for rounding.
pub const AT_PLANE: f64 = 1e-6;

/// A cosine: an edge is on a feature that is so parallel to it, because both are straight there.
const ALONG: f64 = 0.99;

/// Which symmetry quads have.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Symmetry {
    /// None.
    #[default]
    Off,
    /// They are the same on both sides of a plane across x.
    X,
    /// Across y.
    Y,
    /// Across z.
    Z,
    /// That of the surface: up to three planes at right angles, across x, y and z or across its principal axes.
    Auto,
}

/// A plane that quads are mirrored in: the points p with normal · p = offset.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MirrorPlane {
    /// Its unit normal.
    #[serde(serialize_with = "as_array")]
    pub normal: DVec3,
    /// Its distance from the origin along the normal, in the unit of the file.
    pub offset: f64,
    /// How far the mirror image of the surface was found from the surface at most, in the unit of the file.
    pub asymmetry: f64,
}

fn as_array<S: Serializer>(normal: &DVec3, serializer: S) -> std::result::Result<S::Ok, S::Error> {
    normal.to_array().serialize(serializer)
}

impl MirrorPlane {
    /// The height of a point above the plane, along its normal.
    pub fn height(&self, p: DVec3) -> f64 {
        self.normal.dot(p) - self.offset
    }

    /// The mirror image of a point.
    pub fn image(&self, p: DVec3) -> DVec3 {
        p - 2.0 * self.height(p) * self.normal
    }

    /// The nearest point of the plane.
    pub fn foot(&self, p: DVec3) -> DVec3 {
        let foot = p - self.height(p) * self.normal;
        // Across an axis the coordinate is that of the plane, not what is left of it after rounding.
        let exact = |axis: DVec3, p: DVec3| {
            if self.normal == axis { p + (self.offset - p.dot(axis)) * axis } else { p }
        };
        exact(DVec3::Z, exact(DVec3::Y, exact(DVec3::X, foot)))
    }

    /// The same in another scale.
    pub(super) fn moved(self, scale: UnitScale) -> Self {
        let [offset, asymmetry] = [self.offset, self.asymmetry].map(|x| scale.length(x));
        MirrorPlane { offset, asymmetry, ..self }
    }
}

/// What came of symmetry: the whole surface, its quads, and the planes.
pub struct Symmetric {
    pub source: Source,
    pub made: Made,
    pub planes: Vec<MirrorPlane>,
}

/// Symmetric quads. Where there are none, `auto` gives the reason; what was asked for by name is an error then.
pub fn quads(
    mesh: &SurfaceMesh,
    options: &QuadOptions,
    context: &Context,
) -> Result<std::result::Result<Symmetric, String>> {
    let _stage = context.stage("symmetry");
    let edge = options.edge_length.unwrap_or_else(|| length_of_squares(mesh, options.quads as f64));
    let found = planes::planes(mesh, options.symmetry, edge, context)?;
    let planes = match found {
        Found::Planes(planes) => planes,
        Found::None(why) => return Ok(Err(why)),
    };
    let refused = |why: &str| format!("no symmetric quads were found: {why}; more quads may do");
    match of_planes(mesh, options, planes, context)? {
        Ok(found) => Ok(Ok(found)),
        Err(why) if options.symmetry == Symmetry::Auto => Ok(Err(refused(&why))),
        Err(why) => Err(Error::Numeric(refused(&why))),
    }
}

fn of_planes(
    mesh: &SurfaceMesh,
    options: &QuadOptions,
    planes: Vec<MirrorPlane>,
    context: &Context,
) -> Result<std::result::Result<Symmetric, String>> {
    let features = sized(&options.features, mesh, options.quads, options.edge_length);
    let source = guided(Source::new(mesh, &features, context)?, mesh, options, context)?;
    let Some(Part { mesh: part, features: edges }) = part(&source, &options.features, mesh, &planes)? else {
        return Ok(Err("a plane of symmetry has nothing on one side".into()));
    };
    let tags_alone = FeatureOptions { edges: Vec::new(), tags: true, ..options.features.clone() };
    let quads = options.quads.div_ceil(1 << planes.len());
    let part_options = QuadOptions { features: tags_alone, quads, ..options.clone() };
    // Creases are looked for on the whole surface: near a cut they would be others.
    let as_found = FeatureOptions { angle_deg: None, edges, ..part_options.features.clone() };
    let of_part = Source::new(&part, &as_found, context)?;
    let cut_places = cut_places(&of_part, &source);
    let mut of_part = of_part.guided(Guidance { cuts: planes.clone(), cut_places, ..source.guidance.clone() });
    of_part.is_noisy = source.is_noisy;
    let (of_part, mut made) = methods::best(of_part, &part, &part_options, context)?;
    for plane in planes.iter().rev() {
        made.work = mirrored(&made.work, plane, of_part.diagonal);
    }
    if let Some(why) = topology_refusal(&made.work.to_mesh()?, &source) {
        return Ok(Err(why.into()));
    }
    on_source(&mut made.work, &source);
    Ok(Ok(Symmetric { source, made, planes }))
}

/// The part of a surface above all planes, and its features; those that were tagged or listed are its tagged edges. `None` where
/// there is none.
fn part(source: &Source, wanted: &FeatureOptions, mesh: &SurfaceMesh, planes: &[MirrorPlane]) -> Result<Option<Part>> {
    let mut part = source.surface.mesh.clone();
    part.attributes = Default::default();
    // Listed edges have the numbers of the input, which repairs change.
    let listed = if part.vertex_count() == mesh.vertex_count() { wanted.edges.as_slice() } else { &[] };
    if !wanted.tags {
        part.tagged_edges.clear();
    }
    part.tagged_edges.extend(listed.iter().map(|&ends| TaggedEdge { ends, tag: 1 }));
    let features = source.edges.iter().map(|ends| ends.map(VertexId)).collect();
    let mut part = Part { mesh: part, features };
    for plane in planes {
        let Some(above) = half(&part, plane)? else { return Ok(None) };
        part = above;
    }
    Ok(Some(part))
}

/// Borders of a part where the whole surface has no feature.
fn cut_places(part: &Source, whole: &Source) -> FxHashSet<EdgePlace> {
    let mesh = &part.surface.mesh;
    let near = AT_PLANE * whole.diagonal;
    let is_cut = |&c: &CornerId| {
        let [a, b] = [mesh.vertex(c), mesh.vertex(mesh.next(c))].map(|v| mesh.point(v));
        mesh.opposite(c).is_none()
            && whole.feature_along(a.midpoint(b), (b - a).normalize_or_zero(), near, ALONG).is_none()
    };
    part.surface.features.edges(mesh).filter(is_cut).map(|c| edge_place(mesh, c)).collect()
}
