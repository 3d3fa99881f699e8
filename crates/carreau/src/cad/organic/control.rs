//! Control points of the blocks' faces: blossoms of the limit surface.
//!
//! Away from irregular vertices the limit surface is one cubic spline on the grid of the quads, and so are its pieces towards an
//! irregular corner, on knots that are halved towards it. A control point is the polar form of any piece under its
//! basis function, at three knots in each direction. So faces of neighbours have the same border, and are as smooth across it as
//! the limit surface is.
//!
//! ```text
//!     ┌──┬──┬─────┬───────────┬──       knots 0, 1/8, 1/4, 1/2, 1, 2, …
//!     ├──┼──┼─────┼───────────┼──
//!     ├──┼──┼─────┼───────────┼──
//!     ●──┴──┴─────┴───────────┴──       only the first cell is not the limit surface
//! ```

use super::blocks::Block;
use super::limit::{Limit, polar};
use super::net::{Net, next};
use crate::error::Result;
use crate::geometry::bspline::Knots;
use glam::DVec3;

/// A count: knots that are halved towards an irregular vertex, by how often the quads were divided, because the face is to follow
/// the limit surface there, each halves what it misses, and smaller quads miss less.
pub const GRADES: [usize; 3] = [3, 3, 2];

/// The face of a block: knots and control points, u fastest.
#[derive(Debug, Clone)]
pub struct Sheet {
    /// In u and v.
    pub knots: [Knots; 2],
    /// The control points.
    pub points: Vec<DVec3>,
}

impl Sheet {
    /// The control point (i, j) counted from a corner, i along the side that leaves it counter-clockwise.
    pub fn index(&self, corner: usize, i: usize, j: usize) -> usize {
        let [m, n] = [self.knots[0].count(), self.knots[1].count()];
        let [x, y] = match corner {
            0 => [i, j],
            1 => [m - 1 - j, i],
            2 => [m - 1 - i, n - 1 - j],
            _ => [j, n - 1 - i],
        };
        y * m + x
    }
}

/// A place of a block in the part that it is in: the part, which of the four of its quad it is, and the quad's place.
pub fn part_at(block: &Block, u: f64, v: f64) -> (u32, usize, [f64; 2]) {
    let [i, j] = [(u, 0), (v, 1)].map(|(t, k)| (t.floor().max(0.0) as usize).min(block.size[k] - 1));
    let [x, y] = [u - i as f64, v - j as f64];
    let lower = block.at(i, j);
    let quarter = match (x < 0.5, y < 0.5) {
        (true, true) => 0,
        (false, true) => 1,
        (false, false) => 2,
        (true, false) => 3,
    };
    let part = (0..quarter).fold(lower, |h, _| next(h));
    (part, quarter, [i as f64, j as f64])
}

/// Parameters of the part from those of the quad.
pub fn to_part(quarter: usize, [x, y]: [f64; 2]) -> [f64; 2] {
    match quarter {
        0 => [2.0 * x, 2.0 * y],
        1 => [2.0 * y, 2.0 * (1.0 - x)],
        2 => [2.0 * (1.0 - x), 2.0 * (1.0 - y)],
        _ => [2.0 * (1.0 - y), 2.0 * x],
    }
}

/// Parameters of the quad from those of a part.
pub fn from_part(quarter: usize, [a, b]: [f64; 2]) -> [f64; 2] {
    match quarter {
        0 => [0.5 * a, 0.5 * b],
        1 => [1.0 - 0.5 * b, 0.5 * a],
        2 => [1.0 - 0.5 * a, 1.0 - 0.5 * b],
        _ => [0.5 * b, 1.0 - 0.5 * a],
    }
}

/// The knots of a direction of so many quads, halved towards its ends where asked.
fn graded(count: usize, ends: [bool; 2], grades: usize) -> Result<Knots> {
    let mut breaks: Vec<f64> = (0..=count).map(|k| k as f64).collect();
    for grade in 1..=grades {
        let step = 0.5f64.powi(grade as i32);
        breaks.extend(ends[0].then_some(step));
        breaks.extend(ends[1].then_some(count as f64 - step));
    }
    breaks.sort_by(f64::total_cmp);
    breaks.dedup();
    Knots::from_breaks(3, &breaks, 1)
}

/// The face of a block, with so many knots halved towards irregular vertices.
pub fn sheet(net: &Net, block: &Block, surface: &Limit<'_, DVec3>, grades: usize) -> Result<Sheet> {
    let irregular = [0, 1, 2, 3].map(|c| !net.is_regular(&net.fans[net.fan_of[block.corner(c) as usize] as usize]));
    let [a, b, c, d] = irregular;
    let ends = [[a || d, b || c], [a || b, c || d]];
    let knots = [graded(block.size[0], ends[0], grades)?, graded(block.size[1], ends[1], grades)?];
    let values = knots.each_ref().map(|k| k.values());
    let last = values.map(|v| v.len() - 5);
    // Cells at irregular corners are the ones that are not pieces of the limit surface.
    let is_open = |s: usize, t: usize| {
        let (left, right, low, high) = (s == 3, s == last[0], t == 3, t == last[1]);
        !(a && left && low || b && right && low || c && right && high || d && left && high)
    };
    let counts = knots.each_ref().map(|k| k.count());
    let mut points = Vec::with_capacity(counts[0] * counts[1]);
    for j in 0..counts[1] {
        for i in 0..counts[0] {
            let spans = |k: usize, i: usize| {
                [i + 1, i + 2, i, i + 3].into_iter().filter(move |&s| values[k][s] < values[k][s + 1])
            };
            let cell = spans(0, i).flat_map(|s| spans(1, j).map(move |t| (s, t))).find(|&(s, t)| is_open(s, t));
            points.push(match cell {
                Some((s, t)) => blossom(block, surface, values, [i, j], [s, t]),
                None => {
                    let corner = [[0, 1], [3, 2]][usize::from(j > 0)][usize::from(i > 0)];
                    let part = block.corner(corner);
                    surface.apex(part).copied().unwrap_or_else(|| surface.piece(part, [0.0; 2]).point([0.0; 2]))
                }
            });
        }
    }
    Ok(Sheet { knots, points })
}

/// The control point of basis functions i, j from the piece under the cell of spans s, t.
fn blossom(
    block: &Block,
    surface: &Limit<'_, DVec3>,
    [u, v]: [&[f64]; 2],
    [i, j]: [usize; 2],
    [s, t]: [usize; 2],
) -> DVec3 {
    let middle = [0.5 * (u[s] + u[s + 1]), 0.5 * (v[t] + v[t + 1])];
    let (part, quarter, quad) = part_at(block, middle[0], middle[1]);
    let place = |x: f64, y: f64| to_part(quarter, [x - quad[0], y - quad[1]]);
    let piece = surface.piece(part, place(middle[0], middle[1]));
    let at = [1, 2, 3].map(|r| piece.local(place(u[i + r], v[j + r])));
    piece.mix(&polar(at.map(|p| p[0])), &polar(at.map(|p| p[1])))
}
