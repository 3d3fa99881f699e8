//! From a surface to its motorcycle graph: coarse triangles, their frame field, tracks, and cuts where tracks leave patches
//! that are no discs.

use super::super::coarse::{Coarse, Follow, coarse, smoothest_field_of};
use super::super::source::Source;
use super::super::work::Place;
use super::cut::open_holes;
use super::layout::{Fault, audit};
use super::sheet::Sheet;
use super::trace::{Traced, cut, trace};
use crate::context::Context;
use crate::error::Result;
use rustc_hash::{FxHashMap, FxHashSet};

/// Edges of the triangles that carry the field over those of the quads, in the order in which they are tried, because
/// another field may do where one is no good.
pub const FIELD_EDGES: [f64; 6] = [1.0, 0.6, 0.8, 0.45, 0.7, 0.9];

/// A count: rounds of cuts through patches that are no discs at most, because each looks at all patches again.
const MOST_DISC_CUTS: usize = 200;

/// A sheet with its tracks.
pub struct Drawn {
    pub coarse: Coarse,
    pub sheet: Sheet,
    pub singular: Vec<(u32, i32)>,
    pub traced: Traced,
    /// Vertices of the cuts that follow the frames, and of those that do not.
    pub cuts: [Vec<Vec<u32>>; 2],
}

/// Draws the graph for quads of a length, on triangles with edges of another one; or says why there is none.
pub fn draw(
    source: &Source,
    length: f64,
    edges: f64,
    feature_deg: f64,
    context: &Context,
) -> Result<std::result::Result<Drawn, String>> {
    let Some(coarse) = coarse(source, edges, Follow::loose(1.0), feature_deg, context)? else {
        return Ok(Err("its features were not found again".into()));
    };
    let field = smoothest_field_of(&coarse, context)?;
    let curve: FxHashMap<[u32; 2], u32> =
        coarse.features.iter().map(|([a, b], c)| ([*a.min(b), *a.max(b)], *c)).collect();
    let sheet = match field.repaired.is_empty() {
        true => Sheet::new(&field, &curve, |t| coarse.region[t as usize], length),
        false => None,
    };
    let Some(mut sheet) = sheet else { return Ok(Err("its features and its field do not match".into())) };
    let singular: Vec<_> = field.corners.iter().filter(|c| c.is_singular()).map(|c| (c.vertex, c.quads)).collect();
    let traced = trace(&mut sheet, &singular, source.diagonal, context)?;
    let cuts = mend(&mut sheet, source.diagonal, context)?;
    Ok(Ok(Drawn { coarse, sheet, singular, traced, cuts }))
}

/// Cuts patches that are no discs; returns the vertices of the cuts.
fn mend(sheet: &mut Sheet, diagonal: f64, context: &Context) -> Result<[Vec<Vec<u32>>; 2]> {
    let (mut along, mut tried) = (Vec::new(), FxHashSet::default());
    for _ in 0..MOST_DISC_CUTS {
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
        along.extend(cut(sheet, start, diagonal, context)?);
    }
    Ok([along, open_holes(sheet)])
}

/// Where a vertex of the sheet belongs, if it is on a feature.
pub fn place(sheet: &Sheet, coarse: &Coarse, v: u32) -> Option<Place> {
    if let Some(Place::Fixed) = coarse.place.get(v as usize) {
        return Some(Place::Fixed);
    }
    let mut curves = sheet.around(v).into_iter().flat_map(|h| [h, Sheet::previous(h)]).filter_map(|h| sheet.curve(h));
    let first = curves.next()?;
    Some(if curves.all(|c| c == first) { Place::Curve(first) } else { Place::Fixed })
}
