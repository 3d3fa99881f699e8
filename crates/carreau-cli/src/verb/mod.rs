//! The verbs, one file each.
//!
//! A verb is a struct whose fields are its flags; [`contract::Verb`] says what it has to be able to do, and how a run goes. A new one takes a
//! file here, a line in [`AnyVerb`] and one in `each`.

mod cad;
mod compare;
mod completions;
mod contract;
mod convert;
mod curvature;
mod demo;
mod enrich;
mod field;
mod hex;
mod info;
mod man;
mod motorcycle;
mod patch;
mod quad;
mod repair;
mod sample;
mod segment;
mod simplify;
mod skeleton;
mod view;

use crate::failure::Failure;
use crate::host::Host;
use clap::Subcommand;
use contract::Run;
use std::sync::Arc;

/// What to do.
#[derive(Subcommand)]
pub enum AnyVerb {
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
    Enrich(enrich::Enrich),
    Simplify(simplify::Simplify),
    View(view::View),
    Completions(completions::Completions),
    Man(man::Man),
}

/// Calls a method of whichever verb it is.
macro_rules! each {
    ($any:expr, $verb:ident => $call:expr) => {
        match $any {
            AnyVerb::Demo($verb) => $call,
            AnyVerb::Sample($verb) => $call,
            AnyVerb::Info($verb) => $call,
            AnyVerb::Convert($verb) => $call,
            AnyVerb::Repair($verb) => $call,
            AnyVerb::Compare($verb) => $call,
            AnyVerb::Curvature($verb) => $call,
            AnyVerb::Patch($verb) => $call,
            AnyVerb::Segment($verb) => $call,
            AnyVerb::Cad($verb) => $call,
            AnyVerb::Field($verb) => $call,
            AnyVerb::Motorcycle($verb) => $call,
            AnyVerb::Quad($verb) => $call,
            AnyVerb::Hex($verb) => $call,
            AnyVerb::Skeleton($verb) => $call,
            AnyVerb::Enrich($verb) => $call,
            AnyVerb::Simplify($verb) => $call,
            AnyVerb::View($verb) => $call,
            AnyVerb::Completions($verb) => $call,
            AnyVerb::Man($verb) => $call,
        }
    };
}

impl AnyVerb {
    /// Does it; `whole` is the command line as a whole.
    pub fn run(&self, whole: fn() -> clap::Command) -> Result<(), Failure> {
        each!(self, verb => verb.run(whole))
    }

    /// Lets it run in a host; false for verbs that do not.
    pub fn run_in(&mut self, host: &Arc<Host>) -> bool {
        each!(self, verb => verb.run_in(host))
    }
}
