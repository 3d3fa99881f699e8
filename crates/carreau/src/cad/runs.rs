//! A profile, divided into straight lines, arcs of circles, and what is neither: the first two sweep surfaces with a name.
//!
//! ```text
//!     ●────────────●                a line
//!                    ╲ ●            an arc: five places or more on one circle, and the next one is not
//!                      ●  ╲
//!                      │   neither
//! ```

use crate::geometry::primitive::circle;
use glam::DVec2;

/// A count: fewest places of an arc, because three lie on some circle always, and so do four around an extremum of the
/// curvature, which are the corners of a symmetric trapezoid.
const LEAST_ARC: usize = 5;
/// A factor: the place after the end of a line or an arc is off by so many times the precision, because otherwise it is
/// a curve that bends little.
const DEFINITE_FACTOR: f64 = 20.0;
/// Cosine of 43°: two sides of a profile that bend by more meet at an edge, because facets of a smooth one bend by half
/// a radian at most.
const EDGE_COSINE: f64 = 0.73;

/// What a run lies on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    /// A straight line.
    Line,
    /// A circle.
    Arc {
        /// Its centre.
        center: DVec2,
        /// Its radius.
        radius: f64,
    },
    /// Neither.
    Free,
}

/// A part of a profile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Run {
    /// Numbers of its first and last place; the first place of a closed profile is also that after its last one.
    pub ends: [usize; 2],
    /// What it lies on.
    pub shape: Shape,
}

/// The runs of a profile from its first place to its last one.
pub fn runs(points: &[DVec2], near: f64) -> Vec<Run> {
    let mut out: Vec<Run> = Vec::new();
    let mut at = 0;
    while at + 1 < points.len() {
        if let Some((to, shape)) = longest(points, at, near) {
            out.push(Run { ends: [at, to], shape });
            at = to;
        } else {
            match out.last_mut().filter(|run| run.shape == Shape::Free) {
                Some(run) => run.ends[1] = at + 1,
                None => out.push(Run { ends: [at, at + 1], shape: Shape::Free }),
            }
            at += 1;
        }
    }
    // One side alone between others is straight, and so are two that meet at an edge.
    let is_sharp = |run: &Run| {
        let [a, b, c] = [0, 1, 2].map(|k| points[run.ends[0] + k]);
        (b - a).normalize_or_zero().dot((c - b).normalize_or_zero()) < EDGE_COSINE
    };
    let straight = |run: Run| match (run.shape, run.ends[1] - run.ends[0]) {
        (Shape::Free, 1) => vec![Run { shape: Shape::Line, ..run }],
        (Shape::Free, 2) if is_sharp(&run) => {
            let middle = run.ends[0] + 1;
            [[run.ends[0], middle], [middle, run.ends[1]]].map(|ends| Run { ends, shape: Shape::Line }).to_vec()
        }
        _ => vec![run],
    };
    out.into_iter().flat_map(straight).collect()
}

/// A place of a closed profile where a line or an arc begins.
pub fn joint(points: &[DVec2], near: f64) -> Option<usize> {
    let n = points.len();
    let twice: Vec<DVec2> = points.iter().chain(points).copied().collect();
    // Not from the first place, which may be in the middle of one.
    let found = (1..n).find_map(|at| longest(&twice, at, near).map(|(to, _)| (at, to)));
    found.filter(|(at, to)| to - at < n).map(|(at, _)| at)
}

/// The longest line or arc that begins at a place, and where it ends.
fn longest(points: &[DVec2], at: usize, near: f64) -> Option<(usize, Shape)> {
    let last = points.len() - 1;
    let line = |to: usize| {
        let along = (points[to] - points[at]).normalize_or_zero();
        let off = |p: &DVec2| (*p - points[at]).perp_dot(along).abs();
        (points[at..=to].iter().map(off).fold(0.0, f64::max), Shape::Line)
    };
    let arc = |to: usize| match circle(points[at..=to].iter().copied()) {
        Some((center, radius)) => {
            let off = |p: &DVec2| (p.distance(center) - radius).abs();
            (points[at..=to].iter().map(off).fold(0.0, f64::max), Shape::Arc { center, radius })
        }
        None => (f64::INFINITY, Shape::Free),
    };
    grown(at, at + 2, last, near, line, points).or_else(|| grown(at, at + LEAST_ARC - 1, last, near, arc, points))
}

/// The longest run from a place to `least` or beyond that is one shape, with definite ends.
fn grown(
    at: usize,
    least: usize,
    last: usize,
    near: f64,
    fit: impl Fn(usize) -> (f64, Shape),
    points: &[DVec2],
) -> Option<(usize, Shape)> {
    let mut best = None;
    let mut to = least;
    let mut beyond = f64::INFINITY;
    while to <= last {
        let (off, shape) = fit(to);
        if !(off <= near) {
            beyond = off;
            break;
        }
        best = Some((to, shape));
        to += 1;
    }
    let (to, shape) = best?;
    let off = |p: DVec2| match shape {
        Shape::Arc { center, radius } => (p.distance(center) - radius).abs(),
        _ => (p - points[at]).perp_dot((points[to] - points[at]).normalize_or_zero()).abs(),
    };
    let before = if at > 0 { off(points[at - 1]) } else { f64::INFINITY };
    let after = if to < last { off(points[to + 1]).max(beyond.min(f64::MAX)) } else { f64::INFINITY };
    (before > DEFINITE_FACTOR * near && after > DEFINITE_FACTOR * near).then_some((to, shape))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn arc(center: DVec2, radius: f64, from: f64, to: f64, count: usize) -> impl Iterator<Item = DVec2> {
        (0..=count).map(move |k| center + radius * DVec2::from_angle(from + (to - from) * k as f64 / count as f64))
    }

    #[test]
    fn a_slot_is_two_lines_and_two_arcs_wherever_it_begins() {
        use std::f64::consts::FRAC_PI_2;
        let right = arc(DVec2::new(3.0, 0.0), 1.0, -FRAC_PI_2, FRAC_PI_2, 6);
        let slot: Vec<DVec2> = right.chain(arc(DVec2::new(-3.0, 0.0), 1.0, FRAC_PI_2, 3.0 * FRAC_PI_2, 9)).collect();
        for turn in 0..slot.len() {
            let mut turned = slot.clone();
            turned.rotate_left(turn);
            let joint = joint(&turned, 1e-9).unwrap();
            turned.rotate_left(joint);
            turned.push(turned[0]);
            let found = runs(&turned, 1e-9);
            let lines = found.iter().filter(|r| r.shape == Shape::Line).count();
            assert_eq!((found.len(), lines), (4, 2), "{turn}: {found:?}");
            for run in &found {
                if let Shape::Arc { center, radius } = run.shape {
                    assert!((radius - 1.0).abs() < 1e-12 && (center.x.abs() - 3.0).abs() < 1e-12);
                }
            }
        }
    }

    #[test]
    fn a_curve_that_bends_evenly_is_one_run() {
        for count in [12, 60, 400] {
            let curve: Vec<DVec2> = (0..=count)
                .map(|k| f64::from(k) / f64::from(count))
                .map(|x| DVec2::new(x, 0.3 * (4.0 * x).sin() + 0.1 * x * x))
                .collect();
            let found = runs(&curve, 1e-6);
            assert!(found.len() == 1 && found[0].shape == Shape::Free, "{count}: {found:?}");
        }
    }
}
