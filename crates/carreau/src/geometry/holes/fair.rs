//! Vertices where the surface goes on: the thin plate through the border and the faces around it, K x = 0 with K = Lᵀ M⁻¹ L, where L
//! is the Laplacian with weights 1 / length and M holds their sums. Vertices of the mesh stay; the ring next to the border tells how
//! the surface runs into it.

use super::patch::Patch;
use super::refine::place;
use crate::context::Context;
use crate::error::Result;
use crate::mesh::SurfaceMesh;
use crate::numeric::sparse::LeastSquares;
use glam::DVec3;
use rustc_hash::{FxHashMap, FxHashSet};

/// Faces about a hole that leave a plane by less than this share of its size are in it.
const PLANE: f64 = 1e-9;

/// Moves the patch's own vertices.
pub fn fair(patch: &mut Patch, mesh: &SurfaceMesh, ring: &[u32], first: u32, context: &Context) -> Result<()> {
    if patch.points.is_empty() {
        return Ok(());
    }
    let around = neighbours(mesh, ring);
    if is_plane(mesh, ring, &around) {
        return Ok(());
    }
    // Links of the patch, and those of the faces around.
    let mut links: FxHashSet<[u32; 2]> = around.into_iter().collect();
    for t in &patch.triangles {
        links.extend((0..3).map(|k| [t[k].min(t[(k + 1) % 3]), t[k].max(t[(k + 1) % 3])]));
    }
    let mut links: Vec<[u32; 2]> = links.into_iter().collect();
    links.sort_unstable();
    let at = |v: u32| place(patch, mesh, first, v);
    let mean = links.iter().map(|&[a, b]| at(a).distance(at(b))).sum::<f64>() / links.len() as f64;
    let mut of: FxHashMap<u32, Vec<(u32, f64)>> = FxHashMap::default();
    for &[a, b] in &links {
        let weight = mean / at(a).distance(at(b)).max(1e-3 * mean);
        of.entry(a).or_default().push((b, weight));
        of.entry(b).or_default().push((a, weight));
    }
    // A square for every vertex of the patch and its border: (Σ w (x_j − x_i))² / Σ w.
    let mut centres: Vec<u32> = ring.iter().copied().chain((0..patch.points.len() as u32).map(|k| first + k)).collect();
    centres.sort_unstable();
    context.check()?;
    let mut solved = [Vec::new(), Vec::new(), Vec::new()];
    let mut plan = None;
    for (axis, place) in solved.iter_mut().enumerate() {
        let mut squares = LeastSquares::new(patch.points.len());
        for &v in &centres {
            let Some(links) = of.get(&v) else { continue };
            let sum: f64 = links.iter().map(|l| l.1).sum();
            let (mut terms, mut rest) = (Vec::new(), 0.0);
            let mut take = |u: u32, w: f64| match u.checked_sub(first) {
                Some(k) => terms.push((k, w)),
                None => rest += w * mesh.points()[u as usize][axis],
            };
            take(v, -sum);
            links.iter().for_each(|&(u, w)| take(u, w));
            squares.add(1.0 / sum, &terms, rest);
        }
        *place = squares.solve(&mut plan)?;
    }
    for (k, p) in patch.points.iter_mut().enumerate() {
        *p = DVec3::new(solved[0][k], solved[1][k], solved[2][k]);
    }
    Ok(())
}

/// The edges of the faces at a ring of vertices.
fn neighbours(mesh: &SurfaceMesh, ring: &[u32]) -> Vec<[u32; 2]> {
    let on: FxHashSet<u32> = ring.iter().copied().collect();
    let mut links = Vec::new();
    for face in mesh.faces().iter().filter(|f| f.iter().any(|v| on.contains(v))) {
        links.extend((0..face.len()).map(|k| {
            let [a, b] = [face[k], face[(k + 1) % face.len()]];
            [a.min(b), a.max(b)]
        }));
    }
    links.sort_unstable();
    links.dedup();
    // Links between vertices that are not on the ring say nothing.
    links.retain(|[a, b]| on.contains(a) || on.contains(b));
    links
}

/// Whether a ring and the vertices around it lie in a plane.
fn is_plane(mesh: &SurfaceMesh, ring: &[u32], around: &[[u32; 2]]) -> bool {
    let at = |v: u32| mesh.points()[v as usize];
    let centre = ring.iter().map(|&v| at(v)).sum::<DVec3>() / ring.len() as f64;
    let size = ring.iter().map(|&v| at(v).distance(centre)).fold(0.0, f64::max);
    let pairs = (0..ring.len()).map(|k| (at(ring[k]) - centre).cross(at(ring[(k + 1) % ring.len()]) - centre));
    let normal = pairs.sum::<DVec3>().normalize_or_zero();
    let all = ring.iter().chain(around.iter().flatten());
    normal != DVec3::ZERO && all.into_iter().all(|&v| (at(v) - centre).dot(normal).abs() <= PLANE * size)
}
