//! Material libraries (`.mtl`): kept as they are, and asked for the colours of materials.
//!
//! ```text
//! newmtl red paint        the name of a material; it may contain blanks
//! Kd 0.8 0.1 0.1          diffuse colour, taken as sRGB
//! d 0.3                   opacity; `Tr 0.7` says the same
//! map_Kd tex/body.png     a texture, relative to the folder of the library
//! ```

use super::super::names::plain_name;
use super::super::source::Source;
use super::super::text::{Scanner, shown};
use crate::mesh::{Attributes, Column, MaterialLibrary, RawMesh};
use crate::words::counted;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::{Component, Path, PathBuf};

/// The face column of materials.
const MATERIAL: &str = "material";
/// Bytes of the largest library that is read: it is text, a few hundred bytes a material.
const LARGEST_LIBRARY: u64 = 16 << 20;

/// The libraries that a statement `mtllib` names: one whose name has blanks, or several.
pub fn read_beside(mesh: &Path, names: &str, notes: &mut Vec<String>) -> Vec<MaterialLibrary> {
    let whole = load(mesh, names);
    let several = names.split_whitespace().count() > 1;
    if whole.is_none() && several {
        let each: Vec<(&str, Option<Vec<u8>>)> =
            names.split_whitespace().map(|name| (name, load(mesh, name))).collect();
        if each.iter().any(|(_, bytes)| bytes.is_some()) {
            return each.into_iter().map(|(name, bytes)| library(name, bytes, notes)).collect();
        }
    }
    if names.is_empty() { Vec::new() } else { vec![library(names, whole, notes)] }
}

fn library(name: &str, bytes: Option<Vec<u8>>, notes: &mut Vec<String>) -> MaterialLibrary {
    if bytes.is_none() {
        let shown = shown(name.as_bytes());
        notes.push(format!(
            "the material library '{shown}' is not beside the file: materials keep their names and have no colours"
        ));
    }
    MaterialLibrary { name: name.to_string(), bytes: bytes.unwrap_or_default() }
}

/// Reads a library that lies in the folder of the mesh, or below; others are none of a mesh file's business.
fn load(mesh: &Path, name: &str) -> Option<Vec<u8>> {
    let inside = Path::new(name).components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
    if !inside || name.is_empty() || name.contains('\0') {
        return None;
    }
    let file = File::open(mesh.parent().unwrap_or(Path::new("")).join(name)).ok()?;
    let found = file.metadata().ok()?;
    if !found.is_file() || found.len() > LARGEST_LIBRARY {
        return None;
    }
    let mut bytes = Vec::new();
    file.take(LARGEST_LIBRARY).read_to_end(&mut bytes).ok()?;
    Some(bytes)
}

/// What a library says about a material.
#[derive(Clone, Copy)]
struct Look {
    diffuse: Option<[f64; 3]>,
    opacity: f64,
}

/// Gives the labels of materials the colours that the libraries have for their names.
pub fn color_materials(attributes: &mut Attributes) {
    let mut looks: BTreeMap<String, Look> = BTreeMap::new();
    for library in &attributes.libraries {
        collect(library, &mut looks);
    }
    let byte = |x: f64| (255.0 * x.clamp(0.0, 1.0)).round() as u8;
    for ((column, label), name) in attributes.names.iter().filter(|((column, _), _)| column == MATERIAL) {
        let Some(Look { diffuse: Some([r, g, b]), opacity }) = looks.get(name).copied() else { continue };
        attributes.colors.insert((column.clone(), *label), [r, g, b, opacity].map(byte));
    }
}

/// The materials of a library; malformed lines say nothing.
fn collect(library: &MaterialLibrary, looks: &mut BTreeMap<String, Look>) {
    let source = Source { path: Path::new(&library.name), bytes: &library.bytes };
    let mut scanner = Scanner::new(&source, Some(b'#'));
    let mut current = String::new();
    loop {
        match scanner.word_on_line() {
            Some(b"newmtl") => {
                current = String::from_utf8_lossy(scanner.rest_of_line()).into_owned();
                looks.insert(current.clone(), Look { diffuse: None, opacity: 1.0 });
            }
            Some(word @ (b"Kd" | b"d" | b"Tr")) => {
                let mut values = [0.0; 3];
                let count = scanner.floats_on_line(&mut values, "a number").unwrap_or(0);
                if let Some(look) = looks.get_mut(&current).filter(|_| values.iter().all(|x| x.is_finite())) {
                    match (word, count) {
                        // One number alone is a grey.
                        (b"Kd", 1) => look.diffuse = Some([values[0]; 3]),
                        (b"Kd", 3) => look.diffuse = Some(values),
                        (b"d", 1) => look.opacity = values[0],
                        (b"Tr", 1) => look.opacity = 1.0 - values[0],
                        _ => {}
                    }
                }
            }
            _ => {}
        }
        if !scanner.next_line() {
            return;
        }
    }
}

/// What a mesh's file says about its materials.
pub struct LibraryFile {
    /// The statements `mtllib`, which come before the mesh.
    pub statements: String,
    /// The library to write beside the mesh; none where there is nothing to say.
    pub file: Option<(PathBuf, Vec<u8>)>,
    /// What the user should know about it.
    pub warnings: Vec<String>,
}

/// The library of a mesh that is written to `path`: what its libraries had, or the colours of its materials.
pub fn library_beside(mesh: &RawMesh, path: &Path) -> LibraryFile {
    let attributes = &mesh.attributes;
    let mut out = LibraryFile { statements: String::new(), file: None, warnings: Vec::new() };
    if !matches!(attributes.face.get(MATERIAL), Some(Column::Label(_))) {
        return out;
    }
    let mut bytes = Vec::new();
    for library in &attributes.libraries {
        if library.bytes.is_empty() {
            // Nothing is known but its name, which may be right where the output is looked at.
            out.statements += &format!("mtllib {}\n", library.name);
        }
        bytes.extend_from_slice(&library.bytes);
        if !bytes.is_empty() && !bytes.ends_with(b"\n") {
            bytes.push(b'\n');
        }
    }
    let textures = bytes.split(|&b| b == b'\n').filter(|line| has_texture(line)).count();
    if textures > 0 {
        let files = counted(textures, "texture", "textures");
        out.warnings.push(format!(
            "the materials refer to {files} by paths from the folder of the input: image files are not copied, bring them along"
        ));
    }
    if bytes.is_empty() {
        bytes = made(attributes);
    }
    if !bytes.is_empty() {
        let beside = path.with_extension("mtl");
        let name = beside.file_name().unwrap_or_default().to_string_lossy().into_owned();
        out.statements += &format!("mtllib {name}\n");
        out.file = Some((beside, bytes));
    }
    out
}

fn has_texture(line: &[u8]) -> bool {
    let line = line.trim_ascii_start();
    let starts = |word: &[u8]| line.len() > word.len() && line[..word.len()].eq_ignore_ascii_case(word);
    [&b"map_"[..], b"bump ", b"disp ", b"decal ", b"norm ", b"refl "].iter().any(|word| starts(word))
}

/// A library with the colours of materials.
fn made(attributes: &Attributes) -> Vec<u8> {
    let mut text = String::new();
    let share = |c: u8| f64::from(c) / 255.0;
    for ((column, label), &[r, g, b, a]) in attributes.colors.iter().filter(|((column, _), _)| column == MATERIAL) {
        let name = attributes.name(column, *label).map_or_else(|| label.to_string(), plain_name);
        text += &format!("newmtl {name}\nKd {} {} {}\nd {}\n", share(r), share(g), share(b), share(a));
    }
    text.into_bytes()
}
