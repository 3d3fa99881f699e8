//! glTF 2.0: `.gltf` (JSON, with its buffers embedded or beside it) and `.glb` (one binary file).
//!
//! After: *glTF 2.0 Specification*, Khronos Group (ISO/IEC 12113:2022).
//!
//! | file | holds |
//! |---|---|
//! | `schema` | the parts of the JSON that matter here |
//! | `container` | GLB chunks and buffers: embedded, external, binary chunk |
//! | `accessor` | typed arrays in buffers |
//! | `scene` | nodes and their transforms |
//! | `read` | primitives to one mesh |
//! | `vertices` | vertices as they are written |
//! | `write` | the writer |
//!
//! All meshes of the default scene become one mesh, in world coordinates. Vertices are those of the accessors, in order
//! and not welded; primitives of one mesh that use the same accessors share their vertices. Positions, `normal`, `uv` and
//! `color` are kept; of materials (face label `material`) name, base colour and opacity; names of nodes as the face label
//! `object`; textures, skins, morph targets and animations are not. Texture coordinates are kept as they are:
//! glTF counts the second from the top of the image.
//!
//! Colours of vertices are linear in glTF and sRGB (as in PLY and OBJ) in the column `color`; they are converted both ways.

mod accessor;
mod container;
mod read;
mod scene;
mod schema;
mod srgb;
#[cfg(test)]
mod tests;
mod vertices;
mod write;

pub(super) use read::read;
pub(super) use write::{write_glb, write_gltf};
