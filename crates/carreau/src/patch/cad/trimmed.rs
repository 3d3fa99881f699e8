//! One trimmed surface per rectilinear polygon instead of one whole surface per rectangle: fewer faces.
//!
//! The cells of a polygon lie on an integer grid (row, column) with mesh vertices at their corners. The surface of degree
//! (1, 1) spans the bounding rectangle; nodes that no cell has are extrapolated, and the loops around the cells, straight
//! in the parameter plane, trim what is not mesh:
//!
//! ```text
//!    · ──── · ──── ●      ● mesh vertices
//!    ┊      │  ▒▒  │      · extrapolated
//!    ● ──── ● ──── ●
//!    │  ▒▒  │  ▒▒  │
//!    ● ──── ● ──── ●
//! ```
//!
//! A face must not touch itself, so polygons are cut along grid lines first where they have slits, pinches, or pass a
//! mesh vertex twice; and where the bounding rectangle is out of all proportion to the cells.

use super::model::{CadModel, Geometry, PieceSurface, finish};
use super::piece::{Outline, Piece, Source};
use super::scene::Scene;
use super::{chain, exact};
use crate::brep::Surface;
use crate::context::Context;
use crate::error::{Error, Result};
use crate::geometry::bspline::{BSplineSurface, Knots};
use crate::mesh::{FaceId, NONE, SurfaceMesh, VertexId};
use crate::numeric::eigen3::outer;
use glam::{DMat3, DVec3};
use rustc_hash::{FxHashMap, FxHashSet};

/// A rectilinear polygon of quads. Cells that lie side by side are joined only where `next` says so; else there is a
/// wall between them.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct QuadPolygon {
    /// The cells, at most one per place.
    pub cells: Vec<QuadCell>,
}

/// A quad of a [`QuadPolygon`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct QuadCell {
    /// Row, counted upwards.
    pub row: i32,
    /// Column, counted to the right.
    pub col: i32,
    /// The mesh vertices at (row, col), (row, col + 1), (row + 1, col + 1), (row + 1, col).
    pub corners: [VertexId; 4],
    /// The cells across the bottom, right, top and left side; `u32::MAX` where there is a border or a wall.
    pub next: [u32; 4],
}

/// Largest area of the bounding rectangle for each cell.
const SPREAD: u64 = 16;
/// Most lines that are tried in each direction for a cut.
const TRIALS: usize = 12;

/// Builds the model of all polygons and leftover triangles; see [`super::to_brep`].
///
/// # Errors
/// [`Error::Input`] if polygons and leftovers do not fit the mesh,
/// [`Error::Cancelled`], [`Error::Deadline`].
pub fn to_trimmed_brep(
    mesh: &SurfaceMesh,
    polygons: &[QuadPolygon],
    leftover: &[FaceId],
    ctx: &Context,
) -> Result<CadModel> {
    let mut scene = Scene::new(mesh, &[], leftover)?;
    scene.nudge(&scene.leftover.clone());
    let mut pieces = Vec::new();
    let mut surfaces = Vec::new();
    for (k, polygon) in polygons.iter().enumerate() {
        check(mesh, k, polygon)?;
        for cells in parts(polygon, ctx)? {
            let part = Part::new(&polygon.cells, &cells);
            surfaces.push(part.surface(&scene)?);
            pieces.push(part.piece()?);
        }
    }
    for &t in &scene.leftover {
        surfaces.push(exact::triangle(&scene, t));
        pieces.push(Piece::triangle(&scene, t));
    }
    let chains = chain::chains(&pieces, mesh.vertex_count());
    let curves = chains.paths.iter().map(|path| exact::curve(&scene, path)).collect::<Result<_>>()?;
    let geometry = Geometry { curves, stops: vec![None; chains.paths.len()], surfaces };
    finish(scene, &pieces, &chains, geometry, ctx)
}

/// Fails where a polygon does not fit the mesh or contradicts itself.
fn check(mesh: &SurfaceMesh, polygon: usize, of: &QuadPolygon) -> Result<()> {
    let wrong = |what: &str, k: usize| Err(Error::input(what, format!("polygon {polygon}, cell {k}"), ""));
    let mut places = FxHashSet::default();
    for (k, cell) in of.cells.iter().enumerate() {
        let [a, b, c, d] = cell.corners;
        if cell.corners.iter().any(|v| v.index() >= mesh.vertex_count()) {
            return wrong("a corner does not exist", k);
        }
        if a == b || a == c || a == d || b == c || b == d || c == d {
            return wrong("two corners of a cell are the same vertex", k);
        }
        if !places.insert((cell.row, cell.col))
            || cell.row.checked_add(1).is_none()
            || cell.col.checked_add(1).is_none()
        {
            return wrong("the place of a cell is taken or out of range", k);
        }
        for (side, &next) in cell.next.iter().enumerate().filter(|(_, next)| **next != NONE) {
            let across = of.cells.get(next as usize);
            if across.is_none_or(|c| c.next[(side + 2) % 4] != k as u32 || (c.row, c.col) != beside(cell, side)) {
                return wrong("a neighbour does not exist, is elsewhere, or does not know the cell", k);
            }
        }
    }
    Ok(())
}

/// The place across a side.
fn beside(cell: &QuadCell, side: usize) -> (i32, i32) {
    let (dr, dc) = [(-1, 0), (0, 1), (1, 0), (0, -1)][side];
    (cell.row.wrapping_add(dr), cell.col.wrapping_add(dc))
}

// Cutting ------------------------------------------------------------------------------------------------------------

/// A line between rows (axis 0) or columns (axis 1): cells at `at` and above are on one side.
#[derive(Clone, Copy)]
struct Cut {
    axis: usize,
    at: i32,
}

/// Cuts a polygon into sets of cells that can be faces.
fn parts(polygon: &QuadPolygon, ctx: &Context) -> Result<Vec<Vec<u32>>> {
    let cells = &polygon.cells;
    let mut open = connected(cells, (0..cells.len() as u32).collect());
    open.reverse();
    let mut out = Vec::new();
    while let Some(part) = open.pop() {
        ctx.check()?;
        let defects = defects(cells, &part);
        if defects.is_empty() {
            out.push(part);
            continue;
        }
        let mut best: Option<(usize, Vec<Vec<u32>>)> = None;
        for cut in cuts(cells, &part, &defects) {
            let halves = split(cells, &part, cut);
            // Every part will be a face, and every defect will need another cut.
            let cost = halves.iter().map(|h| 1 + self::defects(cells, h).len()).sum();
            if best.as_ref().is_none_or(|(least, _)| cost < *least) {
                best = Some((cost, halves));
            }
        }
        // There is always a cut: a single cell has no defect.
        let Some((_, mut halves)) = best else {
            return Err(Error::Bug("a polygon that touches itself has no line to cut it along".into()));
        };
        halves.reverse();
        open.extend(halves);
    }
    Ok(out)
}

/// Nodes at which the part touches itself, or its middle where its bounding rectangle is too large.
fn defects(cells: &[QuadCell], part: &[u32]) -> Vec<[i32; 2]> {
    let inside: FxHashSet<u32> = part.iter().copied().collect();
    let mut vertex_at: FxHashMap<[i32; 2], VertexId> = FxHashMap::default();
    let (mut starts, mut passed, mut sides) = (FxHashSet::default(), FxHashSet::default(), FxHashSet::default());
    let mut out = Vec::new();
    for &k in part {
        let cell = &cells[k as usize];
        for side in 0..4 {
            let [from, to] = ends(cell, side);
            if *vertex_at.entry(from).or_insert(cell.corners[side]) != cell.corners[side] {
                out.push(from);
            }
            if inside.contains(&cell.next[side]) {
                continue;
            }
            // A pinch, a vertex that is passed again, a wall between two cells of the part.
            let again = !starts.insert(from) | !passed.insert(cell.corners[side]) | sides.contains(&[to, from]);
            sides.insert([from, to]);
            if again {
                out.push(from);
            }
        }
    }
    let [low, high] = bounds(cells, part);
    let size = [0, 1].map(|x| (i64::from(high[x]) - i64::from(low[x])) as u64);
    if size[0].saturating_mul(size[1]) > SPREAD * part.len() as u64 {
        out.push([0, 1].map(|x| low[x].midpoint(high[x])));
    }
    out
}

/// The nodes (row, column) at the beginning and the end of a side, counter-clockwise.
fn ends(cell: &QuadCell, side: usize) -> [[i32; 2]; 2] {
    let (r, c) = (cell.row, cell.col);
    let nodes = [[r, c], [r, c + 1], [r + 1, c + 1], [r + 1, c]];
    [nodes[side], nodes[(side + 1) % 4]]
}

/// First node and last node of the bounding rectangle.
fn bounds(cells: &[QuadCell], part: &[u32]) -> [[i32; 2]; 2] {
    let mut out = [[i32::MAX; 2], [i32::MIN; 2]];
    for &k in part {
        let at = [cells[k as usize].row, cells[k as usize].col];
        for x in 0..2 {
            out[0][x] = out[0][x].min(at[x]);
            out[1][x] = out[1][x].max(at[x] + 1);
        }
    }
    out
}

/// Lines through the defects, the middle of the part, and as a last resort any line: those that really cut.
fn cuts(cells: &[QuadCell], part: &[u32], defects: &[[i32; 2]]) -> Vec<Cut> {
    let [low, high] = bounds(cells, part);
    let mut out = Vec::new();
    for axis in 0..2 {
        let mut lines: Vec<i32> = defects.iter().map(|d| d[axis]).chain([low[axis].midpoint(high[axis])]).collect();
        lines.retain(|&at| low[axis] < at && at < high[axis]);
        lines.sort_unstable();
        lines.dedup();
        let step = lines.len().div_ceil(TRIALS).max(1);
        out.extend(lines.into_iter().step_by(step).map(|at| Cut { axis, at }));
    }
    out
}

/// The connected parts on both sides of a line.
fn split(cells: &[QuadCell], part: &[u32], cut: Cut) -> Vec<Vec<u32>> {
    let above = |k: &u32| [cells[*k as usize].row, cells[*k as usize].col][cut.axis] >= cut.at;
    let (high, low) = part.iter().copied().partition(above);
    let mut out = connected(cells, low);
    out.extend(connected(cells, high));
    out
}

/// Sets of cells connected through `next`, by their first cell.
fn connected(cells: &[QuadCell], part: Vec<u32>) -> Vec<Vec<u32>> {
    let mut left: FxHashSet<u32> = part.iter().copied().collect();
    let mut out = Vec::new();
    for k in part {
        if !left.remove(&k) {
            continue;
        }
        let mut set = vec![k];
        let mut next = 0;
        while next < set.len() {
            for &across in &cells[set[next] as usize].next {
                if left.remove(&across) {
                    set.push(across);
                }
            }
            next += 1;
        }
        set.sort_unstable();
        out.push(set);
    }
    out
}

// Faces --------------------------------------------------------------------------------------------------------------

/// A set of cells that touches itself nowhere.
struct Part<'a> {
    cells: Vec<&'a QuadCell>,
    /// First node, and numbers of cells in the bounding rectangle: row, column.
    low: [i32; 2],
    size: [u32; 2],
    /// Border sides by the node at which they begin: vertex there, node at which they end.
    border: FxHashMap<[i32; 2], (VertexId, [i32; 2])>,
}

impl<'a> Part<'a> {
    fn new(all: &'a [QuadCell], part: &[u32]) -> Self {
        let inside: FxHashSet<u32> = part.iter().copied().collect();
        let [low, high] = bounds(all, part);
        let cells: Vec<&QuadCell> = part.iter().map(|&k| &all[k as usize]).collect();
        let mut border = FxHashMap::default();
        for cell in &cells {
            for side in (0..4).filter(|&s| !inside.contains(&cell.next[s])) {
                let [from, to] = ends(cell, side);
                border.insert(from, (cell.corners[side], to));
            }
        }
        Part { cells, low, size: [0, 1].map(|x| (high[x] - low[x]) as u32), border }
    }

    /// The cells with their loops: the one that runs counter-clockwise is the outer one.
    fn piece(&self) -> Result<Piece> {
        let mut left = self.border.clone();
        let mut loops: Vec<(i64, Outline)> = Vec::new();
        // In the order of the cells, for hash maps have none.
        let starts = self.cells.iter().flat_map(|cell| (0..4).map(|side| ends(cell, side)[0]));
        for start in starts {
            if !left.contains_key(&start) {
                continue;
            }
            let mut nodes = Vec::new();
            let mut at = start;
            while let Some((vertex, next)) = left.remove(&at) {
                nodes.push((at, vertex));
                at = next;
            }
            if at != start {
                return Err(Error::Bug("the border of a polygon is not closed".into()));
            }
            loops.push(self.outline(&nodes));
        }
        loops.sort_by_key(|(area, _)| *area <= 0);
        if loops.iter().filter(|(area, _)| *area > 0).count() != 1 {
            return Err(Error::Bug("a polygon has no outer loop, or several".into()));
        }
        let cells = self.cells.iter().map(|c| c.corners.map(|v| v.0)).collect();
        Ok(Piece { source: Source::Polygon, cells, loops: loops.into_iter().map(|(_, outline)| outline).collect() })
    }

    /// Twice the signed area, and the outline.
    fn outline(&self, nodes: &[([i32; 2], VertexId)]) -> (i64, Outline) {
        let mut out = Outline::default();
        let mut area = 0;
        let n = nodes.len();
        for (k, &(at, vertex)) in nodes.iter().enumerate() {
            let (before, after) = (nodes[(k + n - 1) % n].0, nodes[(k + 1) % n].0);
            out.vertices.push(vertex.0);
            out.corner.push(before[0] != after[0] && before[1] != after[1]);
            out.at.push([(at[1] - self.low[1]) as u32, (at[0] - self.low[0]) as u32]);
            // Relative to the first node, so that places far out do not overflow.
            let [r, c] = [0, 1].map(|x| i64::from(at[x] - self.low[x]));
            let [s, d] = [0, 1].map(|x| i64::from(after[x] - self.low[x]));
            area += c * s - d * r;
        }
        (area, out)
    }

    /// The surface over the bounding rectangle.
    fn surface(&self, scene: &Scene) -> Result<PieceSurface> {
        let [m, n] = self.size;
        let mut net: Vec<Option<DVec3>> = vec![None; (m as usize + 1) * (n as usize + 1)];
        for cell in &self.cells {
            for side in 0..4 {
                let [from, _] = ends(cell, side);
                let [r, c] = [0, 1].map(|x| (from[x] - self.low[x]) as usize);
                net[r * (n as usize + 1) + c] = Some(scene.point(cell.corners[side].0));
            }
        }
        let points = filled(&net, n as usize + 1);
        let surface = BSplineSurface::new(Knots::index(n), Knots::index(m), points)?;
        let whole = self.cells.len() as u64 == u64::from(m) * u64::from(n);
        Ok(PieceSurface { surface: Surface::Spline(surface), border: None, trimmed: !whole })
    }
}

/// Fills the gaps of a net: the affine map that is nearest to the known points, plus a harmonic function that takes up
/// the difference at their edge and has no slope across the edge of the net.
///
/// A harmonic function alone would pull far points together; linear extrapolation from cell to cell would run away.
fn filled(net: &[Option<DVec3>], columns: usize) -> Vec<DVec3> {
    if net.iter().all(Option::is_some) {
        return net.iter().flatten().copied().collect();
    }
    let trend = nearest_affine(net, columns);
    let at = |k: usize| trend * DVec3::new(1.0, (k % columns) as f64, (k / columns) as f64);
    let known: Vec<bool> = net.iter().map(Option::is_some).collect();
    let mut rest: Vec<DVec3> = net.iter().enumerate().map(|(k, p)| p.map_or(DVec3::ZERO, |p| p - at(k))).collect();
    relax(&mut rest, &known, columns);
    (0..net.len()).map(|k| net[k].unwrap_or_else(|| at(k) + rest[k])).collect()
}

/// The matrix M with M (1, column, row) nearest to the known points.
fn nearest_affine(net: &[Option<DVec3>], columns: usize) -> DMat3 {
    let (mut gram, mut moments) = (DMat3::ZERO, DMat3::ZERO);
    for (k, p) in net.iter().enumerate() {
        if let Some(p) = p {
            let x = DVec3::new(1.0, (k % columns) as f64, (k / columns) as f64);
            gram += outer(x);
            moments += DMat3::from_cols(p * x.x, p * x.y, p * x.z);
        }
    }
    // A cell has three corners that are not in line, so the matrix is regular.
    moments * gram.inverse()
}

/// Solves Laplace's equation at the unknown nodes by conjugate gradients.
fn relax(x: &mut [DVec3], known: &[bool], columns: usize) {
    let n = x.len();
    let beside = |k: usize| {
        let (r, c) = (k / columns, k % columns);
        let left = (c > 0).then(|| k - 1);
        let right = (c + 1 < columns).then_some(k + 1);
        let below = (r > 0).then(|| k - columns);
        let above = (k + columns < n).then_some(k + columns);
        [left, right, below, above].into_iter().flatten()
    };
    let laplace = |x: &[DVec3], out: &mut [DVec3]| {
        for k in (0..n).filter(|&k| !known[k]) {
            out[k] = beside(k).map(|j| x[k] - x[j]).sum();
        }
    };
    let dot = |a: &[DVec3], b: &[DVec3]| a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum::<f64>();
    let mut product = vec![DVec3::ZERO; n];
    laplace(x, &mut product);
    let mut r: Vec<DVec3> = product.iter().map(|&p| -p).collect();
    let mut direction = r.clone();
    let mut size = dot(&r, &r);
    let enough = 1e-16 * size;
    // Nothing depends on the last digits of points that are trimmed away.
    for _ in 0..500 {
        if size <= enough {
            return;
        }
        laplace(&direction, &mut product);
        let step = size / dot(&direction, &product);
        if !step.is_finite() {
            return;
        }
        for k in 0..n {
            x[k] += step * direction[k];
            r[k] -= step * product[k];
        }
        let next = dot(&r, &r);
        let keep = next / size;
        size = next;
        direction.iter_mut().zip(&r).for_each(|(d, &r)| *d = r + keep * *d);
    }
}
