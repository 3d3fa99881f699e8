//! Creases at the size of elements: all sharp edges of parts, with noise or without, and little of what noise makes sharp.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)] // a test fails by panicking

use carreau::geometry::features::{Creases, FeatureOptions, Features, feature_edges, length_of_squares};
use carreau::geometry::normals::{face_normals, vertex_normals};
use carreau::geometry::search_tree::TriangleTree;
use carreau::mesh::{CornerId, Polygons, SurfaceMesh, VertexId};
use carreau::{Context, DVec3, sample};

fn model(name: &str, resolution: u32) -> SurfaceMesh {
    sample::make(name, Some(resolution), &Context::new()).unwrap().triangulated().unwrap()
}

fn ends(mesh: &SurfaceMesh, features: &Features) -> Vec<[u32; 2]> {
    features.edges(mesh).map(|c| [c, mesh.next(c)].map(|c| mesh.vertex(c).0)).collect()
}

fn found(mesh: &SurfaceMesh, squares: f64) -> Features {
    feature_edges(mesh, &FeatureOptions::auto().for_squares(mesh, squares)).unwrap()
}

fn mean_edge(mesh: &SurfaceMesh) -> f64 {
    let length = |c: CornerId| mesh.point(mesh.vertex(c)).distance(mesh.point(mesh.vertex(mesh.next(c))));
    (0..mesh.corner_count()).map(|c| length(CornerId::new(c))).sum::<f64>() / mesh.corner_count() as f64
}

/// Vertices moved along the normals by a normal distribution of `share` mean edges.
fn noisy(mesh: &SurfaceMesh, share: f64) -> SurfaceMesh {
    let normals = vertex_normals(mesh, &face_normals(mesh));
    let width = share * mean_edge(mesh);
    let mut state = 1u64;
    let mut uniform = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        ((state >> 11) as f64 + 0.5) / (1u64 << 53) as f64
    };
    let mut normal = || (-2.0 * uniform().ln()).sqrt() * (std::f64::consts::TAU * uniform()).cos();
    let points = mesh.points().iter().zip(&normals).map(|(p, n)| *p + *n * (width * normal())).collect();
    SurfaceMesh::new(points, mesh.faces().clone()).unwrap()
}

/// Share of the length of edges that is within a distance of others.
fn share_near(a: (&SurfaceMesh, &[[u32; 2]]), b: (&SurfaceMesh, &[[u32; 2]]), near: f64) -> f64 {
    let tree = TriangleTree::of_segments(b.0.points(), b.1.iter().copied());
    let (mut hit, mut all) = (0.0, 0.0);
    for ends in a.1 {
        let [p, q] = ends.map(|v| a.0.points()[v as usize]);
        let pieces = (4.0 * p.distance(q) / near).ceil().max(1.0);
        for k in 0..pieces as usize {
            let at = p.lerp(q, (k as f64 + 0.5) / pieces);
            let weight = p.distance(q) / pieces;
            all += weight;
            hit += if tree.closest(at).is_some_and(|found| found.distance() <= near) { weight } else { 0.0 };
        }
    }
    if all > 0.0 { hit / all } else { 1.0 }
}

#[test]
fn parts_keep_every_sharp_edge() {
    for sample in sample::SAMPLES.iter().filter(|s| s.name != "noisy-torus") {
        let mesh = sample::make(sample.name, None, &Context::new()).unwrap();
        let every = feature_edges(&mesh, &FeatureOptions::default()).unwrap();
        for squares in [50.0, 800.0, 3000.0, 50_000.0] {
            let auto = found(&mesh, squares);
            assert_eq!(auto.corners, every.corners, "{} at {squares}", sample.name);
            assert!(auto.dropped.is_empty() && auto.longest_dropped.is_none());
        }
    }
}

#[test]
fn noise_hides_no_edge_and_makes_few() {
    // Of an edge: how far vertices move, the least recall and the least precision.
    for (share, recall, precision) in [(0.01, 0.98, 0.95), (0.03, 0.95, 0.90), (0.1, 0.80, 0.80)] {
        for (name, resolution) in [("bracket", 70), ("cube-cylinders", 60), ("wedge", 60), ("cylinder", 50)] {
            let clean = model(name, resolution);
            let truth = ends(&clean, &feature_edges(&clean, &FeatureOptions::default()).unwrap());
            let mesh = noisy(&clean, share);
            let kept = ends(&mesh, &found(&mesh, 3000.0));
            let near = 0.5 * length_of_squares(&mesh, 3000.0);
            let r = share_near((&clean, &truth), (&mesh, &kept), near);
            let p = share_near((&mesh, &kept), (&clean, &truth), near);
            assert!(r >= recall && p >= precision, "{name} with noise of {share}: recall {r:.3}, precision {p:.3}");
        }
    }
}

/// Two meshes as one.
fn together(a: &SurfaceMesh, b: &SurfaceMesh) -> SurfaceMesh {
    let shift = a.vertex_count() as u32;
    let points = a.points().iter().chain(b.points()).copied().collect();
    let mut faces = Polygons::new();
    a.faces().iter().for_each(|f| faces.push(f));
    b.faces().iter().for_each(|f| faces.push(&f.iter().map(|v| v + shift).collect::<Vec<_>>()));
    SurfaceMesh::new(points, faces).unwrap()
}

fn moved(mesh: &SurfaceMesh, by: impl Fn(DVec3) -> DVec3) -> SurfaceMesh {
    SurfaceMesh::new(mesh.points().iter().map(|&p| by(p)).collect(), mesh.faces().clone()).unwrap()
}

/// A noisy sphere with a block on it that is smaller than an element of 500 squares.
fn scan() -> SurfaceMesh {
    let ball = noisy(&model("icosphere", 60), 0.2);
    let block = model("wedge", 12);
    let size = 0.03 / block.diagonal();
    together(&ball, &moved(&block, |p| p * size + DVec3::splat(2.0)))
}

#[test]
fn noise_goes_and_what_ends_at_itself_stays() {
    let mesh = scan();
    let every = feature_edges(&mesh, &FeatureOptions::default()).unwrap();
    let block = |e: &[u32; 2]| mesh.points()[e[0] as usize].length() > 1.8;
    let drawn = |features: &Features| ends(&mesh, features).iter().filter(|e| block(e)).count();
    for squares in [500.0, 3000.0] {
        let auto = found(&mesh, squares);
        let kept = auto.edges(&mesh).count();
        let (all, of_block) = (every.edges(&mesh).count(), drawn(&every));
        assert!(of_block >= 9 && all > 20 * of_block, "{all} {of_block}");
        assert_eq!(drawn(&auto), of_block, "a block stays, however small");
        assert!(kept < of_block + (all - of_block) / 20, "{kept} of {all}");
        assert_eq!(auto.dropped.len() + kept, all);
        assert!(auto.noise.is_high() && auto.noise.spread_deg > 5.0);
        let longest = auto.longest_dropped.unwrap();
        assert!(longest.length > 0.0 && (longest.place.length() - 1.0).abs() < 0.2, "{longest:?}");
    }
}

#[test]
fn tags_lists_and_borders_are_features_in_any_noise() {
    let mut mesh = scan();
    let listed = [0, 1].map(|k| VertexId(mesh.faces().face(100)[k]));
    let tagged = [0, 1].map(|k| VertexId(mesh.faces().face(900)[k]));
    mesh.tagged_edges = vec![carreau::mesh::TaggedEdge { ends: tagged, tag: 3 }];
    let options = FeatureOptions { edges: vec![listed], ..FeatureOptions::auto().for_squares(&mesh, 3000.0) };
    let kept = ends(&mesh, &feature_edges(&mesh, &options).unwrap());
    for [a, b] in [listed, tagged] {
        assert!(kept.iter().any(|e| *e == [a.0, b.0] || *e == [b.0, a.0]));
    }
}

#[test]
fn loose_edges_beside_tagged_ones_are_no_noise() {
    // Pins: edges that fan out from a vertex that stands out, and end in a flat.
    let clean = model("bracket", 40);
    let normals = vertex_normals(&clean, &face_normals(&clean));
    let sharp = ends(&clean, &feature_edges(&clean, &FeatureOptions::default()).unwrap());
    let is_flat = |v: &usize| sharp.iter().flatten().all(|&w| w as usize != *v);
    let mut points = clean.points().to_vec();
    let pins: Vec<usize> = (0..points.len()).filter(is_flat).step_by(400).collect();
    pins.iter().for_each(|&v| points[v] += 1.5 * mean_edge(&clean) * normals[v]);
    let mut mesh = SurfaceMesh::new(points, clean.faces().clone()).unwrap();
    let every = feature_edges(&mesh, &FeatureOptions::default()).unwrap();
    assert!(every.edges(&mesh).count() > sharp.len() + pins.len(), "pins have sharp edges");
    assert!(found(&mesh, 3000.0).dropped.is_empty());
    mesh.tagged_edges = sharp.iter().map(|&e| carreau::mesh::TaggedEdge { ends: e.map(VertexId), tag: 1 }).collect();
    let tagged = found(&mesh, 3000.0);
    assert!(tagged.dropped.is_empty() && !tagged.noise.is_high(), "{:?}", tagged.noise);
}

#[test]
fn creases_are_those_of_the_shape() {
    let mesh = noisy(&model("bracket", 50), 0.15);
    let size = length_of_squares(&mesh, 2000.0);
    let at = |mesh: &SurfaceMesh, size: f64| {
        let options = FeatureOptions { creases: Creases::AtSize(size), ..FeatureOptions::default() };
        feature_edges(mesh, &options).unwrap()
    };
    let expected = at(&mesh, size);
    assert!(expected.noise.is_high() && !expected.dropped.is_empty());
    // Another unit, to the bit.
    let large = at(&moved(&mesh, |p| p * 1024.0), 1024.0 * size);
    assert_eq!((&large.corners, &large.dropped), (&expected.corners, &expected.dropped));
    // Other numbers of the faces: the same edges.
    let mut faces = Polygons::new();
    (0..mesh.face_count()).rev().for_each(|f| faces.push(mesh.faces().face(f)));
    let other = SurfaceMesh::new(mesh.points().to_vec(), faces).unwrap();
    let sorted = |mesh: &SurfaceMesh, features: &Features| {
        let mut all: Vec<_> = ends(mesh, features).into_iter().map(|[a, b]| [a.min(b), a.max(b)]).collect();
        all.sort_unstable();
        all
    };
    assert_eq!(sorted(&other, &at(&other, size)), sorted(&mesh, &expected));
}
