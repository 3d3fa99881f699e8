//! Vertices inside regions go where the surface bends.
//!
//! Quads on a coarse surface, or on a narrow fillet, cut off what sticks out between their vertices. A vertex that the planes
//! beneath its share of the quads go through (least squares, by a quadric) cuts off the least:
//!
//! ```text
//!      ╱╲  surface        ╱v╲
//!   v╱────╲v       →    ╱    ╲
//!  ╱        ╲         v╱      ╲v
//! ```
//!
//! Along the planes it goes to the mean of its neighbours.

use super::around::{Around, Moves, Ring};
use super::smooth::{GOOD, SHARES};
use super::source::Source;
use super::work::{Place, Work};
use crate::context::Context;
use crate::error::Result;
use crate::geometry::quadric::Quadric;
use glam::DVec3;

/// Rounds over all vertices.
const ROUNDS: usize = 8;
/// Where the surface beneath a quarter of a quad is looked at, along its sides: a little farther than to the middle, or what
/// is there would be nobody's.
const SAMPLES: [f64; 3] = [0.1, 0.33, 0.56];
/// A move may worsen quads down to this scaled Jacobian, worse than in smoothing, where more than this share of the diagonal
/// would be cut off.
const FAIR: f64 = 0.4;
const FAR: f64 = 0.0015;
/// Directions that the planes hold by less than this share of their weight are left to the neighbours: those across a ridge
/// of about ten degrees.
const STEADY: f64 = 0.01;
/// A vertex goes no farther than this share of its shortest edge at once, and comes no nearer to its neighbours than this
/// share of their mean distance, unless it was.
const REACH: f64 = 0.5;
const LEFT: f64 = 0.35;
/// It stays where it would move by a smaller share of the mean.
const LITTLE: f64 = 0.003;

/// Moves the vertices inside regions, those that are to be moved.
pub fn fit(
    work: &mut Work,
    around: &Around,
    source: &Source,
    is_wanted: impl Fn(u32) -> bool,
    context: &Context,
) -> Result<()> {
    let mut moves = Moves::new(work);
    for round in 0..ROUNDS {
        for v in 0..work.points.len() as u32 {
            context.check_every(v as usize)?;
            if let Place::Region(region) = work.place[v as usize]
                && is_wanted(v)
                && moves.any_since(round, 1, work, around, v)
                && let Some(to) = settled(work, around, source, v, region)
                && to.distance(work.points[v as usize]) > LITTLE * around.mean_edge(work, v)
            {
                moves.note(round, v, true);
                work.points[v as usize] = to;
            }
        }
    }
    Ok(())
}

/// Where the planes beneath a vertex meet, if the quads around stay good there.
fn settled(work: &Work, around: &Around, source: &Source, v: u32, region: u32) -> Option<DVec3> {
    let from = work.points[v as usize];
    let neighbours = || around.neighbours[v as usize].iter().map(|&w| work.points[w as usize]);
    let shortest = |p: DVec3| around.shortest_edge(work, v, p);
    let count = neighbours().count() as f64;
    let mean = neighbours().sum::<DVec3>() / count - from;
    let length = around.mean_edge(work, v);
    let step = beneath(work, around, source, v, region).optimum(mean, STEADY).clamp_length_max(REACH * shortest(from));
    let is_far = step.dot(around.up(work, v)).abs() > FAR * source.diagonal;
    let ring = Ring::new(work, around, v);
    let before = ring.now.min(if is_far { FAIR } else { GOOD });
    SHARES
        .into_iter()
        .map(|share| work.put_back(source, v, from + share * step))
        .find(|&to| shortest(to) >= shortest(from).min(LEFT * length) && ring.holds(to, before))
}

/// The planes beneath the quarters of the quads at a vertex, from where it is.
fn beneath(work: &Work, around: &Around, source: &Source, v: u32, region: u32) -> Quadric {
    let from = work.points[v as usize];
    let mut sum = Quadric::ZERO;
    for &q in &around.quads[v as usize] {
        let face = work.faces.face(q as usize);
        let first = face.iter().position(|&w| w == v).unwrap_or(0);
        let [o, a, c, b] = [0, 1, 2, 3].map(|k| work.points[face[(first + k) % 4] as usize]);
        for (s, t) in SAMPLES.into_iter().flat_map(|s| SAMPLES.map(|t| (s, t))) {
            let p = o.lerp(a, s).lerp(b.lerp(c, s), t);
            if let Some((p, triangle)) = source.on_region(region, p) {
                sum.add(&Quadric::plane(p - from, source.normal(triangle), 1.0));
            }
        }
    }
    sum
}
