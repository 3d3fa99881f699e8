//! Quads that are turned over: the vertices around them go where a barrier falls that rises to infinity where a corner of a quad
//! becomes flat.
//!
//! ```text
//!   d───c       At the corner a: N = |u| |v| + λ (|u|² + |v|²), D = n · (u × v), the area that u and v span on the side
//!   │   │ v     where the surface looks, and χ(D) = (D + √(D² + ε²)) / 2, which is D where that is above zero by far
//!   a───b       and still above zero where it is not. The barrier is N / χ(D), summed up over all corners, with ε as
//!     u         the worst corner asks for (Garanzha and others: Foldover-free maps in 50 lines of code, 2021).
//! ```
//!
//! |u| |v| / D is one over the sine of the angle. Angles are what counts in slivers, where quads are far longer than wide; the
//! squares keep edges from shrinking to nothing. D is linear in every vertex: one after the other makes Newton's step in its
//! tangent plane, or along its curve, and goes back to its region or curve.

use super::around::{Around, beside, corners, normal};
use super::smooth::{LOOKED_AFTER_SHARE, jacobian, keeps_feature_at, turned};
use super::source::Source;
use super::validate::faults;
use super::work::{Place, Work};
use crate::context::Context;
use crate::error::Result;
use glam::{DMat2, DVec2, DVec3};
use rustc_hash::FxHashMap;
use std::f64::consts::FRAC_PI_2;

/// A count: rounds with an ε each, because that falls with the worst corner.
const ROUNDS: usize = 30;
/// A count: rounds that leave no fewer quads turned over before it is given up.
const PATIENCE: usize = 8;
/// A count: sweeps over the vertices in a round, because a vertex that moves makes room for others.
const SWEEPS: usize = 4;
/// A count: rings of quads around those that are turned over whose vertices move, because they have to make room.
const RINGS: usize = 3;
/// λ, a share: what the squares of the edges count beside their product, little because slivers cannot but have long edges.
const EDGE_SHARE: f64 = 0.1;
/// A share of the worst corner's area below zero: the ε that goes with it (Garanzha and others, section 3).
const SOFT_SHARE: f64 = 0.2;
/// A share of the mean area of a corner: ε where no corner is turned over, small because the barrier is to be steep there.
const SOFT_LEAST: f64 = 1e-6;
/// A share of the way from a corner of a quad to its centre: the normal of the surface is the mean of those there and in the
/// centre, because single ones of a scan, or of needles, look anywhere.
const INSIDE: f64 = 0.3;
/// A share of the mean edge: one step goes no farther, because the quads around are to change by little.
const LONGEST_STEP: f64 = 0.5;
/// A count: halvings of a step until the barrier falls.
const HALVINGS: usize = 8;
/// A share of the barrier: a step that lowers it by less is none.
const LEAST_GAIN: f64 = 1e-6;

/// Moves the vertices of quads that are turned over, and of those around, until there are none or it is of no use. Returns
/// whether there are none.
pub fn untangle(work: &mut Work, around: &Around, source: &Source, context: &Context) -> Result<bool> {
    let mut best: Option<(usize, usize, Vec<DVec3>)> = None;
    for round in 0..ROUNDS {
        let bad = bad(work, source);
        if best.as_ref().is_none_or(|b| bad.len() < b.0) {
            best = Some((bad.len(), round, work.points.clone()));
        }
        let since = best.as_ref().map_or(0, |b| round - b.1);
        if bad.is_empty() || since > PATIENCE {
            break;
        }
        let near = near(work, around, &bad);
        let barrier = Barrier::new(work, around, source, &near, &bad);
        for _ in 0..SWEEPS {
            for &v in &near {
                context.check_every(v as usize)?;
                barrier.step(work, around, source, v);
            }
        }
    }
    if let Some((_, _, points)) = best {
        work.points = points;
    }
    Ok(turned(work).iter().all(|&q| jacobian(work, q) > 0.0))
}

/// Quads that are turned over, or all but, or look the wrong way.
fn bad(work: &Work, source: &Source) -> Vec<u32> {
    let mut bad = turned(work);
    bad.extend(faults(work, source).map(|(q, _)| q as u32));
    bad.sort_unstable();
    bad.dedup();
    bad
}

/// The vertices around quads.
fn near(work: &Work, around: &Around, quads: &[u32]) -> Vec<u32> {
    let mut quads = quads.to_vec();
    for _ in 1..RINGS {
        quads = quads.iter().flat_map(|&q| beside(work, around, q)).collect();
        quads.sort_unstable();
        quads.dedup();
    }
    let mut near: Vec<u32> = quads.iter().flat_map(|&q| work.faces.face(q as usize)).copied().collect();
    near.sort_unstable();
    near.dedup();
    near
}

/// The barrier around some vertices.
struct Barrier {
    /// Where the quads are to look, by number.
    up: FxHashMap<u32, DVec3>,
    /// ε.
    soft: f64,
}

impl Barrier {
    fn new(work: &Work, around: &Around, source: &Source, near: &[u32], bad: &[u32]) -> Self {
        let mut up = FxHashMap::default();
        let (mut worst, mut sum, mut count) = (0f64, 0.0, 0usize);
        for &q in near.iter().flat_map(|&v| &around.quads[v as usize]) {
            if up.contains_key(&q) {
                continue;
            }
            let p = [0, 1, 2, 3].map(|k| work.points[work.faces.face(q as usize)[k] as usize]);
            // The surface may bend much below a quad: one that is good tells best where it looks.
            let looks = if bad.binary_search(&q).is_ok() { looks(work, source, q, p) } else { normal(p) };
            for k in 0..4 {
                let area = looks.dot((p[(k + 1) % 4] - p[k]).cross(p[(k + 3) % 4] - p[k]));
                (worst, sum, count) = (worst.min(area), sum + area.abs(), count + 1);
            }
            up.insert(q, looks);
        }
        let mean = sum / count.max(1) as f64;
        Barrier { up, soft: (SOFT_LEAST * mean).hypot(SOFT_SHARE * worst) }
    }

    /// Newton's step of a vertex.
    fn step(&self, work: &mut Work, around: &Around, source: &Source, v: u32) {
        if work.place[v as usize] == Place::Fixed || around.neighbours[v as usize].is_empty() {
            return;
        }
        let Some(plane) = self.plane(work, around, v) else { return };
        let from = work.points[v as usize];
        let now = self.around(work, around, v, from, &plane);
        let mut way = descent(&now);
        let length = around.mean_edge(work, v);
        way *= (LONGEST_STEP * length / way.length().max(f64::MIN_POSITIVE)).min(1.0);
        let up = self.up(around, v);
        for _ in 0..HALVINGS {
            let to = from + plane.0[0] * way.x + plane.0[1] * way.y;
            way *= 0.5;
            let Some(to) = work.put_back_facing(source, v, to, up) else { continue };
            if self.around(work, around, v, to, &plane).value < now.value * (1.0 - LEAST_GAIN)
                && keeps_feature_at(work, around, source, v, to, LOOKED_AFTER_SHARE)
            {
                work.points[v as usize] = to;
                return;
            }
        }
    }

    /// Where a vertex moves.
    fn plane(&self, work: &Work, around: &Around, v: u32) -> Option<Plane> {
        if let Place::Curve(_) = work.place[v as usize] {
            let [a, b] = around.neighbours[v as usize][..] else { return None };
            return Some(Plane([(work.points[b as usize] - work.points[a as usize]).try_normalize()?, DVec3::ZERO]));
        }
        let (x, y) = self.up(around, v).try_normalize()?.any_orthonormal_pair();
        Some(Plane([x, y]))
    }

    /// Where the quads around a vertex look together.
    fn up(&self, around: &Around, v: u32) -> DVec3 {
        around.quads[v as usize].iter().map(|q| self.up[q]).sum()
    }

    /// The barrier of the quads around a vertex that is at a place.
    fn around(&self, work: &Work, around: &Around, v: u32, at: DVec3, plane: &Plane) -> Nearby {
        let mut sum = Nearby::ZERO;
        for &q in &around.quads[v as usize] {
            let (up, p) = (self.up[&q], corners(work, q, v, at));
            let Some(own) = work.faces.face(q as usize).iter().position(|&w| w == v) else { continue };
            for (k, moves) in [(own, Moves::Corner), ((own + 3) % 4, Moves::Next), ((own + 1) % 4, Moves::Previous)] {
                let (u, w) = (p[(k + 1) % 4] - p[k], p[(k + 3) % 4] - p[k]);
                sum.add(size(u, w, moves, plane), area(u, w, up, moves, plane), self.soft);
            }
        }
        sum
    }
}

/// Where the surface looks below a quad.
fn looks(work: &Work, source: &Source, q: u32, p: [DVec3; 4]) -> DVec3 {
    let centre = p.iter().sum::<DVec3>() / 4.0;
    let region = work.region[q as usize];
    let of = |at: DVec3| source.on_region(region, at).map_or(DVec3::ZERO, |(_, t)| source.normal(t));
    let sum = p.iter().map(|&p| of(p.lerp(centre, INSIDE))).sum::<DVec3>() + of(centre);
    sum.normalize_or(of(centre))
}

/// The plane in which a vertex moves, by two directions; on a curve the second one is zero.
struct Plane([DVec3; 2]);

impl Plane {
    fn flat(&self, p: DVec3) -> DVec2 {
        DVec2::new(p.dot(self.0[0]), p.dot(self.0[1]))
    }

    fn identity(&self) -> DMat2 {
        DMat2::from_diagonal(DVec2::new(self.0[0].length_squared(), self.0[1].length_squared()))
    }
}

/// Which vertex of a corner moves: its own, or the end of an edge.
#[derive(Clone, Copy)]
enum Moves {
    Corner,
    Next,
    Previous,
}

/// A function of a vertex near where it is: its value, and its first and second derivatives in the plane.
struct Nearby {
    value: f64,
    slope: DVec2,
    bend: DMat2,
}

impl Nearby {
    const ZERO: Self = Nearby { value: 0.0, slope: DVec2::ZERO, bend: DMat2::ZERO };

    /// Adds N / χ(D); D is linear, so that it comes without a second derivative.
    fn add(&mut self, n: Nearby, (d, slope): (f64, DVec2), soft: f64) {
        let root = d.hypot(soft);
        // Below zero χ is a difference of two numbers that are nearly the same: this is what it comes to.
        let chi = if d < 0.0 { 0.5 * soft * soft / (root - d) } else { 0.5 * (d + root) };
        let (first, second) = (chi / root, 0.5 * soft * soft / root.powi(3));
        self.value += n.value / chi;
        self.slope += n.slope / chi - slope * (n.value * first / (chi * chi));
        self.bend += n.bend * (1.0 / chi) - (outer(n.slope, slope) + outer(slope, n.slope)) * (first / (chi * chi))
            + outer(slope, slope) * (n.value * (2.0 * first * first / chi - second) / (chi * chi));
    }
}

fn outer(a: DVec2, b: DVec2) -> DMat2 {
    DMat2::from_cols(a * b.x, a * b.y)
}

/// N at a corner with the edges u and w.
fn size(u: DVec3, w: DVec3, moves: Moves, plane: &Plane) -> Nearby {
    let [lu, lw] = [u, w].map(|edge| edge.length().max(f64::MIN_POSITIVE));
    let (du, dw) = (plane.flat(u / lu), plane.flat(w / lw));
    let across = |d: DVec2| plane.identity() - outer(d, d);
    let value = lu * lw + EDGE_SHARE * (lu * lu + lw * lw);
    let (slope, bend) = match moves {
        Moves::Corner => (
            -(du * lw + dw * lu) - 2.0 * EDGE_SHARE * (du * lu + dw * lw),
            across(du) * (lw / lu)
                + across(dw) * (lu / lw)
                + outer(du, dw)
                + outer(dw, du)
                + plane.identity() * (4.0 * EDGE_SHARE),
        ),
        Moves::Next => {
            (du * (lw + 2.0 * EDGE_SHARE * lu), across(du) * (lw / lu) + plane.identity() * (2.0 * EDGE_SHARE))
        }
        Moves::Previous => {
            (dw * (lu + 2.0 * EDGE_SHARE * lw), across(dw) * (lu / lw) + plane.identity() * (2.0 * EDGE_SHARE))
        }
    };
    Nearby { value, slope, bend }
}

/// D at a corner with the edges u and w, and its derivative.
fn area(u: DVec3, w: DVec3, up: DVec3, moves: Moves, plane: &Plane) -> (f64, DVec2) {
    let slope = match moves {
        Moves::Corner => (u - w).cross(up),
        Moves::Next => w.cross(up),
        Moves::Previous => up.cross(u),
    };
    (up.dot(u.cross(w)), plane.flat(slope))
}

/// The way down: Newton's, with the directions in which the barrier bends down taken as if it bent up.
fn descent(now: &Nearby) -> DVec2 {
    let (a, b, c) = (now.bend.x_axis.x, now.bend.x_axis.y, now.bend.y_axis.y);
    let angle = if b == 0.0 && a >= c { 0.0 } else { 0.5 * (2.0 * b).atan2(a - c) };
    let of = |angle: f64| {
        let along = DVec2::from_angle(angle);
        let bend = along.dot(now.bend * along).abs();
        if bend > 0.0 { along * (-now.slope.dot(along) / bend) } else { DVec2::ZERO }
    };
    of(angle) + of(angle + FRAC_PI_2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::features::FeatureOptions;
    use crate::mesh::{Polygons, SurfaceMesh};
    use proptest::prelude::*;

    /// A sliver of ten quads in two rows; the vertices between the rows are where `moved` says, in the length of a quad along the
    /// sliver and in its width across.
    fn sliver(width: f64, moved: &[[f64; 2]]) -> (Work, Source, Context) {
        let context = Context::new();
        let at = |x: f64, y: f64| DVec3::new(x, y * width, 0.0);
        let mut faces = Polygons::new();
        [[0, 1, 2], [0, 2, 3]].iter().for_each(|t| faces.push(t));
        let outline = vec![at(0.0, 0.0), at(10.0, 0.0), at(10.0, 2.0), at(0.0, 2.0)];
        let mesh = SurfaceMesh::new(outline, faces).unwrap();
        let source = Source::new(&mesh, &FeatureOptions::default(), &context).unwrap();
        let mut work = Work::default();
        for k in 0..=10u32 {
            let x = f64::from(k);
            let inner = moved.get(k as usize).copied().filter(|_| k > 0 && k < 10).unwrap_or_default();
            work.points.extend([at(x, 0.0), at(x + inner[0], 1.0 + inner[1]), at(x, 2.0)]);
            let place = if k > 0 && k < 10 { Place::Region(0) } else { Place::Fixed };
            work.place.extend([Place::Fixed, place, Place::Fixed]);
        }
        for k in 0..10u32 {
            let v = 3 * k;
            work.faces.push(&[v, v + 3, v + 4, v + 1]);
            work.faces.push(&[v + 1, v + 4, v + 5, v + 2]);
        }
        work.region = vec![0; 20];
        (work, source, context)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]
        #[test]
        fn quads_of_a_sliver_are_turned_back(
            width in 0.01..1.0f64,
            moved in prop::collection::vec([-1.4..1.4f64, -0.9..0.9], 11),
        ) {
            let (mut work, source, context) = sliver(width, &moved);
            let around = Around::new(&work);
            let before = work.clone();
            prop_assert!(untangle(&mut work, &around, &source, &context).unwrap());
            prop_assert!(bad(&work, &source).is_empty());
            // What may not move has not, and the others are where they belong.
            for v in 0..work.points.len() {
                match work.place[v] {
                    Place::Fixed => prop_assert_eq!(work.points[v], before.points[v]),
                    _ => prop_assert!(work.points[v].z == 0.0 && (0.0..=2.0 * width).contains(&work.points[v].y)),
                }
            }
        }
    }

    proptest! {
        #[test]
        fn the_slopes_of_the_barrier_are_its_differences(
            p in prop::collection::vec([-1.0..1.0f64, -1.0..1.0, -0.3..0.3], 3),
            soft in 0.1..1.0f64,
        ) {
            let [a, b, c] = [0, 1, 2].map(|k| DVec3::from_array(p[k]));
            prop_assume!((b - a).length() > 0.2 && (c - a).length() > 0.2);
            let (up, plane) = (DVec3::Z, Plane([DVec3::X, DVec3::Y]));
            for moves in [Moves::Corner, Moves::Next, Moves::Previous] {
                let at = |x: f64, y: f64| {
                    let by = |is_it: bool| if is_it { DVec3::new(x, y, 0.0) } else { DVec3::ZERO };
                    let a = a + by(matches!(moves, Moves::Corner));
                    let (b, c) = (b + by(matches!(moves, Moves::Next)), c + by(matches!(moves, Moves::Previous)));
                    let mut sum = Nearby::ZERO;
                    sum.add(size(b - a, c - a, moves, &plane), area(b - a, c - a, up, moves, &plane), soft);
                    sum
                };
                let (now, h) = (at(0.0, 0.0), 1e-5);
                let size = now.value.abs() + now.slope.length() + now.bend.x_axis.length() + now.bend.y_axis.length();
                for (x, y) in [(h, 0.0), (0.0, h)] {
                    let (more, less) = (at(x, y), at(-x, -y));
                    let along = DVec2::new(x, y) / h;
                    prop_assert!(((more.value - less.value) / (2.0 * h) - now.slope.dot(along)).abs() < 1e-4 * size);
                    prop_assert!(((more.slope - less.slope) / (2.0 * h) - now.bend * along).length() < 1e-3 * size);
                }
            }
        }
    }

    #[test]
    fn quads_that_are_good_stay() {
        let (mut work, source, context) = sliver(0.1, &[[0.1, 0.2]; 11]);
        let before = work.points.clone();
        let around = Around::new(&work);
        assert!(untangle(&mut work, &around, &source, &context).unwrap());
        assert_eq!(work.points, before);
    }
}
