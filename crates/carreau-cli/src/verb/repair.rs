//! `repair`: makes a surface sound and says what it did.

use super::contract::Verb;
use crate::common::Common;
use crate::host::Found;
use crate::outputs::Outputs;
use crate::session::Session;
use carreau::geometry::holes::fill;
use carreau::geometry::intersections::Intersections;
use carreau::io::{ResultKind, WriteOptions};
use carreau::mesh::{KeepPieces, RawMesh, RepairOptions, SurfaceMesh, Topology, keep_pieces, repair};
use carreau::report::page::Scene;
use carreau::words::counted;
use carreau::{Error, Length};
use clap::Args;
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::path::{Path, PathBuf};

/// Welds, drops, orients and splits until the surface is sound, and says what it did
#[derive(Args)]
#[command(
    after_help = "Examples:\n  carreau repair scan.stl -o clean.ply\n  carreau repair soup.obj --weld 0.001% -o clean.ply\n  carreau repair scan.ply --keep largest --fill-holes -o closed.ply"
)]
pub struct Repair {
    /// The mesh to repair
    input: PathBuf,
    /// The file to write
    #[arg(short, long, value_name = "FILE", required = true)]
    output: Option<PathBuf>,
    /// Merges vertices closer than this; 0 merges those at equal positions [default: 0]
    #[arg(long, value_name = "LENGTH", conflicts_with = "no_weld")]
    weld: Option<Length>,
    /// Merges no vertices at all
    #[arg(long)]
    no_weld: bool,
    /// Keeps faces without area
    #[arg(long)]
    keep_degenerate: bool,
    /// Keeps duplicate faces (those on the same vertices)
    #[arg(long)]
    keep_duplicates: bool,
    /// Keeps the orientation of every face
    #[arg(long)]
    no_orient: bool,
    /// Leaves touching bodies connected, and non-manifold edges and vertices uncut
    #[arg(long)]
    no_split: bool,
    /// Keeps vertices that no face uses
    #[arg(long)]
    keep_unreferenced: bool,
    /// Pieces to keep: all, largest, or those with at least a share of the largest one's area, such as 1% [default: all]
    #[arg(long, value_name = "all|largest|SHARE")]
    keep: Option<KeepPieces>,
    /// Fills holes with up to this many border edges (all of them without a number), refined and smoothed like the surroundings
    #[arg(long, value_name = "EDGES", num_args = 0..=1, default_missing_value = "all", value_parser = most_edges)]
    fill_holes: Option<u32>,
    /// Orients faces even if an options file says not to: neighbours agree, closed components face outward
    #[arg(long, conflicts_with = "no_orient")]
    orient: bool,
    #[command(flatten)]
    common: Common,
}

#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Options {
    #[serde(flatten)]
    repair: RepairOptions,
    keep: Option<KeepPieces>,
    fill_holes: Option<u32>,
}

impl Verb for Repair {
    const NAME: &'static str = "repair";
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
        Outputs::of(&self.common)
            .reads(&self.input, ResultKind::Surface)
            .writes(self.output.as_deref(), ResultKind::Surface)
    }

    fn defaults(&self) -> Options {
        Options::default()
    }

    fn lay_over(&self, all: &mut Options) -> Result<(), Error> {
        let o = &mut all.repair;
        o.weld = if self.no_weld { None } else { self.weld.or(o.weld) };
        o.degenerate &= !self.keep_degenerate;
        o.duplicates &= !self.keep_duplicates;
        o.orient &= !self.no_orient;
        o.outward &= !self.no_orient;
        o.split &= !self.no_split;
        o.unreferenced &= !self.keep_unreferenced;
        all.fill_holes = self.fill_holes.or(all.fill_holes);
        if self.orient {
            (all.repair.orient, all.repair.outward) = (true, true);
        }
        all.keep = self.keep.or(all.keep);
        all.repair.validate()?;
        Ok(())
    }

    fn work(&self, session: &mut Session, options: &Options) -> Result<(), Error> {
        let mesh = session.read(&self.input)?.into_surface()?;
        let context = session.context.clone();
        let mut done = context.install(|| repair(&mesh, &options.repair, &context))?;
        let mut further = Vec::new();
        if let Some(keep) = options.keep {
            done.mesh = kept(session, done.mesh, keep, &mut further)?;
        }
        if let Some(most) = options.fill_holes {
            done.mesh = filled(session, &done.mesh, most, &mut further)?;
        }
        if !further.is_empty() {
            done.report.after = Topology::of(&done.mesh);
        }
        let sentences: Vec<String> = done.report.sentences().into_iter().chain(further).collect();
        if sentences.is_empty() {
            session.say("nothing to repair");
        }
        for sentence in sentences {
            session.say(sentence.clone());
            session.record.warnings.push(sentence);
        }
        let out = RawMesh::from(done.mesh);
        session.draw(&out)?;
        session.show_result(self.output.as_deref(), |name, _| Scene::of_mesh(name, &out))?;
        session.record.set("output", json!({ "vertices": out.points.len(), "faces": out.faces.len() }));
        session.record.set("repair", done.report);
        if let Some(file) = &self.output {
            session.write_mesh(file, &out, &WriteOptions::default())?;
            session.say(format!("{}: {} vertices, {} faces", file.display(), out.points.len(), out.faces.len()));
        }
        session.keep(|| Found::Mesh(out));
        Ok(())
    }
}

/// The number of edges that holes have at most.
fn most_edges(text: &str) -> Result<u32, String> {
    match text {
        "all" => Ok(u32::MAX),
        text => text.parse().map_err(|_| "a number of edges is expected, or all".into()),
    }
}

/// The pieces that are to stay, and a sentence about the others.
fn kept(
    session: &mut Session,
    mesh: SurfaceMesh,
    keep: KeepPieces,
    said: &mut Vec<String>,
) -> Result<SurfaceMesh, Error> {
    let prepared = keep_pieces(mesh, keep)?;
    let pieces = prepared.report.left_out;
    if let Some(first) = pieces.first {
        said.push(format!(
            "{} of {} left out, first at face {first} of the repaired surface",
            counted(pieces.count, "piece", "pieces"),
            counted(pieces.faces, "face", "faces")
        ));
    }
    session.record.set("left_out", pieces);
    Ok(prepared.mesh)
}

/// The surface with its holes filled, and a sentence for each: new faces are told by their numbers.
fn filled(session: &mut Session, mesh: &SurfaceMesh, most: u32, said: &mut Vec<String>) -> Result<SurfaceMesh, Error> {
    let context = session.context.clone();
    let found = context.install(|| fill(mesh, Some(most as usize), &context))?;
    for hole in &found.holes {
        let [from, to] = hole.faces;
        said.push(format!(
            "a hole of {} was filled by the faces {from} to {}, with {}",
            counted(hole.edges, "edge", "edges"),
            to.saturating_sub(1),
            counted(hole.vertices[1].saturating_sub(hole.vertices[0]) as usize, "new vertex", "new vertices")
        ));
    }
    session.record.set("filled", &found.holes);
    // New faces come after all others.
    if let Some(from) = found.holes.iter().map(|hole| hole.faces[0]).min() {
        let met = context.install(|| Intersections::with(&found.mesh, from, &context))?;
        if let Some([a, b]) = met.places.first() {
            session.warn(format!(
                "faces that fill holes meet others: {} (first {a} and {b}); the outer border of a plate is a hole, too: --fill-holes \
                 EDGES leaves holes of more edges open",
                counted(met.pairs, "pair", "pairs")
            ));
        }
        session.record.set("filled_intersections", met);
    }
    Ok(found.mesh)
}
