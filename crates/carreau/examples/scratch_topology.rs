use carreau::{DVec3, mesh::*};
use std::time::Instant;
pub fn load(path: &str) -> SurfaceMesh {
    let b = std::fs::read(path).unwrap();
    let u = |k: usize| u32::from_le_bytes(b[k..k + 4].try_into().unwrap());
    let d = |k: usize| f64::from_le_bytes(b[k..k + 8].try_into().unwrap());
    let (n, m) = (u(0) as usize, u(4) as usize);
    let points = (0..n).map(|i| DVec3::new(d(8 + 24 * i), d(16 + 24 * i), d(24 + 24 * i))).collect();
    let mut at = 8 + 24 * n;
    let mut f = Polygons::new();
    for _ in 0..m {
        let s = u(at) as usize;
        f.push_iter((0..s).map(|k| u(at + 4 + 4 * k)));
        at += 4 + 4 * s;
    }
    SurfaceMesh::new(points, f).unwrap()
}
fn main() {
    for a in std::env::args().skip(1) {
        let m = match std::panic::catch_unwind(|| load(&a)) {
            Ok(m) => m,
            Err(_) => continue,
        };
        let t0 = Instant::now();
        let t = Topology::of(&m);
        eprintln!("{a} {} {:.3}s", t.faces, t0.elapsed().as_secs_f64());
        println!("{}\t{}", a, serde_json::to_string(&t).unwrap());
    }
}
