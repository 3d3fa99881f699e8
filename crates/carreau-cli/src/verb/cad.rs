//! `cad`: a mesh becomes a CAD model with the faces that the part really has.

use super::contract::Verb;
use crate::choice::choice;
use crate::common::Common;
use crate::host::Found;
use crate::labels::read_labels;
use crate::outputs::Outputs;
use crate::prepare::PrepareFlags;
use crate::session::Session;
use carreau::brep::tessellate::{Fineness, tessellate};
use carreau::brep::{Brep, Surface, SurfaceKind};
use carreau::cad::{self, CadModel, CadOptions, Snap, Style};
use carreau::io::{self, CAD_EXTENSIONS, ResultKind, StepSchema, WriteOptions, extension};
use carreau::mesh::{Column, PrepareOptions, Prepared, RawMesh};
use carreau::report::page::Scene;
use carreau::report::picture::Image;
use carreau::report::{cad_figure, figure};
use carreau::words::counted;
use carreau::{Context, Error, Length};
use clap::Args;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Makes a CAD model of a mesh: closed bodies become solids
///
/// A bore becomes one cylinder with its radius, a fillet one cylinder or torus, a plate one plane with its holes. Regions on no
/// such surface become swept or spline faces, or plane facets where no such face is valid; the summary lists these regions.
/// An open surface becomes a shell. With --style organic a scan becomes a few bicubic faces that meet without a crease.
#[derive(Args)]
#[command(after_help = "Examples:\n  \
    carreau cad part.stl -o part.step --json part.json\n  \
    carreau cad part.ply -o part.step --labels face_id\n  \
    carreau cad part.stl -o part.igs --unit in\n  \
    carreau cad scan.ply -o scan.step --style organic")]
pub struct Cad {
    /// The mesh; polygons are cut into fans of triangles
    input: PathBuf,
    /// The file to write: STEP, IGES, or a mesh format (the triangles, with the face property face)
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// The kind of model: the faces of a part, or smooth faces all over a scan (organic); auto chooses organic if no region
    /// is a plane, cylinder, cone, sphere or torus, or if more than half of a part would be plane facets [default: auto]
    #[arg(long, value_name = "STYLE", value_parser = choice::<Style>(&["auto", "mechanical", "organic"]))]
    style: Option<Style>,
    /// Largest distance of a vertex from its face [default: from the data; organic: .1 % of the diagonal]
    #[arg(long, value_name = "LENGTH")]
    tolerance: Option<Length>,
    /// Takes the faces from a face property of the input, or from a file with one integer per triangle
    #[arg(long, value_name = "FILE|PROPERTY")]
    labels: Option<String>,
    /// Adjusts the surfaces of noisy meshes to each other: directions, axes, equal radii, round numbers; off: each is fitted for
    /// itself [default: on]
    #[arg(long, value_name = "on|off", value_parser = choice::<Snap>(&["on", "off"]))]
    snap: Option<Snap>,
    /// Refuses models with more faces than this
    #[arg(long, value_name = "N")]
    max_faces: Option<u32>,
    #[command(flatten)]
    prepare: PrepareFlags,
    #[command(flatten)]
    common: Common,
}

/// What replays a run.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Options {
    #[serde(flatten)]
    cad: CadOptions,
    labels: Option<String>,
    tolerance: Option<Length>,
    #[serde(flatten)]
    prepare: PrepareOptions,
}

impl Verb for Cad {
    const NAME: &'static str = "cad";
    type Options = Options;

    fn common(&self) -> &Common {
        &self.common
    }

    fn common_mut(&mut self) -> &mut Common {
        &mut self.common
    }

    fn subject(&self) -> Option<&Path> {
        Some(&self.input)
    }

    fn files(&self) -> Outputs {
        let files = Outputs::of(&self.common).reads(&self.input, ResultKind::Surface);
        files.writes(self.output.as_deref(), ResultKind::SurfaceOrCad)
    }

    fn defaults(&self) -> Options {
        Options::default()
    }

    fn lay_over(&self, all: &mut Options) -> Result<(), Error> {
        all.cad.style = self.style.unwrap_or(all.cad.style);
        all.cad.snap = self.snap.unwrap_or(all.cad.snap);
        all.cad.max_faces = self.max_faces.or(all.cad.max_faces);
        all.labels = self.labels.clone().or(all.labels.take());
        all.tolerance = self.tolerance.or(all.tolerance);
        all.prepare = self.prepare.over(all.prepare);
        Ok(())
    }

    fn work(&self, session: &mut Session, options: &Options) -> Result<(), Error> {
        let prepared = session.read_fans(&self.input, &options.prepare)?;
        let mesh = &prepared.mesh;
        let context = session.context.clone();
        let mut wanted = options.cad.clone();
        wanted.tolerance = options.tolerance.map(|t| t.resolve(mesh.diagonal()));
        wanted.labels = options.labels.as_deref().map(|labels| read_labels(&prepared, labels)).transpose()?;
        let diagonal = mesh.diagonal();
        let model = context.install(|| cad::rebuild(mesh, &wanted, &context))?;
        tell(session, &model, options.cad.style, diagonal);
        let out = labelled(prepared, &model);
        session.draw_as(|| match own_triangles(&model.brep, &context) {
            Ok(triangles) => solid_figure(&model.brep, &triangles),
            Err(_) => figure(&out),
        })?;
        session.keep(|| Found::Mesh(out.clone()));
        session.show_result(self.output.as_deref(), |name, context| {
            Scene::of_mesh(name, &out)?.show("face").with_curvature(context)
        })?;
        let Some(file) = &self.output else { return Ok(()) };
        if CAD_EXTENSIONS.contains(&extension(file).as_str()) {
            self.write_cad(session, file, &model.brep)
        } else {
            session.write_mesh(file, &out, &WriteOptions::default())
        }
    }
}

impl Cad {
    fn write_cad(&self, session: &mut Session, file: &Path, brep: &Brep) -> Result<(), Error> {
        let name = self.input.file_stem().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        let cad = io::CadOptions { unit: session.unit, name, schema: StepSchema::Ap242, ..io::CadOptions::default() };
        let mut bytes = Vec::new();
        io::write_cad(file, brep, &cad, &mut bytes)?;
        session.write_bytes(file, &bytes)
    }
}

/// The model's own triangles, with the property `face`.
pub fn own_triangles(brep: &Brep, context: &Context) -> Result<RawMesh, Error> {
    Ok(RawMesh::from(tessellate(brep, &Fineness::of(brep), context)?.mesh()?))
}

/// A picture of a model's own triangles, by kind of face, with its edges.
pub fn solid_figure(brep: &Brep, triangles: &RawMesh) -> Image {
    let kind = |&f: &i32| brep.faces.get(f as usize).map_or(0, |f| brep.surface(f).kind() as i32);
    let kinds: Vec<i32> = match triangles.attributes.face.get("face") {
        Some(Column::Label(faces)) => faces.iter().map(kind).collect(),
        _ => vec![0; triangles.faces.len()],
    };
    cad_figure(triangles, &kinds)
}

/// The mesh with the face of every triangle.
fn labelled(prepared: Prepared, model: &CadModel) -> RawMesh {
    let face = Column::Label(prepared.labels_of_faces(&model.face_of_triangle).into_iter().map(|f| f as i32).collect());
    let mut mesh = prepared.into_input();
    mesh.attributes.face.insert("face".into(), face);
    RawMesh::from(mesh)
}

/// The record and the summary.
fn tell(session: &mut Session, model: &CadModel, style: Style, diagonal: f64) {
    let brep = &model.brep;
    let count = |kind: SurfaceKind| brep.faces.iter().filter(|f| brep.surface(f).kind() == kind).count();
    let kinds: Vec<(&str, usize)> =
        SurfaceKind::ALL.into_iter().map(|k| (k.name(), count(k))).filter(|(_, n)| *n > 0).collect();
    let words: Vec<String> = kinds.iter().map(|(name, n)| format!("{n} {name}")).collect();
    session.say(format!(
        "{}, {}: {}",
        counted(brep.solids.len(), "solid", "solids"),
        counted(brep.faces.len(), "face", "faces"),
        words.join(", ")
    ));
    for f in &model.fallback {
        let to = serde_json::to_value(f.to).unwrap_or_default();
        session.say(format!(
            "region {} ({}) became {}, because {}",
            f.region,
            f.from,
            to.as_str().unwrap_or(""),
            f.reason
        ));
    }
    if !model.relations.is_empty() {
        let mut kinds: BTreeMap<&str, usize> = BTreeMap::new();
        model.relations.iter().for_each(|r| *kinds.entry(r.relation).or_default() += 1);
        let kinds: Vec<String> = kinds.iter().map(|(kind, n)| format!("{n} {}", kind.replace('_', " "))).collect();
        session.say(format!("surfaces adjusted to each other: {}", kinds.join(", ")));
    }
    model.warnings.iter().for_each(|w| session.warn(w.clone()));
    if let Some(smooth) = &model.smooth {
        session.say(format!(
            "angle between faces: 99 % below {:.2}°, at most {:.2}°; distance of the scan: {:.1e} rms, at most {:.1e} of the \
             diagonal",
            smooth.angles.p99,
            smooth.angles.max,
            model.distance_rms / diagonal,
            model.distance_max / diagonal
        ));
        session.record.set("smooth", smooth);
    }
    let share = |d: f64| if diagonal > 0.0 { d / diagonal } else { 0.0 };
    let types: serde_json::Map<String, Value> = kinds.iter().map(|(name, n)| ((*name).to_string(), json!(n))).collect();
    let record = &mut session.record;
    record.set("faces", brep.faces.len());
    record.set("edges", brep.edges.len());
    record.set("solids", brep.solids.len());
    record.set("shells", brep.shells.len());
    record.set("types", types);
    record.set("volume", model.volume);
    record.set("area", model.area);
    record.set("style", style);
    record.set("distance_max", share(model.distance_max));
    record.set("distance_rms", share(model.distance_rms));
    record.set("tolerance_max", share(brep.tolerance()));
    record.set("fallback", &model.fallback);
    record.set("relations", &model.relations);
    record.set("faces_of_regions", faces_of_regions(model));
    record.set("face_table", (0..brep.faces.len()).map(|f| described(model, f)).collect::<Vec<Value>>());
}

/// What is known of a face: its kind, the figures of its surface, its area and its region.
fn described(model: &CadModel, f: usize) -> Value {
    let face = &model.brep.faces[f];
    let surface = model.brep.surface(face);
    let mut out = json!({
        "name": face.name,
        "kind": surface.kind().name(),
        "area": model.areas[f],
        "region": face.region,
        "edges": face.uses().count(),
    });
    let (axis, sizes): (Option<_>, Vec<(&str, f64)>) = match surface {
        Surface::Plane { frame } => (Some(frame), Vec::new()),
        Surface::Cylinder { frame, radius } => (Some(frame), vec![("radius", *radius)]),
        Surface::Sphere { frame, radius } => (Some(frame), vec![("radius", *radius)]),
        Surface::Cone { frame, half_angle, .. } => (Some(frame), vec![("half_angle_deg", half_angle.to_degrees())]),
        Surface::Torus { frame, major_radius, minor_radius } => {
            (Some(frame), vec![("major_radius", *major_radius), ("minor_radius", *minor_radius)])
        }
        Surface::Revolution { frame, .. } => (Some(frame), Vec::new()),
        Surface::Extrusion { direction, .. } => {
            out["direction"] = json!(direction.to_array());
            (None, Vec::new())
        }
        Surface::Spline(s) => {
            let [u, v] = s.knots().map(|k| k.count());
            out["control_points"] = json!([u, v]);
            (None, Vec::new())
        }
    };
    if let Some(frame) = axis {
        // Of planes the normal out of the body.
        let turned = matches!(surface, Surface::Plane { .. }) && !face.same_sense;
        out["origin"] = json!(frame.origin.to_array());
        out["direction"] = json!((if turned { -frame.z } else { frame.z }).to_array());
    }
    for (name, size) in sizes {
        out[name] = json!(size);
    }
    out
}

/// The faces of every region.
fn faces_of_regions(model: &CadModel) -> Vec<Vec<usize>> {
    let mut faces = vec![Vec::new(); model.segmentation.as_ref().map_or(1, |s| s.regions.len())];
    for (f, face) in model.brep.faces.iter().enumerate() {
        if let Some(list) = face.region.and_then(|r| faces.get_mut(r as usize)) {
            list.push(f);
        }
    }
    faces
}
