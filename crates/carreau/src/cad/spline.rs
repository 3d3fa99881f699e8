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
use super::flatten::{Flat, flatten};
use super::memory::Memory;
use super::model::Obstacle;
use super::regions::{Map, Piece, Rung, area_vector};
use super::topology::{Chain, Graph};
use super::tuning::{GAP, STATED};
use crate::brep::Surface;
use crate::context::Context;
use crate::error::Result;
use crate::geometry::bspline::{BSplineSurface, Knots};
use crate::mesh::{NONE, Triangles};
use crate::numeric::sparse::Matrix;
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// Spans across the narrower side of the first grid, and most spans across any side.
const FIRST_SPANS: f64 = 4.0;
const MOST_SPANS: usize = 64;
/// Halvings of the grid.
const HALVINGS: u32 = 3;
/// A grid of half the size brings a smooth surface nearer by a factor of sixteen; where it does not bring it nearer by this, the
/// region has a bend inside, or borders that contradict each other, and no finer grid helps.
const GAIN: f64 = 2.0;
/// Share of the rectangle by which it is larger than the region on every side, so that feet do not leave it.
const MARGIN: f64 = 0.04;
/// Points that are projected, and control points that are solved for, for all surfaces of a model: a second or two. What is not settled
/// then becomes facets.
pub const MOST_EFFORT: u64 = 400_000;
/// Pieces that are fitted side by side before the effort is looked at.
const AT_ONCE: usize = 8;
/// A control point that is solved for takes as long as the projection of so many points.
const CONTROL_POINT: u64 = 4;
/// Rounds in which parameters are corrected.
const CORRECTIONS: usize = 3;
/// Weight of a second difference, for a strong point of weight 1. It decides only where no points do.
const SMOOTH: f64 = 1e-6;
/// Weight of the middle of an edge inside.
const WEAK: f64 = 1e-3;
/// Share of the diagonal: strong points nearer than this need no finer grid. Tolerances of a tenth of what demotes a face.
const NEAR_ENOUGH: f64 = 0.06 * GAP;
/// Points of every edge's curve for each side of the mesh, at least.
const POINTS_A_SIDE: usize = 3;
/// Share of a cell of the grid: points along borders are this near to each other, so that a surface cannot swing between them.
const POINTS_A_CELL: f64 = 0.5;

/// A point of the fit with its parameters and weight.
#[derive(Debug, Clone, Copy)]
struct Sample {
    uv: DVec2,
    point: DVec3,
    weight: f64,
}

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
    for group in which.chunks(AT_ONCE) {
        let known = &*memory;
        let one = |&p: &u32| {
            context.check()?;
            let chains = &chains_of[p as usize];
            let key = Memory::surface_key(&map.pieces[p as usize], chains, tracks);
            Ok(match known.surface(&key) {
                Some(found) => (key, found.clone(), 0),
                None if map.effort >= MOST_EFFORT => (key, None, 0),
                None => {
                    let (found, effort) = fitted(map, p, chains, graph, tracks);
                    (key, found, effort)
                }
            })
        };
        let fits: Vec<_> = context.install(|| group.par_iter().map(one).collect::<Result<_>>())?;
        for (key, fit, effort) in fits {
            memory.keep_surface(key, &fit);
            map.effort += effort;
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
        if !(STATED * off <= GAP * map.diagonal && max <= map.tolerance.max(GAP * map.diagonal)) {
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
    let near = NEAR_ENOUGH * map.diagonal;
    let Some(surface) = approximate(&mut samples, vertices, &mut borders, near, &mut effort) else {
        return (None, effort);
    };
    let gaps = borders.iter().map(|b| b.gap(&surface)).collect();
    let off = |s: &Sample| surface.point(s.uv.x, s.uv.y).distance(s.point);
    let max = samples[..vertices].iter().map(off).fold(0.0, f64::max);
    let square = samples[..vertices].iter().map(|s| off(s).powi(2)).sum::<f64>() / vertices as f64;
    (Some(Fitted { surface, gaps, max, square }), effort)
}

/// A curve around the region: parameters of points along it, and their places.
struct Border<'a> {
    track: &'a Track,
    at: Vec<(f64, DVec2)>,
}

impl<'a> Border<'a> {
    /// Points at the vertices of the mesh.
    fn new(t: Triangles<'_>, chain: &Chain, track: &'a Track, flat: &Flat) -> Self {
        let sides = chain.vertices.len() - 1;
        let mut from = track.range[0];
        let mut at = vec![(from, flat.place(chain.vertices[0]))];
        for k in 0..sides {
            let [a, b] = [k, k + 1].map(|k| chain.vertices[k]);
            let to = if k + 1 == sides {
                track.range[1]
            } else {
                let chord = t.points()[a as usize].distance(t.points()[b as usize]);
                let guess = from + chord / track.curve.derivatives(from)[1].length().max(f64::MIN_POSITIVE);
                track.curve.project_near(t.points()[b as usize], guess).clamp(from, track.range[1])
            };
            at.push((to, flat.place(b)));
            from = to;
        }
        let mut border = Border { track, at };
        // Splines may bend between two vertices.
        let spans = match &track.curve {
            crate::brep::Curve::Spline(s) => s.knots().breaks().len() - 1,
            _ => 1,
        };
        while border.at.len() < (POINTS_A_SIDE * sides).max(2 * spans) {
            border.double(0.0);
        }
        border
    }

    /// Points in the middle of steps that are longer than a length; whether there were any.
    fn double(&mut self, step: f64) -> bool {
        let mut out = vec![self.at[0]];
        for w in self.at.windows(2) {
            let ([(s, p), (t, q)], long) = ([w[0], w[1]], w[0].1.distance(w[1].1) > step);
            if long || step == 0.0 {
                out.push((0.5 * (s + t), 0.5 * (p + q)));
            }
            out.push((t, q));
        }
        let more = out.len() > self.at.len();
        self.at = out;
        more
    }

    fn point(&self, k: usize) -> DVec3 {
        self.track.curve.point(self.at[k].0)
    }

    /// The largest distance from a surface: at the points, and between them.
    fn gap(&self, surface: &BSplineSurface) -> f64 {
        let off = |t: f64, near: DVec2| {
            let p = self.track.curve.point(t);
            let [u, v] = surface.project(p, near.into());
            surface.point(u, v).distance(p)
        };
        let between = self.at.windows(2).map(|w| off(0.5 * (w[0].0 + w[1].0), 0.5 * (w[0].1 + w[1].1)));
        self.at.iter().map(|&(t, uv)| off(t, uv)).chain(between).fold(0.0, f64::max)
    }
}

/// Middles of the edges inside of a region, raised by what they cut off as the normals at their ends say, weakly.
fn raised(t: Triangles<'_>, triangles: &[u32], label: &[u32], p: u32, flat: &Flat) -> Vec<Sample> {
    let mut normals = vec![DVec3::ZERO; flat.vertices.len()];
    let at = |v: u32| flat.vertices.binary_search(&v).unwrap_or(0);
    for &k in triangles {
        let n = area_vector(t, k);
        t.triangle(k).into_iter().for_each(|v| normals[at(v)] += n);
    }
    normals.iter_mut().for_each(|n| *n = n.normalize_or_zero());
    let mut out = Vec::new();
    for c in triangles.iter().flat_map(|&k| 3 * k..3 * k + 3) {
        let o = t.opposite(c);
        if o == NONE || o < c || label[o as usize / 3] != p {
            continue;
        }
        let [a, b] = [t.vertex(c), t.vertex(t.next(c))];
        let [m, n] = [a, b].map(|v| normals[at(v)]);
        let side = t.points()[b as usize] - t.points()[a as usize];
        let up = (m + n).normalize_or_zero();
        let height = ((n - m).dot(side) / 8.0).clamp(-0.25 * side.length(), 0.25 * side.length());
        let point = t.points()[a as usize] + 0.5 * side + up * height;
        out.push(Sample { uv: 0.5 * (flat.place(a) + flat.place(b)), point, weight: WEAK });
    }
    out
}

/// The surface on the coarsest grid that is near the borders and the vertices, the first of the samples; parameters become those of the
/// feet.
fn approximate(
    samples: &mut [Sample],
    vertices: usize,
    borders: &mut [Border<'_>],
    near: f64,
    effort: &mut u64,
) -> Option<BSplineSurface> {
    let places = || samples.iter().map(|s| s.uv).chain(borders.iter().flat_map(|b| b.at.iter().map(|a| a.1)));
    let low = places().fold(DVec2::INFINITY, DVec2::min);
    let high = places().fold(DVec2::NEG_INFINITY, DVec2::max);
    let size = high - low;
    if !(size.min_element() > 0.0) || !size.is_finite() {
        return None;
    }
    let (low, size) = (low - MARGIN * size, (1.0 + 2.0 * MARGIN) * size);
    let first = FIRST_SPANS / size.min_element();
    let mut best: Option<(f64, BSplineSurface, Places)> = None;
    for halving in 0..=HALVINGS {
        let fine = first * f64::from(2u32.pow(halving));
        let spans = [size.x, size.y].map(|l| ((l * fine).round() as usize).clamp(1, MOST_SPANS));
        let cell = (size / DVec2::new(spans[0] as f64, spans[1] as f64)).min_element();
        for border in borders.iter_mut() {
            while border.double(POINTS_A_CELL * cell) {}
        }
        let points = samples.len() + borders.iter().map(|b| b.at.len()).sum::<usize>();
        let controls = spans.iter().map(|s| *s as u64 + 3).product::<u64>();
        *effort += (CORRECTIONS as u64 + 1) * (points as u64 + CONTROL_POINT * controls);
        let surface = corrected(samples, borders, low, size, spans)?;
        let off = |s: &Sample| surface.point(s.uv.x, s.uv.y).distance(s.point);
        let inside = samples[..vertices].iter().map(off).fold(0.0, f64::max);
        let far = borders.iter().map(|b| b.gap(&surface)).fold(inside, f64::max);
        let hopeless = halving > 1 && best.as_ref().is_some_and(|b| GAIN * far > b.0);
        if best.as_ref().is_none_or(|b| far < b.0) {
            best = Some((far, surface, Places::of(samples, borders)));
        }
        if far <= near || hopeless || spans.iter().all(|&s| s == MOST_SPANS) {
            break;
        }
    }
    let (_, surface, places) = best?;
    samples.iter_mut().zip(places.of_samples).for_each(|(s, uv)| s.uv = uv);
    borders.iter_mut().zip(places.of_borders).for_each(|(b, at)| b.at = at);
    Some(surface)
}

/// The surface on one grid, after some rounds in which parameters become those of the feet.
fn corrected(
    samples: &mut [Sample],
    borders: &mut [Border<'_>],
    low: DVec2,
    size: DVec2,
    spans: [usize; 2],
) -> Option<BSplineSurface> {
    let mut surface = None;
    for _ in 0..=CORRECTIONS {
        let along = borders
            .iter()
            .flat_map(|b| (0..b.at.len()).map(|k| Sample { uv: b.at[k].1, point: b.point(k), weight: 1.0 }));
        let all: Vec<Sample> = samples.iter().copied().chain(along).collect();
        let fit = least_squares(&all, low, size, spans)?;
        let foot = |point: DVec3, uv: DVec2| DVec2::from(fit.project(point, uv.into()));
        samples.iter_mut().for_each(|s| s.uv = foot(s.point, s.uv));
        for border in borders.iter_mut() {
            for k in 0..border.at.len() {
                border.at[k].1 = foot(border.point(k), border.at[k].1);
            }
        }
        surface = Some(fit);
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

fn least_squares(samples: &[Sample], low: DVec2, size: DVec2, spans: [usize; 2]) -> Option<BSplineSurface> {
    let knots = |k: usize| {
        let at = |j: usize| low[k] + size[k] * j as f64 / spans[k] as f64;
        Knots::from_breaks(3, &(0..=spans[k]).map(at).collect::<Vec<f64>>(), 1).ok()
    };
    let (u, v) = (knots(0)?, knots(1)?);
    let [m, n] = [u.count(), v.count()];
    let mut matrix = Matrix::new(m * n);
    let mut rhs = [vec![0.0; m * n], vec![0.0; m * n], vec![0.0; m * n]];
    let middle = samples.iter().map(|s| s.point).sum::<DVec3>() / samples.len().max(1) as f64;
    let mut add = |terms: &[(usize, f64)], weight: f64, value: DVec3| {
        for &(i, a) in terms {
            (0..3).for_each(|k| rhs[k][i] += weight * a * value[k]);
            for &(j, b) in terms.iter().filter(|t| t.0 <= i) {
                matrix.add(i as u32, j as u32, weight * a * b);
            }
        }
    };
    for s in samples {
        let ((i, a), (j, b)) = (u.basis(s.uv.x), v.basis(s.uv.y));
        let pairs = (0..4).flat_map(|l| (0..4).map(move |k| (k, l)));
        let terms: Vec<(usize, f64)> = pairs.map(|(k, l)| ((j + l) * m + i + k, a[k] * b[l])).collect();
        add(&terms, s.weight, s.point - middle);
    }
    for j in 0..n {
        for i in 0..m {
            let id = |di: usize, dj: usize| (j + dj) * m + i + di;
            if i + 2 < m {
                add(&[(id(0, 0), 1.0), (id(1, 0), -2.0), (id(2, 0), 1.0)], SMOOTH, DVec3::ZERO);
            }
            if j + 2 < n {
                add(&[(id(0, 0), 1.0), (id(0, 1), -2.0), (id(0, 2), 1.0)], SMOOTH, DVec3::ZERO);
            }
            if i + 1 < m && j + 1 < n {
                let twist = [(id(0, 0), 1.0), (id(1, 0), -1.0), (id(0, 1), -1.0), (id(1, 1), 1.0)];
                add(&twist, 2.0 * SMOOTH, DVec3::ZERO);
            }
        }
    }
    let factor = matrix.factor(&mut None).ok()?;
    let [x, y, z] = [0, 1, 2].map(|k| factor.solve(&rhs[k]).ok());
    let (x, y, z) = (x?, y?, z?);
    let points = (0..m * n).map(|k| middle + DVec3::new(x[k], y[k], z[k])).collect();
    BSplineSurface::new(u, v, points).ok()
}

/// Whether a piece has a border.
pub fn has_border(t: Triangles<'_>, piece: &Piece, label: &[u32]) -> bool {
    let own = label[piece.triangles[0] as usize];
    let inside = |c: u32| t.opposite(c) != NONE && label[t.opposite(c) as usize / 3] == own;
    !piece.triangles.iter().flat_map(|&k| 3 * k..3 * k + 3).all(inside)
}
