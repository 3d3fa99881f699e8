//! `field`: a frame field along the features of a part.

use super::contract::Verb;
use crate::choice::choice;
use crate::common::Common;
use crate::features::{FeatureFlags, FeatureValues, load_guides, tell_features, warn_missing, with_dropped};
use crate::host::Found;
use crate::outputs::{Content, Outputs};
use crate::prepare::PrepareFlags;
use crate::session::Session;
use carreau::field::{self, FieldOptions, Pin, Propagation};
use carreau::io::{ResultKind, WriteOptions};
use carreau::mesh::{Column, PrepareOptions, RawMesh, SurfaceMesh};
use carreau::report::field_figure;
use carreau::report::page::Scene;
use carreau::{DVec3, Error};
use clap::Args;
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::path::{Path, PathBuf};

/// Computes a frame field along the features, with room for a quad in every corner
///
/// Writes the mesh that carries the field (the input with a few splits) with the face vectors u and v; PLY, VTU, VTP and
/// VTK keep them. Features are sharp edges, borders, edges tagged in the file and those of --features.
#[derive(Args)]
#[command(after_help = "Examples:\n  \
    carreau field part.stl -o field.vtu --picture field.png\n  \
    carreau field part.obj --layout field.json --json -\n  \
    carreau field part.obj --pin none --orthogonal --json - | jq .poles")]
pub struct Field {
    /// The surface; polygons are cut into triangles
    input: PathBuf,
    /// The file to write; PLY, VTU, VTP and VTK keep the frames
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Writes mesh, frames, matchings and the quads of every corner (JSON)
    #[arg(long, value_name = "FILE.json")]
    layout: Option<PathBuf>,
    /// Keeps the two directions orthogonal
    #[arg(long)]
    orthogonal: bool,
    /// Gives corners below this angle one quad; none: the classic field, without any repair [default: 90]
    #[arg(long, value_name = "ANGLE", value_parser = choice::<Pin>(&["none", "45", "90"]))]
    pin: Option<Pin>,
    /// How far the rotation that pinned corners need spreads [default: local]
    #[arg(long, value_name = "HOW", value_parser = choice::<Propagation>(&["none", "local", "global"]))]
    propagation: Option<Propagation>,
    /// Largest angle by which the two directions lean towards each other, in degrees [default: 60]
    #[arg(long, value_name = "DEG")]
    lean: Option<f64>,
    /// Weight of the directions of curvature beside the smoothness; 1 counts as much where the field would turn within the radius
    /// of the curvature [default: 0]
    #[arg(long, value_name = "WEIGHT")]
    curvature: Option<f64>,
    /// A file of polylines on the surface that the field follows, such as an OBJ with l lines
    #[arg(long, value_name = "FILE")]
    guides: Option<PathBuf>,
    #[command(flatten)]
    features: FeatureFlags,
    /// Also counts the corners without room and the singularities of the classic field
    #[arg(long)]
    classic: bool,
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
    field: FieldOptions,
    guides: Option<PathBuf>,
    #[serde(flatten)]
    features: FeatureValues,
    classic: bool,
    #[serde(flatten)]
    prepare: PrepareOptions,
}

impl Verb for Field {
    const NAME: &'static str = "field";
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
        let files = files.needs(self.guides.as_deref());
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
        let o = &mut all.field;
        o.orthogonal |= self.orthogonal;
        o.pin = self.pin.unwrap_or(o.pin);
        o.propagation = self.propagation.unwrap_or(o.propagation);
        o.lean_deg = self.lean.unwrap_or(o.lean_deg);
        o.curvature = self.curvature.unwrap_or(o.curvature);
        all.guides = self.guides.clone().or(all.guides.take());
        all.features = self.features.over(std::mem::take(&mut all.features));
        all.classic |= self.classic;
        all.prepare = self.prepare.over(all.prepare);
        all.features.validate()?;
        all.field.validate()?;
        Ok(())
    }

    fn work(&self, session: &mut Session, options: &Options) -> Result<(), Error> {
        let prepared = session.read_surface(&self.input, &options.prepare)?;
        let mesh = &prepared.mesh;
        let context = session.context.clone();
        let mut wanted = options.field.clone();
        wanted.features = options.features.load(session, &prepared)?;
        wanted.guides = load_guides(session, options.guides.as_deref())?;
        let mut found = context.install(|| field::field(mesh, &wanted, &context))?;
        if mesh.is_triangular() {
            found.source.iter_mut().for_each(|t| *t = prepared.face(*t));
        }
        found.repaired.iter().for_each(|what| session.warn(what.clone()));
        warn_missing(&found.missing, &prepared, session);
        describe(session, &found);
        tell_features(&found.found, session);
        if options.classic {
            let classic = context.install(|| {
                let _stage = context.stage("classic field");
                field::field(mesh, &wanted.classic(), &context)
            })?;
            let ([sectors, inner], singular) = (classic.poles(), classic.singularities());
            session.say(format!(
                "classic field: {sectors} corners without a quad, {inner} tips, {singular} singularities"
            ));
            let counts = json!({ "sectors": sectors, "inner": inner, "singularities": singular });
            session.record.set("classic", counts);
        }
        self.write(session, &prepared.mesh, found)
    }
}

impl Field {
    fn write(&self, session: &mut Session, source: &SurfaceMesh, found: field::Field) -> Result<(), Error> {
        let mut mesh = with_frames(&found);
        session.carry(source, &mut mesh)?;
        session.draw_as(|| field_figure(&found))?;
        session.show_result(self.output.as_deref(), |name, _| {
            Ok(with_dropped(Scene::of_field(name, &found)?, &found.found))
        })?;
        if let Some(file) = &self.layout {
            session.write_bytes(file, &found.layout())?;
        }
        let mut counts = json!({
            "vertices": found.mesh.vertex_count(),
            "faces": found.mesh.face_count(),
            "features": found.features.len(),
            "singularities": found.singularities(),
        });
        if let Some(file) = &self.output {
            counts["file"] = json!(file.to_string_lossy());
            session.write_mesh(file, &mesh, &WriteOptions::default())?;
        }
        session.record.set("output", counts);
        session.keep(|| Found::Field(mesh, found));
        Ok(())
    }
}

/// The mesh that carries the field, with its frames and features.
fn with_frames(found: &field::Field) -> RawMesh {
    let mut out = RawMesh::from(found.mesh.clone());
    let vectors = |v: &[DVec3]| Column::Vector3(v.iter().map(DVec3::to_array).collect());
    let columns = [("u", vectors(&found.u)), ("v", vectors(&found.v))];
    out.attributes.face.extend(columns.map(|(name, column)| (name.to_string(), column)));
    (out.edge_tags, out.edges) = (vec![1; found.features.len()], found.features.clone());
    out
}

/// The record's figures and the summary.
fn describe(session: &mut Session, found: &field::Field) {
    let ([sectors, inner], singular) = (found.poles(), found.singularities());
    let [before, after] = found.energy;
    let count = |quads: i32| found.corners.iter().filter(|c| c.closed && c.quads == quads).count();
    session.say(format!(
        "{} triangles, {singular} singularities ({} of three quads, {} of five)",
        found.mesh.face_count(),
        count(3),
        count(5)
    ));
    session.say(format!("{sectors} corners without a quad, {inner} tips with fewer than three"));
    let drop = 100.0 * (1.0 - after / before.max(f64::MIN_POSITIVE));
    session.say(format!("energy {after:.4}, {drop:.1} % below the orthogonal field's {before:.4}"));
    let quality = json!({
        "energy_orthogonal": before,
        "energy": after,
        "lean_max_deg": found.lean_deg(),
        "rounds": found.rounds,
        "moved": found.moved,
    });
    session.record.set("quality", quality);
    session.record.set("singularities", singular);
    session.record.set("poles", json!({ "sectors": sectors, "inner": inner }));
}
