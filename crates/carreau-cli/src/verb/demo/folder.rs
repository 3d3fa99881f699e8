//! The folder that the demo writes.

use super::page::Figure;
use crate::report::command_line;
use crate::session::Session;
use carreau::io::WriteOptions;
use carreau::mesh::RawMesh;
use carreau::report::figure;
use carreau::report::page::{Page, Scene};
use carreau::words::agreed;
use carreau::{Error, sample};
use std::path::{Path, PathBuf};

/// A figure and what its model's page shows.
pub type Drawn = (Figure, Scene);

/// The folder.
pub struct Folder(PathBuf);

impl Folder {
    /// The folder of this name, which is made unless it is there.
    pub fn at(output: &Path) -> Result<Self, Error> {
        if output.is_file() {
            return Err(Error::write(output, "this is a file; give the name of a folder"));
        }
        std::fs::create_dir_all(output).map_err(|e| Error::write(output, e))?;
        Ok(Folder(output.to_path_buf()))
    }

    /// Where a file of this name goes.
    pub fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    /// Writes a mesh; returns the name of the file in the folder.
    pub fn write(&self, session: &mut Session, name: &str, end: &str, mesh: &RawMesh) -> Result<String, Error> {
        let file = format!("{name}{end}.ply");
        // PLY has no place for the words of labels, and here nobody misses them.
        let mut mesh = mesh.clone();
        mesh.attributes.names.clear();
        session.write_mesh(&self.path(&file), &mesh, &WriteOptions::default())?;
        Ok(file)
    }

    /// Writes a picture; returns the name of the file in the folder.
    pub fn draw(&self, session: &mut Session, name: &str, end: &str, mesh: &RawMesh) -> Result<String, Error> {
        let file = format!("{name}{end}.png");
        session.write_bytes(&self.path(&file), &figure(mesh).to_png()?)?;
        Ok(file)
    }

    /// A figure of a model, with the names of its files in the folder; the caption is told, too.
    pub fn figure(
        &self,
        session: &mut Session,
        name: &str,
        scene: &str,
        caption: String,
        picture: String,
        files: &[(&'static str, &str)],
    ) -> Result<Figure, Error> {
        let caption = agreed(&caption);
        session.say(format!("{name}: {caption}"));
        let files = files.iter().map(|&(what, file)| (what, file.to_string())).collect();
        let page = page_of(name, scene);
        Ok(Figure { name: name.into(), about: sample::find(name)?.summary, caption, picture, page, files })
    }

    /// Writes the page of a model.
    pub fn show(&self, session: &mut Session, name: &str, scenes: Vec<Scene>) -> Result<(), Error> {
        let context = session.context.clone();
        let page = Page::new(format!("carreau demo: {name}")).command(command_line()).scenes(scenes.clone());
        let html = context.install(|| {
            let _stage = context.stage("pages");
            page.html()
        })?;
        session.write_bytes(&self.path(&format!("{name}.html")), html.as_bytes())?;
        scenes.into_iter().try_for_each(|scene| {
            let title = format!("{name}, {}", scene.name());
            session.show(Path::new(&title), scene.as_role(), |title, _| Ok(scene.named(title)))
        })
    }
}

/// The address of a scene beside the first one on the page of a model.
pub fn page_of(model: &str, scene: &str) -> String {
    format!("{model}.html#right={scene}")
}
