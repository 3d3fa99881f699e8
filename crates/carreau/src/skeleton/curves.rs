//! Reduces what the flow leaves to curves: edges with triangles are collapsed, shortest first, until no triangle is
//! left (section 4 of the paper).
//!
//! The complex is no surface any more while this goes on: triangles come to lie on each other and become one, edges too.
//! Edges without triangles are curves already and stay. Two of them that would come to lie on each other are a cycle: the
//! edge that would close it waits until all others are done.

use super::flow::Thin;
use crate::mesh::{CurveNet, NONE};
use glam::DVec3;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Curves and what was drawn to them.
pub struct Curves {
    /// The net; radii are not known yet.
    pub net: CurveNet,
    /// The node that every vertex of the source was drawn to.
    pub preimage: Vec<u32>,
}

/// A complex of vertices, edges and triangles.
struct Complex {
    points: Vec<DVec3>,
    /// How many vertices of the surface each stands for; zero for one that is gone.
    count: Vec<f64>,
    /// Neighbours, ascending.
    near: Vec<Vec<u32>>,
    /// Triangles at each vertex, as the other two corners, ascending.
    faces: Vec<Vec<[u32; 2]>>,
    into: Vec<u32>,
}

/// Collapses the thin surface.
pub fn curves(thin: Thin) -> Curves {
    let compact = thin.mesh.compact();
    let points = compact.vertices.iter().map(|&v| thin.mesh.points[v as usize]).collect();
    let mut complex = Complex::new(points, &compact.faces);
    complex.collapse_all();
    let mut number = vec![NONE; thin.mesh.vertex_slots() as usize];
    (0..).zip(&compact.vertices).for_each(|(k, &v)| number[v as usize] = k);
    let alive: Vec<u32> = (0..complex.points.len() as u32).filter(|&v| complex.count[v as usize] > 0.0).collect();
    let mut node = vec![u32::MAX; complex.points.len()];
    (0..).zip(&alive).for_each(|(k, &v)| node[v as usize] = k);
    let edges = alive
        .iter()
        .flat_map(|&v| complex.near[v as usize].iter().filter(move |&&w| v < w).map(move |&w| [v, w]))
        .map(|e| e.map(|v| node[v as usize]))
        .collect();
    let points: Vec<DVec3> = alive.iter().map(|&v| complex.points[v as usize]).collect();
    // A vertex without a triangle is drawn nowhere: it counts for the nearest node.
    let nearest = |p: DVec3| {
        let off = |k: u32| points[k as usize].distance_squared(p);
        (0..points.len() as u32).min_by(|&a, &b| off(a).total_cmp(&off(b))).unwrap_or(0)
    };
    let preimage = thin
        .drawn_to
        .iter()
        .map(|&v| match number[v as usize] {
            NONE => nearest(thin.mesh.points[v as usize]),
            k => node[complex.find(k) as usize],
        })
        .collect();
    let radii = vec![f64::NAN; points.len()];
    Curves { net: CurveNet::new(points, radii, edges), preimage }
}

/// Lengths in the heap: positive numbers compare as their bits do.
type Entry = Reverse<(u64, u32, u32)>;

impl Complex {
    fn new(points: Vec<DVec3>, triangles: &[[u32; 3]]) -> Complex {
        let n = points.len();
        let (mut near, mut faces) = (vec![Vec::new(); n], vec![Vec::new(); n]);
        for t in triangles {
            for k in 0..3 {
                let [a, b, c] = [t[k], t[(k + 1) % 3], t[(k + 2) % 3]];
                near[a as usize].extend([b, c]);
                faces[a as usize].push([b.min(c), b.max(c)]);
            }
        }
        near.iter_mut().for_each(tidy);
        faces.iter_mut().for_each(tidy);
        Complex { points, count: vec![1.0; n], near, faces, into: (0..n as u32).collect() }
    }

    fn entry(&self, a: u32, b: u32) -> Entry {
        let length = self.points[a as usize].distance(self.points[b as usize]);
        Reverse((length.to_bits(), a.min(b), a.max(b)))
    }

    fn has_face(&self, a: u32, b: u32) -> bool {
        self.faces[a as usize].iter().any(|f| f.contains(&b))
    }

    /// Whether two curves would come to lie on each other.
    fn closes_a_curve(&self, a: u32, b: u32) -> bool {
        let is_curve = |v: u32, w: u32| !self.has_face(v, w);
        self.near[a as usize]
            .iter()
            .filter(|&&w| w != b && self.near[b as usize].binary_search(&w).is_ok())
            .any(|&w| is_curve(a, w) && is_curve(b, w))
    }

    fn collapse_all(&mut self) {
        let mut heap: BinaryHeap<Entry> = BinaryHeap::new();
        for v in 0..self.points.len() as u32 {
            heap.extend(self.near[v as usize].iter().filter(|&&w| v < w).map(|&w| self.entry(v, w)));
        }
        let mut waiting: Vec<Entry> = Vec::new();
        loop {
            let Some(entry) = heap.pop() else {
                // Only cycles are left: the shortest of them gives way.
                waiting.sort_unstable_by(|a, b| b.cmp(a));
                let Some(forced) = waiting.iter().position(|e| self.is_due(*e)) else { return };
                let Reverse((_, a, b)) = waiting.remove(forced);
                self.collapse(a, b, &mut heap);
                heap.extend(waiting.drain(..));
                continue;
            };
            if !self.is_due(entry) {
                continue;
            }
            let Reverse((_, a, b)) = entry;
            if self.closes_a_curve(a, b) {
                waiting.push(entry);
            } else {
                self.collapse(a, b, &mut heap);
            }
        }
    }

    /// Whether an entry is that of an edge which is there, of that length, and has a triangle.
    fn is_due(&self, entry: Entry) -> bool {
        let Reverse((_, a, b)) = entry;
        self.near[a as usize].binary_search(&b).is_ok() && entry == self.entry(a, b) && self.has_face(a, b)
    }

    /// `b` goes into `a`, at the mean of what both stand for.
    fn collapse(&mut self, a: u32, b: u32, heap: &mut BinaryHeap<Entry>) {
        let [i, j] = [a, b].map(|v| v as usize);
        let (na, nb) = (self.count[i], self.count[j]);
        self.points[i] = (self.points[i] * na + self.points[j] * nb) / (na + nb);
        (self.count[i], self.count[j]) = (na + nb, 0.0);
        self.into[j] = a;
        let moved = |v: u32| if v == b { a } else { v };
        for w in std::mem::take(&mut self.near[j]) {
            let list = &mut self.near[w as usize];
            list.iter_mut().for_each(|v| *v = moved(*v));
            list.retain(|&v| v != w);
            tidy(list);
            if w != a {
                self.near[i].push(w);
            }
        }
        self.near[i].retain(|&w| w != a && w != b);
        tidy(&mut self.near[i]);
        for f in std::mem::take(&mut self.faces[j]) {
            for w in f {
                let list = &mut self.faces[w as usize];
                list.iter_mut().for_each(|g| *g = sorted(g.map(moved)));
                list.retain(|g| g[0] != g[1] && !g.contains(&w));
                tidy(list);
            }
            if !f.contains(&a) {
                self.faces[i].push(f);
            }
        }
        self.faces[i].retain(|f| !f.contains(&a) && !f.contains(&b));
        tidy(&mut self.faces[i]);
        heap.extend(self.near[i].iter().map(|&w| self.entry(a, w)));
    }

    fn find(&self, mut v: u32) -> u32 {
        while self.into[v as usize] != v {
            v = self.into[v as usize];
        }
        v
    }
}

fn sorted([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

fn tidy<T: Ord>(list: &mut Vec<T>) {
    list.sort_unstable();
    list.dedup();
}
