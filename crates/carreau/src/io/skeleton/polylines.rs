//! Skeletons as the lines of a mesh file; radii in a column `radius` or `MaximumInscribedSphereRadius` (VMTK).

use super::super::files::{read as read_mesh, write as write_mesh};
use super::super::source::WriteOptions;
use crate::error::{Error, Result};
use crate::mesh::{Column, CurveNet, NetBuilder, RawMesh};
use std::path::Path;

/// Names of point columns that hold radii, in lower case; the second one is VMTK's.
const RADIUS_COLUMNS: [&str; 2] = ["radius", "maximuminscribedsphereradius"];

pub(super) fn read(path: &Path) -> Result<CurveNet> {
    let mesh = read_mesh(path)?;
    if !mesh.faces.is_empty() || !mesh.cells.is_empty() {
        return Err(Error::input("a skeleton of lines is expected, the file holds faces or cells", "", ""));
    }
    let column = mesh.attributes.vertex.iter().find(|(name, _)| RADIUS_COLUMNS.contains(&&*name.to_ascii_lowercase()));
    let radius = |v: usize| match column {
        Some((_, Column::Scalar(values))) => values.get(v).copied(),
        _ => None,
    };
    let mut builder = NetBuilder::default();
    for (v, &p) in mesh.points.iter().enumerate() {
        builder.node(v as i64, p, radius(v), v as u64 + 1)?;
    }
    (1..).zip(&mesh.edges).for_each(|(k, &[a, b])| builder.link(i64::from(a), i64::from(b), k));
    mesh.notes.into_iter().for_each(|n| builder.note(n));
    builder.finish()
}

pub(super) fn write(path: &Path, net: &CurveNet) -> Result<Vec<String>> {
    let mut mesh = RawMesh {
        points: net.points.clone(),
        edges: net.edges.clone(),
        edge_tags: vec![0; net.edges.len()],
        ..RawMesh::default()
    };
    if super::extension(path) != "obj" {
        mesh.attributes.vertex.insert("radius".into(), Column::Scalar(net.radii.clone()));
    }
    write_mesh(path, &mesh, &WriteOptions::default())
}
