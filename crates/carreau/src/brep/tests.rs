//! Masses, evaluation and structure of the hand-made models.

use super::*;
use crate::context::Context;
use glam::{DMat3, DQuat};

fn turned() -> Motion {
    let axis = DVec3::new(0.3, -0.5, 0.8).normalize();
    Motion {
        rotation: DMat3::from_quat(DQuat::from_axis_angle(axis, 0.7)),
        scale: 8.0,
        translation: DVec3::new(30.0, -20.0, 10.0),
    }
}

#[test]
fn volumes_are_those_of_the_formulas() {
    for (name, brep, volume) in models::all() {
        let mass = brep.mass(&Context::new()).unwrap();
        // The bore's mouths are interpolated, to 1e-10 or so.
        assert!((mass.volume / volume - 1.0).abs() < 1e-9, "{name}: {} for {volume}", mass.volume);
        assert!(mass.area > 0.0, "{name}");
        let faces = brep.face_masses(&Context::new()).unwrap();
        assert!(faces.iter().all(|f| f.area > 0.0), "{name}: {faces:?}");
        let solids = brep.solid_masses(&faces);
        assert!((solids[0].volume - mass.volume).abs() < 1e-12 * volume, "{name}");
    }
}

#[test]
fn areas_and_centroids_of_simple_bodies() {
    let pi = std::f64::consts::PI;
    let find = |name: &str| models::all().into_iter().find(|m| m.0 == name).unwrap().1;
    let mass = |name: &str| find(name).mass(&Context::new()).unwrap();
    let near = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-10;
    assert!(near(mass("box").area, 52.0));
    assert!(near(mass("bored").area, 52.0 - 2.0 * pi * 0.25 + pi * 4.0));
    assert!(near(mass("cone").area, pi + pi * 5f64.sqrt()));
    assert!(near(mass("sphere").area, 4.0 * pi));
    assert!(near(mass("torus").area, 4.0 * pi * pi));
    assert!(mass("cone").centroid().distance(DVec3::new(0.0, 0.0, 0.5)) < 1e-9);
    assert!(mass("bored").centroid().distance(DVec3::new(0.0, 0.0, 2.0)) < 1e-9);
    // The oblique cylinder's centroid is moved by r² h'² / … : x = 1/16, z = (4 + 1/16) / 4.
    assert!(mass("oblique").centroid().distance(DVec3::new(0.0625, 0.0, 1.015_625)) < 1e-9);
}

#[test]
fn masses_move_with_the_model() {
    let by = turned();
    for (name, brep, volume) in models::all() {
        let moved = brep.moved(&by);
        moved.check().unwrap();
        let (a, b) = (brep.mass(&Context::new()).unwrap(), moved.mass(&Context::new()).unwrap());
        assert!((b.volume / (512.0 * volume) - 1.0).abs() < 1e-9, "{name}");
        assert!((b.area / (64.0 * a.area) - 1.0).abs() < 1e-9, "{name}");
        assert!(b.centroid().distance(by.point(a.centroid())) < 1e-8, "{name}");
    }
}

#[test]
fn points_of_curves_and_surfaces_project_to_themselves() {
    for (name, brep, _) in models::all() {
        for edge in &brep.edges {
            for k in 0..=20 {
                let t = edge.parameter_at(f64::from(k) / 20.0);
                let p = edge.curve.point(t);
                assert!(edge.curve.distance(p) < 1e-9, "{name} {}", edge.curve.kind().name());
                assert!(edge.curve.point(edge.curve.project_near(p, t + 1e-3)).distance(p) < 1e-9, "{name}");
                let h = 1e-5;
                let [_, d, dd] = edge.curve.derivatives(t);
                let (before, after) = (edge.curve.point(t - h), edge.curve.point(t + h));
                if k > 0 && k < 20 && edge.curve.kind() != CurveKind::Spline {
                    assert!(d.distance((after - before) / (2.0 * h)) < 1e-6, "{name}");
                    assert!(dd.distance((after - 2.0 * p + before) / (h * h)) < 1e-3, "{name}");
                }
            }
        }
        for surface in &brep.surfaces {
            for (u, v) in [(0.3, 0.2), (-0.7, 0.9), (0.8, 0.5)] {
                let v = if let Surface::Cone { .. } = surface { v + 0.1 } else { v };
                let u = if let Surface::Extrusion { .. } = surface { 0.5 + 0.3 * u } else { u };
                let jet = surface.jet(u, v);
                let kind = surface.kind().name();
                assert!(surface.point(u, v).distance(jet.point) < 1e-12, "{kind}");
                let [a, b] = surface.project(jet.point);
                assert!(surface.point(a, b).distance(jet.point) < 1e-9, "{kind}");
                let n = surface.normal(u, v);
                assert!(n.distance(jet.first[0].cross(jet.first[1]).normalize()) < 1e-9, "{kind}");
                let h = 1e-5;
                let du = (surface.point(u + h, v) - surface.point(u - h, v)) / (2.0 * h);
                let dv = (surface.point(u, v + h) - surface.point(u, v - h)) / (2.0 * h);
                assert!(du.distance(jet.first[0]) < 1e-6 && dv.distance(jet.first[1]) < 1e-6, "{kind}");
                // A point beside the surface comes back to where it left.
                let [a, b] = surface.project_near(jet.point + 0.01 * n, [u + 0.05, v + 0.05]);
                assert!(surface.point(a, b).distance(jet.point) < 1e-8, "{kind}");
            }
        }
    }
}

#[test]
fn reversed_curves_run_backwards() {
    for (_, brep, _) in models::all() {
        for edge in &brep.edges {
            let (back, range) = edge.curve.reversed(edge.range);
            let turned = Edge { curve: back, range, ends: [edge.ends[1], edge.ends[0]], tolerance: 0.0 };
            for k in 0..=8 {
                let s = f64::from(k) / 8.0;
                assert!(turned.point_at(s).distance(edge.point_at(1.0 - s)) < 1e-12);
            }
        }
    }
}

#[test]
fn curvatures_agree_with_those_of_the_second_fundamental_form() {
    let torus = Surface::Torus {
        frame: Frame::along(DVec3::ONE, DVec3::new(1.0, 2.0, 3.0)),
        major_radius: 3.0,
        minor_radius: 1.0,
    };
    assert!((torus.principal_curvatures(1.0, 0.0)[1] - 1.0).abs() < 1e-12);
    assert!((torus.principal_curvatures(1.0, std::f64::consts::PI)[0] + 0.5).abs() < 1e-12);
    let sphere = Surface::Sphere { frame: Frame::along(DVec3::ZERO, DVec3::Z), radius: 2.0 };
    assert_eq!(sphere.principal_curvatures(0.1, 0.2), [0.5, 0.5]);
    let profile = Curve::Circle { frame: Frame { origin: 3.0 * DVec3::X, z: -DVec3::Y, x: DVec3::X }, radius: 1.0 };
    let frame = Frame { origin: DVec3::ZERO, z: DVec3::Z, x: DVec3::X };
    let revolved = Surface::Revolution { profile, frame };
    for v in [0.0, 0.5, 2.0, 3.0] {
        let (a, b) = (revolved.principal_curvatures(0.3, v), torus.principal_curvatures(0.3, v));
        assert!((a[0] - b[0]).abs() < 1e-9 && (a[1] - b[1]).abs() < 1e-9, "{v}: {a:?} {b:?}");
    }
}
