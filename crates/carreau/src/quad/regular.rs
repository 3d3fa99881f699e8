//! Rung 1: the motorcycle graph of a frame field divides the surface into four-sided patches, which are filled with grids.

use super::fill::fill;
use super::layout::{Fault, Layout, audit};
use super::pair::{Coarse, coarse};
use super::sheet::Sheet;
use super::source::Source;
use super::trace::{cut, trace};
use super::work::{Place, Work};
use crate::context::Context;
use crate::error::Result;
use crate::field::{Field, FieldOptions, field};
use crate::geometry::features::FeatureOptions;
use crate::mesh::VertexId;
use rustc_hash::FxHashMap;

/// Edges of the triangles that carry the field, over those of the quads.
const FINER: f64 = 1.0;
/// Cuts of patches that have holes.
const CUTS: usize = 200;
/// Runs in search of a number of quads.
const RUNS: usize = 8;

/// What comes of it: a mesh, or why there is none.
pub type Outcome = std::result::Result<Work, String>;

/// Quads of a length, or so many of them.
pub fn regular(
    source: &Source,
    length: f64,
    wanted: Option<usize>,
    feature_deg: f64,
    context: &Context,
) -> Result<Outcome> {
    let Some(coarse) = coarse(source, FINER * length, feature_deg, context)? else {
        return Ok(Err("its features were not found again".into()));
    };
    let field = frames(&coarse, context)?;
    let curve: FxHashMap<[u32; 2], u32> =
        coarse.features.iter().map(|([a, b], c)| ([*a.min(b), *a.max(b)], *c)).collect();
    let sheet = match field.repaired.is_empty() {
        true => Sheet::new(&field, &curve, |t| coarse.region[t as usize]),
        false => None,
    };
    let Some(mut sheet) = sheet else { return Ok(Err("its features and its field do not match".into())) };
    let singular = field.corners.iter().filter(|c| c.is_singular()).map(|c| (c.vertex, c.quads)).collect::<Vec<_>>();
    let dropped = trace(&mut sheet, &singular, source.diagonal, context)?;
    let faults = mend(&mut sheet, source.diagonal, context)?;
    if faults > 0 {
        return Ok(Err(format!("{faults} patches are not regular, {dropped} tracks were taken back")));
    }
    let place = |v: u32| place(&sheet, &coarse, v);
    let Some(mut layout) = Layout::new(&sheet, |v| place(v) == Some(Place::Fixed)) else {
        return Ok(Err("its patches have no four sides".into()));
    };
    if !quantise(&mut layout, length, wanted) {
        return Ok(Err("the sides of its patches do not add up".into()));
    }
    Ok(fill(&sheet, &layout, place, context)?.ok_or_else(|| "a patch could not be mapped to a rectangle".to_string()))
}

fn frames(coarse: &Coarse, context: &Context) -> Result<Field> {
    let edges = coarse.features.iter().map(|(ends, _)| ends.map(VertexId)).collect();
    let features = FeatureOptions { angle_deg: None, borders: true, tags: false, edges };
    field(&coarse.mesh, &FieldOptions { features, ..FieldOptions::default() }, context)
}

/// Cuts patches with holes; returns how many patches are not regular in the end.
fn mend(sheet: &mut Sheet, diagonal: f64, context: &Context) -> Result<usize> {
    for _ in 0..CUTS {
        let faults = audit(sheet);
        let start = faults.iter().find_map(|f| match f {
            Fault::NeedsCut(h) => Some(*h),
            Fault::Irregular => None,
        });
        match start {
            Some(h) if !faults.contains(&Fault::Irregular) && cut(sheet, h, diagonal, context)? => {}
            _ => return Ok(faults.len()),
        }
    }
    Ok(CUTS)
}

/// Where a vertex of the sheet belongs, if it is on a feature.
fn place(sheet: &Sheet, coarse: &Coarse, v: u32) -> Option<Place> {
    if let Some(Place::Fixed) = coarse.place.get(v as usize) {
        return Some(Place::Fixed);
    }
    let mut curves = sheet.around(v).into_iter().flat_map(|h| [h, Sheet::previous(h)]).filter_map(|h| sheet.curve(h));
    let first = curves.next()?;
    Some(if curves.all(|c| c == first) { Place::Curve(first) } else { Place::Fixed })
}

/// Quantises until the number of quads is met.
fn quantise(layout: &mut Layout, length: f64, wanted: Option<usize>) -> bool {
    let mut length = length;
    let mut best: Option<(f64, f64)> = None;
    for _ in 0..RUNS {
        if !layout.quantise(length) {
            break;
        }
        let Some(wanted) = wanted else { return true };
        let ratio = layout.quads() as f64 / wanted as f64;
        let off = ratio.ln().abs();
        if best.is_none_or(|b| off < b.0) {
            best = Some((off, length));
        }
        if off < 0.02 {
            break;
        }
        length *= ratio.sqrt();
    }
    best.is_some_and(|(_, length)| layout.quantise(length))
}
