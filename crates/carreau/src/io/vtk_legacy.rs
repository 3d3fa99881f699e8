//! VTK legacy files (`.vtk`), versions 2.0 to 5.1, text and binary; polydata and unstructured grids.
//!
//! After: *VTK File Formats*, Kitware (section "Simple Legacy Formats") and, where it is silent, what VTK's own writers
//! do: METADATA blocks after an array, cells as OFFSETS and CONNECTIVITY since version 5.1, percent codes in names.
//! Binary numbers are big endian.
//!
//! Written is version 4.2, which VTK and all other readers know; an unstructured grid where there are volume cells, else
//! polydata. Data arrays are written as FIELD data, the one form that fits all of them.

mod read;
mod write;

pub(super) use read::read;
pub(super) use write::write;

#[cfg(test)]
mod tests;
mod walker;
