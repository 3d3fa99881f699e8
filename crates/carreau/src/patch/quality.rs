//! Stage 1: which pairs of triangles make a quad, and how good it is (paper §3.1, equation 1).
//!
//! ```text
//!      c ───── b        half-edge h runs from a to b in the triangle (a, b, c);
//!      │ t0  ╱ │        opposite(h) runs from b to a in the triangle (b, a, d);
//!      │  h╱   │        the quad is (a, d, b, c), counter-clockwise.
//!      │ ╱  t1 │
//!      a ───── d
//! ```
//!
//! Q = ¼ Σ |π/2 − αᵢ| over the corner angles, each αᵢ the *sum* of the triangle angles there, so that reflex corners
//! count as what they are; a pair bent by more than ε_φ, or with Q > Q_max, is no candidate (the paper gives it Q = 2π).
//! Nor is one with a reflex corner whose bilinear surface folds noticeably (see `fold`), which the paper does not ask.
//! The filters always use equation 1; another coefficient (`--quality`, the paper's future work) changes the ranking.
//!
//! All sums are formed so that their last bit does not depend on the numbering of vertices and triangles, and ties
//! are broken by position: relabelling the mesh does not change the result.

use super::cad::{OffLimit, cell_weighs_right};
use super::fold::FoldLimit;
use crate::context::Context;
use crate::error::Result;
use crate::geometry::normals::{AngleLimit, angle_between};
use crate::mesh::{NONE, Triangles, by_position};
use glam::DVec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::cmp::Ordering;
use std::f64::consts::{FRAC_PI_2, PI};

/// How candidates are ranked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Quality {
    /// Equation 1: mean deviation of the corner angles from a right angle.
    #[default]
    Angles,
    /// As equation 1, but the target at each vertex is a quarter (on a border: half) of the angle that the surface has
    /// there, so that curved and cone-like places are not punished for the angle they lack.
    Adapted,
    /// One minus the smallest sine of the corner angles: the scaled Jacobian of a planar quad.
    Jacobian,
}

/// Which pairs are acceptable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Filters {
    pub quality: Quality,
    pub q_max: f64,
    pub dihedral: f64,
    /// Relaxes the dihedral limit where the surrounding edges bend as much as the pair itself.
    pub adapt_dihedral: bool,
    pub convex_only: bool,
    pub faces: bool,
    pub off_mesh: Option<OffLimit>,
}

/// All acceptable pairs of triangles.
pub(super) struct Candidates<'a> {
    pub triangles: Triangles<'a>,
    /// Ranking cost of the pair across every half-edge; infinite where there is none.
    pub cost: Vec<f64>,
    /// Place of the pair in `order`, for both its half-edges; [`NONE`] where there is none.
    pub rank: Vec<u32>,
    /// One half-edge of each pair, best first; it leaves the end point with the smaller coordinates.
    pub order: Vec<u32>,
    /// Half-edges that no patch may cross.
    pub barrier: Vec<bool>,
}

/// Geometry of one triangle: its angles and unit normal; `None` for a triangle without area.
type Shape = Option<([f64; 3], DVec3)>;

/// Twice the area below which a triangle of edge length one has none: its square would be too small for a double.
const LEAST_AREA: f64 = 1e-150;

fn shape(p: [DVec3; 3]) -> Shape {
    // Scaled to edge length one, about: products of tiny or huge coordinates neither vanish nor overflow, and nothing is rounded
    // that the validator has not rounded, whose normal of a triangle as thin as that would be another one.
    let edges = [p[1] - p[0], p[2] - p[1], p[0] - p[2]];
    let scale = edges.iter().map(|e| e.abs().max_element()).fold(0.0, f64::max);
    if !(scale > 0.0 && scale.is_finite()) {
        return None;
    }
    let scale = power_of_two(scale);
    let edges = edges.map(|e| e / scale);
    let angle = |out: DVec3, back: DVec3| out.cross(-back).length().atan2(out.dot(-back));
    // At the corner between the shorter edges, where the difference between these is not lost in rounding.
    let longest =
        (0..3).fold(1, |k, other| if edges[other].length_squared() > edges[k].length_squared() { other } else { k });
    let normal = edges[(longest + 1) % 3].cross(edges[(longest + 2) % 3]);
    if normal.abs().max_element() < LEAST_AREA {
        return None;
    }
    let normal = normal.normalize();
    Some(([angle(edges[0], edges[2]), angle(edges[1], edges[0]), angle(edges[2], edges[1])], normal))
}

/// The power of two that is not above a number; the number itself where that would be none.
fn power_of_two(x: f64) -> f64 {
    let power = f64::from_bits(x.to_bits() & (0x7ff << 52));
    if power > 0.0 { power } else { x }
}

impl<'a> Candidates<'a> {
    /// Finds and ranks all acceptable pairs. `barrier` marks the half-edges that no quad and no patch may cross.
    pub fn new(triangles: Triangles<'a>, filters: &Filters, barrier: Vec<bool>, context: &Context) -> Result<Self> {
        context.check()?;
        let shapes: Vec<Shape> = (0..triangles.len() as u32)
            .into_par_iter()
            .map(|t| shape([3 * t, 3 * t + 1, 3 * t + 2].map(|c| triangles.point(c))))
            .collect();
        context.check()?;
        let targets = match filters.quality {
            Quality::Adapted => Some(target_angles(triangles, &shapes)),
            _ => None,
        };
        let rater = Rater {
            triangles,
            shapes: &shapes,
            targets: targets.as_deref(),
            filters,
            dihedral: AngleLimit::new(filters.dihedral),
            fold: FoldLimit::new(triangles),
        };
        // The cost is the same from both sides, to the last bit: the half-edge with the smaller number is rated.
        let mut cost: Vec<f64> = (0..3 * triangles.len() as u32)
            .into_par_iter()
            .map(|h| if h > triangles.opposite(h) { None } else { rater.cost(h) }.unwrap_or(f64::INFINITY))
            .collect();
        context.check()?;
        for h in 0..cost.len() {
            let o = triangles.opposite(h as u32);
            if o != NONE && (o as usize) < h {
                cost[h] = cost[o as usize];
            }
        }
        barrier.iter().zip(&mut cost).filter(|(barred, _)| **barred).for_each(|(_, cost)| *cost = f64::INFINITY);
        let (order, rank) = ranking(triangles, &cost);
        Ok(Candidates { triangles, cost, rank, order, barrier })
    }

    /// Sides of the quad across half-edge `h`, counter-clockwise from its start: inside half-edges.
    #[inline]
    pub fn sides(&self, h: u32) -> [u32; 4] {
        let (t, o) = (self.triangles, self.triangles.opposite(h));
        [t.next(o), t.previous(o), t.next(h), t.previous(h)]
    }

    /// The half-edge across `h`, unless a barrier or a border is in the way.
    #[inline]
    pub fn across(&self, h: u32) -> u32 {
        if self.barrier[h as usize] { NONE } else { self.triangles.opposite(h) }
    }
}

struct Rater<'a> {
    triangles: Triangles<'a>,
    shapes: &'a [Shape],
    targets: Option<&'a [f64]>,
    filters: &'a Filters,
    dihedral: AngleLimit,
    fold: FoldLimit,
}

impl Rater<'_> {
    /// Ranking cost of the pair across `h`; `None` when it is not acceptable.
    fn cost(&self, h: u32) -> Option<f64> {
        let (t, f) = (self.triangles, self.filters);
        let o = t.opposite(h);
        if o == NONE || t.apex(h) == t.apex(o) {
            return None;
        }
        let (angles0, normal0) = self.shapes[h as usize / 3]?;
        let (angles1, normal1) = self.shapes[o as usize / 3]?;
        if self.dihedral.is_exceeded(normal0, normal1)
            && !(f.adapt_dihedral && angle_between(normal0, normal1) <= self.surrounding_bend(h, o))
        {
            return None;
        }
        let at = |angles: &[f64; 3], c: u32| angles[c as usize % 3];
        let alpha = [
            at(&angles0, h) + at(&angles1, t.next(o)), // a
            at(&angles0, t.next(h)) + at(&angles1, o), // b
            at(&angles1, t.previous(o)),               // d
            at(&angles0, t.previous(h)),               // c
        ];
        let q = deviation(alpha, [FRAC_PI_2; 4]);
        if q > f.q_max {
            return None;
        }
        let corners = [h, t.previous(o), o, t.previous(h)];
        let is_reflex = alpha.iter().any(|&a| a > PI);
        let corners = corners.map(|c| t.point(c));
        if is_reflex && (f.convex_only || self.fold.is_exceeded(corners)) {
            return None;
        }
        if f.faces && !(self.fold.is_slight(corners) && cell_weighs_right(corners)) {
            return None;
        }
        if f.off_mesh.is_some_and(|limit| limit.is_exceeded(corners)) {
            return None;
        }
        Some(match (f.quality, self.targets) {
            (Quality::Adapted, Some(targets)) => {
                let corners = [h, o, t.previous(o), t.previous(h)];
                deviation(alpha, corners.map(|c| targets[t.vertex(c) as usize]))
            }
            (Quality::Jacobian, _) => 1.0 - alpha.iter().map(|a| a.sin()).fold(1.0, f64::min),
            _ => q,
        })
    }

    /// Limit for the bend across `h` on a surface that bends as its surroundings do: 1.5 times the mean bend of the
    /// quad's own sides. A crease is sharper than that, a coarse sphere is not.
    fn surrounding_bend(&self, h: u32, o: u32) -> f64 {
        let t = self.triangles;
        let bend = |side: u32| {
            let other = t.opposite(side);
            if other == NONE {
                return None;
            }
            let (inside, outside) = (self.shapes[side as usize / 3]?, self.shapes[other as usize / 3]?);
            Some(angle_between(inside.1, outside.1))
        };
        let pair = |a: u32, b: u32| [bend(a), bend(b)].iter().flatten().fold((0.0, 0), |(s, n), x| (s + x, n + 1));
        let (mine, theirs) = (pair(t.next(h), t.previous(h)), pair(t.next(o), t.previous(o)));
        let (sum, n) = (mine.0 + theirs.0, mine.1 + theirs.1);
        if n < 3 { 0.0 } else { 1.5 * sum / f64::from(n) }
    }
}

/// ¼ Σ |target − α|, with a sum that does not depend on which triangle comes first.
fn deviation(alpha: [f64; 4], target: [f64; 4]) -> f64 {
    let d: [f64; 4] = std::array::from_fn(|k| (target[k] - alpha[k]).abs());
    0.25 * ((d[0] + d[1]) + (d[2] + d[3]))
}

/// The angle a quad should have at every vertex: a quarter of the angle around it, half of it on a border.
fn target_angles(triangles: Triangles, shapes: &[Shape]) -> Vec<f64> {
    let n = triangles.points().len();
    let (mut sum, mut border) = (vec![0.0; n], vec![false; n]);
    for c in 0..3 * triangles.len() as u32 {
        if let Some((angles, _)) = &shapes[c as usize / 3] {
            sum[triangles.vertex(c) as usize] += angles[c as usize % 3];
        }
        if triangles.opposite(c) == NONE {
            border[triangles.vertex(c) as usize] = true;
            border[triangles.vertex(triangles.next(c)) as usize] = true;
        }
    }
    sum.iter().zip(border).map(|(s, b)| if b { s / 2.0 } else { s / 4.0 }).collect()
}

/// One half-edge per pair, best first, and the place of every half-edge's pair.
fn ranking(triangles: Triangles, cost: &[f64]) -> (Vec<u32>, Vec<u32>) {
    let leads = |h: u32, o: u32| by_position(triangles.point(h), triangles.point(o)).then(h.cmp(&o)) == Ordering::Less;
    let middle = |h: u32| triangles.point(h) + triangles.point(triangles.opposite(h));
    // The costs lie beside the half-edges while they are sorted: a look at a table for each comparison would be slow.
    let mut pairs: Vec<(f64, u32)> = (0..cost.len() as u32)
        .into_par_iter()
        .filter(|&h| cost[h as usize].is_finite() && leads(h, triangles.opposite(h)))
        .map(|h| (cost[h as usize], h))
        .collect();
    pairs.par_sort_unstable_by(|&(p, a), &(q, b)| {
        p.total_cmp(&q).then_with(|| by_position(middle(a), middle(b))).then(a.cmp(&b))
    });
    let order: Vec<u32> = pairs.into_iter().map(|(_, h)| h).collect();
    let mut rank = vec![NONE; cost.len()];
    for (k, &h) in order.iter().enumerate() {
        rank[h as usize] = k as u32;
        rank[triangles.opposite(h) as usize] = k as u32;
    }
    (order, rank)
}
