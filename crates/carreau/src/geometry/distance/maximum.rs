//! The largest distance, between two bounds that are brought together.

use super::chunks::{map_chunks, of_chunks};
use super::samples::Sample;
use super::target::Target;
use crate::context::Context;
use crate::error::Result;
use crate::geometry::closest::closest_on_triangle;
use crate::geometry::search_tree::Closest;
use glam::DVec3;
use rayon::prelude::*;

/// Triangles divided in one round.
pub const TRIANGLES_PER_ROUND: usize = 1024;
/// The bounds have met when they differ by less than this share of the diagonal.
pub const MET: f64 = 1e-5;

/// The maximum between two bounds.
pub struct Bracket {
    /// The largest distance seen.
    pub(super) lower: f64,
    /// Where; the first of several.
    pub(super) at: DVec3,
    /// Upper bound of the true maximum.
    pub(super) upper: f64,
    /// Points seen.
    pub(super) points: usize,
}

impl Default for Bracket {
    fn default() -> Self {
        Bracket { lower: f64::NEG_INFINITY, at: DVec3::ZERO, upper: 0.0, points: 0 }
    }
}

impl Bracket {
    pub(super) fn see(&mut self, point: DVec3, distance: f64) {
        self.points += 1;
        if distance > self.lower {
            (self.lower, self.at) = (distance, point);
        }
    }
}

/// Samples from which the distance is climbed.
pub const CLIMBERS: usize = 256;
/// Steps of each. The first is as long as samples are `apart`; where no step leads up, the next is half as long.
pub const STEPS: usize = 24;
/// A step that raises the distance by a smaller share is none.
pub const CLIMB: f64 = 1e-3;

/// Raises the lower bound of the maximum: the farthest samples go uphill within their triangles. Dividing triangles begins
/// where bounds are loosest, and on large flat faces above small triangles that is everywhere but at the maximum.
pub fn climb(bracket: &mut Bracket, samples: &[Sample], distances: &[f64], apart: f64, from: &Target, to: &Target) {
    let mut farthest: Vec<usize> = (0..samples.len()).collect();
    let order = |a: &usize, b: &usize| distances[*b].total_cmp(&distances[*a]).then(a.cmp(b));
    if farthest.len() > CLIMBERS {
        farthest.select_nth_unstable_by(CLIMBERS, order);
        farthest.truncate(CLIMBERS);
    }
    farthest.sort_unstable_by(order);
    let summit = |&k: &usize| {
        let Sample { point: mut top, triangle } = samples[k];
        let (mut height, mut last) = (distances[k], None);
        let corners = from.corners(triangle);
        let (x, y) = from.normals[triangle as usize].any_orthonormal_pair();
        let mut step = apart;
        for _ in 0..STEPS {
            let around = [x, y, -x, -y].map(|way| closest_on_triangle(top + step * way, corners));
            let heights = around.map(|p| to.closest_near(p, &mut last).distance());
            let best = (0..4).fold(0, |best, i| if heights[i] > heights[best] { i } else { best });
            if heights[best] > height * (1.0 + CLIMB) {
                (top, height) = (around[best], heights[best]);
            } else {
                step *= 0.5;
            }
        }
        (top, height)
    };
    let summits: Vec<(DVec3, f64)> = farthest.par_iter().filter(|&&k| distances[k] > 0.0).map(summit).collect();
    summits.into_iter().for_each(|(point, height)| bracket.see(point, height));
}

/// A part of a triangle, the closest triangles of its corners, and a bound for the distance of all its points.
#[derive(Clone, Copy)]
pub struct Part {
    pub(super) corners: [DVec3; 3],
    pub(super) closest: [u32; 3],
    pub(super) bound: f64,
}

impl Part {
    /// Bounded by what is known of the corners.
    pub(super) fn at_corners(corners: [DVec3; 3], closest: [u32; 3], to: &Target) -> Part {
        Part { corners, closest, bound: bound_by(corners, &closest, to) }
    }

    pub(super) fn centre(&self) -> DVec3 {
        self.corners.iter().sum::<DVec3>() / 3.0
    }

    /// Bounded by the closest triangle of the centre as well; returns the centre's distance too.
    pub(super) fn with_centre(mut self, to: &Target) -> (Part, f64) {
        let centre = self.centre();
        let closest = to.closest_near(centre, &mut Some(self.closest[0]));
        // The distance changes by no more than the way: a second bound, better for parts far away.
        let reach = self.corners.iter().map(|c| c.distance(centre)).fold(0.0, f64::max);
        let by_centre = bound_by(self.corners, &[closest.triangle], to).min(closest.distance() + reach);
        self.bound = self.bound.min(by_centre);
        (self, closest.distance())
    }

    /// The four quarters, and all points that were looked at.
    ///
    /// ```text
    ///       c
    ///      ╱ ╲
    ///    ca───bc
    ///    ╱ ╲ ╱ ╲
    ///   a───ab──b
    /// ```
    pub(super) fn quarters(&self, to: &Target) -> ([Part; 4], [(DVec3, f64); 7]) {
        let ([a, b, c], [ka, kb, kc]) = (self.corners, self.closest);
        let middles = [(a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0];
        let found = middles.map(|m| to.closest_near(m, &mut Some(ka)));
        let ([ab, bc, ca], [kab, kbc, kca]) = (middles, found.map(|f| f.triangle));
        let quarters = [
            ([a, ab, ca], [ka, kab, kca]),
            ([ab, b, bc], [kab, kb, kbc]),
            ([ca, bc, c], [kca, kbc, kc]),
            ([ab, bc, ca], [kab, kbc, kca]),
        ]
        .map(|(corners, closest)| Part::at_corners(corners, closest, to).with_centre(to));
        let middle = |k: usize| (middles[k], found[k].distance());
        let centre = |k: usize| (quarters[k].0.centre(), quarters[k].1);
        let seen = [middle(0), middle(1), middle(2), centre(0), centre(1), centre(2), centre(3)];
        (quarters.map(|(part, _)| Part { bound: part.bound.min(self.bound), ..part }), seen)
    }
}

/// The smallest, over the candidates, of the largest distance of a corner.
pub fn bound_by(corners: [DVec3; 3], candidates: &[u32], to: &Target) -> f64 {
    let largest = |candidate: u32| {
        let target = to.corners(candidate);
        corners.iter().map(|&c| c.distance_squared(closest_on_triangle(c, target))).fold(0.0, f64::max)
    };
    let is_first = |k: &usize| !candidates[..*k].contains(&candidates[*k]);
    let bounds = (0..candidates.len()).filter(is_first).map(|k| largest(candidates[k]));
    bounds.fold(f64::INFINITY, f64::min).sqrt()
}

/// Raises the lower bound of the maximum and lowers the upper one until they meet or the budget is spent.
pub fn narrow(
    bracket: &mut Bracket,
    from: &Target,
    to: &Target,
    at_vertices: &[Closest],
    budget: usize,
    context: &Context,
) -> Result<()> {
    let slack = MET * from.diagonal.max(to.diagonal);
    let mut open = first_parts(bracket, from, to, at_vertices, slack, context)?;
    let mut left = budget;
    loop {
        let limit = bracket.lower + slack;
        open.retain(|part| {
            if part.bound <= limit {
                bracket.upper = bracket.upper.max(part.bound);
            }
            part.bound > limit
        });
        if open.is_empty() || left == 0 {
            break;
        }
        // The largest bounds first; the sort is stable, so of equal ones the first.
        open.sort_by(|a, b| b.bound.total_cmp(&a.bound));
        let rest = open.split_off(open.len().min(TRIANGLES_PER_ROUND).min(left));
        left -= open.len();
        let divided = map_chunks(&open, context, |part, ()| part.quarters(to))?;
        open = rest;
        for (parts, seen) in divided {
            seen.iter().for_each(|&(point, distance)| bracket.see(point, distance));
            open.extend(parts);
        }
    }
    bracket.upper = open.iter().map(|part| part.bound).fold(bracket.upper.max(bracket.lower), f64::max);
    Ok(())
}

/// All triangles that what is known of their corners does not settle, bounded by their centres too.
pub fn first_parts(
    bracket: &mut Bracket,
    from: &Target,
    to: &Target,
    at_vertices: &[Closest],
    slack: f64,
    context: &Context,
) -> Result<Vec<Part>> {
    let mut closest_of = vec![0; from.points.len()];
    from.used.iter().zip(at_vertices).for_each(|(&v, found)| closest_of[v as usize] = found.triangle);
    let limit = bracket.lower + slack;
    // Of most triangles no more than the largest bound is kept: there may be millions.
    let chunks = of_chunks(&from.triangles, context, |triangles| {
        let (mut decided, mut open) = (0.0f64, Vec::new());
        for t in triangles {
            let part = Part::at_corners(t.map(|v| from.points[v as usize]), t.map(|v| closest_of[v as usize]), to);
            if part.bound <= limit {
                decided = decided.max(part.bound);
            } else {
                open.push(part.with_centre(to));
            }
        }
        (decided, open)
    })?;
    let mut parts = Vec::new();
    for (decided, open) in chunks {
        bracket.upper = bracket.upper.max(decided);
        for (part, distance) in open {
            bracket.see(part.centre(), distance);
            parts.push(part);
        }
    }
    Ok(parts)
}
