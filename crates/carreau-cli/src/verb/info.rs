//! `info`: what is in a file, and what is wrong with it.

use super::contract::Verb;
use crate::common::Common;
use crate::defects::{defect_lines, intersection_line, intersections};
use crate::outputs::Outputs;
use crate::session::Session;
use carreau::geometry::quality::SurfaceQuality;
use carreau::geometry::thickness::{Side, thin};
use carreau::hex::Validity;
use carreau::mesh::{Column, Columns, HexMesh, PrepareOptions, RawMesh, SurfaceMesh, Takes, Topology, prepare};
use carreau::words::{counted, rounded};
use carreau::{DVec3, Error, Length};
use clap::Args;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};

/// Reports counts, topology, defects with their places, and quality of a mesh file
#[derive(Args)]
#[command(
    after_help = "Examples:\n  carreau info scan.ply\n  carreau info part.stl --json - | jq .topology\n  carreau info part.stl --walls 2 --gaps 0.5%"
)]
pub struct Info {
    /// The file to look at
    input: PathBuf,
    /// Counts faces where the wall is thinner than this: through the material to the opposite face
    #[arg(long, value_name = "LENGTH")]
    walls: Option<Length>,
    /// Counts faces where the gap is narrower than this: through the air to the opposite face
    #[arg(long, value_name = "LENGTH")]
    gaps: Option<Length>,
    #[command(flatten)]
    common: Common,
}

impl Verb for Info {
    const NAME: &'static str = "info";
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
        Outputs::of(&self.common).needs(Some(&self.input))
    }

    fn defaults(&self) -> Options {
        Options::default()
    }

    fn lay_over(&self, all: &mut Options) -> Result<(), Error> {
        all.walls = self.walls.or(all.walls);
        all.gaps = self.gaps.or(all.gaps);
        Ok(())
    }

    fn work(&self, session: &mut Session, options: &Options) -> Result<(), Error> {
        let raw = session.read(&self.input)?;
        describe_content(session, &raw);
        describe_hexes(session, &raw)?;
        // A volume mesh is looked at through its boundary.
        let skin = if raw.cells.is_empty() { raw } else { raw.boundary()? };
        session.draw(&skin)?;
        let surface = skin.into_surface()?;
        session.context.check()?;
        describe_surface(session, &surface)?;
        describe_thin(session, &surface, options)
    }
}

/// What replays a run.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Options {
    walls: Option<Length>,
    gaps: Option<Length>,
}

/// Thin walls and narrow gaps, where they are asked for.
fn describe_thin(session: &mut Session, mesh: &SurfaceMesh, options: &Options) -> Result<(), Error> {
    let kinds = [
        ("walls", options.walls, Side::Wall, "a wall thinner than"),
        ("gaps", options.gaps, Side::Gap, "a gap narrower than"),
    ];
    let size = mesh.diagonal();
    for (name, limit, side, what) in kinds {
        let Some(limit) = limit.map(|limit| limit.resolve(mesh.diagonal())) else { continue };
        let context = session.context.clone();
        let found = context.install(|| {
            let _stage = context.stage("thickness");
            thin(mesh, side, limit, &context)
        })?;
        let shown: Vec<String> = found.places.iter().take(3).map(|[a, b]| format!("[{a},{b}]")).collect();
        let dots = if found.faces > shown.len() { ", …" } else { "" };
        session.say(match found.least {
            None => format!("no face has {what} {}", rounded(limit, size)),
            Some(least) => format!(
                "{} {what} {}, {} at least: {}{dots}",
                counted(found.faces, "face has", "faces have"),
                rounded(limit, size),
                rounded(least, size),
                shown.join(", ")
            ),
        });
        session.record.set(name, found);
    }
    Ok(())
}

/// Name and kind of every column.
fn columns(columns: &Columns) -> Map<String, Value> {
    let kind = |column: &Column| match column {
        Column::Scalar(_) => "scalar",
        Column::Vector2(_) => "vector2",
        Column::Vector3(_) => "vector3",
        Column::Label(_) => "label",
        Column::Color(_) => "color",
        _ => "other",
    };
    columns.iter().map(|(name, column)| (name.clone(), json!(kind(column)))).collect()
}

fn describe_content(session: &mut Session, raw: &RawMesh) {
    let cells = &raw.cells;
    session.say(format!("{} vertices, {} faces, {} tagged edges", raw.points.len(), raw.faces.len(), raw.edges.len()));
    if !cells.is_empty() {
        let counts = json!({
            "tetrahedra": cells.tets.len(), "hexahedra": cells.hexes.len(),
            "wedges": cells.wedges.len(), "pyramids": cells.pyramids.len(),
        });
        session.say(format!("volume mesh: {counts}; the following lines describe its boundary"));
        session.record.set("cells", counts);
    }
    let attributes = &raw.attributes;
    let all = [("vertex", &attributes.vertex), ("face", &attributes.face), ("corner", &attributes.corner)];
    for (element, list) in all.iter().filter(|(_, list)| !list.is_empty()) {
        let names: Vec<&str> = list.keys().map(String::as_str).collect();
        session.say(format!("{element} attributes: {}", names.join(", ")));
    }
    let attributes: Map<String, Value> =
        all.map(|(element, list)| (element.into(), json!(columns(list)))).into_iter().collect();
    session.record.set("attributes", attributes);
}

/// Conformity, quality and certificate of a mesh of hexahedra.
fn describe_hexes(session: &mut Session, raw: &RawMesh) -> Result<(), Error> {
    if raw.cells.hexes.is_empty() || raw.cells.hexes.len() < raw.cells.len() || raw.check().is_err() {
        return Ok(());
    }
    let mesh = HexMesh { points: raw.points.clone(), hexes: raw.cells.hexes.clone(), ..HexMesh::default() };
    let context = session.context.clone();
    let v = context.install(|| {
        let _stage = context.stage("hexahedra");
        Validity::of(&mesh, &context)
    })?;
    session.say(match v.bad_faces {
        0 => "conforming".into(),
        n => format!("not conforming: {n} faces have more than two cells, or two on one side"),
    });
    let quality = &v.quality;
    session.say(format!(
        "scaled Jacobian {:.3} at least, {:.3} on average; {} inverted; {}",
        quality.scaled_jacobian_min,
        quality.scaled_jacobian_mean,
        quality.inverted,
        match quality.uncertified.first() {
            None => "every cell is certified".into(),
            Some(first) => format!("{} cells are not certified, first {first}", quality.uncertified.len()),
        }
    ));
    if let Some(first) = quality.overlapping.first() {
        let (count, share) = (quality.overlapping.len(), 100.0 * quality.overlap);
        let cells = counted(count, "cell lies where another is", "cells lie where others are");
        session.say(format!("{cells} ({share:.2}% of the volume), first {first}"));
    }
    let edges: Vec<String> =
        quality.irregular_edges.iter().map(|(valence, n)| format!("{n} of {valence} cells")).collect();
    if !edges.is_empty() {
        session.say(format!("irregular interior edges: {}", edges.join(", ")));
    }
    session.record.set("hexahedra", v);
    Ok(())
}

fn describe_surface(session: &mut Session, mesh: &SurfaceMesh) -> Result<(), Error> {
    let topology = {
        let _stage = session.context.stage("topology");
        Topology::of(mesh)
    };
    session.context.check()?;
    let quality = {
        let _stage = session.context.stage("quality");
        SurfaceQuality::of(mesh)
    };
    let t = &topology;
    session.say(format!("{} triangles, {} quads, {} polygons; {} edges", t.triangles, t.quads, t.polygons, t.edges));
    let genus = t.genus.map(|g| format!(", genus {g}")).unwrap_or_default();
    session.say(format!("{} components, Euler number {}{genus}", t.components, t.euler));
    let words = [
        (t.closed, "closed", "open"),
        (t.manifold, "manifold", "not manifold"),
        (t.orientable, "orientable", "not orientable"),
        (t.consistently_oriented, "consistently oriented", "not consistently oriented"),
    ];
    session.say(words.map(|(holds, yes, no)| if holds { yes } else { no }).join(", "));
    let (low, high) = mesh.bounds();
    let extent = (high - low).max_element();
    let corner = |p: DVec3| p.to_array().map(|x| rounded(x, extent)).join(", ");
    session.say(format!("bounds ({}) to ({})", corner(low), corner(high)));
    if let Some(volume) = t.volume {
        session.say(format!("volume {}", rounded(volume, extent.powi(3))));
    }
    defect_lines(t, true).into_iter().for_each(|line| session.say(line));
    let crossings = intersections(session, mesh)?;
    intersection_line(&crossings).into_iter().for_each(|line| session.say(line));
    session.record.set("intersections", crossings);
    would_be_prepared(session, mesh)?;
    session.record.set("bounds", json!([low.to_array(), high.to_array()]));
    session.record.set("diagonal", mesh.diagonal());
    session.record.set("topology", topology);
    session.record.set("quality", quality);
    Ok(())
}

/// What other verbs do before they begin.
fn would_be_prepared(session: &mut Session, mesh: &SurfaceMesh) -> Result<(), Error> {
    let context = session.context.clone();
    let report = prepare(mesh.clone(), &PrepareOptions::default(), Takes::Bodies, &context)?.report;
    if let Some(line) = report.line() {
        session.say(format!("other verbs take it {line}"));
    }
    session.record.set("prepared", report);
    Ok(())
}
