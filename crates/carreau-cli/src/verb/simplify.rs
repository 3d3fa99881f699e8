//! `simplify`: a coarser mesh within an angle of the surface.

use super::contract::Verb;
use crate::common::{Common, positive_length};
use crate::outputs::Outputs;
use crate::remesh::{OrOff, Remesh, RemeshValues, number_or_off};
use crate::session::Session;
use carreau::remesh::{self, RemeshOptions};
use carreau::{Error, Length};
use clap::Args;
use std::path::Path;

/// Coarsens a surface to an angular deviation, a number of triangles or a distance
///
/// Ridges, corners, borders and tagged edges are kept. PLY and VTU files carry the vertex property size: the edge length that
/// the size map asks for.
#[derive(Args)]
#[command(after_help = "Examples:\n  \
    carreau simplify scan.ply -o coarse.ply --deviation 14 --json coarse.json\n  \
    carreau simplify scan.ply -o coarse.obj --triangles 20000\n  \
    carreau simplify scan.ply -o light.glb --triangles 5000 --geometric\n  \
    carreau simplify part.stl -o coarse.vtu --distance 1% --feature-angle 30")]
pub struct Simplify {
    #[command(flatten)]
    remesh: Remesh,
    /// Number of triangles, met within 1 % by scaling the sizes
    #[arg(long, value_name = "N", conflicts_with = "distance")]
    triangles: Option<usize>,
    /// Largest two-sided distance between input and output, met by scaling the sizes
    #[arg(long, value_name = "LENGTH")]
    distance: Option<Length>,
    /// Enriches to this angle first, in degrees, or off [default: off]
    #[arg(long, value_name = "DEG|off", value_parser = number_or_off)]
    enrich: Option<OrOff>,
    /// Makes edges longer in the direction in which the surface bends less
    #[arg(long, conflicts_with = "geometric")]
    anisotropic: bool,
    /// Ignores the shape of triangles: stays as close to the surface as their number allows
    #[arg(long, conflicts_with = "enrich")]
    geometric: bool,
}

impl Verb for Simplify {
    const NAME: &'static str = "simplify";
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
        RemeshValues::from(RemeshOptions::default())
    }

    fn lay_over(&self, all: &mut RemeshValues) -> Result<(), Error> {
        self.remesh.lay_over(all)?;
        let o = &mut all.remesh;
        o.triangles = self.triangles.or(o.triangles);
        o.enrich = self.enrich.map_or(o.enrich, |e| e.0);
        o.geometric |= self.geometric;
        o.anisotropic |= self.anisotropic;
        all.distance = self.distance.or(all.distance);
        positive_length("distance", all.distance)?;
        all.remesh.validate()
    }

    fn work(&self, session: &mut Session, options: &RemeshValues) -> Result<(), Error> {
        self.remesh.work(session, options, remesh::simplify)
    }
}
