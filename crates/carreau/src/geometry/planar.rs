//! Fills a planar region with nearly equilateral triangles, keeping the points of its border.
//!
//! The points of a triangular lattice that keep clear of the border are joined to it by a constrained Delaunay
//! triangulation, then relaxed: inner points move to the mean of their neighbours a few times and the whole is
//! triangulated anew. Distances to the border are taken to its points only, which are about one edge apart.

use crate::context::Context;
use crate::error::{Error, Result};
use glam::DVec2;
use spade::handles::FixedVertexHandle;
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};
use std::collections::VecDeque;

/// Lattice points closer to a border point than this many edges are dropped.
const CLEARANCE: f64 = 0.75;
/// Rounds of relaxing and triangulating; the shape hardly changes after these.
const RELAXING_ROUNDS: usize = 2;
/// Moves of every inner point in a round.
const MOVES: usize = 3;

/// The triangles of a region.
pub(crate) struct Filled {
    /// Points added inside the region.
    pub(crate) inner: Vec<DVec2>,
    /// Counter-clockwise triangles; indices count the border points, loop by loop, then `inner`.
    pub(crate) triangles: Vec<[u32; 3]>,
}

/// Fills the region bounded by closed loops; a point belongs to it when a ray from it crosses them an odd number of
/// times, so their sense does not matter. The loops must not touch each other or themselves.
pub(crate) fn fill(loops: &[Vec<DVec2>], edge: f64, context: &Context) -> Result<Filled> {
    let border: Vec<DVec2> = loops.concat();
    let constraints = loop_edges(loops);
    let mut points = border.clone();
    points.extend(lattice(loops, &border, edge));
    let mut triangles = triangulate(&points, &constraints)?;
    for _ in 0..RELAXING_ROUNDS {
        context.check()?;
        (0..MOVES).for_each(|_| relax(&mut points, border.len(), &triangles));
        triangles = triangulate(&points, &constraints)?;
    }
    Ok(Filled { inner: points.split_off(border.len()), triangles })
}

/// The edges of all loops as indices into the concatenated points.
fn loop_edges(loops: &[Vec<DVec2>]) -> Vec<[usize; 2]> {
    let mut edges = Vec::new();
    let mut start = 0;
    for l in loops {
        edges.extend((0..l.len()).map(|k| [start + k, start + (k + 1) % l.len()]));
        start += l.len();
    }
    edges
}

/// Points of an equilateral lattice inside the region and clear of its border.
///
/// ```text
///   ·   ·   ·   ·
///     ·   ·   ·      rows √3/2 apart, every other one shifted by half an edge
///   ·   ·   ·   ·
/// ```
fn lattice(loops: &[Vec<DVec2>], border: &[DVec2], edge: f64) -> Vec<DVec2> {
    let low = border.iter().fold(DVec2::INFINITY, |l, p| l.min(*p));
    let high = border.iter().fold(DVec2::NEG_INFINITY, |h, p| h.max(*p));
    let near = Near::new(border, low, CLEARANCE * edge);
    let rise = edge * 3f64.sqrt() / 2.0;
    let rows = ((high.y - low.y) / rise) as u32;
    let columns = ((high.x - low.x) / edge) as u32;
    let mut out = Vec::new();
    for row in 0..=rows {
        let y = low.y + rise * f64::from(row);
        let crossings = crossings(loops, y);
        let shift = if row % 2 == 0 { 0.0 } else { 0.5 };
        for column in 0..=columns {
            let p = DVec2::new(low.x + edge * (f64::from(column) + shift), y);
            let inside = crossings.partition_point(|&x| x < p.x) % 2 == 1;
            if inside && near.is_clear(p) {
                out.push(p);
            }
        }
    }
    out
}

/// Where the horizontal line at `y` crosses the loops, from left to right.
fn crossings(loops: &[Vec<DVec2>], y: f64) -> Vec<f64> {
    let edges = loops.iter().flat_map(|l| l.iter().zip(l.iter().cycle().skip(1)));
    let mut out: Vec<f64> = edges
        .filter(|(a, b)| (a.y <= y) != (b.y <= y))
        .map(|(a, b)| a.x + (b.x - a.x) * (y - a.y) / (b.y - a.y))
        .collect();
    out.sort_unstable_by(f64::total_cmp);
    out
}

/// Border points in square cells as wide as the clearance, sorted, so that a point looks at nine cells.
struct Near {
    low: DVec2,
    clearance: f64,
    cells: Vec<([i64; 2], DVec2)>,
}

impl Near {
    fn new(points: &[DVec2], low: DVec2, clearance: f64) -> Self {
        let mut near = Near { low, clearance, cells: Vec::new() };
        near.cells = points.iter().map(|&p| (near.cell(p), p)).collect();
        near.cells.sort_by_key(|c| c.0);
        near
    }

    fn cell(&self, p: DVec2) -> [i64; 2] {
        let q = (p - self.low) / self.clearance;
        [q.x.floor() as i64, q.y.floor() as i64]
    }

    /// Whether no border point is closer to `p` than the clearance.
    fn is_clear(&self, p: DVec2) -> bool {
        let [x, y] = self.cell(p);
        (x - 1..=x + 1).all(|column| {
            let start = self.cells.partition_point(|c| c.0 < [column, y - 1]);
            let stop = self.cells.partition_point(|c| c.0 <= [column, y + 1]);
            self.cells[start..stop].iter().all(|c| c.1.distance(p) >= self.clearance)
        })
    }
}

/// Moves every inner point to the mean of its neighbours.
fn relax(points: &mut [DVec2], fixed: usize, triangles: &[[u32; 3]]) {
    let mut sum = vec![(DVec2::ZERO, 0.0); points.len()];
    // An inner edge is seen from both its triangles, each adding one direction of it.
    for [a, b, c] in triangles.iter().map(|t| t.map(|v| v as usize)) {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            sum[from].0 += points[to];
            sum[from].1 += 1.0;
        }
    }
    for (p, (total, count)) in points.iter_mut().zip(sum).skip(fixed) {
        if count > 0.0 {
            *p = total / count;
        }
    }
}

/// The constrained Delaunay triangles inside the loops.
fn triangulate(points: &[DVec2], constraints: &[[usize; 2]]) -> Result<Vec<[u32; 3]>> {
    let vertices = points.iter().map(|p| Point2::new(p.x, p.y)).collect();
    let mut crossing = false;
    let cdt =
        ConstrainedDelaunayTriangulation::<Point2<f64>>::try_bulk_load_cdt(vertices, constraints.to_vec(), |_| {
            crossing = true;
        })
        .map_err(|e| Error::Numeric(format!("a planar face cannot be triangulated: {e}")))?;
    if crossing || cdt.num_vertices() != points.len() {
        return Err(Error::Options("a planar face has an outline that meets itself; check the model's sizes".into()));
    }
    let inside = inside_faces(&cdt);
    let corners = |f: [FixedVertexHandle; 3]| f.map(|v| v.index() as u32);
    Ok(cdt.inner_faces().filter(|f| inside[f.fix().index()]).map(|f| corners(f.vertices().map(|v| v.fix()))).collect())
}

/// For every face of the triangulation, whether an odd number of constraints separates it from the outside.
fn inside_faces(cdt: &ConstrainedDelaunayTriangulation<Point2<f64>>) -> Vec<bool> {
    let outer = cdt.outer_face().fix().index();
    let mut inside: Vec<Option<bool>> = vec![None; cdt.num_all_faces()];
    inside[outer] = Some(false);
    let mut queue = VecDeque::new();
    let mut cross = |edge: spade::handles::DirectedEdgeHandle<'_, _, _, _, _>, here: bool, queue: &mut VecDeque<_>| {
        let beyond = edge.rev().face().fix();
        let slot = &mut inside[beyond.index()];
        if slot.is_none() {
            *slot = Some(here != edge.is_constraint_edge());
            queue.push_back((beyond, here != edge.is_constraint_edge()));
        }
    };
    cdt.convex_hull().for_each(|e| cross(e, false, &mut queue));
    while let Some((face, here)) = queue.pop_front() {
        if let Some(face) = cdt.face(face).as_inner() {
            face.adjacent_edges().into_iter().for_each(|e| cross(e, here, &mut queue));
        }
    }
    inside.into_iter().map(|i| i == Some(true)).collect()
}
