//! Curves through chains whose shape is known.

use super::*;
use proptest::prelude::*;

fn control_points(c: &ChainCurve) -> usize {
    match &c.shape {
        Shape::Polyline(stops) => stops.len(),
        Shape::Spline(s) => s.points().len(),
    }
}

fn check(points: &[DVec3], tolerance: f64) -> ChainCurve {
    let fit = ChainCurve::fit(points, &[], tolerance).unwrap();
    assert_eq!(fit.parameters.len(), points.len());
    let mut largest = 0.0f64;
    for (p, &t) in points.iter().zip(&fit.parameters) {
        largest = largest.max(match &fit.shape {
            Shape::Spline(c) => c.point(t).distance(*p),
            Shape::Polyline(stops) => {
                let corner = |k: u32| (points[k as usize], fit.parameters[k as usize]);
                let k = stops.partition_point(|&k| corner(k).1 < t).clamp(1, stops.len() - 1);
                let ((a, ta), (b, tb)) = (corner(stops[k - 1]), corner(stops[k]));
                a.lerp(b, (t - ta) / (tb - ta)).distance(*p)
            }
        });
    }
    assert!(largest <= tolerance + 1e-12, "{largest} > {tolerance}");
    assert!((largest - fit.deviation).abs() <= 1e-9, "{largest} {}", fit.deviation);
    if let Shape::Spline(c) = &fit.shape {
        assert_eq!(c.ends(), [points[0], points[points.len() - 1]]);
        assert_eq!(c.knots().domain(), [0.0, 1.0]);
    }
    fit
}

fn arc(n: usize, angle: f64) -> Vec<DVec3> {
    (0..=n).map(|k| angle * k as f64 / n as f64).map(|a| DVec3::new(a.cos(), a.sin(), 0.3 * a)).collect()
}

#[test]
fn a_smooth_arc_takes_few_points_and_fewer_the_looser_the_tolerance() {
    let points = arc(64, 3.0);
    let sizes: Vec<usize> = [1e-5, 1e-4, 1e-3, 1e-2].map(|e| control_points(&check(&points, e))).to_vec();
    assert!(sizes.windows(2).all(|w| w[0] >= w[1]), "{sizes:?}");
    assert!(sizes[2] <= 8, "{sizes:?}");
}

#[test]
fn straight_chains_and_corners_become_polylines() {
    let line: Vec<DVec3> = (0..9).map(|k| DVec3::new(f64::from(k).powi(2), 0.0, 1.0)).collect();
    assert!(matches!(check(&line, 1e-9).shape, Shape::Polyline(s) if s == [0, 8]));
    let mut bent = line.clone();
    bent.extend((1..6).map(|k| DVec3::new(64.0, f64::from(k), 1.0)));
    assert!(matches!(check(&bent, 1e-9).shape, Shape::Polyline(s) if s == [0, 8, 13]));
    let half = 0.5f64.sqrt();
    let rounded: Vec<DVec3> = arc(16, 1.0)
        .into_iter()
        .chain((1..9).map(|k| DVec3::new(1f64.cos(), 1f64.sin() - half * f64::from(k), 0.3)))
        .collect();
    assert!(control_points(&check(&rounded, 1e-3)) < 12);
}

/// The parts of one curve meet at the vertices and go on in the same direction.
#[test]
fn parts_are_smooth_where_they_meet() {
    let points = arc(64, 3.0);
    for tolerance in [1e-5, 1e-3] {
        let whole = ChainCurve::fit(&points, &[11, 40], tolerance).unwrap();
        let part = |i: usize, j: usize| whole.part([i, j], [points[i], points[j]]).unwrap();
        let parts = [part(0, 11), part(11, 40), part(40, 64)];
        let curves: Vec<&BSplineCurve> = parts
            .iter()
            .map(|p| match &p.shape {
                Shape::Spline(c) => c,
                Shape::Polyline(_) => panic!("an arc became a polyline"),
            })
            .collect();
        for (w, k) in curves.windows(2).zip([11, 40]) {
            assert!(w[0].ends()[1] == points[k] && w[1].ends()[0] == points[k]);
            let [end, begin] = [w[0].derivatives(1.0)[1], w[1].derivatives(0.0)[1]];
            assert!(end.angle_between(begin) < 1e-6, "{}", end.angle_between(begin));
        }
        for (part, (from, to)) in parts.iter().zip([(0, 11), (11, 40), (40, 64)]) {
            let Shape::Spline(c) = &part.shape else { continue };
            for (p, t) in points[from..=to].iter().zip(&part.parameters) {
                assert!(c.point(*t).distance(*p) <= tolerance + 1e-12);
            }
        }
    }
}

#[test]
fn zero_tolerance_gives_the_polyline() {
    let points = arc(10, 2.0);
    let fit = check(&points, 0.0);
    assert!(matches!(fit.shape, Shape::Polyline(s) if s.len() == points.len()));
}

proptest! {
    #[test]
    fn any_chain_is_met_within_the_tolerance(
        steps in prop::collection::vec((-1.0f64..1.0, -1.0f64..1.0, -1.0f64..1.0), 1..40),
        tolerance in 0.0f64..0.5,
    ) {
        let mut points = vec![DVec3::ZERO];
        for (x, y, z) in steps {
            points.push(points[points.len() - 1] + DVec3::new(x, y, z));
        }
        prop_assume!(points.windows(2).all(|w| w[0] != w[1]));
        check(&points, tolerance);
    }

    #[test]
    fn coinciding_vertices_do_no_harm(keep in prop::collection::vec(any::<bool>(), 1..20)) {
        let mut points = vec![DVec3::ZERO];
        for (k, keep) in keep.into_iter().enumerate() {
            let last = points[points.len() - 1];
            points.push(if keep { last } else { DVec3::new(k as f64, (k as f64).sin(), 0.0) });
        }
        check(&points, 0.01);
    }
}
