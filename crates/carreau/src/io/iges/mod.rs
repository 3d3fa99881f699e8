//! IGES 5.3 files of boundary representations.
//!
//! Two forms, by [`super::cad::IgesForm`]. As surfaces: a whole patch is an untrimmed 128 (rational B-spline surface with unit weights);
//! trimmed faces are 144 → 142 → 102 of curves. Systems that need a closed body sew the faces, which agree on their borders. As
//! solids: 186 → 514 shells → 510 faces → 508 loops → 504 edges → 502 vertices.
//!
//! | file | what is written |
//! |---|---|
//! | `global` | start and global section |
//! | `records` | directory and parameter records |
//! | `curves`, `surfaces` | geometry |
//! | `trimmed` | faces one by one |
//! | `solid` | the whole boundary representation |
//!
//! Records have 80 columns; the last eight are the section's letter and the number of the record:
//!
//! ```text
//! S text                                                                  S      1
//! G delimiters, names, precision, unit, date, resolution                  G      1
//! D      128       1       0 …two records of ten fields of eight columns  D      1
//! P 128,3,2,1,1,0,0,1,0,0,0.,…;                           (65–72: D no.) 1P      1
//! T S      1G      3D      2P      7                                      T      1
//! ```

mod curves;
mod global;
mod records;
mod solid;
mod surfaces;
#[cfg(test)]
mod tests;
mod trimmed;
mod words;

use super::cad::{CadOptions, IgesForm};
use crate::brep::Brep;
use crate::error::{Error, Result};
use global::{ascii, global_fields, push_lines};
use records::Writer;
use words::{MAX_LINES, VERSION};

/// Appends the file's bytes.
///
/// # Errors
/// [`Error::Options`] for options that make no sense, [`Error::Input`] for a model of more records than IGES can number.
pub fn write(brep: &Brep, options: &CadOptions, out: &mut Vec<u8>) -> Result<()> {
    options.check()?;
    let mut writer = Writer::default();
    match options.iges {
        IgesForm::Surfaces => writer.trimmed_faces(brep),
        IgesForm::Solids => writer.solids(brep),
    }
    if writer.directory_lines > MAX_LINES || writer.parameter_lines > MAX_LINES {
        return Err(Error::input(
            format!("the model needs more than {MAX_LINES} records, which IGES cannot number"),
            "",
            "write STEP instead",
        ));
    }
    let start = push_lines(out, b'S', &[format!("{} written by carreau {}", ascii(&options.name), VERSION)]);
    let global = push_lines(out, b'G', &global_fields(brep, options));
    out.extend_from_slice(&writer.directory);
    out.extend_from_slice(&writer.parameters);
    let counts = format!("S{start:>7}G{global:>7}D{:>7}P{:>7}", writer.directory_lines, writer.parameter_lines);
    out.extend_from_slice(format!("{counts:<72}T{:>7}\n", 1).as_bytes());
    Ok(())
}
