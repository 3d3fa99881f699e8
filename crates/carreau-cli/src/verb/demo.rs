//! `demo`: the methods on built-in models, in a folder with an index.

mod folder;
mod page;
mod rooms;

use super::contract::Verb;
use crate::common::Common;
use crate::outputs::Outputs;
use crate::session::Session;
use carreau::mesh::{RawMesh, SurfaceMesh};
use carreau::report::page::{Role, Scene};
use carreau::{Error, sample};
use clap::Args;
use folder::{Drawn, Folder};
use page::Section;
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::path::PathBuf;

/// The models that are shown.
const MODELS: &[&str] = &["cube-cylinders", "bracket", "rounded-box", "torus", "tube-tree"];

/// The model that becomes a solid at the end.
const SOLID: &str = "bracket";

/// The name of a page and its scenes.
type Shown = (String, Vec<Scene>);

/// A room that shows what it makes of every model.
struct Room {
    title: &'static str,
    about: &'static str,
    shown: fn(&Folder, &mut Session, &str, &SurfaceMesh, &str) -> Result<Drawn, Error>,
}

/// The rooms that take a surface, in the order of the index.
const ROOMS: &[Room] = &[
    Room {
        title: "Segmentation",
        about: "The faces of a part, each on its surface: plane, cylinder, cone, sphere, torus or freeform.",
        shown: rooms::segment,
    },
    Room {
        title: "Graded meshes",
        about: "Triangles within an angle of the surface: small where it bends, large elsewhere. Ridges and corners are kept.",
        shown: rooms::remesh,
    },
    Room {
        title: "Quad patches",
        about: "Grids of quads on the same vertices. In the STEP file they are B-spline faces.",
        shown: rooms::patch,
    },
    Room {
        title: "Frame fields",
        about: "Two directions per triangle, along every feature, with room for a quad in every corner. Dots: vertices with fewer \
                    (red) and more (blue) quads than usual.",
        shown: rooms::field,
    },
    Room {
        title: "Motorcycle graphs",
        about: "Tracks along the frames, from every singular vertex and every corner with room for more than two quads: they \
                    divide a part into patches for quads.",
        shown: rooms::graph,
    },
    Room { title: "All-quad meshes", about: "Quads alone; every sharp edge is a path of edges.", shown: rooms::quads },
];

/// Runs every method on built-in models and writes a folder with index.html
#[derive(Args)]
#[command(after_help = "Example:\n  carreau demo -o shown")]
pub struct Demo {
    /// The folder to write
    #[arg(short, long, value_name = "DIR", default_value = "carreau-demo")]
    output: PathBuf,
    #[command(flatten)]
    common: Common,
}

/// What replays a run: nothing of its own.
#[derive(Default, Serialize, Deserialize)]
pub struct Options {}

impl Verb for Demo {
    const NAME: &'static str = "demo";
    const IS_CALLABLE: bool = false;
    type Options = Options;

    fn common(&self) -> &Common {
        &self.common
    }

    fn common_mut(&mut self) -> &mut Common {
        &mut self.common
    }

    fn files(&self) -> Outputs {
        Outputs::of(&self.common)
    }

    fn defaults(&self) -> Options {
        Options::default()
    }

    fn work(&self, session: &mut Session, _: &Options) -> Result<(), Error> {
        let folder = Folder::at(&self.output)?;
        let context = session.context.clone();
        let (sections, shown) = context.install(|| sections(&folder, session))?;
        for (name, scenes) in shown {
            folder.show(session, &name, scenes)?;
        }
        let index = folder.path("index.html");
        session.write_bytes(&index, page::html(&sections).as_bytes())?;
        session.record.set("output", json!({ "index": index.to_string_lossy(), "sections": sections }));
        session.say(format!("open {}", index.display()));
        Ok(())
    }
}

/// Every room on every model, and what the page of each model shows.
fn sections(folder: &Folder, session: &mut Session) -> Result<(Vec<Section>, Vec<Shown>), Error> {
    let empty = |room: &Room| Section { title: room.title, about: room.about, figures: Vec::new() };
    let (mut sections, mut shown): (Vec<Section>, Vec<Shown>) = (ROOMS.iter().map(empty).collect(), Vec::new());
    for name in MODELS {
        let mesh = sample::make(name, None, &session.context)?;
        let input = folder.write(session, name, "", &RawMesh::from(mesh.clone()))?;
        let mut scenes = vec![Scene::of_surface("triangles", &mesh)?.role(Role::Before)];
        for (room, section) in ROOMS.iter().zip(&mut sections) {
            let (figure, scene) = (room.shown)(folder, session, name, &mesh, &input)?;
            section.figures.push(figure);
            scenes.push(scene.role(Role::After));
        }
        shown.push((name.to_string(), scenes));
    }
    let (figure, scenes) = rooms::hex(folder, session)?;
    shown.push((rooms::HEXES.to_string(), scenes));
    sections.push(Section {
        title: "Hexes on a skeleton",
        about: "Hexahedra along the branches of a skeleton, every one certified; right: a cut, by scaled Jacobian.",
        figures: vec![figure],
    });
    let (figure, scene) = rooms::solid(folder, session, SOLID)?;
    if let Some((_, scenes)) = shown.iter_mut().find(|(name, _)| name == SOLID) {
        scenes.push(scene.role(Role::After));
    }
    sections.push(Section {
        title: "CAD solid",
        about: "The part itself: a bore is one cylinder, a plate one plane with its holes; coloured by kind of face.",
        figures: vec![figure],
    });
    Ok((sections, shown))
}
