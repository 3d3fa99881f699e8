//! Profiles of swept surfaces: vertices of the mesh, moved into the profile's plane, lie at a few places in a row.
//!
//! ```text
//!      d ↑  │╲│╲│╲│         seen along d:   ●──●──●──●
//!           │ ╲ ╲ ╲│
//! ```

use super::trace::interpolate;
use crate::brep::Curve;
use crate::mesh::Triangles;
use glam::DVec3;

/// The curve through the places of a region's vertices, which `flat` moves into the plane of the profile. Vertices nearer to each other
/// there than `near` have one place. `None` where the region's sides do not say in which order the places are, or there are fewer
/// than `least`.
pub fn profile(
    t: Triangles<'_>,
    triangles: &[u32],
    flat: impl Fn(DVec3) -> DVec3,
    across: DVec3,
    near: f64,
    least: usize,
) -> Option<Curve> {
    let mut vertices: Vec<u32> = triangles.iter().flat_map(|&k| t.triangle(k)).collect();
    vertices.sort_unstable();
    vertices.dedup();
    // Columns: vertices at one place of the profile.
    let place = |v: u32| flat(t.points()[v as usize]);
    let mut order: Vec<(f64, u32)> = vertices.iter().map(|&v| (place(v).dot(across), v)).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut columns: Vec<DVec3> = Vec::new();
    let mut of: Vec<(u32, u32)> = Vec::with_capacity(order.len());
    let mut recent: Vec<(f64, u32)> = Vec::new();
    for (x, v) in order {
        recent.retain(|r| x - r.0 <= near);
        let p = place(v);
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
    let row = walk(t, triangles, columns.len(), column, least)?;
    let closed = row[0] == row[row.len() - 1];
    let points: Vec<DVec3> = row.iter().map(|&c| columns[c as usize]).collect();
    let (spline, _) = interpolate(&points, closed)?;
    Some(Curve::Spline(spline))
}

/// The columns from one end to the other; a cycle repeats its first one.
fn walk(
    t: Triangles<'_>,
    triangles: &[u32],
    count: usize,
    column: impl Fn(u32) -> u32,
    least: usize,
) -> Option<Vec<u32>> {
    if count < least {
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
