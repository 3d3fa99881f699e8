//! Flat ends of closed tubes: plane pieces of a surface with a sharp rim, across the wall around them.
//!
//! ```text
//!        rim, sharp
//!       ╭──────────╮
//!       │  plane   │   the wall beyond the rim goes on along the normal of the plane, or nearly:
//!       ├──────────┤   a lid that is part of the surface
//!       │   wall   │
//! ```
//!
//! A cut segmentation and a pipe of a CAD system end so. A plane piece is only a candidate: whether a tube ends there is
//! for its skeleton to say.

use super::lids::{Closed, Lid};
use crate::error::Result;
use crate::geometry::normals::face_normals;
use crate::mesh::{CornerId, SurfaceMesh, triangle_area_vector};
use glam::DVec3;

/// Normals of a plane piece are within this angle of its largest triangle's: noise of a segmentation, and no bend.
const PLANE_DEGREES: f64 = 5.0;
/// A rim is sharp where the surface bends by more than this: an edge, and no rounding that was meshed finely.
const SHARP_DEGREES: f64 = 40.0;
/// The wall beyond the rim is within this cosine of square to the plane: tubes that taper by a third of a right angle.
const ACROSS: f64 = 0.5;
/// The share of the rim's length that is sharp and has such a wall.
const RIM: f64 = 0.9;
/// Vertices of a plane piece leave its plane by no more than this share of its radius.
const FLAT_PIECE: f64 = 0.05;

/// The plane pieces that may be ends, as lids, each with its triangles; in the order of their first triangles.
pub fn candidates(closed: &Closed) -> Vec<(Lid, Vec<u32>)> {
    let mesh = &closed.mesh;
    let normals = face_normals(mesh);
    let mut piece_of = vec![u32::MAX; closed.wall];
    let area = |t: u32| area_vector(mesh, t).length();
    let mut seeds: Vec<(f64, u32)> = (0..closed.wall as u32).map(|t| (area(t), t)).collect();
    seeds.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let mut found = Vec::new();
    for (piece, (_, seed)) in seeds.into_iter().enumerate() {
        if piece_of[seed as usize] != u32::MAX {
            continue;
        }
        let triangles = grow(mesh, &normals, seed, piece as u32, &mut piece_of);
        found.extend(lid(mesh, &normals, piece as u32, &piece_of, triangles));
    }
    found.sort_by_key(|(_, triangles)| triangles[0]);
    found
}

/// Where branches of a closed surface may be led to, but for ends with a rounded rim: plane pieces, and lids of open ends.
pub fn sharp(closed: &Closed) -> Vec<Lid> {
    let plane = candidates(closed).into_iter().map(|(lid, _)| lid);
    plane.chain(closed.lids.iter().cloned()).collect()
}

/// The triangles about a seed that face as it does, ascending.
fn grow(mesh: &SurfaceMesh, normals: &[DVec3], seed: u32, piece: u32, piece_of: &mut [u32]) -> Vec<u32> {
    let (normal, least) = (normals[seed as usize], PLANE_DEGREES.to_radians().cos());
    let mut triangles = vec![seed];
    piece_of[seed as usize] = piece;
    let mut next = 0;
    while let Some(&t) = triangles.get(next) {
        next += 1;
        for other in neighbours(mesh, t).into_iter().flatten() {
            let faces = normals.get(other as usize).map_or(0.0, |n| n.dot(normal));
            if piece_of.get(other as usize) == Some(&u32::MAX) && faces > least {
                piece_of[other as usize] = piece;
                triangles.push(other);
            }
        }
    }
    triangles.sort_unstable();
    triangles
}

/// The lid that a piece is, if it is plane, has one rim, and that is sharp.
fn lid(
    mesh: &SurfaceMesh,
    normals: &[DVec3],
    piece: u32,
    piece_of: &[u32],
    triangles: Vec<u32>,
) -> Option<(Lid, Vec<u32>)> {
    let normal = triangles.iter().map(|&t| area_vector(mesh, t)).sum::<DVec3>().try_normalize()?;
    let (sharp, mut border) = (SHARP_DEGREES.to_radians().cos(), Vec::new());
    let (mut length, mut good, mut centre) = (0.0, 0.0, DVec3::ZERO);
    for &t in &triangles {
        for (k, other) in neighbours(mesh, t).into_iter().enumerate() {
            if other.is_some_and(|o| piece_of.get(o as usize) == Some(&piece)) {
                continue;
            }
            let ends = side(mesh, t, k);
            let [a, b] = ends.map(|v| mesh.points()[v as usize]);
            border.push(ends);
            let beyond = other.map_or(normal, |o| normals[o as usize]);
            length += a.distance(b);
            centre += 0.5 * a.distance(b) * (a + b);
            if beyond.dot(normal) < sharp && beyond.dot(normal).abs() < ACROSS {
                good += a.distance(b);
            }
        }
    }
    if !(length > 0.0) || good < RIM * length || !is_disc(mesh, &triangles, border.len()) {
        return None;
    }
    centre /= length;
    let at = |v: u32| mesh.points()[v as usize];
    let off = |v: u32| (at(v) - centre).dot(normal).abs();
    let radius = border.iter().map(|e| at(e[0]).distance(centre)).sum::<f64>() / border.len() as f64;
    let flatness = border.iter().map(|e| off(e[0])).fold(0.0, f64::max) / radius.max(f64::MIN_POSITIVE);
    let is_flat =
        triangles.iter().flat_map(|&t| [0, 1, 2].map(|k| side(mesh, t, k)[0])).all(|v| off(v) < FLAT_PIECE * radius);
    is_flat.then_some((Lid { centre, normal, radius, flatness, border, triangles: 0..0, is_open: false }, triangles))
}

/// Whether triangles that hang together have no hole, by Euler's formula.
fn is_disc(mesh: &SurfaceMesh, triangles: &[u32], border: usize) -> bool {
    let mut vertices: Vec<u32> = triangles.iter().flat_map(|&t| [0, 1, 2].map(|k| side(mesh, t, k)[0])).collect();
    vertices.sort_unstable();
    vertices.dedup();
    let edges = (3 * triangles.len() + border) / 2;
    vertices.len() + triangles.len() == edges + 1
}

/// The same surface with some plane pieces as lids, behind those of its open ends.
///
/// # Errors
/// [`crate::Error::Input`] where there would be more elements than numbers for them.
pub fn with_lids(closed: Closed, ends: Vec<(Lid, Vec<u32>)>) -> Result<Closed> {
    let triangles = closed.mesh.faces().fan().0;
    let mut taken = vec![false; triangles.len()];
    ends.iter().flat_map(|(_, of_end)| of_end).for_each(|&t| taken[t as usize] = true);
    let mut order: Vec<[u32; 3]> = (0..triangles.len()).filter(|&t| !taken[t]).map(|t| triangles[t]).collect();
    let moved = (triangles.len() - order.len()) as u32;
    let mut lids = closed.lids;
    for lid in &mut lids {
        lid.triangles = lid.triangles.start - moved..lid.triangles.end - moved;
    }
    for (lid, of_end) in ends {
        let first = order.len() as u32;
        order.extend(of_end.iter().map(|&t| triangles[t as usize]));
        lids.push(Lid { triangles: first..order.len() as u32, ..lid });
    }
    let mesh = SurfaceMesh::from_triangles(closed.mesh.points().to_vec(), &order)?;
    Ok(Closed { mesh, lids, wall: closed.wall - moved as usize })
}

/// The triangles beyond the three sides of one.
fn neighbours(mesh: &SurfaceMesh, t: u32) -> [Option<u32>; 3] {
    corners(t).map(|c| mesh.opposite(c).map(|o| mesh.face_of(o).0))
}

/// The ends of a side of a triangle.
fn side(mesh: &SurfaceMesh, t: u32, k: usize) -> [u32; 2] {
    let c = corners(t)[k];
    [mesh.vertex(c).0, mesh.vertex(mesh.next(c)).0]
}

fn corners(t: u32) -> [CornerId; 3] {
    [0, 1, 2].map(|k| CornerId::new(3 * t as usize + k))
}

fn area_vector(mesh: &SurfaceMesh, t: u32) -> DVec3 {
    let [a, b, c] = [0, 1, 2].map(|k| mesh.points()[side(mesh, t, k)[0] as usize]);
    triangle_area_vector(a, b, c)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::skeleton::closed;
    use std::f64::consts::TAU;

    /// A closed prism of `n` sides about the z axis, from 0 to `height`, its upper end scaled; long thin triangles as CAD makes them.
    fn prism(n: u32, height: f64, upper: f64) -> SurfaceMesh {
        let at = |k: u32, z: f64, r: f64| {
            let (sin, cos) = (f64::from(k) * TAU / f64::from(n)).sin_cos();
            DVec3::new(r * cos, r * sin, z)
        };
        let points = (0..n).map(|k| at(k, 0.0, 1.0)).chain((0..n).map(|k| at(k, height, upper))).collect();
        let mut triangles = Vec::new();
        for k in 0..n {
            let next = (k + 1) % n;
            triangles.extend([[k, next, n + next], [k, n + next, n + k]]);
        }
        triangles.extend((1..n - 1).flat_map(|k| [[0, k + 1, k], [n, n + k, n + k + 1]]));
        SurfaceMesh::from_triangles(points, &triangles).unwrap()
    }

    #[test]
    fn the_ends_of_a_pipe_are_found_and_become_lids() {
        let pipe = closed(&prism(24, 9.0, 1.0)).unwrap();
        let ends = candidates(&pipe);
        assert_eq!(ends.len(), 2);
        for ((lid, _), [z, normal]) in ends.iter().zip([[0.0, -1.0], [9.0, 1.0]]) {
            assert!((lid.centre.z - z).abs() < 1e-12 && (lid.normal.z - normal).abs() < 1e-12, "{lid:?}");
        }
        assert!(
            ends.iter().all(|(lid, t)| (lid.radius - 1.0).abs() < 1e-12 && t.len() == 22 && lid.border.len() == 24)
        );
        let with = with_lids(pipe, ends).unwrap();
        assert_eq!((with.wall, with.lids.len(), with.mesh.face_count()), (48, 2, 92));
        for lid in &with.lids {
            assert!(!lid.is_open && lid.triangles.len() == 22);
            assert!(lid.triangles.clone().all(|t| area_vector(&with.mesh, t).normalize().dot(lid.normal) > 0.999));
        }
    }

    /// The sides of a prism of few sides are plane pieces with a sharp rim, too: the skeleton tells them apart. A blunt cone
    /// has one end across its wall, the wall of a round one has none.
    #[test]
    fn what_is_no_end_is_no_candidate() {
        assert_eq!(candidates(&closed(&prism(24, 0.5, 0.4)).unwrap()).len(), 0);
        let ball = closed(&crate::mesh::test_models::sphere(3)).unwrap();
        assert!(candidates(&ball).is_empty());
    }
}
