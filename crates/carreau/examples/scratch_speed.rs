use carreau::{DVec3, mesh::*};
use std::time::Instant;
fn main() {
    let n = 742u32; // torus grid n x n, 2 n^2 triangles = 1.1 M
    let w = |i: u32, j: u32| (i % n) * n + j % n;
    let pts = (0..n * n)
        .map(|k| {
            let (u, v) = ((k / n) as f64 / n as f64 * 6.283185307179586, (k % n) as f64 / n as f64 * 6.283185307179586);
            DVec3::new((2. + 0.5 * v.cos()) * u.cos(), (2. + 0.5 * v.cos()) * u.sin(), 0.5 * v.sin())
        })
        .collect::<Vec<_>>();
    let mut t = vec![];
    for i in 0..n {
        for j in 0..n {
            let (a, b, c, d) = (w(i, j), w(i + 1, j), w(i + 1, j + 1), w(i, j + 1));
            t.push([a, b, c]);
            t.push([a, c, d]);
        }
    }
    // shuffled vertex ids and face order, as scans have
    let mut s = 12345u64;
    let mut r = move |k: usize| {
        s = s.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (s >> 33) as usize % k
    };
    if std::env::args().nth(1).is_some() {
        for k in (1..t.len()).rev() {
            t.swap(k, r(k + 1));
        }
    }
    let t0 = Instant::now();
    let m = SurfaceMesh::from_triangles(pts, &t).unwrap();
    eprintln!("build {:.3}", t0.elapsed().as_secs_f64());
    for _ in 0..3 {
        let t0 = Instant::now();
        let x = Topology::of(&m);
        eprintln!("{} topology {:.3}  {:?}", x.faces, t0.elapsed().as_secs_f64(), x.genus);
    }
}
