//! Models of any size: what a room makes of a model is, but for the unit, what it makes of the same model at a size of one.
//! Coordinates near 1e205 have squares that are infinite, those near 1e-205 squares that are zero.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)] // a test fails by panicking

use carreau::geometry::distance::{Distance, DistanceOptions, compare};
use carreau::geometry::primitive::Primitive;
use carreau::mesh::{Column, CurveNet, SurfaceMesh};
use carreau::remesh::{RemeshOptions, Remeshed};
use carreau::{Context, DVec3, field, hex, quad, remesh, sample, segment, skeleton};

/// Powers of two that the models are multiplied by: 3e-271 to 8e270, and units that are in use.
const POWERS: [i32; 8] = [-900, -500, -30, -3, 3, 30, 500, 900];

/// 2ⁿ · x; a factor of two rounds nothing.
fn times(x: f64, n: i32) -> f64 {
    x * 2f64.powi(n / 2) * 2f64.powi(n - n / 2)
}

fn place(p: DVec3, n: i32) -> DVec3 {
    DVec3::from_array(p.to_array().map(|x| times(x, n)))
}

fn places(points: &[DVec3], n: i32) -> Vec<DVec3> {
    points.iter().map(|&p| place(p, n)).collect()
}

fn moved(mesh: &SurfaceMesh, n: i32) -> SurfaceMesh {
    let mut out = SurfaceMesh::new(places(mesh.points(), n), mesh.faces().clone()).unwrap();
    out.attributes = mesh.attributes.clone();
    out.tagged_edges = mesh.tagged_edges.clone();
    out
}

/// A coarse model whose largest coordinate is between one and two.
fn model(name: &str, resolution: u32) -> SurfaceMesh {
    let mesh = sample::make(name, Some(resolution), &Context::new()).unwrap();
    let largest = mesh.points().iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
    moved(&mesh, -(largest.log2().floor() as i32))
}

fn same_mesh(found: &SurfaceMesh, expected: &SurfaceMesh, n: i32, what: &str) {
    assert_eq!(found.faces(), expected.faces(), "{what} at 2^{n}");
    assert_eq!(found.points(), places(expected.points(), n), "{what} at 2^{n}");
}

fn same_net(found: &CurveNet, expected: &CurveNet, n: i32, what: &str) {
    assert_eq!(found.edges, expected.edges, "{what} at 2^{n}");
    assert_eq!(found.points, places(&expected.points, n), "{what} at 2^{n}");
    let radii: Vec<f64> = expected.radii.iter().map(|&r| times(r, n)).collect();
    assert_eq!(found.radii, radii, "{what} at 2^{n}");
}

/// Radii and points of a surface, in the order of its fields.
fn numbers(primitive: &Primitive) -> (Vec<DVec3>, Vec<f64>) {
    match *primitive {
        Primitive::Plane { origin, .. } => (vec![origin], vec![]),
        Primitive::Cylinder { origin, radius, .. } => (vec![origin], vec![radius]),
        Primitive::Cone { apex, .. } => (vec![apex], vec![]),
        Primitive::Sphere { center, radius } => (vec![center], vec![radius]),
        Primitive::Torus { center, major_radius, minor_radius, .. } => (vec![center], vec![major_radius, minor_radius]),
    }
}

#[test]
fn regions() {
    let mesh = model("bracket", 16);
    let options = segment::SegmentOptions { tolerance: Some(1e-4), ..Default::default() };
    let of = |n: i32| {
        let options = segment::SegmentOptions { tolerance: Some(times(1e-4, n)), ..options.clone() };
        segment::segment(&moved(&mesh, n), &options, &Context::new()).unwrap()
    };
    let expected = of(0);
    assert_eq!(expected.regions.len(), 13);
    for n in POWERS {
        let found = of(n);
        assert_eq!(found.labels, expected.labels, "2^{n}");
        assert_eq!(found.boundaries, expected.boundaries, "2^{n}");
        assert_eq!(found.chosen.tolerance, times(expected.chosen.tolerance, n));
        for (f, e) in found.regions.iter().zip(&expected.regions) {
            assert_eq!([f.rms, f.max], [e.rms, e.max].map(|x| times(x, n)), "2^{n}");
            assert_eq!([f.kmin, f.kmax], [e.kmin, e.kmax].map(|k| times(k, -n)), "2^{n}");
            assert!(f.area.is_finite());
            let ((points, radii), (p, r)) = (numbers(&f.primitive.unwrap()), numbers(&e.primitive.unwrap()));
            assert_eq!(f.primitive.unwrap().kind(), e.primitive.unwrap().kind());
            assert_eq!(points, places(&p, n));
            assert_eq!(radii, r.into_iter().map(|r| times(r, n)).collect::<Vec<_>>());
        }
        for (f, e) in found.junctions.iter().zip(&expected.junctions) {
            assert_eq!((f.position, f.distance), (place(e.position, n), times(e.distance, n)));
        }
    }
}

fn same_sizes(found: &Remeshed, expected: &Remeshed, n: i32, what: &str) {
    same_mesh(&found.mesh, &expected.mesh, n, what);
    assert_eq!(found.quality.shape_min, expected.quality.shape_min, "{what} at 2^{n}");
    let size = |r: &Remeshed| match r.mesh.attributes.vertex.get("size") {
        Some(Column::Scalar(size)) => size.clone(),
        other => panic!("{what}: {other:?}"),
    };
    assert_eq!(size(found), size(expected).into_iter().map(|h| times(h, n)).collect::<Vec<_>>(), "{what} at 2^{n}");
}

#[test]
fn graded_meshes() {
    let mut mesh = model("cube-cylinders", 12);
    let heights: Vec<f64> = mesh.points().iter().map(|p| 0.2 + 0.05 * p.z.abs()).collect();
    let context = Context::new();
    let usual = RemeshOptions { deviation: 16.0, ..Default::default() };
    let cases = [
        ("to an angle", usual.clone()),
        ("to a count", RemeshOptions { triangles: Some(300), ..usual.clone() }),
        ("to a distance", RemeshOptions { distance: Some(0.01), ..usual.clone() }),
        ("of least error", RemeshOptions { geometric: true, triangles: Some(200), ..usual.clone() }),
        ("to given sizes", RemeshOptions { sizes: Some("wanted".into()), ..usual.clone() }),
    ];
    for (what, options) in cases {
        let mut of = |n: i32| {
            let wanted = heights.iter().map(|&h| times(h, n)).collect();
            mesh.attributes.vertex.insert("wanted".into(), Column::Scalar(wanted));
            let options = RemeshOptions { distance: options.distance.map(|d| times(d, n)), ..options.clone() };
            remesh::simplify(&moved(&mesh, n), &options, &context).unwrap()
        };
        let expected = of(0);
        for n in POWERS {
            let found = of(n);
            same_sizes(&found, &expected, n, what);
            let [Some(Column::Scalar(f)), Some(Column::Scalar(e))] =
                [&found, &expected].map(|r| r.mesh.attributes.vertex.get("wanted"))
            else {
                panic!("{what}: the sizes were not carried along")
            };
            assert!(f.iter().zip(e).all(|(f, e)| (f / times(*e, n) - 1.0).abs() < 1e-12), "{what} at 2^{n}");
        }
    }
    let of = |n: i32| remesh::enrich(&moved(&mesh, n), &usual, &context).unwrap();
    let expected = of(0);
    POWERS.into_iter().for_each(|n| same_sizes(&of(n), &expected, n, "enrich"));
}

#[test]
fn frame_fields() {
    let mesh = model("bracket", 16);
    let of = |n: i32| field::field(&moved(&mesh, n), &field::FieldOptions::default(), &Context::new()).unwrap();
    let expected = of(0);
    for n in POWERS {
        let found = of(n);
        same_mesh(&found.mesh, &expected.mesh, n, "field");
        assert_eq!((&found.u, &found.v, found.energy), (&expected.u, &expected.v, expected.energy), "2^{n}");
    }
}

#[test]
fn quads() {
    let mesh = model("wedge", 8);
    let of = |n: i32| {
        let options = quad::QuadOptions { edge_length: Some(times(0.15, n)), ..Default::default() };
        quad::quads(&moved(&mesh, n), &options, &Context::new()).unwrap()
    };
    let expected = of(0);
    for n in POWERS {
        let found = of(n);
        same_mesh(&found.mesh, &expected.mesh, n, "quad");
        assert_eq!(found.quality.distance_max, expected.quality.distance_max, "2^{n}");
    }
}

#[test]
fn motorcycle_graphs() {
    let mesh = model("bracket", 16);
    let of = |n: i32| {
        let options = quad::GraphOptions { edge_length: Some(times(0.1, n)), ..Default::default() };
        quad::motorcycle_graph(&moved(&mesh, n), &options, &Context::new()).unwrap()
    };
    let expected = of(0);
    assert!(!expected.tracks.is_empty());
    for n in POWERS {
        let found = of(n);
        same_mesh(&found.mesh, &expected.mesh, n, "graph");
        assert_eq!((&found.tracks, &found.arcs, &found.nodes), (&expected.tracks, &expected.arcs, &expected.nodes));
        let areas = |graph: &quad::MotorcycleGraph, n: i32| -> Vec<f64> {
            graph.patches.iter().map(|p| times(p.area, 2 * n).min(f64::MAX)).collect()
        };
        assert_eq!(areas(&found, 0), areas(&expected, n), "2^{n}");
    }
}

#[test]
fn skeletons_and_hexes() {
    let context = Context::new();
    let mesh = model("tube-tree", 46);
    let thin = |n: i32| skeleton::extract(&moved(&mesh, n), &skeleton::SkeletonOptions::default(), &context).unwrap();
    let expected = thin(0);
    for n in POWERS {
        let found = thin(n);
        same_net(&found.net, &expected.net, n, "skeleton");
        assert_eq!((&found.preimage, &found.closed.lids.len()), (&expected.preimage, &expected.closed.lids.len()));
        for (f, e) in found.closed.lids.iter().zip(&expected.closed.lids) {
            assert_eq!((f.centre, f.radius), (place(e.centre, n), times(e.radius, n)));
        }
    }
    let points = vec![DVec3::ZERO, DVec3::X, DVec3::new(1.75, 0.5, 0.0), DVec3::new(1.75, -0.5, 0.25)];
    let net = CurveNet::new(points, vec![0.2, 0.25, 0.1, 0.15], vec![[0, 1], [1, 2], [1, 3]]);
    let filled = |n: i32| {
        let radii = net.radii.iter().map(|&r| times(r, n)).collect();
        let net = CurveNet::new(places(&net.points, n), radii, net.edges.clone());
        let options = hex::HexOptions { edge_length: Some(times(0.3, n)), ..Default::default() };
        hex::from_net(&net, &options, &context).unwrap()
    };
    let expected = filled(0);
    for n in POWERS {
        let found = filled(n);
        assert_eq!(found.mesh.hexes, expected.mesh.hexes, "2^{n}");
        assert_eq!(found.mesh.points, places(&expected.mesh.points, n), "2^{n}");
        same_net(&found.skeleton, &expected.skeleton, n, "hex");
        let quality = |r: &hex::HexResult| (r.figures.quality.certified, r.figures.quality.scaled_jacobian_min);
        assert_eq!(quality(&found), quality(&expected), "2^{n}");
    }
}

#[test]
fn hexes_of_surfaces() {
    let mesh = model("tube-tree", 46);
    let options = hex::HexOptions { refine_across: Some(0), padding: hex::Padding::None, ..Default::default() };
    let of = |n: i32| hex::from_surface(&moved(&mesh, n), None, &options, &Context::new()).unwrap();
    let expected = of(0);
    for n in [-500, 700] {
        let found = of(n);
        assert_eq!(found.mesh.hexes, expected.mesh.hexes, "2^{n}");
        assert_eq!(found.mesh.points, places(&expected.mesh.points, n), "2^{n}");
        assert_eq!(found.figures.volume_ratio, expected.figures.volume_ratio, "2^{n}");
    }
}

#[test]
fn distances() {
    let (a, b) = (model("torus", 16), model("torus", 24));
    let options = DistanceOptions { samples: 2000, ..Default::default() };
    let of = |n: i32| compare(&moved(&a, n), &moved(&b, n), &options, &Context::new()).unwrap();
    let expected = of(0);
    let lengths = |d: &Distance| [d.mean, d.rms, d.max, d.max_upper];
    for n in POWERS {
        let found = of(n);
        assert_eq!(found.relative, expected.relative, "2^{n}");
        assert_eq!(lengths(&found.distance), lengths(&expected.distance).map(|x| times(x, n)), "2^{n}");
        assert_eq!(found.a_to_b.max_at, expected.a_to_b.max_at.map(|x| times(x, n)), "2^{n}");
        assert_eq!(found.normal_deg, expected.normal_deg, "2^{n}");
    }
    // One of the two far smaller than the other.
    let apart = compare(&a, &moved(&b, -700), &options, &Context::new()).unwrap();
    assert!(apart.a_to_b.distance.max > 0.4 && apart.a_to_b.distance.max.is_finite());
}
