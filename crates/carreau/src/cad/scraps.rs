//! Scraps: a few triangles beside a border that were given to the wrong piece, or are a piece of their own by chance.
//!
//! ```text
//!     ──────●──────●──────●───    border of A and B: a triangle with all corners there lies on both,
//!      A     ╲ S  ╱ ╲    ╱  B     and noise makes a piece S of it
//!             ╲  ╱   ╲  ╱
//! ```

use super::clean::CERTAIN_TRIANGLES;
use super::regions::{Map, area_vector, inner_vertices, vertex_ids, vertices};
use super::tuning::FILE_PRECISION;
use glam::DVec3;

/// Cosine of 45°, the largest angle between facets and the surface that they are to lie on, because noise tilts narrow
/// facets.
pub const SCRAP_TILT: f64 = 0.7;

impl Map<'_> {
    /// In noisy data, gives pieces without a vertex of their own to the neighbours on whose surfaces they lie within the noise.
    pub fn absorb_scraps(&mut self) {
        if !self.is_noisy() {
            return;
        }
        let inner = inner_vertices(self.t, &self.label);
        for p in 0..self.pieces.len() as u32 {
            let piece = &self.pieces[p as usize];
            // A flat lid has no vertex inside either, but noise leaves nothing exact.
            if piece.primitive.is_some()
                && piece.triangles.len() >= CERTAIN_TRIANGLES
                && piece.max <= FILE_PRECISION * self.diagonal
            {
                continue;
            }
            let triangles = piece.triangles.clone();
            if vertex_ids(self.t, &triangles).iter().any(|&v| inner[v as usize]) {
                continue;
            }
            if let Some(home) = self.home(p, &triangles, self.tolerance) {
                self.give(p, &triangles, home);
            }
        }
        self.compact();
    }

    /// The neighbour on whose surface triangles of a piece lie within a distance and which faces their way: the nearest.
    pub fn home(&self, of: u32, triangles: &[u32], within: f64) -> Option<u32> {
        let around = self.labels_beside(triangles.iter().copied()).into_iter().filter(|&p| p != of);
        let points = vertices(self.t, triangles);
        let middle = points.iter().sum::<DVec3>() / points.len().max(1) as f64;
        let facing = triangles.iter().map(|&k| area_vector(self.t, k)).sum::<DVec3>().normalize_or_zero();
        let far = |p: u32| {
            let surface = self.pieces[p as usize].primitive?;
            let aligned = surface.normal(middle).dot(facing).abs() > SCRAP_TILT;
            let far = points.iter().map(|&q| surface.distance(q).abs()).fold(0.0, f64::max);
            (aligned && far <= within).then_some((far, p))
        };
        around.filter_map(far).min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))).map(|f| f.1)
    }

    /// Gives triangles of a piece to another one.
    pub fn give(&mut self, from: u32, triangles: &[u32], to: u32) {
        triangles.iter().for_each(|&k| self.label[k as usize] = to);
        self.pieces[from as usize].triangles.retain(|k| triangles.binary_search(k).is_err());
        let piece = &mut self.pieces[to as usize];
        piece.triangles.extend(triangles);
        piece.triangles.sort_unstable();
    }
}
