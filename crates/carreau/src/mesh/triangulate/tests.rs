//! Polygons of every shape.

use super::*;
use proptest::prelude::*;
use std::f64::consts::TAU;

fn cut(points: &[DVec3], faces: &[&[u32]]) -> Cut {
    triangulate(points, &faces.iter().copied().collect())
}

fn flat(points: &[(f64, f64)]) -> Vec<DVec3> {
    points.iter().map(|&(x, y)| DVec3::new(x, y, 0.0)).collect()
}

#[test]
fn convex_polygons_are_fanned_from_their_first_corner_whatever_their_shape() {
    let rhombus = flat(&[(-2.0, 0.0), (0.0, -1.0), (2.0, 0.0), (0.0, 1.0)]);
    assert_eq!(cut(&rhombus, &[&[0, 1, 2, 3]]).triangles, [[0, 1, 2], [0, 2, 3]]);
    let hexagon: Vec<(f64, f64)> =
        (0..6).map(|k| (TAU * f64::from(k) / 6.0).sin_cos()).map(|(y, x)| (9.0 * x, y)).collect();
    assert_eq!(cut(&flat(&hexagon), &[&[4, 5, 0, 1, 2, 3]]).triangles, [[4, 5, 0], [4, 0, 1], [4, 1, 2], [4, 2, 3]]);
}

#[test]
fn a_dart_is_cut_at_its_reflex_corner_wherever_that_is_and_fanned_from_its_first_where_numbers_count() {
    let dart = flat(&[(0.0, 0.0), (2.0, -1.0), (0.5, 0.0), (2.0, 1.0)]);
    for turn in 0..4 {
        let face: Vec<u32> = (0..4).map(|k| (k + turn) % 4).collect();
        let found = cut(&dart, &[&face]);
        assert!(found.triangles.iter().all(|t| t.contains(&0) && t.contains(&2)));
        let Cut { triangles, corners, parent, .. } = fans(&dart, &[face.as_slice()].into_iter().collect());
        assert_eq!(triangles, [[face[0], face[1], face[2]], [face[0], face[2], face[3]]]);
        assert_eq!((corners, parent), (vec![0, 1, 2, 0, 2, 3], vec![0, 0]));
    }
}

#[test]
fn nearly_fans_are_fans_but_for_flat_triangles() {
    let points = flat(&[(0.0, 0.0), (2.0, -1.0), (0.5, 0.0), (2.0, 1.0), (3.0, 0.0)]);
    let found = |face: &[u32]| nearly_fans(&points, &[face].into_iter().collect()).triangles;
    assert_eq!(found(&[1, 2, 3, 0]), [[1, 2, 3], [1, 3, 0]], "turned, but a fan");
    assert!(found(&[0, 2, 4, 3]).iter().all(|t| t.contains(&3)), "its first triangle is flat");
    let twice: Polygons = [&[0, 1, 2, 3][..], &[0, 2, 1]].into_iter().collect();
    assert_eq!(nearly_fans(&points, &twice).middles, [[0, 2]], "its diagonal is an edge, its ears are turned");
}

/// The diagonals of a pentagon are edges already, one, the other or both.
#[test]
fn diagonals_of_nearly_fans_that_are_edges_already_are_divided() {
    let points: Vec<DVec3> =
        (0..6).map(|k| DVec3::new((TAU * f64::from(k) / 5.0).cos(), (TAU * f64::from(k) / 5.0).sin(), 0.0)).collect();
    for others in [&[&[0, 5, 2][..]][..], &[&[0, 5, 3]], &[&[0, 5, 2], &[3, 5, 0]]] {
        let faces: Polygons = others.iter().copied().chain([&[0, 1, 2, 3, 4][..]]).collect();
        assert!(nearly_fans(&points, &faces).middles.is_empty(), "it is plane");
        let mut points = points.clone();
        points[1].z = 1.5;
        let found = nearly_fans(&points, &faces);
        assert_eq!(found.middles.len(), others.len());
        let middles: Vec<DVec3> =
            found.middles.iter().map(|m| 0.5 * (points[m[0] as usize] + points[m[1] as usize])).collect();
        points.extend(middles);
        let edges = HalfEdges::new(&Polygons::from_triangles(&found.triangles), points.len());
        assert!(edges.groups().all(|e| e.len() <= 2), "{:?}", found.triangles);
        let of_pentagon = found.triangles.iter().zip(&found.parent).filter(|t| *t.1 == others.len() as u32);
        let areas: Vec<f64> = of_pentagon
            .map(|(t, _)| triangle_area_vector(points[t[0] as usize], points[t[1] as usize], points[t[2] as usize]).z)
            .collect();
        assert!(areas.len() == 3 + 2 * others.len() && areas.iter().all(|a| *a > 0.0), "{areas:?}");
        assert!((areas.iter().sum::<f64>() - 2.5 * (TAU / 5.0).sin()).abs() < 1e-12);
    }
}

/// Two quads that share three vertices: the middle one has no other face, and both shorter diagonals are the same.
#[test]
fn quads_that_share_three_vertices_do_not_share_a_diagonal() {
    let points = flat(&[(0.0, 0.0), (3.0, -1.0), (3.0, 1.0), (1.0, 0.0), (6.0, 0.0)]);
    let (left, right) = ([0, 1, 3, 2], [1, 4, 2, 3]);
    let found = cut(&points, &[&left, &right]);
    let faces = Polygons::from_triangles(&found.triangles);
    assert!(HalfEdges::new(&faces, points.len()).groups().all(|e| e.len() <= 2), "{:?}", found.triangles);
}

/// Two sides cross: on either side of either diagonal one triangle is turned.
#[test]
fn a_quad_that_is_folded_either_way_lies_on_itself_as_little_as_possible() {
    let points = flat(&[(0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 0.8)]);
    let area = |t: &[u32; 3]| triangle_area_vector(points[t[0] as usize], points[t[1] as usize], points[t[2] as usize]);
    for turn in 0..4 {
        let face: Vec<u32> = (0..4).map(|k| (k + turn) % 4).collect();
        let sum: f64 = cut(&points, &[&face]).triangles.iter().map(|t| area(t).length()).sum();
        assert!((sum - 0.9).abs() < 1e-12, "{sum}");
    }
}

/// From the other two corners the fan is the larger cut, and ears go by shape.
#[test]
fn a_quad_that_is_folded_either_way_is_a_fan_where_that_lies_on_itself_far_less() {
    let points = flat(&[(0.0, 0.0), (3.0, 1.0), (1.0, 0.0), (0.0, 1.0)]);
    let area = |t: &[u32; 3]| triangle_area_vector(points[t[0] as usize], points[t[1] as usize], points[t[2] as usize]);
    for turn in [0, 2] {
        let face: Vec<u32> = (0..4).map(|k| (k + turn) % 4).collect();
        let sum: f64 = cut(&points, &[&face]).triangles.iter().map(|t| area(t).length()).sum();
        assert!((sum - 1.0).abs() < 1e-12, "the other cut has three times that: {sum}");
    }
}

#[test]
fn corners_and_parents_are_those_of_the_polygons() {
    let points: Vec<DVec3> = (0..9).map(|k| DVec3::new(f64::from(k).cos(), f64::from(k).sin(), 0.0)).collect();
    let faces: Polygons = [&[0, 1, 2][..], &[3, 4, 5, 6, 7], &[8, 0, 2, 4]].into_iter().collect();
    let found = triangulate(&points, &faces);
    assert_eq!(found.parent, [0, 1, 1, 1, 2, 2]);
    for (k, &c) in found.corners.iter().enumerate() {
        assert_eq!(found.triangles.as_flattened()[k], faces.corners()[c as usize]);
        let f = found.parent[k / 3] as usize;
        assert!((faces.offsets()[f]..faces.offsets()[f + 1]).contains(&c));
    }
}

#[test]
fn large_and_degenerate_polygons_end() {
    let n = MOST_CORNERS as u32 + 5;
    let points: Vec<DVec3> = (0..n).map(|k| DVec3::new(f64::from(k), f64::from(k % 2), 0.0)).collect();
    let large: Vec<u32> = (0..n).collect();
    assert_eq!(cut(&points, &[&large]).triangles.len(), n as usize - 2);
    assert_eq!(cut(&points, &[&[0, 0, 0, 0, 0], &[1, 2, 1, 2]]).triangles.len(), 5);
    let folded: Vec<DVec3> = [0.0, 2.0, 1.0, 3.0, 1.5].map(|x| DVec3::new(x, 0.0, 0.0)).to_vec();
    assert_eq!(cut(&folded, &[&[0, 1, 2, 3, 4]]).triangles.len(), 3);
}

proptest! {
    /// Star-shaped polygons, reflex corners and all: no triangle is turned, and the areas add up.
    #[test]
    fn no_triangle_is_turned(radii in prop::collection::vec(0.2f64..1.0, 4..24)) {
        let n = radii.len();
        let at = |k: usize| { let s = TAU * k as f64 / n as f64; DVec3::new(radii[k] * s.cos(), radii[k] * s.sin(), 3.0) };
        let points: Vec<DVec3> = (0..n).map(at).collect();
        let face: Vec<u32> = (0..n as u32).collect();
        let area = |t: &[u32]| area_vector(&points, t).z;
        let triangles = cut(&points, &[&face]).triangles;
        prop_assert_eq!(triangles.len(), n - 2);
        prop_assert!(triangles.iter().all(|t| area(t) > -1e-12));
        let sum: f64 = triangles.iter().map(|t| area(t).abs()).sum();
        prop_assert!((sum - area(&face)).abs() < 1e-9);
    }
}
