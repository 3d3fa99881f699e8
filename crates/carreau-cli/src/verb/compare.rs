//! `compare`: how far two surfaces are apart.

use super::contract::Verb;
use crate::common::Common;
use crate::defects::{intersection_line, intersections};
use crate::failure::named;
use crate::outputs::Outputs;
use crate::prepare::PrepareFlags;
use crate::session::Session;
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
    common: Common,
}

#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Options {
    #[serde(flatten)]
    distance: DistanceOptions,
    #[serde(flatten)]
    prepare: PrepareOptions,
}

impl Verb for Compare {
    const NAME: &'static str = "compare";
    type Options = Options;

    fn common(&self) -> &Common {
        &self.common
    }

    fn common_mut(&mut self) -> &mut Common {
        &mut self.common
    }

    fn subject(&self) -> Option<&Path> {
        Some(&self.a)
    }

    fn files(&self) -> Outputs {
        Outputs::of(&self.common).needs(Some(&self.a)).needs(Some(&self.b))
    }

    fn defaults(&self) -> Options {
        Options::default()
    }

    fn lay_over(&self, all: &mut Options) -> Result<(), Error> {
        all.distance.samples = self.samples.unwrap_or(all.distance.samples);
        all.prepare = self.prepare.over(all.prepare);
        all.distance.validate()?;
        Ok(())
    }

    fn work(&self, session: &mut Session, options: &Options) -> Result<(), Error> {
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
    }
}

/// Reads a surface and prepares it; what is wrong with it is told with its name.
fn read(session: &mut Session, file: &Path, options: &PrepareOptions) -> Result<(SurfaceMesh, PrepareReport), Error> {
    let mesh = session.read(file)?.into_surface().map_err(|error| named(file, error))?;
    let prepared = session.prepare(mesh, options, Takes::Bodies)?;
    Ok((prepared.mesh, prepared.report))
}
