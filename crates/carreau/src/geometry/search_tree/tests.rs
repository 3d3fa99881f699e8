//! The tree against a search through all triangles.

use super::*;
use crate::mesh::SurfaceMesh;
use crate::mesh::test_models::*;
use proptest::prelude::*;

fn fans(mesh: &SurfaceMesh) -> Vec<[u32; 3]> {
    mesh.faces().fan().0
}

fn tree_of(mesh: &SurfaceMesh) -> TriangleTree {
    TriangleTree::new(mesh.points(), &fans(mesh))
}

/// The distance triangle by triangle: inside by the normal equations, on the edges by halving, as the distance is convex.
fn oracle(points: &[DVec3], triangles: &[[u32; 3]], p: DVec3) -> f64 {
    let inside = |a: DVec3, u: DVec3, v: DVec3| {
        let (uu, uv, vv) = (u.dot(u), u.dot(v), v.dot(v));
        let (pu, pv, det) = ((p - a).dot(u), (p - a).dot(v), uu * vv - uv * uv);
        let (s, t) = ((pu * vv - pv * uv) / det, (pv * uu - pu * uv) / det);
        (s >= 0.0 && t >= 0.0 && s + t <= 1.0).then(|| p.distance(a + s * u + t * v))
    };
    let along = |a: DVec3, b: DVec3| {
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            let is_left = (a.lerp(b, middle) - p).dot(b - a) > 0.0;
            (low, high) = if is_left { (low, middle) } else { (middle, high) };
        }
        p.distance(a.lerp(b, 0.5 * (low + high)))
    };
    let distance = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|k| points[k as usize]);
        let edges = [along(a, b), along(b, c), along(c, a)];
        edges.into_iter().chain(inside(a, b - a, c - a)).fold(f64::INFINITY, f64::min)
    };
    triangles.iter().map(distance).fold(f64::INFINITY, f64::min)
}

fn point() -> impl Strategy<Value = DVec3> {
    prop::array::uniform3(-1.0f64..1.0).prop_map(DVec3::from_array)
}

fn soup() -> impl Strategy<Value = (Vec<DVec3>, Vec<[u32; 3]>)> {
    (prop::collection::vec(point(), 4..40), 1usize..200).prop_flat_map(|(points, n)| {
        let index = 0..points.len() as u32;
        (Just(points), prop::collection::vec(prop::array::uniform3(index), n))
    })
}

/// A soup, or a fan of needles, which the tree cuts.
fn soup_or_fan() -> impl Strategy<Value = (Vec<DVec3>, Vec<[u32; 3]>)> {
    let fan = (50u32..300, point()).prop_map(|(n, apex)| {
        let rim = (0..n).map(|k| {
            let angle = f64::from(k) / f64::from(n);
            DVec3::new(angle.cos(), angle.sin(), 0.5 * angle)
        });
        let points = std::iter::once(apex).chain(rim).collect();
        (points, (1..n).map(|k| [0, k, k % n + 1]).collect())
    });
    prop_oneof![soup(), fan]
}

proptest! {
    #[test]
    fn closest_agrees_with_the_oracle((points, triangles) in soup_or_fan(), queries in prop::collection::vec(point(), 20)) {
        let tree = TriangleTree::new(&points, &triangles);
        for p in queries.into_iter().map(|p| p * 2.0) {
            let found = tree.closest(p).unwrap();
            prop_assert!((found.distance() - oracle(&points, &triangles, p)).abs() < 1e-9);
            let own = triangles[found.triangle as usize].map(|k| points[k as usize]);
            prop_assert_eq!(found.point, closest_on_triangle(p, own));
            for hint in &triangles {
                let near = tree.closest_near(p, hint.map(|k| points[k as usize])).unwrap();
                prop_assert!((near.distance() - found.distance()).abs() < 1e-9);
            }
            // Of triangles that share the closest point, either may be found, with the rounding of its own plane.
            let within = tree.closest_within(p, found.distance() * (1.0 + 1e-12)).unwrap();
            prop_assert!(within.point.distance(found.point) <= 1e-12 && within.distance() <= found.distance() * (1.0 + 1e-12));
            prop_assert_eq!(tree.closest_within(p, found.distance() * 0.999 - 1e-12), None);
        }
    }

    /// Whatever the normals are said to be.
    #[test]
    fn slabs_change_no_answer(
        (points, triangles) in soup_or_fan(),
        queries in prop::collection::vec(point(), 20),
        normals in prop::collection::vec(point(), 300),
    ) {
        let tree = TriangleTree::new(&points, &triangles);
        let with_slabs = TriangleTree::new(&points, &triangles).with_slabs(&normals);
        for p in queries {
            let (plain, found) = (tree.closest(p).unwrap(), with_slabs.closest(p).unwrap());
            prop_assert!((plain.distance() - found.distance()).abs() < 1e-12);
        }
    }

    #[test]
    fn the_cheapest_is_the_cheapest_of_those_within(
        (points, triangles) in soup_or_fan(),
        p in point(),
        radius in 0.0f64..2.0,
    ) {
        let tree = TriangleTree::new(&points, &triangles);
        let cost = |c: &Closest| (!c.triangle.is_multiple_of(3)).then(|| c.distance() * f64::from(1 + c.triangle % 7));
        let mut expected: Option<(f64, u32)> = None;
        tree.within(p, radius, |c| {
            if let Some(cost) = cost(&c)
                && expected.is_none_or(|e| (cost, c.triangle) < e)
            {
                expected = Some((cost, c.triangle));
            }
        });
        prop_assert_eq!(tree.cheapest(p, radius, cost).map(|(cost, c)| (cost, c.triangle)), expected);
    }

    #[test]
    fn within_finds_exactly_the_near_triangles((points, triangles) in soup_or_fan(), p in point(), radius in 0.0f64..0.5) {
        let tree = TriangleTree::new(&points, &triangles);
        let mut found = Vec::new();
        tree.within(p, radius, |c| found.push(c.triangle));
        found.sort_unstable();
        let near = |t: &[u32; 3]| p.distance(closest_on_triangle(p, t.map(|k| points[k as usize]))) <= radius;
        let expected: Vec<u32> = (0u32..).zip(&triangles).filter(|(_, t)| near(t)).map(|(k, _)| k).collect();
        prop_assert_eq!(found, expected);
    }

    #[test]
    fn rays_enter_and_leave_a_closed_surface(origin in point(), toward in point()) {
        // Aimed at a vertex: the worst case for watertightness.
        let mesh = sphere(2);
        let tree = tree_of(&mesh);
        let vertex = mesh.points()[(toward.x.abs() * 160.0) as usize];
        let inside = origin * 0.9 / 1.8;
        let first = tree.first_hit(inside, vertex - inside).unwrap();
        prop_assert!((first.t - 1.0).abs() < 1e-9 && !first.front);
        let outside = origin.normalize_or(DVec3::X) * 3.0;
        prop_assert!(tree.first_hit(outside, toward * 0.4 - outside).unwrap().front);
        prop_assert!(tree.first_hit(outside, outside).is_none());
        // Without a direction there is nothing along it, wherever it begins.
        prop_assert!([inside, outside].into_iter().all(|p| tree.first_hit(p, DVec3::ZERO).is_none()));
    }

    #[test]
    fn rays_hit_what_lies_on_them((points, triangles) in soup_or_fan(), origin in point(), weights in prop::array::uniform3(0.05f64..1.0)) {
        let tree = TriangleTree::new(&points, &triangles);
        let [a, b, c] = triangles[0].map(|k| points[k as usize]);
        let w = weights.iter().sum::<f64>();
        let target = (a * weights[0] + b * weights[1] + c * weights[2]) / w;
        let mut hit = None;
        let mut times = vec![0; triangles.len()];
        tree.along_ray(origin, target - origin, 2.0, |h| {
            hit = hit.or((h.triangle == 0).then_some(h.t));
            times[h.triangle as usize] += 1;
        });
        prop_assert!(times.iter().all(|&n| n <= 1));
        let volume = (a - origin).dot((b - origin).cross(c - origin)).abs();
        prop_assert!(volume < 1e-6 || (hit.unwrap() - 1.0).abs() < 1e-6);
    }
}

#[test]
fn the_tree_does_not_depend_on_the_number_of_threads() {
    let mesh = torus(150, 60);
    let build = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| tree_of(&mesh)).slices
    };
    assert_eq!(build(1), build(3));
}

#[test]
fn an_empty_tree_has_no_answers() {
    let tree = TriangleTree::new(&[], &[]);
    assert!(tree.is_empty() && tree.closest(DVec3::ZERO).is_none() && tree.first_hit(DVec3::ZERO, DVec3::X).is_none());
}
