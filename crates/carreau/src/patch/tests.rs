//! The room as a whole: every strategy on meshes of every kind.

use super::grid::Grid;
use super::*;
use crate::context::Context;
use crate::mesh::{FaceId, Polygons, SurfaceMesh, VertexId};
use glam::{DMat3, DVec3};
use proptest::prelude::{ProptestConfig, prop, prop_assert, proptest};

/// A height field of `rows × cols` quads, each cut along one of its diagonals.
fn field(rows: u32, cols: u32, height: impl Fn(f64, f64) -> f64, up: impl Fn(u32, u32) -> bool) -> SurfaceMesh {
    let point = |r: u32, c: u32| DVec3::new(f64::from(c), f64::from(r), height(f64::from(c), f64::from(r)));
    let points = (0..=rows).flat_map(|r| (0..=cols).map(move |c| (r, c))).map(|(r, c)| point(r, c)).collect();
    let id = |r, c| r * (cols + 1) + c;
    let mut triangles = Vec::new();
    for (r, c) in (0..rows).flat_map(|r| (0..cols).map(move |c| (r, c))) {
        let [a, b, d, e] = [id(r, c), id(r, c + 1), id(r + 1, c + 1), id(r + 1, c)];
        triangles.extend(if up(r, c) { [[a, b, d], [a, d, e]] } else { [[a, b, e], [b, d, e]] });
    }
    SurfaceMesh::from_triangles(points, &triangles).unwrap()
}

/// A torus of `rings × sides` quads.
fn torus(rings: u32, sides: u32) -> SurfaceMesh {
    let angle = |k: u32, n: u32| std::f64::consts::TAU * f64::from(k) / f64::from(n);
    let point = |i: u32, j: u32| {
        let (u, v) = (angle(i, rings), angle(j, sides));
        DVec3::new((2.0 + 0.5 * v.cos()) * u.cos(), (2.0 + 0.5 * v.cos()) * u.sin(), 0.5 * v.sin())
    };
    let points = (0..rings).flat_map(|i| (0..sides).map(move |j| (i, j))).map(|(i, j)| point(i, j)).collect();
    let id = |i: u32, j: u32| (i % rings) * sides + j % sides;
    let quads = (0..rings).flat_map(|i| (0..sides).map(move |j| (i, j)));
    let cut = |(i, j)| {
        let [a, b, c, d] = [id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)];
        [[a, b, c], [a, c, d]]
    };
    SurfaceMesh::from_triangles(points, &quads.flat_map(cut).collect::<Vec<_>>()).unwrap()
}

/// A bumpy sheet without symmetry: irregular enough that all stages have something to do.
fn bumpy(rows: u32, cols: u32, seed: u32) -> SurfaceMesh {
    let noise = move |x: f64, y: f64| {
        let s = (12.9898 * x + 78.233 * y + f64::from(seed)).sin() * 43758.5453;
        s - s.floor() - 0.5
    };
    let mesh = field(
        rows,
        cols,
        |x, y| 0.4 * (0.7 * x).sin() * (0.5 * y).cos(),
        |r, c| noise(f64::from(r), f64::from(c)) > -0.2,
    );
    let (points, faces, ..) = mesh.into_parts();
    let shake = |p: DVec3| p + 0.25 * DVec3::new(noise(p.x, p.y), noise(p.y, p.x + 7.0), 0.3 * noise(p.x + 3.0, p.y));
    SurfaceMesh::new(points.into_iter().map(shake).collect(), faces).unwrap()
}

/// Every combination of strategy, policy, dissection and ranking, with small and large patches.
fn all_options() -> Vec<PatchOptions> {
    let mut all = Vec::new();
    for strategy in [Strategy::Grow, Strategy::Zones, Strategy::Matching, Strategy::MatchingCardinality] {
        for policy in [Policy::KeepFirst, Policy::Paper] {
            for (dissection, merge, min_cells) in
                [(Dissection::Greedy, false, 2), (Dissection::Minimum, true, 1), (Dissection::LongestRow, true, 3)]
            {
                all.push(PatchOptions { strategy, policy, dissection, merge, min_cells, ..PatchOptions::default() });
            }
        }
    }
    all.push(PatchOptions { quality: Quality::Adapted, convex_only: true, ..PatchOptions::default() });
    all.push(PatchOptions {
        quality: Quality::Jacobian,
        adapt_dihedral: true,
        probes: Some(0),
        ..PatchOptions::default()
    });
    all
}

fn run(mesh: &SurfaceMesh, options: &PatchOptions) -> PatchResult {
    decompose(mesh, options, &Context::new()).unwrap()
}

fn sizes(result: &PatchResult) -> Vec<(u32, u32)> {
    result.patches.iter().map(|p| (p.rows.max(p.cols), p.rows.min(p.cols))).collect()
}

#[test]
fn a_grid_is_one_patch_however_its_quads_are_cut() {
    for options in all_options() {
        let mesh = field(6, 9, |_, _| 0.0, |r, c| (r * 7 + c * 3) % 5 < 2);
        let result = run(&mesh, &options);
        assert_eq!(sizes(&result), [(9, 6)], "{options:?}");
        assert!(result.leftover.is_empty());
        assert!(result.figures.q_max_deg < 1e-9);
    }
}

#[test]
fn a_torus_is_covered_by_patches_that_close_on_themselves() {
    for options in all_options() {
        let result = run(&torus(24, 12), &options);
        // The paper's policy takes quads with two places out of their polygon: on a torus there is always one.
        let least = if options.policy == Policy::Paper { 0.95 } else { 0.999 };
        assert!(result.figures.coverage > least, "{options:?}: {}", result.figures.coverage);
        assert!(result.patches.len() <= 8, "{options:?}: {:?}", sizes(&result));
    }
}

#[test]
fn every_strategy_passes_the_validator_on_an_irregular_mesh() {
    let mesh = bumpy(14, 17, 1);
    for options in all_options() {
        let result = run(&mesh, &options);
        assert!(result.patches.iter().all(|p| p.cells() >= options.min_cells as usize));
        let held: usize = result.patches.iter().map(|p| 2 * p.cells()).sum();
        assert_eq!(held + result.leftover.len(), mesh.face_count());
    }
}

#[test]
fn matchings_are_optimal_among_the_strategies() {
    let mesh = bumpy(15, 15, 2);
    let pairs = |strategy| {
        run(&mesh, &PatchOptions { strategy, min_cells: 1, merge: false, ..PatchOptions::default() }).figures
    };
    let (zones, weighted, most) =
        (pairs(Strategy::Zones), pairs(Strategy::Matching), pairs(Strategy::MatchingCardinality));
    let price =
        |f: &Figures| f.cells as f64 * (6.0 + f.q_mean_deg / 90.0) + 4.0 * (mesh.face_count() - 2 * f.cells) as f64;
    assert!(price(&weighted) <= price(&zones) + 1e-3 && price(&weighted) <= price(&most) + 1e-3);
    assert!(most.cells >= weighted.cells && most.cells >= zones.cells);
}

#[test]
fn the_minimum_dissection_needs_no_more_patches() {
    let mesh = bumpy(20, 20, 3);
    let with =
        |dissection| run(&mesh, &PatchOptions { dissection, min_cells: 1, ..PatchOptions::paper() }).patches.len();
    assert!(with(Dissection::Minimum) <= with(Dissection::Greedy));
    assert!(with(Dissection::Minimum) <= with(Dissection::LongestRow));
}

#[test]
fn threads_do_not_change_the_result() {
    let mesh = bumpy(20, 20, 4);
    for options in all_options() {
        let of = |threads| {
            let context = Context::new().with_threads(threads).unwrap();
            context.install(|| decompose(&mesh, &options, &context)).unwrap()
        };
        assert_eq!(of(1).patches, of(2).patches);
    }
}

/// The same surface with vertices, triangles and corners in another order.
fn relabelled(mesh: &SurfaceMesh, seed: u64) -> SurfaceMesh {
    let mut state = seed | 1;
    let mut random = move |n: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state % n as u64) as usize
    };
    let mut shuffled = |n: usize| {
        let mut order: Vec<usize> = (0..n).collect();
        (1..n).rev().for_each(|k| order.swap(k, random(k + 1)));
        order
    };
    let (old_vertex, old_face) = (shuffled(mesh.vertex_count()), shuffled(mesh.face_count()));
    let mut new_id = vec![0; old_vertex.len()];
    old_vertex.iter().enumerate().for_each(|(new, &old)| new_id[old] = new as u32);
    let turn = |f: &[u32], k: usize| [f[k % 3], f[(k + 1) % 3], f[(k + 2) % 3]].map(|v| new_id[v as usize]);
    let triangles: Vec<[u32; 3]> = old_face.iter().map(|&t| turn(mesh.faces().face(t), t)).collect();
    SurfaceMesh::from_triangles(old_vertex.iter().map(|&v| mesh.points()[v]).collect(), &triangles).unwrap()
}

#[test]
fn relabelling_does_not_change_the_patches() {
    for (mesh, name) in [(bumpy(18, 18, 5), "bumpy"), (torus(20, 10), "torus")] {
        for options in all_options() {
            // Among matchings of equal cost any may be found: only their cost is invariant.
            let exact = matches!(options.strategy, Strategy::Grow | Strategy::Zones);
            let (before, after) = (run(&mesh, &options), run(&relabelled(&mesh, 99), &options));
            if exact {
                assert_eq!(sizes(&before), sizes(&after), "{name} {options:?}");
            } else if options.min_cells == 1 && !options.merge {
                assert_eq!(before.figures.cells, after.figures.cells);
            }
        }
    }
}

#[test]
fn moving_and_scaling_keep_the_patches() {
    let mesh = bumpy(16, 16, 6);
    let turn = DMat3::from_rotation_z(0.5) * DMat3::from_rotation_x(1.1);
    for scale in [1e-30, 1.0, 1e30] {
        let points = mesh.points().iter().map(|&p| scale * (turn * p)).collect();
        let moved = SurfaceMesh::new(points, mesh.faces().clone()).unwrap();
        let options = PatchOptions::default();
        assert_eq!(sizes(&run(&mesh, &options)), sizes(&run(&moved, &options)), "{scale}");
    }
}

#[test]
fn barriers_are_never_crossed() {
    // A roof: two slopes that meet at 60 degrees along x = 4.
    let roof = field(6, 8, |x, _| -(x - 4.0).abs() * 30f64.to_radians().tan(), |r, c| (r + c) % 3 == 0);
    let flat = run(&roof, &PatchOptions { dihedral: 90.0, ..PatchOptions::default() });
    assert_eq!(sizes(&flat), [(8, 6)]);
    for options in all_options() {
        let result = run(&roof, &PatchOptions { dihedral: 90.0, feature_angle: Some(45.0), ..options });
        assert_eq!(sizes(&result), [(6, 4), (6, 4)]);
    }
    // The same limit given edge by edge.
    let ridge = (0..6).map(|r| [VertexId(9 * r + 4), VertexId(9 * (r + 1) + 4)]).collect();
    let options = PatchOptions { dihedral: 90.0, feature_edges: ridge, ..PatchOptions::default() };
    assert_eq!(sizes(&run(&roof, &options)), [(6, 4), (6, 4)]);
}

#[test]
fn the_dihedral_limit_adapts_to_curvature_but_not_to_creases() {
    let with = |mesh: &SurfaceMesh, adapt_dihedral| {
        run(mesh, &PatchOptions { dihedral: 5.0, adapt_dihedral, ..PatchOptions::default() }).figures
    };
    let bent = bumpy(12, 12, 3);
    assert!(with(&bent, true).coverage > with(&bent, false).coverage);
    // Two planes that meet along x = y, where the diagonals are: a crease, not curvature.
    let crease = field(8, 8, |x, y| 0.4 * (x - y).max(0.0), |_, _| true);
    assert!(with(&crease, true).dihedral_max_deg < 1.0);
}

#[test]
fn bad_options_and_inputs_are_refused() {
    let mesh = field(2, 2, |_, _| 0.0, |_, _| true);
    let code = |mesh: &SurfaceMesh, o: PatchOptions| decompose(mesh, &o, &Context::new()).err().map(|e| e.exit_code());
    assert_eq!(code(&mesh, PatchOptions { q_max: -1.0, ..PatchOptions::default() }), Some(2));
    assert_eq!(code(&mesh, PatchOptions { dihedral: f64::NAN, ..PatchOptions::default() }), Some(2));
    assert_eq!(code(&mesh, PatchOptions { min_cells: 0, ..PatchOptions::default() }), Some(2));
    let empty = SurfaceMesh::new(vec![DVec3::ZERO], Polygons::new()).unwrap();
    assert_eq!(code(&empty, PatchOptions::default()), Some(3));
    let missing = vec![[VertexId(0), VertexId(99)]];
    assert_eq!(code(&mesh, PatchOptions { feature_edges: missing, ..PatchOptions::default() }), Some(3));
}

/// Each damage must be noticed: a validator that accepts everything proves nothing.
#[test]
fn the_validator_notices_damage() {
    let mesh = bumpy(8, 8, 7);
    let options = PatchOptions::default();
    let good = run(&mesh, &options);
    let check = |patches: &[Patch], leftover: &[FaceId]| {
        validate(&mesh, patches, leftover, &options.promises(), |_, _| false).is_ok()
    };
    assert!(check(&good.patches, &good.leftover));
    assert!(!check(&good.patches[1..], &good.leftover), "a lost patch");
    type Damage = (&'static str, fn(&mut Patch));
    let damages: [Damage; 6] = [
        ("a wrong vertex", |p| p.vertices[0] = p.vertices[1]),
        ("a triangle twice", |p| p.triangles[0] = p.triangles[1]),
        ("a missing row", |p| p.rows -= 1),
        ("a vertex too many", |p| p.vertices.push(VertexId(0))),
        ("cells in another order", |p| p.triangles.rotate_left(2)),
        ("reversed", |p| *p = mirrored(p)),
    ];
    for (name, damage) in damages {
        let mut patches = good.patches.clone();
        damage(&mut patches[0]);
        assert!(!check(&patches, &good.leftover), "{name}");
    }
    let strict = Promises { q_max: 0.01, ..options.promises() };
    assert!(validate(&mesh, &good.patches, &good.leftover, &strict, |_, _| false).is_err());
    let crossed = good.patches[0].vertex(0, 1);
    assert!(
        validate(&mesh, &good.patches, &good.leftover, &options.promises(), |a, b| a == crossed || b == crossed)
            .is_err()
    );
}

/// The same grid with its columns in reverse: all cells inside out.
fn mirrored(p: &Patch) -> Patch {
    let mut grid = Grid::new(p.rows, p.cols);
    for (r, c) in p.cell_places() {
        let [bl, br, tr, tl] = p.cell(r, c);
        grid.set(r, p.cols - 1 - c, [br, bl, tl, tr], p.cell_triangles(r, c));
    }
    grid.finish()
}

#[test]
fn four_quarter_turns_are_none_and_sides_follow() {
    let mesh = bumpy(9, 9, 8);
    let patch = &run(&mesh, &PatchOptions::default()).patches[0];
    assert_eq!(patch.turned(4), *patch);
    assert_eq!(patch.turned(1).turned(3), *patch);
    for turns in 0..4 {
        let turned = patch.turned(turns);
        assert_eq!(turned.side_vertices(turns), patch.side_vertices(0));
        let (mut a, mut b) = (turned.border(), patch.border());
        a.sort_unstable();
        b.sort_unstable();
        assert_eq!(a, b);
    }
}

#[test]
fn the_quad_mesh_has_the_input_vertices_and_every_face_once() {
    let mesh = bumpy(10, 10, 9);
    let result = run(&mesh, &PatchOptions::default());
    let out = quad_mesh(&mesh, &result);
    assert_eq!(out.points, mesh.points());
    assert_eq!(out.faces.len(), result.figures.cells + result.leftover.len());
    let area = |faces: &Polygons, points: &[DVec3]| -> f64 {
        let p = |v: u32| points[v as usize];
        faces.fan().0.iter().map(|t| (p(t[1]) - p(t[0])).cross(p(t[2]) - p(t[0])).z / 2.0).sum()
    };
    // The area of the shadow on the plane does not depend on which diagonal cuts a quad.
    assert!((area(&out.faces, &out.points) - area(mesh.faces(), mesh.points())).abs() < 1e-9);
}

#[test]
fn a_corner_far_away_is_measured_as_it_is() {
    // One vertex lies at 1e23 times the size of the mesh: differences to it swallow all others.
    let mesh = bumpy(8, 8, 10);
    let (mut points, faces, ..) = mesh.into_parts();
    points[40] *= 1e23;
    let mesh = SurfaceMesh::new(points, faces).unwrap();
    for options in all_options() {
        run(&mesh, &PatchOptions { q_max: 90.0, dihedral: 180.0, ..options });
    }
}

/// Their normals are what rounding makes of them: the filters and the validator must round alike.
#[test]
fn triangles_on_a_line_are_seen_alike_by_filters_and_validator() {
    let (sin, cos) = 10f64.to_radians().sin_cos();
    for seed in 0..60 {
        let (points, faces, ..) = bumpy(5, 5, seed).into_parts();
        let along = |p: DVec3| (p.x + 0.3 * p.y) * 2e37 * DVec3::new(cos, 0.0, sin);
        let mesh = SurfaceMesh::new(points.into_iter().map(along).collect(), faces).unwrap();
        run(&mesh, &PatchOptions { min_cells: 1, ..PatchOptions::default() });
    }
}

#[test]
fn no_size_is_too_small_or_too_large() {
    let mesh = bumpy(6, 6, 10);
    let patches = run(&mesh, &PatchOptions::default()).patches;
    let (points, faces, ..) = mesh.into_parts();
    for scale in [1e-310, 1e-300, 1e-160, 1e160, 1e300] {
        let scaled = SurfaceMesh::new(points.iter().map(|&p| p * scale).collect(), faces.clone()).unwrap();
        let found = run(&scaled, &PatchOptions::default()).patches;
        // A denormal has too few digits for the angles to stay the same.
        assert!(scale < 1e-308 || found == patches, "{scale}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// Coordinates of every magnitude side by side, as a file read from the wrong byte on has them: the triangles of a
    /// cell then differ in size by any factor.
    #[test]
    fn wild_coordinates_give_valid_results(
        exponents in prop::collection::vec(prop::array::uniform3(-300i32..300), 16),
        digits in prop::collection::vec(prop::array::uniform3(-2.0..2.0), 16),
    ) {
        let wild = exponents.iter().zip(&digits);
        let points = wild.map(|(e, d)| DVec3::from_array(std::array::from_fn(|k| d[k] * 10f64.powi(e[k])))).collect();
        let (_, faces, ..) = bumpy(3, 3, 10).into_parts();
        let mesh = SurfaceMesh::new(points, faces).unwrap();
        let options = PatchOptions { dihedral: 180.0, min_cells: 1, ..PatchOptions::default() };
        let result = decompose(&mesh, &options, &Context::new());
        prop_assert!(result.is_ok(), "{:?}", result.err());
    }

    /// Any triangles at all: non-manifold, degenerate, one-sided. The result is valid or a clear error.
    #[test]
    fn soups_give_valid_results(
        coordinates in prop::collection::vec(prop::array::uniform3(-2i32..3), 3..14),
        triangles in prop::collection::vec(prop::array::uniform3(0usize..14), 1..40),
        choice in 0usize..26,
    ) {
        let points: Vec<DVec3> = coordinates.iter().map(|c| DVec3::from_array(c.map(f64::from))).collect();
        let triangles: Vec<[u32; 3]> = triangles.iter().map(|t| t.map(|v| (v % points.len()) as u32)).collect();
        let mesh = SurfaceMesh::from_triangles(points, &triangles).unwrap();
        let all = all_options();
        let options = PatchOptions { dihedral: 180.0, q_max: 180.0, ..all[choice % all.len()].clone() };
        let result = decompose(&mesh, &options, &Context::new());
        prop_assert!(result.is_ok(), "{:?}", result.err());
    }
}
