//! `skeleton`: the curve skeleton of a surface, with radii.

use crate::common::{Common, CommonValues};
use crate::host::Found;
use crate::outputs::Outputs;
use crate::prepare::PrepareFlags;
use crate::replay::options_from;
use crate::session::{Failure, Session};
use carreau::Error;
use carreau::io::ResultKind;
use carreau::mesh::PrepareOptions;
use carreau::report::page::Scene;
use carreau::report::skeleton_figure;
use carreau::skeleton::{SkeletonOptions, extract};
use clap::Args;
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::path::PathBuf;

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
    pub(super) common: Common,
}

/// All options of a run.
#[derive(Default, Serialize, Deserialize)]
#[serde(default)]
struct Options {
    #[serde(flatten)]
    skeleton: SkeletonOptions,
    #[serde(flatten)]
    prepare: PrepareOptions,
    #[serde(flatten)]
    common: CommonValues,
}

impl Skeleton {
    /// The files of a run.
    pub fn outputs(&self) -> Outputs {
        Outputs::of(&self.common).needs(Some(&self.input)).writes(self.output.as_deref(), ResultKind::Skeleton)
    }

    /// Runs the verb.
    pub fn run(&self) -> Result<(), Failure> {
        let options = self.options()?;
        Session::run("skeleton", &self.common, &options.common, Some(&self.input), |session| {
            session.record.set("options", &options);
            self.skeleton(session, &options)
        })
    }

    fn options(&self) -> Result<Options, Error> {
        let mut all = options_from(self.common.options.as_deref(), "skeleton", Options::default())?;
        all.skeleton.speed = self.speed.unwrap_or(all.skeleton.speed);
        all.skeleton.medial = self.medial.unwrap_or(all.skeleton.medial);
        all.skeleton.detail = self.detail.unwrap_or(all.skeleton.detail);
        all.skeleton.prune &= !self.no_prune;
        all.prepare = self.prepare.over(all.prepare);
        all.common = self.common.over(all.common);
        all.skeleton.validate()?;
        Ok(all)
    }

    fn skeleton(&self, session: &mut Session, options: &Options) -> Result<(), Error> {
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
