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

/// The same corners where the strips are flat sides with vertices of their own: those are not on any cylinder.
#[test]
fn flat_sides_with_vertices_inside_stay_flat() {
    let corner = |k: u32| DVec3::new([5.0, -5.0, -5.0, 5.0][k as usize], [3.0, 3.0, -3.0, -3.0][k as usize], 0.0);
    let column = |k: u32, j: u32| {
        let angle = std::f64::consts::FRAC_PI_2 * (f64::from(k) + f64::from(j) / 4.0);
        corner(k) + 1.25 * DVec3::new(angle.cos(), angle.sin(), 0.0)
    };
    // A vertex of the middle of every strip follows its first column.
    let ring = |z: f64| -> Vec<DVec3> {
        let between = |k: u32, j: u32| 0.5 * (column(k, j) + column(k, j + 1));
        let of = |k: u32| (0..4).flat_map(move |j| [column(k, j), between(k, j)]).chain([column(k, 4)]);
        (0..4).flat_map(of).map(|p| p + DVec3::new(0.0, 0.0, z)).collect()
    };
    let model = of(&loft(&[ring(0.0), ring(1.0), ring(2.0)]));
    assert_eq!((model.brep.faces.len(), count(&model, SurfaceKind::Plane)), (22, 22), "{:?}", model.fallback);
}

/// A round rod with a step to its middle, turned and in float precision: vertical edges are where the seam would like to be.
#[test]
fn a_seam_does_not_run_along_an_edge() {
    let n = 24u32;
    let at = |k: u32, z: f64| {
        let p = DVec2::from_angle(std::f64::consts::TAU * f64::from(k) / f64::from(n)).extend(z);
        (glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.3, -0.8, 1.1) * p).as_vec3().as_dvec3()
    };
    // Rings at the foot, at the step, and half a ring on top.
    let points: Vec<DVec3> = [0.0, 1.0, 2.0].into_iter().flat_map(|z| (0..n).map(move |k| at(k, z))).collect();
    let mut triangles = Vec::new();
    let mut quad = |[a, b, c, d]: [u32; 4]| triangles.extend([[a, b, c], [a, c, d]]);
    (0..n).for_each(|k| quad([k, (k + 1) % n, n + (k + 1) % n, n + k]));
    (0..n / 2).for_each(|k| quad([n + k, n + k + 1, 2 * n + k + 1, 2 * n + k]));
    quad([n + n / 2, n, 2 * n, 2 * n + n / 2]);
    triangles.extend((1..n - 1).map(|k| [0, k + 1, k]));
    triangles.extend((1..n / 2).map(|k| [n + n / 2, n + n / 2 + k, n + (n / 2 + k + 1) % n]));
    triangles.extend((1..n / 2).map(|k| [2 * n, 2 * n + k, 2 * n + k + 1]));
    // Half of the last ring is used by no triangle.
    let used = points[..(2 * n + n / 2 + 1) as usize].to_vec();
    let model = of(&SurfaceMesh::from_triangles(used, &triangles).unwrap());
    assert!(model.fallback.is_empty(), "{:?}", model.fallback);
    assert_eq!((model.brep.faces.len(), count(&model, SurfaceKind::Cylinder)), (5, 1));
    assert!((model.volume / (1.5 * std::f64::consts::PI) - 1.0).abs() < 1e-6, "{}", model.volume);
}

/// A profile drawn from a point to the same point, smooth but for its curvature there, and every vertex at a place of its own.
#[test]
fn an_extrusion_of_a_closed_curve_with_a_joint_is_one_face() {
    let rings = 6u32;
    let ring = |j: u32| -> Vec<DVec3> {
        let point = |k: u32| {
            let s = if j == 0 || j + 1 == rings {
                f64::from(k) / 48.0
            } else {
                (f64::from(k) + 0.15 * f64::from(j)) / 48.0
            };
            let radius = 1.0 + s * s * (1.0 - s).powi(3);
            (radius * DVec2::from_angle(std::f64::consts::TAU * s)).extend(0.2 * f64::from(j))
        };
        (0..48).map(point).collect()
    };
    let model = of(&loft(&(0..rings).map(ring).collect::<Vec<_>>()));
    assert!(model.fallback.is_empty(), "{:?}", model.fallback);
    assert_eq!((model.brep.faces.len(), count(&model, SurfaceKind::Spline)), (3, 1));
}

/// A plate with round corners, one of which was given the first column of the flat side beside it, which is so narrow that it lies on
/// the round corner to a millionth of the size.
#[test]
fn a_row_of_a_flat_side_leaves_the_round_corner_that_it_nearly_lies_on() {
    let quarter = std::f64::consts::FRAC_PI_2;
    let ring = |z: f64| -> Vec<DVec3> {
        let corner = |k: u32| {
            let center = [DVec2::new(3.0, 2.0), DVec2::new(-3.0, 2.0), DVec2::new(-3.0, -2.0), DVec2::new(3.0, -2.0)];
            let arc = (0..=6)
                .map(move |j| center[k as usize] + DVec2::from_angle(quarter * (f64::from(k) + f64::from(j) / 6.0)));
            // The flat side after the first corner runs along −x.
            arc.chain((k == 0).then_some(DVec2::new(3.0 - 2e-3, 3.0)))
        };
        (0..4).flat_map(corner).map(|p| p.extend(z)).collect()
    };
    let mesh = loft(&[ring(0.0), ring(1.0)]);
    // Columns: six of the corner and the narrow one, the flat side, then seven for each corner and the side after it.
    let column = |c: u32| match c {
        0..7 => 0,
        7 => 1,
        c => 2 * ((c - 8) / 7 + 1) + u32::from((c - 8) % 7 == 6),
    };
    let lids = mesh.faces().len() as u32 - 58;
    let labels = (0..58).map(|k| column(k / 2)).chain((0..lids).map(|k| 8 + k % 2)).collect();
    let options = CadOptions { labels: Some(labels), ..CadOptions::default() };
    let model = rebuild(&mesh, &options, &Context::new()).unwrap();
    assert!(model.fallback.is_empty(), "{:?}", model.fallback);
    assert_eq!((model.brep.faces.len(), count(&model, SurfaceKind::Cylinder)), (10, 4));
    let volume = 8.0 * 6.0 - (4.0 - std::f64::consts::PI);
    assert!((model.volume / volume - 1.0).abs() < 1e-10, "{} for {volume}", model.volume);
}

/// A triangle of a lid has all corners on the rim, hence on the side as well.
#[test]
fn a_triangle_on_two_surfaces_goes_to_the_one_that_it_lies_in() {
    let ring = |z: f64| -> Vec<DVec3> {
        (0..24).map(|k| DVec2::from_angle(f64::from(k) * std::f64::consts::TAU / 24.0).extend(z)).collect()
    };
    let mesh = loft(&[ring(0.0), ring(2.0)]);
    // Sides, then triangles of both lids in turns; the first of these counts as a side.
    let labels = (0..48 + 44).map(|k| if k <= 48 { 0 } else { 1 + k % 2 }).collect();
    let options = CadOptions { labels: Some(labels), ..CadOptions::default() };
    let model = rebuild(&mesh, &options, &Context::new()).unwrap();
    assert!(model.fallback.is_empty(), "{:?}", model.fallback);
    assert_eq!((model.brep.faces.len(), count(&model, SurfaceKind::Cylinder)), (3, 1));
    assert!((model.volume / (2.0 * std::f64::consts::PI) - 1.0).abs() < 1e-9, "{}", model.volume);
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

/// A prism over a section that crosses itself bounds nothing, and the message says so, not what the validator thinks of it.
#[test]
fn a_surface_that_crosses_itself_is_refused_with_the_place() {
    let section = [[0.0, 0.0], [6.0, 0.0], [6.0, 4.0], [2.0, -1.0], [1.0, 4.0], [0.0, 4.0]];
    let ring = |z: f64| section.iter().map(|s| DVec3::new(s[0], s[1], z)).collect::<Vec<_>>();
    let mesh = loft(&[ring(0.0), ring(3.0)]);
    let refused = rebuild(&mesh, &CadOptions::default(), &Context::new()).unwrap_err();
    assert!(
        matches!(&refused, Error::Input { what, place, .. } if what.contains("crosses itself") && !place.is_empty()),
        "{refused}"
    );
}

/// A cylinder over an ellipse weighs right in programs that integrate by the default rule: its profile runs along v, and all of its
/// borders have the knots of the profile. The seam is at both ends of it.
#[test]
fn an_extrusion_of_a_spline_weighs_right_in_other_programs() {
    for turn in [0.0, 0.7] {
        let turned = glam::DQuat::from_euler(glam::EulerRot::XYZ, turn, 0.4 * turn, 2.0 * turn);
        let ring = |z: f64| -> Vec<DVec3> {
            let at = |k: i32| std::f64::consts::TAU * f64::from(k) / 60.0;
            (0..60).map(|k| turned * DVec3::new(3.0 * at(k).cos(), 2.0 * at(k).sin(), z)).collect()
        };
        let model = of(&loft(&[ring(0.0), ring(1.0)]));
        assert!(model.fallback.is_empty(), "{:?}", model.fallback);
        assert_eq!(model.brep.faces.len(), 3);
        let side = model.brep.faces.iter().find(|f| f.trimmed).unwrap();
        let crate::brep::Surface::Spline(surface) = model.brep.surface(side) else { panic!("{side:?}") };
        let [u, v] = surface.knots();
        assert!(u.degree() == 1 && v.degree() == 3 && u.breaks().len() == 2 && v.breaks().len() > 10);
        let [from, to] = v.domain();
        let mut seams = Vec::new();
        for of in side.uses() {
            let edge = &model.brep.edges[of.edge as usize];
            assert!(of.parameters.len() >= 2, "{of:?}");
            for (&[a, b], t) in [of.parameters[0], of.parameters[of.parameters.len() - 1]].iter().zip(edge.range) {
                assert!(surface.point(a, b).distance(edge.curve.point(t)) < 1e-9);
            }
            if of.parameters.len() == 2 {
                seams.push(of.parameters[0][1]);
            } else {
                let crate::brep::Curve::Spline(curve) = &edge.curve else { panic!("{edge:?}") };
                assert_eq!(of.parameters.len(), curve.knots().breaks().len());
            }
        }
        seams.sort_by(f64::total_cmp);
        assert_eq!(seams, [from, to]);
        // The spline through 60 points of an ellipse.
        assert!((model.volume / (6.0 * std::f64::consts::PI) - 1.0).abs() < 1e-4, "{}", model.volume);
    }
}

/// Cones are described by a circle in the middle of their face, not by their apex.
#[test]
fn the_circle_of_a_cone_is_inside_its_face() {
    let ring = |radius: f64, z: f64| -> Vec<DVec3> {
        let at = |k: i32| std::f64::consts::TAU * f64::from(k) / 40.0;
        (0..40).map(|k| DVec3::new(radius * at(k).cos(), radius * at(k).sin(), z)).collect()
    };
    let model = of(&loft(&[ring(2.0, 0.0), ring(1.0, 1.0)]));
    assert_eq!(count(&model, SurfaceKind::Cone), 1);
    let cone = model.brep.surfaces.iter().find_map(|s| match s {
        crate::brep::Surface::Cone { radius, .. } => Some(*radius),
        _ => None,
    });
    assert!((cone.unwrap() - 1.5).abs() < 1e-6, "{cone:?}");
}

/// Where most of a part would be facets and its shape is smooth, smooth faces are made over all of it.
#[test]
fn a_lump_with_one_flat_side_is_no_heap_of_facets() {
    let context = Context::new();
    let sphere = sample::make("icosphere", None, &context).unwrap();
    let lump = |p: DVec3| {
        let q = p.normalize();
        let r = 1.0 + 0.12 * (3.0 * q.x + 1.0).sin() * (2.5 * q.y).cos() + 0.1 * (2.0 * q.z + 4.0 * q.x).sin();
        DVec3::new(1.3 * r * q.x, r * q.y, (0.8 * r * q.z).max(-0.4))
    };
    let points: Vec<DVec3> = sphere.points().iter().map(|&p| lump(p)).collect();
    let triangles: Vec<[u32; 3]> = sphere.faces().iter().map(|f| [f[0], f[1], f[2]]).collect();
    let model = of(&SurfaceMesh::from_triangles(points, &triangles).unwrap());
    assert!(model.brep.faces.len() < 200, "{} {:?}", model.brep.faces.len(), model.fallback);
    assert_eq!(model.brep.solids.len(), 1);
}
