//! An edge gets a vertex.
//!
//! ```text
//!      c                c
//!     ╱ ╲              ╱│╲
//!    ╱   ╲            ╱ │ ╲
//!   a──h─→b    →     a─→m──b      h runs from a to m now
//!    ╲   ╱            ╲ │ ╱
//!     ╲ ╱              ╲│╱
//!      d                d
//! ```

use super::edit_mesh::{EditMesh, next, previous};
use crate::mesh::triangles::NONE;
use glam::DVec3;

impl EditMesh {
    /// Splits an edge at a point; `wedges` are those of the new corners on the left and on the right of `h`. Returns the
    /// new vertex. Both halves lie on the curve of the edge.
    pub fn split(&mut self, h: u32, point: DVec3, wedges: [u32; 2]) -> u32 {
        let m = self.points.len() as u32;
        self.points.push(point);
        self.origin.push(NONE);
        self.live_vertices += 1;
        let (o, curve) = (self.opposite(h), self.curve(h));
        let left = 3 * self.new_triangle();
        self.source[left as usize / 3] = self.source[h as usize / 3];
        // Left: (a, b, c) becomes (a, m, c), and (m, b, c) is new.
        let (n, p) = (next(h), previous(h));
        let (at_n, at_p) = (self.corner(n), self.corner(p));
        self.put(left, m, wedges[0]);
        self.put(left + 1, at_n.vertex, at_n.wedge);
        self.put(left + 2, at_p.vertex, at_p.wedge);
        self.put(n, m, wedges[0]);
        self.link(left + 1, at_n.opposite, at_n.curve);
        self.link(n, left + 2, NONE);
        if self.start[at_n.vertex as usize] == n {
            self.start[at_n.vertex as usize] = left + 1;
        }
        self.start.push(left);
        if o == NONE {
            self.link(left, NONE, curve);
            return m;
        }
        // Right: (b, a, d) becomes (m, a, d), and (b, m, d) is new.
        let right = 3 * self.new_triangle();
        self.source[right as usize / 3] = self.source[o as usize / 3];
        let po = previous(o);
        let (at_o, at_po) = (self.corner(o), self.corner(po));
        self.put(right, at_o.vertex, at_o.wedge);
        self.put(right + 1, m, wedges[1]);
        self.put(right + 2, at_po.vertex, at_po.wedge);
        self.put(o, m, wedges[1]);
        self.link(right + 2, at_po.opposite, at_po.curve);
        self.link(po, right + 1, NONE);
        self.link(left, right, curve);
        for (v, old, new) in [(at_o.vertex, o, right), (at_po.vertex, po, right + 2)] {
            if self.start[v as usize] == old {
                self.start[v as usize] = new;
            }
        }
        m
    }

    fn put(&mut self, slot: u32, vertex: u32, wedge: u32) {
        let corner = &mut self.corners[slot as usize];
        (corner.vertex, corner.wedge) = (vertex, wedge);
    }
}
