//! Vertices on features go to where these bend.
//!
//! The features of a coarse input are chains of long straight edges. Quads of about the same length that do not know of them
//! cut every bend off:
//!
//! ```text
//!     w             v→w
//!    ╱ ╲            ╱ ╲
//!   ╱ ──v──  →     ╱   ╲
//!  v╱     ╲       v     ╲
//! ```
//!
//! The vertices of a curve and its bends are matched in their order (dynamic programming over both, least squares of the ways
//! that vertices go): every bend gets a vertex where there are enough. Matched vertices stay there; those between them share
//! what is left of the curve as before.

use super::around::{Around, worst};
use super::curve::{Curve, end_of, in_order};
use super::smooth::{POOR_SHAPE, jacobian};
use super::source::Source;
use super::validate::keeps_feature;
use super::work::{Place, Work};
use glam::DVec3;
use rustc_hash::FxHashMap;
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Degrees: curves are straight where they turn by less, because an edge cuts off hardly anything there.
pub const BEND_DEG: f64 = 8.0;
/// A share of the mean edge: a vertex goes no farther where there are more bends than vertices, a little more than half
/// because bends between two would be left out otherwise.
const BEND_REACH: f64 = 0.55;
/// A share of the mean edge: two bends that are nearer to each other do not both get a vertex, because the edge between
/// would be too short.
const BEND_SPACING: f64 = 0.35;
/// A scaled Jacobian: quads between features alone that become worse are taken back, because bends of two features side
/// by side may be out of step, and no smoothing mends that.
const RIGID_JACOBIAN: f64 = 0.2;
/// Lengths of a curve that a radian of its turn counts for, in the order in which they are tried: the first that keeps the curve
/// leaves its edges most alike.
const TURN_SHARES: [f64; 5] = [0.02, 0.05, 0.1, 0.2, 0.5];
/// A count: more pairs of a vertex and a bend are not looked at for one curve, because they would take a gigabyte.
const MOST_BEND_PAIRS: usize = 50_000_000;

/// The vertices of a curve of the mesh in their order, with their stations on the curve of the source.
struct Chain<'a> {
    number: u32,
    curve: &'a Curve,
    /// The first one again at the end of a closed chain.
    vertices: Vec<u32>,
    stations: Vec<f64>,
}

/// Moves vertices on curves to bends of the source, where the quads around allow it. Returns those that stay there, and where
/// they were free to move.
pub fn follow(work: &mut Work, around: &Around, source: &Source) -> Vec<(u32, Place)> {
    let mut held = Vec::new();
    let mut edges: BTreeMap<u32, Vec<[u32; 2]>> = BTreeMap::new();
    work.features.iter().for_each(|&(ends, curve)| edges.entry(curve).or_default().push(ends));
    for (number, edges) in edges {
        let Some(curve) = source.paths.get(number as usize) else { continue };
        let Some(chain) = Chain::new(work, &edges, number, curve) else {
            tracing::debug!(target: "carreau::quad", number, "vertices are in no order along the curve");
            continue;
        };
        let was_kept = chain.is_kept(work, source);
        let before: Vec<(DVec3, Place)> = chain.state(work);
        if curve.bends.is_empty() {
            let is_kept = was_kept || chain.share_turns(work, source);
            if !is_kept || chain.has_flattened(work, around, &before) {
                chain.restore(work, &before);
            }
            continue;
        }
        let on_bends = chain.go_to_bends(work);
        // More bends than vertices: all of them together may be nearer to the curve where they were.
        let is_worse = was_kept && !chain.is_kept(work, source);
        let is_flat = chain.has_flattened(work, around, &before);
        tracing::debug!(target: "carreau::quad", number, bends = curve.bends.len(), vertices = chain.vertices.len(), held = on_bends.len(), is_worse, is_flat, "bends");
        if is_worse || is_flat {
            chain.restore(work, &before);
        } else {
            held.extend(on_bends.into_iter().map(|v| (v, Place::Curve(number))));
        }
    }
    held
}

/// Vertices held at bends may move along their curves again where no smoothing has made the quads around good. Returns whether
/// there are any.
pub fn let_go(work: &mut Work, around: &Around, held: &[(u32, Place)]) -> bool {
    let is_poor = |&&(v, _): &&(u32, Place)| worst(work, around, v) < POOR_SHAPE;
    let poor: Vec<(u32, Place)> = held.iter().filter(is_poor).copied().collect();
    poor.iter().for_each(|&(v, place)| work.place[v as usize] = place);
    !poor.is_empty()
}

impl<'a> Chain<'a> {
    /// `None` where the vertices are in no order along the curve.
    fn new(work: &Work, edges: &[[u32; 2]], number: u32, curve: &'a Curve) -> Option<Self> {
        let end = end_of(edges, |v| work.place[v as usize] == Place::Fixed);
        let mut vertices = in_order(edges, end.unwrap_or(edges[0][0]));
        if vertices.len() != edges.len() + 1 || end.is_none() != curve.is_closed {
            return None;
        }
        let point = |v: u32| work.points[v as usize];
        let of = |vertices: &[u32]| -> Vec<f64> { vertices.iter().map(|&v| curve.station(point(v))).collect() };
        let mut stations = of(&vertices);
        let rises = |w: &[f64]| w[1] > w[0];
        if curve.is_closed {
            // Once around from the first one, whichever way it goes.
            let ups = stations.windows(2).filter(|w| rises(w)).count();
            if 2 * ups < stations.len() - 1 {
                vertices.reverse();
                stations.reverse();
            }
            let (first, length) = (stations[0], curve.length());
            let last = stations.len() - 1;
            stations[1..].iter_mut().for_each(|s| *s = first + (*s - first).rem_euclid(length));
            stations[last] = first + length;
        } else {
            let middle = stations.len() / 2;
            // Both ends of a curve from a corner to itself are at the same place.
            let is_backwards = stations[1] > stations[middle] || stations[middle] > stations[stations.len() - 2];
            if is_backwards {
                vertices.reverse();
                stations.reverse();
            }
            let last = stations.len() - 1;
            (stations[0], stations[last]) = (0.0, curve.length());
        }
        stations.windows(2).all(rises).then_some(Chain { number, curve, vertices, stations })
    }

    fn is_kept(&self, work: &Work, source: &Source) -> bool {
        let keeps = |w: &[u32]| keeps_feature(source, self.number, [w[0], w[1]].map(|v| work.points[v as usize]), 1.0);
        self.vertices.windows(2).all(keeps)
    }

    fn state(&self, work: &Work) -> Vec<(DVec3, Place)> {
        self.vertices.iter().map(|&v| (work.points[v as usize], work.place[v as usize])).collect()
    }

    fn restore(&self, work: &mut Work, state: &[(DVec3, Place)]) {
        for (&v, state) in self.vertices.iter().zip(state) {
            (work.points[v as usize], work.place[v as usize]) = *state;
        }
    }

    /// Whether a quad with no vertex that could still give way has become too flat.
    fn has_flattened(&self, work: &mut Work, around: &Around, before: &[(DVec3, Place)]) -> bool {
        let quads = self.vertices.iter().flat_map(|&v| around.quads[v as usize].iter().copied());
        let is_rigid =
            |&q: &u32| work.faces.face(q as usize).iter().all(|&v| !matches!(work.place[v as usize], Place::Region(_)));
        let flat: Vec<u32> = quads.filter(is_rigid).filter(|&q| jacobian(work, q) < RIGID_JACOBIAN).collect();
        if flat.is_empty() {
            return false;
        }
        let after = self.state(work);
        self.restore(work, before);
        let is_new = flat.iter().any(|&q| jacobian(work, q) > RIGID_JACOBIAN);
        self.restore(work, &after);
        is_new
    }

    /// Moves vertices along a curve that bends nowhere sharply to where it turns, as much as keeps it. Returns whether anything does.
    fn share_turns(&self, work: &mut Work, source: &Source) -> bool {
        let count = self.vertices.len() - 1;
        let from = if self.curve.is_closed { self.stations[0] } else { 0.0 };
        TURN_SHARES.iter().any(|share| {
            let stations = self.curve.shared(from, count, share * self.curve.length());
            for (&v, &station) in self.vertices[1..count].iter().zip(&stations[1..count]) {
                if let Place::Curve(_) = work.place[v as usize] {
                    work.points[v as usize] = self.curve.at(station);
                }
            }
            self.is_kept(work, source)
        })
    }

    /// Puts vertices to the bends that they are matched with, and those between them evenly. Returns those at bends.
    fn go_to_bends(&self, work: &mut Work) -> Vec<u32> {
        let mut anchors: Vec<(usize, f64)> = self.matched();
        let last = self.vertices.len() - 1;
        let on_bends: Vec<u32> = anchors.iter().map(|&(k, _)| self.vertices[k % last]).collect();
        match (self.curve.is_closed, anchors.first().copied()) {
            (_, None) => return Vec::new(),
            // Once around: the first anchor is the last one, too.
            (true, Some((k, station))) => anchors.push((k + last, station + self.curve.length())),
            (false, Some(_)) => {
                anchors.insert(0, (0, self.stations[0]));
                anchors.push((last, self.stations[last]));
            }
        }
        let own = |k: usize| match k > last {
            true => self.stations[k - last] + self.curve.length(),
            false => self.stations[k],
        };
        for pair in anchors.windows(2) {
            let [(i, from), (j, to)] = [pair[0], pair[1]];
            let (first, whole) = (own(i), own(j) - own(i));
            for k in i..j {
                let v = self.vertices[k % last] as usize;
                if let Place::Curve(_) = work.place[v] {
                    work.points[v] = self.curve.at(from + (to - from) * (own(k) - first) / whole);
                }
            }
        }
        on_bends.iter().for_each(|&v| work.place[v as usize] = Place::Fixed);
        on_bends
    }

    /// Vertices, by their place in the chain, with the stations of the bends that they go to, both in order.
    fn matched(&self) -> Vec<(usize, f64)> {
        let count = self.vertices.len() - 1;
        let mean = self.curve.length() / count as f64;
        let mut bends: Vec<f64> = Vec::new();
        for &bend in &self.curve.bends {
            if bends.last().is_none_or(|last| bend - last >= BEND_SPACING * mean) {
                bends.push(bend);
            }
        }
        if !self.curve.is_closed {
            // Near an end the vertex there is near enough.
            bends.retain(|&b| b >= BEND_SPACING * mean && self.curve.length() - b >= BEND_SPACING * mean);
            let inner: Vec<f64> = self.stations[1..count].to_vec();
            return alignment(&inner, &bends, BEND_REACH * mean).into_iter().map(|(i, j)| (i + 1, bends[j])).collect();
        }
        // Once around from the vertex and the bend that are nearest to each other.
        let first = self.stations[0];
        let length = self.curve.length();
        let round = |b: f64| first + (b - first).rem_euclid(length);
        bends.iter_mut().for_each(|b| *b = round(*b));
        bends.sort_by(f64::total_cmp);
        let off = |k: usize, j: usize| {
            let way = (self.stations[k] - bends[j]).abs();
            way.min(length - way)
        };
        let nearest = |j: usize| (0..count).map(move |k| (off(k, j), k, j)).min_by(|a, b| a.0.total_cmp(&b.0));
        let Some((_, k, j)) = (0..bends.len()).filter_map(nearest).min_by(|a, b| a.0.total_cmp(&b.0)) else {
            return Vec::new();
        };
        let vertex = |i: usize| self.stations[(k + i) % count] + if k + i >= count { length } else { 0.0 };
        let bend = |i: usize| bends[(j + i) % bends.len()] + if j + i >= bends.len() { length } else { 0.0 };
        // Both begin anew there, where the bend may be half around from the vertex's number.
        let shift = ((bend(0) - vertex(0)) / length).round() * length;
        let others: Vec<f64> = (1..count).map(vertex).collect();
        let other_bends: Vec<f64> = (1..bends.len()).map(|i| bend(i) - shift).collect();
        let mut matched = vec![(k, bend(0) - shift)];
        let rest = alignment(&others, &other_bends, BEND_REACH * mean);
        matched.extend(rest.into_iter().map(|(i, j)| (k + i + 1, other_bends[j])));
        matched
    }
}

/// Matches vertices and bends in their order: all bends, where there are enough vertices; else as many as are within reach. The
/// sum of the squares of the ways between them is least.
fn alignment(vertices: &[f64], bends: &[f64], reach: f64) -> Vec<(usize, usize)> {
    let (n, m) = (vertices.len(), bends.len());
    if n == 0 || m == 0 || n.saturating_mul(m) > MOST_BEND_PAIRS {
        return Vec::new();
    }
    // Leaving a bend out costs more than any way, or as much as the farthest one.
    let left_out = match n >= m {
        true => {
            let all = vertices.iter().chain(bends);
            let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &s| (l.min(s), h.max(s)));
            m as f64 * (high - low + reach).powi(2)
        }
        false => reach * reach,
    };
    // least[j]: the least cost of the first vertices and the first j bends; the step that led there.
    let mut least: Vec<f64> = (0..=m).map(|j| j as f64 * left_out).collect();
    let mut steps = vec![Step::NoBend; (n + 1) * (m + 1)];
    for i in 1..=n {
        let mut diagonal = least[0];
        steps[i * (m + 1)] = Step::NoVertex;
        for j in 1..=m {
            let matched = diagonal + (vertices[i - 1] - bends[j - 1]).powi(2);
            diagonal = least[j];
            let (mut best, mut step) = (matched, Step::Match);
            if least[j] < best {
                (best, step) = (least[j], Step::NoVertex);
            }
            if least[j - 1] + left_out < best {
                (best, step) = (least[j - 1] + left_out, Step::NoBend);
            }
            least[j] = best;
            steps[i * (m + 1) + j] = step;
        }
    }
    let (mut i, mut j) = (n, m);
    let mut pairs = Vec::new();
    while i > 0 || j > 0 {
        match steps[i * (m + 1) + j] {
            Step::Match => {
                (i, j) = (i - 1, j - 1);
                pairs.push((i, j));
            }
            Step::NoVertex => i -= 1,
            Step::NoBend => j -= 1,
        }
    }
    pairs.reverse();
    pairs
}

#[derive(Clone, Copy)]
enum Step {
    Match,
    NoVertex,
    NoBend,
}

/// The points inside of every curve where it bends by more than an angle; `edges` by their ends, with the curve of each.
pub fn bends(points: &[DVec3], edges: &[[u32; 2]], curve: &[u32], least_deg: f64) -> FxHashMap<u32, Vec<DVec3>> {
    let point = |v: u32| points[v as usize];
    let mut arms: FxHashMap<(u32, u32), Vec<u32>> = FxHashMap::default();
    let mut order = Vec::new();
    for (&[a, b], &curve) in edges.iter().zip(curve) {
        for (v, w) in [(a, b), (b, a)] {
            let list = arms.entry((curve, v)).or_default();
            if list.is_empty() {
                order.push((curve, v));
            }
            list.push(w);
        }
    }
    let straight = PI - least_deg.to_radians();
    let mut bends: FxHashMap<u32, Vec<DVec3>> = FxHashMap::default();
    for (curve, v) in order {
        if let [a, b] = arms[&(curve, v)].as_slice()
            && (point(*a) - point(v)).angle_between(point(*b) - point(v)) < straight
        {
            bends.entry(curve).or_default().push(point(v));
        }
    }
    bends
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn all_bends_have_a_vertex_in_order_where_there_are_enough(
            mut vertices in prop::collection::vec(0.0..10.0f64, 1..40),
            mut bends in prop::collection::vec(0.0..10.0f64, 1..40),
        ) {
            vertices.sort_by(f64::total_cmp);
            bends.sort_by(f64::total_cmp);
            let pairs = alignment(&vertices, &bends, 0.3);
            prop_assert!(pairs.windows(2).all(|w| w[0].0 < w[1].0 && w[0].1 < w[1].1));
            if vertices.len() >= bends.len() {
                prop_assert_eq!(pairs.len(), bends.len());
            } else {
                prop_assert!(pairs.iter().all(|&(i, j)| (vertices[i] - bends[j]).abs() <= 0.3 + 1e-12));
            }
        }

        #[test]
        fn no_other_matching_in_order_is_shorter(
            mut vertices in prop::collection::vec(0.0..10.0f64, 4..7),
            mut bends in prop::collection::vec(0.0..10.0f64, 3),
        ) {
            vertices.sort_by(f64::total_cmp);
            bends.sort_by(f64::total_cmp);
            let cost = |pairs: &[usize]| -> f64 { pairs.iter().zip(&bends).map(|(&i, b)| (vertices[i] - b).powi(2)).sum() };
            let found: Vec<usize> = alignment(&vertices, &bends, 0.3).into_iter().map(|p| p.0).collect();
            let n = vertices.len();
            let all = (0..n).flat_map(|a| (a + 1..n).flat_map(move |b| (b + 1..n).map(move |c| [a, b, c])));
            let least = all.map(|triple| cost(&triple)).fold(f64::INFINITY, f64::min);
            prop_assert!((cost(&found) - least).abs() < 1e-9);
        }
    }
}
