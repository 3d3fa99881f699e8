//! Gmsh files (`.msh`), versions 2.2 and 4.1, text and binary.
//!
//! Source: *Gmsh reference manual*, sections "MSH file format" and "MSH file format version 2 (Legacy)".
//!
//! | file | holds |
//! |---|---|
//! | `stream` | sections and numbers, text or binary |
//! | `elements` | the element types |
//! | `nodes` | node tags, which may have gaps, to vertex ids |
//! | `collector` | elements to [`RawMesh`] |
//! | `version2`, `version4` | what differs between the versions |
//! | `write` | version 4.1 |
//!
//! Corner orders are those of VTK, except that Gmsh itself exchanges corners 1-2 and 4-5 of a prism when it writes VTK;
//! here no corner is exchanged: of a wedge, 0-1-2 is counter-clockwise seen from 3-4-5.
//!
//! The reference of an element is its (first) physical tag: face label `ref`, `edge_tags`, `cells.tags`; of point
//! elements, vertex label `ref`. Where elementary entities (the faces of a CAD model) divide the faces further than
//! physical tags do, they are the face label `entity`. Physical names become names of the labels `ref` (surfaces), and
//! of `vertex`, `edge` and `cell` (physical points, curves and volumes). Of elements of higher order the corners are
//! kept; their other nodes stay as vertices that no element uses.

mod collector;
mod element;
mod elements;
mod nodes;
mod stream;
#[cfg(test)]
mod tests;
mod version2;
mod version4;
mod write;

use super::source::{Source, WriteOptions};
use super::text::shown;
use crate::error::{Place, Result};
use crate::mesh::RawMesh;
use collector::Collector;
use stream::Stream;

/// The sections of a file that depend on its version.
type SectionReader = fn(&mut Stream, &mut Collector) -> Result<()>;

struct Version {
    nodes: SectionReader,
    elements: SectionReader,
    entities: Option<SectionReader>,
}

pub(super) fn read(source: &Source) -> Result<RawMesh> {
    let (mut stream, version) = Stream::open(source)?;
    let readers = version_readers(&stream, version)?;
    let mut mesh = Collector::default();
    while let Some(name) = stream.heading()? {
        match (name, readers.entities) {
            (b"Nodes", _) if mesh.has_nodes() => return Err(stream.error("this is a second section $Nodes")),
            (b"Nodes", _) => (readers.nodes)(&mut stream, &mut mesh)?,
            (b"Elements", _) if !mesh.has_nodes() => return Err(stream.error("$Elements comes before $Nodes")),
            (b"Elements", _) => (readers.elements)(&mut stream, &mut mesh)?,
            (b"Entities", Some(entities)) if !mesh.has_elements() => entities(&mut stream, &mut mesh)?,
            (b"ParametricNodes", _) => {
                return Err(
                    stream.error("$ParametricNodes of version 2 are not read; save without parametric coordinates")
                );
            }
            (b"PhysicalNames", _) => read_physical_names(&mut stream, &mut mesh)?,
            _ => {
                stream.skip(name)?;
                mesh.skipped(name);
                continue;
            }
        }
        stream.close(name)?;
    }
    mesh.finish().map_err(|what| source.error(Place::File, what))
}

/// Gmsh has written "2" for 2.2 too.
fn version_readers(stream: &Stream, version: &[u8]) -> Result<Version> {
    match version {
        b"2" | b"2.1" | b"2.2" if stream.is_short() => Err(stream.error("single precision is not known in version 2")),
        b"2" | b"2.1" | b"2.2" => {
            Ok(Version { nodes: version2::read_nodes, elements: version2::read_elements, entities: None })
        }
        b"4.1" => Ok(Version {
            nodes: version4::read_nodes,
            elements: version4::read_elements,
            entities: Some(version4::read_entities),
        }),
        other => Err(stream.error(format!(
            "version {} of the MSH format is not read, 2.2 and 4.1 are; `gmsh IN -save -format msh41 -o OUT` converts it",
            shown(other)
        ))),
    }
}

/// `dimension tag "name"`, one a line, as text in binary files too.
fn read_physical_names(stream: &mut Stream, mesh: &mut Collector) -> Result<()> {
    let count = stream.text_integer("the number of physical names")?;
    for _ in 0..count {
        let line = stream.line("a physical name")?;
        let text = String::from_utf8_lossy(line);
        let mut words = text.split_whitespace();
        let mut number = || words.next().and_then(|w| w.parse::<i32>().ok());
        let (Some(dimension @ 0..=3), Some(tag)) = (number(), number()) else {
            return Err(stream.error(format!("dimension, tag and name are expected, found '{}'", shown(line))));
        };
        let name = text.split_once('"').map(|(_, rest)| rest.rsplit_once('"').map_or(rest, |(name, _)| name));
        mesh.name(dimension, tag, name.unwrap_or_default());
    }
    Ok(())
}

pub(super) fn write(mesh: &RawMesh, options: &WriteOptions, out: &mut Vec<u8>) -> Result<Vec<String>> {
    Ok(write::write(mesh, options.ascii, out))
}
