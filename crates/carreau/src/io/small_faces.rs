//! What formats that know only triangles and quads, each with one reference number, can hold of a [`RawMesh`].

use crate::mesh::{Column, Columns, Polygons, RawMesh};
use std::borrow::Cow;

/// Face label columns that are written as the reference number, the first one found.
const REFERENCE_NAMES: [&str; 8] = ["ref", "region", "tag", "group", "material", "object", "solid", "patch"];
/// Those of them whose labels are numbers of names, from 0 (`patch`: -1 for faces of none).
pub(super) const COUNTED_FROM_ZERO: [&str; 5] = ["group", "material", "object", "solid", "patch"];

/// The faces of a mesh as triangles and quads.
pub(super) struct SmallFaces<'a> {
    /// Faces of three or four corners.
    pub faces: Cow<'a, Polygons>,
    /// The mesh's face of every one of `faces`; `None` where they are the mesh's own.
    parents: Option<Vec<u32>>,
}

impl<'a> SmallFaces<'a> {
    /// Fans faces of more than four corners and leaves out those of fewer than three; both are said in `warnings`.
    ///
    /// ```text
    /// 4───3         4───3
    /// │    ╲        │ ╲  ╲
    /// │     2   →   │  ╲  2    (0,1,2) (0,2,3) (0,3,4)
    /// │    ╱        │ ╱╱ ╱
    /// 0───1         0───1
    /// ```
    pub fn of(mesh: &'a RawMesh, format: &str, warnings: &mut Vec<String>) -> Self {
        let large = mesh.faces.iter().filter(|f| f.len() > 4).count();
        let small = mesh.faces.iter().filter(|f| f.len() < 3).count();
        if large + small == 0 {
            return SmallFaces { faces: Cow::Borrowed(&mesh.faces), parents: None };
        }
        if large > 0 {
            warnings.push(format!("{format} has no faces of more than 4 corners: {large} were cut into triangles"));
        }
        if small > 0 {
            warnings.push(format!("{small} faces of fewer than 3 corners were left out"));
        }
        let (mut faces, mut parents) = (Polygons::new(), Vec::new());
        for (f, face) in (0u32..).zip(mesh.faces.iter()) {
            match *face {
                [] | [_] | [_, _] => {}
                [_, _, _] | [_, _, _, _] => {
                    faces.push(face);
                    parents.push(f);
                }
                [first, ref others @ ..] => {
                    for pair in others.windows(2) {
                        faces.push_iter([first].into_iter().chain(pair.iter().copied()));
                        parents.push(f);
                    }
                }
            }
        }
        SmallFaces { faces: Cow::Owned(faces), parents: Some(parents) }
    }

    /// A value of the mesh's faces, for every one of `faces`.
    pub fn values<'b>(&self, of_mesh: &'b [i32]) -> Cow<'b, [i32]> {
        match &self.parents {
            None => Cow::Borrowed(of_mesh),
            Some(p) => Cow::Owned(p.iter().map(|&f| of_mesh.get(f as usize).copied().unwrap_or(0)).collect()),
        }
    }
}

/// The corners (numbers in the list of all corners) of the triangles that polygons are fanned into.
pub(super) fn fan_corners(faces: &Polygons) -> Vec<[u32; 3]> {
    let mut corners = Vec::new();
    let mut first = 0;
    for face in faces.iter() {
        let n = face.len() as u32;
        corners.extend((1..n.saturating_sub(1)).map(|k| [first, first + k, first + k + 1]));
        first += n;
    }
    corners
}

/// Name and values of the face column that is written as the reference number.
pub(super) fn face_references(mesh: &RawMesh) -> Option<(&'static str, &[i32])> {
    REFERENCE_NAMES.into_iter().find_map(|name| label(&mesh.attributes.face, name).map(|values| (name, values)))
}

/// The values of a label column.
pub(super) fn label<'a>(columns: &'a Columns, name: &str) -> Option<&'a [i32]> {
    match columns.get(name) {
        Some(Column::Label(values)) => Some(values),
        _ => None,
    }
}

/// A label column that is worth keeping: some value is not zero.
pub(super) fn keep_label(columns: &mut Columns, name: &str, values: Vec<i32>) {
    if values.iter().any(|&v| v != 0) {
        columns.insert(name.to_string(), Column::Label(values));
    }
}

/// Warns about the columns that are not written: all but the label columns named.
pub(super) fn warn_unheld(mesh: &RawMesh, format: &str, vertex: &[&str], face: &[&str], warnings: &mut Vec<String>) {
    let a = &mesh.attributes;
    for (element, columns, held) in [("vertex", &a.vertex, vertex), ("face", &a.face, face), ("corner", &a.corner, &[])]
    {
        let unheld = |name: &&String| !(held.contains(&name.as_str()) && label(columns, name).is_some());
        let lost: Vec<&str> = columns.keys().filter(unheld).map(String::as_str).collect();
        if !lost.is_empty() {
            warnings.push(format!("{format} does not hold these {element} attributes: {}", lost.join(", ")));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh(faces: &[&[u32]]) -> RawMesh {
        RawMesh { faces: faces.iter().copied().collect(), ..RawMesh::default() }
    }

    #[test]
    fn triangles_and_quads_are_borrowed() {
        let (mesh, mut warnings) = (mesh(&[&[0, 1, 2], &[0, 1, 2, 3]]), Vec::new());
        let small = SmallFaces::of(&mesh, "X", &mut warnings);
        assert!(matches!(small.faces, Cow::Borrowed(_)) && warnings.is_empty());
        assert_eq!(small.values(&[7, 8]).as_ref(), [7, 8]);
    }

    #[test]
    fn others_are_fanned_or_left_out_and_said() {
        let mesh = mesh(&[&[0, 1], &[4, 3, 2, 1, 0], &[0, 1, 2, 3], &[]]);
        let mut warnings = Vec::new();
        let small = SmallFaces::of(&mesh, "X", &mut warnings);
        let got: Vec<&[u32]> = small.faces.iter().collect();
        assert_eq!(got, [&[4, 3, 2][..], &[4, 2, 1], &[4, 1, 0], &[0, 1, 2, 3]]);
        assert_eq!(small.values(&[1, 2, 3, 4]).as_ref(), [2, 2, 2, 3]);
        assert_eq!(warnings.len(), 2);
    }
}
