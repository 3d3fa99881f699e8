//! What every sample promises, checked on all of them; what single models promise besides.

use super::builder::TRUTH;
use super::*;
use crate::mesh::{Column, CornerId, FaceId, Side, VertexId};
use glam::DVec3;
use proptest::prelude::*;

/// Euler number of every sample.
const EULER: &[(&str, i64)] = &[
    ("bracket", 2 - 2 * 3),
    ("cube-cylinders", 2),
    ("cylinder", 2),
    ("icosphere", 2),
    ("noisy-torus", 0),
    ("open-cylinder", 0),
    ("open-torus", 0),
    ("rounded-box", 2),
    ("saddle", 1),
    ("torus", 0),
    ("tube-tree", 2),
    ("uv-sphere", 2),
    ("wedge", 2),
];

fn default(name: &str) -> Model {
    find(name).unwrap().make(None, &Context::new()).unwrap()
}

fn labels(mesh: &SurfaceMesh) -> &[i32] {
    match &mesh.attributes.face[TRUTH] {
        Column::Label(labels) => labels,
        other => panic!("{other:?}"),
    }
}

fn corners(mesh: &SurfaceMesh) -> impl Iterator<Item = CornerId> {
    (0..mesh.corner_count()).map(CornerId::new)
}

fn triangles(mesh: &SurfaceMesh) -> impl Iterator<Item = [DVec3; 3]> {
    mesh.faces().iter().map(|f| [0, 1, 2].map(|k| mesh.points()[f[k] as usize]))
}

fn area(mesh: &SurfaceMesh) -> f64 {
    triangles(mesh).map(|[a, b, c]| (b - a).cross(c - a).length() / 2.0).sum()
}

fn volume(mesh: &SurfaceMesh) -> f64 {
    triangles(mesh).map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
}

/// Smallest angle of all triangles in degrees.
fn least_angle(mesh: &SurfaceMesh) -> f64 {
    let angle = |[a, b, c]: [DVec3; 3]| (b - a).angle_between(c - a).to_degrees();
    triangles(mesh).flat_map(|[a, b, c]| [[a, b, c], [b, c, a], [c, a, b]]).map(angle).fold(180.0, f64::min)
}

/// Vertices − edges + faces; every edge has two half-edges unless it is a border.
fn euler(mesh: &SurfaceMesh) -> i64 {
    let borders = corners(mesh).filter(|&c| mesh.side(c) == Side::Border).count();
    let edges = (mesh.corner_count() + borders) / 2;
    mesh.vertex_count() as i64 - edges as i64 + mesh.face_count() as i64
}

/// Panics unless the mesh is a manifold, watertight if `closed`, without stray, double or pinched vertices.
fn assert_sound(mesh: &SurfaceMesh, closed: bool, what: &str) {
    assert!(mesh.is_triangular());
    for c in corners(mesh) {
        let fine = matches!(mesh.side(c), Side::Inner(_)) || (!closed && mesh.side(c) == Side::Border);
        assert!(fine, "{what}: {:?} at corner {c}", mesh.side(c));
    }
    assert_eq!(closed, corners(mesh).all(|c| mesh.side(c) != Side::Border), "{what}");
    assert_one_fan_per_vertex(mesh, what);
    let mut places: Vec<[u64; 3]> = mesh.points().iter().map(|p| p.to_array().map(|x| (x + 0.0).to_bits())).collect();
    places.sort_unstable();
    places.dedup();
    assert_eq!(places.len(), mesh.vertex_count(), "{what}: two vertices at one position");
    let scale = mesh.diagonal();
    for (f, [a, b, c]) in triangles(mesh).enumerate() {
        let height = (b - a).cross(c - a).length() / (b - a).length().max((c - b).length()).max((a - c).length());
        assert!(height > 1e-6 * scale, "{what}: triangle {f} is degenerate");
    }
}

/// Turning around a vertex from any of its corners meets all of its corners.
fn assert_one_fan_per_vertex(mesh: &SurfaceMesh, what: &str) {
    let mut valence = vec![0; mesh.vertex_count()];
    let mut first = vec![None; mesh.vertex_count()];
    for c in corners(mesh) {
        let v = mesh.vertex(c).index();
        valence[v] += 1;
        // On a border, the fan begins at the corner with nothing before it.
        if first[v].is_none() || mesh.side(c) == Side::Border {
            first[v] = Some(c);
        }
    }
    for (v, &start) in first.iter().enumerate() {
        let start = start.unwrap_or_else(|| panic!("{what}: vertex {v} is unused"));
        let mut met = 1;
        let mut c = start;
        while let Some(o) = mesh.opposite(mesh.previous(c)).filter(|&o| o != start) {
            met += 1;
            c = o;
        }
        assert_eq!(met, valence[v], "{what}: vertex {v} is pinched");
    }
}

#[test]
fn the_table_is_in_order_and_complete() {
    assert!(SAMPLES.is_sorted_by_key(|s| s.name));
    assert!(SAMPLES.iter().map(|s| s.name).eq(EULER.iter().map(|e| e.0)));
    for s in SAMPLES {
        assert!(find(s.name).is_ok() && !s.summary.is_empty());
    }
    let unknown = make("cubes", None, &Context::new()).unwrap_err();
    assert_eq!(unknown.exit_code(), 2);
    assert!(SAMPLES.iter().all(|s| unknown.to_string().contains(s.name)), "{unknown}");
}

#[test]
fn every_sample_is_sound_and_has_its_topology() {
    for (sample, &(name, expected)) in SAMPLES.iter().zip(EULER) {
        let model = default(name);
        assert_sound(&model.mesh, sample.closed, name);
        assert_eq!(euler(&model.mesh), expected, "{name}");
        assert!((model.mesh.diagonal() / sample.diagonal - 1.0).abs() < 0.02, "{name}: {}", model.mesh.diagonal());
        if sample.closed {
            assert!(volume(&model.mesh) > 0.0, "{name} is inside out");
        }
    }
}

#[test]
fn low_resolutions_are_sound_or_refused() {
    for sample in SAMPLES {
        let mut made = 0;
        for resolution in [4, 5, 6, 7, 9, 11, 14, 18, 25, 45, 51] {
            let what = format!("{} at {resolution}", sample.name);
            match sample.make(Some(resolution), &Context::new()) {
                Ok(model) => {
                    made += 1;
                    assert_sound(&model.mesh, sample.closed, &what);
                }
                Err(Error::Options(message)) => assert!(message.contains("edge length"), "{what}: {message}"),
                Err(other) => panic!("{what}: {other}"),
            }
        }
        assert!(made >= 2, "{}", sample.name);
        for resolution in [0, 3, RESOLUTIONS.end() + 1, u32::MAX] {
            assert!(matches!(sample.make(Some(resolution), &Context::new()), Err(Error::Options(_))));
        }
    }
}

#[test]
fn vertices_lie_on_the_surfaces_of_their_labels() {
    for sample in SAMPLES {
        let Model { mesh, shapes, noise, .. } = default(sample.name);
        let tolerance = 1e-13 * sample.diagonal + noise;
        let mut used = vec![false; shapes.len()];
        for (f, &label) in labels(&mesh).iter().enumerate() {
            used[label as usize] = true;
            for &v in mesh.face(FaceId::new(f)) {
                let distance = shapes[label as usize].distance(mesh.point(VertexId(v)));
                assert!(distance <= tolerance, "{}: vertex {v} is {distance:e} off face {label}", sample.name);
            }
        }
        assert!(used.iter().all(|&u| u), "{}: a label without a triangle", sample.name);
        let named = (0..shapes.len() as i32).all(|l| mesh.attributes.names.contains_key(&(TRUTH.into(), l)));
        assert!(named, "{}", sample.name);
    }
}

#[test]
fn triangles_face_as_their_surfaces_do() {
    for sample in SAMPLES {
        let Model { mesh, shapes, .. } = default(sample.name);
        for ([a, b, c], &label) in triangles(&mesh).zip(labels(&mesh)) {
            let normal = (b - a).cross(c - a).normalize();
            let centre = (a + b + c) / 3.0;
            let agreement = match shapes[label as usize] {
                Shape::Plane { normal: outward, .. } => normal.dot(outward) - (1.0 - 1e-12),
                // On which side the material lies is not part of the shape, that it is a side is.
                Shape::Cylinder { origin, axis, .. } => {
                    let d = centre - origin;
                    normal.dot((d - axis * d.dot(axis)).normalize()).abs() - 0.9
                }
                Shape::Sphere { center, .. } => normal.dot((centre - center).normalize()) - 0.9,
                _ => 1.0,
            };
            assert!(agreement > 0.0, "{}: face {label} at {centre}", sample.name);
        }
    }
}

#[test]
fn measures_converge_to_those_of_the_smooth_model() {
    for sample in SAMPLES.iter().filter(|s| s.name != "tube-tree") {
        let errors = |resolution: u32| {
            let model = sample.make(Some(resolution), &Context::new()).unwrap();
            let exact = model.exact.unwrap();
            assert_eq!(exact.volume.is_some(), sample.closed);
            let off = |value: f64, truth: f64| (value / truth - 1.0).abs();
            [off(area(&model.mesh), exact.area), exact.volume.map_or(0.0, |v| off(volume(&model.mesh), v))]
        };
        let (coarse, fine) = (errors(25), errors(100));
        for (k, what) in ["area", "volume"].into_iter().enumerate() {
            // Second order: four times finer is sixteen times closer, less where counts are rounded; first order would
            // be four times. Noise adds area at every resolution.
            if (sample.name, what) != ("noisy-torus", "area") {
                assert!(fine[k] < coarse[k] / 6.0 + 1e-12, "{} {what}: {coarse:?} {fine:?}", sample.name);
            }
            assert!(coarse[k] < 0.1, "{} {what}: {coarse:?}", sample.name);
        }
    }
}

#[test]
fn edges_are_as_long_as_the_resolution_says() {
    for sample in SAMPLES {
        let mesh = default(sample.name).mesh;
        let lengths = triangles(&mesh).flat_map(|[a, b, c]| [a.distance(b), b.distance(c), c.distance(a)]);
        let mean = lengths.sum::<f64>() / mesh.corner_count() as f64;
        let promised = sample.diagonal / f64::from(sample.resolution);
        assert!((0.75..1.35).contains(&(mean / promised)), "{}: {}", sample.name, mean / promised);
    }
}

#[test]
fn triangles_are_well_shaped() {
    for sample in SAMPLES {
        let least = match sample.name {
            // The paper's model bridges without inner points; poles and noise make thin triangles.
            "cube-cylinders" | "uv-sphere" => 0.5,
            "wedge" => 15.0,
            _ => 24.0,
        };
        let angle = least_angle(&default(sample.name).mesh);
        assert!(angle > least, "{}: {angle}", sample.name);
    }
}

#[test]
fn models_do_not_depend_on_the_number_of_threads() {
    let one = Context::new().with_threads(1).unwrap();
    let three = Context::new().with_threads(3).unwrap();
    for sample in SAMPLES {
        let [a, b] = [&one, &three].map(|c| c.install(|| make(sample.name, Some(50), c)).unwrap());
        assert_eq!(a.points(), b.points(), "{}", sample.name);
        assert_eq!(a.faces(), b.faces(), "{}", sample.name);
        assert_eq!(a.attributes, b.attributes, "{}", sample.name);
    }
}

#[test]
fn noise_depends_on_the_seed_only_and_stays_within_its_amplitude() {
    let seeded = |seed| noisy_torus(2.0, 0.5, 40, 16, 0.01, seed).unwrap().mesh;
    assert_eq!(seeded(1).points(), seeded(1).points());
    assert_ne!(seeded(1).points(), seeded(2).points());
    let smooth = torus(2.0, 0.5, 40, 16).unwrap().mesh;
    let moves: Vec<f64> = smooth.points().iter().zip(seeded(1).points()).map(|(p, q)| p.distance(*q)).collect();
    let largest = moves.iter().copied().fold(0.0, f64::max);
    assert!(largest <= 0.01 + 1e-15 && largest > 0.009, "{largest}");
    let mut context = Context::new();
    context.seed = 5;
    let [a, b] = [make("noisy-torus", None, &context), make("noisy-torus", None, &Context::new())].map(Result::unwrap);
    assert_ne!(a.points(), b.points());
}

#[test]
fn cube_cylinders_has_the_counts_of_the_paper() {
    let model = default("cube-cylinders");
    assert_eq!((model.mesh.vertex_count(), model.mesh.face_count()), (1306, 2608));
    let direct = cube_cylinders(&CubeCylinders::default()).unwrap();
    assert_eq!(direct.mesh.faces(), model.mesh.faces());
    let mut count = vec![0; model.shapes.len()];
    labels(&model.mesh).iter().for_each(|&l| count[l as usize] += 1);
    let side = 2 * 13 * 13;
    assert_eq!(count, [side, side, side, side, 52 + 34, 34 * 8 * 2, 32, 52 + 34, 34 * 7 * 2, 32]);
}

#[test]
fn icosphere_has_the_classic_counts() {
    for n in [1, 2, 5, 16] {
        let mesh = icosphere(3.0, n).unwrap().mesh;
        assert_eq!(mesh.face_count() as u32, 20 * n * n);
        assert_eq!(mesh.vertex_count() as u32, 10 * n * n + 2);
    }
}

#[test]
fn saddle_area_agrees_with_quadrature() {
    for (side, k) in [(2.0, 1.2), (1.0, 1e-3), (3.0, 8.0)] {
        let n = 400;
        let at = |i: usize| side * ((i as f64 + 0.5) / n as f64 - 0.5);
        let root = |x: f64, y: f64| (1.0 + k * k * (x * x + y * y)).sqrt();
        let sum: f64 = (0..n).flat_map(|i| (0..n).map(move |j| (i, j))).map(|(i, j)| root(at(i), at(j))).sum();
        let midpoint = sum * (side / n as f64).powi(2);
        let exact = saddle(side, k, 2).unwrap().exact.unwrap().area;
        assert!((exact / midpoint - 1.0).abs() < 1e-4, "{side} {k}: {exact} {midpoint}");
    }
}

#[test]
fn senseless_parameters_are_refused() {
    let context = Context::new();
    let short = Tube { ends: [DVec3::ZERO, DVec3::Z * 0.1], radii: [1.0, 0.5] };
    let wide = CubeCylinders { radius: 1.0, ..CubeCylinders::default() };
    let tight = Bracket { bore: 25.0, ..Bracket::default() };
    let refused = [
        icosphere(0.0, 3),
        icosphere(f64::NAN, 3),
        icosphere(1.0, 0),
        icosphere(1.0, u32::MAX),
        uv_sphere(1.0, 2, 8),
        uv_sphere(1.0, 8, 1),
        torus(1.0, 1.0, 8, 8),
        torus(1.0, -0.1, 8, 8),
        torus(1.0, 0.5, u32::MAX, u32::MAX),
        open_torus(1.0, 0.5, 360.0, 8, 8),
        open_torus(1.0, 0.5, 0.0, 8, 8),
        noisy_torus(1.0, 0.5, 8, 8, f64::INFINITY, 0),
        cylinder(1.0, 1.0, 1e-9),
        cylinder(1.0, f64::INFINITY, 0.1),
        open_cylinder(1.0, 1.0, 2, 1),
        rounded_box([1.0, 1.0, 0.4], 0.2, 0.1),
        rounded_box([1.0, 1.0, f64::NAN], 0.2, 0.1),
        cube_cylinders(&wide),
        bracket(&tight, 2.0, &context),
        bracket(&Bracket::default(), 0.0, &context),
        wedge(0.5, 1.0, 1.0, 0.1, &context),
        wedge(20.0, 1.0, 0.0, 0.1, &context),
        saddle(1.0, 0.0, 4),
        tubes(&[short], 0.1, 0.1, &context),
        tubes(&tree(), 0.1, 0.2, &context),
        tubes(&tree(), f64::NAN, 0.1, &context),
        tubes(&tree(), 0.1, 1e-6, &context),
    ];
    for (k, result) in refused.into_iter().enumerate() {
        assert!(matches!(result, Err(Error::Options(_))), "case {k}: {:?}", result.err());
    }
}

#[test]
fn a_cancelled_run_stops() {
    let cancelled = Context::new().with_cancel(std::sync::Arc::new(true.into()));
    for name in ["tube-tree", "bracket"] {
        assert!(matches!(make(name, None, &cancelled), Err(Error::Cancelled)), "{name}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn wedges_of_any_angle_are_sound(angle in 3.0..170.0f64, length in 0.5..3.0f64, width in 0.2..2.0f64) {
        let model = wedge(angle, length, width, 0.15, &Context::new()).unwrap();
        assert_sound(&model.mesh, true, "wedge");
        let exact = model.exact.unwrap();
        prop_assert!((area(&model.mesh) / exact.area - 1.0).abs() < 1e-12);
        prop_assert!((volume(&model.mesh) / exact.volume.unwrap() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn brackets_of_any_size_are_sound(
        legs in (40.0..90.0f64, 40.0..90.0f64), width in 24.0..60.0f64, plate in (1.0..9.0f64, 1.0..9.0f64),
        holes in (0.5..4.0f64, 0.5..9.0f64), edge in 1.5..8.0f64,
    ) {
        let size = Bracket {
            length: legs.0, height: legs.1, width, thickness: plate.0, fillet: plate.1, screw: holes.0, bore: holes.1,
        };
        let model = bracket(&size, edge, &Context::new()).unwrap();
        assert_sound(&model.mesh, true, "bracket");
        prop_assert_eq!(euler(&model.mesh), -4);
    }

    #[test]
    fn rounded_boxes_of_any_size_are_sound(size in [0.5..3.0f64, 0.5..3.0f64, 0.5..3.0f64], share in 0.02..0.49f64) {
        let radius = share * size.into_iter().fold(f64::INFINITY, f64::min);
        let model = rounded_box(size, radius, 0.1).unwrap();
        assert_sound(&model.mesh, true, "rounded box");
    }

    /// The tube is the union of all the spheres in between: its distance is the least of theirs.
    #[test]
    fn tube_distance_is_that_of_the_nearest_sphere(
        b in [-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64], radii in [0.1..0.5f64, 0.1..0.5f64],
        p in [-2.0..2.0f64, -2.0..2.0f64, -2.0..2.0f64],
    ) {
        let (b, p) = (DVec3::from(b), DVec3::from(p));
        prop_assume!(b.length() > (radii[0] - radii[1]).abs() + 1e-3);
        let tube = Tube { ends: [DVec3::ZERO, b], radii };
        let sphere = |t: f64| p.distance(b * t) - (radii[0] + (radii[1] - radii[0]) * t);
        let least = (0..=2000).map(|k| sphere(f64::from(k) / 2000.0)).fold(f64::INFINITY, f64::min);
        prop_assert!(tube.distance(p) <= least + 1e-12 && tube.distance(p) > least - 1e-3);
    }
}
