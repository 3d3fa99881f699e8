//! Spline surfaces of regions that lie on no surface of a simple kind.
//!
//! ```text
//!     ┌─────────────┐   the rectangle of the parameters
//!     │   ___●__    │   ●  vertices, and points of the curves around the region: strong
//!     │ ●╱ ·    ╲●  │   ·  middles of edges inside, raised by what facets cut off: weak
//!     │  ╲___·__╱   │
//!     │      ●      │   beyond the region the surface is only as smooth as it can be
//!     └─────────────┘
//! ```
//!
//! A bicubic surface of least squares with a penalty on its second differences (Eilers and Marx, *Flexible smoothing with
//! B-splines and penalties*, Statistical Science 11, 1996; after Reinsch's smoothing). The parameters of all points are those of
//! their feet on the surface before (Hoschek, *Intrinsic parametrization for approximation*, CAGD 5, 1988). The grid is halved
//! until the strong points are near enough.

use super::curves::Track;
use super::flatten::flatten;
use super::grid::{Grid, Sample};
use super::memory::Memory;
use super::model::Obstacle;
use super::points::{Border, raised};
use super::regions::{Map, Piece, Rung};
use super::topology::Graph;
use super::tuning::{MOST_GAP, STATED_FACTOR};
use crate::brep::Surface;
use crate::context::Context;
use crate::error::Result;
use crate::geometry::bspline::BSplineSurface;
use crate::mesh::{NONE, Triangles};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// A count: spans across the narrower side of the first grid, few because each halving doubles them.
const FIRST_SPANS: f64 = 4.0;
/// A count: most spans across any side, because time and file grow with their square.
const MOST_SPANS: usize = 64;
/// A count: a grid of more spans than this for each sample is not halved, because it follows nothing that it knows.
const SPANS_A_SAMPLE: usize = 8;
/// A count: halvings of the grid, because each takes four times as long.
const GRID_HALVINGS: u32 = 4;
/// A factor: a grid of half the size brings a surface nearer by no more. For a smooth one it is sixteen, because
/// splines are cubic, and where points were few, this in all that was seen.
const MOST_GAIN: f64 = 32.0;
/// A factor: where half the size brings a surface nearer by less, no finer grid helps, because the region has a bend
/// inside, or borders that contradict each other.
const LEAST_GAIN: f64 = 2.0;
/// A share of the rectangle by which it is larger than the region on every side, because feet would leave it.
const GRID_MARGIN: f64 = 0.04;
/// A count of points that are projected, and control points that are solved for, for all surfaces of a model: a second.
/// What is not settled then becomes facets, because a user waits.
pub const MOST_EFFORT: u64 = 200_000;
/// A count: pieces that are fitted side by side before the effort is looked at, because the result must not depend on
/// the number of threads.
const PIECES_AT_ONCE: usize = 8;
/// A count of points: a control point is solved for in about the time that so many take to be projected.
const CONTROL_EFFORT: u64 = 4;
/// A count: rounds in which parameters are corrected, few because each brings feet much nearer.
const FOOT_CORRECTIONS: usize = 3;
/// A share of the diagonal: strong points nearer than this need no finer grid, because tolerances then are a tenth of
/// what demotes a face.
const ENOUGH_DISTANCE: f64 = 0.06 * MOST_GAP;
/// Weight of the middle of an edge inside, for a strong point of weight 1: small, because edges cut off what is round.
const MIDDLE_WEIGHT: f64 = 1e-3;
/// A factor: what that weight is multiplied by with every halving, because what middles pull a surface off its borders
/// has to fall with the distances that are left.
const MIDDLE_FACTOR: f64 = 0.1;
/// A count: samples for every control point, because more do not change the surface.
const SAMPLES_A_CONTROL: usize = 6;
/// A share of a cell of the grid: points along borders are this near to each other, because a surface could swing
/// between them.
const BORDER_SPACING: f64 = 0.34;

/// Gives all pieces of the rung their surfaces, between the curves of their edges, whose gaps they add to. Returns the pieces that
/// have none.
pub fn settle(
    map: &mut Map<'_>,
    graph: &Graph,
    tracks: &mut [Track],
    memory: &mut Memory,
    context: &Context,
) -> Result<Vec<Obstacle>> {
    let which: Vec<u32> =
        (0..map.pieces.len() as u32).filter(|&p| map.pieces[p as usize].rung == Rung::Spline).collect();
    if which.is_empty() {
        return Ok(Vec::new());
    }
    let _stage = context.stage("splines");
    let mut chains_of: Vec<Vec<u32>> = vec![Vec::new(); map.pieces.len()];
    for (chain, k) in graph.chains.iter().zip(0u32..) {
        chain.sides.iter().filter(|&&s| s != NONE).for_each(|&s| chains_of[s as usize].push(k));
    }
    let mut found = Vec::with_capacity(which.len());
    for group in which.chunks(PIECES_AT_ONCE) {
        let known = &*memory;
        let one = |&p: &u32| {
            context.check()?;
            let chains = &chains_of[p as usize];
            let key = Memory::surface_key(&map.pieces[p as usize], chains, tracks);
            Ok(match known.surface(&key) {
                Some(found) => (key, found.clone(), 0),
                None if known.is_spent() => (key, None, 0),
                None => {
                    let (found, effort) = fitted(map, p, chains, graph, tracks);
                    (key, found, effort)
                }
            })
        };
        let fits: Vec<_> = context.install(|| group.par_iter().map(one).collect::<Result<_>>())?;
        for (key, fit, effort) in fits {
            memory.keep_surface(key, &fit);
            memory.effort += effort;
            found.push(fit);
        }
    }
    let mut obstacles = Vec::new();
    for (&p, found) in which.iter().zip(found) {
        let piece = &mut map.pieces[p as usize];
        let Some(Fitted { surface, gaps, max, square }) = found else {
            let reason = "it cannot be laid out in a plane, or there was no time left for it";
            obstacles.push(Obstacle { pieces: vec![p], reason: reason.into() });
            continue;
        };
        let off = gaps.iter().copied().fold(0.0, f64::max);
        for (&k, gap) in chains_of[p as usize].iter().zip(gaps) {
            tracks[k as usize].gap = tracks[k as usize].gap.max(gap);
        }
        if !(STATED_FACTOR * off <= MOST_GAP * map.diagonal && max <= map.tolerance.max(MOST_GAP * map.diagonal)) {
            let off = off.max(max) / map.diagonal;
            let reason = format!("no spline surface came nearer to its vertices and edges than {off:.0e} of the size");
            obstacles.push(Obstacle { pieces: vec![p], reason });
        }
        (piece.surface, piece.same_sense) = (Surface::Spline(surface), true);
        (piece.max, piece.square) = (max, square);
    }
    Ok(obstacles)
}

/// A surface with what was measured.
#[derive(Debug, Clone)]
pub struct Fitted {
    surface: BSplineSurface,
    /// Distance of every chain's curve.
    gaps: Vec<f64>,
    /// Of the vertices: the largest distance, and the mean square.
    max: f64,
    square: f64,
}

/// The surface of a piece, and the effort.
fn fitted(map: &Map<'_>, p: u32, chains: &[u32], graph: &Graph, tracks: &[Track]) -> (Option<Fitted>, u64) {
    let triangles = &map.pieces[p as usize].triangles;
    let Some(flat) = flatten(map.t, triangles) else { return (None, triangles.len() as u64) };
    let mut samples: Vec<Sample> = flat
        .vertices
        .iter()
        .zip(&flat.places)
        .map(|(&v, &uv)| Sample { uv, point: map.t.points()[v as usize], weight: 1.0 })
        .collect();
    let vertices = samples.len();
    samples.extend(raised(map.t, triangles, &map.label, p, &flat));
    let mut borders: Vec<Border<'_>> =
        chains.iter().map(|&k| Border::new(map.t, &graph.chains[k as usize], &tracks[k as usize], &flat)).collect();
    let mut effort = 0;
    let Some(surface) = approximate(&mut samples, vertices, &mut borders, map.diagonal, &mut effort) else {
        return (None, effort);
    };
    let gaps = borders.iter().map(|b| b.gap(&surface)).collect();
    let off = |s: &Sample| surface.point(s.uv.x, s.uv.y).distance(s.point);
    let max = samples[..vertices].iter().map(off).fold(0.0, f64::max);
    let square = samples[..vertices].iter().map(|s| off(s).powi(2)).sum::<f64>() / vertices as f64;
    (Some(Fitted { surface, gaps, max, square }), effort)
}

/// The surface on the coarsest grid that is near the borders and the vertices, the first of the samples; parameters become those of the
/// feet.
fn approximate(
    samples: &mut [Sample],
    vertices: usize,
    borders: &mut [Border<'_>],
    diagonal: f64,
    effort: &mut u64,
) -> Option<BSplineSurface> {
    let places = || samples.iter().map(|s| s.uv).chain(borders.iter().flat_map(|b| b.at.iter().map(|a| a.1)));
    let low = places().fold(DVec2::INFINITY, DVec2::min);
    let high = places().fold(DVec2::NEG_INFINITY, DVec2::max);
    let size = high - low;
    if !(size.min_element() > 0.0) || !size.is_finite() {
        return None;
    }
    let (low, size) = (low - GRID_MARGIN * size, (1.0 + 2.0 * GRID_MARGIN) * size);
    let first = FIRST_SPANS / size.min_element();
    let mut best: Option<(f64, BSplineSurface, Places)> = None;
    for halving in 0..=GRID_HALVINGS {
        let fine = first * f64::from(2u32.pow(halving));
        let spans = [size.x, size.y].map(|l| ((l * fine).round() as usize).clamp(1, MOST_SPANS));
        let cell = (size / DVec2::new(spans[0] as f64, spans[1] as f64)).min_element();
        for border in borders.iter_mut() {
            while border.double(BORDER_SPACING * cell) {}
        }
        // What they pull the surface off its borders has to fall with the distances that are left.
        samples[vertices..].iter_mut().for_each(|s| s.weight = MIDDLE_WEIGHT * MIDDLE_FACTOR.powi(halving as i32));
        let mut grid = Grid::new(low, size, spans)?;
        let surface = corrected(samples, borders, &mut grid, effort)?;
        samples[..vertices].iter_mut().for_each(|s| s.uv = surface.project(s.point, s.uv.into()).into());
        let off = |s: &Sample| surface.point(s.uv.x, s.uv.y).distance(s.point);
        let inside = samples[..vertices].iter().map(off).fold(0.0, f64::max);
        let far = borders.iter().map(|b| b.gap(&surface)).fold(inside, f64::max);
        tracing::debug!(spans = ?spans, samples = samples.len(), inside = inside / diagonal, far = far / diagonal, "spline surface");
        let slow = halving > 2 && best.as_ref().is_some_and(|b| LEAST_GAIN * far > b.0);
        // Nearer by the largest gain with every halving that is left is not near enough.
        let hopeless = far > MOST_GAP * diagonal * MOST_GAIN.powi((GRID_HALVINGS - halving) as i32);
        if best.as_ref().is_none_or(|b| far < b.0) {
            best = Some((far, surface, Places::of(samples, borders)));
        }
        // A finer grid knows no more than the samples do.
        let is_fine = spans[0] * spans[1] > SPANS_A_SAMPLE * samples.len();
        if far <= ENOUGH_DISTANCE * diagonal || slow || hopeless || is_fine || spans.iter().all(|&s| s == MOST_SPANS) {
            break;
        }
    }
    let (_, surface, places) = best?;
    samples.iter_mut().zip(places.of_samples).for_each(|(s, uv)| s.uv = uv);
    borders.iter_mut().zip(places.of_borders).for_each(|(b, at)| b.at = at);
    Some(surface)
}

/// The surface on one grid, after some rounds in which parameters become those of the feet. Of more samples than a grid needs, every
/// second, third … counts.
fn corrected(
    samples: &mut [Sample],
    borders: &mut [Border<'_>],
    grid: &mut Grid,
    effort: &mut u64,
) -> Option<BSplineSurface> {
    let step = samples.len().div_ceil(SAMPLES_A_CONTROL * grid.count()).max(1);
    let points = samples.len() / step + borders.iter().map(|b| b.at.len()).sum::<usize>();
    let mut surface: Option<BSplineSurface> = None;
    for _ in 0..=FOOT_CORRECTIONS {
        if let Some(fit) = &surface {
            let foot = |point: DVec3, uv: DVec2| DVec2::from(fit.project(point, uv.into()));
            samples.iter_mut().step_by(step).for_each(|s| s.uv = foot(s.point, s.uv));
            for border in borders.iter_mut() {
                for k in 0..border.at.len() {
                    border.at[k].1 = foot(border.point(k), border.at[k].1);
                }
            }
        }
        *effort += points as u64 + CONTROL_EFFORT * grid.count() as u64;
        let along = borders
            .iter()
            .flat_map(|b| (0..b.at.len()).map(|k| Sample { uv: b.at[k].1, point: b.point(k), weight: 1.0 }));
        surface = Some(grid.fit(samples.iter().copied().step_by(step).chain(along))?);
    }
    surface
}

/// Where all points were on the best surface.
struct Places {
    of_samples: Vec<DVec2>,
    of_borders: Vec<Vec<(f64, DVec2)>>,
}

impl Places {
    fn of(samples: &[Sample], borders: &[Border<'_>]) -> Self {
        Places {
            of_samples: samples.iter().map(|s| s.uv).collect(),
            of_borders: borders.iter().map(|b| b.at.clone()).collect(),
        }
    }
}

/// Whether a piece has a border.
pub fn has_border(t: Triangles<'_>, piece: &Piece, label: &[u32]) -> bool {
    let own = label[piece.triangles[0] as usize];
    let inside = |c: u32| t.opposite(c) != NONE && label[t.opposite(c) as usize / 3] == own;
    !piece.triangles.iter().flat_map(|&k| 3 * k..3 * k + 3).all(inside)
}
