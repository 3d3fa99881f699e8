//! `demo`: the methods on built-in models, in a folder with an index.

mod page;

use super::segment::labelled;
use crate::common::{Common, CommonValues};
use crate::session::{Failure, Session};
use carreau::field::{self, FieldOptions};
use carreau::hex::{self, HexOptions};
use carreau::io::WriteOptions;
use carreau::io::cad::{CadOptions, write_cad};
use carreau::io::write_skeleton;
use carreau::mesh::{Column, CurveNet, RawMesh, SurfaceMesh};
use carreau::patch::cad::{BrepOptions, to_brep};
use carreau::patch::{PatchOptions, decompose, quad_mesh};
use carreau::quad::{self, QuadOptions};
use carreau::remesh::{RemeshOptions, simplify};
use carreau::report::{field_figure, figure, hex_figure};
use carreau::segment::{SegmentOptions, segment};
use carreau::{Error, sample};
use clap::Args;
use page::{Figure, Section};
use serde_json::json;
use std::path::{Path, PathBuf};

/// The models that are shown.
const MODELS: &[&str] = &["cube-cylinders", "bracket", "rounded-box", "torus", "tube-tree"];

/// Makes built-in models, runs the methods on them and writes a folder with index.html
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
    /// Runs the verb.
    pub fn run(&self) -> Result<(), Failure> {
        let values = self.common.over(CommonValues::default());
        Session::run("demo", &self.common, &values, None, |session| {
            session.record.set("options", &values);
            std::fs::create_dir_all(&self.output).map_err(|e| Error::write(&self.output, e))?;
            let context = session.context.clone();
            let sections = context.install(|| self.sections(session))?;
            let index = self.output.join("index.html");
            session.write_bytes(&index, page::html(&sections).as_bytes())?;
            session.record.set("output", json!({ "index": index.to_string_lossy(), "sections": sections }));
            session.say(format!("open {}", index.display()));
            Ok(())
        })
    }

    /// Every room on every model.
    fn sections(&self, session: &mut Session) -> Result<Vec<Section>, Error> {
        let mut regions = Section {
            title: "Segmentation",
            about: "The faces of a part, each on its surface: plane, cylinder, cone, sphere, torus or freeform.",
            figures: Vec::new(),
        };
        let mut graded = Section {
            title: "Graded meshes",
            about: "Within an angle of the surface, small where it bends; ridges and corners stay.",
            figures: Vec::new(),
        };
        let mut patches = Section {
            title: "Quad patches",
            about: "Grids of quads on the same vertices; each patch is one B-spline face of the STEP file.",
            figures: Vec::new(),
        };
        let mut fields = Section {
            title: "Frame fields",
            about: "Two directions per triangle, along every feature, with room for a quad in every corner. Dots: vertices with fewer \
                    (red) and more (blue) quads than usual.",
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
            regions.figures.push(self.segment(session, name, &mesh, &input)?);
            graded.figures.push(self.remesh(session, name, &mesh, &input)?);
            patches.figures.push(self.patch(session, name, &mesh, &input)?);
            fields.figures.push(self.field(session, name, &mesh, &input)?);
            quads.figures.push(self.quads(session, name, &mesh, &input)?);
        }
        let hexes = Section {
            title: "Hexes on a skeleton",
            about: "Hexahedra along the branches of a skeleton, every one certified; right: a cut, by scaled Jacobian.",
            figures: vec![self.hex(session)?],
        };
        Ok(vec![regions, graded, patches, fields, quads, hexes])
    }

    /// Triangles to regions.
    fn segment(&self, session: &mut Session, name: &str, mesh: &SurfaceMesh, input: &str) -> Result<Figure, Error> {
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
        self.figure(session, name, caption, picture, &[("triangles", input), ("regions", &file)])
    }

    /// Triangles to a graded mesh.
    fn remesh(&self, session: &mut Session, name: &str, mesh: &SurfaceMesh, input: &str) -> Result<Figure, Error> {
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
        self.figure(session, name, caption, picture, &[("triangles", input), ("graded", &file)])
    }

    /// Triangles to patches, and to a CAD file.
    fn patch(&self, session: &mut Session, name: &str, mesh: &SurfaceMesh, input: &str) -> Result<Figure, Error> {
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
        self.figure(session, name, caption, picture, &[("triangles", input), ("patches", &file), ("STEP", &step_file)])
    }

    /// Triangles to a frame field.
    fn field(&self, session: &mut Session, name: &str, mesh: &SurfaceMesh, input: &str) -> Result<Figure, Error> {
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
        self.figure(session, name, caption, picture, &[("triangles", input), ("field", &layout)])
    }

    /// Triangles to quads alone.
    fn quads(&self, session: &mut Session, name: &str, mesh: &SurfaceMesh, input: &str) -> Result<Figure, Error> {
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
        self.figure(session, name, caption, picture, &[("triangles", input), ("quads", &file)])
    }

    /// The skeleton of the sample tube-tree to hexes.
    fn hex(&self, session: &mut Session) -> Result<Figure, Error> {
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
        session.write_mesh(&self.output.join(&file), &RawMesh::from(result.mesh), &WriteOptions::default())?;
        let caption = format!(
            "{} nodes → {} hexes; scaled Jacobian {:.2} at least, {:.2} on average",
            net.points.len(),
            f.hexes,
            f.quality.scaled_jacobian_min,
            f.quality.scaled_jacobian_mean
        );
        self.figure(session, name, caption, picture, &[("skeleton", &skeleton), ("hexes", &file)])
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
        caption: String,
        picture: String,
        files: &[(&'static str, &str)],
    ) -> Result<Figure, Error> {
        session.say(format!("{name}: {caption}"));
        let files = files.iter().map(|&(what, file)| (what, file.to_string())).collect();
        Ok(Figure { name: name.into(), about: sample::find(name)?.summary, caption, picture, files })
    }
}
