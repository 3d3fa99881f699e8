//! Dissection of a polygon into the fewest rectangles.
//!
//! Sources: Lipski et al., Fund. Inform. 2 (1979); Ohtsuki, ISCAS 1982; Imai and Asano, SIAM J. Comput. 15 (1986);
//! Soltan and Gorpinevich, Discrete Comput. Geom. 9 (1993). Bénière et al. (REFIG 5(1), 2011, figure 9) note that their
//! greedy extraction needs more rectangles than necessary; this is the remedy.
//!
//! Every concave vertex must be resolved by a cut (see `concave`). A cut usually resolves one vertex; a *chord*, a cut
//! that continues a wall at both of its ends, resolves two. A vertical and a horizontal chord that touch, be it at
//! an end, cannot both do so:
//!
//! ```text
//!         ┏━━━┓           a ┄┄ b is a chord; so is a ┄┄ c. They share a, which only one of them needs to resolve.
//!         ┃   ┃
//!     ┏━━━a┄┄┄b━━━┓
//!     ┃   ┊       ┃
//!     ┗━━━c   ┏━━━┛
//!         ┃   ┃
//!         ┗━━━┛
//! ```
//!
//! 1. Find all chords. A cut passes across the tip of a slit that is perpendicular to it, and resolves it.
//! 2. Touching chords form a bipartite graph; a maximum independent set (Hopcroft–Karp and König) is cut.
//! 3. At each concave vertex that remains, extend one wall up to the next wall. The theory leaves the choice free; the
//!    shorter extension is taken, the horizontal one of two that are equally long.
//!
//! The number of rectangles is N − L + χ with N concave vertices, L independent chords and χ the Euler characteristic of
//! the polygon, its cells being glued along the sides that are not walls. Without slits and diagonal contacts χ is 1 − h
//! with h holes, which gives the N − L − h + 1 of the literature; a slit inside counts as a hole, and diagonal contacts
//! do not close a hole.
//!
//! Each grid edge lies on at most one ray in each direction, so that all steps but the matching are linear in the number
//! of cells. Vertices are taken in the order of their places: the result does not depend on the numbering of the cells.

use super::concave::{ConcaveVertex, Ray};
use super::polygon::{BOTTOM, LEFT, Links, NONE, Polygon, RIGHT, Rectangle, TOP};
use crate::numeric::hopcroft_karp::Bipartite;
use crate::{Context, Error, Result};

/// Dissects a polygon into the fewest rectangles, listed by row, then column of their lower left cells.
///
/// # Errors
/// Cancellation and deadline of the context.
pub fn minimum(polygon: &Polygon, context: &Context) -> Result<Vec<Rectangle>> {
    debug_assert!(polygon.check().is_ok());
    let mut links = Links::of(polygon);
    let vertices = sorted_vertices(polygon, &links);
    context.check()?;
    let chords = Chords::find(&vertices, &links);
    context.check()?;
    for chord in chords.independent(&links) {
        chord.cut(&mut links);
    }
    for (step, vertex) in vertices.iter().enumerate() {
        context.check_every(step)?;
        if let Some(ray) = shortest(vertex.rays(&links), &links) {
            ray.cut(&mut links);
        }
    }
    let rectangles = read_off(polygon, &links)?;
    debug_assert!(polygon.check_dissection(&rectangles).is_ok());
    Ok(rectangles)
}

fn sorted_vertices(polygon: &Polygon, links: &Links) -> Vec<ConcaveVertex> {
    let mut vertices = ConcaveVertex::all(links);
    vertices.sort_unstable_by_key(|vertex| {
        let cell = &polygon.cells[vertex.first.cell as usize];
        (cell.row, cell.col, vertex.first.corner)
    });
    vertices
}

/// The shortest of several cuts, the horizontal one if two are equally long.
fn shortest(rays: impl Iterator<Item = Ray>, links: &Links) -> Option<Ray> {
    rays.min_by_key(|ray| (ray.edges(links).count(), ray.direction == TOP || ray.direction == BOTTOM))
}

/// Cuts that continue a wall at both ends, each named by its left or lower end.
struct Chords {
    horizontal: Vec<Ray>,
    vertical: Vec<Ray>,
}

impl Chords {
    fn find(vertices: &[ConcaveVertex], links: &Links) -> Self {
        let towards = |direction| {
            let rays = vertices.iter().flat_map(|vertex| vertex.rays(links));
            rays.filter(|ray| ray.direction == direction && ray.is_chord(links)).collect()
        };
        Self { horizontal: towards(RIGHT), vertical: towards(TOP) }
    }

    /// As many chords as possible of which no two touch.
    fn independent(&self, links: &Links) -> Vec<Ray> {
        let (lefts, rights) = (self.horizontal.len() as u32, self.vertical.len() as u32);
        let free = Bipartite::new(lefts, rights, &self.contacts(links)).maximum_independent_set();
        let horizontal = self.horizontal.iter().zip(&free.left);
        let vertical = self.vertical.iter().zip(&free.right);
        horizontal.chain(vertical).filter(|&(_, &free)| free).map(|(&chord, _)| chord).collect()
    }

    /// The pairs (horizontal, vertical) of chords that have a point in common.
    fn contacts(&self, links: &Links) -> Vec<(u32, u32)> {
        let mut horizontal_at = vec![NONE; 4 * links.len() as usize];
        for (id, chord) in (0..).zip(&self.horizontal) {
            for sector in chord.sectors(links) {
                horizontal_at[sector] = id;
            }
        }
        let mut contacts = Vec::new();
        for (id, chord) in (0..).zip(&self.vertical) {
            let met = chord.sectors(links).map(|sector| horizontal_at[sector]);
            contacts.extend(met.filter(|&horizontal| horizontal != NONE).map(|horizontal| (horizontal, id)));
        }
        contacts
    }
}

/// The parts into which the polygon has been cut, which must be rectangles.
fn read_off(polygon: &Polygon, links: &Links) -> Result<Vec<Rectangle>> {
    let length = |mut cell: u32, direction| {
        let mut length = 1;
        while links.joined(cell, direction) {
            cell = links.next(cell, direction);
            length += 1;
        }
        length
    };
    let corners = (0..links.len()).filter(|&cell| !links.joined(cell, LEFT) && !links.joined(cell, BOTTOM));
    let mut rectangles: Vec<Rectangle> = corners
        .map(|corner| {
            let cell = &polygon.cells[corner as usize];
            let (rows, cols) = (length(corner, TOP), length(corner, RIGHT));
            Rectangle { row: cell.row, col: cell.col, rows, cols, corner }
        })
        .collect();
    if rectangles.iter().map(Rectangle::area).sum::<usize>() != polygon.cells.len() {
        return Err(Error::Bug("a rectilinear polygon was cut into parts that are not rectangles".into()));
    }
    rectangles.sort_unstable_by_key(|r| (r.row, r.col));
    Ok(rectangles)
}
