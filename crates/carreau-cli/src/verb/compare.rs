//! `compare`: how far two surfaces are apart.

use super::{intersection_line, intersections};
use crate::common::{Common, CommonValues};
use crate::outputs::Outputs;
use crate::prepare::PrepareFlags;
use crate::replay::options_from;
use crate::session::{Failure, Session, named};
use carreau::Error;
use carreau::geometry::distance::{DistanceOptions, compare};
use carreau::geometry::quality::SurfaceQuality;
use carreau::mesh::{PrepareOptions, PrepareReport, SurfaceMesh, Takes};
use clap::Args;
use serde::{Deserialize, Serialize};
use serde_json::{Map, json};
use std::path::{Path, PathBuf};

/// Compares two surfaces: two-sided distance, angle between normals, quality of both
#[derive(Args)]
#[command(
    after_help = "Examples:\n  carreau compare scan.ply simplified.ply\n  carreau compare a.stl b.stl --json - | jq .distance"
)]
pub struct Compare {
    /// The first surface; shares of the diagonal refer to it
    a: PathBuf,
    /// The second surface
    b: PathBuf,
    /// Samples on each surface, in addition to its vertices [default: 200000]
    #[arg(long, value_name = "N")]
    samples: Option<usize>,
    #[command(flatten)]
    prepare: PrepareFlags,
    #[command(flatten)]
    pub(super) common: Common,
}

#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(default)]
struct Options {
    #[serde(flatten)]
    distance: DistanceOptions,
    #[serde(flatten)]
    prepare: PrepareOptions,
    #[serde(flatten)]
    common: CommonValues,
}

impl Compare {
    /// The files of a run.
    pub fn outputs(&self) -> Outputs {
        Outputs::of(&self.common).needs(Some(&self.a)).needs(Some(&self.b))
    }

    /// Runs the verb.
    pub fn run(&self) -> Result<(), Failure> {
        let mut options = options_from(self.common.options.as_deref(), "compare", Options::default())?;
        options.distance.samples = self.samples.unwrap_or(options.distance.samples);
        options.prepare = self.prepare.over(options.prepare);
        options.distance.validate()?;
        options.common = self.common.over(options.common);
        Session::run("compare", &self.common, &options.common, Some(&self.a), |session| {
            session.record.set("options", &options);
            // The record's `input` is the first file: it is read last, so that its counts stay.
            let (b, prepared_b) = read(session, &self.b, &options.prepare)?;
            let (a, prepared_a) = read(session, &self.a, &options.prepare)?;
            session.record.set("prepared", json!({ "a": prepared_a, "b": prepared_b }));
            session.show_equal(&[&self.a, &self.b]);
            let mut crossed = Map::new();
            let context = session.context.clone();
            let found = context.install(|| {
                let _stage = context.stage("distance");
                compare(&a, &b, &options.distance, &context)
            })?;
            let (d, share) = (found.distance, found.relative);
            session.say(format!("diagonal of the first: {}", found.diagonal));
            session.say(format!("distance mean {:.6e} ({:.4} % of the diagonal)", d.mean, 100.0 * share.mean));
            session.say(format!("distance rms  {:.6e} ({:.4} %)", d.rms, 100.0 * share.rms));
            session.say(format!(
                "distance max  {:.6e} ({:.4} %), certainly below {:.6e}",
                d.max,
                100.0 * share.max,
                d.max_upper
            ));
            if let Some(angle) = &found.normal_deg {
                session.say(format!("normals: mean {:.3}°, max {:.3}°", angle.mean, angle.max));
            }
            for (name, mesh) in [("a", &a), ("b", &b)] {
                let crossings = intersections(session, mesh)?;
                intersection_line(&crossings).into_iter().for_each(|line| session.say(format!("{name}: {line}")));
                crossed.insert(name.into(), json!(crossings));
            }
            session.record.set("intersections", crossed);
            session.record.set_all(&found);
            session.draw(&a.clone().into())?;
            session.record.set("quality", json!({ "a": SurfaceQuality::of(&a), "b": SurfaceQuality::of(&b) }));
            Ok(())
        })
    }
}

/// Reads a surface and prepares it; what is wrong with it is told with its name.
fn read(session: &mut Session, file: &Path, options: &PrepareOptions) -> Result<(SurfaceMesh, PrepareReport), Error> {
    let mesh = session.read(file)?.into_surface().map_err(|error| named(file, error))?;
    let prepared = session.prepare(mesh, options, Takes::Bodies)?;
    Ok((prepared.mesh, prepared.report))
}
