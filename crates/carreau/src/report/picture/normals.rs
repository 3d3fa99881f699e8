//! Normals at the corners of triangles, averaged across smooth edges only.

use crate::mesh::{HalfEdges, Polygons};
use glam::DVec3;

/// Unit normals of triangles; zero where a triangle has no area.
pub(super) fn flat(points: &[DVec3], triangles: &[[u32; 3]]) -> Vec<DVec3> {
    let normal = |[a, b, c]: [DVec3; 3]| {
        let n = (b - a).cross(c - a);
        // Scaled first: the squares of a small triangle's sides may be too small for their squares to be normalised.
        (n / n.abs().max_element()).try_normalize().unwrap_or_default()
    };
    triangles.iter().map(|t| normal(t.map(|v| points[v as usize]))).collect()
}

/// Unit normals at the corners of triangles: the mean of the triangles that meet at the vertex without a crease in
/// between, weighted by their angles there.
pub(super) fn smooth(points: &[DVec3], triangles: &[[u32; 3]], flat: &[DVec3], crease: f64) -> Vec<[DVec3; 3]> {
    let mut sectors = Sectors::new(3 * triangles.len());
    let limit = crease.to_radians().cos();
    for edge in HalfEdges::new(&Polygons::from_triangles(triangles), points.len()).groups() {
        let mut corners = edge.corners().map(|c| c as usize);
        if let (2, Some(c), Some(d)) = (edge.len(), corners.next(), corners.next()) {
            let opposed = triangles.as_flattened()[c] != triangles.as_flattened()[d];
            if opposed && flat[c / 3].dot(flat[d / 3]) >= limit {
                sectors.join(c, next(d));
                sectors.join(next(c), d);
            }
        }
    }
    let mut sums = vec![DVec3::ZERO; 3 * triangles.len()];
    for (f, t) in triangles.iter().enumerate() {
        for k in 0..3 {
            sums[sectors.root(3 * f + k)] += flat[f] * angle(t.map(|v| points[v as usize]), k);
        }
    }
    (0..triangles.len())
        .map(|f| [0, 1, 2].map(|k| sums[sectors.root(3 * f + k)].try_normalize().unwrap_or(flat[f])))
        .collect()
}

fn next(corner: usize) -> usize {
    if corner % 3 == 2 { corner - 2 } else { corner + 1 }
}

/// Angle of a triangle at corner `k`; zero where it has none.
fn angle(p: [DVec3; 3], k: usize) -> f64 {
    let (u, v) = (p[(k + 1) % 3] - p[k], p[(k + 2) % 3] - p[k]);
    u.cross(v).length().atan2(u.dot(v))
}

/// Corners that share a normal: disjoint sets.
struct Sectors(Vec<u32>);

impl Sectors {
    fn new(corners: usize) -> Self {
        Sectors((0..corners as u32).collect())
    }

    fn root(&mut self, mut corner: usize) -> usize {
        while self.0[corner] as usize != corner {
            let above = self.0[self.0[corner] as usize];
            self.0[corner] = above;
            corner = above as usize;
        }
        corner
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b)] = a.min(b) as u32;
    }
}
