//! `motorcycle`: the motorcycle graph of a frame field, which divides a part into patches for quads.

use super::contract::Verb;
use crate::common::{Common, positive_length};
use crate::features::{FeatureFlags, FeatureValues, tell_features, warn_missing, with_dropped};
use crate::host::Found;
use crate::outputs::{Content, Outputs};
use crate::prepare::PrepareFlags;
use crate::session::Session;
use carreau::io::{ResultKind, WriteOptions};
use carreau::mesh::{PrepareOptions, RawMesh, SurfaceMesh};
use carreau::quad::graph::{Track, TrackKind};
use carreau::quad::{GraphOptions, MotorcycleGraph, motorcycle_graph};
use carreau::report::graph_figure;
use carreau::report::page::Scene;
use carreau::{Error, Length};
use clap::Args;
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Traces the motorcycle graph of a frame field: the patches of a part for quads
///
/// Tracks leave the singular vertices of the field and the corners of the features, all at the same speed, and stop at
/// features and at tracks across their way. The output is a triangle mesh in which tracks are paths of edges, with the face
/// properties patch and region. Edges are tagged (1 features, 2 tracks, 3 cuts through patches that would have holes) if
/// the format has tags, and written as lines otherwise.
#[derive(Args)]
#[command(after_help = "Examples:\n  \
    carreau motorcycle part.stl -o graph.vtp --picture graph.png\n  \
    carreau motorcycle part.obj --layout graph.json --json - | jq .patches\n  \
    carreau motorcycle scan.ply -o graph.obj --quads 500 --feature-angle 180")]
pub struct Motorcycle {
    /// The surface; polygons are cut into triangles
    input: PathBuf,
    /// The file to write
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Writes mesh, nodes, tracks, arcs and the sides of every patch (JSON)
    #[arg(long, value_name = "FILE.json")]
    layout: Option<PathBuf>,
    /// Number of quads that the graph is meant for: tracks closer than half a quad are joined [default: 3000]
    #[arg(long, value_name = "N", conflicts_with = "edge_length")]
    quads: Option<usize>,
    /// Length of the quads' edges instead
    #[arg(long, value_name = "LENGTH")]
    edge_length: Option<Length>,
    #[command(flatten)]
    features: FeatureFlags,
    #[command(flatten)]
    prepare: PrepareFlags,
    #[command(flatten)]
    common: Common,
}

/// What replays a run.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Options {
    #[serde(flatten)]
    graph: GraphOptions,
    edge_length: Option<Length>,
    #[serde(flatten)]
    features: FeatureValues,
    #[serde(flatten)]
    prepare: PrepareOptions,
}

impl Verb for Motorcycle {
    const NAME: &'static str = "motorcycle";
    type Options = Options;

    fn common(&self) -> &Common {
        &self.common
    }

    fn common_mut(&mut self) -> &mut Common {
        &mut self.common
    }

    fn subject(&self) -> Option<&Path> {
        Some(&self.input)
    }

    fn files(&self) -> Outputs {
        let files = Outputs::of(&self.common).reads(&self.input, ResultKind::Surface).needs(self.features.file());
        files.writes(self.output.as_deref(), ResultKind::Surface).also(
            "--layout",
            self.layout.as_deref(),
            Content::Json,
        )
    }

    fn defaults(&self) -> Options {
        Options::default()
    }

    fn lay_over(&self, all: &mut Options) -> Result<(), Error> {
        all.graph.quads = self.quads.unwrap_or(all.graph.quads);
        all.edge_length = if self.quads.is_some() { None } else { self.edge_length.or(all.edge_length) };
        all.features = self.features.over(std::mem::take(&mut all.features));
        all.prepare = self.prepare.over(all.prepare);
        positive_length("edge-length", all.edge_length)?;
        all.features.validate()?;
        all.graph.validate()?;
        Ok(())
    }

    fn work(&self, session: &mut Session, options: &Options) -> Result<(), Error> {
        let prepared = session.read_surface(&self.input, &options.prepare)?;
        let mesh = &prepared.mesh;
        let context = session.context.clone();
        let mut wanted = options.graph.clone();
        wanted.features = options.features.load(session, &prepared)?;
        wanted.edge_length = options.edge_length.map(|l| l.resolve(mesh.diagonal()));
        let found = context.install(|| motorcycle_graph(mesh, &wanted, &context))?;
        found.warnings.iter().for_each(|what| session.warn(what.clone()));
        warn_missing(&found.missing, &prepared, session);
        describe(session, &found);
        tell_features(&found.features, session);
        self.write(session, &prepared.mesh, found)
    }
}

impl Motorcycle {
    fn write(&self, session: &mut Session, source: &SurfaceMesh, found: MotorcycleGraph) -> Result<(), Error> {
        session.draw_as(|| graph_figure(&found))?;
        session.show_result(self.output.as_deref(), |name, _| {
            Ok(with_dropped(Scene::of_graph(name, &found)?, &found.features))
        })?;
        if let Some(file) = &self.layout {
            session.write_bytes(file, &found.layout())?;
        }
        let mut mesh = RawMesh::from(found.mesh.clone());
        session.carry(source, &mut mesh)?;
        let mut counts = json!({ "vertices": mesh.points.len(), "faces": mesh.faces.len() });
        if let Some(file) = &self.output {
            counts["file"] = json!(file.to_string_lossy());
            session.write_mesh(file, &mesh, &WriteOptions::default())?;
        }
        session.record.set("output", counts);
        session.keep(|| Found::Graph(mesh, found));
        Ok(())
    }
}

/// The record's figures and the summary.
fn describe(session: &mut Session, found: &MotorcycleGraph) {
    let tracks = |kind: TrackKind| found.tracks.iter().filter(move |t: &&Track| t.kind == kind).count();
    let [motorcycles, cuts, shortcuts] = [TrackKind::Motorcycle, TrackKind::Cut, TrackKind::Shortcut].map(tracks);
    let discs = found.patches.iter().filter(|p| p.is_disc()).count();
    let regular = found.regular();
    let mut corners: BTreeMap<usize, usize> = BTreeMap::new();
    found.patches.iter().filter(|p| p.is_disc()).for_each(|p| *corners.entry(p.corners).or_default() += 1);
    let inner = found.starts.iter().filter(|s| s.inner).count();
    let (sectors, taken_back) = (found.starts.len() - inner, found.taken_back());
    session.say(format!("{} patches: {regular} for a grid of quads, {discs} discs", found.patches.len()));
    session.say(format!(
        "{motorcycles} tracks from {inner} singular vertices and {sectors} corners, {taken_back} taken back; {} cuts",
        cuts + shortcuts
    ));
    session.record.set("patches", found.patches.len());
    session.record.set("regular", regular);
    session.record.set("discs", discs);
    session.record.set("corners", corners);
    session.record.set("nodes", found.nodes.len());
    session.record.set("arcs", found.arcs.len());
    session.record.set("tracks", json!({ "motorcycle": motorcycles, "cut": cuts, "shortcut": shortcuts }));
    session.record.set("starts", json!({ "inner": inner, "sectors": sectors, "taken_back": taken_back }));
}
