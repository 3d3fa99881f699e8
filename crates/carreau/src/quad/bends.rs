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
//! The vertex nearest to a bend moves there and stays; those beside it share what is left of the curve as before: where it
//! turns more they are nearer to each other.

use super::around::{Around, Ring, worst};
use super::source::Source;
use super::validate::keeps_feature;
use super::work::{Place, Work};
use glam::DVec3;
use rustc_hash::FxHashMap;
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Curves are straight where they turn by less, in degrees.
pub const BEND_DEG: f64 = 8.0;
/// A vertex goes no farther than this share of the shorter edge beside it: a little more than half, or bends between two would
/// be left out.
const REACH: f64 = 0.55;
/// What has to be left of the edges beside it: two bends next to each other do not both get a vertex.
const LEFT: f64 = 0.35;
/// Moves that leave a quad worse than this scaled Jacobian are taken back: bends of two features side by side may be out of
/// step. Both have to be there before it shows.
const FAIR: f64 = 0.2;
/// Those that have a worse quad when all has been smoothed are let go.
const TIGHT: f64 = 0.6;
/// Rounds in which the vertices between bends share what is left of the curve as they did before.
const EVEN: usize = 8;

/// A vertex that has moved, with where and how it was.
struct Moved {
    vertex: u32,
    from: DVec3,
    place: Place,
    worst: f64,
}

/// A curve with its edges and the vertices inside, which have two neighbours there, in their order.
#[derive(Default)]
struct Strand {
    curve: u32,
    edges: Vec<[u32; 2]>,
    beads: Vec<u32>,
}

/// Moves vertices on curves to bends of the source, where the quads around allow it. Returns those that stay there, and where
/// they were free to move.
pub fn follow(work: &mut Work, around: &Around, source: &Source) -> Vec<(u32, Place)> {
    let mut moved = Vec::new();
    for strand in strands(work, around) {
        let Some(bends) = source.bends.get(&strand.curve) else { continue };
        let was_kept = strand.is_kept(work, source);
        let (before, shares) = (strand.state(work), strand.shares(work, around));
        let on_bends = strand.go_to_bends(work, around, bends);
        strand.spread(work, around, source, &shares);
        // More bends than vertices: all of them together may be nearer to the curve where they were.
        if was_kept && !strand.is_kept(work, source) {
            strand.restore(work, before);
        } else {
            moved.extend(on_bends);
        }
    }
    let mut held = Vec::new();
    for Moved { vertex, from, place, worst: before } in moved {
        let ring = Ring::new(work, around, vertex);
        if ring.now < before.min(FAIR) && ring.worst(from) > ring.now {
            work.points[vertex as usize] = from;
            work.place[vertex as usize] = place;
        } else {
            held.push((vertex, place));
        }
    }
    held
}

/// Vertices held at bends may move along their curves again where no smoothing has made the quads around good. Returns whether
/// there are any.
pub fn let_go(work: &mut Work, around: &Around, held: &[(u32, Place)]) -> bool {
    let is_poor = |&&(v, _): &&(u32, Place)| worst(work, around, v) < TIGHT;
    let poor: Vec<(u32, Place)> = held.iter().filter(is_poor).copied().collect();
    poor.iter().for_each(|&(v, place)| work.place[v as usize] = place);
    !poor.is_empty()
}

impl Strand {
    /// Whether its edges keep the curve.
    fn is_kept(&self, work: &Work, source: &Source) -> bool {
        let keeps = |ends: &[u32; 2]| keeps_feature(source, self.curve, ends.map(|v| work.points[v as usize]), 1.0);
        self.edges.iter().all(keeps)
    }

    fn state(&self, work: &Work) -> Vec<(DVec3, Place)> {
        self.beads.iter().map(|&v| (work.points[v as usize], work.place[v as usize])).collect()
    }

    fn restore(&self, work: &mut Work, state: Vec<(DVec3, Place)>) {
        for (&v, state) in self.beads.iter().zip(state) {
            (work.points[v as usize], work.place[v as usize]) = state;
        }
    }

    /// Where every bead is between its neighbours.
    fn shares(&self, work: &Work, around: &Around) -> Vec<f64> {
        let share = |&v: &u32| {
            let [a, b] = ends(work, around, v).map(|p| p.distance(work.points[v as usize]));
            if a + b > 0.0 { a / (a + b) } else { 0.5 }
        };
        self.beads.iter().map(share).collect()
    }

    /// Puts the nearest beads to the bends, as far as they reach.
    fn go_to_bends(&self, work: &mut Work, around: &Around, bends: &[DVec3]) -> Vec<Moved> {
        let point = |v: u32| work.points[v as usize];
        let edges: Vec<f64> = self.beads.iter().map(|&v| around.shortest_edge(work, v, point(v))).collect();
        let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
        for (k, &v) in self.beads.iter().enumerate() {
            let near = bends.iter().enumerate().map(|(b, p)| (p.distance(point(v)), k, b));
            pairs.extend(near.filter(|pair| pair.0 <= REACH * edges[k]));
        }
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        let mut taken = vec![false; bends.len()];
        let mut moved = Vec::new();
        for (_, k, b) in pairs {
            let (vertex, to) = (self.beads[k], bends[b]);
            let v = vertex as usize;
            let is_free = !taken[b] && work.place[v] != Place::Fixed;
            if is_free && around.shortest_edge(work, vertex, to) >= LEFT * edges[k] {
                let (from, place) = (work.points[v], work.place[v]);
                moved.push(Moved { vertex, from, place, worst: worst(work, around, vertex) });
                taken[b] = true;
                work.points[v] = to;
                work.place[v] = Place::Fixed;
            }
        }
        moved
    }

    /// Lets the beads between bends share what is left of the curve.
    fn spread(&self, work: &mut Work, around: &Around, source: &Source, shares: &[f64]) {
        for _ in 0..EVEN {
            for (&v, &share) in self.beads.iter().zip(shares) {
                let [a, b] = ends(work, around, v);
                // What is held at a bend stays.
                work.points[v as usize] = work.put_back(source, v, a.lerp(b, share));
            }
        }
    }
}

/// The neighbours of a bead.
fn ends(work: &Work, around: &Around, v: u32) -> [DVec3; 2] {
    [0, 1].map(|k| work.points[around.neighbours[v as usize][k] as usize])
}

/// All curves of the mesh, by number.
fn strands(work: &Work, around: &Around) -> impl Iterator<Item = Strand> + use<> {
    let mut of_curve: BTreeMap<u32, Strand> = BTreeMap::new();
    for &(ends, curve) in &work.features {
        let strand = of_curve.entry(curve).or_default();
        strand.curve = curve;
        strand.edges.push(ends);
    }
    for (v, place) in (0u32..).zip(&work.place) {
        if let Place::Curve(curve) = place
            && around.neighbours[v as usize].len() == 2
            && let Some(strand) = of_curve.get_mut(curve)
        {
            strand.beads.push(v);
        }
    }
    of_curve.into_values()
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
