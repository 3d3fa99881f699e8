//! Rungs 1 and 2: the motorcycle graph of a frame field divides the surface into patches.
//!
//! Rung 1: all have four sides that add up, and are filled with grids. Rung 2: where some have not, grids of twice the size
//! are made in the others and triangles in these, paired where possible, and all is halved: any numbers of sides fit then.

use super::fill::fill;
use super::halve::{Middle, halve};
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
use rustc_hash::{FxHashMap, FxHashSet};

/// Edges of the triangles that carry the field, over those of the quads.
const FINER: f64 = 1.0;
/// Cuts of patches that have holes.
const CUTS: usize = 200;
/// Runs in search of a number of quads.
const RUNS: usize = 8;

/// What comes of it: a mesh with its rung, or why there is none.
pub type Outcome = std::result::Result<(Work, u32), String>;

/// Quads of a length, or so many of them; `first`: rung 1 may do.
pub fn regular(
    source: &Source,
    length: f64,
    wanted: Option<usize>,
    feature_deg: f64,
    first: bool,
    context: &Context,
) -> Result<Outcome> {
    let Some(coarse) = coarse(source, FINER * length, feature_deg, context)? else {
        return Ok(Err("its features were not found again".into()));
    };
    let field = frames(&coarse, context)?;
    let curve: FxHashMap<[u32; 2], u32> =
        coarse.features.iter().map(|([a, b], c)| ([*a.min(b), *a.max(b)], *c)).collect();
    let sheet = match field.repaired.is_empty() {
        true => Sheet::new(&field, &curve, |t| coarse.region[t as usize], length),
        false => None,
    };
    let Some(mut sheet) = sheet else { return Ok(Err("its features and its field do not match".into())) };
    let singular = field.corners.iter().filter(|c| c.is_singular()).map(|c| (c.vertex, c.quads)).collect::<Vec<_>>();
    let dropped = trace(&mut sheet, &singular, source.diagonal, context)?;
    mend(&mut sheet, source.diagonal, context)?;
    let place = |v: u32| place(&sheet, &coarse, v);
    let Some(mut layout) = Layout::new(&sheet, |v| place(v) == Some(Place::Fixed)) else {
        return Ok(Err("its tracks do not enclose patches".into()));
    };
    let missing = || "a patch could not be filled".to_string();
    if first && layout.is_regular() && quantise(&mut layout, length, wanted) {
        let work = fill(&sheet, &layout, place, context)?.map(|work| settled(work, source));
        return Ok(work.map(|work| (work, 1)).ok_or_else(missing));
    }
    let irregular = layout.patches.iter().filter(|p| p.sides.is_none()).count();
    tracing::debug!(target: "carreau::quad", dropped, irregular, patches = layout.patches.len());
    quantise_leniently(&mut layout, 2.0 * length, wanted.map(|n| n as f64 / 4.0));
    let work = fill(&sheet, &layout, place, context)?.map(|work| settled(work, source));
    Ok(work.map(|work| (halve(&work, source, Middle::OnSurface), 2)).ok_or_else(missing))
}

/// Every vertex where it belongs: the sheet's features are chords of the source's.
fn settled(mut work: Work, source: &Source) -> Work {
    for v in 0..work.points.len() as u32 {
        work.points[v as usize] = work.put_back(source, v, work.points[v as usize]);
    }
    work
}

fn frames(coarse: &Coarse, context: &Context) -> Result<Field> {
    let edges = coarse.features.iter().map(|(ends, _)| ends.map(VertexId)).collect();
    let features = FeatureOptions { angle_deg: None, borders: true, tags: false, edges };
    field(&coarse.mesh, &FieldOptions { features, ..FieldOptions::default() }, context)
}

/// Cuts patches that are no discs.
fn mend(sheet: &mut Sheet, diagonal: f64, context: &Context) -> Result<()> {
    let mut tried = FxHashSet::default();
    for _ in 0..CUTS {
        let faults = audit(sheet).into_iter();
        let starts = faults.filter_map(|f| match f {
            Fault::NeedsCut(starts) => Some(starts),
            Fault::Irregular => None,
        });
        // From the middle of what there is; not twice from the same vertex.
        let fresh =
            starts.map(|starts| starts.into_iter().filter(|&h| !tried.contains(&sheet.tail(h))).collect::<Vec<_>>());
        let Some(start) = fresh.into_iter().find_map(|starts| starts.get(starts.len() / 2).copied()) else { break };
        tried.insert(sheet.tail(start));
        cut(sheet, start, diagonal, context)?;
    }
    Ok(())
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

/// Quantises until the number of quads is met; returns whether all patches add up.
fn quantise(layout: &mut Layout, length: f64, wanted: Option<usize>) -> bool {
    let mut length = length;
    let mut best: Option<(f64, f64)> = None;
    for _ in 0..RUNS {
        if layout.quantise(length).is_err() {
            break;
        }
        let Some(wanted) = wanted else { return true };
        let ratio = layout.quads(length) / wanted as f64;
        let off = ratio.ln().abs();
        if best.is_none_or(|b| off < b.0) {
            best = Some((off, length));
        }
        if off < 0.02 {
            break;
        }
        length *= ratio.sqrt();
    }
    best.is_some_and(|(_, length)| layout.quantise(length).is_ok())
}

/// The same where patches that do not add up are filled with triangles.
fn quantise_leniently(layout: &mut Layout, mut length: f64, wanted: Option<f64>) {
    let sides: Vec<_> = layout.patches.iter().map(|p| p.sides.clone()).collect();
    for _ in 0..RUNS {
        layout.patches.iter_mut().zip(&sides).for_each(|(p, sides)| p.sides = sides.clone());
        layout.quantise_leniently(length);
        let ratio = wanted.map_or(1.0, |wanted| layout.quads(length) / wanted);
        if ratio.ln().abs() < 0.03 {
            break;
        }
        length *= ratio.sqrt();
    }
}
