//! What `simplify` and `enrich` share: their flags, and a run with either method of the room.

use crate::common::{Common, positive_length};
use crate::features::{FeatureFlags, FeatureValues, tell_features, warn_missing, with_both};
use crate::host::Found;
use crate::outputs::Outputs;
use crate::prepare::PrepareFlags;
use crate::session::Session;
use carreau::io::{ResultKind, holds_numbers};
use carreau::mesh::{PrepareOptions, Prepared, RawMesh, SurfaceMesh};
use carreau::remesh::{RemeshOptions, Remeshed};
use carreau::report::page::Scene;
use carreau::{Error, Length};
use clap::Args;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// What both verbs have.
#[derive(Args)]
pub struct Remesh {
    /// The surface; polygons are cut into fans of triangles
    pub input: PathBuf,
    /// The file to write
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Angle between edges and the surface, in degrees [default: 14; enrich: 5]
    #[arg(long, value_name = "DEG")]
    deviation: Option<f64>,
    /// Largest ratio of sizes over one unit of length [default: 1.5]
    #[arg(long, value_name = "B|off", value_parser = number_or_off)]
    gradation: Option<OrOff>,
    #[command(flatten)]
    features: FeatureFlags,
    /// A face property of integers; edges between two values are kept
    #[arg(long, value_name = "PROPERTY")]
    labels: Option<String>,
    /// A vertex property of numbers that limits the length of edges, in the unit of the file
    #[arg(long, value_name = "PROPERTY")]
    sizes: Option<String>,
    /// Smallest edge length [default: 0.02%]
    #[arg(long, value_name = "LENGTH")]
    min_size: Option<Length>,
    /// Largest edge length [default: 20%]
    #[arg(long, value_name = "LENGTH")]
    max_size: Option<Length>,
    #[command(flatten)]
    prepare: PrepareFlags,
    #[command(flatten)]
    pub common: Common,
}

/// A number, or `off`.
#[derive(Debug, Clone, Copy)]
pub struct OrOff(pub Option<f64>);

/// Reads a number, or `off`.
pub fn number_or_off(text: &str) -> Result<OrOff, String> {
    match text {
        "off" => Ok(OrOff(None)),
        _ => text.parse().map(|x| OrOff(Some(x))).map_err(|_| format!("'{text}' is neither a number nor off")),
    }
}

/// What replays a run.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct RemeshValues {
    #[serde(flatten)]
    pub remesh: RemeshOptions,
    /// Lengths stay as they were given: their shares refer to the input.
    pub distance: Option<Length>,
    min_size: Option<Length>,
    max_size: Option<Length>,
    #[serde(flatten)]
    prepare: PrepareOptions,
    features: FeatureValues,
}

impl From<RemeshOptions> for RemeshValues {
    fn from(remesh: RemeshOptions) -> Self {
        RemeshValues { remesh, ..RemeshValues::default() }
    }
}

impl RemeshValues {
    /// Refuses a smallest size above the largest, as far as that is known without the model.
    fn check_sizes(&self) -> Result<(), Error> {
        let base = &self.remesh;
        let low = self.min_size.unwrap_or(Length::OfDiagonal(base.min_size));
        let high = self.max_size.unwrap_or(Length::OfDiagonal(base.max_size));
        let turned = match (low, high) {
            (Length::Absolute(low), Length::Absolute(high)) | (Length::OfDiagonal(low), Length::OfDiagonal(high)) => {
                low > high
            }
            _ => false,
        };
        if turned { Err(Error::Options(format!("min-size {low} is above max-size {high}"))) } else { Ok(()) }
    }
}

/// A method of the room.
type Method = fn(&SurfaceMesh, &RemeshOptions, &carreau::Context) -> Result<Remeshed, Error>;

impl Remesh {
    /// The files of a run.
    pub fn files(&self) -> Outputs {
        let files = Outputs::of(&self.common).reads(&self.input, ResultKind::Surface);
        files.writes(self.output.as_deref(), ResultKind::Surface)
    }

    /// Lays the flags over the options, and refuses what does not go together.
    pub fn lay_over(&self, all: &mut RemeshValues) -> Result<(), Error> {
        let o = &mut all.remesh;
        o.deviation = self.deviation.unwrap_or(o.deviation);
        o.gradation = self.gradation.map_or(o.gradation, |g| g.0);
        o.labels = self.labels.clone().or(o.labels.take());
        o.sizes = self.sizes.clone().or(o.sizes.take());
        all.features = self.features.over(std::mem::take(&mut all.features));
        all.min_size = self.min_size.or(all.min_size);
        all.max_size = self.max_size.or(all.max_size);
        all.prepare = self.prepare.over(all.prepare);
        for (name, length) in [("min-size", all.min_size), ("max-size", all.max_size), ("distance", all.distance)] {
            positive_length(name, length)?;
        }
        all.features.validate()?;
        all.check_sizes()?;
        all.remesh.validate()
    }

    /// Does it by one of the methods.
    pub fn work(&self, session: &mut Session, options: &RemeshValues, method: Method) -> Result<(), Error> {
        let prepared = session.read_surface(&self.input, &options.prepare)?;
        let context = session.context.clone();
        let diagonal = prepared.mesh.diagonal();
        let mut wanted = options.remesh.clone();
        wanted.distance = options.distance.map(|d| d.resolve(diagonal));
        let share = |length: Length| length.resolve(diagonal) / diagonal.max(f64::MIN_POSITIVE);
        wanted.min_size = options.min_size.map_or(wanted.min_size, share);
        wanted.max_size = options.max_size.map_or(wanted.max_size, share);
        let features = options.features.load(session, &prepared)?;
        wanted.feature_angle = features.angle_deg.unwrap_or(180.0);
        wanted.creases = features.creases;
        wanted.tags = features.tags;
        wanted.feature_edges = features.edges;
        let result = context.install(|| method(&prepared.mesh, &wanted, &context))?;
        self.tell(session, &prepared, result)
    }

    fn tell(&self, session: &mut Session, prepared: &Prepared, result: Remeshed) -> Result<(), Error> {
        let source = &prepared.mesh;
        let context = session.context.clone();
        let mut quality = result.quality;
        // Distances take as long as the method itself: only a record asks for them.
        if self.common.json.is_some() {
            quality = context.install(|| quality.with_distance(source, &result.mesh, &context))?;
        }
        result.repaired.iter().for_each(|what| session.warn(what.clone()));
        let q = &quality;
        let (before, after) = (source.faces().fan().0.len(), result.mesh.face_count());
        session.say(format!("{after} triangles, before {before}"));
        session.say(format!("shape: min {:.3}, mean {:.3}", q.shape_min, q.shape_mean));
        session.say(format!(
            "edges in the metric: {:.2} to {:.2}, mean {:.3}; {:.2} % in [0.6, 1.7]",
            q.length_min,
            q.length_max,
            q.length_mean,
            100.0 * q.length_in_06_17
        ));
        session.say(format!(
            "deviation: mean {:.2}°, over the area {:.2}°, max {:.1}°",
            q.deviation_mean_deg, q.deviation_area_mean_deg, q.deviation_max_deg
        ));
        session.record.set("quality", quality);
        warn_missing(&result.missing, prepared, session);
        tell_features(&result.features, session);
        let (mut mesh, found) = (RawMesh::from(result.mesh), result.features);
        session.carry(source, &mut mesh)?;
        // Sizes are a help for the eye: formats without numbers on vertices go without, and without a word.
        if self.output.as_deref().is_some_and(|file| !holds_numbers(file)) {
            for name in ["size", "stretch"].into_iter().filter(|name| !source.attributes.vertex.contains_key(*name)) {
                mesh.attributes.vertex.remove(name);
            }
        }
        session
            .deliver_as(&mesh, self.output.as_deref(), |name| Ok(with_both(Scene::of_mesh(name, &mesh)?, &found)))?;
        session.keep(|| Found::Mesh(mesh));
        Ok(())
    }
}
