//! Convex hull of a few points in space, incrementally with exact orientation tests. Facets are triangles, coplanar ones
//! too.

use glam::DVec3;
use robust::{Coord3D, orient3d};

/// Triangles of the hull, counter-clockwise from outside; `None` for points in one plane.
pub fn convex_hull(points: &[DVec3]) -> Option<Vec<[u32; 3]>> {
    let mut faces = first_tetrahedron(points)?;
    let started: Vec<u32> = faces.as_flattened().to_vec();
    for p in (0..points.len() as u32).filter(|p| !started.contains(p)) {
        let (visible, hidden): (Vec<[u32; 3]>, Vec<[u32; 3]>) = faces.iter().partition(|f| sees(points, **f, p));
        let sides = |f: &[u32; 3]| [[f[0], f[1]], [f[1], f[2]], [f[2], f[0]]];
        let seen: Vec<[u32; 2]> = visible.iter().flat_map(sides).collect();
        faces = hidden;
        let horizon = seen.iter().filter(|[a, b]| !seen.contains(&[*b, *a]));
        faces.extend(horizon.map(|&[a, b]| [a, b, p]));
    }
    Some(faces)
}

/// Whether a point lies strictly outside the plane of a face.
fn sees(points: &[DVec3], face: [u32; 3], p: u32) -> bool {
    orientation(points, face, p) > 0.0
}

/// Positive where the point lies on the outer side of a counter-clockwise face.
fn orientation(points: &[DVec3], [a, b, c]: [u32; 3], p: u32) -> f64 {
    let [a, b, c, p] = [a, b, c, p].map(|v| {
        let q = points[v as usize];
        Coord3D { x: q.x, y: q.y, z: q.z }
    });
    -orient3d(a, b, c, p)
}

fn first_tetrahedron(points: &[DVec3]) -> Option<Vec<[u32; 3]>> {
    let n = points.len() as u32;
    for c in 2..n {
        for d in c + 1..n {
            let side = orientation(points, [0, 1, c], d);
            if side != 0.0 {
                let (b, c) = if side < 0.0 { (1, c) } else { (c, 1) };
                return Some(vec![[0, b, c], [0, d, b], [b, d, c], [c, d, 0]]);
            }
        }
    }
    None
}
