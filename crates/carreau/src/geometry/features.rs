//! Feature edges: where a surface must not be smoothed over.
//!
//! Features are the sharp edges, the borders, the edges tagged in the file and those the user lists. Edges without a
//! regular neighbour on the other side (non-manifold, inconsistently oriented) always count. Which sharp edges count is a
//! matter of the size of what is made: see [`Creases`].
//!
//! | file | holds |
//! |---|---|
//! | `at_size` | which sharp edges are creases at the size of elements; noise |
//! | `network` | strands of edges: bridged, pruned |
//! | `found` | what was found, for records and pictures |

mod at_size;
mod dropped;
mod found;
mod marked;
mod network;
mod noise;
#[cfg(test)]
mod tests;

use super::normals::{AngleLimit, face_normals};
use crate::bounds::angle;
use crate::context::Context;
use crate::error::Result;
use crate::mesh::{CornerId, Side, SurfaceMesh, TaggedEdge, VertexId, sound};
use marked::sides;
use serde::{Deserialize, Serialize};

pub use super::features::dropped::DroppedStrand;
pub use super::features::noise::Noise;
pub use at_size::USUAL_ELEMENTS;
pub use found::FoundFeatures;
pub use marked::{Features, dihedral_turn, length_of_squares};

/// An edge is sharp when its angle exceeds the limit by more than this, so that edges exactly at the limit are not
/// divided by rounding.
const MARGIN_DEG: f64 = 1e-6;

/// Which of the edges above the angle are features.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Creases {
    /// Every one.
    #[default]
    Every,
    /// Those that are creases at the size of the elements that are made: each method knows its own.
    Auto,
    /// Those that are creases at the size of elements with edges of this length, in the unit of the mesh.
    AtSize(f64),
}

/// What makes an edge a feature.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FeatureOptions {
    /// Edges whose face normals differ by more than this, in degrees; `None`: no edge is sharp.
    pub angle_deg: Option<f64>,
    /// Whether every such edge is a feature, or only creases at the size of the result.
    pub creases: Creases,
    /// Whether borders are features.
    pub borders: bool,
    /// Whether edges tagged in the file are features.
    pub tags: bool,
    /// Further features, by their end vertices.
    pub edges: Vec<[VertexId; 2]>,
}

impl FeatureOptions {
    /// Refuses an angle that is none.
    ///
    /// # Errors
    /// [`Error::Options`](crate::Error::Options).
    pub fn validate(&self) -> Result<()> {
        self.angle_deg.map_or(Ok(()), |degrees| angle("feature-angle", degrees))
    }
}

impl Default for FeatureOptions {
    fn default() -> Self {
        FeatureOptions { angle_deg: Some(35.0), creases: Creases::Every, borders: true, tags: true, edges: Vec::new() }
    }
}

impl FeatureOptions {
    /// Creases at the size of the elements that a method makes.
    pub fn auto() -> Self {
        FeatureOptions { creases: Creases::Auto, ..FeatureOptions::default() }
    }

    /// The same for elements with edges of this length, where they are to be found at that size.
    pub fn for_size(&self, length: f64) -> Self {
        let creases = if self.creases == Creases::Auto { Creases::AtSize(length) } else { self.creases };
        FeatureOptions { creases, ..self.clone() }
    }

    /// The same for elements that cover a surface `count` times over with squares.
    pub fn for_squares(&self, mesh: &SurfaceMesh, count: f64) -> Self {
        self.for_size(length_of_squares(mesh, count))
    }
}

/// Finds the feature edges of a mesh.
///
/// # Errors
/// [`Error::Options`](crate::Error::Options) for an angle outside 0 to 180.
pub fn feature_edges(mesh: &SurfaceMesh, options: &FeatureOptions) -> Result<Features> {
    feature_edges_in(mesh, options, &Context::new())
}

/// The same in a context: creases at the size of elements take their time.
///
/// # Errors
/// [`Error::Options`](crate::Error::Options) for an angle outside 0 to 180, [`Error::Cancelled`](crate::Error::Cancelled), [`Error::Deadline`](crate::Error::Deadline).
pub fn feature_edges_in(mesh: &SurfaceMesh, options: &FeatureOptions, context: &Context) -> Result<Features> {
    options.validate()?;
    let normals = face_normals(mesh);
    let limit = options.angle_deg.map(|a| AngleLimit::new((a + MARGIN_DEG).to_radians()));
    let is_sharp = |c: CornerId| {
        mesh.opposite(c).zip(limit.as_ref()).is_some_and(|(o, limit)| {
            let [a, b] = sides(mesh, &normals, c, o);
            limit.is_exceeded(a, b)
        })
    };
    let is_fixed = |c: CornerId| match mesh.side(c) {
        Side::Inner(_) => false,
        Side::Border => options.borders,
        Side::Inconsistent | Side::NonManifold => true,
    };
    let every = || (0..mesh.corner_count()).map(CornerId::new);
    let mut fixed: Vec<bool> = every().map(is_fixed).collect();
    let missing = mark_listed(mesh, options, &mut fixed);
    let sharp: Vec<bool> = every().map(is_sharp).collect();
    let size = match options.creases {
        Creases::Every => None,
        Creases::Auto => Some(length_of_squares(mesh, USUAL_ELEMENTS)),
        Creases::AtSize(size) => Some(size),
    };
    let Some((size, angle)) = size.zip(options.angle_deg).filter(|_| sharp.contains(&true)) else {
        let corners = fixed.iter().zip(&sharp).map(|(fixed, sharp)| *fixed || *sharp).collect();
        return Ok(Features { corners, missing, ..Features::default() });
    };
    let found = at_size::select(mesh, &normals, [fixed, sharp], angle, size, context)?;
    Ok(Features { missing, ..found })
}

/// Marks the tagged and listed edges; returns those that the mesh does not have.
fn mark_listed(mesh: &SurfaceMesh, options: &FeatureOptions, marks: &mut [bool]) -> Vec<[VertexId; 2]> {
    let tagged = mesh.tagged_edges.iter().filter(|_| options.tags).map(|e| e.ends);
    let listed: Vec<[VertexId; 2]> = tagged.chain(options.edges.iter().copied()).collect();
    let mut missing = Vec::new();
    if !listed.is_empty() {
        let half_edges = mesh.half_edges();
        for ends in listed {
            match half_edges.find(ends[0].0, ends[1].0) {
                Some(edge) => edge.corners().for_each(|c| marks[c as usize] = true),
                None => missing.push(ends),
            }
        }
    }
    missing
}

/// Sound triangles with their features: what fields and quads start from.
#[derive(Debug, Clone)]
pub struct FeaturedSurface {
    /// The triangles; the features are its tagged edges.
    pub mesh: SurfaceMesh,
    /// The features.
    pub features: Features,
    /// What was repaired, one sentence each.
    pub repaired: Vec<String>,
    /// Listed and tagged edges that the mesh does not have.
    pub missing: Vec<[VertexId; 2]>,
    /// What was kept and dropped.
    pub found: FoundFeatures,
}

impl FeaturedSurface {
    /// Finds the features of a mesh, triangulates it and repairs what needs it. Features are those of the mesh as it is: the
    /// diagonals that divide polygons are none.
    ///
    /// # Errors
    /// [`Error::Options`](crate::Error::Options) for an angle outside 0 to 180, [`Error::Cancelled`](crate::Error::Cancelled), [`Error::Deadline`](crate::Error::Deadline).
    pub fn new(mesh: &SurfaceMesh, options: &FeatureOptions, context: &Context) -> Result<Self> {
        let _stage = context.stage("features");
        let found = feature_edges_in(mesh, options, context)?;
        let mut marked = mesh.clone();
        let ends = |c: CornerId| [mesh.vertex(c), mesh.vertex(mesh.next(c))];
        marked.tagged_edges = found.edges(mesh).map(|c| TaggedEdge { ends: ends(c), tag: 1 }).collect();
        let is_triangular = mesh.is_triangular();
        let (mesh, repaired) = sound(&marked, context)?;
        // A repair may flip edges that were marked: others are sharp then.
        let is_new = is_triangular && !repaired.is_empty() && !found.noise.is_high();
        let angle_deg = options.angle_deg.filter(|_| is_new);
        let as_marked = FeatureOptions { angle_deg, ..FeatureOptions::default() };
        let features = feature_edges(&mesh, &as_marked)?;
        let told = FoundFeatures::new(&marked, &found);
        Ok(FeaturedSurface { mesh, features, repaired, missing: found.missing, found: told })
    }
}
