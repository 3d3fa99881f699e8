//! `enrich`: a finer mesh within an angle of the surface.

use super::contract::Verb;
use crate::common::Common;
use crate::outputs::Outputs;
use crate::remesh::{Remesh, RemeshValues};
use crate::session::Session;
use carreau::Error;
use carreau::remesh::{self, RemeshOptions};
use clap::Args;
use std::path::Path;

/// Refines a surface to an angular deviation
///
/// Long edges are split; new vertices lie on curved patches that follow the vertex normals. PLY and VTU files carry the vertex
/// property size: the edge length that the size map asks for.
#[derive(Args)]
#[command(after_help = "Example:\n  carreau enrich part.stl -o fine.ply --deviation 2 --gradation 1.5")]
pub struct Enrich {
    #[command(flatten)]
    remesh: Remesh,
}

impl Verb for Enrich {
    const NAME: &'static str = "enrich";
    type Options = RemeshValues;

    fn common(&self) -> &Common {
        &self.remesh.common
    }

    fn common_mut(&mut self) -> &mut Common {
        &mut self.remesh.common
    }

    fn subject(&self) -> Option<&Path> {
        Some(&self.remesh.input)
    }

    fn files(&self) -> Outputs {
        self.remesh.files()
    }

    fn defaults(&self) -> RemeshValues {
        RemeshValues::from(RemeshOptions { deviation: 5.0, ..RemeshOptions::default() })
    }

    fn lay_over(&self, all: &mut RemeshValues) -> Result<(), Error> {
        self.remesh.lay_over(all)
    }

    fn work(&self, session: &mut Session, options: &RemeshValues) -> Result<(), Error> {
        self.remesh.work(session, options, remesh::enrich)
    }
}
