//! Decks of finite element programs, written only: Abaqus and CalculiX (`.inp`), Nastran (`.bdf`).
//!
//! Sources: *Abaqus Analysis User's Guide*, elements and input syntax; *MSC Nastran Quick Reference Guide*, bulk data.
//!
//! | file | holds |
//! |---|---|
//! | `sets` | labels as sets with names |
//! | `abaqus` | `.inp` |
//! | `nastran` | `.bdf` |
//!
//! Corner orders are those of VTK. Nodes and elements count from 1; faces come first, then tetrahedra, hexahedra, wedges and
//! pyramids. Loads, materials and sections are the analyst's: none is made up.

mod abaqus;
mod nastran;
mod sets;
#[cfg(test)]
mod tests;

use super::source::Source;
use crate::error::{Place, Result};
use crate::mesh::RawMesh;

pub(super) use abaqus::write as write_inp;
pub(super) use nastran::write as write_bdf;

/// These files are not read: says what to do instead.
pub(super) fn read(source: &Source) -> Result<RawMesh> {
    let advice = super::advice::advice(&super::source::extension(source.path)).unwrap_or("it is written only");
    Err(source.error(Place::File, advice))
}
