//! Whether closed polygons in the plane are simple: the border of a plane face may not cross or touch itself.

use glam::DVec2;
use robust::{Coord, orient2d};

/// Whether no two sides of closed polygons have more in common than the corner between them.
pub fn are_simple<P: AsRef<[DVec2]>>(polygons: &[P]) -> bool {
    // Ends of every side, and the sides before and behind it.
    let mut sides: Vec<([DVec2; 2], [usize; 2])> = Vec::new();
    for polygon in polygons.iter().map(AsRef::as_ref) {
        let (first, n) = (sides.len(), polygon.len());
        let side = |k: usize| ([polygon[k], polygon[(k + 1) % n]], [(k + n - 1) % n, (k + 1) % n].map(|j| first + j));
        sides.extend((0..n).map(side));
    }
    // By their left ends, so that only sides above each other meet.
    let mut order: Vec<usize> = (0..sides.len()).collect();
    let left = |k: usize| sides[k].0[0].x.min(sides[k].0[1].x);
    order.sort_unstable_by(|&a, &b| left(a).total_cmp(&left(b)).then(a.cmp(&b)));
    order.iter().enumerate().all(|(place, &k)| {
        let ([a, b], [before, behind]) = sides[k];
        let right = a.x.max(b.x);
        let later = order[place + 1..].iter().take_while(|&&l| left(l) <= right);
        later.copied().all(|l| match l {
            _ if l == behind => !folds(a, b, sides[l].0[1]),
            _ if l == before => !folds(sides[l].0[0], a, b),
            _ => !touch([a, b], sides[l].0),
        })
    })
}

/// Whether b–c runs back over a–b.
fn folds(a: DVec2, b: DVec2, c: DVec2) -> bool {
    turn(a, b, c) == 0.0 && (a - b).dot(c - b) >= 0.0
}

fn touch([a, b]: [DVec2; 2], [c, d]: [DVec2; 2]) -> bool {
    let apart = a.max(b).cmplt(c.min(d)).any() || c.max(d).cmplt(a.min(b)).any();
    !apart && turn(a, b, c) * turn(a, b, d) <= 0.0 && turn(c, d, a) * turn(c, d, b) <= 0.0
}

/// 1, 0 or −1: c is to the left of a–b, on it, to the right.
fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    let [a, b, c] = [a, b, c].map(|p| Coord { x: p.x, y: p.y });
    let x = orient2d(a, b, c);
    if x == 0.0 { 0.0 } else { x.signum() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn is_simple(polygon: &[DVec2]) -> bool {
        are_simple(&[polygon])
    }

    fn polygon(points: &[[f64; 2]]) -> Vec<DVec2> {
        points.iter().map(|&p| DVec2::from(p)).collect()
    }

    #[test]
    fn crossings_touches_and_folds_are_found() {
        assert!(is_simple(&polygon(&[[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 0.25], [0.0, 1.0]])));
        assert!(!is_simple(&polygon(&[[0.0, 0.0], [2.0, 0.0], [0.0, 1.0], [2.0, 1.0]])));
        assert!(!is_simple(&polygon(&[[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 0.0], [0.0, 1.0]])));
        assert!(!is_simple(&polygon(&[[0.0, 0.0], [2.0, 0.0], [1.0, 0.0], [1.0, 1.0]])));
    }

    proptest! {
        #[test]
        fn stars_are_simple_until_two_rays_change_places(
            radii in prop::collection::vec(0.1f64..1.0, 5..40),
            at in any::<prop::sample::Index>(),
        ) {
            let n = radii.len();
            let ray = |k: usize| DVec2::from_angle(std::f64::consts::TAU * k as f64 / n as f64) * radii[k];
            let mut star: Vec<DVec2> = (0..n).map(ray).collect();
            prop_assert!(is_simple(&star));
            // Corners k + 1 and k + 2 of k, k + 1, k + 2, k + 3 on a convex arc: both ways cross.
            let k = at.index(n);
            (0..4).for_each(|j| star[(k + j) % n] = star[(k + j) % n].normalize());
            star.swap((k + 1) % n, (k + 2) % n);
            prop_assert!(!is_simple(&star));
        }
    }
}
