//! Flat regions as faces: connected parts with their borders, cut where a border passes a vertex twice or crosses itself.
//!
//! ```text
//!   ┌─────────┐         a ─ b ─ c
//!   │  ┌───┐  │         │ ╱ │ ╲ │      b is passed twice: cut through b
//!   │  │   │  │  hole   d ─ · ─ e
//!   │  └───┘  │
//!   └─────────┘
//! ```

use super::piece::Outline;
use super::simple::are_simple;
use crate::mesh::{NONE, Triangles};
use glam::{DVec2, DVec3};
use rustc_hash::FxHashSet;

/// A connected part of a flat region: its triangles, and its borders, the outer one first.
pub struct Part {
    pub triangles: Vec<u32>,
    pub loops: Vec<Outline>,
}

/// Cuts sets of triangles in one plane into parts that can be faces; single triangles have no loops.
pub struct Parts<'a> {
    triangles: Triangles<'a>,
    /// The set that a triangle is in while it is looked at.
    set_of: Vec<u32>,
    sets: u32,
}

impl<'a> Parts<'a> {
    pub fn new(triangles: Triangles<'a>) -> Self {
        Parts { triangles, set_of: vec![NONE; triangles.len()], sets: 0 }
    }

    /// All parts of a set of triangles in a plane with this normal.
    pub fn cut(&mut self, set: Vec<u32>, normal: DVec3) -> Vec<Part> {
        let axis = normal.any_orthonormal_vector();
        let frame = [axis, normal.cross(axis)];
        let mut out = Vec::new();
        let mut open = self.connected(set);
        open.reverse();
        while let Some(set) = open.pop() {
            if set.len() == 1 {
                out.push(Part { triangles: set, loops: Vec::new() });
                continue;
            }
            match self.loops(&set, frame) {
                Ok(loops) => out.push(Part { triangles: set, loops }),
                Err(at) => {
                    let halves = self.halves(set, frame, at);
                    open.extend(halves.into_iter().flat_map(|half| self.connected(half)).rev());
                }
            }
        }
        out
    }

    /// Connected sets, each by its first triangle.
    fn connected(&mut self, set: Vec<u32>) -> Vec<Vec<u32>> {
        self.sets += 1;
        let waiting = self.sets;
        set.iter().for_each(|&t| self.set_of[t as usize] = waiting);
        let mut out = Vec::new();
        for seed in set {
            if self.set_of[seed as usize] != waiting {
                continue;
            }
            self.sets += 1;
            self.set_of[seed as usize] = self.sets;
            let mut part = vec![seed];
            let mut next = 0;
            while next < part.len() {
                let t = part[next];
                next += 1;
                for c in 3 * t..3 * t + 3 {
                    let o = self.triangles.opposite(c);
                    if o != NONE && self.set_of[(o / 3) as usize] == waiting {
                        self.set_of[(o / 3) as usize] = self.sets;
                        part.push(o / 3);
                    }
                }
            }
            part.sort_unstable();
            out.push(part);
        }
        out
    }

    /// The borders of a connected set, or where they touch themselves (`None` where that is unknown).
    fn loops(&mut self, set: &[u32], [x, y]: [DVec3; 2]) -> Result<Vec<Outline>, Option<DVec2>> {
        self.sets += 1;
        let own = self.sets;
        set.iter().for_each(|&t| self.set_of[t as usize] = own);
        let border = |c: u32| {
            let o = self.triangles.opposite(c);
            o == NONE || self.set_of[(o / 3) as usize] != own
        };
        let flat = |v: u32| {
            let p = self.triangles.points()[v as usize];
            DVec2::new(p.dot(x), p.dot(y))
        };
        let (mut done, mut passed) = (FxHashSet::default(), FxHashSet::default());
        let mut loops: Vec<Vec<u32>> = Vec::new();
        for start in set.iter().flat_map(|&t| 3 * t..3 * t + 3).filter(|&c| border(c)) {
            if done.contains(&start) {
                continue;
            }
            let mut vertices = Vec::new();
            let mut c = start;
            while done.insert(c) {
                let v = self.triangles.vertex(c);
                if !passed.insert(v) {
                    return Err(Some(flat(v)));
                }
                vertices.push(v);
                c = self.triangles.next(c);
                while !border(c) {
                    c = self.triangles.next(self.triangles.opposite(c));
                }
            }
            loops.push(vertices);
        }
        let polygons: Vec<Vec<DVec2>> = loops.iter().map(|l| l.iter().map(|&v| flat(v)).collect()).collect();
        let outer: Vec<usize> = (0..loops.len()).filter(|&k| area(&polygons[k]) > 0.0).collect();
        let [outer] = outer[..] else { return Err(None) };
        if !are_simple(&polygons) {
            return Err(None);
        }
        loops.swap(0, outer);
        Ok(loops.into_iter().map(Outline::of_plane).collect())
    }

    /// Two sets on both sides of a line through a point, or through the middle.
    fn halves(&self, mut set: Vec<u32>, [x, y]: [DVec3; 2], at: Option<DVec2>) -> [Vec<u32>; 2] {
        let middle = |t: u32| -> DVec2 {
            let sum: DVec3 = self.triangles.triangle(t).iter().map(|&v| self.triangles.points()[v as usize]).sum();
            DVec2::new(sum.dot(x), sum.dot(y)) / 3.0
        };
        let bounds = set.iter().map(|&t| middle(t));
        let (low, high) = bounds.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
        let longer = usize::from((high - low).y > (high - low).x);
        if let Some(at) = at {
            for axis in [longer, 1 - longer] {
                let halves: (Vec<u32>, Vec<u32>) = set.iter().partition(|&&t| middle(t)[axis] < at[axis]);
                if !halves.0.is_empty() && !halves.1.is_empty() {
                    return [halves.0, halves.1];
                }
            }
        }
        set.sort_by(|&a, &b| middle(a)[longer].total_cmp(&middle(b)[longer]));
        let rest = set.split_off(set.len() / 2);
        [set, rest]
    }
}

/// Twice the signed area of a polygon, about its first corner.
fn area(polygon: &[DVec2]) -> f64 {
    let a = polygon[0];
    polygon.windows(2).map(|w| (w[0] - a).perp_dot(w[1] - a)).sum()
}
