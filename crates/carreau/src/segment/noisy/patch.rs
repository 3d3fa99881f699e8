//! Patches of triangles around a seed, ring by ring, and their vertices.

use crate::mesh::NONE;
use crate::segment::surface::Surface;
use glam::DVec3;

/// A patch, and the memory to find the next.
pub struct Patches<'a> {
    surface: &'a Surface<'a>,
    /// The triangles, in the order they were reached.
    pub triangles: Vec<u32>,
    /// Their distinct vertices and mean normals there over the patch alone.
    pub points: Vec<DVec3>,
    pub normals: Vec<DVec3>,
    // Marks by stamp, so that nothing is cleared between patches.
    triangle_stamp: Vec<u32>,
    vertex_stamp: Vec<u32>,
    slot: Vec<u32>,
    stamp: u32,
}

impl<'a> Patches<'a> {
    pub fn new(surface: &'a Surface<'a>) -> Self {
        let vertices = surface.triangles.points().len();
        Patches {
            surface,
            triangles: Vec::new(),
            points: Vec::new(),
            normals: Vec::new(),
            triangle_stamp: vec![0; surface.len()],
            vertex_stamp: vec![0; vertices],
            slot: vec![0; vertices],
            stamp: 0,
        }
    }

    /// The first `size` triangles around a seed, over half-edges that are no barrier.
    pub fn around(&mut self, seed: u32, size: usize, barrier: &dyn Fn(u32) -> bool) {
        self.reach(seed, size, &|c, _| !barrier(c));
        self.gather();
    }

    /// The triangles connected with a seed over half-edges to triangles that may be entered, at most `size`.
    pub fn reach(&mut self, seed: u32, size: usize, enters: &dyn Fn(u32, u32) -> bool) {
        self.stamp += 1;
        self.triangles.clear();
        self.triangles.push(seed);
        self.triangle_stamp[seed as usize] = self.stamp;
        let mut next = 0;
        while next < self.triangles.len() {
            let k = self.triangles[next];
            next += 1;
            for c in 3 * k..3 * k + 3 {
                let o = self.surface.triangles.opposite(c);
                if o == NONE || self.triangle_stamp[o as usize / 3] == self.stamp || !enters(c, o / 3) {
                    continue;
                }
                if self.triangles.len() == size {
                    return;
                }
                self.triangle_stamp[o as usize / 3] = self.stamp;
                self.triangles.push(o / 3);
            }
        }
    }

    /// Collects the vertices of the triangles.
    pub fn gather(&mut self) {
        let triangles = std::mem::take(&mut self.triangles);
        self.gather_of(&triangles);
        self.triangles = triangles;
    }

    /// Collects the vertices of any triangles.
    pub fn gather_of(&mut self, triangles: &[u32]) {
        self.stamp += 1;
        self.points.clear();
        self.normals.clear();
        let t = self.surface.triangles;
        for &k in triangles {
            let normal = self.surface.normals[k as usize] * self.surface.areas[k as usize];
            for v in t.triangle(k) {
                if self.vertex_stamp[v as usize] != self.stamp {
                    self.vertex_stamp[v as usize] = self.stamp;
                    self.slot[v as usize] = self.points.len() as u32;
                    self.points.push(t.points()[v as usize]);
                    self.normals.push(DVec3::ZERO);
                }
                self.normals[self.slot[v as usize] as usize] += normal;
            }
        }
        self.normals.iter_mut().for_each(|n| *n = n.normalize_or_zero());
    }

    /// Keeps at most this many of the points, evenly.
    pub fn thin(&mut self, most: usize) {
        let n = self.points.len();
        if n > most {
            for k in 0..most {
                (self.points[k], self.normals[k]) = (self.points[k * n / most], self.normals[k * n / most]);
            }
            self.points.truncate(most);
            self.normals.truncate(most);
        }
    }
}
