//! Regions of the mesh that a model is compared with: their triangles, their borders, and how deep their triangles are.
//!
//! ```text
//!      θ ↷ ___----___        facets of width w that turn by θ each are w θ / 8 deep in the arc
//!     ●───────w───────●      through their corners
//! ```

use super::Reference;
use crate::brep::Brep;
use glam::DVec3;

/// The triangles of a region, and those of its faces.
pub(super) struct Region {
    pub triangles: Vec<[u32; 3]>,
    pub faces: Vec<u32>,
    /// Vertices of the region's border with the longest border side there, by vertex.
    pub border: Vec<(u32, f64)>,
    /// How deep every triangle is in a surface that bends as it and its neighbours do.
    pub depth: Vec<f64>,
}

impl Region {
    /// The longest border side at a vertex; 0 inside.
    pub fn border_at(&self, v: u32) -> f64 {
        self.border.binary_search_by_key(&v, |b| b.0).map_or(0.0, |k| self.border[k].1)
    }

    /// An arc of facets of width w that turn by θ each is w θ / 8 above their middles.
    fn find_depth(&mut self, points: &[DVec3]) {
        let corners = |t: &[u32; 3]| t.map(|v| points[v as usize]);
        let normal = |t: &[u32; 3]| {
            let [a, b, c] = corners(t);
            (b - a).cross(c - a).normalize_or_zero()
        };
        let mut sides: Vec<([u32; 2], usize)> = Vec::with_capacity(3 * self.triangles.len());
        for (k, t) in self.triangles.iter().enumerate() {
            sides.extend((0..3).map(|i| ([t[i].min(t[(i + 1) % 3]), t[i].max(t[(i + 1) % 3])], k)));
        }
        sides.sort_unstable();
        let mut turn = vec![0.0f64; self.triangles.len()];
        for pair in sides.chunk_by(|a, b| a.0 == b.0).filter(|c| c.len() == 2) {
            let [j, k] = [pair[0].1, pair[1].1];
            let [m, n] = [j, k].map(|t| normal(&self.triangles[t]));
            let angle = m.dot(n).clamp(-1.0, 1.0).acos();
            [j, k].into_iter().for_each(|t| turn[t] = turn[t].max(angle));
        }
        let width = |t: &[u32; 3]| {
            let [a, b, c] = corners(t);
            a.distance(b).max(b.distance(c)).max(c.distance(a))
        };
        self.depth = self.triangles.iter().zip(turn).map(|(t, turn)| width(t) * turn / 8.0).collect();
    }

    fn find_border(&mut self, points: &[DVec3]) {
        let sorted = |a: u32, b: u32| [a.min(b), a.max(b)];
        let mut sides: Vec<[u32; 2]> =
            self.triangles.iter().flat_map(|t| (0..3).map(move |k| sorted(t[k], t[(k + 1) % 3]))).collect();
        sides.sort_unstable();
        let single = sides.chunk_by(|a, b| a == b).filter(|c| c.len() == 1).map(|c| c[0]);
        let length = |s: [u32; 2]| points[s[0] as usize].distance(points[s[1] as usize]);
        let mut ends: Vec<(u32, f64)> = single.flat_map(|s| s.map(|v| (v, length(s)))).collect();
        ends.sort_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)));
        ends.dedup_by_key(|e| e.0);
        self.border = ends;
    }
}

/// Triangles and faces of every region.
pub(super) fn regions(brep: &Brep, reference: &Reference) -> Vec<Region> {
    let faces = brep.faces.iter().filter_map(|f| f.region);
    let count = reference.region_of.iter().copied().chain(faces).max().map_or(0, |m| m as usize + 1);
    let mut out: Vec<Region> = (0..count)
        .map(|_| Region { triangles: Vec::new(), faces: Vec::new(), border: Vec::new(), depth: Vec::new() })
        .collect();
    for (f, face) in brep.faces.iter().enumerate() {
        if let Some(r) = face.region {
            out[r as usize].faces.push(f as u32);
        }
    }
    for (face, &r) in reference.mesh.faces().iter().zip(reference.region_of) {
        let region = &mut out[r as usize];
        region.triangles.extend(fan(face));
    }
    for region in &mut out {
        region.find_border(reference.mesh.points());
        region.find_depth(reference.mesh.points());
    }
    out
}

/// The triangles of a polygon around its first corner.
pub(super) fn fan(face: &[u32]) -> impl Iterator<Item = [u32; 3]> {
    (2..face.len()).map(|k| [face[0], face[k - 1], face[k]])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Strips of a cylinder are as deep in it as its radius less the distance of their middles, and those of a plane are not.
    #[test]
    fn strips_of_a_cylinder_are_as_deep_as_their_arc() {
        for (radius, turn) in [(2.0, 0.3), (5.0, 0.05)] {
            let strip = |k: u32| [2 * k, 2 * k + 2, 2 * k + 1];
            let points: Vec<DVec3> = (0..8u32)
                .map(|k| {
                    let angle = turn * f64::from(k / 2);
                    DVec3::new(radius * angle.cos(), radius * angle.sin(), 1e-3 * f64::from(k % 2))
                })
                .collect();
            let other = |k: u32| [2 * k + 1, 2 * k + 2, 2 * k + 3];
            let triangles = (0..3).flat_map(|k| [strip(k), other(k)]).collect();
            let mut region = Region { triangles, faces: Vec::new(), border: Vec::new(), depth: Vec::new() };
            region.find_depth(&points);
            let depth = radius * (1.0 - (0.5 * turn).cos());
            let middle = region.depth[2];
            assert!((middle / depth - 1.0).abs() < 0.02, "{middle} for {depth}");
            let flat: Vec<DVec3> = points.iter().map(|p| DVec3::new(radius, p.y, p.z)).collect();
            region.find_depth(&flat);
            assert!(region.depth.iter().all(|d| d.abs() < 1e-9), "{:?}", region.depth);
        }
    }
}
