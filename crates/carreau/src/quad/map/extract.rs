//! Quads straight from the integer triangles: every cell centre is a quad, and a straight walk leads to each of its corners. All
//! in whole numbers: centres are at odd multiples of half a cell, corners at even ones.
//!
//! ```text
//!   ┌───────┐
//!   │ ↖   ↗ │     corners of a cell are vertices of the triangulation (cones), whole points of its edges,
//!   │   ·   │     or whole points inside a face
//!   │ ↙   ↘ │
//!   └───────┘
//! ```

use super::super::work::{Place, Work};
use super::cell::Cell;
use super::flat::Flat;
use super::framed::{Framed, next};
use super::locate::{Locator, share_of_edge};
use super::tuning::{MOST_CELLS, MOST_CROSSED};
use crate::context::Context;
use crate::error::Result;
use crate::mesh::NONE;
use rustc_hash::FxHashMap;

/// Where a vertex of quads is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Spot {
    Vertex(u32),
    /// So many of the whole steps along a half-edge, the one with the smaller number.
    Edge(u32, i64),
    /// In a face, in half cells from its first corner.
    Face(u32, Cell),
}

/// The quads, and the face that the centre of each is in; or why there are none.
pub fn extract(
    flat: &Flat,
    framed: &Framed,
    locator: &Locator,
    context: &Context,
) -> Result<std::result::Result<(Work, Vec<u32>), &'static str>> {
    let (number, work) = (FxHashMap::default(), Work::default());
    let mut out = Extraction { flat, framed, locator, number, work, of: Vec::new() };
    for f in flat.faces() {
        context.check()?;
        if let Err(why) = out.add_face(f, context)? {
            return Ok(Err(why));
        }
    }
    out.add_features();
    Ok(Ok((out.work, out.of)))
}

struct Extraction<'a> {
    flat: &'a Flat,
    framed: &'a Framed,
    locator: &'a Locator<'a>,
    number: FxHashMap<Spot, u32>,
    work: Work,
    /// The face of every quad.
    of: Vec<u32>,
}

impl Extraction<'_> {
    /// Corners of a face in half cells, the first at the origin.
    fn corners(&self, f: u32) -> [Cell; 3] {
        let (a, b) = (self.flat.side(3 * f).cells, self.flat.side(3 * f + 1).cells);
        [Cell::ZERO, 2 * a, 2 * (a + b)]
    }

    /// The cells whose centre is in a face; of those on an edge, the face of the smaller half-edge has it.
    fn add_face(&mut self, f: u32, context: &Context) -> Result<std::result::Result<(), &'static str>> {
        let p = self.corners(f);
        let (x, y) = (p.map(|p| p.x), p.map(|p| p.y));
        let low = Cell::new(x[0].min(x[1]).min(x[2]), y[0].min(y[1]).min(y[2]));
        let high = Cell::new(x[0].max(x[1]).max(x[2]), y[0].max(y[1]).max(y[2]));
        let size = high - low;
        if size.x.saturating_mul(size.y) / 4 > MOST_CELLS {
            return Ok(Err("a face has too many cells"));
        }
        let odd = |n: i64| n + i64::from(n % 2 == 0);
        for y in (odd(low.y)..=high.y).step_by(2) {
            context.check()?;
            for x in (odd(low.x)..=high.x).step_by(2) {
                let centre = Cell::new(x, y);
                let side = [0, 1, 2].map(|k| (p[(k + 1) % 3] - p[k]).cross(centre - p[k]));
                if side.iter().any(|&s| s < 0) {
                    continue;
                }
                let on = (0..3u32).find(|&k| side[k as usize] == 0).map(|k| 3 * f + k);
                if on.is_some_and(|h| self.flat.side(h).opposite < h) {
                    continue;
                }
                let mut quad = [0; 4];
                for (corner, step) in quad.iter_mut().zip([(-1, -1), (1, -1), (1, 1), (-1, 1)]) {
                    let Some(spot) = self.walk(f, centre, Cell::new(step.0, step.1)) else {
                        return Ok(Err("a cell has no corner"));
                    };
                    *corner = self.vertex(spot);
                }
                self.work.faces.push(&quad);
                self.work.region.push(self.flat.region[f as usize]);
                self.of.push(f);
            }
        }
        Ok(Ok(()))
    }

    /// The corner of a cell, in a direction from its centre.
    fn walk(&self, mut f: u32, mut from: Cell, mut way: Cell) -> Option<Spot> {
        for _ in 0..MOST_CROSSED {
            let (p, to) = (self.corners(f), from + way);
            let side = [0, 1, 2].map(|k| (p[(k + 1) % 3] - p[k]).cross(to - p[k]));
            if side.iter().all(|&s| s >= 0) {
                return Some(self.spot(f, to, side));
            }
            // A whole point is never between: the line passes beside all corners.
            let k = (0..3)
                .find(|&k| side[k] < 0 && way.cross(p[k] - from) <= 0 && way.cross(p[(k + 1) % 3] - from) >= 0)?;
            let h = 3 * f + k as u32;
            let (o, turn) = (self.flat.side(h).opposite, self.flat.side(h).turn);
            if o == NONE {
                return None;
            }
            let across = self.corners(o / 3)[next(o) as usize % 3];
            from = (from - p[k]).turned(turn) + across;
            way = way.turned(turn);
            f = o / 3;
        }
        None
    }

    /// What a point of a face is, by which of its sides it is on.
    fn spot(&self, f: u32, at: Cell, side: [i64; 3]) -> Spot {
        let p = self.corners(f);
        if let Some(k) = (0..3).find(|&k| p[k] == at) {
            return Spot::Vertex(self.flat.side(3 * f + k as u32).vertex);
        }
        match (0..3).find(|&k| side[k] == 0) {
            None => Spot::Face(f, at),
            Some(k) => {
                let h = 3 * f + k as u32;
                let whole = self.flat.side(h).cells.steps();
                self.edge_spot(h, whole * (at - p[k]).steps() / (p[(k + 1) % 3] - p[k]).steps())
            }
        }
    }

    fn edge_spot(&self, h: u32, step: i64) -> Spot {
        let side = self.flat.side(h);
        match side.opposite < h {
            true => Spot::Edge(side.opposite, side.cells.steps() - step),
            false => Spot::Edge(h, step),
        }
    }

    fn vertex(&mut self, spot: Spot) -> u32 {
        if let Some(&known) = self.number.get(&spot) {
            return known;
        }
        let flat = self.flat;
        let (point, place) = match spot {
            Spot::Vertex(v) => {
                let region = flat.region[flat.at[v as usize] as usize / 3];
                let place = self.framed.place[v as usize].unwrap_or(Place::Region(region));
                (self.framed.points[v as usize], place)
            }
            Spot::Edge(h, step) => {
                let share = step as f64 / flat.side(h).cells.steps() as f64;
                match flat.side(h).curve {
                    NONE => {
                        let point = self.locator.in_face(flat, h / 3, share_of_edge(h, share));
                        (point, Place::Region(flat.region[h as usize / 3]))
                    }
                    curve => (self.locator.on_curve(flat, h, share), Place::Curve(curve)),
                }
            }
            Spot::Face(f, at) => {
                let p = self.corners(f);
                let whole = (p[1] - p[0]).cross(p[2] - p[0]) as f64;
                let shares = [1, 2, 0].map(|k: usize| (p[(k + 1) % 3] - p[k]).cross(at - p[k]) as f64 / whole);
                (self.locator.in_face(flat, f, shares), Place::Region(flat.region[f as usize]))
            }
        };
        let number = self.work.points.len() as u32;
        self.work.points.push(point);
        self.work.place.push(place);
        self.number.insert(spot, number);
        number
    }

    /// The edges of quads along features.
    fn add_features(&mut self) {
        for f in self.flat.faces() {
            for h in 3 * f..3 * f + 3 {
                let side = *self.flat.side(h);
                if side.curve == NONE || side.opposite < h {
                    continue;
                }
                let whole = side.cells.steps();
                let spot = |step: i64| match step {
                    0 => Spot::Vertex(side.vertex),
                    _ if step == whole => Spot::Vertex(self.flat.side(next(h)).vertex),
                    _ => Spot::Edge(h, step),
                };
                for step in 0..whole {
                    let ends = [spot(step), spot(step + 1)].map(|s| self.number.get(&s).copied());
                    if let [Some(a), Some(b)] = ends {
                        self.work.features.push(([a, b], side.curve));
                    }
                }
            }
        }
    }
}
