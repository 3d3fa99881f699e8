//! Models of the room as a whole.

use super::*;
use crate::brep::SurfaceKind;
use crate::sample;

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
