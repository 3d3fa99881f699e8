//! What a surface format cannot hold: refused where it is the mesh itself, said in a warning where it is an ornament.

use crate::error::{Error, Result};
use crate::mesh::{Column, Columns, Polygons, RawMesh, gather_columns};
use crate::words::counted;
use glam::DVec3;
use std::collections::BTreeSet;

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

/// What a format does not hold of the words and colours of labels; `names` and `colors` say of which columns it holds them.
/// Words of labels that the mesh has not are no loss.
pub(super) fn words_left_out(
    format: &str,
    mesh: &RawMesh,
    names: impl Fn(&str) -> bool,
    colors: impl Fn(&str) -> bool,
) -> Vec<String> {
    let attributes = &mesh.attributes;
    let beside = |column: &str| match column {
        "edge" => mesh.edge_tags.iter().any(|&tag| tag != 0),
        "cell" => !mesh.cells.tags.is_empty(),
        "vertex" => attributes.vertex.contains_key("ref"),
        _ => false,
    };
    let lost = |columns: BTreeSet<&str>, kept: &dyn Fn(&str) -> bool| -> Vec<String> {
        let there = |column: &&str| attributes.has_labels(column) || beside(column);
        columns.into_iter().filter(there).filter(|column| !kept(column)).map(|column| format!("'{column}'")).collect()
    };
    let of_names = lost(attributes.names.keys().map(|(column, _)| column.as_str()).collect(), &names);
    let of_colors = lost(attributes.colors.keys().map(|(column, _)| column.as_str()).collect(), &colors);
    let said = |what: &str, columns: Vec<String>| {
        (!columns.is_empty()).then(|| {
            format!("{format} has no place for the {what} of labels: left out those of {}", columns.join(", "))
        })
    };
    [said("names", of_names), said("colours", of_colors)].into_iter().flatten().collect()
}

/// Rounding by less than this share of the extent is no loss that anyone could see: the format is known for it.
const UNSEEN: f64 = 1e-6;

/// How far the rounding to single precision moves a coordinate, where that is worth a word: of small models far from the origin.
pub(super) fn moved_by_single_precision(mesh: &RawMesh) -> Option<f64> {
    let low = mesh.points.iter().fold(DVec3::INFINITY, |a, &p| a.min(p));
    let high = mesh.points.iter().fold(DVec3::NEG_INFINITY, |a, &p| a.max(p));
    let moved = |p: &DVec3| (p.as_vec3().as_dvec3() - *p).abs().max_element();
    let most = mesh.points.iter().map(moved).fold(0.0, f64::max);
    (most > 0.0 && most > UNSEEN * (high - low).max_element()).then_some(most)
}

/// The note about elements of higher order, of which readers keep the corners: `elements` is their number.
pub(super) fn note_higher_order(mesh: &mut RawMesh, elements: usize) {
    if elements == 0 {
        return;
    }
    let mut used = vec![false; mesh.points.len()];
    let cells = &mesh.cells;
    let corners =
        [mesh.edges.as_flattened(), mesh.faces.corners(), cells.tets.as_flattened(), cells.hexes.as_flattened()];
    let further = [cells.wedges.as_flattened(), cells.pyramids.as_flattened()];
    corners.into_iter().chain(further).flatten().for_each(|&v| used[v as usize] = true);
    let between = used.iter().filter(|&&u| !u).count();
    let elements = counted(
        elements,
        "element of higher order: only its corners are",
        "elements of higher order: only their corners are",
    );
    let between = counted(between, "node between them stays as a vertex", "nodes between them stay as vertices");
    mesh.notes.push(format!("{elements} kept; {between} that no element uses"));
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
