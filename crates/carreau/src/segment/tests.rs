//! The room as a whole: models of known faces, invariance, broken input.

mod tessellations;

use super::*;
use crate::geometry::primitive::{Kind, Primitive};
use crate::mesh::test_models::{cube, cubes_sharing_an_edge, moved, sphere, strip, together, triangles};
use crate::mesh::{CornerId, FaceId, Side};
use crate::sample;
use glam::{DQuat, DVec3};
use proptest::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

fn model(name: &str) -> SurfaceMesh {
    sample::make(name, None, &Context::new()).unwrap()
}

fn run(mesh: &SurfaceMesh, options: &SegmentOptions) -> Segmentation {
    let result = segment(mesh, options, &Context::new()).unwrap();
    check(mesh, &result);
    result
}

fn default(mesh: &SurfaceMesh) -> Segmentation {
    run(mesh, &SegmentOptions::default())
}

/// What holds for every result: labels, counts, areas, neighbours and boundaries agree; regions are connected.
fn check(mesh: &SurfaceMesh, result: &Segmentation) {
    let n = result.regions.len();
    assert_eq!(result.labels.len(), mesh.face_count());
    let mut count = vec![0; n];
    result.labels.iter().for_each(|&l| count[l as usize] += 1);
    assert!(result.regions.iter().zip(&count).all(|(r, &c)| r.triangles == c && c > 0));
    assert!(result.regions.windows(2).all(|w| w[0].area >= w[1].area * (1.0 - 1e-12)));

    // Connected across edges.
    let mut seen = vec![false; mesh.face_count()];
    let mut pieces = 0;
    for seed in 0..mesh.face_count() {
        if std::mem::replace(&mut seen[seed], true) {
            continue;
        }
        pieces += 1;
        let mut stack = vec![seed];
        while let Some(f) = stack.pop() {
            for o in mesh.corners(FaceId::new(f)).filter_map(|c| mesh.opposite(c)) {
                let g = mesh.face_of(o).index();
                if result.labels[g] == result.labels[f] && !std::mem::replace(&mut seen[g], true) {
                    stack.push(g);
                }
            }
        }
    }
    assert_eq!(pieces, n, "regions in pieces");

    // Every edge between two regions, and every border edge, on exactly one boundary.
    let mut wanted: BTreeMap<[u32; 2], (u32, Option<u32>)> = BTreeMap::new();
    let mut pairs = vec![BTreeSet::new(); n];
    for c in (0..mesh.corner_count()).map(CornerId::new) {
        let (a, b) = (mesh.vertex(c).0, mesh.vertex(mesh.next(c)).0);
        let own = result.labels[mesh.face_of(c).index()];
        match mesh.side(c) {
            Side::Inner(o) => {
                let other = result.labels[mesh.face_of(o).index()];
                if own != other {
                    wanted.insert([a.min(b), a.max(b)], (own.min(other), Some(own.max(other))));
                    pairs[own as usize].insert(other);
                }
            }
            Side::Border => {
                wanted.insert([a.min(b), a.max(b)], (own, None));
            }
            Side::Inconsistent | Side::NonManifold => return,
        }
    }
    for boundary in &result.boundaries {
        let v: Vec<u32> = boundary.vertices.iter().map(|v| v.0).collect();
        let closing = boundary.closed.then(|| [v[v.len() - 1], v[0]]);
        for [a, b] in v.windows(2).map(|w| [w[0], w[1]]).chain(closing) {
            assert_eq!(wanted.remove(&[a.min(b), a.max(b)]), Some(boundary.regions));
        }
    }
    assert!(wanted.is_empty(), "{} edges on no boundary", wanted.len());
    for (region, pairs) in result.regions.iter().zip(&pairs) {
        assert_eq!(region.neighbours, pairs.iter().copied().collect::<Vec<_>>());
    }

    // Every vertex of a region is as near to its surface as the region says.
    let rounding = 1e-12 * mesh.diagonal();
    for (f, &l) in result.labels.iter().enumerate() {
        if let Some(p) = result.regions[l as usize].primitive {
            let max = result.regions[l as usize].max * (1.0 + 1e-9);
            for &v in mesh.face(FaceId::new(f)) {
                assert!(p.distance(mesh.points()[v as usize]).abs() <= max + rounding);
            }
        }
    }
}

fn kinds(result: &Segmentation) -> BTreeMap<Option<Kind>, usize> {
    let mut count = BTreeMap::new();
    for region in &result.regions {
        *count.entry(region.primitive.map(|p| p.kind())).or_default() += 1;
    }
    count
}

/// The partition, whatever the numbers of the regions.
fn partition(labels: &[u32]) -> BTreeSet<Vec<usize>> {
    let mut parts: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    labels.iter().enumerate().for_each(|(t, &l)| parts.entry(l).or_default().push(t));
    parts.into_values().collect()
}

#[test]
fn parts_fall_into_their_faces() {
    let expected: [(&str, &[(Kind, usize)]); 6] = [
        ("wedge", &[(Kind::Plane, 5)]),
        ("bracket", &[(Kind::Plane, 8), (Kind::Cylinder, 5)]),
        ("rounded-box", &[(Kind::Plane, 6), (Kind::Cylinder, 12), (Kind::Sphere, 8)]),
        ("icosphere", &[(Kind::Sphere, 1)]),
        ("torus", &[(Kind::Torus, 1)]),
        ("cylinder", &[(Kind::Plane, 2), (Kind::Cylinder, 1)]),
    ];
    for (name, faces) in expected {
        let found = kinds(&default(&model(name)));
        let wanted: BTreeMap<Option<Kind>, usize> = faces.iter().map(|&(kind, n)| (Some(kind), n)).collect();
        assert_eq!(found, wanted, "{name}");
    }
}

#[test]
fn a_cube_has_six_faces_and_a_sphere_one() {
    let result = default(&cube(DVec3::ZERO, 2.0).triangulated().unwrap());
    assert_eq!(kinds(&result), BTreeMap::from([(Some(Kind::Plane), 6)]));
    assert_eq!(result.boundaries.len(), 12);
    let ball = default(&sphere(3));
    assert_eq!(ball.regions.len(), 1);
    assert!(ball.boundaries.is_empty());
    let Some(Primitive::Sphere { center, radius }) = ball.regions[0].primitive else { panic!("no sphere") };
    assert!(center.length() < 1e-9 && (radius - 1.0).abs() < 1e-9);
}

/// Every triangle in four, without moving anything.
fn subdivided(mesh: &SurfaceMesh) -> SurfaceMesh {
    let mut points = mesh.points().to_vec();
    let mut middles = std::collections::HashMap::new();
    let mut faces = Vec::new();
    for f in (0..mesh.face_count()).map(FaceId::new) {
        let [a, b, c]: [u32; 3] = mesh.face(f).try_into().unwrap();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                points.push((points[a as usize] + points[b as usize]) / 2.0);
                points.len() as u32 - 1
            })
        };
        let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
        faces.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }
    SurfaceMesh::from_triangles(points, &faces).unwrap()
}

#[test]
fn a_subdivided_wall_is_one_region_again() {
    let mesh = subdivided(&subdivided(&model("cylinder")));
    assert_eq!(default(&mesh).regions.len(), 3);
}

#[test]
fn two_planes_that_meet_at_a_flat_angle_are_no_cylinder() {
    // A roof with slopes of 10 degrees.
    let rise = 10f64.to_radians().tan();
    let outline = [[-1.0, 0.0], [-1.0, -1.0], [1.0, -1.0], [1.0, 0.0], [0.0, rise]];
    let ring = |y: f64| outline.map(|[x, z]| DVec3::new(x, y, z));
    let points: Vec<DVec3> = ring(0.0).into_iter().chain(ring(3.0)).collect();
    let mut faces: Vec<[u32; 3]> = (1..4).flat_map(|k| [[0, k, k + 1], [5, 5 + k + 1, 5 + k]]).collect();
    for k in 0..5 {
        let next = (k + 1) % 5;
        faces.extend([[k, next + 5, next], [k, k + 5, next + 5]]);
    }
    let mesh = SurfaceMesh::from_triangles(points, &faces).unwrap();
    let result = default(&mesh);
    assert_eq!(kinds(&result), BTreeMap::from([(Some(Kind::Plane), 7)]));
}

#[test]
fn the_bracket_keeps_its_faces_in_every_position_and_size() {
    let mesh = model("bracket");
    let faces = partition(&default(&mesh).labels);
    let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
    assert_eq!(partition(&default(&moved(&mesh, |p| turn * p + DVec3::new(3.0, -5.0, 2.0))).labels), faces);
    for power in [-40, -3, 3, 40] {
        assert_eq!(default(&moved(&mesh, |p| p * 2f64.powi(power))).labels, default(&mesh).labels);
    }
}

#[test]
fn renumbering_changes_nothing() {
    let scan = SegmentOptions { surfaces: false, ..SegmentOptions::default() };
    let cases =
        [("rounded-box", SegmentOptions::default()), ("cube-cylinders", SegmentOptions::paper()), ("tube-tree", scan)];
    for (name, options) in cases {
        let mesh = model(name);
        let (n, vertices) = (mesh.face_count(), mesh.vertex_count());
        // Permutations without pattern: multiplication by a number without a common divisor.
        let permutation = |n: usize| {
            let step = (1_000_003..).find(|k| gcd(*k, n) == 1).unwrap();
            (0..n).map(|k| k * step % n).collect::<Vec<usize>>()
        };
        let (source, place) = (permutation(n), permutation(vertices));
        let mut points = vec![DVec3::ZERO; vertices];
        mesh.points().iter().zip(&place).for_each(|(&p, &to)| points[to] = p);
        let corners = |&f: &usize| {
            let face: [u32; 3] = mesh.face(FaceId::new(f)).try_into().unwrap();
            let mut face = face.map(|v| place[v as usize] as u32);
            face.rotate_left(f % 3);
            face
        };
        let faces: Vec<[u32; 3]> = source.iter().map(corners).collect();
        let shuffled = SurfaceMesh::from_triangles(points, &faces).unwrap();
        let (before, after) = (run(&mesh, &options), run(&shuffled, &options));
        let expected: Vec<u32> = source.iter().map(|&f| before.labels[f]).collect();
        assert_eq!(after.labels, expected, "{name}");
        assert_eq!(after.regions, before.regions, "{name}");
        for (a, b) in after.boundaries.iter().zip(&before.boundaries) {
            assert!(a.vertices.iter().zip(&b.vertices).all(|(a, b)| a.index() == place[b.index()]), "{name}");
        }
    }
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// The mesh with normally distributed noise on its vertices, of a deviation in mean edges.
fn with_noise(mesh: &SurfaceMesh, share: f64) -> SurfaceMesh {
    let lengths = (0..mesh.corner_count()).map(CornerId::new).map(|c| {
        let ends = [c, mesh.next(c)].map(|c| mesh.point(mesh.vertex(c)));
        ends[0].distance(ends[1])
    });
    let sigma = share * lengths.sum::<f64>() / mesh.corner_count() as f64;
    // Sums of twelve uniform numbers from a linear congruential generator.
    let mut state = 7u64;
    let mut uniform = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut normal = || (0..12).map(|_| uniform()).sum::<f64>() - 6.0;
    let points: Vec<DVec3> =
        mesh.points().iter().map(|&p| p + sigma * DVec3::new(normal(), normal(), normal())).collect();
    let faces: Vec<[u32; 3]> = mesh.faces().iter().map(|f| [f[0], f[1], f[2]]).collect();
    triangles(&points, &faces)
}

/// Number of parts of `truth` that a part of `labels` covers with more than `share` of their union, by triangles.
fn covered(labels: &[u32], truth: &[u32], share: f64) -> usize {
    let parts = |labels: &[u32]| -> Vec<BTreeSet<usize>> {
        partition(labels).into_iter().map(|part| part.into_iter().collect()).collect()
    };
    let (found, wanted) = (parts(labels), parts(truth));
    let is_found = |face: &&BTreeSet<usize>| {
        found.iter().any(|part| {
            let both = part.intersection(face).count() as f64;
            both > share * (part.len() + face.len()) as f64 - share * both
        })
    };
    wanted.iter().filter(is_found).count()
}

#[test]
fn parts_with_noise_keep_their_faces() {
    for (name, share) in [("bracket", 0.01), ("bracket", 0.05), ("cube-cylinders", 0.02), ("wedge", 0.05)] {
        let mesh = model(name);
        let exact = default(&mesh);
        let noisy = default(&with_noise(&mesh, share));
        assert_eq!(noisy.chosen.basis, Basis::Surfaces, "{name} {share}");
        assert_eq!(kinds(&noisy), kinds(&exact), "{name} {share}");
        assert_eq!(covered(&noisy.labels, &exact.labels, 0.9), exact.regions.len(), "{name} {share}");
        // The noise along a normal is that along an axis.
        let edge = (mesh_area(&mesh) / mesh.face_count() as f64 * 4.0 / 3f64.sqrt()).sqrt();
        assert!((0.8..1.25).contains(&(noisy.chosen.noise / (share * edge))), "{name} {share}");
    }
}

/// Every vertex half the way to the mean of its neighbours.
fn smoothed(mesh: &SurfaceMesh) -> SurfaceMesh {
    let mut sum = vec![(DVec3::ZERO, 0.0); mesh.vertex_count()];
    for f in mesh.faces().iter() {
        for k in 0..3 {
            let (own, other) = (&mut sum[f[k] as usize], mesh.points()[f[(k + 1) % 3] as usize]);
            *own = (own.0 + other, own.1 + 1.0);
        }
    }
    let points: Vec<DVec3> =
        mesh.points().iter().zip(sum).map(|(&p, (sum, n))| if n > 0.0 { p.lerp(sum / n, 0.5) } else { p }).collect();
    let faces: Vec<[u32; 3]> = mesh.faces().iter().map(|f| [f[0], f[1], f[2]]).collect();
    triangles(&points, &faces)
}

#[test]
fn smoothed_parts_keep_their_faces() {
    let mesh = subdivided(&subdivided(&subdivided(&cube(DVec3::ZERO, 2.0).triangulated().unwrap())));
    let exact = default(&mesh);
    let found = default(&smoothed(&mesh));
    assert_eq!(kinds(&found), kinds(&exact));
    assert_eq!(covered(&found.labels, &exact.labels, 0.9), 6);
}

/// The mesh with smooth noise on its vertices, some 14 mean edges long, of a deviation in mean edges along every axis.
fn with_waves(mesh: &SurfaceMesh, share: f64) -> SurfaceMesh {
    with_long_waves(mesh, share, 14.0)
}

/// The same, of any length in mean edges.
fn with_long_waves(mesh: &SurfaceMesh, share: f64, length: f64) -> SurfaceMesh {
    const WAVES: u32 = 6;
    let edge = (mesh_area(mesh) / mesh.face_count() as f64 * 4.0 / 3f64.sqrt()).sqrt();
    // A sine has a root mean square of 1/√2, and each of the waves goes one way, so a third of it along every axis.
    let height = share * edge * (3.0 * 2.0 / f64::from(WAVES)).sqrt();
    moved(mesh, |p| {
        let wave = |j: u32| {
            let x = f64::from(j);
            let along = DVec3::new((1.0 + 3.7 * x).sin(), (2.0 + 2.3 * x).cos(), (5.0 * x + 0.5).sin()).normalize();
            let way = DVec3::new((1.3 * x).cos(), (2.9 * x + 1.0).sin(), (4.1 * x + 2.0).cos()).normalize();
            way * height * (std::f64::consts::TAU * p.dot(along) / (length * edge) + 1.7 * x).sin()
        };
        p + (0..WAVES).map(wave).sum::<DVec3>()
    })
}

#[test]
fn parts_with_waves_keep_their_faces() {
    let mesh = model("cube-cylinders");
    let exact = default(&mesh);
    for share in [0.05, 0.1] {
        let found = default(&with_waves(&mesh, share));
        assert_eq!(found.chosen.basis, Basis::Surfaces, "{share}");
        assert_eq!(found.regions.len(), exact.regions.len(), "{share}");
        assert_eq!(covered(&found.labels, &exact.labels, 0.9), exact.regions.len(), "{share}");
        // A higher wave bends a face of a few of its lengths as a cylinder does.
        if share <= 0.05 {
            assert_eq!(kinds(&found), kinds(&exact), "{share}");
        }
    }
}

#[test]
fn waves_that_are_flat_or_round_in_places_are_no_exact_surfaces() {
    let mesh = model("wedge");
    let exact = default(&mesh);
    for length in [20.0, 28.0] {
        let found = default(&with_long_waves(&mesh, 0.05, length));
        assert_eq!(kinds(&found), kinds(&exact), "{length}");
        assert_eq!(covered(&found.labels, &exact.labels, 0.9), exact.regions.len(), "{length}");
    }
}

#[test]
fn parts_that_are_nearly_exact_keep_their_faces() {
    // Vertices some 1e-5 of the size off: just more than careless kernels are.
    for name in ["wedge", "bracket"] {
        let mesh = model(name);
        let exact = default(&mesh);
        let found = default(&with_noise(&mesh, 5e-4));
        assert_eq!(kinds(&found), kinds(&exact), "{name}");
        assert_eq!(covered(&found.labels, &exact.labels, 0.9), exact.regions.len(), "{name}");
    }
}

#[test]
fn a_freeform_face_beside_exact_ones_stays_whole() {
    let cube = (0..5).fold(cube(DVec3::ZERO, 2.0).triangulated().unwrap(), |mesh, _| subdivided(&mesh));
    // The top swells; its rim stays.
    let top = cube.points().iter().map(|p| p.z).fold(f64::NEG_INFINITY, f64::max);
    let (low, high) = cube.bounds();
    let swollen = moved(&cube, |p| {
        let q = (p - low) / (high - low);
        let bump =
            (std::f64::consts::PI * q.x).sin() * (std::f64::consts::PI * q.y).sin() * (1.0 + 0.4 * (5.0 * q.x).sin());
        if p.z == top { p + DVec3::Z * 0.1 * bump } else { p }
    });
    let found = default(&swollen);
    assert_eq!(kinds(&found), BTreeMap::from([(Some(Kind::Plane), 5), (None, 1)]));
}

#[test]
fn a_scanned_part_keeps_its_faces() {
    // Waves and white noise all over, rounded edges.
    let cube = (0..4).fold(cube(DVec3::ZERO, 2.0).triangulated().unwrap(), |mesh, _| subdivided(&mesh));
    let exact = default(&cube);
    let found = default(&with_noise(&with_waves(&smoothed(&cube), 0.05), 0.03));
    assert_eq!(kinds(&found), kinds(&exact));
    assert_eq!(covered(&found.labels, &exact.labels, 0.9), 6);
}

fn mesh_area(mesh: &SurfaceMesh) -> f64 {
    let p = |v: u32| mesh.points()[v as usize];
    mesh.faces().iter().map(|f| 0.5 * (p(f[1]) - p(f[0])).cross(p(f[2]) - p(f[0])).length()).sum()
}

/// An egg with bumps: smooth, on no surface.
fn egg() -> SurfaceMesh {
    moved(&sphere(4), |p| {
        let bumps = 1.0 + 0.1 * (3.0 * p.x).sin() * (2.0 * p.y + 1.0).cos() + 0.05 * (5.0 * p.z).sin();
        DVec3::new(p.x, 1.2 * p.y, 1.5 * p.z) * bumps
    })
}

#[test]
fn slivers_do_not_change_the_faces_of_a_part() {
    for name in ["bracket", "cube-cylinders", "torus"] {
        let mesh = model(name);
        let clean = default(&mesh);
        let spoiled = heal::tests::with_slivers(&mesh, 11);
        let result = default(&spoiled);
        assert_eq!(kinds(&result), kinds(&clean), "{name}");
        // Every triangle that is left, the two parts of those that were divided, and no cap of the wrong side.
        let own = |regions: &[Region]| regions.iter().map(|r| r.area).collect::<Vec<f64>>();
        for (a, b) in own(&result.regions).into_iter().zip(own(&clean.regions)) {
            assert!((a - b).abs() <= 1e-4 * b, "{name}: {a} for {b}");
        }
        // Needles may have gone to either side.
        let corners = |f: usize| [0, 1, 2].map(|k| spoiled.points()[spoiled.face(FaceId::new(f))[k] as usize]);
        let wide = |&f: &usize| {
            let [a, b, c] = corners(f);
            (b - a).cross(c - a).length() > 1e-3 * (b - a).length_squared().max((c - b).length_squared())
        };
        let kept: Vec<usize> = (0..mesh.face_count()).filter(wide).collect();
        assert!(kept.len() > mesh.face_count() * 9 / 10);
        let of = |labels: &[u32]| partition(&kept.iter().map(|&f| labels[f]).collect::<Vec<u32>>());
        assert!(of(&result.labels) == of(&clean.labels), "{name}");
    }
}

#[test]
fn coordinates_of_a_few_digits_do_not_change_the_faces_of_a_part() {
    let round = |x: f64| format!("{x:.4e}").parse::<f64>().unwrap();
    for (name, scale) in [("wedge", 1.0), ("cube-cylinders", 7.3), ("torus", 0.02)] {
        // Turned, so that hardly any coordinate is a round number.
        let turn = DQuat::from_axis_angle(DVec3::new(3.0, -1.0, 2.0).normalize(), 0.7);
        let mesh = moved(&model(name), |p| turn * p * scale + DVec3::new(0.31, 0.0, -0.17));
        let rounded = moved(&mesh, |p| DVec3::from_array(p.to_array().map(round)));
        assert_ne!(rounded.points(), mesh.points());
        let (clean, result) = (default(&mesh), default(&rounded));
        assert_eq!(kinds(&result), kinds(&clean), "{name}");
        assert_eq!(partition(&result.labels), partition(&clean.labels), "{name}");
    }
}

#[test]
fn exact_and_organic_surfaces_have_no_noise() {
    for mesh in [model("bracket"), egg()] {
        assert_eq!(default(&mesh).chosen.noise, 0.0);
    }
}

#[test]
fn an_organic_shape_keeps_its_regions_in_every_position() {
    let options = SegmentOptions { regions: Some(10), ..SegmentOptions::default() };
    let result = run(&egg(), &options);
    assert_eq!(result.chosen.basis, Basis::Curvature);
    for turn in [0.4, 1.3, 2.9] {
        let turn = DQuat::from_axis_angle(DVec3::new(-2.0, 1.0, 3.0).normalize(), turn);
        let turned = run(&moved(&egg(), |p| turn * p + DVec3::new(1.0, 7.0, -2.0)), &options);
        assert_eq!(covered(&turned.labels, &result.labels, 0.98), result.regions.len());
    }
}

#[test]
fn noisy_parts_have_the_same_faces_in_every_size_and_numbering() {
    let mesh = with_noise(&model("cube-cylinders"), 0.01);
    let labels = default(&mesh).labels;
    for power in [-40, 40] {
        assert_eq!(default(&moved(&mesh, |p| p * 2f64.powi(power))).labels, labels);
    }
    let n = mesh.face_count();
    let faces: Vec<[u32; 3]> = (0..n).map(|k| mesh.face(FaceId::new(n - 1 - k)).try_into().unwrap()).collect();
    let reversed = default(&triangles(mesh.points(), &faces)).labels;
    let back: Vec<u32> = reversed.into_iter().rev().collect();
    assert_eq!(back, labels);
}

#[test]
fn threads_do_not_change_the_regions() {
    for (name, options) in [("tube-tree", SegmentOptions::default()), ("bracket", SegmentOptions::paper())] {
        let mesh = model(name);
        let with = |threads: usize| {
            let context = Context::new().with_threads(threads).unwrap();
            context.install(|| segment(&mesh, &options, &context)).unwrap().labels
        };
        assert_eq!(with(1), with(3));
    }
}

#[test]
fn the_paper_s_pipeline_finds_walls_and_caps() {
    // Two cylinders on a cube: six sides of the cube, two walls, two caps.
    let result = run(&model("cube-cylinders"), &SegmentOptions::paper());
    assert_eq!(result.chosen.basis, Basis::Curvature);
    assert_eq!(kinds(&result).get(&Some(Kind::Cylinder)), Some(&2));
    assert!((10..=12).contains(&result.regions.len()), "{}", result.regions.len());
}

#[test]
fn the_dendrogram_gives_every_threshold_without_another_run() {
    let mesh = model("tube-tree");
    let with = |threshold: f64| SegmentOptions {
        surfaces: false,
        clusters: Some(6),
        merge_threshold: Some(threshold),
        rectify: Rectify::None,
        ..SegmentOptions::default()
    };
    let all = run(&mesh, &with(1.0)).dendrogram;
    for threshold in [0.0, 0.5, 2.0, 10.0] {
        let result = run(&mesh, &with(threshold));
        assert_eq!(result.dendrogram, all);
        let left = all.regions as usize - all.until_threshold(threshold);
        assert_eq!(result.regions.len(), left);
        assert_eq!(all.cut(all.until_threshold(threshold)).iter().max().map(|&m| m as usize + 1), Some(left));
    }
    let result = run(&mesh, &SegmentOptions { regions: Some(4), ..with(1.0) });
    assert_eq!(result.regions.len(), 4);
}

#[test]
fn spoiled_labels_are_put_right() {
    let mesh = model("bracket");
    let truth = default(&mesh).labels;
    // Triangles at borders go over to a neighbour, in a pattern without order.
    let mut spoiled = truth.clone();
    for f in 0..mesh.face_count() {
        let beyond =
            mesh.corners(FaceId::new(f)).filter_map(|c| mesh.opposite(c)).map(|o| truth[mesh.face_of(o).index()]);
        if let Some(other) = beyond.filter(|&l| l != truth[f]).last()
            && f * 7919 % 100 < 35
        {
            spoiled[f] = other;
        }
    }
    let wrong = |labels: &[u32]| labels.iter().zip(&truth).filter(|(a, b)| a != b).count();
    assert!(wrong(&spoiled) > 20);
    let options = SegmentOptions { labels: Some(spoiled.clone()), ..SegmentOptions::default() };
    let mended = run(&mesh, &options);
    assert!(partition(&mended.labels).intersection(&partition(&truth)).count() * 10 >= partition(&truth).len() * 9);
    // Untouched where nothing is to be corrected.
    let kept = run(&mesh, &SegmentOptions { rectify: Rectify::None, labels: Some(truth.clone()), ..options.clone() });
    assert_eq!(partition(&kept.labels), partition(&truth));
}

#[test]
fn open_irregular_and_separate_surfaces_are_segmented() {
    let cubes = cubes_sharing_an_edge().triangulated().unwrap();
    assert_eq!(default(&cubes).regions.len(), 12);
    default(&strip(9, 1).triangulated().unwrap());
    let two = together(&[sphere(2), moved(&sphere(2), |p| p + DVec3::X * 5.0)]);
    assert_eq!(default(&two).regions.len(), 2);
    // A vertex without faces, a triangle without area.
    let mut points = sphere(2).points().to_vec();
    points.push(DVec3::splat(9.0));
    let faces: Vec<[u32; 3]> = sphere(2).faces().iter().map(|f| [f[0], f[1], f[2]]).collect();
    assert_eq!(default(&triangles(&points, &faces)).regions.len(), 1);
    let flat = [DVec3::ZERO, DVec3::X, DVec3::X * 2.0, DVec3::Y];
    default(&triangles(&flat, &[[0, 1, 2], [0, 1, 3]]));
    default(&triangles(&flat, &[[0, 1, 2]]));
}

#[test]
fn bad_options_and_inputs_are_refused() {
    let mesh = sphere(1);
    let refused = |options: SegmentOptions| matches!(segment(&mesh, &options, &Context::new()), Err(Error::Options(_)));
    let default = SegmentOptions::default;
    assert!(refused(SegmentOptions { clusters: Some(0), ..default() }));
    assert!(refused(SegmentOptions { regions: Some(0), ..default() }));
    assert!(refused(SegmentOptions { merge_threshold: Some(f64::NAN), ..default() }));
    assert!(refused(SegmentOptions { sharp_angle: Some(200.0), ..default() }));
    assert!(refused(SegmentOptions { tolerance: Some(0.0), ..default() }));
    assert!(refused(SegmentOptions { labels: Some(vec![0; 3]), ..default() }));
    let empty = SurfaceMesh::from_triangles(Vec::new(), &[]).unwrap();
    assert!(matches!(segment(&empty, &default(), &Context::new()), Err(Error::Input { .. })));
    assert!(matches!(segment(&cube(DVec3::ZERO, 1.0), &default(), &Context::new()), Err(Error::Input { .. })));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// Any triangles at all: non-manifold, degenerate, one-sided, of any size.
    #[test]
    fn soups_give_valid_results(
        points in prop::collection::vec(prop::array::uniform3(-1.0f64..1.0), 4..12),
        faces in prop::collection::vec(prop::array::uniform3(0u32..4), 1..24),
        exponent in -150i32..150,
        paper in any::<bool>(),
    ) {
        let scale = 10f64.powi(exponent);
        let points: Vec<DVec3> = points.into_iter().map(|p| DVec3::from_array(p) * scale).collect();
        let mesh = triangles(&points, &faces);
        let options = if paper { SegmentOptions::paper() } else { SegmentOptions::default() };
        let result = segment(&mesh, &options, &Context::new()).unwrap();
        prop_assert_eq!(result.labels.len(), faces.len());
        for r in &result.regions {
            prop_assert!([r.area, r.kmin, r.kmax, r.rms, r.max].iter().all(|x| x.is_finite()), "{:?}", r);
        }
    }
}
