//! `view`: files as one page to look at.

use super::contract::Verb;
use crate::common::Common;
use crate::failure::named;
use crate::outputs::{Content, Outputs};
use crate::session::Session;
use carreau::Error;
use carreau::io::{self, is_skeleton_file};
use carreau::report::page::{Role, Scene};
use clap::Args;
use serde::{Deserialize, Serialize};
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

/// What replays a run.
#[derive(Serialize, Deserialize)]
#[serde(default)]
pub struct Options {
    curvature: bool,
}

impl Default for Options {
    fn default() -> Self {
        Options { curvature: true }
    }
}

impl Verb for View {
    const NAME: &'static str = "view";
    const IS_CALLABLE: bool = false;
    type Options = Options;

    fn common(&self) -> &Common {
        &self.common
    }

    fn common_mut(&mut self) -> &mut Common {
        &mut self.common
    }

    fn files(&self) -> Outputs {
        let files = self.inputs.iter().fold(Outputs::of(&self.common), |files, input| files.needs(Some(input)));
        files.also("--output", Some(&self.output), Content::Page)
    }

    fn defaults(&self) -> Options {
        Options::default()
    }

    fn lay_over(&self, all: &mut Options) -> Result<(), Error> {
        all.curvature &= !self.no_curvature;
        Ok(())
    }

    fn work(&self, session: &mut Session, options: &Options) -> Result<(), Error> {
        session.report_to(&self.output);
        for file in &self.inputs {
            self.add(session, file, options).map_err(|error| named(file, error))?;
        }
        session.show_equal(&self.inputs.iter().map(PathBuf::as_path).collect::<Vec<_>>());
        session.record.set("inputs", &self.inputs);
        session.record.set("output", json!({ "file": self.output.to_string_lossy(), "scenes": self.inputs.len() }));
        Ok(())
    }
}

impl View {
    fn add(&self, session: &mut Session, file: &Path, options: &Options) -> Result<(), Error> {
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
            if options.curvature { scene.with_curvature(context) } else { Ok(scene) }
        })
    }
}
