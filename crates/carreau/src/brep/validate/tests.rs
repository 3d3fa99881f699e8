//! Good models pass; each kind of damage is found.

use super::*;
use crate::brep::tessellate::tessellate;
use crate::brep::{Curve, Surface, models};

fn judged(brep: &Brep) -> Vec<Finding> {
    validate(brep, None, &Limits::new(5.0, 5e-3), &Context::new()).unwrap()
}

/// A model as a mesh of its own, with its faces as regions.
fn as_reference(brep: &Brep, chord: f64) -> (SurfaceMesh, Vec<u32>) {
    let fineness = Fineness { chord, angle: 0.5 };
    let out = tessellate(brep, &fineness, &Context::new()).unwrap();
    let labels = out.face_of.clone();
    (out.mesh().unwrap(), labels)
}

fn with_regions(mut brep: Brep) -> Brep {
    brep.faces.iter_mut().enumerate().for_each(|(k, f)| f.region = Some(k as u32));
    brep
}

fn against(brep: &Brep, mesh: &SurfaceMesh, region_of: &[u32], distance: f64) -> Vec<Finding> {
    let limits = Limits::new(mesh.diagonal(), distance);
    validate(brep, Some(&Reference { mesh, region_of }), &limits, &Context::new()).unwrap()
}

#[test]
fn good_models_pass() {
    for (name, brep, _) in models::all() {
        assert_eq!(judged(&brep), [], "{name}");
        let brep = with_regions(brep);
        for chord in [0.05, 0.01] {
            let (mesh, regions) = as_reference(&brep, chord);
            assert_eq!(against(&brep, &mesh, &regions, 5e-3), [], "{name} {chord}");
        }
    }
}

/// A model by name, after a change.
fn damaged(name: &str, change: impl Fn(&mut Brep)) -> Vec<Fault> {
    let mut brep = models::all().into_iter().find(|m| m.0 == name).unwrap().1;
    change(&mut brep);
    let mut faults: Vec<Fault> = judged(&brep).iter().map(|f| f.fault).collect();
    faults.dedup();
    faults
}

#[test]
fn damage_is_found() {
    let has = |faults: Vec<Fault>, wanted: Fault| assert!(faults.contains(&wanted), "{wanted:?} not in {faults:?}");
    has(damaged("bored", |b| b.faces[0].loops[0][0].reversed = false), Fault::EdgeUses);
    // A bore of another radius: its rings are off the cylinder.
    let widened = |b: &mut Brep| {
        if let Surface::Cylinder { radius, .. } = &mut b.surfaces[0] {
            *radius += 1e-3;
        }
    };
    has(damaged("bored", widened), Fault::EdgeOffSurface);
    has(damaged("box", |b| b.vertices[0].point.z += 1e-3), Fault::VertexOffEdge);
    has(damaged("box", |b| b.vertices[0].tolerance = 1e-2), Fault::LargeTolerance);
    has(damaged("box", |b| b.faces[0].same_sense = false), Fault::InvertedLoop);
    // A tube without its seam winds round.
    let unseamed = |b: &mut Brep| {
        let uses = b.faces[0].loops[0].clone();
        b.faces[0].loops = vec![vec![uses[0].clone()], vec![uses[2].clone()]];
    };
    has(damaged("bored", unseamed), Fault::OpenLoop);
}

#[test]
fn another_body_is_not_that_of_the_mesh() {
    let bored = with_regions(models::block(0.5));
    let (mesh, regions) = as_reference(&bored, 0.02);
    let wide = with_regions(models::block(0.6));
    let faults: Vec<Fault> = against(&wide, &mesh, &regions, 5e-3).iter().map(|f| f.fault).collect();
    assert!(faults.contains(&Fault::MeshOffFace) && faults.contains(&Fault::FaceOffMesh), "{faults:?}");
    let mut whole = with_regions(models::block(0.0));
    // The bore is the first face of the other.
    whole.faces.iter_mut().for_each(|f| f.region = f.region.map(|r| r + 1));
    let faults: Vec<Fault> = against(&whole, &mesh, &regions, 5e-3).iter().map(|f| f.fault).collect();
    assert!(faults.contains(&Fault::EulerCharacteristic) && faults.contains(&Fault::Volume), "{faults:?}");
    // A bore that is turned inside out.
    let mut turned = bored.clone();
    turned.faces[0].same_sense = true;
    let faults: Vec<Fault> = against(&turned, &mesh, &regions, 5e-3).iter().map(|f| f.fault).collect();
    assert!(faults.contains(&Fault::TurnedNormal) || faults.contains(&Fault::InvertedLoop), "{faults:?}");
}

#[test]
fn bodies_that_cross_are_found_and_neighbours_are_not() {
    let two = |shift: f64| {
        let (a, b) = (models::block(0.0), models::sphere());
        let by = crate::brep::Motion {
            scale: 0.6,
            translation: DVec3::new(shift, 0.0, 2.0),
            ..crate::brep::Motion::IDENTITY
        };
        joined(a, b.moved(&by))
    };
    let faults = |brep: &Brep| judged(brep).iter().map(|f| f.fault).collect::<Vec<_>>();
    assert!(faults(&two(1.2)).contains(&Fault::CrossingFaces));
    assert_eq!(faults(&two(2.5)), []);
    assert_eq!(faults(&two(0.0)), []);
}

/// Two models in one.
fn joined(mut a: Brep, b: Brep) -> Brep {
    let (v, e, s, f, h) = (a.vertices.len(), a.edges.len(), a.surfaces.len(), a.faces.len(), a.shells.len());
    a.vertices.extend(b.vertices);
    a.edges.extend(b.edges.into_iter().map(|x| crate::brep::Edge { ends: x.ends.map(|k| k + v as u32), ..x }));
    a.surfaces.extend(b.surfaces);
    a.faces.extend(b.faces.into_iter().map(|mut x| {
        x.surface += s as u32;
        x.loops.iter_mut().flatten().for_each(|of| of.edge += e as u32);
        x.poles.iter_mut().for_each(|p| *p += v as u32);
        x
    }));
    a.shells.extend(b.shells.into_iter().map(|mut x| {
        x.faces.iter_mut().for_each(|k| *k += f as u32);
        x
    }));
    a.solids.extend(b.solids.into_iter().map(|mut x| {
        x.outer += h as u32;
        x
    }));
    a.check().unwrap();
    a
}

#[test]
fn a_short_edge_is_found() {
    let mut brep = models::block(0.0);
    brep.vertices[0].tolerance = 1e-5;
    let (curve, range) = Curve::segment(brep.point(0), brep.point(0) + 1e-5 * DVec3::X);
    brep.edges[0] = crate::brep::Edge { curve, range, ..brep.edges[0].clone() };
    assert!(judged(&brep).iter().any(|f| f.fault == Fault::ShortEdge));
}
