//! Tessellations of the hand-made models: watertight, near the surface, of the right volume.

use super::*;
use crate::brep::models;

#[test]
fn tessellations_are_watertight_and_near() {
    for (name, brep, volume) in models::all() {
        let fineness = Fineness { chord: 2e-3, angle: 12f64.to_radians() };
        let out = tessellate(&brep, &fineness, &Context::new()).unwrap();
        assert!(out.crossed.is_empty(), "{name}: {:?}", out.crossed);
        for (t, (uv, &f)) in out.triangles.iter().zip(out.places.iter().zip(&out.face_of)) {
            let face = &brep.faces[f as usize];
            let surface = brep.surface(face);
            let [a, b, c] = t.map(|v| out.points[v as usize]);
            for (p, at) in [a, b, c].iter().zip(uv) {
                assert!(surface.point(at.x, at.y).distance(*p) < 1e-6, "{name}: face {f}");
            }
            let middle = (uv[0] + uv[1] + uv[2]) / 3.0;
            let off = surface.distance((a + b + c) / 3.0);
            // Middles of the model's triangles are looked at in the parameter plane, and on a border its chords are.
            assert!(off < 4.0 * fineness.chord, "{name}: face {f} {off}");
            let normal = surface.normal(middle.x, middle.y) * if face.same_sense { 1.0 } else { -1.0 };
            assert!((b - a).cross(c - a).dot(normal) >= -1e-12, "{name}: face {f} turned");
        }
        let mesh = out.mesh().unwrap();
        let open = (0..mesh.corner_count() as u32).filter(|&c| mesh.opposite(crate::mesh::CornerId(c)).is_none());
        assert_eq!(open.count(), 0, "{name}");
        let points = mesh.points();
        let flat: f64 = mesh
            .faces()
            .iter()
            .map(|t| points[t[0] as usize].dot(points[t[1] as usize].cross(points[t[2] as usize])) / 6.0)
            .sum();
        assert!((flat / volume - 1.0).abs() < 0.02, "{name}: {flat} for {volume}");
    }
}

#[test]
fn finer_is_nearer() {
    for (name, brep, volume) in models::all() {
        let off = |chord: f64| {
            let out = tessellate(&brep, &Fineness { chord, angle: 1.0 }, &Context::new()).unwrap();
            let cone = |t: &[u32; 3]| {
                let [a, b, c] = t.map(|v| out.points[v as usize]);
                a.dot(b.cross(c)) / 6.0
            };
            (out.triangles.iter().map(cone).sum::<f64>() / volume - 1.0).abs()
        };
        let (coarse, fine) = (off(2e-2), off(1e-3));
        assert!(fine < 0.3 * coarse + 1e-9, "{name}: {fine} after {coarse}");
    }
}
