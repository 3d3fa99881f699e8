//! `sample`: built-in procedural models.

use super::contract::Verb;
use crate::common::Common;
use crate::outputs::Outputs;
use crate::session::Session;
use carreau::io::{ResultKind, WriteOptions};
use carreau::report::page::Scene;
use carreau::sample::{SAMPLES, make};
use carreau::{Error, mesh::RawMesh};
use clap::Args;
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::path::{Path, PathBuf};

/// Writes a built-in procedural model
#[derive(Args)]
#[command(after_help = "Examples:\n  carreau sample --list\n  carreau sample torus --resolution 64 -o torus.ply")]
pub struct Sample {
    /// Name of the model
    #[arg(required_unless_present = "list")]
    name: Option<String>,
    /// Lists the models
    #[arg(long)]
    list: bool,
    /// Makes edges of about 1/N of the bounding-box diagonal [default: depends on the model]
    #[arg(long, value_name = "N")]
    resolution: Option<u32>,
    /// The file to write
    #[arg(short, long, value_name = "FILE", required_unless_present = "list")]
    output: Option<PathBuf>,
    #[command(flatten)]
    common: Common,
}

/// What replays a run.
#[derive(Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Options {
    name: Option<String>,
    resolution: Option<u32>,
}

impl Verb for Sample {
    const NAME: &'static str = "sample";
    const IS_CALLABLE: bool = false;
    type Options = Options;

    fn common(&self) -> &Common {
        &self.common
    }

    fn common_mut(&mut self) -> &mut Common {
        &mut self.common
    }

    fn files(&self) -> Outputs {
        Outputs::of(&self.common).writes(self.output.as_deref(), ResultKind::Surface)
    }

    fn defaults(&self) -> Options {
        Options::default()
    }

    fn lay_over(&self, all: &mut Options) -> Result<(), Error> {
        all.name = self.name.clone().or(all.name.take());
        all.resolution = self.resolution.or(all.resolution);
        Ok(())
    }

    fn work(&self, session: &mut Session, options: &Options) -> Result<(), Error> {
        match (&options.name, &self.output) {
            (Some(name), Some(output)) if !self.list => write(session, name, options.resolution, output),
            _ => {
                list(session);
                Ok(())
            }
        }
    }
}

/// Makes a model and writes it.
fn write(session: &mut Session, name: &str, resolution: Option<u32>, output: &Path) -> Result<(), Error> {
    let mesh: RawMesh = make(name, resolution, &session.context)?.into();
    session.draw(&mesh)?;
    session.show_result(Some(output), |name, _| Scene::of_mesh(name, &mesh))?;
    session.write_mesh(output, &mesh, &WriteOptions::default())?;
    let counts = json!({ "file": output.to_string_lossy(), "vertices": mesh.points.len(), "faces": mesh.faces.len() });
    session.record.set("output", counts);
    session.say(format!("{}: {} vertices, {} faces", output.display(), mesh.points.len(), mesh.faces.len()));
    Ok(())
}

/// Lists the models.
fn list(session: &mut Session) {
    for sample in SAMPLES {
        session.say(format!("{:16} {}", sample.name, sample.summary));
    }
    let names: Vec<_> = SAMPLES.iter().map(|s| json!({ "name": s.name, "summary": s.summary })).collect();
    session.record.set("samples", names);
}
