//! Boundaries of single cells and of balls.

use super::*;
use crate::mesh::test_models::{bricks, sphere};
use crate::skeleton;

/// Of two vertices side by side on the top of a block, one would turn its cells over: the other goes alone.
#[test]
fn a_vertex_goes_where_its_neighbour_cannot() {
    let at = |i: u32, j: u32, k: u32| (k * 2 + j) * 4 + i;
    let (points, hexes) = bricks([3, 1, 1]);
    let (goes_alone, cannot) = (at(1, 0, 1), at(2, 0, 1));
    let up = |v: u32, by: f64| (v, points[v as usize] + DVec3::Z * by, DVec3::Z);
    let places = [up(goes_alone, 0.1), up(cannot, -1.5)];
    let (mut moved, mut goes) = (points.clone(), vec![false; points.len()]);
    put_singly(&Optimiser::new(&points, &hexes), &mut moved, &places, &[0.4; 3], &mut goes, |_, _| None);
    assert!(goes[goes_alone as usize] && !goes[cannot as usize]);
    assert_eq!(moved[goes_alone as usize], places[0].1);
    assert!((0..16).filter(|&v| v != goes_alone).all(|v| moved[v as usize] == points[v as usize]));
}

/// A block of 2 × 2 × 2 cells in a ball: the middle of its top belongs above the middle of the four vertices around it.
#[test]
fn a_vertex_may_go_where_its_neighbours_say() {
    let at = |i: u32, j: u32, k: u32| (k * 3 + j) * 3 + i;
    let (mut points, hexes) = bricks([2; 3]);
    points.iter_mut().for_each(|p| *p = 0.3 * (*p - DVec3::ONE));
    let top = at(1, 1, 2);
    points[top as usize] = DVec3::new(0.2, 0.1, 0.4);
    let (closed, _) = skeleton::prepared(&sphere(4), &Context::new()).unwrap();
    let (skin, target) = (Skin::new(&hexes, &[0; 27], &[]), Target::new(&closed));
    let middles = Middles::new(&skin, &target);
    let to = middles.place(top, &points).unwrap();
    assert!(to.distance(DVec3::Z) < 0.05, "{to}");
    assert_eq!(middles.place(at(1, 1, 1), &points), None);
    // Its own place would fold the cells; that of the others is taken.
    let (mut moved, mut goes) = (points.clone(), vec![true; 27]);
    goes[top as usize] = false;
    let places = [(top, DVec3::new(0.0, 0.0, -0.5), DVec3::Z)];
    put_singly(&Optimiser::new(&points, &hexes), &mut moved, &places, &[0.1; 8], &mut goes, |_, _| {
        Some(DVec3::new(0.0, 0.0, 0.5))
    });
    assert!(goes[top as usize]);
    assert_eq!(moved[top as usize], DVec3::new(0.0, 0.0, 0.5));
}

/// A block in a ball, all of its boundary on that: its volume grows, by as much as vertices may leave the surface; what is
/// free stays.
#[test]
fn a_boundary_on_a_ball_takes_its_volume() {
    let (mut points, hexes) = bricks([8; 3]);
    for p in &mut points {
        let q = 0.25 * *p - DVec3::ONE;
        *p = q.abs().max_element() * q.normalize_or_zero();
    }
    let (closed, _) = skeleton::prepared(&sphere(4), &Context::new()).unwrap();
    let (skin, target) = (Skin::new(&hexes, &vec![0; points.len()], &[]), Target::new(&closed));
    let on_wall: Vec<usize> = (0..points.len()).filter(|&v| skin.has(v)).collect();
    on_wall.iter().for_each(|&v| points[v] = target.closest_wall(points[v]).unwrap().0);
    let free: Vec<bool> = (0..points.len()).map(|v| !skin.has(v)).collect();
    let start = points.clone();
    swell(&mut points, &hexes, &skin, &target, &free);
    let outward = |v: &usize| points[*v].length() - start[*v].length();
    let reach = SWELL * target.surface().diagonal();
    assert!(on_wall.iter().all(|v| (0.0..=1.01 * reach).contains(&outward(v))));
    assert!(on_wall.iter().filter(|v| outward(v) > 0.9 * reach).count() > on_wall.len() / 2);
    assert!((0..points.len()).filter(|&v| free[v]).all(|v| points[v] == start[v]));
    let mut stays = start.clone();
    swell(&mut stays, &hexes, &skin, &target, &vec![true; free.len()]);
    assert_eq!(stays, start);
}

/// Ahead of a vertex in a ball the surface is nearer than where it is closest; but where a vertex cannot go there it goes to
/// the closest place.
#[test]
fn a_vertex_may_go_to_the_closest_place() {
    let (mut points, hexes) = bricks([2; 3]);
    points.iter_mut().for_each(|p| *p = 0.3 * (*p - DVec3::ONE));
    let (closed, _) = skeleton::prepared(&sphere(4), &Context::new()).unwrap();
    let (skin, target) = (Skin::new(&hexes, &[0; 27], &[]), Target::new(&closed));
    let top = (2 * 3 + 1) * 3 + 1;
    let placed = (0..27).map(|v| skin.has(v)).collect();
    let mut sliding = Sliding::new(&points, &skin, &target, placed, &[top]);
    let (top, at) = (top as usize, DVec3::new(0.6, 0.0, 0.2));
    let ahead = sliding.place(top, at).0;
    sliding.at_closest[top] = true;
    let closest = sliding.place(top, at).0;
    assert!(ahead.distance(DVec3::new(0.6, 0.0, 0.8)) < 0.05, "{ahead}");
    assert!(closest.distance(at.normalize()) < 0.05, "{closest}");
}
