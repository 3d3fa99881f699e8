//! `convert`: any readable format to any writable one.

use super::contract::Verb;
use crate::common::Common;
use crate::outputs::Outputs;
use crate::session::Session;
use carreau::Error;
use carreau::io::{ResultKind, WriteOptions};
use carreau::report::page::Scene;
use clap::Args;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Converts a mesh file to another format, chosen by the extension
#[derive(Args)]
#[command(
    after_help = "Examples:\n  carreau convert part.stl -o part.ply\n  carreau convert mesh.msh --boundary -o skin.obj"
)]
pub struct Convert {
    /// The file to read
    input: PathBuf,
    /// The file to write
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Writes only the boundary of a volume mesh, as a surface
    #[arg(long)]
    boundary: bool,
    /// Writes text instead of binary in formats that have both
    #[arg(long)]
    ascii: bool,
    /// Cuts every polygon into triangles, as a fan from its first corner
    #[arg(long)]
    triangulate: bool,
    #[command(flatten)]
    common: Common,
}

#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Options {
    boundary: bool,
    ascii: bool,
    triangulate: bool,
}

impl Verb for Convert {
    const NAME: &'static str = "convert";
    const IS_CALLABLE: bool = false;
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
        Outputs::of(&self.common).reads(&self.input, ResultKind::Any).writes(Some(&self.output), ResultKind::Any)
    }

    fn defaults(&self) -> Options {
        Options::default()
    }

    fn lay_over(&self, all: &mut Options) -> Result<(), Error> {
        all.boundary |= self.boundary;
        all.ascii |= self.ascii;
        all.triangulate |= self.triangulate;
        Ok(())
    }

    fn work(&self, session: &mut Session, options: &Options) -> Result<(), Error> {
        let mut mesh = session.read(&self.input)?;
        if options.boundary {
            mesh = mesh.boundary()?;
        }
        if options.triangulate {
            mesh = mesh.into_surface()?.triangulated()?.into();
        }
        session.draw(&mesh)?;
        session.show_result(Some(&self.output), |name, _| Scene::of_mesh(name, &mesh))?;
        session.write_mesh(&self.output, &mesh, &WriteOptions { ascii: options.ascii })?;
        session.record.set(
            "output",
            serde_json::json!({
                "file": self.output.to_string_lossy(),
                "vertices": mesh.points.len(),
                "faces": mesh.faces.len(),
                "cells": mesh.cells.len(),
            }),
        );
        session.say(format!(
            "{}: {} vertices, {} faces, {} cells",
            self.output.display(),
            mesh.points.len(),
            mesh.faces.len(),
            mesh.cells.len()
        ));
        Ok(())
    }
}
