//! How a surface is prepared before a verb's room sees it: the flags, and what is told about it.

use crate::defects::defect_lines;
use crate::session::Session;
use carreau::mesh::{
    KeepPieces, PrepareOptions, Prepared, RawMesh, SurfaceMesh, Takes, Topology, VertexId, prepare, prepare_fans,
};
use carreau::{Error, Length};
use clap::Args;
use std::path::Path;

/// How the surface is prepared, as flags.
#[derive(Args, Clone, Default)]
pub struct PrepareFlags {
    /// Vertices nearer than this become one; 0: those at equal positions [default: 0]
    #[arg(long, value_name = "LENGTH", help_heading = "Preparation")]
    weld: Option<Length>,
    /// Pieces that stay: all, largest, or those with a share of the largest one's area, such as 1% [default: all; for one skeleton: largest]
    #[arg(long, value_name = "all|largest|SHARE", help_heading = "Preparation")]
    keep: Option<KeepPieces>,
    /// Takes the surface as it is in the file: nothing is welded, left out or turned
    #[arg(long, conflicts_with_all = ["weld", "keep"], help_heading = "Preparation")]
    as_is: bool,
}

impl PrepareFlags {
    /// These flags laid over values from an options file.
    pub fn over(&self, values: PrepareOptions) -> PrepareOptions {
        let given = self.weld.is_some() || self.keep.is_some();
        PrepareOptions {
            weld: self.weld.unwrap_or(values.weld),
            keep: self.keep.or(values.keep),
            as_is: self.as_is || (values.as_is && !given),
        }
    }
}

impl Session {
    /// Reads a surface and prepares it; its polygons stay.
    pub fn read_surface(&mut self, file: &Path, options: &PrepareOptions) -> Result<Prepared, Error> {
        let mesh = self.read(file)?.into_surface()?;
        self.prepare(mesh, options, Takes::Bodies)
    }

    /// Reads a surface and prepares it. Its polygons become fans from their first corners before, so that everybody numbers the
    /// triangles alike.
    pub fn read_fans(&mut self, file: &Path, options: &PrepareOptions) -> Result<Prepared, Error> {
        let mesh = self.read(file)?.into_surface()?;
        let prepared = prepare_fans(mesh, options, Takes::Bodies, &self.context.clone())?;
        Ok(self.tell(prepared))
    }

    /// Reads a surface for a method that takes one body, and cuts its polygons into triangles.
    pub fn read_body(&mut self, raw: RawMesh, options: &PrepareOptions) -> Result<Prepared, Error> {
        self.prepare(raw.into_surface()?, options, Takes::OneBody)?.triangulated()
    }

    /// Prepares a surface; says what was done and what is still wrong with it.
    pub fn prepare(&mut self, mesh: SurfaceMesh, options: &PrepareOptions, takes: Takes) -> Result<Prepared, Error> {
        let prepared = prepare(mesh, options, takes, &self.context.clone())?;
        Ok(self.tell(prepared))
    }

    /// Says what was done to a surface.
    fn tell(&mut self, prepared: Prepared) -> Prepared {
        self.record.set("prepared", &prepared.report);
        if prepared.report.as_is {
            let topology = self.context.install(|| Topology::of(&prepared.mesh));
            defect_lines(&topology, false).into_iter().for_each(|line| self.warn(line));
        }
        prepared.report.line().into_iter().for_each(|line| self.warn(line));
        prepared.report.left().into_iter().for_each(|line| self.warn(line));
        prepared
    }
}

/// Edges named by vertices of the file, as edges of the surface; those that are gone keep a name that the surface does not have.
pub fn edges_of_surface(prepared: &Prepared, edges: Vec<[VertexId; 2]>) -> Vec<[VertexId; 2]> {
    let image = |v: VertexId| VertexId(prepared.vertex_image(v.0).unwrap_or(u32::MAX));
    edges.into_iter().map(|ends| ends.map(image)).collect()
}
