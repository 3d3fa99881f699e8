//! What the two CAD writers have in common: options, units, numbers, the choice by extension.

mod breaks;
mod numbers;
mod options;
#[cfg(test)]
mod tests;

use super::source::extension;
use super::{iges, step};
use crate::brep::Brep;
use crate::error::{Error, Result};
use std::path::Path;

pub(super) use breaks::needs_parameter_curves;
pub(super) use numbers::{push_real, resolution};
pub use options::{CadOptions, IgesForm, StepSchema, Unit};

/// Extensions of the CAD formats, in lower case.
pub const CAD_EXTENSIONS: &[&str] = &["step", "stp", "igs", "iges"];

/// Writes a CAD file into a buffer; the extension of `path` decides the format.
///
/// # Errors
/// [`Error::Write`] for an extension that is no CAD format,
/// [`Error::Options`] for options that make no sense.
pub fn write_cad(path: &Path, brep: &Brep, options: &CadOptions, out: &mut Vec<u8>) -> Result<()> {
    match extension(path).as_str() {
        "step" | "stp" => step::write(brep, options, out),
        "igs" | "iges" => iges::write(brep, options, out),
        _ => Err(Error::write(path, format!("not a CAD format; known are: {}", CAD_EXTENSIONS.join(", ")))),
    }
}
