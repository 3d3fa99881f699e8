//! Where the vertices along an arc go: to the bends of its feature, if there are enough of them, and evenly between.
//!
//! ```text
//!          3───4            The four bends of this feature have a vertex each, its five pieces an edge each; the two edges
//!        ╱       ╲          that are left over are dealt to the longest pieces, one after the other.
//!  0─1─2           5─6─7
//! ```

use super::layout::Arc;
use super::sheet::Sheet;
use super::source::Source;
use crate::geometry::normals::unit;
use glam::DVec3;
use std::collections::BTreeMap;

/// A bend this near to the end of an arc, as a share of the length of quads, is for the vertex there: it goes there by itself.
const AT_END: f64 = 0.35;

/// The bends inside an arc, in order, by their stations.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Bends {
    pub inside: Vec<f64>,
    /// Those that the vertices at the ends go to.
    pub at_ends: [Option<f64>; 2],
}

impl Bends {
    /// Those at stations in order; a free end of the arc takes the one that is this near to it.
    fn new(mut stations: Vec<f64>, near: f64, [first, last]: [bool; 2]) -> Self {
        let mut at_ends = [None; 2];
        if last && stations.last().is_some_and(|s| 1.0 - s < near) {
            at_ends[1] = stations.pop();
        }
        if first && stations.first().is_some_and(|&s| s < near) {
            at_ends[0] = Some(stations.remove(0));
        }
        Bends { inside: stations, at_ends }
    }

    /// Where `count` edges begin and end, by stations.
    pub fn ticks(&self, count: usize) -> Vec<f64> {
        if count <= self.inside.len() {
            return (0..=count).map(|k| k as f64 / count as f64).collect();
        }
        let ends: Vec<f64> = [0.0].iter().chain(&self.inside).chain(&[1.0]).copied().collect();
        let mut pieces: Vec<(f64, usize)> = ends.windows(2).map(|w| (w[1] - w[0], 1)).collect();
        for _ in pieces.len()..count {
            let longest = (0..pieces.len()).max_by(|&a, &b| {
                let [a, b] = [a, b].map(|k| pieces[k].0 / pieces[k].1 as f64);
                a.total_cmp(&b)
            });
            longest.into_iter().for_each(|k| pieces[k].1 += 1);
        }
        let mut ticks = vec![0.0];
        for ((length, edges), start) in pieces.into_iter().zip(ends) {
            ticks.extend((1..=edges).map(|k| start + length * k as f64 / edges as f64));
        }
        ticks
    }

    /// The same where the ends have gone to their bends.
    pub fn settled_ticks(&self, count: usize) -> Vec<f64> {
        let mut ticks = self.ticks(count);
        ticks[0] = self.at_ends[0].unwrap_or(0.0);
        ticks[count] = self.at_ends[1].unwrap_or(1.0);
        ticks
    }
}

/// The last of stations in order that is before another one, and the share of the way from there to the next.
pub fn locate(stations: &[f64], station: f64) -> (usize, f64) {
    let k = stations.partition_point(|&s| s < station).clamp(1, stations.len() - 1);
    let [from, to] = [stations[k - 1], stations[k]];
    (k - 1, if to > from { ((station - from) / (to - from)).clamp(0.0, 1.0) } else { 0.0 })
}

/// Where a station is among ticks, in edges from the first one.
pub fn place(ticks: &[f64], station: f64) -> f64 {
    let (k, share) = locate(ticks, station);
    k as f64 + share
}

/// Finds the bends inside arcs, for quads of a length. A vertex that `is_fixed` goes nowhere.
pub fn find_bends(arcs: &mut [Arc], sheet: &Sheet, source: &Source, length: f64, is_fixed: impl Fn(u32) -> bool) {
    let mut stations: Vec<Vec<f64>> = vec![Vec::new(); arcs.len()];
    let mut of_curve: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for (a, curve) in arcs.iter().enumerate().filter_map(|(a, arc)| Some((a, arc.curve?))) {
        of_curve.entry(curve).or_default().push(a);
    }
    for (curve, own) in of_curve {
        for &bend in source.bends.get(&curve).into_iter().flatten() {
            let nearest = own.iter().map(|&a| (nearest_station(&arcs[a], sheet, bend), a));
            if let Some(((_, station), a)) = nearest.min_by(|a, b| a.0.0.total_cmp(&b.0.0)) {
                stations[a].push(station);
            }
        }
    }
    for (arc, mut stations) in arcs.iter_mut().zip(stations) {
        stations.sort_by(f64::total_cmp);
        stations.dedup();
        stations.retain(|&s| s > 0.0 && s < 1.0);
        let is_free = [0, arc.vertices.len() - 1].map(|k| !is_fixed(arc.vertices[k]));
        arc.bends = Bends::new(stations, AT_END * length / arc.length, is_free);
    }
}

/// How far an arc is from a place, and the station where it is nearest.
fn nearest_station(arc: &Arc, sheet: &Sheet, p: DVec3) -> (f64, f64) {
    let mut nearest = (f64::INFINITY, 0.0);
    for (w, s) in arc.vertices.windows(2).zip(arc.stations.windows(2)) {
        let [a, b] = [w[0], w[1]].map(|v| sheet.points[v as usize]);
        let share = ((p - a).dot(unit(b - a)) / a.distance(b).max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        let off = a.lerp(b, share).distance(p);
        if off < nearest.0 {
            nearest = (off, s[0] + (s[1] - s[0]) * share);
        }
    }
    nearest
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn inside(stations: &[f64]) -> Bends {
        Bends { inside: stations.to_vec(), at_ends: [None; 2] }
    }

    #[test]
    fn bends_have_ticks_where_there_are_enough() {
        assert_eq!(inside(&[]).ticks(4), [0.0, 0.25, 0.5, 0.75, 1.0]);
        assert_eq!(inside(&[0.2]).ticks(2), [0.0, 0.2, 1.0]);
        assert_eq!(inside(&[0.25]).ticks(3), [0.0, 0.25, 0.625, 1.0]);
        // More bends than ticks: even.
        assert_eq!(inside(&[0.1, 0.2]).ticks(2), [0.0, 0.5, 1.0]);
    }

    proptest! {
        #[test]
        fn ticks_are_in_order_and_places_are_their_numbers(mut stations in prop::collection::vec(0.01..0.99, 0..6), extra in 1usize..9) {
            stations.sort_by(f64::total_cmp);
            stations.dedup();
            let count = stations.len() + extra;
            let ticks = inside(&stations).ticks(count);
            prop_assert_eq!(ticks.len(), count + 1);
            prop_assert!(ticks.windows(2).all(|w| w[0] < w[1]));
            for s in &stations {
                prop_assert!(ticks.iter().any(|t| (t - s).abs() < 1e-12));
            }
            for (k, &t) in ticks.iter().enumerate() {
                prop_assert!((place(&ticks, t) - k as f64).abs() < 1e-9);
            }
        }
    }
}
