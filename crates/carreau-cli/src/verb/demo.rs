//! `demo`: the methods on built-in models, in a folder with an index.

mod page;

use super::cad::{own_triangles, solid_figure};
use super::segment::{labelled, worded};
use crate::common::{Common, CommonValues};
use crate::outputs::Outputs;
use crate::report::command_line;
use crate::session::{Failure, Session};
use carreau::cad;
use carreau::field::{self, FieldOptions};
use carreau::hex::{self, HexOptions};
use carreau::io::WriteOptions;
use carreau::io::cad::{CadOptions, write_cad};
use carreau::io::write_skeleton;
use carreau::mesh::{Column, CurveNet, RawMesh, SurfaceMesh};
use carreau::patch::cad::{BrepOptions, to_brep};
use carreau::patch::{PatchOptions, decompose, quad_mesh};
use carreau::quad::{self, GraphOptions, QuadOptions};
use carreau::remesh::{RemeshOptions, simplify};
use carreau::report::page::{Page, Role, Scene};
use carreau::report::{field_figure, figure, graph_figure, hex_figure};
use carreau::segment::{SegmentOptions, segment};
use carreau::words::{agreed, counted};
use carreau::{Error, sample};
use clap::Args;
use page::{Figure, Section};
use serde_json::json;
use std::path::{Path, PathBuf};

/// The models that are shown.
const MODELS: &[&str] = &["cube-cylinders", "bracket", "rounded-box", "torus", "tube-tree"];

/// The name of the page of hexes; that of the surface has the model's name.
const HEXES: &str = "tube-tree-hexes";

/// The model that becomes a solid at the end.
const SOLID: &str = "bracket";

/// A figure and what its model's page shows.
type Drawn = (Figure, Scene);
/// The name of a page and its scenes.
type Shown = (String, Vec<Scene>);

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

impl Demo {
    /// The files of a run.
    pub fn outputs(&self) -> Outputs {
        Outputs::of(&self.common)
    }

    /// Runs the verb.
    pub fn run(&self) -> Result<(), Failure> {
        let values = self.common.over(CommonValues::default());
        Session::run("demo", &self.common, &values, None, |session| {
            session.record.set("options", &values);
            if self.output.is_file() {
                return Err(Error::write(&self.output, "this is a file; give the name of a folder"));
            }
            std::fs::create_dir_all(&self.output).map_err(|e| Error::write(&self.output, e))?;
            let context = session.context.clone();
            let (sections, shown) = context.install(|| self.sections(session))?;
            for (name, scenes) in shown {
                self.show(session, &name, scenes)?;
            }
            let index = self.output.join("index.html");
            session.write_bytes(&index, page::html(&sections).as_bytes())?;
            session.record.set("output", json!({ "index": index.to_string_lossy(), "sections": sections }));
            session.say(format!("open {}", index.display()));
            Ok(())
        })
    }

    /// Every room on every model, and what the page of each model shows.
    fn sections(&self, session: &mut Session) -> Result<(Vec<Section>, Vec<Shown>), Error> {
        let mut shown = Vec::new();
        let mut regions = Section {
            title: "Segmentation",
            about: "The faces of a part, each on its surface: plane, cylinder, cone, sphere, torus or freeform.",
            figures: Vec::new(),
        };
        let mut graded = Section {
            title: "Graded meshes",
            about: "Triangles within an angle of the surface: small where it bends, large elsewhere. Ridges and corners are kept.",
            figures: Vec::new(),
        };
        let mut patches = Section {
            title: "Quad patches",
            about: "Grids of quads on the same vertices. In the STEP file they are B-spline faces.",
            figures: Vec::new(),
        };
        let mut fields = Section {
            title: "Frame fields",
            about: "Two directions per triangle, along every feature, with room for a quad in every corner. Dots: vertices with fewer \
                    (red) and more (blue) quads than usual.",
            figures: Vec::new(),
        };
        let mut graphs = Section {
            title: "Motorcycle graphs",
            about: "Tracks along the frames, from every singular vertex and every corner with room for more than two quads: they \
                    divide a part into patches for quads.",
            figures: Vec::new(),
        };
        let mut quads = Section {
            title: "All-quad meshes",
            about: "Quads alone; every sharp edge is a path of edges.",
            figures: Vec::new(),
        };
        for name in MODELS {
            let mesh = sample::make(name, None, &session.context)?;
            let input = self.write(session, name, "", &RawMesh::from(mesh.clone()))?;
            let mut scenes = vec![Scene::of_surface("triangles", &mesh)?.role(Role::Before)];
            let mut add = |section: &mut Section, (figure, scene): (Figure, Scene)| {
                section.figures.push(figure);
                scenes.push(scene.role(Role::After));
            };
            add(&mut regions, self.segment(session, name, &mesh, &input)?);
            add(&mut graded, self.remesh(session, name, &mesh, &input)?);
            add(&mut patches, self.patch(session, name, &mesh, &input)?);
            add(&mut fields, self.field(session, name, &mesh, &input)?);
            add(&mut graphs, self.graph(session, name, &mesh, &input)?);
            add(&mut quads, self.quads(session, name, &mesh, &input)?);
            shown.push((name.to_string(), scenes));
        }
        let (figure, scenes) = self.hex(session)?;
        shown.push((HEXES.to_string(), scenes));
        let hexes = Section {
            title: "Hexes on a skeleton",
            about: "Hexahedra along the branches of a skeleton, every one certified; right: a cut, by scaled Jacobian.",
            figures: vec![figure],
        };
        let (figure, scene) = self.solid(session)?;
        if let Some((_, scenes)) = shown.iter_mut().find(|(name, _)| name == SOLID) {
            scenes.push(scene.role(Role::After));
        }
        let solid = Section {
            title: "CAD solid",
            about: "The part itself: a bore is one cylinder, a plate one plane with its holes; coloured by kind of face.",
            figures: vec![figure],
        };
        Ok((vec![regions, graded, patches, fields, graphs, quads, hexes, solid], shown))
    }

    /// Triangles to regions.
    fn segment(&self, session: &mut Session, name: &str, mesh: &SurfaceMesh, input: &str) -> Result<Drawn, Error> {
        let result = segment(mesh, &SegmentOptions::default(), &session.context)?;
        let lines = result.boundaries.len();
        let free = result.regions.iter().filter(|r| r.primitive.is_none()).count();
        let regions = result.regions.len();
        let out = labelled(mesh.clone(), &result);
        let file = self.write(session, name, "-regions", &out)?;
        let picture = self.draw(session, name, "-regions", &out)?;
        let caption = format!(
            "{} triangles → {regions} regions, {free} of them freeform; {lines} boundary lines",
            mesh.face_count()
        );
        let scene = Scene::of_mesh("regions", &worded(&out, &result))?.with_curvature(&session.context)?;
        let figure =
            self.figure(session, name, "regions", caption, picture, &[("triangles", input), ("regions", &file)])?;
        Ok((figure, scene))
    }

    /// Triangles to a graded mesh.
    fn remesh(&self, session: &mut Session, name: &str, mesh: &SurfaceMesh, input: &str) -> Result<Drawn, Error> {
        // Faces that meet without a ridge keep their borders, too.
        let is_label = |c: &Column| matches!(c, Column::Label(_));
        let labels = mesh.attributes.face.iter().find(|(_, c)| is_label(c)).map(|(name, _)| name.clone());
        let options = RemeshOptions { deviation: 20.0, labels, ..RemeshOptions::default() };
        let result = simplify(mesh, &options, &session.context)?;
        let (q, triangles) = (result.quality, result.mesh.face_count());
        let out = RawMesh::from(result.mesh);
        let file = self.write(session, name, "-graded", &out)?;
        let picture = self.draw(session, name, "-graded", &out)?;
        let caption = format!(
            "{} triangles → {triangles} at 20°; shape {:.2} on average, {:.2} at worst; {:.1} % of the edges within .6 to 1.7 of \
             the wanted length",
            mesh.face_count(),
            q.shape_mean,
            q.shape_min,
            100.0 * q.length_in_06_17
        );
        let scene = Scene::of_mesh("graded", &out)?.show("plain");
        let figure =
            self.figure(session, name, "graded", caption, picture, &[("triangles", input), ("graded", &file)])?;
        Ok((figure, scene))
    }

    /// Triangles to patches, and to a CAD file.
    fn patch(&self, session: &mut Session, name: &str, mesh: &SurfaceMesh, input: &str) -> Result<Drawn, Error> {
        let context = session.context.clone();
        let result = decompose(mesh, &PatchOptions::default(), &context)?;
        let model = to_brep(mesh, &result.patches, &result.leftover, &BrepOptions::default(), &context)?;
        let mut step = Vec::new();
        let cad = CadOptions { name: name.into(), ..CadOptions::default() };
        write_cad(Path::new("model.step"), &model.brep, &cad, &mut step)?;
        let step_file = format!("{name}.step");
        session.write_bytes(&self.output.join(&step_file), &step)?;
        let quads = quad_mesh(mesh, &result);
        let file = self.write(session, name, "-patches", &quads)?;
        let picture = self.draw(session, name, "-patches", &quads)?;
        let solids = model.brep.solids.len();
        let caption = format!(
            "{} triangles → {} patches hold {:.2} %; {} CAD faces, {solids} solid{}",
            mesh.face_count(),
            result.patches.len(),
            100.0 * result.figures.coverage,
            model.brep.faces.len(),
            if solids == 1 { "" } else { "s" }
        );
        let files = [("triangles", input), ("patches", &file), ("STEP", &step_file)];
        Ok((
            self.figure(session, name, "patches", caption, picture, &files)?,
            Scene::of_mesh("patches", &quads)?.show("patch"),
        ))
    }

    /// Triangles to a solid.
    fn solid(&self, session: &mut Session) -> Result<Drawn, Error> {
        let (name, context) = (SOLID, session.context.clone());
        let mesh = sample::make(name, None, &context)?;
        let model = cad::rebuild(&mesh, &cad::CadOptions::default(), &context)?;
        let mut step = Vec::new();
        let options = CadOptions { name: name.into(), ..CadOptions::default() };
        let step_file = format!("{name}-solid.step");
        write_cad(Path::new("model.step"), &model.brep, &options, &mut step)?;
        session.write_bytes(&self.output.join(&step_file), &step)?;
        let caption = format!(
            "{} triangles → {}, {}; volume {:.4}",
            mesh.face_count(),
            counted(model.brep.solids.len(), "solid", "solids"),
            counted(model.brep.faces.len(), "face", "faces"),
            model.volume
        );
        let picture = format!("{name}-solid.png");
        let triangles = own_triangles(&model.brep, &context)?;
        let image = solid_figure(&model.brep, &triangles);
        session.write_bytes(&self.output.join(&picture), &image.to_png()?)?;
        let figure = self.figure(session, name, "solid", caption, picture, &[("STEP", &step_file)])?;
        Ok((figure, Scene::of_mesh("solid", &triangles)?.show("face")))
    }

    /// Triangles to a frame field.
    fn field(&self, session: &mut Session, name: &str, mesh: &SurfaceMesh, input: &str) -> Result<Drawn, Error> {
        let found = field::field(mesh, &FieldOptions::default(), &session.context)?;
        let picture = format!("{name}-field.png");
        session.write_bytes(&self.output.join(&picture), &field_figure(&found).to_png()?)?;
        let layout = format!("{name}-field.json");
        session.write_bytes(&self.output.join(&layout), &found.layout())?;
        let caption = format!(
            "{} triangles, {} singularities; no corner without a quad",
            mesh.face_count(),
            found.singularities()
        );
        let figure =
            self.figure(session, name, "field", caption, picture, &[("triangles", input), ("field", &layout)])?;
        Ok((figure, Scene::of_field("field", &found)?))
    }

    /// Triangles to patches for quads.
    fn graph(&self, session: &mut Session, name: &str, mesh: &SurfaceMesh, input: &str) -> Result<Drawn, Error> {
        let found = quad::motorcycle_graph(mesh, &GraphOptions::default(), &session.context)?;
        let picture = format!("{name}-graph.png");
        session.write_bytes(&self.output.join(&picture), &graph_figure(&found).to_png()?)?;
        let file = self.write(session, name, "-graph", &RawMesh::from(found.mesh.clone()))?;
        let regular = found.regular();
        let caption = format!(
            "{} triangles → {} tracks, {} patches, {regular} of them with four sides",
            mesh.face_count(),
            found.tracks.len(),
            found.patches.len()
        );
        let figure =
            self.figure(session, name, "graph", caption, picture, &[("triangles", input), ("graph", &file)])?;
        Ok((figure, Scene::of_graph("graph", &found)?))
    }

    /// Triangles to quads alone.
    fn quads(&self, session: &mut Session, name: &str, mesh: &SurfaceMesh, input: &str) -> Result<Drawn, Error> {
        let result = quad::quads(mesh, &QuadOptions::default(), &session.context)?;
        let (q, count) = (result.quality, result.mesh.face_count());
        let out = RawMesh::from(result.mesh);
        let file = self.write(session, name, "-quads", &out)?;
        let picture = self.draw(session, name, "-quads", &out)?;
        let caption = format!(
            "{} triangles → {count} quads; scaled Jacobian {:.2} on average, {:.2} at worst; {} irregular vertices",
            mesh.face_count(),
            q.scaled_jacobian_mean,
            q.scaled_jacobian_min,
            q.irregular
        );
        let figure =
            self.figure(session, name, "quads", caption, picture, &[("triangles", input), ("quads", &file)])?;
        Ok((figure, Scene::of_mesh("quads", &out)?))
    }

    /// The skeleton of the sample tube-tree to hexes.
    fn hex(&self, session: &mut Session) -> Result<(Figure, Vec<Scene>), Error> {
        let name = "tube-tree";
        let tubes = sample::tree();
        let net = CurveNet::new(
            tubes.iter().flat_map(|t| t.ends).collect(),
            tubes.iter().flat_map(|t| t.radii).collect(),
            (0..tubes.len() as u32).map(|k| [2 * k, 2 * k + 1]).collect(),
        );
        // Each tube brings its own ends: one node for all at one place.
        let net = net.repaired(None)?.net;
        let skeleton = format!("{name}.cgr");
        write_skeleton(&self.output.join(&skeleton), &net)?;
        let result = hex::from_net(&net, &HexOptions::default(), &session.context)?;
        let picture = format!("{name}-hexes.png");
        session.write_bytes(&self.output.join(&picture), &hex_figure(&result.mesh).to_png()?)?;
        let (f, file) = (&result.figures, format!("{name}-hexes.vtu"));
        let scenes = vec![
            Scene::of_net("skeleton", &net).role(Role::Before),
            Scene::of_hexes("hexes", &result.mesh)?.net("skeleton", &result.skeleton).role(Role::After),
        ];
        session.write_mesh(&self.output.join(&file), &RawMesh::from(result.mesh), &WriteOptions::default())?;
        let caption = format!(
            "{} nodes → {} hexes; scaled Jacobian {:.2} at least, {:.2} on average",
            net.points.len(),
            f.hexes,
            f.quality.scaled_jacobian_min,
            f.quality.scaled_jacobian_mean
        );
        let files = [("skeleton", &skeleton[..]), ("hexes", &file)];
        let figure = self.figure(session, name, "hexes", caption, picture, &files)?;
        Ok((Figure { page: page_of(HEXES, "hexes"), ..figure }, scenes))
    }

    /// Writes a mesh; returns the name of the file in the folder.
    fn write(&self, session: &mut Session, name: &str, end: &str, mesh: &RawMesh) -> Result<String, Error> {
        let file = format!("{name}{end}.ply");
        // PLY has no place for the words of labels, and here nobody misses them.
        let mut mesh = mesh.clone();
        mesh.attributes.names.clear();
        session.write_mesh(&self.output.join(&file), &mesh, &WriteOptions::default())?;
        Ok(file)
    }

    /// Writes a picture; returns the name of the file in the folder.
    fn draw(&self, session: &mut Session, name: &str, end: &str, mesh: &RawMesh) -> Result<String, Error> {
        let file = format!("{name}{end}.png");
        session.write_bytes(&self.output.join(&file), &figure(mesh).to_png()?)?;
        Ok(file)
    }

    fn figure(
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
    fn show(&self, session: &mut Session, name: &str, scenes: Vec<Scene>) -> Result<(), Error> {
        let context = session.context.clone();
        let page = Page::new(format!("carreau demo: {name}")).command(command_line()).scenes(scenes.clone());
        let html = context.install(|| {
            let _stage = context.stage("pages");
            page.html()
        })?;
        session.write_bytes(&self.output.join(format!("{name}.html")), html.as_bytes())?;
        scenes.into_iter().try_for_each(|scene| {
            let title = format!("{name}, {}", scene.name());
            session.show(Path::new(&title), scene.as_role(), |title, _| Ok(scene.named(title)))
        })
    }
}

/// The address of a scene beside the first one on the page of a model.
fn page_of(model: &str, scene: &str) -> String {
    format!("{model}.html#right={scene}")
}
