//! Bends that no edge may cut off become nodes of the layout.
//!
//! ```text
//!      ╱╲                  ●        An edge across a sharp bend of a coarse circle is not along either side of it. Where
//!     ╱  ╲                ╱ ╲       vertices between nodes do not find their bends, the bends are nodes themselves: what is
//!   ─╱────╲─     →      ─╱   ╲─     between two of them is straight.
//!   ╱      ╲            ╱     ╲
//! ```

use super::sheet::Sheet;
use super::source::Source;
use glam::DVec3;
use rustc_hash::FxHashSet;

/// A vertex as near to a bend as this share of the edge beside goes there; else the edge is divided.
const NEAR: f64 = 0.3;

/// Puts vertices of the sheet to the sharp bends of a feature curve. New triangles get the state of those that they are part
/// of.
pub fn pin<T: Copy>(sheet: &mut Sheet, source: &Source, curve: u32, pinned: &mut FxHashSet<u32>, state: &mut Vec<T>) {
    for &bend in source.sharp.get(&curve).into_iter().flatten() {
        let Some(h) = nearest(sheet, curve, bend) else { return };
        let ends = [sheet.tail(h), sheet.head(h)];
        let length = sheet.along(h).length();
        let is_near = |&v: &u32| sheet.points[v as usize].distance(bend) < NEAR * length && !pinned.contains(&v);
        let v = match ends.into_iter().find(is_near) {
            Some(v) => {
                sheet.points[v as usize] = bend;
                v
            }
            None if ends.iter().any(|&v| sheet.points[v as usize] == bend) => continue,
            None => {
                let beside = [Some(h), Some(sheet.opposite[h as usize])];
                let both = beside.into_iter().flatten().filter_map(|h| state.get(h as usize / 3).copied());
                state.extend(both.collect::<Vec<T>>());
                sheet.divide(h, bend)
            }
        };
        pinned.insert(v);
    }
}

/// The half-edge of a curve nearest to a point.
fn nearest(sheet: &Sheet, curve: u32, p: DVec3) -> Option<u32> {
    let on_curve = (0..3 * sheet.triangles.len() as u32).filter(|&h| sheet.curve(h) == Some(curve));
    let of = |h: u32| (sheet.distance(sheet.tail(h), sheet.head(h), p), h);
    on_curve.map(of).min_by(|a, b| a.0.total_cmp(&b.0)).map(|found| found.1)
}

#[cfg(test)]
mod tests {
    use super::super::draw::draw;
    use super::*;
    use crate::context::Context;
    use crate::geometry::features::FeatureOptions;
    use crate::mesh::test_models::triangles;
    use glam::DVec2;
    use std::f64::consts::TAU;

    #[test]
    fn sharp_bends_become_vertices_of_the_sheet() {
        // A disc with twelve straight edges around, which bend by 30°: no corners.
        let rim = |k: usize| (DVec2::from_angle(TAU * k as f64 / 12.0) * 3.0).extend(0.0);
        let points: Vec<DVec3> = (0..12).map(rim).chain([DVec3::ZERO]).collect();
        let faces: Vec<[u32; 3]> = (0..12).map(|k| [k, (k + 1) % 12, 12]).collect();
        let (mesh, context) = (triangles(&points, &faces), Context::new());
        let source = Source::new(&mesh, &FeatureOptions::default(), &context).unwrap();
        assert_eq!(source.sharp.values().map(Vec::len).sum::<usize>(), 12);
        let mut sheet = draw(&source, 1.0, 0.9, 35.0, &context).unwrap().unwrap().sheet;
        let (mut pinned, mut state) = (FxHashSet::default(), vec![7; sheet.triangles.len()]);
        pin(&mut sheet, &source, 0, &mut pinned, &mut state);
        let at = |p: &DVec3| pinned.iter().filter(|&&v| sheet.points[v as usize] == *p).count();
        assert!(points[..12].iter().all(|p| at(p) == 1));
        assert_eq!((pinned.len(), state.len()), (12, sheet.triangles.len()));
        // Again there is nothing to do.
        let before = sheet.points.clone();
        pin(&mut sheet, &source, 0, &mut pinned, &mut state);
        assert!(sheet.points == before && pinned.len() == 12);
    }
}
