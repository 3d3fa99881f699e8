//! `sample`: built-in procedural models.

use crate::common::{Common, CommonValues};
use crate::outputs::Outputs;
use crate::session::{Failure, Session};
use carreau::io::ResultKind;
use carreau::io::WriteOptions;
use carreau::report::page::Scene;
use carreau::sample::{SAMPLES, make};
use carreau::{Error, mesh::RawMesh};
use clap::Args;
use serde_json::json;
use std::path::PathBuf;

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

impl Sample {
    /// The files of a run.
    pub fn outputs(&self) -> Outputs {
        Outputs::of(&self.common).writes(self.output.as_deref(), ResultKind::Surface)
    }

    /// Runs the verb.
    pub fn run(&self) -> Result<(), Failure> {
        let values = self.common.over(CommonValues::default());
        Session::run("sample", &self.common, &values, None, |session| match (&self.name, &self.output) {
            (Some(name), Some(output)) if !self.list => {
                session
                    .record
                    .set("options", json!({ "name": name, "resolution": self.resolution, "seed": values.seed }));
                let mesh: RawMesh = make(name, self.resolution, &session.context)?.into();
                session.draw(&mesh)?;
                session.show_result(Some(output), |name, _| Scene::of_mesh(name, &mesh))?;
                session.write_mesh(output, &mesh, &WriteOptions::default())?;
                let counts = json!({ "file": output.to_string_lossy(), "vertices": mesh.points.len(), "faces": mesh.faces.len() });
                session.record.set("output", counts);
                session.say(format!(
                    "{}: {} vertices, {} faces",
                    output.display(),
                    mesh.points.len(),
                    mesh.faces.len()
                ));
                Ok(())
            }
            _ => {
                for sample in SAMPLES {
                    session.say(format!("{:16} {}", sample.name, sample.summary));
                }
                let names: Vec<_> = SAMPLES.iter().map(|s| json!({ "name": s.name, "summary": s.summary })).collect();
                session.record.set("samples", names);
                Ok::<(), Error>(())
            }
        })
    }
}
