//! The motorcycle graph as a result of its own (Protais et al., §3): nodes, tracks, and the patches that tracks and features
//! divide the surface into. Nothing is quantised or filled for it.
//!
//! ```text
//!   ●━━━━━━━━━━┳━━━━━━━━━━●     ● corner of features     ━ feature
//!   ┃          │  p1      ┃     ○ singular vertex        │ track
//!   ┃   p0     ├──────────┫
//!   ┃          │  p2      ┃     tracks end at features and at tracks across their way; a node is where arcs meet:
//!   ┃          ○─────     ┃     the long track is one track and two arcs
//! ```
//!
//! `build` collects all this from what tracks were drawn into.

mod build;
mod cut;
mod draw;
mod layout;
mod sheet;
#[cfg(test)]
mod tests;
mod trace;

use super::source::Source;
use super::{check_size, sized};
use crate::context::Context;
use crate::error::{Error, Result};
use crate::geometry::features::{FeatureOptions, FoundFeatures};
use crate::mesh::{Column, SurfaceMesh, UnitScale, VertexId};
use build::Builder;
use draw::{FIELD_EDGES, draw};
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// A tag of the edges of a graph's mesh: features, because they are walls before any track is drawn.
pub const FEATURE: i32 = 1;
/// A tag of the edges of a graph's mesh: tracks of the motorcycle graph, because they are paths of edges.
pub const TRACK: i32 = 2;
/// A tag of the edges of a graph's mesh: cuts through patches, because no track divides these.
pub const CUT: i32 = 3;

/// Options of [`motorcycle_graph`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct GraphOptions {
    /// What tracks end at.
    #[serde(skip)]
    pub features: FeatureOptions,
    /// Number of quads that the graph is for: the triangles that carry the field have edges as long as theirs, ends of tracks
    /// that are nearer to each other than half of that are one.
    pub quads: usize,
    /// The length of their edges instead, in the unit of the file.
    #[serde(skip)]
    pub edge_length: Option<f64>,
}

impl GraphOptions {
    /// Refuses values out of range.
    ///
    /// # Errors
    /// [`Error::Options`].
    pub fn validate(&self) -> Result<()> {
        self.features.validate()?;
        check_size(self.quads, self.edge_length)
    }
}

impl Default for GraphOptions {
    fn default() -> Self {
        GraphOptions { features: FeatureOptions::auto(), quads: 3000, edge_length: None }
    }
}

/// Where tracks start: an inner vertex that the field gives another number of quads than four, or a sector between features
/// with more than two.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Start {
    /// The vertex.
    pub vertex: u32,
    /// Not on a feature.
    pub inner: bool,
    /// Quads that the field gives the vertex or the sector.
    pub quads: u32,
    /// Tracks that leave it or have come to it on the way of one that would have; one less than quads in a sector, or as many
    /// as quads around an inner vertex, unless some were taken back.
    pub tracks: u32,
}

impl Start {
    /// Tracks that should leave it.
    pub fn ways(&self) -> u32 {
        self.quads.saturating_sub(u32::from(!self.inner))
    }
}

/// What a node is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum NodeKind {
    /// A singular vertex off the features.
    Singularity,
    /// A vertex where features meet, end, bend, or have room for other than two quads.
    Corner,
    /// Another point of a feature.
    Feature,
    /// Another point of an open border.
    Border,
    /// A point of a track where others end.
    Track,
}

/// A vertex where arcs meet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Node {
    /// The vertex.
    pub vertex: u32,
    /// What it is.
    pub kind: NodeKind,
}

/// How a track came about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum TrackKind {
    /// It follows the field from a start; two that met head on are one.
    Motorcycle,
    /// It follows the field from a wall, across a patch that is no disc.
    Cut,
    /// The shortest way across such a patch, where the field led none.
    Shortcut,
}

/// A path of edges on the surface.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Track {
    /// How it came about.
    pub kind: TrackKind,
    /// The nodes that it runs between; what they are tells where it starts and why it ends.
    pub nodes: [u32; 2],
    /// Its vertices, from the first node to the second.
    pub vertices: Vec<u32>,
}

/// A piece of a track or a feature from node to node.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Arc {
    /// The nodes that it runs between.
    pub nodes: [u32; 2],
    /// The track that it is part of; `None` on features.
    pub track: Option<u32>,
    /// Its vertices, from the first node to the second.
    pub vertices: Vec<u32>,
}

/// An arc as a patch sees it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Side {
    /// The arc.
    pub arc: u32,
    /// Whether the patch is on the right of it.
    pub reversed: bool,
    /// Quads that the patch has at the end of the arc: at 1 it has a corner, at 2 its side goes on, at more it turns back.
    pub quads: i32,
}

/// What tracks and features enclose.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Patch {
    /// The arcs around it, with the patch on the left, one list per loop; where there is a corner, from one on.
    pub loops: Vec<Vec<Side>>,
    /// Its Euler number: 1 for a disc.
    pub euler: i64,
    /// Its number of corners.
    pub corners: usize,
    /// Its area.
    pub area: f64,
    /// The region between features that it is in, the face column `region` of the mesh.
    pub region: u32,
}

impl Patch {
    /// Whether it is a disc.
    pub fn is_disc(&self) -> bool {
        self.loops.len() == 1 && self.euler == 1
    }

    /// Whether a grid of quads fits without any irregular vertex: a disc with four corners and straight sides.
    pub fn is_regular(&self) -> bool {
        let straight = self.loops.iter().flatten().all(|s| matches!(s.quads, 1 | 2));
        self.is_disc() && self.corners == 4 && straight
    }

    /// The sides of a disc from corner to corner; all around where it has no corner, none where it is no disc.
    pub fn sides(&self) -> Vec<&[Side]> {
        match &self.loops[..] {
            [around] if self.is_disc() => around.split_inclusive(|s| s.quads == 1).collect(),
            _ => Vec::new(),
        }
    }
}

/// A motorcycle graph.
#[derive(Debug, Clone)]
pub struct MotorcycleGraph {
    /// The triangles that it is drawn into: tracks are paths of their edges. Face columns `patch` and `region`, vertex column
    /// `singularity` (quads of singular vertices, 0 elsewhere); edges tagged [`FEATURE`], [`TRACK`], [`CUT`].
    pub mesh: SurfaceMesh,
    /// Where tracks start.
    pub starts: Vec<Start>,
    /// Where arcs meet.
    pub nodes: Vec<Node>,
    /// The tracks, first the motorcycles, then the cuts.
    pub tracks: Vec<Track>,
    /// The pieces of tracks and features.
    pub arcs: Vec<Arc>,
    /// What they enclose.
    pub patches: Vec<Patch>,
    /// What was repaired before, one sentence each.
    pub warnings: Vec<String>,
    /// Tagged and listed edges that the mesh does not have.
    pub missing: Vec<[VertexId; 2]>,
    /// The features of the input, and sharp edges that are none at the size of the quads.
    pub features: FoundFeatures,
}

/// The content of a layout file.
#[derive(Serialize)]
struct LayoutFile<'a> {
    vertices: Vec<[f64; 3]>,
    triangles: Vec<&'a [u32]>,
    /// Of every triangle.
    patch: &'a [i32],
    features: Vec<[u32; 2]>,
    starts: &'a [Start],
    nodes: &'a [Node],
    tracks: &'a [Track],
    arcs: &'a [Arc],
    patches: &'a [Patch],
}

impl MotorcycleGraph {
    /// Patch of every triangle.
    pub fn patch_of(&self) -> &[i32] {
        match self.mesh.attributes.face.get("patch") {
            Some(Column::Label(labels)) => labels,
            _ => &[],
        }
    }

    /// Edges with a tag.
    pub fn edges(&self, tag: impl Fn(i32) -> bool) -> Vec<[u32; 2]> {
        self.mesh.tagged_edges.iter().filter(|e| tag(e.tag)).map(|e| e.ends.map(|v| v.0)).collect()
    }

    /// Patches that a grid of quads fits into.
    pub fn regular(&self) -> usize {
        self.patches.iter().filter(|p| p.is_regular()).count()
    }

    /// What was found at a size of about one, as of the model.
    fn of_model(mut self, scale: UnitScale) -> Self {
        self.mesh = scale.back().moved(self.mesh, &[]);
        self.patches.iter_mut().for_each(|patch| patch.area = scale.area(patch.area));
        self.features = self.features.moved(scale.back());
        self
    }

    /// Tracks that were taken back, over all starts: their vertices stay inside patches.
    pub fn taken_back(&self) -> u32 {
        self.starts.iter().map(|s| s.ways().saturating_sub(s.tracks)).sum()
    }

    /// The layout file (JSON): everything above, ids from 0.
    pub fn layout(&self) -> Vec<u8> {
        let layout = LayoutFile {
            vertices: self.mesh.points().iter().map(DVec3::to_array).collect(),
            triangles: self.mesh.faces().iter().collect(),
            patch: self.patch_of(),
            features: self.edges(|tag| tag == FEATURE),
            starts: &self.starts,
            nodes: &self.nodes,
            tracks: &self.tracks,
            arcs: &self.arcs,
            patches: &self.patches,
        };
        // Numbers and lists alone: nothing that JSON could refuse.
        serde_json::to_vec(&layout).unwrap_or_default()
    }
}

/// Draws the motorcycle graph of the frame field along the features of a surface: what [`super::quads`] starts from.
///
/// ```
/// use carreau::{Context, quad, sample};
/// let context = Context::new();
/// let mesh = sample::make("bracket", None, &context)?;
/// let graph = quad::motorcycle_graph(&mesh, &quad::GraphOptions::default(), &context)?;
/// assert!(graph.patches.iter().all(|patch| patch.is_disc()));
/// // Tracks run from node to node, and end at a feature, a border, a track across, or where another one starts.
/// let track = &graph.tracks[0];
/// assert_eq!(graph.nodes[track.nodes[0] as usize].vertex, track.vertices[0]);
/// # Ok::<(), carreau::Error>(())
/// ```
///
/// # Errors
/// [`Error::Options`] for options out of range, [`Error::Input`] for a mesh without faces or with one side only,
/// [`Error::Numeric`] where no field could be made or its tracks enclose nothing, [`Error::Cancelled`], [`Error::Deadline`].
pub fn motorcycle_graph(mesh: &SurfaceMesh, options: &GraphOptions, context: &Context) -> Result<MotorcycleGraph> {
    options.validate()?;
    let scale = UnitScale::of_mesh(mesh);
    if let Some(mesh) = scale.mesh(mesh, &[]) {
        let edge_length = options.edge_length.map(|length| scale.length(length));
        let found = motorcycle_graph(&mesh, &GraphOptions { edge_length, ..options.clone() }, context)?;
        return Ok(found.of_model(scale));
    }
    let features = sized(&options.features, mesh, options.quads, options.edge_length);
    let source = Source::new(mesh, &features, context)?;
    let length = options.edge_length.unwrap_or_else(|| (source.area / options.quads as f64).sqrt());
    let feature_deg = options.features.angle_deg.unwrap_or(180.0);
    let mut why = String::new();
    for finer in FIELD_EDGES {
        match draw(&source, length, finer * length, feature_deg, context)? {
            Ok(drawn) => match Builder::new(&drawn, &source).and_then(Builder::graph) {
                Some(graph) => return graph,
                None => why = "its tracks do not enclose patches".into(),
            },
            Err(reason) => why = reason,
        }
    }
    Err(Error::Numeric(format!("the motorcycle graph could not be drawn: {why}")))
}
