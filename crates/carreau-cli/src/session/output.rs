//! What a run makes beside its record: meshes, pictures and pages.

use super::run::Session;
use carreau::mesh::{CurveNet, RawMesh};
use carreau::report::figure;
use carreau::report::page::{Role, Scene};
use carreau::report::picture::Image;
use carreau::{Context, Error, io};
use serde_json::json;
use std::path::Path;

impl Session {
    /// Writes a mesh file.
    pub fn write_mesh(&mut self, file: &Path, mesh: &RawMesh, options: &io::WriteOptions) -> Result<(), Error> {
        self.context.check()?;
        let warnings = {
            let _stage = self.context.stage("write");
            io::write(file, mesh, options)?
        };
        warnings.into_iter().for_each(|w| self.warn(w));
        Ok(())
    }

    /// What most verbs end with: draws a mesh, writes it where that was asked for, and records what it has; with a scene of the
    /// verb's own. What is kept for a host is up to the verb.
    pub fn deliver_as(
        &mut self,
        mesh: &RawMesh,
        file: Option<&Path>,
        scene: impl FnOnce(String) -> Result<Scene, Error> + Send,
    ) -> Result<(), Error> {
        self.draw(mesh)?;
        self.show_result(file, |name, _| scene(name))?;
        let mut counts = json!({ "vertices": mesh.points.len(), "faces": mesh.faces.len() });
        if let Some(file) = file {
            counts["file"] = json!(file.to_string_lossy());
            self.write_mesh(file, mesh, &io::WriteOptions::default())?;
        }
        self.record.set("output", counts);
        Ok(())
    }

    /// Writes a skeleton.
    pub fn write_skeleton(&mut self, file: &Path, net: &CurveNet) -> Result<(), Error> {
        self.context.check()?;
        let warnings = {
            let _stage = self.context.stage("write");
            io::write_skeleton(file, net)?
        };
        warnings.into_iter().for_each(|w| self.warn(w));
        Ok(())
    }

    /// Draws a mesh where a picture was asked for.
    pub fn draw(&mut self, mesh: &RawMesh) -> Result<(), Error> {
        self.draw_as(|| figure(mesh))
    }

    /// Draws a figure of a verb's own where a picture was asked for.
    pub fn draw_as(&mut self, figure: impl FnOnce() -> Image + Send) -> Result<(), Error> {
        let Some(file) = self.picture.clone() else { return Ok(()) };
        let context = self.context.clone();
        let png = context.install(|| {
            let _stage = context.stage("picture");
            figure().to_png()
        })?;
        self.write_bytes(&file, &png)
    }

    /// Writes the page to this file, too.
    pub fn report_to(&mut self, file: &Path) {
        self.report.files.push(file.to_path_buf());
    }

    /// Shows a scene on the page, where one was asked for; see [`Report::add`].
    pub fn show(
        &mut self,
        file: &Path,
        role: Role,
        make: impl FnOnce(String, &Context) -> Result<Scene, Error> + Send,
    ) -> Result<(), Error> {
        self.report.add(file, role, &self.context, make)
    }

    /// Shows the result of the verb on the page, under the name of its file where it has one.
    pub fn show_result(
        &mut self,
        file: Option<&Path>,
        make: impl FnOnce(String, &Context) -> Result<Scene, Error> + Send,
    ) -> Result<(), Error> {
        let name = format!("result of {}", self.record.verb());
        // A file that replaces the input is shown beside it.
        let file = file.filter(|file| !self.report.has(file));
        self.show(file.unwrap_or(Path::new(&name)), Role::After, make)
    }

    /// Shows files in this order, none of them before or after another.
    pub fn show_equal(&mut self, files: &[&Path]) {
        self.report.equal(files);
    }
}
