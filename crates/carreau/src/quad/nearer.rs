//! The last few quads that are too far from the surface, most of them across a ridge of coarse facets, where what brings one
//! nearer takes another away: each vertex of theirs looks around for a place where the farthest of its quads is nearer.
//!
//! ```text
//!     ·              up and down, along the surface and across, or along its curve;
//!   · v ·       →    half as far where nothing is better
//!     ·
//! ```

use super::around::{Around, Ring, corners};
use super::gaps::{Gaps, beneath};
use super::quality::halves_of;
use super::smooth::{KEPT_SHARE, keeps_feature_at};
use super::work::{Place, Work};
use crate::context::Context;
use crate::error::Result;
use crate::geometry::closest::closest_on_triangle;
use glam::DVec3;
use rustc_hash::{FxHashMap, FxHashSet};

/// A share of the quads: where more are too far off none is nudged, because other quads are needed there.
const MOST_FAR_SHARE: f64 = 0.03;
/// A count: so many quads are nudged whatever their share, because a few of a small mesh are a large share.
const FEW_FAR_QUADS: usize = 20;
/// A count: rounds over the quads that are too far off, because what brings one nearer may take another away.
const NUDGE_ROUNDS: usize = 4;
/// A share of what is allowed: the first step up and down, because quads are mostly off by little more than that.
const NUDGE_UP: f64 = 0.5;
/// A share of the mean edge: the first step along the surface or a curve, because longer ones skew the quads around.
const NUDGE_ALONG: f64 = 0.15;
/// A count: how often these steps are halved, because shorter ones hardly bring anything nearer.
const NUDGE_HALVINGS: u32 = 3;
/// A count: steps of a vertex in one round at most, because each of them measures the quads around anew.
const MOST_NUDGES: usize = 12;
/// A scaled Jacobian over what it can be: a move may worsen quads down to it, further than in smoothing because no
/// other place may be nearer.
const NUDGED_SHAPE: f64 = 0.6;
/// A share of the distance: a place must be nearer by so much, because less is not worth a step.
const NUDGE_GAIN: f64 = 0.01;

/// Moves vertices inside regions, and those on curves along them; returns the gaps after it.
pub fn nudge(
    work: &mut Work,
    around: &Around,
    gaps: &mut Gaps,
    mut now: Vec<DVec3>,
    context: &Context,
) -> Result<Vec<DVec3>> {
    for _ in 0..NUDGE_ROUNDS {
        let beyond: Vec<usize> = (0..now.len()).filter(|&q| now[q].length() > gaps.far).collect();
        if beyond.is_empty() || beyond.len() > FEW_FAR_QUADS.max((MOST_FAR_SHARE * now.len() as f64) as usize) {
            break;
        }
        let free = |&v: &u32| work.place[v as usize] != Place::Fixed;
        let mut vertices: Vec<u32> = beyond.iter().flat_map(|&q| work.faces.face(q)).copied().filter(free).collect();
        vertices.sort_unstable();
        vertices.dedup();
        let quads: FxHashSet<u32> = vertices.iter().flat_map(|&v| around.quads[v as usize].iter().copied()).collect();
        let above = gaps.above(&quads);
        let mut has_moved = vec![false; work.points.len()];
        for &v in &vertices {
            context.check()?;
            if let Some(to) = (Nudge { work, around, gaps, above: &above, v }).better() {
                work.points[v as usize] = to;
                has_moved[v as usize] = true;
            }
        }
        if !has_moved.contains(&true) {
            break;
        }
        now = gaps.of(work, &has_moved);
    }
    Ok(now)
}

/// A vertex that may move.
struct Nudge<'a> {
    work: &'a Work,
    around: &'a Around,
    gaps: &'a Gaps<'a>,
    /// Places of the source above quads.
    above: &'a FxHashMap<u32, Vec<DVec3>>,
    v: u32,
}

impl Nudge<'_> {
    /// Where the farthest of its quads is nearer, if that one is too far off.
    fn better(&self) -> Option<DVec3> {
        let (work, far) = (self.work, self.gaps.far);
        let from = work.points[self.v as usize];
        let before = self.gap(from);
        let ring = Ring::new(work, self.around, self.v);
        let least = ring.now.min(NUDGED_SHAPE);
        let (mut at, mut gap, mut scale) = (from, before, 1.0);
        let ways = self.ways();
        let smallest = 0.5f64.powi(NUDGE_HALVINGS as i32);
        for _ in 0..MOST_NUDGES {
            if gap <= far || scale < smallest {
                break;
            }
            let places = ways.iter().flat_map(|&way| [at + scale * way, at - scale * way]).map(|to| self.kept(to));
            let may_be = |&to: &DVec3| {
                ring.holds(to, least) && keeps_feature_at(work, self.around, self.gaps.source, self.v, to, KEPT_SHARE)
            };
            let measured = places.filter(may_be).map(|to| (self.gap(to), to));
            match measured.min_by(|a, b| a.0.total_cmp(&b.0)) {
                Some((nearer, to)) if nearer < (1.0 - NUDGE_GAIN) * gap => (at, gap) = (to, nearer),
                _ => scale *= 0.5,
            }
        }
        (gap < before).then_some(at)
    }

    /// Its first steps: along its curve; else away from the surface, and two ways along it.
    fn ways(&self) -> Vec<DVec3> {
        let (work, around, v) = (self.work, self.around, self.v);
        let length = NUDGE_ALONG * around.mean_edge(work, v);
        match work.place[v as usize] {
            Place::Region(_) => {
                let up = around.up(work, v);
                let along = length * up.any_orthonormal_vector();
                vec![NUDGE_UP * self.gaps.far * up, along, up.cross(along)]
            }
            _ => {
                let from = work.points[v as usize];
                let neighbours = around.neighbours[v as usize].iter().map(|&w| work.points[w as usize]);
                neighbours.map(|w| length * (w - from).normalize_or_zero()).take(1).collect()
            }
        }
    }

    /// A vertex on a curve stays there.
    fn kept(&self, to: DVec3) -> DVec3 {
        match self.work.place[self.v as usize] {
            Place::Region(_) => to,
            _ => self.work.put_back(self.gaps.source, self.v, to),
        }
    }

    /// How far the quads around it are off where it is at `at`: both ways, and at the vertex.
    fn gap(&self, at: DVec3) -> f64 {
        let quads = &self.around.quads[self.v as usize];
        let halves: Vec<[[DVec3; 3]; 2]> = quads
            .iter()
            .map(|&q| {
                let p = corners(self.work, q, self.v, at);
                halves_of(p).map(|half| half.map(|k| p[k]))
            })
            .collect();
        let Gaps { source, far, .. } = *self.gaps;
        let region = |q: u32| self.work.region[q as usize];
        let below = quads.iter().zip(&halves).map(|(&q, halves)| beneath(source, region(q), *halves, far).length());
        let nearest = |p: &DVec3| {
            let distances = halves.iter().flatten().map(|&half| closest_on_triangle(*p, half).distance(*p));
            distances.fold(f64::INFINITY, f64::min)
        };
        let above = quads.iter().filter_map(|q| self.above.get(q)).flatten().map(nearest);
        below.chain(above).fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::features::FeatureOptions;
    use crate::mesh::{SurfaceMesh, test_models};
    use crate::quad::around::worst;
    use crate::quad::source::Source;

    /// A flat pyramid over the unit square, and `n` by `n` quads with their vertices on it: one without the tip for an odd
    /// number.
    fn pyramid(slope: f64, n: u32) -> (Work, Source) {
        let lifted = |p: DVec3, n: u32| {
            let p = p / f64::from(n);
            p.with_z(slope * (0.5 - (p.x - 0.5).abs().max((p.y - 0.5).abs())))
        };
        let squares = test_models::grid(2);
        let corners: Vec<DVec3> = squares.points().iter().map(|&p| lifted(p, 2)).collect();
        let around: Vec<[u32; 3]> =
            vec![[0, 3, 4], [3, 6, 4], [6, 7, 4], [7, 8, 4], [8, 5, 4], [5, 2, 4], [2, 1, 4], [1, 0, 4]];
        let mesh = SurfaceMesh::from_triangles(corners, &around).unwrap();
        let options = FeatureOptions { angle_deg: None, ..FeatureOptions::default() };
        let source = Source::new(&mesh, &options, &Context::new()).unwrap();
        let points: Vec<DVec3> = test_models::grid(n).points().iter().map(|&p| lifted(p, n)).collect();
        let is_inner = |p: &DVec3| p.z > 1e-9;
        let place = points.iter().map(|p| if is_inner(p) { Place::Region(0) } else { Place::Fixed }).collect();
        let quad = |i: u32, j: u32| [i, i + 1, i + 1, i].map(|i| i * (n + 1)).into_iter().zip([j, j, j + 1, j + 1]);
        let mut work = Work { points, place, region: vec![0; (n * n) as usize], ..Work::default() };
        for k in 0..n * n {
            work.faces.push_iter(quad(k / n, k % n).map(|(row, j)| row + j));
        }
        (work, source)
    }

    /// The gaps before and after, in what is allowed.
    fn nudged(work: &mut Work, source: &Source) -> [f64; 2] {
        let around = Around::new(work);
        let mut gaps = Gaps::new(work, source, 0.0017 * source.diagonal);
        let largest =
            |gaps: &[DVec3]| gaps.iter().map(|gap| gap.length()).fold(0.0, f64::max) / (0.0017 * source.diagonal);
        let before = gaps.of(work, &vec![true; work.points.len()]);
        let after = nudge(work, &around, &mut gaps, before.clone(), &Context::new()).unwrap();
        // What it says is so.
        let again = Gaps::new(work, source, 0.0017 * source.diagonal).of(work, &vec![true; work.points.len()]);
        assert!((largest(&again) - largest(&after)).abs() < 1e-9);
        [largest(&before), largest(&after)]
    }

    #[test]
    fn quads_that_leave_out_a_tip_come_near_it() {
        let (mut work, source) = pyramid(0.08, 9);
        let was = work.clone();
        let [before, after] = nudged(&mut work, &source);
        assert!(before > 1.5 && after <= 1.05, "{before} {after}");
        let around = Around::new(&work);
        assert!((0..100).all(|v| worst(&work, &around, v) >= NUDGED_SHAPE));
        let has_moved = |v: usize| work.points[v] != was.points[v];
        assert!((0..100).all(|v| !has_moved(v) || work.place[v] != Place::Fixed));
        assert!((0..100).filter(|&v| has_moved(v)).count() < 20, "the few that it takes");
    }

    #[test]
    fn many_that_are_too_far_are_left_alone() {
        let (mut work, source) = pyramid(2.0, 25);
        let was = work.points.clone();
        let [before, after] = nudged(&mut work, &source);
        assert!(before > 1.0 && before == after);
        assert_eq!(work.points, was);
    }
}
