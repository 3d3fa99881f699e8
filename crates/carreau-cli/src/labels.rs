//! Labels of faces, from a property or a file.

use carreau::mesh::{Column, Prepared};
use carreau::{Error, Place};
use std::path::Path;

/// Labels from a face property of the mesh, or from a text file with one integer per triangle.
pub fn read_labels(prepared: &Prepared, name: &str) -> Result<Vec<u32>, Error> {
    let mesh = &prepared.mesh;
    // Any integers do: only whether two are equal matters, and their order.
    let shift = |l: i64| (l - i64::from(i32::MIN)) as u32;
    match mesh.attributes.face.get(name) {
        Some(Column::Label(labels)) => return Ok(labels.iter().map(|&l| shift(i64::from(l))).collect()),
        Some(_) => return Err(Error::Options(format!("the face property '{name}' holds no integers"))),
        None => {}
    }
    let file = Path::new(name);
    if !file.exists() {
        let known: Vec<&str> = mesh.attributes.face.keys().map(String::as_str).collect();
        let known = if known.is_empty() { "none".into() } else { known.join(", ") };
        return Err(Error::Options(format!(
            "--labels {name}: no such file, and no such face property (there are: {known})"
        )));
    }
    let text = std::fs::read_to_string(file).map_err(|e| Error::read(file, Place::File, e.to_string()))?;
    let mut labels = Vec::new();
    for (line, number) in text.lines().zip(1..) {
        for word in line.split('#').next().unwrap_or("").split_whitespace() {
            let label: i32 = word.parse().map_err(|_| {
                Error::read(file, Place::Line(number), format!("an integer is expected, found '{word}'"))
            })?;
            labels.push(shift(i64::from(label)));
        }
    }
    let triangles = prepared.input().face_count();
    if labels.len() != triangles {
        let what = format!("{} labels for {triangles} triangles", labels.len());
        return Err(Error::read(file, Place::File, what));
    }
    Ok(prepared.gather_faces(labels))
}
