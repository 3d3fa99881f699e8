//! Normals and points without noise, at the scale of the sizes.

use super::curves::Rank;
use super::rings::Rings;
use super::support::Support;
use crate::geometry::normals::unit;
use crate::mesh::triangle_area_vector;
use glam::DVec3;
use rayon::prelude::*;

impl Support {
    /// Smooths the normals at the scale of the sizes: a wedge takes part in as many rounds of averaging over its
    /// triangles as it needs for a kernel of about `share` sizes.
    pub fn fit_normals(&mut self, share: f64, most: usize) {
        let mesh = &self.mesh;
        self.normal.clone_from(&self.raw_normal);
        let at_vertex = rounds(&self.rings, &self.size, share, most);
        let mut rounds = vec![0u8; self.normal.len()];
        for h in 0..mesh.half_edge_slots() {
            rounds[mesh.wedge(h) as usize] = at_vertex[mesh.vertex(h) as usize];
        }
        let longest = at_vertex.iter().copied().max().unwrap_or(0);
        let areas: Vec<f64> = (0..mesh.triangle_slots())
            .into_par_iter()
            .map(|t| {
                let [a, b, c] = mesh.positions(t);
                triangle_area_vector(a, b, c).length()
            })
            .collect();
        for round in 0..longest {
            let mean = |t: u32| {
                let sum: DVec3 = (3 * t..3 * t + 3).map(|h| self.normal[mesh.wedge(h) as usize]).sum();
                areas[t as usize] * unit(sum)
            };
            let of_triangle: Vec<DVec3> = (0..mesh.triangle_slots()).into_par_iter().map(mean).collect();
            let mut sum = vec![DVec3::ZERO; self.normal.len()];
            for h in 0..mesh.half_edge_slots() {
                sum[mesh.wedge(h) as usize] += of_triangle[h as usize / 3];
            }
            for (k, n) in self.normal.iter_mut().enumerate().filter(|(k, _)| rounds[*k] > round) {
                let smooth = unit(sum[k]);
                if smooth != DVec3::ZERO {
                    *n = smooth;
                }
            }
        }
    }

    /// Takes the noise out of the positions of free vertices, at the scale of the sizes: rounds of Taubin's λ|μ smoothing,
    /// which keep the shape (Taubin 1995). No vertex moves farther than `most` sizes.
    pub fn fit_points(&mut self, rank: &[Rank], share: f64, most: f64) {
        let mesh = &self.mesh;
        let rounds = rounds(&self.rings, &self.size, share, 4);
        let longest = rounds.iter().copied().max().unwrap_or(0);
        let mut points = mesh.points.clone();
        for round in 0..longest {
            for factor in [0.5, -0.53] {
                let moved = |v: u32| {
                    let p = points[v as usize];
                    if rounds[v as usize] <= round || rank[v as usize] != Rank::Free || !mesh.is_vertex(v) {
                        return p;
                    }
                    let ring = self.rings.of(v);
                    let sum: DVec3 = ring.iter().map(|&w| points[w as usize] - p).sum();
                    p + sum * (factor / ring.len() as f64)
                };
                points = (0..mesh.vertex_slots()).into_par_iter().map(moved).collect();
            }
        }
        for (v, p) in points.into_iter().enumerate() {
            let way = p - mesh.points[v];
            // Along the normal only: sliding would change triangles, not the surface.
            let n = self.normal[v];
            let way = n * n.dot(way);
            self.fitted[v] = mesh.points[v] + way.clamp_length_max(most * self.size[v]);
        }
    }
}

/// Rounds of averaging over neighbours that make a kernel of about `share` sizes at every vertex, up to a limit.
pub fn rounds(rings: &Rings, size: &[f64], share: f64, most: usize) -> Vec<u8> {
    let at = |v: u32| {
        let lengths = rings.lengths(v);
        let (sum, count) = (lengths.iter().map(|l| l * l).sum::<f64>(), lengths.len() as f64);
        // One round has a variance of about half the squared edge length.
        let scale = share * size[v as usize];
        let wanted = scale * scale * count / (0.5 * sum).max(f64::MIN_POSITIVE);
        wanted.round().min(most as f64) as u8
    };
    (0..rings.len()).into_par_iter().map(at).collect()
}
