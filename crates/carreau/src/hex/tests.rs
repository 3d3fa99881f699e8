//! The whole way from a net to a mesh: counts in closed form, conformity, certificates, determinism, odd input.

use super::connection::tests::star;
use super::refine::CORE;
use super::*;
use crate::error::Error;
use crate::mesh::{Column, RawMesh, SurfaceMesh, Topology};
use glam::DVec3;
use proptest::prelude::*;
use std::collections::BTreeMap;

pub(super) fn star_net(directions: &[DVec3], radius: f64) -> CurveNet {
    let n = directions.len() as u32;
    let points = std::iter::once(DVec3::ZERO).chain(directions.iter().copied()).collect();
    CurveNet::new(points, vec![radius; n as usize + 1], (1..=n).map(|k| [0, k]).collect())
}

fn ring(n: u32) -> CurveNet {
    let at = |k: u32| {
        let (sin, cos) = (f64::from(k) * std::f64::consts::TAU / f64::from(n)).sin_cos();
        // Out of the plane, so that the frame does not close by itself.
        DVec3::new(cos, sin, 0.3 * (2.0 * sin * cos))
    };
    CurveNet::new((0..n).map(at).collect(), vec![0.15; n as usize], (0..n).map(|k| [k, (k + 1) % n]).collect())
}

fn theta() -> CurveNet {
    let mut net = ring(12);
    net.points.push(DVec3::ZERO);
    net.radii.push(0.1);
    net.ids.push(12);
    net.edges.extend([[0, 12], [12, 6]]);
    net
}

fn tree() -> CurveNet {
    let points = [[0, 0, 0], [0, 0, 4], [3, 0, 7], [-3, 1, 7], [3, 3, 10], [5, -2, 10], [-3, -2, 11]];
    let points = points.map(|p: [i32; 3]| DVec3::from(p.map(f64::from))).to_vec();
    CurveNet::new(points, vec![0.8, 0.7, 0.5, 0.6, 0.4, 0.4, 0.3], vec![[0, 1], [1, 2], [1, 3], [2, 4], [2, 5], [3, 6]])
}

pub(super) fn assert_conforming(hexes: &[[u32; 8]], points: &[DVec3], cycles: &[usize]) {
    assert_eq!(flaw(hexes, points, cycles), None);
}

/// Where a mesh is not one in which every face has one or two cells that see it from opposite sides, and the boundary is a
/// closed manifold whose genus is the number of cycles.
pub(super) fn flaw(hexes: &[[u32; 8]], points: &[DVec3], cycles: &[usize]) -> Option<String> {
    let mut faces: BTreeMap<[u32; 4], Vec<[u32; 4]>> = BTreeMap::new();
    for h in hexes {
        for f in crate::mesh::HEX_FACES {
            let face = f.map(|c| h[c]);
            let start = (0..4).min_by_key(|&k| face[k]).unwrap();
            let turned: [u32; 4] = std::array::from_fn(|k| face[(start + k) % 4]);
            let mut key = face;
            key.sort_unstable();
            if key.windows(2).any(|w| w[0] == w[1]) {
                return Some(format!("a face with equal corners {face:?}"));
            }
            faces.entry(key).or_default().push(turned);
        }
    }
    let fits = |sides: &Vec<[u32; 4]>| match sides[..] {
        [_] => true,
        [[a, b, c, d], other] => other == [a, d, c, b],
        _ => false,
    };
    if let Some(sides) = faces.values().find(|sides| !fits(sides)) {
        return Some(format!("cells do not share a face {sides:?}"));
    }
    let raw = RawMesh {
        points: points.to_vec(),
        cells: crate::mesh::Cells { hexes: hexes.to_vec(), ..Default::default() },
        ..RawMesh::default()
    };
    let topology = Topology::of(&raw.boundary().unwrap().into_surface().unwrap());
    let is_sound = topology.closed && topology.manifold && topology.consistently_oriented;
    let is_same = topology.components == cycles.len() && topology.genus == Some(cycles.iter().sum());
    (!is_sound || !is_same).then(|| format!("its boundary {topology:?}"))
}

/// Hexes, boundary quads and vertices of the base mesh and the paddings, in closed form.
#[test]
fn counts_are_the_closed_form() {
    for net in [tree(), ring(9), theta()] {
        let around = net.incidence();
        let valence = |v: usize| around.valence(v as u32);
        let nodes = 0..net.points.len();
        let (e, ends) = (net.edges.len(), nodes.clone().filter(|&v| valence(v) == 1).count());
        let vertices: usize = nodes.map(|v| if valence(v) == 1 { 9 } else { 3 * valence(v) + 3 }).sum();
        let base = base_mesh(&net);
        assert_eq!((base.hexes.len(), base.points.len()), (4 * e, vertices));
        assert_conforming(&base.hexes, &base.points, &net.cycles());
        for (padding, hexes, quads) in [
            (Padding::None, 4 * e, 8 * e + 4 * ends),
            (Padding::Sides, 12 * e, 8 * e + 12 * ends),
            (Padding::All, 12 * e + 4 * ends, 8 * e + 4 * ends),
        ] {
            let options = HexOptions { padding, stage: Stage::Base, allow_invalid: true, ..HexOptions::default() };
            let result = from_net(&net, &options, &Context::new()).unwrap();
            assert_eq!((result.mesh.hexes.len(), result.mesh.quads.len()), (hexes, quads));
            assert_conforming(&result.mesh.hexes, &result.mesh.points, &net.cycles());
            assert_eq!(result.mesh.tags.iter().max(), Some(&(1 + ends as i32)));
            if padding != Padding::None {
                assert!(result.figures.quality.certified && result.figures.quality.inverted == 0);
            }
        }
    }
}

/// K = 2 per halving across, N = 2 along; the layer on an end is halved in its thickness too.
#[test]
fn halving_multiplies_the_counts() {
    let net = tree();
    let (e, ends) = (net.edges.len(), 4);
    let options = HexOptions { refine_across: Some(1), refine_along: 1, stage: Stage::Base, ..HexOptions::default() };
    let result = from_net(&net, &options, &Context::new()).unwrap();
    assert_eq!(result.mesh.hexes.len(), 12 * e * 4 * 2 + 4 * ends * 8);
    assert_eq!(result.mesh.quads.len(), 8 * e * 2 * 2 + 4 * ends * 4);
    assert_conforming(&result.mesh.hexes, &result.mesh.points, &[0]);
    assert!(
        result.figures.quality.certified && result.figures.quality.scaled_jacobian_min > 0.2,
        "{:?}",
        result.figures
    );
    // Σ (valence − 4) over interior edges: 2 K (4 n − 8) at every branching and 3-valent edges of the layer.
    let excess: i64 = result
        .figures
        .quality
        .irregular_edges
        .iter()
        .filter(|e| *e.0 > 4)
        .map(|(&v, &n)| (i64::from(v) - 4) * n as i64)
        .sum();
    assert_eq!(excess, 2 * 2 * (2 * (4 * 3 - 8)));
}

#[test]
fn resampled_meshes_are_certified_and_the_same_for_any_number_of_threads() {
    for net in [tree(), ring(9), theta()] {
        let mesh = |threads| {
            let context = Context::new().with_threads(threads).unwrap();
            context.install(|| from_net(&net, &HexOptions::default(), &context)).unwrap()
        };
        let (one, two) = (mesh(1), mesh(2));
        assert_eq!(one.mesh, two.mesh);
        assert_conforming(&one.mesh.hexes, &one.mesh.points, &net.cycles());
        assert!(one.figures.quality.certified && one.figures.quality.scaled_jacobian_min > 0.3, "{:?}", one.figures);
        // Wall vertices lie about at the radius of the net.
        let radius = |p: DVec3| {
            let near = |e: &[u32; 2]| {
                let [a, b] = e.map(|v| one.skeleton.points[v as usize]);
                let t = ((p - a).dot(b - a) / a.distance_squared(b)).clamp(0.0, 1.0);
                let r = one.skeleton.radii[e[0] as usize] * (1.0 - t) + one.skeleton.radii[e[1] as usize] * t;
                (p.distance(a.lerp(b, t)), r)
            };
            one.skeleton.edges.iter().map(near).min_by(|a, b| a.0.total_cmp(&b.0)).map_or(0.0, |(d, r)| d / r)
        };
        let mut ratios: Vec<f64> =
            one.mesh.quads.iter().flatten().map(|&v| radius(one.mesh.points[v as usize])).collect();
        ratios.sort_by(f64::total_cmp);
        assert!((ratios[ratios.len() / 2] - 1.0).abs() < 0.1, "{}", ratios[ratios.len() / 2]);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(6))]
    #[test]
    fn random_stars_conform_and_are_certified(n in 3usize..9, numbers in prop::collection::vec(-1.0f64..1.0, 400)) {
        if let Some(directions) = star(&numbers, n, 25.0) {
            let options = HexOptions { stage: Stage::Base, ..HexOptions::default() };
            let result = from_net(&star_net(&directions, 0.2), &options, &Context::new()).unwrap();
            assert_conforming(&result.mesh.hexes, &result.mesh.points, &[0]);
            prop_assert!(result.figures.quality.inverted == 0);
        }
    }
}

#[test]
fn odd_nets() {
    let x = |x: f64| DVec3::new(x, 0.0, 0.0);
    // A U-turn (whose cells stay folded; a layer of them takes minutes), a fat node beside a short segment (which resampling
    // passes over), a narrow fork.
    let turn = CurveNet::new(vec![x(0.0), x(1.0), DVec3::new(0.0, 0.05, 0.0)], vec![0.1; 3], vec![[0, 1], [1, 2]]);
    let fat = CurveNet::new(vec![x(0.0), x(0.1), x(3.0)], vec![0.1, 2.0, 0.1], vec![[0, 1], [1, 2]]);
    let narrow = CurveNet::new(
        vec![x(0.0), x(-2.0), DVec3::new(3.0, 0.2, 0.0), DVec3::new(3.0, -0.2, 0.0)],
        vec![0.3; 4],
        vec![[0, 1], [0, 2], [0, 3]],
    );
    let nets = [(turn, Padding::None, true), (fat, Padding::All, false), (narrow, Padding::All, true)];
    for (net, padding, warned) in nets {
        let options = HexOptions { allow_invalid: true, padding, ..HexOptions::default() };
        let result = from_net(&net, &options, &Context::new()).unwrap();
        assert_conforming(&result.mesh.hexes, &result.mesh.points, &[0]);
        assert_eq!(!result.warnings.is_empty(), warned, "{:?}", result.warnings);
    }
    let code = |options: HexOptions| from_net(&tree(), &options, &Context::new()).map_err(|e| e.exit_code()).err();
    assert_eq!(code(HexOptions { refine_across: Some(99), ..HexOptions::default() }), Some(2));
    assert_eq!(code(HexOptions { hexes: Some(10), edge_length: Some(1.0), ..HexOptions::default() }), Some(2));
    assert_eq!(code(HexOptions { radius: Some(-1.0), ..HexOptions::default() }), Some(2));
}

#[test]
fn the_number_of_hexes_is_followed() {
    let options = |n| HexOptions { hexes: Some(n), ..HexOptions::default() };
    let count = |n| from_net(&tree(), &options(n), &Context::new()).unwrap().mesh.hexes.len() as f64;
    for n in [400, 1500] {
        assert!((0.8..=1.0).contains(&(count(n) / n as f64)), "{} of {n}", count(n));
    }
}

#[test]
fn tags_become_labels_of_the_faces() {
    let raw: RawMesh = from_net(&tree(), &HexOptions::default(), &Context::new()).unwrap().mesh.into();
    let Some(Column::Label(tags)) = raw.attributes.face.get("ref") else { panic!("no tags") };
    let mut kinds = tags.clone();
    kinds.sort_unstable();
    kinds.dedup();
    assert_eq!(kinds, [1, 2, 3, 4, 5]);
}

/// A bent tube without ends about a quarter of a circle of radius 4; radius 1 in the middle, less at one end.
fn bent_tube() -> SurfaceMesh {
    let (rounds, around) = (20, 16);
    let at = |i: u32, j: u32| i * around + j % around;
    let point = |k: u32| {
        let (t, a) = (f64::from(k / around) / f64::from(rounds), f64::from(k % around) / f64::from(around));
        let (sin, cos) = (std::f64::consts::TAU * a).sin_cos();
        let r = 4.0 + (1.0 - 0.4 * t) * cos;
        let (along, out) = (std::f64::consts::FRAC_PI_2 * t).sin_cos();
        DVec3::new(r * out, r * along, -(1.0 - 0.4 * t) * sin)
    };
    let points = (0..(rounds + 1) * around).map(point).collect();
    let cell = |k: u32| {
        let (i, j) = (k / around, k % around);
        [[at(i, j), at(i, j + 1), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i + 1, j)]]
    };
    SurfaceMesh::from_triangles(points, &(0..rounds * around).flat_map(cell).collect::<Vec<_>>()).unwrap()
}

/// Certified, on the surface, as many hexes as asked for at most; ends in their planes with tags of their own.
#[test]
fn an_open_tube_is_meshed_on_its_surface_with_caps() {
    let mesh = bent_tube();
    let options = HexOptions { hexes: Some(1000), ..HexOptions::default() };
    let result = from_surface(&mesh, None, &options, &Context::new()).unwrap();
    let f = &result.figures;
    // No cell has a straight angle on the border of an end.
    assert!(f.quality.certified && f.quality.scaled_jacobian_min > 0.55, "{f:?}");
    assert!((400..=1000).contains(&f.hexes));
    assert_conforming(&result.mesh.hexes, &result.mesh.points, &[0]);
    let mut kinds = result.mesh.tags.clone();
    kinds.sort_unstable();
    kinds.dedup();
    assert_eq!(kinds, [1, 2, 3]);
    assert!((0.93..1.02).contains(&f.volume_ratio.unwrap()), "{:?}", f.volume_ratio);
    let tree = crate::geometry::search_tree::TriangleTree::new(mesh.points(), &mesh.faces().fan().0);
    for (q, &tag) in result.mesh.quads.iter().zip(&result.mesh.tags) {
        for p in q.map(|v| result.mesh.points[v as usize]) {
            // The ends lie in the planes y = 0 and x = 0.
            let off = if tag == 1 { tree.closest(p).unwrap().distance() } else { p.y.abs().min(p.x.abs()) };
            assert!(off < 1e-4 * mesh.diagonal(), "{off} on {tag}");
        }
    }
}

#[test]
fn a_given_skeleton_is_used_and_a_torus_stays_one() {
    let mesh = crate::mesh::test_models::torus(40, 20);
    let at = |k: u32| {
        let (sin, cos) = (f64::from(k) * std::f64::consts::TAU / 24.0).sin_cos();
        DVec3::new(2.0 * cos, 2.0 * sin, 0.0)
    };
    let net = CurveNet::new((0..24).map(at).collect(), vec![0.5; 24], (0..24).map(|k| [k, (k + 1) % 24]).collect());
    let options = HexOptions { hexes: Some(900), ..HexOptions::default() };
    let result = from_surface(&mesh, Some(&net), &options, &Context::new()).unwrap();
    assert!(
        result.figures.quality.certified && result.figures.quality.scaled_jacobian_min > 0.4,
        "{:?}",
        result.figures
    );
    assert_conforming(&result.mesh.hexes, &result.mesh.points, &[1]);
    assert!(result.mesh.tags.iter().all(|&t| t == 1));
}

/// Five tubes from one point, two of them side by side for three radii.
fn narrow_star() -> Vec<DVec3> {
    let narrow = |y: f64| DVec3::new(1.0, y, 0.0).normalize();
    vec![narrow(0.3), narrow(-0.3), DVec3::new(-0.7, 0.7, 0.2).normalize(), -DVec3::Y, DVec3::new(-0.3, 0.1, 1.0)]
}

fn star_surface(directions: &[DVec3]) -> SurfaceMesh {
    let tube = |d: &DVec3| crate::sample::Tube { ends: [DVec3::ZERO, *d], radii: [0.12; 2] };
    let parts: Vec<_> = directions.iter().map(tube).collect();
    crate::sample::tubes(&parts, 0.04, 0.05, &Context::new()).unwrap().mesh.triangulated().unwrap()
}

/// The cells of a narrow fork reach into the cleft between its tubes.
#[test]
fn a_star_of_tubes_side_by_side_is_on_its_surface() {
    let result = from_surface(&star_surface(&narrow_star()), None, &HexOptions::default(), &Context::new()).unwrap();
    let f = &result.figures;
    assert!(f.quality.certified && f.distance_mean.unwrap() < 1.5e-3, "{f:?}");
    assert!((0.98..1.02).contains(&f.volume_ratio.unwrap()), "{:?}", f.volume_ratio);
    assert!(!result.warnings.iter().any(|w| w.contains("could not be put")), "{:?}", result.warnings);
}

/// Branchings that were merged beside the point that the tubes aim at go there.
#[test]
fn branches_meet_where_their_tubes_aim_at() {
    let directions = narrow_star();
    let mesh = star_surface(&directions);
    let (closed, _) = crate::skeleton::prepared(&mesh, &Context::new()).unwrap();
    let mut points = vec![DVec3::new(0.08, 0.0, 0.03)];
    let mut edges = Vec::new();
    for d in &directions {
        for k in 1..=10 {
            edges.push([if k == 1 { 0 } else { points.len() as u32 - 1 }, points.len() as u32]);
            points.push(0.1 * f64::from(k) * *d);
        }
    }
    let mut net = CurveNet::new(points, vec![0.12; 51], edges);
    junction_centres::meet(&mut net, &target::Target::new(&closed));
    assert!(net.points[0].length() < 0.02, "{}", net.points[0]);
}

/// The segments of a mesh are halved along one by one.
#[test]
fn a_segment_halved_alone_conforms() {
    let net = tree();
    let mut tube = refine::pad(&net, &assemble::base_mesh(&net, false), Padding::All, CORE);
    let before = tube.hexes.len();
    tube.refine_along(|segment| segment == 2);
    assert_eq!(tube.hexes.len(), before + 12);
    assert_conforming(&tube.hexes, &tube.points, &net.cycles());
}

/// Steps as long as usual in radii would be hundreds of millions, and a thousand times as long still too many.
#[test]
fn a_thread_has_few_cells() {
    let net = CurveNet::new(vec![DVec3::ZERO, DVec3::X], vec![1e-8; 2], vec![[0, 1]]);
    let made = from_net(&net, &HexOptions::default(), &Context::new()).unwrap();
    assert!((1000..100_000).contains(&made.mesh.hexes.len()), "{}", made.mesh.hexes.len());
}

/// A closed tube whose ends are flat: both are ends with tags of their own. Lengthened, they are flat, two radii farther out,
/// and the faces around the new pieces continue those of the wall.
#[test]
fn flat_ends_of_a_closed_tube_are_ends() {
    let closed = crate::skeleton::closed(&bent_tube()).unwrap().mesh;
    let at = |k: u32| {
        let (sin, cos) = (f64::from(k) / 20.0 * std::f64::consts::FRAC_PI_2).sin_cos();
        DVec3::new(4.0 * sin, 4.0 * cos, 0.0)
    };
    // As the flow leaves it: it stops before the ends.
    let nodes: Vec<DVec3> = (4..=16).map(at).collect();
    let net = CurveNet::new(nodes.clone(), vec![0.8; nodes.len()], (1..13).map(|k| [k - 1, k]).collect());
    let options = HexOptions { hexes: Some(200), extend: Some(2.0), ..HexOptions::default() };
    let long = from_surface(&closed, Some(&net), &options, &Context::new()).unwrap();
    assert_eq!(long.flat_caps, [2, 3]);
    assert!(long.figures.quality.certified && long.figures.quality.scaled_jacobian_min > 0.4, "{:?}", long.figures);
    // An octagon in a circle has .90 of its area, and the wall is bent.
    assert!((0.87..1.02).contains(&long.figures.volume_ratio.unwrap()), "{:?}", long.figures.volume_ratio);
    assert_conforming(&long.mesh.hexes, &long.mesh.points, &[0]);
    for tag in [2, 3] {
        let faces = long.mesh.quads.iter().zip(&long.mesh.tags).filter(|f| *f.1 == tag);
        let points: Vec<DVec3> = faces.flat_map(|f| f.0.map(|v| long.mesh.points[v as usize])).collect();
        let by = points.iter().map(|p| -p.x.min(p.y)).fold(0.0, f64::max);
        // The section is a polygon in a circle of radius 1 or .6.
        assert!((1.8..2.02).contains(&by) || (1.08..1.21).contains(&by), "{by}");
        assert!(points.iter().all(|p| (p.y + by).abs().min((p.x + by).abs()) < 1e-9), "flat");
    }
    let far = |q: &[u32; 4]| q.iter().any(|&v| long.mesh.points[v as usize].min_element() < -1.05);
    let is_side = |f: &usize| long.mesh.tags[*f] == 1 && far(&long.mesh.quads[*f]);
    let sides: Vec<usize> = (0..long.mesh.quads.len()).filter(is_side).collect();
    assert!(!sides.is_empty());
    for f in sides {
        let origin = long.origins[f] as usize;
        assert!(origin != f && long.mesh.tags[origin] == 1 && long.origins[origin] as usize == origin);
    }
}

/// Steps far shorter than a flat end is wide: the last nodes have the radius of the tube, not their distance from the cap, and
/// the count that is asked for is met because flat ends take no cells.
#[test]
fn short_steps_before_a_flat_end_have_the_radius_of_the_tube() {
    let cylinder = crate::sample::cylinder(1.0, 3.0, 0.4).unwrap().mesh.triangulated().unwrap();
    let net = CurveNet::new(vec![DVec3::Z * 0.3, DVec3::Z * 2.7], vec![1.0; 2], vec![[0, 1]]);
    let by_count = HexOptions { hexes: Some(400), ..HexOptions::default() };
    let by_length =
        HexOptions { edge_length: Some(0.2), refine_across: Some(0), padding: Padding::Sides, ..HexOptions::default() };
    // By length the section is an octagon, which has .90 of the area of its circle and is .076 inside of it.
    for (options, far, least) in [(by_count, 0.015, 0.96), (by_length, 0.02, 0.9)] {
        let result = from_surface(&cylinder, Some(&net), &options, &Context::new()).unwrap();
        let f = &result.figures;
        assert_eq!(result.flat_caps, [2, 3]);
        assert!(f.quality.certified && f.quality.scaled_jacobian_min > 0.5 && f.quality.overlap == 0.0, "{f:?}");
        assert!(f.distance_max.unwrap() < far && (least..1.01).contains(&f.volume_ratio.unwrap()), "{f:?}");
        assert!(options.hexes.is_none_or(|n| (0.7..=1.0).contains(&(f.hexes as f64 / n as f64))), "{}", f.hexes);
    }
}

/// A tube with a waist that has no room for the layers: they are thin there, and as asked elsewhere.
#[test]
fn layers_are_thin_only_where_there_is_no_room() {
    let places = [0.0, 3.0, 4.0, 6.0, 7.0, 10.0].map(|x| DVec3::X * x).to_vec();
    let net = CurveNet::new(places, vec![1.0, 1.0, 0.4, 0.4, 1.0, 1.0], (1..6).map(|k| [k - 1, k]).collect());
    let layers = Some(Layers { count: 2, first: 0.2, growth: 1.5 });
    let made = from_net(&net, &HexOptions { layers, ..HexOptions::default() }, &Context::new()).unwrap();
    let figures = made.figures.layers.as_ref().unwrap();
    assert!(made.figures.quality.certified && (0.3..0.8).contains(&figures.least), "{figures:?}");
    assert!(figures.as_asked > 0.6 && (figures.least_at[0] - 5.0).abs() < 2.0, "{figures:?}");
}

/// Five layers on a straight tube and on a fork: as thick as asked for along the wall's normal, in proportion, and certified.
#[test]
fn layers_have_the_thickness_asked_for() {
    let straight = CurveNet::new(vec![DVec3::ZERO, DVec3::X * 6.0], vec![1.0; 2], vec![[0, 1]]);
    for (net, first, share) in [(straight, 0.02, 0.99), (tree(), 0.006, 0.95)] {
        let (plain, context) = (HexOptions::default(), Context::new());
        let before = from_net(&net, &plain, &context).unwrap();
        let wanted = Layers { count: 5, first, growth: 1.3 };
        let after = from_net(&net, &HexOptions { layers: Some(wanted), ..plain }, &context).unwrap();
        let f = &after.figures;
        let layers = f.layers.as_ref().unwrap();
        assert!(f.quality.certified && layers.as_asked > share, "{layers:?} {:?}", after.warnings);
        assert!((layers.thickness - first * (1.3f64.powi(5) - 1.0) / 0.3).abs() < 1e-12);
        let of_wall = before.mesh.tags.iter().filter(|t| **t == 1).count();
        assert_eq!(f.hexes, before.figures.hexes + 5 * of_wall);
        assert_conforming(&after.mesh.hexes, &after.mesh.points, &net.cycles());
        assert_eq!(after.mesh.tags.iter().max(), before.mesh.tags.iter().max());
        // The wall stays where it was.
        let wall = |r: &HexResult| {
            let faces = r.mesh.quads.iter().zip(&r.mesh.tags).filter(|f| *f.1 == 1);
            let mut on: Vec<[u64; 3]> =
                faces.flat_map(|f| f.0.map(|v| r.mesh.points[v as usize].to_array().map(f64::to_bits))).collect();
            on.sort_unstable();
            on.dedup();
            on
        };
        assert_eq!(wall(&before), wall(&after));
        // Edges across the layers grow by the factor.
        let last = after.mesh.hexes.len() - of_wall;
        let [outer, next] = [last, last - of_wall].map(|h| {
            let [a, b] = [0, 4].map(|c| after.mesh.points[after.mesh.hexes[h][c] as usize]);
            a.distance(b)
        });
        assert!((next / outer - 1.3).abs() < 1e-9, "{next} {outer}");
    }
}

/// The Jacobian of cells of second order at places inside of them, the least over their mean volume, straight from its definition.
fn least_jacobian(raw: &RawMesh) -> f64 {
    let nodes = raw.second_order.as_ref().unwrap();
    let shape = |k: usize, t: f64| [(2.0 * t - 1.0) * (t - 1.0), 4.0 * t * (1.0 - t), t * (2.0 * t - 1.0)][k];
    let slope = |k: usize, t: f64| [4.0 * t - 3.0, 4.0 - 8.0 * t, 4.0 * t - 1.0][k];
    let lattice = crate::geometry::second_order::LATTICE;
    let mut least = f64::INFINITY;
    for (cell, middles) in raw.cells.hexes.iter().zip(&nodes.hexes) {
        let p: Vec<DVec3> = cell.iter().chain(middles).map(|&v| raw.points[v as usize]).collect();
        for n in 0..27 {
            let t = [n / 9, n / 3 % 3, n % 3].map(|k| f64::from(k) / 2.0);
            let derivative = |axis: usize| {
                p.iter().zip(lattice).fold(DVec3::ZERO, |sum, (p, at)| {
                    let factor = |a: usize| if a == axis { slope(at[a], t[a]) } else { shape(at[a], t[a]) };
                    sum + *p * (factor(0) * factor(1) * factor(2))
                })
            };
            least = least.min(derivative(0).dot(derivative(1).cross(derivative(2))));
        }
    }
    least
}

/// Nodes of second order are on the surface, or on the round wall of a tube, also with layers and on lengthened ends; no cell folds.
#[test]
fn nodes_of_second_order_are_on_the_wall() {
    let straight = CurveNet::new(vec![DVec3::ZERO, DVec3::X * 4.0], vec![1.0; 2], vec![[0, 1]]);
    let layers = Some(Layers { count: 2, first: 0.05, growth: 1.2 });
    let options = HexOptions {
        padding: Padding::Sides,
        order: Order::Second,
        layers,
        extend: Some(1.0),
        ..HexOptions::default()
    };
    let tube = from_net(&straight, &options, &Context::new()).unwrap();
    assert_eq!(tube.figures.straight_edges, Some(StraightEdges { count: 0, at: None }));
    let raw = tube.raw();
    assert!(raw.check().is_ok() && least_jacobian(&raw) > 0.0);
    assert_eq!(raw.points.len(), tube.figures.vertices);
    let nodes = raw.second_order.as_ref().unwrap();
    let from_axis = |v: u32| raw.points[v as usize].with_x(0.0).length();
    let mut bent = 0;
    for (q, middles) in raw.faces.iter().zip(&nodes.quads).zip(&tube.mesh.tags).filter(|f| *f.1 == 1).map(|f| f.0) {
        for k in 0..4 {
            let [a, m, b] = [q[k], middles[k], q[(k + 1) % 4]].map(from_axis);
            let straight = 0.5 * (raw.points[q[k] as usize] + raw.points[q[(k + 1) % 4] as usize]).with_x(0.0).length();
            // Corners are nearly at radius 1, the middles of eight sides at .92.
            assert!((m - 0.5 * (a + b)).abs() < 0.02, "{a} {m} {b}");
            bent += usize::from(m - straight > 0.05);
        }
    }
    assert!(bent > 50, "{bent}");

    let mesh = crate::mesh::test_models::torus(40, 20);
    let at = |k: u32| {
        let (sin, cos) = (f64::from(k) * std::f64::consts::TAU / 24.0).sin_cos();
        DVec3::new(2.0 * cos, 2.0 * sin, 0.0)
    };
    let net = CurveNet::new((0..24).map(at).collect(), vec![0.5; 24], (0..24).map(|k| [k, (k + 1) % 24]).collect());
    let options = HexOptions { hexes: Some(300), order: Order::Second, ..HexOptions::default() };
    let torus = from_surface(&mesh, Some(&net), &options, &Context::new()).unwrap();
    let raw = torus.raw();
    assert!(least_jacobian(&raw) > 0.0, "{:?}", torus.warnings);
    let tree = crate::geometry::search_tree::TriangleTree::new(mesh.points(), &mesh.faces().fan().0);
    let on = raw
        .second_order
        .as_ref()
        .unwrap()
        .quads
        .as_flattened()
        .iter()
        .filter(|&&v| tree.distance(raw.points[v as usize]) < 1e-9);
    let (on, all) = (on.count(), 5 * raw.faces.len());
    assert!(on * 10 > all * 9, "{on} of {all}");
    // Written as corners alone it is the mesh of first order.
    assert_eq!(raw.first_order().points, torus.mesh.points);
}

/// A length far below what fits is refused, not replaced.
#[test]
fn steps_too_short_are_refused() {
    let options = HexOptions { edge_length: Some(1e-7), ..HexOptions::default() };
    for result in
        [from_net(&tree(), &options, &Context::new()), from_surface(&bent_tube(), None, &options, &Context::new())]
    {
        assert!(matches!(result, Err(Error::Options(_))), "{:?}", result.map(|r| r.figures.hexes));
    }
}

/// Layers thicker than the tube are thinned, which is said, and the cells are certified all the same.
#[test]
fn layers_without_room_are_thinned() {
    let wanted = Layers { count: 3, first: 0.4, growth: 1.5 };
    let options = HexOptions { layers: Some(wanted), ..HexOptions::default() };
    let result = from_net(&tree(), &options, &Context::new()).unwrap();
    let layers = result.figures.layers.as_ref().unwrap();
    assert!(result.figures.quality.certified && layers.as_asked < 0.5 && layers.least > 0.0, "{layers:?}");
    assert!(result.warnings.iter().any(|w| w.contains("no room")), "{:?}", result.warnings);
    assert!(HexOptions { layers: Some(Layers { growth: 0.5, ..wanted }), ..HexOptions::default() }.validate().is_err());
    assert!(HexOptions { extend: Some(0.0), ..HexOptions::default() }.validate().is_err());
}
