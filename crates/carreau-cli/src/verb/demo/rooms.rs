//! Every room on a model of the demo.

use super::folder::{Drawn, Folder, page_of};
use super::page::Figure;
use crate::session::Session;
use crate::verb::cad::{own_triangles, solid_figure};
use crate::verb::segment::{labelled, worded};
use carreau::field::{self, FieldOptions};
use carreau::hex::{self, HexOptions};
use carreau::io::cad::{CadOptions, write_cad};
use carreau::io::{WriteOptions, write_skeleton};
use carreau::mesh::{Column, CurveNet, RawMesh, SurfaceMesh};
use carreau::patch::cad::{BrepOptions, to_brep};
use carreau::patch::{PatchOptions, decompose, quad_mesh};
use carreau::quad::{self, GraphOptions, QuadOptions};
use carreau::remesh::{RemeshOptions, simplify};
use carreau::report::page::{Role, Scene};
use carreau::report::{field_figure, graph_figure, hex_figure};
use carreau::segment::{self, SegmentOptions};
use carreau::words::counted;
use carreau::{Error, cad, sample};
use std::path::Path;

/// The name of the page of hexes; that of the surface has the model's name.
pub const HEXES: &str = "tube-tree-hexes";

/// Triangles to regions.
pub fn segment(
    folder: &Folder,
    session: &mut Session,
    name: &str,
    mesh: &SurfaceMesh,
    input: &str,
) -> Result<Drawn, Error> {
    let result = segment::segment(mesh, &SegmentOptions::default(), &session.context)?;
    let lines = result.boundaries.len();
    let free = result.regions.iter().filter(|r| r.primitive.is_none()).count();
    let regions = result.regions.len();
    let out = labelled(mesh.clone(), &result);
    let file = folder.write(session, name, "-regions", &out)?;
    let picture = folder.draw(session, name, "-regions", &out)?;
    let caption =
        format!("{} triangles → {regions} regions, {free} of them freeform; {lines} boundary lines", mesh.face_count());
    let scene = Scene::of_mesh("regions", &worded(&out, &result))?.with_curvature(&session.context)?;
    let figure =
        folder.figure(session, name, "regions", caption, picture, &[("triangles", input), ("regions", &file)])?;
    Ok((figure, scene))
}

/// Triangles to a graded mesh.
pub fn remesh(
    folder: &Folder,
    session: &mut Session,
    name: &str,
    mesh: &SurfaceMesh,
    input: &str,
) -> Result<Drawn, Error> {
    // Faces that meet without a ridge keep their borders, too.
    let is_label = |c: &Column| matches!(c, Column::Label(_));
    let labels = mesh.attributes.face.iter().find(|(_, c)| is_label(c)).map(|(name, _)| name.clone());
    let options = RemeshOptions { deviation: 20.0, labels, ..RemeshOptions::default() };
    let result = simplify(mesh, &options, &session.context)?;
    let (q, triangles) = (result.quality, result.mesh.face_count());
    let out = RawMesh::from(result.mesh);
    let file = folder.write(session, name, "-graded", &out)?;
    let picture = folder.draw(session, name, "-graded", &out)?;
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
        folder.figure(session, name, "graded", caption, picture, &[("triangles", input), ("graded", &file)])?;
    Ok((figure, scene))
}

/// Triangles to patches, and to a CAD file.
pub fn patch(
    folder: &Folder,
    session: &mut Session,
    name: &str,
    mesh: &SurfaceMesh,
    input: &str,
) -> Result<Drawn, Error> {
    let context = session.context.clone();
    let result = decompose(mesh, &PatchOptions::default(), &context)?;
    let model = to_brep(mesh, &result.patches, &result.leftover, &BrepOptions::default(), &context)?;
    let mut step = Vec::new();
    let cad = CadOptions { name: name.into(), ..CadOptions::default() };
    write_cad(Path::new("model.step"), &model.brep, &cad, &mut step)?;
    let step_file = format!("{name}.step");
    session.write_bytes(&folder.path(&step_file), &step)?;
    let quads = quad_mesh(mesh, &result);
    let file = folder.write(session, name, "-patches", &quads)?;
    let picture = folder.draw(session, name, "-patches", &quads)?;
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
        folder.figure(session, name, "patches", caption, picture, &files)?,
        Scene::of_mesh("patches", &quads)?.show("patch"),
    ))
}

/// Triangles to a solid.
pub fn solid(folder: &Folder, session: &mut Session, name: &'static str) -> Result<Drawn, Error> {
    let context = session.context.clone();
    let mesh = sample::make(name, None, &context)?;
    let model = cad::rebuild(&mesh, &cad::CadOptions::default(), &context)?;
    let mut step = Vec::new();
    let options = CadOptions { name: name.into(), ..CadOptions::default() };
    let step_file = format!("{name}-solid.step");
    write_cad(Path::new("model.step"), &model.brep, &options, &mut step)?;
    session.write_bytes(&folder.path(&step_file), &step)?;
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
    session.write_bytes(&folder.path(&picture), &image.to_png()?)?;
    let figure = folder.figure(session, name, "solid", caption, picture, &[("STEP", &step_file)])?;
    Ok((figure, Scene::of_mesh("solid", &triangles)?.show("face")))
}

/// Triangles to a frame field.
pub fn field(
    folder: &Folder,
    session: &mut Session,
    name: &str,
    mesh: &SurfaceMesh,
    input: &str,
) -> Result<Drawn, Error> {
    let found = field::field(mesh, &FieldOptions::default(), &session.context)?;
    let picture = format!("{name}-field.png");
    session.write_bytes(&folder.path(&picture), &field_figure(&found).to_png()?)?;
    let layout = format!("{name}-field.json");
    session.write_bytes(&folder.path(&layout), &found.layout())?;
    let caption =
        format!("{} triangles, {} singularities; no corner without a quad", mesh.face_count(), found.singularities());
    let figure =
        folder.figure(session, name, "field", caption, picture, &[("triangles", input), ("field", &layout)])?;
    Ok((figure, Scene::of_field("field", &found)?))
}

/// Triangles to patches for quads.
pub fn graph(
    folder: &Folder,
    session: &mut Session,
    name: &str,
    mesh: &SurfaceMesh,
    input: &str,
) -> Result<Drawn, Error> {
    let found = quad::motorcycle_graph(mesh, &GraphOptions::default(), &session.context)?;
    let picture = format!("{name}-graph.png");
    session.write_bytes(&folder.path(&picture), &graph_figure(&found).to_png()?)?;
    let file = folder.write(session, name, "-graph", &RawMesh::from(found.mesh.clone()))?;
    let regular = found.regular();
    let caption = format!(
        "{} triangles → {} tracks, {} patches, {regular} of them with four sides",
        mesh.face_count(),
        found.tracks.len(),
        found.patches.len()
    );
    let figure = folder.figure(session, name, "graph", caption, picture, &[("triangles", input), ("graph", &file)])?;
    Ok((figure, Scene::of_graph("graph", &found)?))
}

/// Triangles to quads alone.
pub fn quads(
    folder: &Folder,
    session: &mut Session,
    name: &str,
    mesh: &SurfaceMesh,
    input: &str,
) -> Result<Drawn, Error> {
    let result = quad::quads(mesh, &QuadOptions::default(), &session.context)?;
    let (q, count) = (result.quality, result.mesh.face_count());
    let out = RawMesh::from(result.mesh);
    let file = folder.write(session, name, "-quads", &out)?;
    let picture = folder.draw(session, name, "-quads", &out)?;
    let caption = format!(
        "{} triangles → {count} quads; scaled Jacobian {:.2} on average, {:.2} at worst; {} irregular vertices",
        mesh.face_count(),
        q.scaled_jacobian_mean,
        q.scaled_jacobian_min,
        q.irregular
    );
    let figure = folder.figure(session, name, "quads", caption, picture, &[("triangles", input), ("quads", &file)])?;
    Ok((figure, Scene::of_mesh("quads", &out)?))
}

/// The skeleton of the sample tube-tree to hexes.
pub fn hex(folder: &Folder, session: &mut Session) -> Result<(Figure, Vec<Scene>), Error> {
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
    write_skeleton(&folder.path(&skeleton), &net)?;
    let result = hex::from_net(&net, &HexOptions::default(), &session.context)?;
    let picture = format!("{name}-hexes.png");
    session.write_bytes(&folder.path(&picture), &hex_figure(&result.mesh).to_png()?)?;
    let (f, file) = (&result.figures, format!("{name}-hexes.vtu"));
    let scenes = vec![
        Scene::of_net("skeleton", &net).role(Role::Before),
        Scene::of_hexes("hexes", &result.mesh)?.net("skeleton", &result.skeleton).role(Role::After),
    ];
    session.write_mesh(&folder.path(&file), &RawMesh::from(result.mesh), &WriteOptions::default())?;
    let caption = format!(
        "{} nodes → {} hexes; scaled Jacobian {:.2} at least, {:.2} on average",
        net.points.len(),
        f.hexes,
        f.quality.scaled_jacobian_min,
        f.quality.scaled_jacobian_mean
    );
    let files = [("skeleton", &skeleton[..]), ("hexes", &file)];
    let figure = folder.figure(session, name, "hexes", caption, picture, &files)?;
    Ok((Figure { page: page_of(HEXES, "hexes"), ..figure }, scenes))
}
