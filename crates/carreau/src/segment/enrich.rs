//! Enrichment (§4.1): a triangle with three sharp vertices has no curvature of its own; a vertex at its centroid gives it
//! one. The vertex goes again at the end.
//!
//! ```text
//!        c                c
//!       ╱ ╲              ╱│╲
//!      ╱   ╲     →      ╱ m ╲        triangles (a,b,m), (b,c,m), (c,a,m)
//!     ╱     ╲          ╱╱   ╲╲
//!    a───────b        a───────b
//! ```

use super::surface::{Sharp, Surface};
use crate::error::Result;
use crate::mesh::SurfaceMesh;

/// A mesh without triangles that have three sharp vertices.
pub struct Enriched {
    pub mesh: SurfaceMesh,
    /// The triangle of the input that each triangle is, or is a part of.
    pub parent: Vec<u32>,
}

/// Enriches a mesh; `None` where there is nothing to do.
pub fn enrich(surface: &Surface<'_>, sharp: &Sharp) -> Result<Option<Enriched>> {
    let t = surface.triangles;
    let closed = |k: u32| sharp.count(t.triangle(k)) == 3 && surface.areas[k as usize] > 0.0;
    if !(0..t.len() as u32).any(closed) {
        return Ok(None);
    }
    let mut points = t.points().to_vec();
    let (mut triangles, mut parent) = (Vec::with_capacity(t.len()), Vec::with_capacity(t.len()));
    for k in 0..t.len() as u32 {
        let [a, b, c] = t.triangle(k);
        if !closed(k) {
            triangles.push([a, b, c]);
            parent.push(k);
            continue;
        }
        let m = points.len() as u32;
        points.push([a, b, c].iter().map(|&v| t.points()[v as usize] / 3.0).sum());
        triangles.extend([[a, b, m], [b, c, m], [c, a, m]]);
        parent.extend([k; 3]);
    }
    Ok(Some(Enriched { mesh: SurfaceMesh::from_triangles(points, &triangles)?, parent }))
}

impl Enriched {
    /// Labels of the input: that of most children, of equally many the lowest.
    pub fn project(&self, label: &[u32], triangles: usize) -> Vec<u32> {
        let mut out = vec![0; triangles];
        let mut k = 0;
        for group in self.parent.chunk_by(|a, b| a == b) {
            let of = &label[k..k + group.len()];
            let votes = |l: u32| of.iter().filter(|&&x| x == l).count();
            let most = of.iter().copied().max_by(|&a, &b| votes(a).cmp(&votes(b)).then(b.cmp(&a)));
            out[group[0] as usize] = most.unwrap_or(0);
            k += group.len();
        }
        out
    }
}
