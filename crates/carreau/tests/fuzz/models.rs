//! Meshes to begin with, and the ways to spoil them.

use crate::random::Random;
use carreau::mesh::{Cells, Column, CurveNet, Polygons, RawMesh, SurfaceMesh};
use carreau::{Context, DVec3, sample};
use std::f64::consts::TAU;

/// Small meshes with all that files can hold.
pub fn files() -> Vec<RawMesh> {
    let cube: Vec<DVec3> =
        (0..8).map(|k| DVec3::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2))).collect();
    let mut mixed =
        RawMesh { points: cube.clone(), edges: vec![[0, 1], [1, 3]], edge_tags: vec![7, -2], ..RawMesh::default() };
    for face in
        [&[0u32, 2, 3, 1][..], &[4, 5, 7], &[4, 7, 6], &[0, 1, 5, 4], &[3, 2, 6, 7], &[0, 4, 6, 2], &[1, 3, 7, 5]]
    {
        mixed.faces.push(face);
    }
    let count = mixed.faces.len();
    mixed.attributes.face.insert("region".into(), Column::Label((0..count as i32).collect()));
    mixed.attributes.vertex.insert("size".into(), Column::Scalar((0..8).map(|k| f64::from(k) / 3.0).collect()));
    mixed.attributes.vertex.insert("u".into(), Column::Vector3(cube.iter().map(|p| [p.x, p.y, 0.1]).collect()));
    let cells = Cells { hexes: vec![[0, 1, 3, 2, 4, 5, 7, 6]], tets: vec![[0, 1, 2, 4]], ..Cells::default() };
    let volume = RawMesh { points: cube, cells, ..RawMesh::default() };
    let pentagon = (0..5).map(|k| f64::from(k).sin_cos()).map(|(y, x)| DVec3::new(x, y, 0.1)).collect();
    let mut polygon = RawMesh { points: pentagon, ..RawMesh::default() };
    polygon.faces.push(&[0, 1, 2, 3, 4]);
    let small = sample::make("wedge", Some(8), &Context::new()).unwrap();
    vec![mixed, volume, polygon, small.into()]
}

/// Small skeletons.
pub fn nets() -> Vec<CurveNet> {
    let at = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    let fork = vec![at(0.0, 0.0, 0.0), at(1.0, 0.0, 0.0), at(2.0, 1.0, 0.0), at(2.0, -1.0, 0.5)];
    vec![CurveNet::new(fork, vec![0.2, 0.25, 0.1, 0.15], vec![[0, 1], [1, 2], [1, 3]])]
}

/// Small surfaces of every kind.
pub struct Models(Vec<SurfaceMesh>);

impl Models {
    pub fn new() -> Self {
        let context = Context::new();
        let coarse = |s: &sample::Sample| {
            // The coarsest that the model can be made at.
            [4, 6, 8, 12, 16, 24, 32, 48].iter().find_map(|&n| sample::make(s.name, Some(n), &context).ok()).unwrap()
        };
        Models(sample::SAMPLES.iter().map(coarse).filter(|m| m.face_count() < 1500).collect())
    }

    /// A surface that nobody would make.
    pub fn surface(&self, rng: &mut Random) -> SurfaceMesh {
        let (points, triangles) = match rng.below(8) {
            0 => soup(rng),
            1 => strip(rng),
            2 | 3 => rings(rng),
            _ => {
                let model = rng.pick(&self.0).clone().triangulated().unwrap();
                let (points, faces, ..) = model.into_parts();
                let mut triangles = faces.fan().0;
                if triangles.len() > 100 && !rng.one_in(16) {
                    // A piece of it: what goes wrong shows in few triangles, and a hundred thousand of these are soon tried.
                    let start = rng.below(triangles.len() - 80);
                    triangles = triangles[start..start + 12 + rng.below(60)].to_vec();
                }
                (points, triangles)
            }
        };
        let (mut points, mut triangles) = (points, triangles);
        for _ in 0..rng.below(4) {
            spoil_triangles(&mut triangles, points.len(), rng);
        }
        for _ in 0..rng.below(3) {
            spoil_points(&mut points, rng);
        }
        let points = points.into_iter().map(|p| if p.is_finite() { p } else { DVec3::ZERO }).collect();
        SurfaceMesh::new(points, Polygons::from_triangles(&triangles)).unwrap()
    }

    /// A skeleton that nobody would draw.
    pub fn net(&self, rng: &mut Random) -> CurveNet {
        let n = 2 + rng.below(6);
        let grid = rng.one_in(3);
        let coordinate = |rng: &mut Random| if grid { rng.below(3) as f64 } else { 4.0 * rng.signed() };
        let mut points: Vec<DVec3> =
            (0..n).map(|_| DVec3::new(coordinate(rng), coordinate(rng), coordinate(rng))).collect();
        if rng.one_in(4) {
            spoil_points(&mut points, rng);
        }
        let size = points.iter().fold(0.0f64, |s, p| s.max(p.length()));
        let radii = (0..n).map(|_| if rng.one_in(12) { 0.0 } else { size * (0.002 + 0.1 * rng.share()) }).collect();
        let mut edges: Vec<[u32; 2]> = (1..n).map(|v| [rng.below(v) as u32, v as u32]).collect();
        (0..rng.below(3)).for_each(|_| edges.push([rng.below(n) as u32, rng.below(n) as u32]));
        if rng.one_in(5) {
            edges.remove(rng.below(edges.len()));
        }
        CurveNet::new(points, radii, edges)
    }
}

type Soup = (Vec<DVec3>, Vec<[u32; 3]>);

/// Any triangles on a few points of a grid.
fn soup(rng: &mut Random) -> Soup {
    let n = 3 + rng.below(14);
    let mut coordinate = || rng.below(5) as f64 - 2.0;
    let points = (0..n).map(|_| DVec3::new(coordinate(), coordinate(), coordinate())).collect();
    let triangles = (0..1 + rng.below(40)).map(|_| [0; 3].map(|_: u32| rng.below(n) as u32)).collect();
    (points, triangles)
}

/// A strip of needles: one side may be any factor shorter than the other.
fn strip(rng: &mut Random) -> Soup {
    let n = 4 + rng.below(40);
    let thin = 10f64.powi(-(rng.below(17) as i32));
    let (bend, rise) = (rng.share(), if rng.one_in(2) { thin } else { 0.0 });
    let at = |k: usize| DVec3::new((k / 2) as f64 * thin, (k % 2) as f64, (k as f64 * bend).sin() * rise);
    let points = (0..n).map(at).collect();
    let triangles = (2..n as u32).map(|k| if k % 2 == 0 { [k - 2, k - 1, k] } else { [k - 1, k - 2, k] }).collect();
    (points, triangles)
}

/// Tubes of a few rings, closed, open or bent around to a ring.
fn rings(rng: &mut Random) -> Soup {
    let (n, m) = (3 + rng.below(5), 2 + rng.below(5));
    let around = m > 2 && rng.one_in(3);
    let mut points = Vec::new();
    for j in 0..m {
        let (radius, turn) = (0.2 + 0.6 * rng.share(), TAU * j as f64 / m as f64);
        let (out, up) = if around { ((turn.cos(), turn.sin()), DVec3::Z) } else { ((1.0, 0.0), DVec3::Y) };
        let out = DVec3::new(out.0, out.1, 0.0);
        let middle = if around { 2.0 * out } else { j as f64 * DVec3::Z };
        points.extend((0..n).map(|i| {
            let (sin, cos) = (TAU * i as f64 / n as f64).sin_cos();
            middle + radius * (cos * out + sin * up)
        }));
    }
    let at = |j: usize, i: usize| (j % m * n + i % n) as u32;
    let mut triangles = Vec::new();
    for j in 0..if around { m } else { m - 1 } {
        for i in 0..n {
            triangles.push([at(j, i), at(j, i + 1), at(j + 1, i + 1)]);
            triangles.push([at(j, i), at(j + 1, i + 1), at(j + 1, i)]);
        }
    }
    for end in [0, m - 1] {
        if !around && !rng.one_in(3) {
            let fan = (1..n - 1).map(|i| [at(end, 0), at(end, i), at(end, i + 1)]);
            triangles.extend(fan.map(|[a, b, c]| if end == 0 { [a, c, b] } else { [a, b, c] }));
        }
    }
    (points, triangles)
}

fn spoil_triangles(triangles: &mut Vec<[u32; 3]>, n: usize, rng: &mut Random) {
    let at = rng.below(triangles.len());
    match rng.below(6) {
        0 => {
            let range = rng.range(triangles.len());
            if range.len() < triangles.len() {
                triangles.drain(range);
            }
        }
        1 => triangles[at].swap(0, 1),
        2 => triangles.push(triangles[at]),
        3 => triangles[at][rng.below(3)] = rng.below(n) as u32,
        4 => {
            // Two vertices become one, wherever they are.
            let (a, b) = (rng.below(n) as u32, triangles[at][0]);
            triangles.iter_mut().flatten().filter(|v| **v == a).for_each(|v| *v = b);
        }
        _ => {
            for _ in 0..triangles.len() {
                let (a, b) = (rng.below(triangles.len()), rng.below(triangles.len()));
                triangles.swap(a, b);
            }
        }
    }
}

fn spoil_points(points: &mut [DVec3], rng: &mut Random) {
    let size = points.iter().fold(0.0f64, |s, p| s.max(p.abs().max_element()));
    match rng.below(9) {
        0 => {
            // Flat, or nearly.
            let (axis, factor) = (rng.below(3), if rng.one_in(2) { 0.0 } else { 10f64.powi(-(rng.below(18) as i32)) });
            points.iter_mut().for_each(|p| p[axis] *= factor);
        }
        1 => {
            let noise = size * 10f64.powi(-(rng.below(17) as i32));
            for p in points.iter_mut() {
                *p += noise * DVec3::new(rng.signed(), rng.signed(), rng.signed());
            }
        }
        2 => {
            let factor = 10f64.powi(rng.below(601) as i32 - 300);
            points.iter_mut().for_each(|p| *p *= factor);
        }
        3 => {
            let far = DVec3::new(rng.signed(), rng.signed(), rng.signed()) * size * 10f64.powi(rng.below(16) as i32);
            points.iter_mut().for_each(|p| *p += far);
        }
        4 => {
            let step = size * 10f64.powi(-1 - rng.below(4) as i32);
            points.iter_mut().for_each(|p| *p = (*p / step).round() * step);
        }
        5 => {
            let (a, b) = (rng.below(points.len()), rng.below(points.len()));
            points[a] = points[b];
        }
        6 => {
            let at = rng.below(points.len());
            points[at] *= 10f64.powi(rng.below(320) as i32);
        }
        7 => {
            let axis = rng.below(3);
            let factor = 10f64.powi(rng.below(13) as i32 - 6);
            points.iter_mut().for_each(|p| p[axis] *= factor);
        }
        _ => {
            let at = rng.below(points.len());
            let next = points[(at + 1) % points.len()];
            points[at] = next + (points[at] - next) * 10f64.powi(-(rng.below(20) as i32));
        }
    }
}
