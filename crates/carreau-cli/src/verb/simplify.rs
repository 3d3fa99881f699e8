//! `simplify` and `enrich`: a graded mesh within an angle of the surface.

use super::features::{FeatureFlags, FeatureValues, tell_features, warn_missing, with_both};
use crate::common::{Common, CommonValues, positive_length};
use crate::host::Found;
use crate::outputs::Outputs;
use crate::prepare::PrepareFlags;
use crate::replay::options_from;
use crate::session::{Failure, Session};
use carreau::io::{ResultKind, holds_numbers};
use carreau::mesh::{PrepareOptions, Prepared, RawMesh, SurfaceMesh};
use carreau::remesh::{self, RemeshOptions, Remeshed};
use carreau::report::page::Scene;
use carreau::{Error, Length};
use clap::Args;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Coarsens a surface to an angular deviation, a number of triangles or a distance
///
/// Ridges, corners, borders and tagged edges are kept. PLY and VTU files carry the vertex property size: the edge length that
/// the size map asks for.
#[derive(Args)]
#[command(after_help = "Examples:\n  \
    carreau simplify scan.ply -o coarse.ply --deviation 14 --json coarse.json\n  \
    carreau simplify scan.ply -o coarse.obj --triangles 20000\n  \
    carreau simplify scan.ply -o light.glb --triangles 5000 --geometric\n  \
    carreau simplify part.stl -o coarse.vtu --distance 1% --feature-angle 30")]
pub struct Simplify {
    #[command(flatten)]
    pub(super) remesh: Remesh,
    /// Number of triangles, met within 1 % by scaling the sizes
    #[arg(long, value_name = "N", conflicts_with = "distance")]
    triangles: Option<usize>,
    /// Largest two-sided distance between input and output, met by scaling the sizes
    #[arg(long, value_name = "LENGTH")]
    distance: Option<Length>,
    /// Enriches to this angle first, in degrees, or off [default: off]
    #[arg(long, value_name = "DEG|off", value_parser = number_or_off)]
    enrich: Option<OrOff>,
    /// Makes edges longer in the direction in which the surface bends less
    #[arg(long, conflicts_with = "geometric")]
    anisotropic: bool,
    /// Ignores the shape of triangles: stays as close to the surface as their number allows
    #[arg(long, conflicts_with = "enrich")]
    geometric: bool,
}

/// Refines a surface to an angular deviation
///
/// Long edges are split; new vertices lie on curved patches that follow the vertex normals. PLY and VTU files carry the vertex
/// property size: the edge length that the size map asks for.
#[derive(Args)]
#[command(after_help = "Example:\n  carreau enrich part.stl -o fine.ply --deviation 2 --gradation 1.5")]
pub struct Enrich {
    #[command(flatten)]
    pub(super) remesh: Remesh,
}

/// What both verbs have.
#[derive(Args)]
pub(super) struct Remesh {
    /// The surface; polygons are cut into fans of triangles
    input: PathBuf,
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
    pub(super) common: Common,
}

/// A number, or `off`.
#[derive(Debug, Clone, Copy)]
struct OrOff(Option<f64>);

fn number_or_off(text: &str) -> Result<OrOff, String> {
    match text {
        "off" => Ok(OrOff(None)),
        _ => text.parse().map(|x| OrOff(Some(x))).map_err(|_| format!("'{text}' is neither a number nor off")),
    }
}

/// What replays a run.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(default)]
struct Options {
    #[serde(flatten)]
    remesh: RemeshOptions,
    /// Lengths stay as they were given: their shares refer to the input.
    distance: Option<Length>,
    min_size: Option<Length>,
    max_size: Option<Length>,
    #[serde(flatten)]
    prepare: PrepareOptions,
    features: FeatureValues,
    #[serde(flatten)]
    common: CommonValues,
}

impl Options {
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

impl Simplify {
    /// Runs the verb.
    pub fn run(&self) -> Result<(), Failure> {
        let mut options = self.remesh.options("simplify", RemeshOptions::default())?;
        let o = &mut options.remesh;
        o.triangles = self.triangles.or(o.triangles);
        o.enrich = self.enrich.map_or(o.enrich, |e| e.0);
        o.geometric |= self.geometric;
        o.anisotropic |= self.anisotropic;
        options.distance = self.distance.or(options.distance);
        positive_length("distance", options.distance)?;
        options.remesh.validate()?;
        self.remesh.run("simplify", &options, remesh::simplify)
    }
}

impl Enrich {
    /// Runs the verb.
    pub fn run(&self) -> Result<(), Failure> {
        let options = self.remesh.options("enrich", RemeshOptions { deviation: 5.0, ..RemeshOptions::default() })?;
        self.remesh.run("enrich", &options, remesh::enrich)
    }
}

type Method = fn(&SurfaceMesh, &RemeshOptions, &carreau::Context) -> Result<Remeshed, Error>;

impl Remesh {
    /// The files of a run.
    pub fn outputs(&self) -> Outputs {
        let files = Outputs::of(&self.common).reads(&self.input, ResultKind::Surface);
        files.writes(self.output.as_deref(), ResultKind::Surface)
    }

    /// Defaults, then options file, then flags.
    fn options(&self, verb: &str, defaults: RemeshOptions) -> Result<Options, Error> {
        let base = Options { remesh: defaults, ..Options::default() };
        let mut all = options_from(self.common.options.as_deref(), verb, base)?;
        let o = &mut all.remesh;
        o.deviation = self.deviation.unwrap_or(o.deviation);
        o.gradation = self.gradation.map_or(o.gradation, |g| g.0);
        o.labels = self.labels.clone().or(o.labels.take());
        o.sizes = self.sizes.clone().or(o.sizes.take());
        all.features = self.features.over(all.features);
        all.min_size = self.min_size.or(all.min_size);
        all.max_size = self.max_size.or(all.max_size);
        all.prepare = self.prepare.over(all.prepare);
        all.common = self.common.over(all.common);
        for (name, length) in [("min-size", all.min_size), ("max-size", all.max_size), ("distance", all.distance)] {
            positive_length(name, length)?;
        }
        all.features.validate()?;
        all.check_sizes()?;
        all.remesh.validate()?;
        Ok(all)
    }

    fn run(&self, verb: &'static str, options: &Options, method: Method) -> Result<(), Failure> {
        Session::run(verb, &self.common, &options.common, Some(&self.input), |session| {
            session.record.set("options", options);
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
        })
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
