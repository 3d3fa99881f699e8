//! Every stage for itself, on sample models: what must hold by construction is asserted, not how good it looks.

use super::cell::Cell;
use super::cut::cut;
use super::decimate::decimate;
use super::extract::extract;
use super::flat::Flat;
use super::framed::{Framed, previous};
use super::integers::{Curves, choose, goals};
use super::lattice::{Lattice, Unknowns};
use super::locate::Locator;
use super::seamless::{Map, seamless};
use super::strips::Strips;
use super::{QuadMap, Wish, fewest};
use crate::context::Context;
use crate::geometry::features::FeatureOptions;
use crate::mesh::{HalfEdges, NONE, SurfaceMesh, Topology};
use crate::quad::coarse::{Follow, coarse, field_of};
use crate::quad::source::Source;
use crate::sample;
use std::f64::consts::FRAC_PI_2;

const QUADS: usize = 600;

fn source(name: &str, context: &Context) -> Source {
    let mesh = sample::make(name, None, context).unwrap();
    Source::new(&mesh, &FeatureOptions::default(), context).unwrap()
}

fn framed(source: &Source, context: &Context) -> (Framed, f64) {
    let length = (source.area / QUADS as f64).sqrt();
    let coarse = coarse(source, 0.9 * length, Follow::even(0.5), 35.0, context).unwrap().unwrap();
    (Framed::new(&coarse, &field_of(&coarse, source, 0.0, context).unwrap()).unwrap(), length)
}

fn mapped(name: &str, context: &Context) -> (Source, Framed, Map) {
    let source = source(name, context);
    let (framed, length) = framed(&source, context);
    let map = seamless(&framed, cut(&framed).unwrap(), length, context).unwrap().unwrap();
    (source, framed, map)
}

/// Edges are the same on both sides, but for right angles; faces close and have area.
fn assert_flat(flat: &Flat) {
    for f in flat.faces() {
        let sides = [0, 1, 2].map(|k| *flat.side(3 * f + k));
        assert!(sides.iter().map(|s| s.vector).sum::<glam::DVec2>().length() < 1e-6);
        assert!(flat.area(f) > 0.0);
        for (k, side) in (0u32..).zip(&sides).filter(|(_, s)| s.opposite != NONE) {
            let across = flat.side(side.opposite);
            assert_eq!(across.opposite, 3 * f + k);
            assert_eq!((across.turn + side.turn).rem_euclid(4), 0);
            assert!((super::framed::turned(side.vector, side.turn) + across.vector).length() < 1e-6);
            assert_eq!(across.curve, side.curve);
        }
    }
}

fn total_area(flat: &Flat) -> f64 {
    flat.faces().map(|f| flat.area(f)).sum::<f64>() / 2.0
}

#[test]
fn quads_of_the_field_make_the_euler_number() {
    // Σ (4 − quads) = 4 χ on closed surfaces, with and without features.
    let context = Context::new();
    for (name, euler) in [("torus", 0), ("icosphere", 2)] {
        let framed = framed(&source(name, &context), &context).0;
        assert_eq!(framed.quads.iter().map(|q| 4 - q).sum::<i32>(), 4 * euler, "{name}");
    }
}

#[test]
fn angles_of_the_map_are_right_angles_times_quads() {
    let context = Context::new();
    for name in ["torus", "icosphere", "bracket"] {
        let (_, framed, map) = mapped(name, &context);
        assert!(map.wrong_angles(&framed).is_empty(), "{name}");
        assert!(
            (0..framed.triangles.len())
                .all(|t| { map.along(3 * t as u32).perp_dot(-map.along(previous(3 * t as u32))) > 0.0 })
        );
        assert_flat(&Flat::new(&framed, &map));
    }
}

#[test]
fn features_run_along_the_axes_of_the_map() {
    let context = Context::new();
    let (_, framed, map) = mapped("bracket", &context);
    let on = (0..framed.curve.len() as u32).filter(|&h| framed.curve[h as usize] != NONE);
    assert!(on.map(|h| map.along(h)).all(|d| d.x.abs().min(d.y.abs()) < 1e-6 * d.length().max(1.0)));
}

#[test]
fn decimation_keeps_the_metric_and_leaves_the_cones() {
    let context = Context::new();
    for name in ["icosphere", "bracket", "torus", "open-torus", "tube-tree", "cube-cylinders"] {
        let (_, framed, map) = mapped(name, &context);
        let mut flat = Flat::new(&framed, &map);
        let before = total_area(&flat);
        let left = decimate(&mut flat, &framed.is_kept, &context).unwrap();
        assert_flat(&flat);
        assert!((total_area(&flat) - before).abs() < 1e-6 * before, "{name}");
        let kept = framed.is_kept.iter().filter(|k| **k).count();
        assert_eq!(flat.at.iter().filter(|h| **h != NONE).count(), kept + left, "{name}");
        assert!(left * 50 < framed.points.len(), "{name}: {left} of {}", framed.points.len());
        // Signposts still tell the angles, all around.
        for v in (0..flat.at.len() as u32).filter(|&v| flat.at[v as usize] != NONE) {
            let (star, is_closed) = flat.star(v).unwrap();
            let whole: f64 = star.iter().map(|&h| flat.corner_angle(h)).sum();
            assert!((whole - f64::from(framed.quads[v as usize]) * FRAC_PI_2).abs() < 1e-4);
            for pair in star.windows(2) {
                let turn = flat.side(pair[1]).post - flat.side(pair[0]).post - flat.corner_angle(pair[0]);
                let around = if is_closed { whole } else { f64::INFINITY };
                assert!(turn.abs() < 1e-5 || (turn.abs() - around).abs() < 1e-5, "{name} {turn} of {whole}");
            }
        }
    }
}

#[test]
fn closed_assignments_close_and_are_whole_with_the_right_parities() {
    let context = Context::new();
    let (_, framed, map) = mapped("icosphere", &context);
    let mut flat = Flat::new(&framed, &map);
    decimate(&mut flat, &framed.is_kept, &context).unwrap();
    let unknowns = Unknowns::new(&flat, &goals(&flat, &vec![1.0; framed.points.len()], &Curves::default()));
    let order: Vec<u32> = (0..unknowns.real.len() as u32).collect();
    let lattice = Lattice::new(&unknowns, &order, &context).unwrap().unwrap();
    let mut whole: Vec<i64> = Vec::new();
    for k in 0..lattice.free.len() {
        let n = 7 * k as i64 % 11 - 5;
        whole.push(n + lattice.is_odd(k, &whole).map_or(0, |odd| i64::from(odd != (n % 2 != 0))));
    }
    let of = |c: usize| lattice.of_free[c].iter().map(|t| t.1 * whole[t.0 as usize] as f64).sum::<f64>();
    let q: Vec<f64> = (0..unknowns.real.len()).map(of).collect();
    assert!(q.iter().all(|q| (q - q.round()).abs() < 1e-9));
    for f in 0..unknowns.faces.len() {
        let edges = [0, 1, 2].map(|k| unknowns.cells(f, k, &q));
        assert_eq!(edges[0] + edges[1] + edges[2], Cell::ZERO);
    }
}

#[test]
fn whole_faces_close_are_positive_and_their_quads_have_the_euler_number() {
    let context = Context::new();
    for name in ["icosphere", "bracket", "torus", "open-torus", "tube-tree", "cube-cylinders"] {
        let (source, framed, map) = mapped(name, &context);
        let mut flat = Flat::new(&framed, &map);
        decimate(&mut flat, &framed.is_kept, &context).unwrap();
        assert!(
            choose(&mut flat, &mut vec![1.0; framed.points.len()], &Curves::default(), &context).unwrap(),
            "{name}"
        );
        for f in flat.faces() {
            let cells = [0, 1, 2].map(|k| flat.side(3 * f + k).cells);
            assert_eq!(cells[0] + cells[1] + cells[2], Cell::ZERO);
            assert!(flat.cells(f) > 0);
        }
        let (work, of) = extract(&flat, &framed, &Locator::new(&framed, &map, 1.0), &context).unwrap().unwrap();
        assert!(of.len() == work.faces.len() && of.iter().all(|&f| flat.is_alive[f as usize]));
        let count = flat.faces().map(|f| flat.cells(f)).sum::<i64>();
        assert_eq!(2 * work.faces.len() as i64, count, "{name}");
        let mesh = SurfaceMesh::new(work.points.clone(), work.faces.clone()).unwrap();
        let (has, had) = (Topology::of(&mesh), Topology::of(&source.surface.mesh));
        assert_eq!((has.euler, has.components, has.boundary_loops), (had.euler, had.components, had.boundary_loops));
        assert_eq!(has.nonmanifold_edges + has.nonmanifold_vertices + has.inconsistent_edges, 0, "{name}");
        // Features are edges of quads.
        let half_edges = HalfEdges::new(&work.faces, work.points.len());
        assert!(work.features.iter().all(|([a, b], _)| half_edges.find(*a, *b).is_some()));
    }
}

fn assert_whole(flat: &Flat, name: &str) {
    for f in flat.faces() {
        let sides = [0, 1, 2].map(|k| *flat.side(3 * f + k));
        assert_eq!(sides.iter().fold(Cell::ZERO, |sum, s| sum + s.cells), Cell::ZERO, "{name}");
        assert!(flat.cells(f) > 0, "{name}");
        for side in sides.iter().filter(|side| side.opposite != NONE) {
            assert_eq!(side.cells.turned(side.turn) + flat.side(side.opposite).cells, Cell::ZERO, "{name}");
        }
    }
}

#[test]
fn strips_give_cells_to_faces_that_have_none() {
    let context = Context::new();
    // Without a cone, as on a torus, no single strip gives a cell to anything.
    for name in ["icosphere", "open-torus", "tube-tree"] {
        let (source, framed, map) = mapped(name, &context);
        let mut flat = Flat::new(&framed, &map);
        decimate(&mut flat, &framed.is_kept, &context).unwrap();
        let curves = Curves { factor: vec![1.0; source.paths.len()], fewest: vec![0; source.paths.len()] };
        let goal = goals(&flat, &vec![1.0; framed.points.len()], &curves);
        // No edge has a cell: that closes, too.
        flat.sides.iter_mut().for_each(|side| side.cells = Cell::ZERO);
        assert!(Strips::new(&mut flat, goal, &curves.fewest).give_cells(&context).unwrap(), "{name}");
        assert_whole(&flat, name);
    }
}

#[test]
fn strips_give_curves_the_edges_that_they_need() {
    let context = Context::new();
    for name in ["bracket", "open-torus", "cube-cylinders", "wedge"] {
        let (source, framed, map) = mapped(name, &context);
        let mut flat = Flat::new(&framed, &map);
        decimate(&mut flat, &framed.is_kept, &context).unwrap();
        let mut stretch = vec![1.0; framed.points.len()];
        let curves = Curves { factor: vec![1.0; source.paths.len()], fewest: vec![0; source.paths.len()] };
        assert!(choose(&mut flat, &mut stretch, &curves, &context).unwrap(), "{name}");
        let edges = |flat: &Flat| flat.edges_of_curves(source.paths.len());
        let more: Vec<usize> = edges(&flat).into_iter().map(|n| if n > 0 { n as usize + 3 } else { 0 }).collect();
        assert!(more.iter().any(|&n| n > 0), "{name} has features");
        let goal = goals(&flat, &stretch, &curves);
        assert_eq!(Strips::new(&mut flat, goal, &more).lengthen_curves(&context).unwrap(), 0, "{name}");
        assert!(edges(&flat).iter().zip(&more).all(|(&has, &needs)| has >= needs as i64), "{name}");
        assert_whole(&flat, name);
    }
}

#[test]
fn the_number_of_quads_is_met() {
    let context = Context::new();
    for quads in [300, 1200] {
        let source = source("icosphere", &context);
        let length = (source.area / quads as f64).sqrt();
        let wish = Wish { length, quads: Some(quads), working: 0.9, feature_deg: 35.0 };
        let (framed, _) = framed(&source, &context);
        let mut map = QuadMap::of_frames(framed, fewest(&source), &wish, &context).unwrap().unwrap();
        let work = map.quads(&wish, &context).unwrap().unwrap();
        assert!(work.faces.len().abs_diff(quads) * 20 <= quads, "{} of {quads}", work.faces.len());
    }
}

#[test]
fn quads_are_smaller_where_others_came_to_nothing_and_their_number_is_met() {
    let context = Context::new();
    let (quads, source) = (2000, source("tube-tree", &context));
    let length = (source.area / quads as f64).sqrt();
    let wish = Wish { length, quads: Some(quads), working: 0.9, feature_deg: 35.0 };
    let mut map = QuadMap::of_frames(framed(&source, &context).0, fewest(&source), &wish, &context).unwrap().unwrap();
    let before = map.quads(&wish, &context).unwrap().unwrap();
    let heights = |work: &super::Work| -> Vec<f64> {
        work.faces.iter().map(|face| face.iter().map(|&v| work.points[v as usize].z).sum::<f64>() / 4.0).collect()
    };
    let mut sorted = heights(&before);
    sorted.sort_by(f64::total_cmp);
    let limit = sorted[sorted.len() * 9 / 10];
    let on_top = |work: &super::Work| -> Vec<usize> {
        heights(work).iter().enumerate().filter(|h| *h.1 > limit).map(|h| h.0).collect()
    };
    let top = on_top(&before);
    (0..2).for_each(|_| map.refine(top.iter().copied()));
    let after = map.quads(&wish, &context).unwrap().unwrap();
    assert!(after.faces.len().abs_diff(quads) * 10 <= quads, "{} of {quads}", after.faces.len());
    assert!(on_top(&after).len() * 10 > top.len() * 11, "{} of {}", on_top(&after).len(), top.len());
}
