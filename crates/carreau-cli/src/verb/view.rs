//! `view`: files as one page to look at.

use crate::common::{Common, CommonValues};
use crate::outputs::{Content, Outputs};
use crate::session::{Failure, Session, named};
use carreau::Error;
use carreau::io::{self, is_skeleton_file};
use carreau::report::page::{Role, Scene};
use clap::Args;
use serde::Serialize;
use serde_json::json;
use std::path::{Path, PathBuf};

/// Writes meshes and skeletons into one HTML page that works offline
///
/// The page shows one file, or two side by side: faces and cells coloured by any property, sharp edges, quality with the
/// worst elements, slices through volume meshes. A click on an element shows its numbers. Curvatures are measured if a
/// triangle mesh has none.
#[derive(Args)]
#[command(after_help = "Examples:\n  \
    carreau view part.ply -o part.html\n  \
    carreau view scan.ply simplified.ply -o both.html\n  \
    carreau view vessel.vtu vessel.cgr -o vessel.html")]
pub struct View {
    /// Meshes and skeletons
    #[arg(required = true, value_name = "FILE")]
    inputs: Vec<PathBuf>,
    /// The page to write
    #[arg(short, long, value_name = "FILE.html")]
    output: PathBuf,
    /// Does not measure curvatures
    #[arg(long)]
    no_curvature: bool,
    #[command(flatten)]
    common: Common,
}

#[derive(Serialize)]
struct Options {
    curvature: bool,
    #[serde(flatten)]
    common: CommonValues,
}

impl View {
    /// The files of a run.
    pub fn outputs(&self) -> Outputs {
        let files = self.inputs.iter().fold(Outputs::of(&self.common), |files, input| files.needs(Some(input)));
        files.also("--output", Some(&self.output), Content::Page)
    }

    /// Runs the verb.
    pub fn run(&self) -> Result<(), Failure> {
        let options = Options { curvature: !self.no_curvature, common: self.common.over(CommonValues::default()) };
        Session::run("view", &self.common, &options.common, None, |session| {
            session.report_to(&self.output);
            session.record.set("options", &options);
            for file in &self.inputs {
                self.add(session, file).map_err(|error| named(file, error))?;
            }
            session.show_equal(&self.inputs.iter().map(PathBuf::as_path).collect::<Vec<_>>());
            session.record.set("inputs", &self.inputs);
            session.record.set("output", json!({ "file": self.output.to_string_lossy(), "scenes": self.inputs.len() }));
            Ok(())
        })
    }

    fn add(&self, session: &mut Session, file: &Path) -> Result<(), Error> {
        if is_skeleton_file(file) {
            return session.read_skeleton(file).map(drop);
        }
        let mesh = session.read(file)?;
        // Lines alone may be a skeleton with radii.
        let is_lines = mesh.faces.is_empty() && mesh.cells.is_empty() && !mesh.edges.is_empty();
        if let Some(net) = is_lines.then(|| io::read_skeleton(file).ok()).flatten() {
            return session.show(file, Role::Other, |name, _| Ok(Scene::of_net(name, &net)));
        }
        if Some(file) == self.inputs.first().map(PathBuf::as_path) {
            session.draw(&mesh)?;
        }
        session.show(file, Role::Other, |name, context| {
            let scene = Scene::of_mesh(name, &mesh)?;
            if self.no_curvature { Ok(scene) } else { scene.with_curvature(context) }
        })
    }
}
