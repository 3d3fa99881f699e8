//! 3MF (`.3mf`): bodies, materials, colours and the unit, read and written.
//!
//! Sources: 3MF Consortium, *3D Manufacturing Format: Core Specification* 1.3, *Materials and Properties Extension* 1.2 (colour
//! groups), *Production Extension* 1.1 (objects in further parts of the package).
//!
//! | in the file | in the mesh |
//! |---|---|
//! | `<item>` of the build and its `<component>`s, at their places | bodies: face label `object` with the names of the objects |
//! | `<basematerials>` | face label `material` with names and colours |
//! | … named by their colours alone, `<colorgroup>` with one colour a triangle | face column `color` |
//! | `<colorgroup>` with three colours a triangle | corner column `color` |
//! | `unit` | `unit`; coordinates stay as they are |
//!
//! | file | holds |
//! |---|---|
//! | `package` | the ZIP container, with limits |
//! | `model` | the XML of a part: objects, colours, build |
//! | `read` | objects at their places to one mesh |
//! | `write` | the writer |
//!
//! Textures, composites, beams, slices, print tickets and supports are not read.

mod model;
mod package;
mod read;
#[cfg(test)]
mod tests;
mod words;
mod write;

pub(super) use read::read;
pub(super) use write::write;
