//! Regions that a curve sweeps along a straight line: extrusions.
//!
//! All triangles of an extruded region contain its direction. Seen along it, the vertices lie on a curve, and the triangles'
//! sides say in which order: a path from one end of the profile to the other, or a cycle.
//!
//! ```text
//!      d ↑  │╲│╲│╲│         seen along d:   ●──●──●──●
//!           │ ╲ ╲ ╲│
//! ```

use super::regions::{Map, Piece, Rung, area_vector, looks_along, mean_square, vertices};
use super::trace::interpolate;
use super::tuning::{ALONG, COLUMN};
use crate::brep::{Curve, Surface};
use crate::mesh::Triangles;
use crate::numeric::eigen3::{Eigen3, outer};
use glam::{DMat3, DVec3};

/// Least number of columns of vertices: fewer are a plane or a wedge.
const LEAST: usize = 4;

/// Gives extrusions to the pieces without a surface that are some; the others stay in the list.
pub fn sweep(map: &mut Map<'_>) {
    let free = std::mem::take(&mut map.free);
    let mut left = Vec::new();
    for p in free {
        let piece = &map.pieces[p as usize];
        if let Some(surface) = extrusion(map.t, &piece.triangles, map.diagonal) {
            let piece = &mut map.pieces[p as usize];
            *piece = Piece { surface, rung: Rung::Swept, ..piece.clone() };
            piece.same_sense = looks_along(map.t, piece);
            piece.square = mean_square(map.t, &piece.triangles, |q| piece.surface.distance(q));
            let far = |q: &DVec3| piece.surface.distance(*q);
            piece.max = vertices(map.t, &piece.triangles).iter().map(far).fold(0.0, f64::max);
        } else {
            left.push(p);
        }
    }
    map.free = left;
}

fn extrusion(t: Triangles<'_>, triangles: &[u32], diagonal: f64) -> Option<Surface> {
    let mut matrix = DMat3::ZERO;
    for &k in triangles {
        let n = area_vector(t, k);
        matrix += outer(n.normalize_or_zero()) * n.length();
    }
    let eigen = Eigen3::new(matrix);
    if !(eigen.values[0] <= ALONG * ALONG * eigen.values[2]) || eigen.values[1] <= ALONG * eigen.values[2] {
        return None;
    }
    let direction = eigen.vectors[0];
    let mut vertices: Vec<u32> = triangles.iter().flat_map(|&k| t.triangle(k)).collect();
    vertices.sort_unstable();
    vertices.dedup();
    let origin = t.points()[vertices[0] as usize];
    let flat = |v: u32| {
        let p = t.points()[v as usize];
        p - direction * (p - origin).dot(direction)
    };
    // Columns: vertices at one place of the profile.
    let near = COLUMN * diagonal;
    let across = direction.any_orthonormal_vector();
    let mut order: Vec<(f64, u32)> = vertices.iter().map(|&v| (flat(v).dot(across), v)).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut columns: Vec<DVec3> = Vec::new();
    let mut of: Vec<(u32, u32)> = Vec::with_capacity(order.len());
    let mut recent: Vec<(f64, u32)> = Vec::new();
    for (x, v) in order {
        recent.retain(|r| x - r.0 <= near);
        let p = flat(v);
        let known = recent.iter().find(|r| columns[r.1 as usize].distance(p) <= near).map(|r| r.1);
        let column = known.unwrap_or_else(|| {
            columns.push(p);
            columns.len() as u32 - 1
        });
        if known.is_none() {
            recent.push((x, column));
        }
        of.push((v, column));
    }
    of.sort_unstable();
    let column = |v: u32| of.binary_search_by_key(&v, |o| o.0).map_or(0, |k| of[k].1);
    let profile = walk(t, triangles, columns.len(), column)?;
    let closed = profile[0] == profile[profile.len() - 1];
    let points: Vec<DVec3> = profile.iter().map(|&c| columns[c as usize]).collect();
    let (spline, _) = interpolate(&points, closed)?;
    Some(Surface::Extrusion { profile: Curve::Spline(spline), direction })
}

/// The columns from one end to the other; a cycle repeats its first one.
fn walk(t: Triangles<'_>, triangles: &[u32], count: usize, column: impl Fn(u32) -> u32) -> Option<Vec<u32>> {
    if count < LEAST {
        return None;
    }
    let mut next: Vec<Vec<u32>> = vec![Vec::new(); count];
    for &k in triangles {
        let c = t.triangle(k).map(&column);
        for (a, b) in [(c[0], c[1]), (c[1], c[2]), (c[2], c[0])] {
            if a != b {
                next[a as usize].push(b);
                next[b as usize].push(a);
            }
        }
    }
    for list in &mut next {
        list.sort_unstable();
        list.dedup();
        if list.len() > 2 || list.is_empty() {
            return None;
        }
    }
    let start = next.iter().position(|l| l.len() == 1).unwrap_or(0) as u32;
    let mut path = vec![start];
    let (mut before, mut at) = (u32::MAX, start);
    while let Some(&to) = next[at as usize].iter().find(|&&n| n != before) {
        path.push(to);
        if to == start || path.len() > count + 1 {
            break;
        }
        (before, at) = (at, to);
    }
    let closed = path[path.len() - 1] == start;
    (path.len() == count + usize::from(closed)).then_some(path)
}
