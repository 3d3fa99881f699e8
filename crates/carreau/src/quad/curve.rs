//! Feature curves in the order of their length: where their vertices are, where they bend, and how many edges they need.
//!
//! ```text
//!       ╭──────╮  curve          Edges are its chords. A place on it is kept where a chord is near and
//!     ╱╌╌╌╌╌╌╌╌╌╌╲               about parallel, as the validator will have it: too few of them cut bends off.
//!    ╱    chord   ╲
//! ```

use super::source::{Source, bits};
use super::validate::{FEATURE_ALONG_DEG, FEATURE_NEAR};
use glam::DVec3;
use rustc_hash::FxHashSet;
use std::collections::BTreeMap;

/// A share of [`FEATURE_NEAR`]: chords keep a place that is so near, because smoothing moves their ends.
const CHORD_NEAR: f64 = 0.8;
/// A share of [`FEATURE_ALONG_DEG`]: chords keep a place that is so parallel, because smoothing turns them.
const CHORD_PARALLEL: f64 = 0.9;
/// Radians: a curve needs a chord for each turn by so much, because what a chord keeps of a bend is within half of it
/// to either side.
const CHORD_TURN: f64 = 2.0 * CHORD_PARALLEL * FEATURE_ALONG_DEG / 180.0 * std::f64::consts::PI;

/// A curve of the source.
pub struct Curve {
    points: Vec<DVec3>,
    /// The length of the curve up to every point.
    stations: Vec<f64>,
    /// Where it bends, by stations in order; a closed curve begins at a bend if it has one.
    pub bends: Vec<f64>,
    /// It ends where it begins, in no corner.
    pub is_closed: bool,
}

/// All curves, by number.
pub fn paths(source: &Source) -> Vec<Curve> {
    let mut edges: Vec<Vec<[u32; 2]>> = Vec::new();
    for (&ends, &curve) in source.edges.iter().zip(&source.curve) {
        if edges.len() <= curve as usize {
            edges.resize(curve as usize + 1, Vec::new());
        }
        edges[curve as usize].push(ends);
    }
    edges.iter().zip(0u32..).map(|(edges, number)| Curve::new(source, edges, number)).collect()
}

/// A vertex where a path through edges ends: it has one of them, or is said to be an end.
pub fn end_of(edges: &[[u32; 2]], is_end: impl Fn(u32) -> bool) -> Option<u32> {
    let mut arms: BTreeMap<u32, usize> = BTreeMap::new();
    edges.iter().flatten().for_each(|&v| *arms.entry(v).or_default() += 1);
    arms.into_iter().find(|&(v, n)| n == 1 || is_end(v)).map(|(v, _)| v)
}

/// Vertices in the order of a path through edges, from `first`; the first one comes again at the end of a closed path.
pub fn in_order(edges: &[[u32; 2]], first: u32) -> Vec<u32> {
    let mut at: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (e, ends) in edges.iter().enumerate() {
        ends.iter().for_each(|&v| at.entry(v).or_default().push(e));
    }
    let (mut path, mut is_used) = (vec![first], vec![false; edges.len()]);
    let mut last = first;
    while let Some(&e) = at.get(&last).and_then(|list| list.iter().find(|&&e| !is_used[e])) {
        is_used[e] = true;
        let [a, b] = edges[e];
        last = if a == last { b } else { a };
        path.push(last);
    }
    path
}

impl Curve {
    fn new(source: &Source, edges: &[[u32; 2]], number: u32) -> Self {
        let point = |v: u32| source.surface.mesh.points()[v as usize];
        let end = end_of(edges, |v| source.is_corner(point(v)));
        let of_curve: FxHashSet<[u64; 3]> = source.bends.get(&number).into_iter().flatten().map(|&p| bits(p)).collect();
        let is_bend = |p: DVec3| of_curve.contains(&bits(p));
        let least_bend = || edges.iter().flatten().copied().filter(|&v| is_bend(point(v))).min();
        let first = end.or_else(least_bend).unwrap_or(edges[0][0]);
        let points: Vec<DVec3> = in_order(edges, first).into_iter().map(point).collect();
        let mut stations = vec![0.0];
        for k in 1..points.len() {
            stations.push(stations[k - 1] + points[k].distance(points[k - 1]));
        }
        let is_closed = end.is_none();
        let inner = usize::from(!is_closed)..points.len() - 1;
        let bends = inner.filter(|&k| is_bend(points[k])).map(|k| stations[k]).collect();
        Curve { points, stations, bends, is_closed }
    }

    /// The points where it ends, in no order; none where it is closed.
    pub fn ends(&self) -> Vec<DVec3> {
        match self.is_closed {
            true => Vec::new(),
            false => vec![self.points[0], self.points[self.points.len() - 1]],
        }
    }

    pub fn length(&self) -> f64 {
        self.stations[self.stations.len() - 1]
    }

    /// Stations, from one on, that share the length of the curve and its turn evenly; a length counts for so much of a turn, in
    /// radians. A closed curve is once around.
    pub fn shared(&self, from: f64, count: usize, of_turn: f64) -> Vec<f64> {
        let last = self.points.len() - 1;
        let turn = |k: usize| {
            let [before, after] = match k % last {
                0 if self.is_closed => [last - 1, 1],
                0 => return 0.0,
                k => [k - 1, k + 1],
            };
            let at = self.points[k % last];
            let ways = [at - self.points[before], self.points[after] - at].map(DVec3::normalize_or_zero);
            ways[0].dot(ways[1]).clamp(-1.0, 1.0).acos()
        };
        // What is shared up to every point: half of a turn is before it, half behind.
        let mut sums = vec![0.0];
        for k in 1..=last {
            let length = self.stations[k] - self.stations[k - 1];
            sums.push(sums[k - 1] + length + of_turn * 0.5 * (turn(k - 1) + turn(k)));
        }
        let (length, whole) = (self.length(), sums[last]);
        let between = |x: f64, of: &[f64], is: &[f64]| {
            let k = of.partition_point(|&s| s < x).clamp(1, last);
            let share = if of[k] > of[k - 1] { ((x - of[k - 1]) / (of[k] - of[k - 1])).clamp(0.0, 1.0) } else { 0.0 };
            is[k - 1] + share * (is[k] - is[k - 1])
        };
        let first = between(from.rem_euclid(length), &self.stations, &sums);
        let at = |k: usize| {
            let sum = first + whole * k as f64 / count as f64;
            let rounds = if self.is_closed { (sum / whole).floor() } else { 0.0 };
            between(sum - rounds * whole, &sums, &self.stations) + rounds * length
        };
        (0..=count).map(at).collect()
    }

    /// The point at a station; one beyond the ends of a closed curve comes round again.
    pub fn at(&self, station: f64) -> DVec3 {
        let station = if self.is_closed { station.rem_euclid(self.length()) } else { station };
        let k = self.stations.partition_point(|&s| s < station).clamp(1, self.stations.len() - 1);
        let [from, to] = [self.stations[k - 1], self.stations[k]];
        let share = if to > from { ((station - from) / (to - from)).clamp(0.0, 1.0) } else { 0.0 };
        self.points[k - 1].lerp(self.points[k], share)
    }

    /// The station of the nearest place.
    pub fn station(&self, p: DVec3) -> f64 {
        let mut nearest = (f64::INFINITY, 0.0);
        for (w, s) in self.points.windows(2).zip(self.stations.windows(2)) {
            let along = w[1] - w[0];
            let share = ((p - w[0]).dot(along) / along.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
            let off = w[0].lerp(w[1], share).distance_squared(p);
            if off < nearest.0 {
                nearest = (off, s[0] + (s[1] - s[0]) * share);
            }
        }
        nearest.1
    }

    /// The fewest edges that keep it, up to `most`, from bend to bend or evenly spaced where there are more bends than edges.
    pub fn fewest(&self, source: &Source, most: usize) -> Option<usize> {
        let turn = |w: &[DVec3]| (w[1] - w[0]).angle_between(w[2] - w[1]);
        let turned: f64 = self.points.windows(3).map(turn).filter(|a| a.is_finite()).sum();
        let least = ((turned / CHORD_TURN).floor() as usize).max(1);
        (least..=most).find(|&count| self.is_kept(&self.ticks(count), CHORD_NEAR * FEATURE_NEAR * source.diagonal))
    }

    /// Where so many edges begin and end: at bends, if there are enough, and evenly between them.
    fn ticks(&self, count: usize) -> Vec<f64> {
        let length = self.length();
        let mut fixed = vec![0.0];
        fixed.extend(self.bends.iter().copied().filter(|&b| b > 0.0));
        fixed.push(length);
        if count + 1 < fixed.len() {
            return (0..=count).map(|k| length * k as f64 / count as f64).collect();
        }
        let mut pieces: Vec<(f64, usize)> = fixed.windows(2).map(|w| (w[1] - w[0], 1)).collect();
        for _ in pieces.len()..count {
            let longest = (0..pieces.len()).max_by(|&a, &b| {
                let [a, b] = [a, b].map(|k| pieces[k].0 / pieces[k].1 as f64);
                a.total_cmp(&b)
            });
            longest.into_iter().for_each(|k| pieces[k].1 += 1);
        }
        let mut ticks = vec![0.0];
        for ((length, edges), start) in pieces.into_iter().zip(fixed) {
            ticks.extend((1..=edges).map(|k| start + length * k as f64 / edges as f64));
        }
        ticks
    }

    /// Whether chords between ticks keep it: every piece that is of one edge and of one chord.
    fn is_kept(&self, ticks: &[f64], near: f64) -> bool {
        let cos = (CHORD_PARALLEL * FEATURE_ALONG_DEG).to_radians().cos();
        let ends: Vec<DVec3> = ticks.iter().map(|&t| self.at(t)).collect();
        let keeps = |k: usize, p: DVec3, along: DVec3| {
            let chord = ends[k + 1] - ends[k];
            let way = chord.normalize_or_zero();
            let foot = ends[k] + way * (p - ends[k]).dot(way).clamp(0.0, chord.length());
            way.dot(along).abs() >= cos && foot.distance(p) <= near
        };
        let (mut edge, mut own, mut from) = (0, 0, 0.0);
        while edge + 1 < self.points.len() {
            let is_last = own + 2 == ticks.len();
            let to = if is_last { self.stations[edge + 1] } else { self.stations[edge + 1].min(ticks[own + 1]) };
            let along = (self.points[edge + 1] - self.points[edge]).normalize_or_zero();
            let ends_of_piece = [from, to].map(|station| self.at(station));
            let near_by = [own, own.saturating_sub(1), (own + 1).min(ticks.len() - 2)];
            let is_kept = || ends_of_piece.iter().all(|&p| near_by.into_iter().any(|k| keeps(k, p, along)));
            if to > from && along != DVec3::ZERO && !is_kept() {
                return false;
            }
            from = to;
            if to >= self.stations[edge + 1] {
                edge += 1;
            }
            if !is_last && to >= ticks[own + 1] {
                own += 1;
            }
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::super::validate::recall;
    use super::super::work::Work;
    use super::*;
    use crate::context::Context;
    use crate::geometry::features::FeatureOptions;
    use crate::mesh::{Polygons, SurfaceMesh};
    use std::f64::consts::TAU;

    /// A flat ellipse, three times as long as wide: its border bends far more at two places than between them.
    fn ellipse(sides: u32) -> Source {
        let mut points = vec![DVec3::ZERO];
        points.extend((0..sides).map(|k| {
            let (sin, cos) = (TAU * f64::from(k) / f64::from(sides)).sin_cos();
            DVec3::new(3.0 * cos, sin, 0.0)
        }));
        let mut faces = Polygons::new();
        (0..sides).for_each(|k| faces.push(&[0, 1 + k, 1 + (k + 1) % sides]));
        let mesh = SurfaceMesh::new(points, faces).unwrap();
        Source::new(&mesh, &FeatureOptions::default(), &Context::new()).unwrap()
    }

    #[test]
    fn as_many_edges_as_it_says_keep_a_curve_and_fewer_do_not() {
        for sides in [14, 40, 400] {
            let source = ellipse(sides);
            let mut chords = Work::default();
            for (number, curve) in (0u32..).zip(paths(&source)) {
                let least = curve.fewest(&source, 1000).unwrap();
                assert_eq!(curve.fewest(&source, least - 1), None);
                assert!(
                    least <= 2 * curve.points.len(),
                    "its own edges keep it, but not all of its bends are known as such"
                );
                let first = chords.points.len() as u32;
                chords.points.extend(curve.ticks(least).into_iter().map(|t| curve.at(t)));
                chords.features.extend((first..first + least as u32).map(|k| ([k, k + 1], number)));
            }
            assert!(recall(&chords, &source).0 > 0.9995, "the validator agrees");
        }
    }

    #[test]
    fn places_share_length_and_turn() {
        let source = ellipse(200);
        let [curve] = &paths(&source)[..] else { panic!("one border") };
        let length = curve.length();
        for (from, of_turn) in [(0.0, 0.0), (0.3 * length, 0.0), (0.0, length), (0.7 * length, 0.1 * length)] {
            let stations = curve.shared(from, 20, of_turn);
            assert!((stations[0] - from).abs() < 1e-9 && (stations[20] - from - length).abs() < 1e-9 * length);
            assert!(stations.windows(2).all(|w| w[0] < w[1]));
            let edges: Vec<f64> = stations.windows(2).map(|w| w[1] - w[0]).collect();
            let spread = edges.iter().fold(0.0, |m: f64, &e| m.max(e)) / edges.iter().fold(length, |m, &e| m.min(e));
            assert!(if of_turn == 0.0 { spread < 1.0 + 1e-6 } else { spread > 1.2 }, "{spread}");
        }
    }

    #[test]
    fn stations_are_where_points_are() {
        let source = ellipse(200);
        let [curve] = &paths(&source)[..] else { panic!("one border") };
        assert!(curve.is_closed);
        for k in 0..50 {
            let station = curve.length() * f64::from(k) / 50.0;
            assert!((curve.station(curve.at(station)) - station).abs() < 1e-9 * curve.length());
        }
        assert!(curve.bends.windows(2).all(|w| w[0] < w[1]));
        assert!(curve.bends.iter().all(|&b| source.bends[&0].contains(&curve.at(b))));
    }
}
