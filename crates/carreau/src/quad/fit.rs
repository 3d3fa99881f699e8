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
use super::smooth::{GOOD_SHAPE, WAY_SHARES};
use super::source::Source;
use super::work::{Place, Work};
use crate::context::Context;
use crate::error::Result;
use crate::geometry::quadric::Quadric;
use glam::DVec3;

/// A count: rounds over all vertices, because they go to the mean of neighbours that move as well.
const FIT_ROUNDS: usize = 8;
/// Shares of the sides of a quad from a vertex: where the surface beneath is looked at, a little farther than to the
/// middle because what is there would be nobody's otherwise.
const FIT_PLACES: [f64; 3] = [0.1, 0.33, 0.56];
/// A scaled Jacobian over what it can be: a move may worsen quads down to it, further than in smoothing because much
/// would be cut off otherwise.
const FITTED_SHAPE: f64 = 0.4;
/// A share of the diagonal: shapes may become as poor as [`FITTED_SHAPE`] only where more would be cut off, because
/// less is not worth it.
const FITTED_GAP: f64 = 0.0015;
/// A share of the planes' weight: directions that hold less are left to the neighbours, because across a ridge of about
/// ten degrees planes hold no more.
const STEADY_WEIGHT: f64 = 0.01;
/// A share of its shortest edge: a vertex goes no farther at once, because quads around would be turned over.
const FIT_REACH: f64 = 0.5;
/// A share of the mean edge: a vertex comes no nearer to its neighbours, unless it was, because ridges draw vertices
/// together.
const FIT_EDGE: f64 = 0.35;
/// A share of the mean edge: a vertex stays where it would move by less, because its neighbours need not be looked at
/// then.
const LITTLE_FIT: f64 = 0.003;

/// Moves the vertices inside regions, those that are to be moved.
pub fn fit(
    work: &mut Work,
    around: &Around,
    source: &Source,
    is_wanted: impl Fn(u32) -> bool,
    context: &Context,
) -> Result<()> {
    let mut moves = Moves::new(work);
    for round in 0..FIT_ROUNDS {
        for v in 0..work.points.len() as u32 {
            context.check_every(v as usize)?;
            if let Place::Region(region) = work.place[v as usize]
                && is_wanted(v)
                && moves.any_since(round, 1, work, around, v)
                && let Some(to) = settled(work, around, source, v, region)
                && to.distance(work.points[v as usize]) > LITTLE_FIT * around.mean_edge(work, v)
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
    let step = beneath(work, around, source, v, region)
        .optimum(mean, STEADY_WEIGHT)
        .clamp_length_max(FIT_REACH * shortest(from));
    let is_far = step.dot(around.up(work, v)).abs() > FITTED_GAP * source.diagonal;
    let ring = Ring::new(work, around, v);
    let before = ring.now.min(if is_far { FITTED_SHAPE } else { GOOD_SHAPE });
    WAY_SHARES
        .into_iter()
        .map(|share| work.put_back(source, v, from + share * step))
        .find(|&to| shortest(to) >= shortest(from).min(FIT_EDGE * length) && ring.holds(to, before))
}

/// The planes beneath the quarters of the quads at a vertex, from where it is.
fn beneath(work: &Work, around: &Around, source: &Source, v: u32, region: u32) -> Quadric {
    let from = work.points[v as usize];
    let mut sum = Quadric::ZERO;
    for &q in &around.quads[v as usize] {
        let face = work.faces.face(q as usize);
        let first = face.iter().position(|&w| w == v).unwrap_or(0);
        let [o, a, c, b] = [0, 1, 2, 3].map(|k| work.points[face[(first + k) % 4] as usize]);
        for (s, t) in FIT_PLACES.into_iter().flat_map(|s| FIT_PLACES.map(|t| (s, t))) {
            let p = o.lerp(a, s).lerp(b.lerp(c, s), t);
            if let Some((p, triangle)) = source.on_region(region, p) {
                sum.add(&Quadric::plane(p - from, source.normal(triangle), 1.0));
            }
        }
    }
    sum
}
