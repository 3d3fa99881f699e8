//! Reading and writing files: one file per format, one table of formats ([`FORMATS`]).
//!
//! A reader turns the bytes of a file into a [`RawMesh`](crate::mesh::RawMesh). It never panics, never allocates by a number that it has not checked
//! against the size of the file, and says at which line or byte it stopped. A writer fills a buffer, which [`write()`] puts in
//! place in one step: the file appears whole or not at all.
//!
//! | file | holds |
//! |---|---|
//! | `obj`, `off`, `ply`, `stl`, `gltf`, `threemf` | formats of surfaces |
//! | `medit`, `gmf`, `gmsh`, `vtk_legacy`, `vtk_xml` | formats of surfaces and volumes |
//! | `fem` | input of finite element programs, which is only written |
//! | `skeleton` | formats of skeletons |
//! | `cad`, `step`, `iges` | CAD models, which are only written |
//! | `text`, `binary`, `limits`, `names`, `percent` | what readers and writers share |
//! | `vtk_cells`, `vtk_arrays`, `medit_sections`, `medit_keywords`, `small_faces` | what some of the formats share |
//! | `source`, `formats`, `files` | what a reader is given; the table of formats; reading and writing whole files |
//! | `outputs`, `atomic` | checks of an output before any work; writing in one step |
//! | `advice` | what to do about files that are not read |

mod advice;
mod atomic;
mod binary;
pub mod cad;
mod fem;
mod files;
mod formats;
mod gltf;
mod gmf;
mod gmsh;
pub mod iges;
mod limits;
mod medit;
mod medit_keywords;
mod medit_sections;
mod names;
mod obj;
mod off;
mod outputs;
mod percent;
mod ply;
#[cfg(test)]
mod round_trips;
mod skeleton;
mod small_faces;
mod source;
pub mod step;
mod stl;
#[cfg(test)]
mod surface_tests;
mod text;
mod threemf;
mod vtk_arrays;
mod vtk_cells;
mod vtk_legacy;
mod vtk_xml;

pub use atomic::write_atomically;
pub use cad::{CAD_EXTENSIONS, CadOptions, IgesForm, StepSchema, Unit, write_cad};
pub use files::{read, write};
pub use formats::{FORMATS, Format, format_of};
pub use outputs::{ResultKind, check_format, check_place, check_second_order, holds_numbers, holds_second_order};
pub use skeleton::{SKELETON_EXTENSIONS, is_skeleton_file, read_skeleton, write_skeleton};
pub use source::{Source, WriteOptions, extension};
