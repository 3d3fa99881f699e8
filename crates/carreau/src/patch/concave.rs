//! Concave vertices of a polygon with walls, and the rays that extend a wall beyond them.
//!
//! Around a grid point lie up to four *quadrants*, the corners of its cells. Those that are joined across their common
//! side form a *sector*; walls and borders separate sectors. A sector of three quadrants (270°) is a concave vertex of
//! the polygon, and so is one of four that does not close (360°: the tip of a slit). One and two quadrants are a convex
//! corner and a straight side. Two cells that touch diagonally have a sector each, so that they need no special care.
//!
//! ```text
//!     180° + 180°        270° + 90°        270°            360° (tip)        closed: not a vertex
//!     ┌───┬───┐          ┌───┬───┐         ┌───┬───┐       ┌───┬───┐         ┌───┬───┐
//!     │   ┃   │          │   ┃   │         │   │   │       │   │   │         │   │   │
//!     ├───╂───┤          ├───╄━━━┤         ├───┼───┘       ├───╁───┤         ├───┼───┤
//!     │   ┃   │          │   │   │         │   │           │   ┃   │         │   │   │
//!     └───┴───┘          └───┴───┘         └───┘           └───┴───┘         └───┴───┘
//! ```
//!
//! A dissection into rectangles has no concave vertex, so some cut must end at or pass through each of them: for 270°,
//! the extension of one of its two walls; for a tip, the extension of its slit or a cut that passes across it.

use super::polygon::{Links, NONE, opposite, turn_left, turn_right};

/// A corner of a cell. Corner k lies between the sides k − 1 and k, corner 0 at the lower left.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Quadrant {
    pub cell: u32,
    pub corner: usize,
}

impl Quadrant {
    /// The next quadrant around the same point.
    fn clockwise(self, links: &Links) -> Option<Self> {
        let cell = links.next(self.cell, self.corner);
        (cell != NONE).then_some(Self { cell, corner: turn_right(self.corner) })
    }

    /// The next quadrant around the same point.
    fn counter_clockwise(self, links: &Links) -> Option<Self> {
        let cell = links.next(self.cell, turn_right(self.corner));
        (cell != NONE).then_some(Self { cell, corner: turn_left(self.corner) })
    }

    /// A number for the sector of this quadrant, below four times the number of cells and the same for all quadrants of
    /// the sector: that of its most clockwise quadrant, or of the one with corner 0 if the sector closes.
    pub fn sector_id(self, links: &Links) -> usize {
        let mut first = self;
        while let Some(next) = first.clockwise(links) {
            first = next;
            if first == self {
                first.cell = (0..self.corner).fold(self, |q, _| q.clockwise(links).unwrap_or(q)).cell;
                first.corner = 0;
                break;
            }
        }
        4 * first.cell as usize + first.corner
    }
}

/// A sector of 270° or 360°, named by its most clockwise quadrant.
#[derive(Debug, Clone, Copy)]
pub(super) struct ConcaveVertex {
    pub first: Quadrant,
}

impl ConcaveVertex {
    /// All concave vertices.
    pub fn all(links: &Links) -> Vec<Self> {
        let quadrants = (0..links.len()).flat_map(|cell| (0..4).map(move |corner| Quadrant { cell, corner }));
        let begins_sector = |q: &Quadrant| q.clockwise(links).is_none();
        quadrants.filter(begins_sector).map(|first| Self { first }).filter(|v| v.is_concave(links)).collect()
    }

    /// Whether no cut has resolved this vertex yet.
    pub fn is_concave(&self, links: &Links) -> bool {
        self.rays(links).next().is_some()
    }

    /// The extensions of the walls at this vertex: two at 270°, one at 360°, none if it is not concave.
    pub fn rays(&self, links: &Links) -> impl Iterator<Item = Ray> + use<> {
        let second = self.first.counter_clockwise(links);
        let third = second.and_then(|q| q.counter_clockwise(links));
        let fourth = third.and_then(|q| q.counter_clockwise(links));
        let concave = third.is_some();
        let beside_first = (concave && fourth.is_none()).then_some(self.first);
        let beside_second = second.filter(|_| concave);
        beside_first.into_iter().chain(beside_second).map(Ray::along)
    }
}

/// A directed grid edge inside the polygon: the first step of a cut that goes straight on from there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Ray {
    /// The cell to the right of the edge.
    right: u32,
    /// 0 down, 1 right, 2 up, 3 left.
    pub direction: usize,
}

/// What a cut meets at the end of an edge.
enum Head {
    /// Nothing, or the tip of a slit that stands across the cut: it goes on.
    Open(Ray),
    /// A concave vertex with a wall that the cut continues.
    Concave,
    /// A straight wall or border.
    Straight,
}

impl Ray {
    /// The edge that leaves the point of this quadrant along its counter-clockwise side.
    fn along(quadrant: Quadrant) -> Self {
        Self { right: quadrant.cell, direction: opposite(quadrant.corner) }
    }

    /// A quadrant at the start of the edge.
    fn tail(self) -> Quadrant {
        Quadrant { cell: self.right, corner: opposite(self.direction) }
    }

    /// A quadrant at the end of the edge.
    fn head(self) -> Quadrant {
        Quadrant { cell: self.right, corner: turn_left(self.direction) }
    }

    /// ```text
    ///     ahead left │ ahead right        The cut goes on if the two cells ahead are joined, and one of them to the
    ///   ─────────────●─────────────       cell behind it. If not both are, it passes the tip of a slit. A tip does not
    ///     left       ↑ right              stop a cut, or else the vertex that it comes from and the one beyond the tip
    /// ```                                 would seem unrelated, and the number of rectangles would not be minimal.
    fn look_ahead(self, links: &Links) -> Head {
        let (to_left, to_right) = (turn_left(self.direction), turn_right(self.direction));
        let ahead_right = links.next(self.right, self.direction);
        let ahead_left = links.next(links.next(self.right, to_left), self.direction);
        let beyond = match (ahead_left, ahead_right) {
            (NONE, NONE) => return Head::Straight,
            (left, NONE) => links.next(left, to_right),
            (_, right) if links.joined(right, to_left) => right,
            _ => NONE,
        };
        if beyond == NONE { Head::Concave } else { Head::Open(Self { right: beyond, ..self }) }
    }

    /// The edges of the cut.
    pub fn edges(self, links: &Links) -> impl Iterator<Item = Self> + '_ {
        std::iter::successors(Some(self), |ray| match ray.look_ahead(links) {
            Head::Open(next) => Some(next),
            Head::Concave | Head::Straight => None,
        })
    }

    /// Whether the cut ends at a concave vertex whose wall it continues.
    pub fn is_chord(self, links: &Links) -> bool {
        self.edges(links).last().is_some_and(|last| matches!(last.look_ahead(links), Head::Concave))
    }

    /// The sectors of the points of the cut, its ends included.
    pub fn sectors(self, links: &Links) -> impl Iterator<Item = usize> + '_ {
        let start = self.tail().sector_id(links);
        std::iter::once(start).chain(self.edges(links).map(|edge| edge.head().sector_id(links)))
    }

    /// Makes the whole cut a wall.
    pub fn cut(self, links: &mut Links) {
        let mut edge = self;
        loop {
            let head = edge.look_ahead(links);
            links.cut(edge.right, turn_left(edge.direction));
            match head {
                Head::Open(next) => edge = next,
                Head::Concave | Head::Straight => break,
            }
        }
    }
}
