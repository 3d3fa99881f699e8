//! STEP (ISO 10303-21) files of boundary representations, for the protocols AP214 and AP242.
//!
//! Solids are MANIFOLD_SOLID_BREP or BREP_WITH_VOIDS, shells without a solid are in a SHELL_BASED_SURFACE_MODEL. Points
//! are written once per position and referenced wherever they occur, in control nets too: neighbours then agree exactly,
//! and files are about a third smaller.
//!
//! | file | what is written |
//! |---|---|
//! | `text` | entities, lists, numbers, strings |
//! | `product` | header, units, the product and its representations |
//! | `topology` | vertices, edges, loops, faces, shells, solids |
//! | `geometry` | points, curves, surfaces |
//! | `style` | colours of faces |

mod geometry;
mod product;
mod style;
#[cfg(test)]
mod tests;
mod text;
mod topology;
mod writer;

use super::cad::CadOptions;
use crate::brep::Brep;
use crate::error::Result;
use rustc_hash::FxHashMap;
use writer::Writer;

/// Appends the file's bytes.
///
/// # Errors
/// [`Error::Options`](crate::Error::Options) for options that make no sense.
pub fn write(brep: &Brep, options: &CadOptions, out: &mut Vec<u8>) -> Result<()> {
    options.check()?;
    let mut writer = Writer { out, last: 0, points: FxHashMap::default(), points_2d: FxHashMap::default() };
    writer.header(options);
    let context = writer.context(brep, options.unit);
    let written = writer.topology(brep, options.parameter_curves);
    writer.product(brep, options, context, &written.shells);
    writer.colors(brep, context, &written.faces);
    writer.text("ENDSEC;\nEND-ISO-10303-21;\n");
    Ok(())
}
