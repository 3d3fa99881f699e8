use carreau::{Context, mesh::*};
#[path = "scratch_topology.rs"]
#[allow(dead_code)]
mod t;
fn main() {
    for a in std::env::args().skip(1) {
        let m = match std::panic::catch_unwind(|| t::load(&a)) { Ok(m) => m, Err(_) => continue };
        let t0 = std::time::Instant::now();
        let r = repair(&m, &RepairOptions::default(), &Context::new()).unwrap();
        let s = t0.elapsed().as_secs_f64();
        let r2 = repair(&r.mesh, &RepairOptions::default(), &Context::new()).unwrap();
        let idem = r2.mesh.points() == r.mesh.points() && r2.mesh.faces() == r.mesh.faces();
        println!("{} {} {:.2}s idem={} closed {}->{} | {}", a.rsplit('/').next().unwrap(), m.face_count(), s, idem, r.report.before.closed, r.report.after.closed, r.report.sentences().join("; "));
    }
}
