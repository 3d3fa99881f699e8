//! An edge becomes one of its ends.
//!
//! ```text
//!      c                      c
//!     ╱│╲                     │
//!    ╱ │ ╲                    │
//!  ─•──h─→•─      →       ────•────     Keep::Head; the triangles on both sides of h disappear
//!    ╲ │ ╱                    │
//!     ╲│╱                     │
//!      d                      d
//! ```
//!
//! The result is a surface of the same topology exactly when the ends have no common neighbours but the apexes c and d
//! (the link condition, Dey et al. 1999), where a border counts as one more vertex, joined to all of it.

use super::edit_mesh::{EditMesh, next, previous};
use crate::mesh::triangles::NONE;

/// Which end of a half-edge stays.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Keep {
    /// The vertex that the half-edge leaves.
    Tail,
    /// The vertex that it enters.
    Head,
}

/// Why an edge cannot be collapsed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CollapseError {
    /// An inner edge joins two borders, or two parts of one.
    Pinch,
    /// The ends have a common neighbour besides the apexes.
    Link,
    /// An apex would be left with too few triangles: a tetrahedron, or the last triangle of a component.
    Apex,
}

impl EditMesh {
    /// The ends of an edge, the one that goes first.
    #[inline]
    pub fn gone_and_kept(&self, h: u32, keep: Keep) -> (u32, u32) {
        match keep {
            Keep::Tail => (self.head(h), self.vertex(h)),
            Keep::Head => (self.vertex(h), self.head(h)),
        }
    }

    /// Whether the topology stays when this edge is collapsed: the link condition. Geometry is not looked at.
    ///
    /// # Errors
    /// The reason why the edge may not be collapsed.
    pub fn check_collapse(&self, h: u32) -> Result<(), CollapseError> {
        let (a, b, o) = (self.vertex(h), self.head(h), self.opposite(h));
        if o != NONE && self.is_border(a) && self.is_border(b) {
            return Err(CollapseError::Pinch);
        }
        let apexes = [self.apex(h), if o == NONE { NONE } else { self.apex(o) }];
        for c in apexes.into_iter().filter(|&c| c != NONE) {
            let triangles = self.around(c).take(4).count();
            if triangles <= if self.is_border(c) { 1 } else { 3 } {
                return Err(CollapseError::Apex);
            }
        }
        if apexes[0] == apexes[1] {
            return Err(CollapseError::Link);
        }
        // Rings have half a dozen vertices: comparing all pairs beats any marking.
        let mut ring = [NONE; 32];
        let mut count = 0;
        self.for_neighbours(b, |v| {
            if count < ring.len() {
                ring[count] = v;
            }
            count += 1;
        });
        let mut common = false;
        self.for_neighbours(a, |v| {
            let is_near_b = if count <= ring.len() { ring[..count].contains(&v) } else { self.are_neighbours(v, b) };
            common |= is_near_b && !apexes.contains(&v);
        });
        if common { Err(CollapseError::Link) } else { Ok(()) }
    }

    /// Whether a collapse makes an edge that may exist elsewhere in the welded mesh, or a triangle of three copies.
    pub fn joins_copies(&self, h: u32, keep: Keep) -> bool {
        if self.copied.is_empty() {
            return false;
        }
        let (gone, kept) = self.gone_and_kept(h, keep);
        let mut joins = false;
        self.for_neighbours(gone, |w| {
            joins |= w != kept && self.may_double(w, kept) && !self.are_neighbours(w, kept);
        });
        joins
            || self.is_copy(kept)
                && self.around(gone).any(|h| {
                    let sides = [self.head(h), self.apex(h)];
                    !sides.contains(&kept) && sides.iter().all(|&v| self.is_copy(v))
                })
    }

    /// Whether an edge between two vertices may exist elsewhere in the welded mesh: both are copies, or one of them is joined
    /// to another copy of the other, as at the end of a slit.
    pub fn may_double(&self, a: u32, b: u32) -> bool {
        let meets_twin = |at: u32, of: u32| {
            let mut meets = false;
            self.for_neighbours(at, |u| meets |= u != of && self.origin[u as usize] == self.origin[of as usize]);
            meets
        };
        match (self.is_copy(a), self.is_copy(b)) {
            (true, true) => true,
            (true, false) => meets_twin(b, a),
            (false, true) => meets_twin(a, b),
            (false, false) => false,
        }
    }

    /// Whether an edge joins two vertices.
    pub fn are_neighbours(&self, a: u32, b: u32) -> bool {
        let mut found = false;
        self.for_neighbours(a, |v| found |= v == b);
        found
    }

    /// Collapses an edge that has passed [`EditMesh::check_collapse`].
    ///
    /// The vertex that goes must lie on no curve, or on one curve only, which the edge belongs to. Corners that change
    /// their vertex join the wedge of the kept vertex on their side.
    pub fn collapse(&mut self, h: u32, keep: Keep) {
        // Of an inner edge the tail goes: the other case is the same for the opposite half-edge.
        let h = if keep == Keep::Tail && self.opposite(h) != NONE { self.opposite(h) } else { h };
        let tail_goes = keep == Keep::Head || self.opposite(h) != NONE;
        let o = self.opposite(h);
        let (gone, kept) = if tail_goes { (self.vertex(h), self.head(h)) } else { (self.head(h), self.vertex(h)) };
        self.move_corners(h, gone, kept, tail_goes);
        let apexes = [(h, self.apex(h)), (o, if o == NONE { NONE } else { self.apex(o) })];
        let mut leaving_kept = NONE;
        for (side, apex) in apexes {
            if side != NONE {
                leaving_kept = self.close_triangle(side, apex, kept).unwrap_or(leaving_kept);
            }
        }
        self.start[kept as usize] = if leaving_kept == NONE { NONE } else { self.first_around(leaving_kept) };
        self.start[gone as usize] = NONE;
        self.live_vertices -= 1;
    }

    /// Gives the corners of the vertex that goes to the one that stays.
    fn move_corners(&mut self, h: u32, gone: u32, kept: u32, tail_goes: bool) {
        let o = self.opposite(h);
        if o == NONE {
            let wedge = self.wedge(if tail_goes { next(h) } else { h });
            let mut at = self.start[gone as usize];
            while at != NONE {
                (self.corners[at as usize].vertex, self.corners[at as usize].wedge) = (kept, wedge);
                at = self.opposite(previous(at));
            }
            return;
        }
        // Counter-clockwise from h: on its left until a curve is crossed, then on its right.
        let (left, right) = (self.wedge(next(h)), self.wedge(o));
        let (mut at, mut wedge) = (h, left);
        loop {
            (self.corners[at as usize].vertex, self.corners[at as usize].wedge) = (kept, wedge);
            at = self.opposite(previous(at));
            if at == NONE || at == h {
                return;
            }
            if self.curve(at) != NONE {
                wedge = right;
            }
        }
    }

    /// Removes the triangle left of `h`, both ends of which are now the kept vertex, and sews its other sides together.
    /// Returns a half-edge that leaves the kept vertex.
    fn close_triangle(&mut self, h: u32, apex: u32, kept: u32) -> Option<u32> {
        let sides = [next(h), previous(h)];
        let [a, b] = sides.map(|s| self.opposite(s));
        let curve = sides.map(|s| self.curve(s)).into_iter().min().unwrap_or(NONE);
        self.link(a, b, curve);
        self.remove_triangle(h / 3);
        let mut leaving_kept = None;
        for side in [a, b].into_iter().filter(|&s| s != NONE) {
            if self.vertex(side) == kept {
                leaving_kept = Some(side);
                self.start[apex as usize] = self.first_around(next(side));
            } else {
                leaving_kept = leaving_kept.or(Some(next(side)));
                self.start[apex as usize] = self.first_around(side);
            }
        }
        leaving_kept
    }
}
