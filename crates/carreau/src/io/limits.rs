//! What a surface format cannot hold: refused where it is the mesh itself, said in a warning where it is an ornament.

use crate::error::{Error, Result};
use crate::mesh::{Column, Columns, Polygons, RawMesh, gather_columns};

/// Refuses volume meshes, and what no reader or method makes: indices of nothing, columns of another length than what
/// they describe. Writers index freely after it.
pub(super) fn require_surface(mesh: &RawMesh, format: &str) -> Result<()> {
    mesh.check()?;
    if !mesh.cells.is_empty() {
        return Err(Error::input(
            format!("{format} holds surfaces, this is a volume mesh ({} cells)", mesh.cells.len()),
            "",
            "write its boundary with `carreau convert --boundary`, or use a format with cells: .mesh, .vtu, .vtk, .msh",
        ));
    }
    let columns = &mesh.attributes;
    let lengths = [
        (&columns.vertex, mesh.points.len()),
        (&columns.face, mesh.faces.len()),
        (&columns.corner, mesh.faces.corners().len()),
    ];
    for (columns, wanted) in lengths {
        if let Some((name, column)) = columns.iter().find(|(_, c)| c.len() != wanted) {
            return Err(Error::Bug(format!("attribute '{name}' has {} values for {wanted} elements", column.len())));
        }
    }
    Ok(())
}

/// The columns that `kept` does not accept, as a warning.
pub(super) fn columns_left_out(
    format: &str,
    element: &str,
    columns: &Columns,
    kept: impl Fn(&str, &Column) -> bool,
) -> Option<String> {
    let left: Vec<String> = columns.iter().filter(|(n, c)| !kept(n, c)).map(|(n, _)| format!("'{n}'")).collect();
    (!left.is_empty()).then(|| format!("{format} has no place for {element} attributes: left out {}", left.join(", ")))
}

/// The warning of a format without lines, where the mesh has some.
pub(super) fn edges_left_out(format: &str, mesh: &RawMesh) -> Option<String> {
    (!mesh.edges.is_empty()).then(|| format!("{format} has no place for lines: left out all {}", mesh.edges.len()))
}

/// Removes the faces with fewer than three corners that a file listed, with their attributes, and notes it.
pub(super) fn drop_short_faces(mesh: &mut RawMesh) {
    let short = |f: &[u32]| f.len() < 3;
    let Some(first) = mesh.faces.iter().position(short) else { return };
    let kept: Vec<u32> = (0u32..).zip(mesh.faces.iter()).filter(|(_, f)| !short(f)).map(|(k, _)| k).collect();
    let (dropped, all) = (mesh.faces.len() - kept.len(), mesh.faces.len());
    mesh.notes
        .push(format!("left out {dropped} of {all} faces: they have fewer than 3 corners, the first is face {first}"));
    mesh.attributes.face = gather_columns(&mesh.attributes.face, &kept);
    mesh.faces = kept.iter().map(|&k| mesh.faces.face(k as usize)).collect::<Polygons>();
}
