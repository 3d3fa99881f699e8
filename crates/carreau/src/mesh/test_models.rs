//! Small procedural surfaces for tests.

use super::{Polygons, SurfaceMesh};
use glam::DVec3;
use std::f64::consts::TAU;

/// A mesh of triangles; panics on a mistake in the test.
pub fn triangles(points: &[DVec3], triangles: &[[u32; 3]]) -> SurfaceMesh {
    SurfaceMesh::from_triangles(points.to_vec(), triangles).unwrap()
}

/// Several meshes in one, nothing merged.
pub fn together(parts: &[SurfaceMesh]) -> SurfaceMesh {
    let (mut points, mut faces) = (Vec::new(), Polygons::new());
    for part in parts {
        let base = points.len() as u32;
        part.faces().iter().for_each(|f| faces.push_iter(f.iter().map(|v| v + base)));
        points.extend_from_slice(part.points());
    }
    SurfaceMesh::new(points, faces).unwrap()
}

/// The mesh with its points moved.
pub fn moved(mesh: &SurfaceMesh, by: impl FnMut(DVec3) -> DVec3) -> SurfaceMesh {
    SurfaceMesh::new(mesh.points().iter().copied().map(by).collect(), mesh.faces().clone()).unwrap()
}

/// The mesh with all or some faces turned over.
pub fn turned(mesh: &SurfaceMesh, turn: impl Fn(usize) -> bool) -> SurfaceMesh {
    let mut faces = Polygons::new();
    for (f, face) in mesh.faces().iter().enumerate() {
        if turn(f) { faces.push_iter(face.iter().rev().copied()) } else { faces.push(face) }
    }
    SurfaceMesh::new(mesh.points().to_vec(), faces).unwrap()
}

/// The mesh without some faces.
pub fn without(mesh: &SurfaceMesh, faces: &[usize]) -> SurfaceMesh {
    let kept = mesh.faces().iter().enumerate().filter(|(f, _)| !faces.contains(f)).map(|(_, face)| face).collect();
    SurfaceMesh::new(mesh.points().to_vec(), kept).unwrap()
}

/// A regular tetrahedron, outward.
pub fn tetrahedron() -> SurfaceMesh {
    let p = [(1., 1., 1.), (1., -1., -1.), (-1., 1., -1.), (-1., -1., 1.)].map(DVec3::from);
    triangles(&p, &[[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])
}

/// A cube of quads from `low` with this edge length, outward.
pub fn cube(low: DVec3, size: f64) -> SurfaceMesh {
    let p =
        (0..8).map(|k| low + size * DVec3::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2))).collect();
    let quads = [[0u32, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    SurfaceMesh::new(p, quads.iter().map(|q| &q[..]).collect()).unwrap()
}

/// The unit cube, with two quads for its top that share the two sides at a vertex beside its diagonal: closed, but the fans of
/// these quads have a triangle in common.
pub fn folded_box() -> SurfaceMesh {
    let cube = cube(DVec3::ZERO, 1.0);
    let points = cube.points().iter().copied().chain([DVec3::new(0.3, 0.6, 1.0)]).collect();
    let mut faces = Polygons::new();
    for face in cube.faces().iter() {
        match face {
            &[a, c, b, e] if [a, c, b, e] == [4, 5, 7, 6] => {
                [[a, c, b, 8], [a, 8, b, e]].iter().for_each(|q| faces.push(q))
            }
            _ => faces.push(face),
        }
    }
    SurfaceMesh::new(points, faces).unwrap()
}

/// `n × m` vertices around a torus with radii 2 and 0.5, outward.
pub fn torus(n: u32, m: u32) -> SurfaceMesh {
    let at = |i: u32, j: u32| (i % n) * m + j % m;
    let point = |k: u32| {
        let (u, v) = (TAU * f64::from(k / m) / f64::from(n), TAU * f64::from(k % m) / f64::from(m));
        let r = 2.0 + 0.5 * v.cos();
        DVec3::new(r * u.cos(), r * u.sin(), 0.5 * v.sin())
    };
    let cell = |k: u32| (at(k / m, k % m), at(k / m + 1, k % m), at(k / m + 1, k % m + 1), at(k / m, k % m + 1));
    let faces: Vec<_> = (0..n * m).map(cell).flat_map(|(a, b, c, d)| [[a, b, c], [a, c, d]]).collect();
    triangles(&(0..n * m).map(point).collect::<Vec<_>>(), &faces)
}

/// `n × n` squares of side 1 in the plane z = 0, each of two triangles; square (i, j) has the triangles 2(i n + j) and
/// the next.
pub fn grid(n: u32) -> SurfaceMesh {
    let at = |i: u32, j: u32| i * (n + 1) + j;
    let points = (0..(n + 1) * (n + 1)).map(|k| DVec3::new(f64::from(k / (n + 1)), f64::from(k % (n + 1)), 0.0));
    let cell = |k: u32| (at(k / n, k % n), at(k / n + 1, k % n), at(k / n + 1, k % n + 1), at(k / n, k % n + 1));
    let faces: Vec<_> = (0..n * n).map(cell).flat_map(|(a, b, c, d)| [[a, b, c], [a, c, d]]).collect();
    triangles(&points.collect::<Vec<_>>(), &faces)
}

/// A strip of `n` quads, given `half_turns` before its ends are joined: a Möbius strip for an odd number.
pub fn strip(n: u32, half_turns: u32) -> SurfaceMesh {
    let point = |k: u32| {
        let u = TAU * f64::from(k / 2) / f64::from(n);
        let (side, tilt) = (f64::from(k % 2) - 0.5, 0.5 * u * f64::from(half_turns));
        let r = 2.0 + side * tilt.cos();
        DVec3::new(r * u.cos(), r * u.sin(), side * tilt.sin())
    };
    let quad = |i: u32| {
        let swap = if i + 1 == n { half_turns % 2 } else { 0 };
        let next = 2 * ((i + 1) % n);
        [2 * i, 2 * i + 1, next + 1 - swap, next + swap]
    };
    let quads: Vec<_> = (0..n).map(quad).collect();
    SurfaceMesh::new((0..2 * n).map(point).collect(), quads.iter().map(|q| &q[..]).collect()).unwrap()
}

/// An icosahedron subdivided `levels` times, on the unit sphere, outward: 20 · 4^levels triangles.
pub fn sphere(levels: u32) -> SurfaceMesh {
    let g = (1.0 + 5f64.sqrt()) / 2.0;
    let ring = [(-1., g, 0.), (1., g, 0.), (-1., -g, 0.), (1., -g, 0.)].map(DVec3::from);
    let rings = [ring, ring.map(|p| DVec3::new(p.z, p.x, p.y)), ring.map(|p| DVec3::new(p.y, p.z, p.x))];
    let mut points: Vec<DVec3> = rings.as_flattened().iter().map(|p| p.normalize()).collect();
    let edge = points[0].distance(points[1]);
    let near = |a: usize, b: usize| a != b && (points[a].distance(points[b]) - edge).abs() < 1e-9;
    let mut faces = Vec::new();
    for (a, b, c) in (0..12).flat_map(|a| (a + 1..12).flat_map(move |b| (b + 1..12).map(move |c| (a, b, c)))) {
        if near(a, b) && near(b, c) && near(c, a) {
            let outward = points[a].dot(points[b].cross(points[c])) > 0.0;
            faces.push(if outward { [a, b, c] } else { [a, c, b] }.map(|v| v as u32));
        }
    }
    for _ in 0..levels {
        let mut middle = std::collections::BTreeMap::new();
        let old = std::mem::take(&mut faces);
        for [a, b, c] in old {
            let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(p, q)| {
                *middle.entry((p.min(q), p.max(q))).or_insert_with(|| {
                    points.push((points[p as usize] + points[q as usize]).normalize());
                    points.len() as u32 - 1
                })
            });
            faces.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
    }
    triangles(&points, &faces)
}

/// Two unit cubes whose only common vertices are those of one edge.
pub fn cubes_sharing_an_edge() -> SurfaceMesh {
    merged(&together(&[cube(DVec3::ZERO, 1.0), cube(DVec3::new(1.0, 1.0, 0.0), 1.0)]))
}

/// Two unit cubes with one common vertex.
pub fn cubes_sharing_a_vertex() -> SurfaceMesh {
    merged(&together(&[cube(DVec3::ZERO, 1.0), cube(DVec3::ONE, 1.0)]))
}

/// The mesh with vertices at equal positions made one; unreferenced ones stay.
pub fn merged(mesh: &SurfaceMesh) -> SurfaceMesh {
    let first = super::first_at_same_position(mesh.points());
    let mut faces = mesh.faces().clone();
    faces.corners_mut().iter_mut().for_each(|v| *v = first[*v as usize]);
    SurfaceMesh::new(mesh.points().to_vec(), faces).unwrap()
}

/// So many unit cubes along the three axes, from the origin; vertices and cells row by row, the x axis first.
pub fn bricks([nx, ny, nz]: [u32; 3]) -> (Vec<DVec3>, Vec<[u32; 8]>) {
    let triples = |[nx, ny, nz]: [u32; 3]| (0..nx * ny * nz).map(move |c| [c % nx, c / nx % ny, c / nx / ny]);
    let at = |i: u32, j: u32, k: u32| (k * (ny + 1) + j) * (nx + 1) + i;
    let hex = |[i, j, k]: [u32; 3]| {
        let low = [at(i, j, k), at(i + 1, j, k), at(i + 1, j + 1, k), at(i, j + 1, k)];
        let high = low.map(|v| v + (nx + 1) * (ny + 1));
        [low[0], low[1], low[2], low[3], high[0], high[1], high[2], high[3]]
    };
    let points = triples([nx + 1, ny + 1, nz + 1]).map(|c| DVec3::from(c.map(f64::from)));
    (points.collect(), triples([nx, ny, nz]).map(hex).collect())
}
