//! Skeletons of surfaces whose skeleton is known.

use super::tuning::MANY;
use super::*;
use crate::mesh::test_models::*;
use glam::DVec3;

fn skeleton(mesh: &SurfaceMesh) -> Skeleton {
    extract(mesh, &SkeletonOptions::default(), &Context::new()).unwrap()
}

/// A tube without ends from z = 0 to `length`, outward.
fn tube(rounds: u32, around: u32, length: f64) -> SurfaceMesh {
    let at = |i: u32, j: u32| i * around + j % around;
    let point = |k: u32| {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(k % around) / f64::from(around)).sin_cos();
        DVec3::new(cos, sin, length * f64::from(k / around) / f64::from(rounds))
    };
    let points: Vec<DVec3> = (0..(rounds + 1) * around).map(point).collect();
    let cell = |k: u32| {
        let (i, j) = (k / around, k % around);
        [[at(i, j), at(i, j + 1), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i + 1, j)]]
    };
    triangles(&points, &(0..rounds * around).flat_map(cell).collect::<Vec<_>>())
}

/// One cycle for the one handle, on the circle in the middle, at the distance of the tube's radius.
#[test]
fn a_torus_becomes_its_circle() {
    around_in_the_middle(&torus(60, 24));
}

/// A surface with more vertices than are used throughout.
#[test]
fn a_very_fine_torus_becomes_its_circle() {
    let mesh = torus(500, 220);
    assert!(mesh.vertex_count() > MANY);
    around_in_the_middle(&mesh);
}

fn around_in_the_middle(mesh: &SurfaceMesh) {
    let s = skeleton(mesh);
    assert_eq!((s.figures.cycles, s.figures.extremities, s.figures.branchings), (1, 0, 0));
    assert_eq!(s.net.cycles(), [1]);
    for (p, r) in s.net.points.iter().zip(&s.net.radii) {
        let off = DVec3::new(p.truncate().length() - 2.0, p.z, 0.0).length();
        assert!(off < 0.12 && (0.35..0.51).contains(r), "{p} {r}");
    }
    assert!(s.net.points.len() > 20);
    assert_eq!(s.preimage.len(), mesh.vertex_count());
    // Every vertex was drawn to a node that is not far from it.
    for (v, &node) in s.preimage.iter().enumerate() {
        assert!(mesh.points()[v].distance(s.net.points[node as usize]) < 1.0);
    }
}

/// Triangles of a CAD system, as long as the tube, closed by flat fans or open: the axis, from end to end, at the radius.
#[test]
fn a_tube_of_long_triangles_gets_its_axis_from_end_to_end() {
    for (around, length, is_closed) in [(24, 40.0, true), (96, 30.0, true), (16, 20.0, false)] {
        let open = tube(1, around, length);
        let mesh = if is_closed { closed(&open).unwrap().mesh } else { open };
        let s = skeleton(&mesh);
        assert_eq!((s.figures.extremities, s.figures.branchings, s.figures.components), (2, 0, 1));
        assert_eq!(s.preimage.len(), s.closed.mesh.vertex_count());
        let inner = (std::f64::consts::PI / f64::from(around)).cos();
        for (p, r) in s.net.points.iter().zip(&s.net.radii) {
            assert!(p.truncate().length() < 0.02 && (inner - 0.02..1.01).contains(r), "{p} {r}");
        }
        let heights = s.net.points.iter().map(|p| p.z);
        let [low, high] = [heights.clone().fold(f64::MAX, f64::min), heights.fold(f64::MIN, f64::max)];
        assert!(low > 0.0 && low < 0.05 && high < length && high > length - 0.05, "{low} {high}");
    }
}

#[test]
fn an_open_tube_gets_two_lids_and_an_axis() {
    let s = skeleton(&tube(24, 16, 12.0));
    assert_eq!((s.figures.lids, s.figures.extremities, s.figures.branchings), (2, 2, 0));
    for lid in &s.closed.lids {
        let end = if lid.centre.z > 6.0 { 12.0 } else { 0.0 };
        assert!(lid.centre.distance(DVec3::Z * end) < 1e-9 && (lid.radius - 1.0).abs() < 1e-9 && lid.flatness < 1e-9);
        assert!(lid.normal.z * (lid.centre.z - 6.0) > 0.9 * 6.0);
    }
    assert!(s.net.points.iter().all(|p| p.truncate().length() < 0.1 && (0.0..12.0).contains(&p.z)));
    assert!(!s.warnings.is_empty());
}

/// A tube that is short, or bends up to its flat ends, closed or open: the branch leads from the middle of one end to that of the other,
/// in the middle of the tube, with its radius, and the rims of the ends are no limbs.
#[test]
fn a_branch_leads_to_the_flat_ends_of_a_short_tube_and_of_a_bent_one() {
    let bent = |p: DVec3| {
        let (sin, cos) = (p.z / 4.0).sin_cos();
        DVec3::new(4.0 - (4.0 - p.x) * cos, p.y, (4.0 - p.x) * sin)
    };
    for (length, is_bent, is_closed) in [(3.0, false, true), (8.0, true, true), (8.0, true, false)] {
        let straight = tube(3 * length as u32, 16, length);
        let open = if is_bent { moved(&straight, bent) } else { straight };
        let mesh = if is_closed { closed(&open).unwrap().mesh } else { open };
        let s = skeleton(&mesh);
        assert_eq!((s.figures.extremities, s.figures.branchings), (2, 0), "{length} {:?}", s.warnings);
        assert!(!s.warnings.iter().any(|w| w.contains("limb")), "{:?}", s.warnings);
        for (p, r) in s.net.points.iter().zip(&s.net.radii) {
            let off = if is_bent { DVec3::new(4.0 - p.x, 0.0, p.z).length() - 4.0 } else { p.x };
            assert!(off.hypot(p.y) < 0.05 && (0.95..1.01).contains(r), "{length} {p} {r}");
        }
        let axis = |z: f64| if is_bent { bent(DVec3::Z * z) } else { DVec3::Z * z };
        for end in [axis(0.0), axis(length)] {
            assert!(s.net.points.iter().any(|p| p.distance(end) < 0.05), "{length} {end}");
        }
    }
}

/// Four tubes that meet at right angles do so in one place.
#[test]
fn a_cross_has_one_branching() {
    let tube = |to: DVec3, radius| crate::sample::Tube { ends: [DVec3::ZERO, to], radii: [radius; 2] };
    let parts = [tube(DVec3::X, 0.2), tube(-DVec3::X, 0.2), tube(DVec3::Y, 0.15), tube(-DVec3::Y, 0.15)];
    let mesh = crate::sample::tubes(&parts, 0.04, 0.06, &Context::new()).unwrap().mesh.triangulated().unwrap();
    let s = skeleton(&mesh);
    assert_eq!((s.figures.extremities, s.figures.branchings), (4, 1));
    assert_eq!(s.preimage.len(), mesh.vertex_count());
    assert!(s.preimage.iter().all(|&node| (node as usize) < s.net.points.len()));
}

#[test]
fn components_each_get_theirs_and_the_sense_does_not_matter() {
    let far = moved(&turned(&tube(24, 16, 12.0), |_| true), |p| p + DVec3::X * 9.0);
    let s = skeleton(&together(&[torus(60, 24), far]));
    assert_eq!(s.net.components().1, 2);
    assert_eq!(s.net.cycles(), [0, 1]);
}

#[test]
fn the_same_for_any_number_of_threads() {
    let run = |threads| {
        let context = Context::new().with_threads(threads).unwrap();
        extract(&torus(40, 16), &SkeletonOptions::default(), &context).unwrap().net
    };
    assert_eq!(run(1), run(2));
}

#[test]
fn what_is_no_surface_is_refused() {
    let code = |mesh: &SurfaceMesh| {
        extract(mesh, &SkeletonOptions::default(), &Context::new()).map_err(|e| e.exit_code()).err()
    };
    assert_eq!(code(&SurfaceMesh::from_triangles(Vec::new(), &[]).unwrap()), Some(3));
    let pinched =
        triangles(&[DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z, -DVec3::Z], &[[0, 1, 2], [1, 0, 3], [0, 1, 4]]);
    assert_eq!(code(&pinched), Some(3));
    let options = SkeletonOptions { detail: 0.0, ..SkeletonOptions::default() };
    assert_eq!(extract(&torus(8, 6), &options, &Context::new()).map_err(|e| e.exit_code()).err(), Some(2));
}

/// A pipe with an inner and an outer side and rings between them at its ends.
fn pipe(rounds: u32, around: u32, length: f64, inner: f64) -> SurfaceMesh {
    let outer = tube(rounds, around, length);
    let inside = turned(&moved(&outer, |p| DVec3::new(inner * p.x, inner * p.y, p.z)), |_| true);
    let both = together(&[outer.clone(), inside]);
    let (base, last) = (outer.vertex_count() as u32, rounds * around);
    let mut faces = both.faces().fan().0;
    for j in 0..around {
        let next = (j + 1) % around;
        let ([a, b], [c, d]) = ([j, next], [base + j, base + next]);
        faces.extend([[b, a, c], [b, c, d]]);
        let [a, b, c, d] = [a, b, c, d].map(|v| v + last);
        faces.extend([[a, b, d], [a, d, c]]);
    }
    triangles(both.points(), &faces)
}

/// The reason is told, in whatever unit, and what is advised helps.
#[test]
fn pipes_with_a_wall_are_refused_and_their_outer_sides_are_taken() {
    for (scale, inner) in [(1.0, 0.8), (1e3, 0.9), (1e-3, 0.6)] {
        let pipe = moved(&pipe(40, 24, 8.0, inner), |p| scale * p);
        assert!(Topology::of(&pipe).closed && Topology::of(&pipe).genus == Some(1));
        let error = extract(&pipe, &SkeletonOptions::default(), &Context::new()).unwrap_err();
        assert_eq!(error.exit_code(), 3);
        let share = 100.0 * (1.0 - inner) / pipe.diagonal() * scale;
        let said = error.to_string();
        assert!(said.contains("a wall around a hollow") && said.contains("outer side"), "{said}");
        let told: f64 = said.split(", ").find_map(|part| part.split(" %").next()?.parse().ok()).unwrap();
        assert!((told - share).abs() < 0.2 * share, "{told} instead of {share}");
    }
    let outer = skeleton(&tube(40, 24, 8.0));
    assert_eq!((outer.figures.cycles, outer.closed.lids.len()), (0, 2));
}

/// A flat patch closed by its lid encloses nothing: no node could have a radius.
#[test]
fn a_flat_sheet_has_no_inside() {
    let points = [(0.0, 0.0), (4.0, 0.0), (4.0, 1.0), (0.0, 1.0)].map(|(x, y)| DVec3::new(x, y, 3.0)).to_vec();
    let sheet = SurfaceMesh::from_triangles(points, &[[0, 1, 2], [0, 2, 3]]).unwrap();
    let error = extract(&sheet, &SkeletonOptions::default(), &Context::new()).unwrap_err();
    assert!(matches!(error, Error::Input { .. }), "{error}");
}
