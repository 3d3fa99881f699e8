//! Models of the room as a whole.

use super::*;
use crate::brep::SurfaceKind;
use crate::sample;
use glam::{DVec2, DVec3};

fn model(name: &str) -> CadModel {
    let context = Context::new();
    let mesh = sample::make(name, None, &context).unwrap();
    rebuild(&mesh, &CadOptions::default(), &context).unwrap()
}

fn count(model: &CadModel, kind: SurfaceKind) -> usize {
    model.brep.faces.iter().filter(|f| model.brep.surface(f).kind() == kind).count()
}

#[test]
fn the_bracket_has_its_13_faces() {
    let model = model("bracket");
    assert!(model.fallback.is_empty(), "{:?}", model.fallback);
    assert_eq!((model.brep.faces.len(), model.brep.solids.len()), (13, 1));
    assert!(count(&model, SurfaceKind::Plane) > 0 && count(&model, SurfaceKind::Cylinder) > 0);
    assert!(model.brep.tolerance() < 1e-9, "{}", model.brep.tolerance());
}

#[test]
fn samples_become_solids_of_exact_faces() {
    for name in ["cube-cylinders", "rounded-box", "bracket"] {
        let model = model(name);
        assert!(model.fallback.is_empty(), "{name}: {:?}", model.fallback);
        assert_eq!(model.brep.solids.len(), 1, "{name}");
        model.brep.check().unwrap();
    }
}

/// A body between rings of points, each of the same number: sides, and lids that are fans.
fn loft(rings: &[Vec<DVec3>]) -> SurfaceMesh {
    let n = rings[0].len() as u32;
    let last = (rings.len() as u32 - 1) * n;
    let mut triangles = Vec::new();
    for ring in 0..rings.len() as u32 - 1 {
        for k in 0..n {
            let (a, b) = (ring * n + k, ring * n + (k + 1) % n);
            triangles.extend([[a, b, b + n], [a, b + n, a + n]]);
        }
    }
    triangles.extend((1..n - 1).flat_map(|k| [[0, k + 1, k], [last, last + k, last + k + 1]]));
    SurfaceMesh::from_triangles(rings.concat(), &triangles).unwrap()
}

fn of(mesh: &SurfaceMesh) -> CadModel {
    rebuild(mesh, &CadOptions::default(), &Context::new()).unwrap()
}

/// Corners of a plate, rounded by strips that touch its sides.
#[test]
fn strips_of_a_rounded_corner_are_one_cylinder() {
    let strips = 5u32;
    let quarter = std::f64::consts::FRAC_PI_2;
    let corner = |k: u32| DVec3::new([5.0, -5.0, -5.0, 5.0][k as usize], [3.0, 3.0, -3.0, -3.0][k as usize], 0.0);
    let ring = |z: f64| -> Vec<DVec3> {
        (0..4u32)
            .flat_map(|k| (0..=strips).map(move |j| (k, j)))
            .map(|(k, j)| {
                let angle = quarter * (f64::from(k) + f64::from(j) / f64::from(strips));
                corner(k) + 1.25 * DVec3::new(angle.cos(), angle.sin(), 0.0) + DVec3::new(0.0, 0.0, z)
            })
            .collect()
    };
    let model = of(&loft(&[ring(0.0), ring(2.0)]));
    assert_eq!(model.brep.faces.len(), 10, "{strips}");
    assert_eq!(count(&model, SurfaceKind::Cylinder), 4, "{strips}");
    let volume = 2.0 * (12.5 * 8.5 - (4.0 - std::f64::consts::PI) * 1.25 * 1.25);
    assert!((model.volume / volume - 1.0).abs() < 1e-9, "{strips}: {} for {volume}", model.volume);
}

#[test]
fn a_prism_stays_a_prism() {
    let ring = |z: f64| -> Vec<DVec3> {
        (0..6).map(|k| DVec2::from_angle(f64::from(k) * std::f64::consts::FRAC_PI_3).extend(z)).collect()
    };
    let model = of(&loft(&[ring(0.0), ring(2.0)]));
    assert_eq!((model.brep.faces.len(), count(&model, SurfaceKind::Plane)), (8, 8));
}

/// A vase has rings at uneven heights on a profile with no name: one region, or several that fit badly.
#[test]
fn a_vase_has_one_side() {
    let radius = |z: f64| 1.2 + 0.4 * (2.1 * z).sin() + 0.1 * z;
    let ring = |z: f64| -> Vec<DVec3> {
        let angle = |k: u32| std::f64::consts::TAU * f64::from(k) / 24.0;
        (0..24).map(|k| (radius(z) * DVec2::from_angle(angle(k))).extend(z)).collect()
    };
    let heights: Vec<f64> = (0..=12).map(|k| 3.0 * f64::from(k) / 12.0 + 0.03 * f64::from(k * k % 5)).collect();
    let rings: Vec<Vec<DVec3>> = heights.iter().map(|&z| ring(z)).collect();
    let model = of(&loft(&rings));
    assert_eq!(model.brep.faces.len(), 3, "{:?}", model.fallback);
    assert_eq!(count(&model, SurfaceKind::Revolution), 1);
}

/// Vertices off their places by up to a share of the diagonal, the same for the same place.
fn noisy(mesh: &SurfaceMesh, share: f64) -> SurfaceMesh {
    let mut seed = 1u64;
    let mut random = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    };
    let size = 2.0 * share * mesh.diagonal();
    let points = mesh.points().iter().map(|&p| p + size * DVec3::new(random(), random(), random())).collect();
    let triangles: Vec<[u32; 3]> = mesh.faces().iter().map(|f| [f[0], f[1], f[2]]).collect();
    SurfaceMesh::from_triangles(points, &triangles).unwrap()
}

#[test]
fn noise_makes_no_facets_of_parts() {
    let context = Context::new();
    for name in ["bracket", "cube-cylinders", "cylinder"] {
        let mesh = sample::make(name, None, &context).unwrap();
        let [exact, model] =
            [mesh.clone(), noisy(&mesh, 2e-4)].map(|mesh| rebuild(&mesh, &CadOptions::default(), &context).unwrap());
        assert!(model.fallback.is_empty(), "{name}: {:?}", model.fallback);
        assert_eq!((model.brep.faces.len(), model.brep.solids.len()), (exact.brep.faces.len(), 1), "{name}");
        assert!((model.volume / exact.volume - 1.0).abs() < 1e-3, "{name}");
    }
}
