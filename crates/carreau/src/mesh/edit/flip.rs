//! An edge becomes the other diagonal of its two triangles.
//!
//! ```text
//!      c               c
//!     ╱ ╲             ╱│╲
//!    ╱   ╲           ╱ │ ╲
//!   a──h─→b    →    a  h  b
//!    ╲   ╱           ╲ ↓ ╱
//!     ╲ ╱             ╲│╱
//!      d               d
//! ```

use super::edit_mesh::{EditMesh, next, previous};
use crate::mesh::triangles::NONE;

impl EditMesh {
    /// Whether the topology allows it: an inner edge on no curve, whose apexes are not joined already, and
    /// could not be joined elsewhere, as copies could.
    pub fn can_flip(&self, h: u32) -> bool {
        let o = self.opposite(h);
        if o == NONE || self.curve(h) != NONE {
            return false;
        }
        let (c, d) = (self.apex(h), self.apex(o));
        c != d && !self.are_neighbours(c, d) && !self.may_double(c, d)
    }

    /// Flips an edge for which [`EditMesh::can_flip`] is true; afterwards `h` runs from c to d.
    pub fn flip(&mut self, h: u32) {
        let o = self.opposite(h);
        let [n, p, no, po] = [next(h), previous(h), next(o), previous(o)];
        let [at_h, at_n, at_p] = [h, n, p].map(|x| self.corners[x as usize]);
        let [_, at_no, at_po] = [o, no, po].map(|x| self.corners[x as usize]);
        let [a, b, c, d] = [at_h, at_n, at_p, at_po];
        for (slot, corner) in [(h, c), (n, d), (p, b), (o, d), (no, c), (po, a)] {
            (self.corners[slot as usize].vertex, self.corners[slot as usize].wedge) = (corner.vertex, corner.wedge);
        }
        self.link(h, o, NONE);
        for (slot, side) in [(n, at_po), (p, at_n), (no, at_p), (po, at_no)] {
            self.link(slot, side.opposite, side.curve);
        }
        // Half-edges that left a vertex now lie in another slot.
        let moved = [(a.vertex, [h, no], po), (b.vertex, [o, n], p), (c.vertex, [p, p], no), (d.vertex, [po, po], n)];
        for (v, old, new) in moved {
            if old.contains(&self.start[v as usize]) {
                self.start[v as usize] = new;
            }
        }
    }
}
