//! The verbs, one file each; `simplify` holds `enrich` as well, `features` the flags of feature edges.

mod cad;
mod compare;
mod convert;
mod curvature;
mod demo;
mod features;
mod field;
mod hex;
mod info;
mod motorcycle;
mod patch;
mod quad;
mod repair;
mod sample;
mod segment;
mod shell;
mod simplify;
mod skeleton;
mod view;

use crate::common::Common;
use crate::outputs::Outputs;
use crate::session::Failure;
use clap::Subcommand;

pub use features::read_edges;
pub use info::{defect_lines, intersection_line, intersections};

/// What to do.
#[derive(Subcommand)]
pub enum Verb {
    Demo(demo::Demo),
    Sample(sample::Sample),
    Info(info::Info),
    Convert(convert::Convert),
    Repair(repair::Repair),
    Compare(compare::Compare),
    Curvature(curvature::Curvature),
    Patch(patch::Patch),
    Segment(segment::Segment),
    Cad(cad::Cad),
    Field(field::Field),
    Motorcycle(motorcycle::Motorcycle),
    Quad(quad::Quad),
    Hex(hex::Hex),
    Skeleton(skeleton::Skeleton),
    Enrich(simplify::Enrich),
    Simplify(simplify::Simplify),
    View(view::View),
    Completions(shell::Completions),
    Man(shell::Man),
}

impl Verb {
    /// The common options of a verb that a program may call.
    pub fn common_mut(&mut self) -> Option<&mut Common> {
        match self {
            Verb::Info(verb) => Some(&mut verb.common),
            Verb::Repair(verb) => Some(&mut verb.common),
            Verb::Compare(verb) => Some(&mut verb.common),
            Verb::Curvature(verb) => Some(&mut verb.common),
            Verb::Patch(verb) => Some(&mut verb.common),
            Verb::Segment(verb) => Some(&mut verb.common),
            Verb::Cad(verb) => Some(&mut verb.common),
            Verb::Field(verb) => Some(&mut verb.common),
            Verb::Motorcycle(verb) => Some(&mut verb.common),
            Verb::Quad(verb) => Some(&mut verb.common),
            Verb::Hex(verb) => Some(&mut verb.common),
            Verb::Skeleton(verb) => Some(&mut verb.common),
            Verb::Enrich(verb) => Some(&mut verb.remesh.common),
            Verb::Simplify(verb) => Some(&mut verb.remesh.common),
            Verb::Demo(_)
            | Verb::Sample(_)
            | Verb::Convert(_)
            | Verb::View(_)
            | Verb::Completions(_)
            | Verb::Man(_) => None,
        }
    }

    /// The files of a run.
    fn outputs(&self) -> Outputs {
        match self {
            Verb::Demo(verb) => verb.outputs(),
            Verb::Sample(verb) => verb.outputs(),
            Verb::Info(verb) => verb.outputs(),
            Verb::Repair(verb) => verb.outputs(),
            Verb::Convert(verb) => verb.outputs(),
            Verb::Compare(verb) => verb.outputs(),
            Verb::Curvature(verb) => verb.outputs(),
            Verb::Patch(verb) => verb.outputs(),
            Verb::Segment(verb) => verb.outputs(),
            Verb::Cad(verb) => verb.outputs(),
            Verb::Field(verb) => verb.outputs(),
            Verb::Motorcycle(verb) => verb.outputs(),
            Verb::Quad(verb) => verb.outputs(),
            Verb::Hex(verb) => verb.outputs(),
            Verb::Skeleton(verb) => verb.outputs(),
            Verb::Enrich(verb) => verb.remesh.outputs(),
            Verb::Simplify(verb) => verb.remesh.outputs(),
            Verb::View(verb) => verb.outputs(),
            Verb::Completions(_) | Verb::Man(_) => Outputs::default(),
        }
    }

    /// Does it, once it is known that its results can be written.
    pub fn run(&self) -> Result<(), Failure> {
        self.outputs().check()?;
        match self {
            Verb::Demo(verb) => verb.run(),
            Verb::Sample(verb) => verb.run(),
            Verb::Info(verb) => verb.run(),
            Verb::Repair(verb) => verb.run(),
            Verb::Convert(verb) => verb.run(),
            Verb::Compare(verb) => verb.run(),
            Verb::Curvature(verb) => verb.run(),
            Verb::Patch(verb) => verb.run(),
            Verb::Segment(verb) => verb.run(),
            Verb::Cad(verb) => verb.run(),
            Verb::Field(verb) => verb.run(),
            Verb::Motorcycle(verb) => verb.run(),
            Verb::Quad(verb) => verb.run(),
            Verb::Hex(verb) => verb.run(),
            Verb::Skeleton(verb) => verb.run(),
            Verb::Enrich(verb) => verb.run(),
            Verb::Simplify(verb) => verb.run(),
            Verb::View(verb) => verb.run(),
            Verb::Completions(verb) => verb.run(),
            Verb::Man(verb) => verb.run(),
        }
    }
}
