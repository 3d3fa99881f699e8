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

use super::cuts::{bounds, ends, parts};
use super::model::{CadModel, Geometry, PieceSurface, finish};
use super::piece::{Outline, Piece, Source};
use super::quad_polygon::{QuadCell, QuadPolygon};
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
