//! Triangles as kernels make them: exact, few, and on faces of every kind.

use crate::context::Context;
use crate::geometry::primitive::{Kind, Primitive};
use crate::mesh::SurfaceMesh;
use crate::segment::{SegmentOptions, Segmentation, segment};
use glam::DVec3;
use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, TAU};

fn found(mesh: &SurfaceMesh) -> Segmentation {
    segment(mesh, &SegmentOptions::default(), &Context::new()).unwrap()
}

/// Number of regions of every kind; freeform ones have none.
fn kinds(mesh: &SurfaceMesh) -> BTreeMap<Option<Kind>, usize> {
    let mut count = BTreeMap::new();
    for region in found(mesh).regions {
        *count.entry(region.primitive.map(|p| p.kind())).or_default() += 1;
    }
    count
}

/// A lid without a vertex inside, as kernels make them, over the vertices `first..first + n`.
fn lid(first: u32, n: u32, up: bool, faces: &mut Vec<[u32; 3]>) {
    faces.extend((1..n - 1).map(|k| match up {
        true => [first, first + k, first + k + 1],
        false => [first, first + k + 1, first + k],
    }));
}

/// Two rings of vertices `a..a + n`, `b..b + n` joined by strips.
fn strips(a: u32, b: u32, n: u32, faces: &mut Vec<[u32; 3]>) {
    for k in 0..n {
        let next = (k + 1) % n;
        faces.extend([[a + k, a + next, b + next], [a + k, b + next, b + k]]);
    }
}

/// A turned solid with plane ends, of a profile of radii and heights and `n` strips around.
fn turned(profile: &[[f64; 2]], n: u32) -> SurfaceMesh {
    let around = |r: f64, z: f64, k: u32| {
        let angle = TAU * f64::from(k) / f64::from(n);
        DVec3::new(r * angle.cos(), r * angle.sin(), z)
    };
    let points = profile.iter().flat_map(|&[r, z]| (0..n).map(move |k| around(r, z, k))).collect();
    let mut faces = Vec::new();
    let last = n * (profile.len() as u32 - 1);
    (0..last).step_by(n as usize).for_each(|a| strips(a, a + n, n, &mut faces));
    lid(0, n, false, &mut faces);
    lid(last, n, true, &mut faces);
    SurfaceMesh::from_triangles(points, &faces).unwrap()
}

/// A prism over a polygon.
fn prism(polygon: &[[f64; 2]], height: f64) -> SurfaceMesh {
    let n = polygon.len() as u32;
    let points = [0.0, height].into_iter().flat_map(|z| polygon.iter().map(move |p| DVec3::new(p[0], p[1], z)));
    let mut faces = Vec::new();
    strips(0, n, n, &mut faces);
    lid(0, n, false, &mut faces);
    lid(n, n, true, &mut faces);
    SurfaceMesh::from_triangles(points.collect(), &faces).unwrap()
}

/// A profile of radii over heights.
fn profile(radius: impl Fn(f64) -> f64, heights: [f64; 2], steps: u32) -> Vec<[f64; 2]> {
    let height = |k: u32| heights[0] + (heights[1] - heights[0]) * f64::from(k) / f64::from(steps);
    (0..=steps).map(height).map(|z| [radius(z), z]).collect()
}

/// A profile that is an arc nowhere.
fn wave(z: f64) -> f64 {
    1.0 + 0.35 * (1.3 * z + 0.4).sin()
}

#[test]
fn the_lid_on_a_rounded_rim_is_a_plane_of_its_own() {
    // The lid touches the torus along its top circle: all its corners lie on it, and its normals are those of the torus.
    for [n, steps] in [[24, 4], [40, 5], [64, 8]] {
        let arc = (0..=steps).map(|k| (FRAC_PI_2 * f64::from(k) / f64::from(steps)).sin_cos());
        let rim = std::iter::once([2.5, -1.0]).chain(arc.map(|(sin, cos)| [2.0 + 0.5 * cos, 0.5 + 0.5 * sin]));
        let mesh = turned(&rim.collect::<Vec<_>>(), n);
        let wanted = [(Some(Kind::Plane), 2), (Some(Kind::Cylinder), 1), (Some(Kind::Torus), 1)];
        assert_eq!(kinds(&mesh), BTreeMap::from(wanted), "{n} strips");
    }
}

#[test]
fn faces_between_two_rings_are_what_their_strips_say() {
    // Two rings are on a sphere, too; and strips that are wider than long bend towards the chamfer as they do around.
    for (height, chamfer) in [(0.3, 0.2), (0.6, 0.2), (0.9, 0.4), (4.0, 0.1)] {
        for n in [30, 40, 64] {
            let mesh = turned(&[[3.0, 0.0], [3.0, height], [3.0 - chamfer, height + chamfer]], n);
            let result = found(&mesh);
            let wanted = [(Some(Kind::Plane), 2), (Some(Kind::Cylinder), 1), (Some(Kind::Cone), 1)];
            assert_eq!(kinds(&mesh), BTreeMap::from(wanted), "{height} {chamfer} {n}");
            for primitive in result.regions.iter().filter_map(|region| region.primitive) {
                match primitive {
                    Primitive::Cylinder { radius, .. } => assert!((radius - 3.0).abs() < 1e-9),
                    Primitive::Cone { half_angle, .. } => assert!((half_angle.to_degrees() - 45.0).abs() < 1e-6),
                    _ => {}
                }
            }
        }
    }
}

#[test]
fn a_turned_face_of_no_simple_kind_is_one_region() {
    // Coarse ones are within a share of an edge of spheres and cones, of fine ones three rings are on a torus.
    for [n, steps] in [[20, 8], [30, 16], [40, 40]] {
        let mesh = turned(&profile(wave, [0.0, 4.0], steps), n);
        assert_eq!(kinds(&mesh), BTreeMap::from([(Some(Kind::Plane), 2), (None, 1)]), "{n} strips");
    }
}

#[test]
fn beside_an_exact_cylinder_what_is_open_is_freeform() {
    // A foot on a flange: triangles as good as those of a remesher, and a torus nearly everywhere.
    for n in [24, 32] {
        let foot = profile(|z| 2.0 + 0.12 * z.powi(3), [0.0, 2.0], 8);
        let mesh = turned(&[vec![[3.0, -3.0], [3.0, 0.0]], foot].concat(), n);
        let result = found(&mesh);
        assert_eq!(result.chosen.noise, 0.0);
        let cylinders = result.regions.iter().filter(|r| r.primitive.is_some_and(|p| p.kind() == Kind::Cylinder));
        assert_eq!(cylinders.map(|r| r.triangles).collect::<Vec<_>>(), [2 * n], "{n} strips");
        assert_eq!(result.regions.len(), 5, "{n} strips");
    }
}

#[test]
fn planes_that_meet_at_small_bends_are_planes() {
    // Three sides in a row, 25° from each to the next, and no circle through their four edges.
    for share in [0.2, 0.35, 0.6] {
        let mut corner = DVec3::new(6.0, 3.0, 0.0);
        let mut polygon = vec![[0.0, 0.0], [6.0, 0.0], [6.0, 3.0]];
        for (angle, length) in [(115f64, 2.0), (140.0, 2.0 * share)] {
            corner += length * DVec3::new(angle.to_radians().cos(), angle.to_radians().sin(), 0.0);
            polygon.push([corner.x, corner.y]);
        }
        polygon.push([0.0, corner.y]);
        let mesh = prism(&polygon, 1.0);
        assert_eq!(kinds(&mesh), BTreeMap::from([(Some(Kind::Plane), polygon.len() + 2)]), "{share}");
    }
}

#[test]
fn flats_of_a_shaft_are_planes() {
    // Two sides of the polygon are chords of its circle, wide ones.
    for gap in [72, 90, 150] {
        let on_arc = |degrees: i32| {
            let (sin, cos) = f64::from(degrees).to_radians().sin_cos();
            [4.0 * cos, 4.0 * sin]
        };
        let arcs = [gap / 2, 180 + gap / 2].map(|from| (from..=from + 180 - gap).step_by(6).map(on_arc));
        let mesh = prism(&arcs.into_iter().flatten().collect::<Vec<_>>(), 5.0);
        let wanted = [(Some(Kind::Plane), 4), (Some(Kind::Cylinder), 2)];
        assert_eq!(kinds(&mesh), BTreeMap::from(wanted), "{gap}");
    }
}

#[test]
fn a_coarse_freeform_surface_has_no_planes_of_single_triangles() {
    // Long ones beside small ones, at bends that are sharp elsewhere.
    let ball = crate::sample::make("icosphere", Some(8), &Context::new()).unwrap();
    for [x, y, z] in [[1.0, 1.3, 2.2], [1.0, 2.0, 3.0]] {
        let points = ball.points().iter().map(|&p| p * DVec3::new(x, y, z)).collect();
        let mesh = SurfaceMesh::new(points, ball.faces().clone()).unwrap();
        assert_eq!(kinds(&mesh), BTreeMap::from([(None, 1)]), "{x} {y} {z}");
    }
}
