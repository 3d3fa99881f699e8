//! `skeleton`: the curve skeleton of a surface, with radii.

use super::contract::Verb;
use crate::common::Common;
use crate::host::Found;
use crate::outputs::Outputs;
use crate::prepare::PrepareFlags;
use crate::session::Session;
use carreau::Error;
use carreau::io::ResultKind;
use carreau::mesh::PrepareOptions;
use carreau::report::page::Scene;
use carreau::report::skeleton_figure;
use carreau::skeleton::{SkeletonOptions, extract};
use clap::Args;
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::path::{Path, PathBuf};

/// Finds the curve skeleton of a surface, with radii
///
/// The surface flows along its mean curvature, drawn to the centres of its inner balls, until it is a curve. The skeleton has as
/// many cycles as the surface has handles, and every node is inside. Open ends are closed by lids; branches end at flat ends.
/// The file is a graph: .cgr, .cg, .skel, .swc (no cycles), .tgf, .vtp, .vtk, .obj.
#[derive(Args)]
#[command(after_help = "Examples:\n  \
    carreau skeleton vessel.stl -o vessel.cgr --picture vessel.png\n  \
    carreau skeleton hand.obj -o hand.swc --detail 0.001")]
pub struct Skeleton {
    /// The surface; open ends are closed
    input: PathBuf,
    /// The graph to write
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Weight that pulls a vertex back to its place: larger is slower and follows the shape more closely [default: 0.1]
    #[arg(long, value_name = "W")]
    speed: Option<f64>,
    /// Weight that pulls a vertex to the centre of its inner ball [default: 0.2]
    #[arg(long, value_name = "W")]
    medial: Option<f64>,
    /// Length below which edges are collapsed, as a share of the diagonal [default: 0.002]
    #[arg(long, value_name = "SHARE")]
    detail: Option<f64>,
    /// Keeps branches that end within the ball of their branching
    #[arg(long)]
    no_prune: bool,
    #[command(flatten)]
    prepare: PrepareFlags,
    #[command(flatten)]
    common: Common,
}

/// All options of a run.
#[derive(Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Options {
    #[serde(flatten)]
    skeleton: SkeletonOptions,
    #[serde(flatten)]
    prepare: PrepareOptions,
}

impl Verb for Skeleton {
    const NAME: &'static str = "skeleton";
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
        Outputs::of(&self.common).needs(Some(&self.input)).writes(self.output.as_deref(), ResultKind::Skeleton)
    }

    fn defaults(&self) -> Options {
        Options::default()
    }

    fn lay_over(&self, all: &mut Options) -> Result<(), Error> {
        all.skeleton.speed = self.speed.unwrap_or(all.skeleton.speed);
        all.skeleton.medial = self.medial.unwrap_or(all.skeleton.medial);
        all.skeleton.detail = self.detail.unwrap_or(all.skeleton.detail);
        all.skeleton.prune &= !self.no_prune;
        all.prepare = self.prepare.over(all.prepare);
        all.skeleton.validate()?;
        Ok(())
    }

    fn work(&self, session: &mut Session, options: &Options) -> Result<(), Error> {
        let raw = session.read(&self.input)?;
        let prepared = session.read_body(raw, &options.prepare)?;
        let mesh = &prepared.mesh;
        let mut found = extract(mesh, &options.skeleton, &session.context.clone())?;
        let of_lids = found.preimage.split_off(mesh.vertex_count().min(found.preimage.len()));
        found.preimage = prepared.values_of_vertices(found.preimage, u32::MAX).into_iter().chain(of_lids).collect();
        found.warnings.iter().for_each(|w| session.warn(w));
        session.leave_behind(mesh, "a skeleton", |_| false);
        session.draw_as(|| skeleton_figure(&found.closed.mesh, &found.net))?;
        session.show_result(self.output.as_deref(), |name, _| {
            Ok(Scene::of_surface(name, &found.closed.mesh)?.net("skeleton", &found.net).show("plain"))
        })?;
        let f = &found.figures;
        session.record.set_all(f);
        session.record.set("output", json!({ "nodes": f.nodes, "segments": f.segments }));
        session.say(format!(
            "{} nodes, {} segments; {} extremities, {} branchings, {} cycles",
            f.nodes, f.segments, f.extremities, f.branchings, f.cycles
        ));
        if let Some(file) = &self.output {
            session.write_skeleton(file, &found.net)?;
        }
        session.keep(|| Found::Skeleton(found));
        Ok(())
    }
}
