//! `quad`: an all-quad mesh that keeps every feature.

use super::contract::Verb;
use crate::choice::choice;
use crate::common::{Common, positive_length};
use crate::features::{FeatureFlags, FeatureValues, load_guides, tell_features, warn_missing, with_dropped};
use crate::host::Found;
use crate::outputs::Outputs;
use crate::prepare::PrepareFlags;
use crate::session::Session;
use carreau::io::ResultKind;
use carreau::mesh::{PrepareOptions, RawMesh};
use carreau::quad::{self, QuadOptions, Quads, Symmetry};
use carreau::report::page::Scene;
use carreau::{Error, Length};
use clap::Args;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Makes an all-quad mesh that keeps every feature
///
/// Features (sharp edges, borders, edges tagged in the file and those of --features) are paths of edges of the result; formats
/// with tags get them as tagged edges. The face property region numbers the regions between features.
#[derive(Args)]
#[command(after_help = "Examples:\n  \
    carreau quad part.stl -o quads.obj\n  \
    carreau quad part.obj -o quads.mesh --quads 2000 --json quads.json --picture quads.png\n  \
    carreau quad scan.ply -o quads.vtu --edge-length 2% --feature-angle 180\n  \
    carreau quad scan.ply -o quads.obj --symmetry auto --adaptive")]
pub struct Quad {
    /// The surface; polygons are cut into triangles
    input: PathBuf,
    /// The file to write
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Number of quads, met within 10 % where the features allow it [default: 3000]
    #[arg(long, value_name = "N", conflicts_with = "edge_length")]
    quads: Option<usize>,
    /// Length of the quads' edges instead
    #[arg(long, value_name = "LENGTH")]
    edge_length: Option<Length>,
    /// Makes quads smaller where the surface bends and larger where it is flat; their number stays
    #[arg(long, conflicts_with = "sizes")]
    adaptive: bool,
    /// A vertex property that says how long the edges are to be, relative to each other; of a colour, red makes quads smaller
    #[arg(long, value_name = "PROPERTY")]
    sizes: Option<String>,
    /// Makes the quads of one half and mirrors them: across an axis, or across all planes of symmetry that the surface has
    /// [default: off]
    #[arg(long, value_name = "off|x|y|z|auto", value_parser = choice::<Symmetry>(&["off", "x", "y", "z", "auto"]))]
    symmetry: Option<Symmetry>,
    /// A file of polylines on the surface that rows of quads follow, such as an OBJ with l lines
    #[arg(long, value_name = "FILE")]
    guides: Option<PathBuf>,
    /// Weight of the directions of curvature in the field; 0 gives fewer irregular vertices, larger ones run along limbs more
    /// strictly [default: 0.03]
    #[arg(long, value_name = "WEIGHT")]
    curvature: Option<f64>,
    /// Refuses meshes with more quads than this
    #[arg(long, value_name = "N")]
    max_quads: Option<usize>,
    #[command(flatten)]
    features: FeatureFlags,
    /// The first method to try: 1 (the map, best), 3 (pairs) or 4 (always gives a mesh) [default: 1]
    #[arg(long, value_name = "N")]
    rung: Option<u32>,
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
    quad: QuadOptions,
    edge_length: Option<Length>,
    guides: Option<PathBuf>,
    #[serde(flatten)]
    features: FeatureValues,
    #[serde(flatten)]
    prepare: PrepareOptions,
}

impl Verb for Quad {
    const NAME: &'static str = "quad";
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
        files.writes(self.output.as_deref(), ResultKind::Surface)
    }

    fn defaults(&self) -> Options {
        Options::default()
    }

    fn lay_over(&self, all: &mut Options) -> Result<(), Error> {
        all.quad.quads = self.quads.unwrap_or(all.quad.quads);
        all.quad.rung = self.rung.unwrap_or(all.quad.rung);
        all.edge_length = if self.quads.is_some() { None } else { self.edge_length.or(all.edge_length) };
        all.quad.adaptive |= self.adaptive;
        all.quad.sizes = if self.adaptive { None } else { self.sizes.clone().or(all.quad.sizes.take()) };
        all.quad.symmetry = self.symmetry.unwrap_or(all.quad.symmetry);
        all.quad.curvature = self.curvature.unwrap_or(all.quad.curvature);
        all.quad.max_quads = self.max_quads.or(all.quad.max_quads);
        all.guides = self.guides.clone().or(all.guides.take());
        all.features = self.features.over(std::mem::take(&mut all.features));
        all.prepare = self.prepare.over(all.prepare);
        positive_length("edge-length", all.edge_length)?;
        all.features.validate()?;
        all.quad.validate()?;
        Ok(())
    }

    fn work(&self, session: &mut Session, options: &Options) -> Result<(), Error> {
        let prepared = session.read_surface(&self.input, &options.prepare)?;
        let mesh = &prepared.mesh;
        let context = session.context.clone();
        let mut wanted = options.quad.clone();
        wanted.features = options.features.load(session, &prepared)?;
        wanted.guides = load_guides(session, options.guides.as_deref())?;
        wanted.edge_length = options.edge_length.map(|l| l.resolve(mesh.diagonal()));
        let result = context.install(|| quad::quads(mesh, &wanted, &context))?;
        result.warnings.iter().for_each(|what| session.warn(what.clone()));
        warn_missing(&result.missing, &prepared, session);
        describe(session, &result);
        tell_features(&result.features, session);
        let (mut quads, found) = (RawMesh::from(result.mesh), result.features);
        session.carry(&prepared.mesh, &mut quads)?;
        let mesh = quads;
        let scene = |name| Ok(with_dropped(Scene::of_mesh(name, &mesh)?, &found));
        session.deliver_as(&mesh, self.output.as_deref(), scene)?;
        session.keep(|| Found::Mesh(mesh));
        Ok(())
    }
}

/// The record's figures and the summary.
fn describe(session: &mut Session, result: &Quads) {
    let q = &result.quality;
    let count = result.mesh.face_count();
    session.say(format!("{count} quads, {} regions, rung {}", result.rungs.len(), result.rung()));
    session.say(format!(
        "scaled Jacobian: min {:.3}, mean {:.3}; {} irregular vertices, {} inverted quads",
        q.scaled_jacobian_min, q.scaled_jacobian_mean, q.irregular, q.inverted
    ));
    for plane in &result.symmetry {
        let ([x, y, z], offset) = (plane.normal.to_array(), plane.offset);
        session.say(format!(
            "symmetric about the plane {x:.4} x + {y:.4} y + {z:.4} z = {offset:.4}; the input is up to {:.3e} off its mirror image",
            plane.asymmetry
        ));
    }
    session.say(format!("features kept: {:.3} %", 100.0 * q.feature_recall));
    if let Some((found, bound)) = q.distance_found.zip(q.distance_max) {
        let [found, bound] = [found, bound].map(|share| 100.0 * share);
        session.say(format!("distance: {found:.4} % of the diagonal was found, at most {bound:.4} %"));
    }
    session.record.set("quality", q);
    session.record.set("quads", count);
    session.record.set("rung", result.rung());
    session.record.set("rungs", &result.rungs);
    session.record.set("symmetry", &result.symmetry);
}
