//! How many edges a feature needs to be kept by them: told before there is any.
//!
//! ```text
//!       ╭──────╮  feature        Edges are its chords. A place on it is kept where a chord is near and
//!     ╱╌╌╌╌╌╌╌╌╌╌╲               about parallel, as the validator will have it: too few of them cut bends off.
//!    ╱    chord   ╲
//! ```

use super::layout::Arc;
use super::sheet::Sheet;
use super::source::Source;
use super::ticks::{locate, place};
use super::validate::ALONG_DEG;
use glam::DVec3;

/// Places that are looked at on every edge of the sheet: the source's curve bends between its vertices.
const PLACES: usize = 8;
/// Chords lie along a feature within this share of the angle that counts: smoothing moves their ends.
const PARALLEL: f64 = 0.9;

/// Places on a feature, densely, with their stations.
struct Curve {
    stations: Vec<f64>,
    places: Vec<DVec3>,
}

/// The fewest chords that keep the feature of an arc within `near` of them, between its bends or evenly spaced: as many as it
/// has at least, or more. `None` where it takes more than `most`.
pub fn fewest(sheet: &Sheet, source: &Source, arc: &Arc, most: i64, near: f64) -> Option<i64> {
    let curve = Curve::new(sheet, source, arc, arc.curve?);
    (arc.least.max(1)..=most).find(|&n| curve.is_kept(&arc.bends.settled_ticks(n as usize), near))
}

impl Curve {
    fn new(sheet: &Sheet, source: &Source, arc: &Arc, number: u32) -> Self {
        let at = |k: usize| sheet.points[arc.vertices[k] as usize];
        let (mut stations, mut places) = (vec![0.0], vec![at(0)]);
        for k in 1..arc.vertices.len() {
            for j in 1..=PLACES {
                let share = j as f64 / PLACES as f64;
                stations.push(arc.stations[k - 1] + (arc.stations[k] - arc.stations[k - 1]) * share);
                let p = at(k - 1).lerp(at(k), share);
                places.push(source.on_curve(number, p).unwrap_or(p));
            }
        }
        Curve { stations, places }
    }

    /// Whether chords between ticks keep it, but for what is beyond the first and the last one.
    fn is_kept(&self, ticks: &[f64], near: f64) -> bool {
        let count = ticks.len() - 1;
        let ends: Vec<DVec3> = ticks.iter().map(|&t| self.at(t)).collect();
        let cos = (PARALLEL * ALONG_DEG).to_radians().cos();
        let keeps = |k: usize, p: DVec3, along: DVec3| {
            let chord = ends[k + 1] - ends[k];
            let way = chord.normalize_or_zero();
            let foot = ends[k] + way * (p - ends[k]).dot(way).clamp(0.0, chord.length());
            way.dot(along).abs() >= cos && foot.distance(p) <= near
        };
        self.stations.windows(2).zip(self.places.windows(2)).all(|(s, w)| {
            let (station, p) = (0.5 * (s[0] + s[1]), w[0].midpoint(w[1]));
            let along = (w[1] - w[0]).normalize_or_zero();
            let own = (place(ticks, station) as usize).min(count - 1);
            along == DVec3::ZERO
                || !(ticks[0]..=ticks[count]).contains(&station)
                || [own, own.saturating_sub(1), (own + 1).min(count - 1)].into_iter().any(|k| keeps(k, p, along))
        })
    }

    fn at(&self, station: f64) -> DVec3 {
        let (k, share) = locate(&self.stations, station);
        self.places[k].lerp(self.places[k + 1], share)
    }
}

#[cfg(test)]
mod tests {
    use super::super::draw::{draw, place};
    use super::super::layout::Layout;
    use super::super::validate::{NEAR, lost_features};
    use super::super::work::{Place, Work};
    use super::*;
    use crate::context::Context;
    use crate::geometry::features::FeatureOptions;
    use crate::mesh::{Polygons, SurfaceMesh};
    use std::f64::consts::TAU;

    /// A flat ellipse, three times as long as wide: its border bends far more at two places than between them.
    fn ellipse(sides: u32) -> SurfaceMesh {
        let mut points = vec![DVec3::ZERO];
        points.extend((0..sides).map(|k| {
            let (sin, cos) = (TAU * f64::from(k) / f64::from(sides)).sin_cos();
            DVec3::new(3.0 * cos, sin, 0.0)
        }));
        let mut faces = Polygons::new();
        (0..sides).for_each(|k| faces.push(&[0, 1 + k, 1 + (k + 1) % sides]));
        SurfaceMesh::new(points, faces).unwrap()
    }

    #[test]
    fn as_many_chords_as_it_says_keep_a_feature_and_fewer_do_not() {
        let context = Context::new();
        let source = Source::new(&ellipse(400), &FeatureOptions::default(), &context).unwrap();
        let near = 0.8 * NEAR * source.diagonal;
        let drawn = draw(&source, 0.3, 0.3, 35.0, &context).unwrap().unwrap();
        let sheet = &drawn.sheet;
        let is_fixed = |v| place(sheet, &drawn.coarse, v) == Some(Place::Fixed);
        let layout = Layout::new(sheet, f64::INFINITY, is_fixed).unwrap();
        let (mut bounded, mut chords) = (0, Work::default());
        for arc in layout.arcs.iter().filter(|arc| arc.curve.is_some()) {
            let least = fewest(sheet, &source, arc, 1000, near).unwrap();
            let number = arc.curve.unwrap();
            let curve = Curve::new(sheet, &source, arc, number);
            let first = chords.points.len() as u32;
            chords.points.extend((0..=least).map(|k| curve.at(k as f64 / least as f64)));
            chords.features.extend((0..least as u32).map(|k| ([first + k, first + k + 1], number)));
            if least > arc.least {
                bounded += 1;
                assert!(!curve.is_kept(&arc.bends.settled_ticks(least as usize - 1), near));
                assert_eq!(fewest(sheet, &source, arc, least - 1, near), None);
            }
        }
        assert!(lost_features(&chords, &source, NEAR).is_empty(), "the validator agrees");
        assert!(bounded > 0, "some feature needs more chords than its turns alone");
    }
}
