//! Surface nets (Gibson 1998): polygonises the zero set of a field by one vertex per grid cell that it passes through
//! and one quad per grid edge that it crosses; then the vertices are spread evenly and put exactly on the surface.
//!
//! Departure: a cell that several sheets of the surface pass through has one vertex for each of them, as in dual
//! marching cubes (Nielson 2004); with one vertex for all, the crotch of a fork is often not manifold.

use crate::context::Context;
use crate::error::{Error, Result};
use crate::mesh::split_quad;
use glam::DVec3;
use rayon::prelude::*;

/// A function whose zero set is a closed surface, negative inside, with slope at most 1.
pub(super) trait Field: Sync {
    /// The value at a point.
    fn value(&self, p: DVec3) -> f64;
    /// A box that holds the surface.
    fn bounds(&self) -> (DVec3, DVec3);
}

/// Cells along the side of a block; blocks farther from the surface than their own radius are skipped whole.
const BLOCK: i32 = 8;
/// Rounds of spreading.
const ROUNDS: usize = 12;
/// Largest number of blocks looked at.
const MAX_BLOCKS: f64 = 2e7;

/// A cell or a node of the grid.
type Place = [i32; 3];

/// The surface with edges of about this length. Fails with [`Error::Options`] when the grid would be too fine.
pub(super) fn polygonise(field: &impl Field, edge: f64, context: &Context) -> Result<(Vec<DVec3>, Vec<[u32; 3]>)> {
    let stage = context.stage("polygonise");
    let grid = Grid::new(field, edge)?;
    let crossings = grid.crossings(field);
    stage.step(1, 3)?;
    let (guesses, quads) = connect(&crossings);
    let neighbours = Neighbours::new(guesses.len(), &quads);
    let mut points: Vec<DVec3> = guesses.par_iter().map(|&g| project(field, grid.low + g * grid.cell, edge)).collect();
    stage.step(2, 3)?;
    for _ in 0..ROUNDS {
        context.check()?;
        points = spread(field, &points, &neighbours, edge);
    }
    let triangles = quads.iter().flat_map(|q| split_quad(&points, *q)).collect();
    Ok((points, triangles))
}

/// The grid: node (i, j, k) stands at `low + cell · (i, j, k)`.
struct Grid {
    low: DVec3,
    cell: f64,
    /// Number of blocks along each axis.
    blocks: Place,
}

impl Grid {
    fn new(field: &impl Field, edge: f64) -> Result<Self> {
        let (low, high) = field.bounds();
        // Surface cells are cut obliquely: the sides of quads and their diagonals are about 0.9 cells long on average.
        let cell = edge * 1.1;
        let count = ((high - low + 2.0 * cell) / (cell * f64::from(BLOCK))).ceil();
        if count.element_product() > MAX_BLOCKS {
            return Err(Error::Options(format!("an edge length of {edge:.4} makes too fine a grid; use longer edges")));
        }
        Ok(Grid { low: low - cell, cell, blocks: count.to_array().map(|c| c as i32) })
    }

    fn node(&self, at: Place) -> DVec3 {
        self.low + DVec3::from(at.map(f64::from)) * self.cell
    }

    /// All grid edges that cross the surface: where they start, their axis, and whether they start inside; sorted by
    /// block, then by place.
    fn crossings(&self, field: &impl Field) -> Vec<Crossing> {
        let [nx, ny, nz] = self.blocks;
        let blocks: Vec<Place> =
            (0..nz).flat_map(|k| (0..ny).flat_map(move |j| (0..nx).map(move |i| [i, j, k]))).collect();
        blocks.par_iter().flat_map_iter(|b| self.block_crossings(field, b.map(|i| i * BLOCK))).collect()
    }

    /// The crossings that start in one block.
    fn block_crossings(&self, field: &impl Field, first: Place) -> Vec<Crossing> {
        let half = 0.5 * self.cell * f64::from(BLOCK);
        let mut out = Vec::new();
        if field.value(self.node(first) + half).abs() > half * 3f64.sqrt() * (1.0 + 1e-9) {
            return out;
        }
        const SIDE: usize = BLOCK as usize + 1;
        let mut inside = [[[false; SIDE]; SIDE]; SIDE];
        for (k, j, i) in places(SIDE) {
            inside[k][j][i] =
                field.value(self.node([first[0] + i as i32, first[1] + j as i32, first[2] + k as i32])) < 0.0;
        }
        for (k, j, i) in places(SIDE - 1) {
            let here = inside[k][j][i];
            for (axis, there) in [inside[k][j][i + 1], inside[k][j + 1][i], inside[k + 1][j][i]].into_iter().enumerate()
            {
                if here != there {
                    let start = [first[0] + i as i32, first[1] + j as i32, first[2] + k as i32];
                    out.push(Crossing { start, axis, inside: here });
                }
            }
        }
        out
    }
}

fn places(side: usize) -> impl Iterator<Item = (usize, usize, usize)> {
    (0..side).flat_map(move |k| (0..side).flat_map(move |j| (0..side).map(move |i| (k, j, i))))
}

/// A grid edge that crosses the surface.
struct Crossing {
    start: Place,
    axis: usize,
    /// Whether `start` is inside.
    inside: bool,
}

impl Crossing {
    /// The four cells around the edge, each with the edge's number in it, counter-clockwise seen from outside.
    ///
    /// ```text
    ///    1 │ 0        the edge points at the reader: the quad 0-1-2-3 faces its end,
    ///   ───•───       which is right when the start is inside
    ///    2 │ 3
    /// ```
    fn cells(&self) -> [(Place, usize); 4] {
        let (u, v) = ((self.axis + 1) % 3, (self.axis + 2) % 3);
        let quad = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(du, dv)| {
            let mut cell = self.start;
            cell[u] -= du;
            cell[v] -= dv;
            (cell, edge_number(self.axis, du as usize, dv as usize))
        });
        if self.inside { quad } else { [quad[3], quad[2], quad[1], quad[0]] }
    }
}

/// The number (0..12) of a cell's edge along `axis` at the offsets `du`, `dv` along the two following axes.
fn edge_number(axis: usize, du: usize, dv: usize) -> usize {
    4 * axis + du + 2 * dv
}

/// One corner of one quad: the cell it stands for.
struct QuadCorner {
    cell: Place,
    /// Number of the crossed edge in the cell.
    edge: usize,
    crossing: u32,
    slot: u32,
}

/// The quads, and the first guess of every vertex: the mean of the edges' midpoints, in cells.
fn connect(crossings: &[Crossing]) -> (Vec<DVec3>, Vec<[u32; 4]>) {
    let quad_corners = |(k, crossing): (usize, &Crossing)| {
        let corner = |(slot, (cell, edge))| QuadCorner { cell, edge, crossing: k as u32, slot: slot as u32 };
        crossing.cells().into_iter().enumerate().map(corner).collect::<Vec<_>>()
    };
    let mut corners: Vec<QuadCorner> = crossings.par_iter().enumerate().flat_map_iter(quad_corners).collect();
    corners.par_sort_unstable_by_key(|c| (c.cell, c.edge));
    let mut vertices = Vec::new();
    let mut quads = vec![[0; 4]; crossings.len()];
    for cell in corners.chunk_by(|a, b| a.cell == b.cell) {
        let sheet = sheets(cell, crossings);
        for first in 0..12 {
            let members = || cell.iter().filter(|c| sheet[c.edge] == first);
            let count = members().count();
            if count > 0 {
                members().for_each(|c| quads[c.crossing as usize][c.slot as usize] = vertices.len() as u32);
                let sum: DVec3 = members().map(|c| midpoint(&crossings[c.crossing as usize])).sum();
                vertices.push(sum / count as f64);
            }
        }
    }
    (vertices, quads)
}

fn midpoint(crossing: &Crossing) -> DVec3 {
    let mut p = DVec3::from(crossing.start.map(f64::from));
    p[crossing.axis] += 0.5;
    p
}

/// Tells the sheets of the surface in a cell apart: every crossed edge gets the number of the first edge of its sheet.
///
/// Two crossed edges belong together if the surface joins them across a face of the cell. Where all four edges of a
/// face are crossed there are two ways to join them; the surface is made to go around the inside corners, a rule that
/// both cells at the face follow, so that no edge of the result has more than two quads:
///
/// ```text
///   ○──╱──●
///   ╱     ╱        ● inside, ○ outside
///   ●──╱──○
/// ```
fn sheets(cell: &[QuadCorner], crossings: &[Crossing]) -> [usize; 12] {
    let mut inside_start = [None; 12];
    cell.iter().for_each(|c| inside_start[c.edge] = Some(crossings[c.crossing as usize].inside));
    let mut sheet: [usize; 12] = std::array::from_fn(|k| k);
    let mut join = |a: usize, b: usize| {
        let (low, high) = (sheet[a].min(sheet[b]), sheet[a].max(sheet[b]));
        sheet.iter_mut().filter(|s| **s == high).for_each(|s| *s = low);
    };
    for axis in 0..3 {
        let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
        for level in 0..2 {
            let along_b = [0, 1].map(|offset| edge_number(b, offset, level));
            let along_c = [0, 1].map(|offset| edge_number(c, level, offset));
            let crossed: Vec<usize> =
                along_b.into_iter().chain(along_c).filter(|&e| inside_start[e].is_some()).collect();
            match crossed[..] {
                [p, q] => join(p, q),
                [p, q, r, s] => {
                    // The edge `p` starts where `r` starts, and ends where `s` starts.
                    let (with_p, with_q) = if inside_start[p] == Some(true) { (r, s) } else { (s, r) };
                    join(p, with_p);
                    join(q, with_q);
                }
                _ => {}
            }
        }
    }
    sheet
}

/// The vertices joined to every vertex by a side of a quad.
struct Neighbours {
    offsets: Vec<u32>,
    list: Vec<u32>,
}

impl Neighbours {
    fn new(vertices: usize, quads: &[[u32; 4]]) -> Self {
        // Every side belongs to two quads that run it in opposite senses: each adds one of the two directions.
        let sides = || quads.iter().flat_map(|q| (0..4).map(|k| (q[k], q[(k + 1) % 4])));
        let mut offsets = vec![0u32; vertices + 1];
        sides().for_each(|(a, _)| offsets[a as usize + 1] += 1);
        for v in 0..vertices {
            offsets[v + 1] += offsets[v];
        }
        let mut fill = offsets.clone();
        let mut list = vec![0u32; 4 * quads.len()];
        for (a, b) in sides() {
            list[fill[a as usize] as usize] = b;
            fill[a as usize] += 1;
        }
        Neighbours { offsets, list }
    }

    fn of(&self, v: usize) -> &[u32] {
        &self.list[self.offsets[v] as usize..self.offsets[v + 1] as usize]
    }
}

/// Moves every vertex to the mean of its neighbours and back to the surface.
fn spread(field: &impl Field, points: &[DVec3], neighbours: &Neighbours, edge: f64) -> Vec<DVec3> {
    (0..points.len())
        .into_par_iter()
        .map(|v| {
            let around = neighbours.of(v);
            let mean = around.iter().map(|&n| points[n as usize]).sum::<DVec3>() / around.len() as f64;
            project(field, mean, edge)
        })
        .collect()
}

/// The foot of a point near the surface, by Newton's method along the gradient.
fn project(field: &impl Field, mut p: DVec3, edge: f64) -> DVec3 {
    for _ in 0..6 {
        let value = field.value(p);
        if value.abs() < 1e-13 * edge {
            break;
        }
        let gradient = gradient(field, p, 1e-5 * edge);
        let square = gradient.length_squared();
        // Where two tubes meet on the inside the gradient can vanish: stay there and leave it to the next round.
        if square < 1e-3 {
            break;
        }
        p -= gradient * (value / square);
    }
    p
}

fn gradient(field: &impl Field, p: DVec3, step: f64) -> DVec3 {
    let slope = |d: DVec3| (field.value(p + d * step) - field.value(p - d * step)) / (2.0 * step);
    DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z))
}
