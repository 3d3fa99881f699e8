//! Splits that a field with features needs: every triangle has one feature edge at most, and every other edge touches the
//! features with one end at most.
//!
//! ```text
//!        c                c                   c                    c
//!       ╱ ╲              ╱│╲                 ╱ ╲                  ╱│╲
//!      ╱   ╲     →      ╱ m ╲               ╱   ╲       →        ╱ │ ╲
//!     a━━━━━b          a━━━━━b             a─────b              a──m──b
//!     two or three sides are features      a and b are on features, ab is none
//! ```
//!
//! After that a sector between two features has an edge to cross, and such edges belong to one sector alone.

use crate::error::Result;
use crate::geometry::features::Features;
use crate::mesh::{CornerId, SurfaceMesh};
use glam::DVec3;
use rustc_hash::{FxHashMap, FxHashSet};

/// A mesh ready for a field.
pub struct Conditioned {
    pub mesh: SurfaceMesh,
    /// For every corner whether the half-edge that leaves it lies on a feature.
    pub feature: Vec<bool>,
    /// Triangle of the input that every triangle is a part of.
    pub source: Vec<u32>,
}

fn key(a: u32, b: u32) -> (u32, u32) {
    (a.min(b), a.max(b))
}

/// Triangles that are being divided.
struct Division {
    points: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    source: Vec<u32>,
    features: FxHashSet<(u32, u32)>,
}

/// Splits what has to be split.
pub fn condition(mesh: &SurfaceMesh, features: &Features) -> Result<Conditioned> {
    let triangles = mesh.faces().fan().0;
    let ends = |c: usize| {
        let c = CornerId::new(c);
        key(mesh.vertex(c).0, mesh.vertex(mesh.next(c)).0)
    };
    let listed = (0..mesh.corner_count()).filter(|&c| features.corners[c]).map(ends).collect();
    let mut division = Division {
        points: mesh.points().to_vec(),
        source: (0..triangles.len() as u32).collect(),
        triangles,
        features: listed,
    };
    division.split_at_centers();
    division.split_edges();
    division.finish()
}

impl Division {
    fn is_feature(&self, t: [u32; 3], k: usize) -> bool {
        self.features.contains(&key(t[k], t[(k + 1) % 3]))
    }

    /// Triangles with two and three feature edges.
    fn split_at_centers(&mut self) {
        for k in 0..self.triangles.len() {
            let t = self.triangles[k];
            if (0..3).filter(|&side| self.is_feature(t, side)).count() < 2 {
                continue;
            }
            let m = self.points.len() as u32;
            self.points.push(t.iter().map(|&v| self.points[v as usize]).sum::<DVec3>() / 3.0);
            self.triangles[k] = [t[0], t[1], m];
            for side in [1, 2] {
                self.triangles.push([t[side], t[(side + 1) % 3], m]);
                self.source.push(self.source[k]);
            }
        }
    }

    /// Edges from feature to feature that are none.
    fn split_edges(&mut self) {
        let mut on_feature = vec![false; self.points.len()];
        for &(a, b) in &sorted(&self.features) {
            (on_feature[a as usize], on_feature[b as usize]) = (true, true);
        }
        let mut middle: FxHashMap<(u32, u32), u32> = FxHashMap::default();
        for k in 0..self.triangles.len() {
            let t = self.triangles[k];
            let mut m = [None; 3];
            for side in 0..3 {
                let (a, b) = (t[side], t[(side + 1) % 3]);
                if on_feature[a as usize] && on_feature[b as usize] && !self.is_feature(t, side) {
                    m[side] = Some(*middle.entry(key(a, b)).or_insert_with(|| {
                        self.points.push((self.points[a as usize] + self.points[b as usize]) / 2.0);
                        self.points.len() as u32 - 1
                    }));
                }
            }
            let mut parts = parts(t, m).into_iter();
            self.triangles[k] = parts.next().unwrap_or(t);
            for part in parts {
                self.triangles.push(part);
                self.source.push(self.source[k]);
            }
        }
    }

    fn finish(self) -> Result<Conditioned> {
        let mesh = SurfaceMesh::from_triangles(self.points, &self.triangles)?;
        let is_feature =
            |c: usize| self.features.contains(&key(self.triangles[c / 3][c % 3], self.triangles[c / 3][(c + 1) % 3]));
        let feature = (0..3 * self.triangles.len()).map(is_feature).collect();
        Ok(Conditioned { mesh, feature, source: self.source })
    }
}

fn sorted(set: &FxHashSet<(u32, u32)>) -> Vec<(u32, u32)> {
    let mut all: Vec<(u32, u32)> = set.iter().copied().collect();
    all.sort_unstable();
    all
}

/// The parts of a triangle with the middles of some sides.
fn parts(t: [u32; 3], m: [Option<u32>; 3]) -> Vec<[u32; 3]> {
    let turned = |k: usize| ([t[k], t[(k + 1) % 3], t[(k + 2) % 3]], [m[k], m[(k + 1) % 3], m[(k + 2) % 3]]);
    match m.iter().flatten().count() {
        0 => vec![t],
        1 => {
            let k = (0..3).find(|&k| m[k].is_some()).unwrap_or(0);
            let ([a, b, c], [m, ..]) = turned(k);
            let m = m.unwrap_or(a);
            vec![[a, m, c], [m, b, c]]
        }
        2 => {
            // The side without a middle comes last.
            let k = (0..3).find(|&k| m[(k + 2) % 3].is_none()).unwrap_or(0);
            let ([a, b, c], [m, n, _]) = turned(k);
            let (m, n) = (m.unwrap_or(a), n.unwrap_or(b));
            vec![[m, b, n], [a, m, n], [a, n, c]]
        }
        _ => {
            let [x, y, z] = m.map(|m| m.unwrap_or(t[0]));
            vec![[t[0], x, z], [x, t[1], y], [z, y, t[2]], [x, y, z]]
        }
    }
}
