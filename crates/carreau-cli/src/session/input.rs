//! What a run reads: files, or what a host holds in their place.

use super::run::Session;
use crate::edges::read_edges;
use crate::host::Input as HostInput;
use carreau::mesh::{CurveNet, RawMesh, VertexId};
use carreau::report::page::{Role, Scene};
use carreau::{Error, io};
use serde::Serialize;
use std::path::Path;

impl Session {
    /// What a mesh file holds, or what the host holds in its place.
    pub fn load_mesh(&self, file: &Path) -> Result<RawMesh, Error> {
        match self.hosted(file) {
            Some(HostInput::Mesh(mesh)) => Ok(mesh.clone()),
            _ => io::read(file),
        }
    }

    /// What a skeleton file holds, or what the host holds in its place.
    pub fn load_skeleton(&self, file: &Path) -> Result<CurveNet, Error> {
        match self.hosted(file) {
            Some(HostInput::Skeleton(net)) => Ok(net.clone()),
            _ => io::read_skeleton(file),
        }
    }

    /// The edges that a file lists, or those the host holds in its place.
    pub fn load_edges(&self, file: &Path) -> Result<Vec<[VertexId; 2]>, Error> {
        match self.hosted(file) {
            Some(HostInput::Edges(edges)) => Ok(edges.clone()),
            _ => read_edges(file),
        }
    }

    /// Whether a file is a skeleton by its name, or the host holds one in its place.
    pub fn is_skeleton(&self, file: &Path) -> bool {
        match self.hosted(file) {
            Some(input) => matches!(input, HostInput::Skeleton(_)),
            None => io::is_skeleton_file(file),
        }
    }

    fn hosted(&self, file: &Path) -> Option<&HostInput> {
        self.host.as_ref().and_then(|host| host.input(file))
    }

    /// Reads a mesh file as it is; what the reader repaired or left out becomes warnings.
    pub fn read(&mut self, file: &Path) -> Result<RawMesh, Error> {
        let mut mesh = {
            let _stage = self.context.stage("read");
            self.load_mesh(file)?
        };
        self.context.check()?;
        let input = Input {
            file: file.to_string_lossy().into_owned(),
            vertices: mesh.points.len(),
            faces: mesh.faces.len(),
            edges: mesh.edges.len(),
            cells: mesh.cells.len(),
        };
        self.record.set("input", input);
        std::mem::take(&mut mesh.notes).into_iter().for_each(|note| self.warn(note));
        self.show(file, Role::Before, |name, _| Scene::of_mesh(name, &mesh))?;
        Ok(mesh)
    }

    /// Reads a skeleton; what the reader mended stands in its notes.
    pub fn read_skeleton(&mut self, file: &Path) -> Result<CurveNet, Error> {
        let net = {
            let _stage = self.context.stage("read");
            self.load_skeleton(file)?
        };
        self.context.check()?;
        let input = Input {
            file: file.to_string_lossy().into_owned(),
            vertices: net.points.len(),
            faces: 0,
            edges: net.edges.len(),
            cells: 0,
        };
        self.record.set("input", input);
        self.show(file, Role::Before, |name, _| Ok(Scene::of_net(name, &net)))?;
        Ok(net)
    }
}

/// The record's `input`.
#[derive(Serialize)]
struct Input {
    file: String,
    vertices: usize,
    faces: usize,
    edges: usize,
    cells: usize,
}
