//! Triangles between surfaces: edges that smoothing, remeshing or a scanner rounded off are no faces. What is shallow and near
//! the surfaces beside it goes to these, each triangle to the one that it fits best:
//!
//! ```text
//!     ________            ________
//!             ╲       →           |      the rounded strip is divided where the two surfaces meet
//!              │                  │
//! ```

use super::expand::Energy;
use crate::context::Context;
use crate::error::Result;
use crate::geometry::normals::angle_between;
use crate::mesh::NONE;
use crate::segment::regions::{Groups, connected, count};
use crate::segment::surface::quantile;
use glam::DVec3;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// A count: regions of fewer triangles are no faces, because noise makes such regions.
const REGION_TRIANGLES: usize = 4;
/// A count: rings between the border of a region and its innermost triangle below which it is shallow, because rounded
/// edges have a few triangles across.
const SHALLOW_RINGS: u32 = 3;
/// A share of the triangles that are no deeper than the innermost ones, because a strip is wider in a few places.
const INNERMOST_QUANTILE: f64 = 0.95;
/// A share of the triangles of a shallow region near a surface beside it with which it is a rounded edge, because of a
/// narrow face only the corners are near.
const ROUNDED_SHARE: f64 = 0.75;
/// A share of an edge: those are no farther from the surface, because rounding by smoothing moves vertices by no more.
const ROUNDED_DISTANCE: f64 = 0.5;
/// A share of an edge: distance that costs 1, because that is how far smoothing moves vertices.
const UNIT_DISTANCE: f64 = 0.25;
/// Radians, 25°: turn that costs 1, because a triangle of a rounded edge turns about halfway to the next surface.
const UNIT_TURN: f64 = 0.44;
/// Radians, 40°: bend that costs 1, more because the bend of one edge says less than the turn against a surface.
const UNIT_BEND: f64 = 0.7;
/// What a triangle costs a free region that grows over it, in the same unit, because the surfaces beside it are to have
/// it first.
const GROWTH_PRICE: f64 = 4.0;
/// A count: rounds, because regions may be weak that were between weak ones.
const SETTLE_ROUNDS: usize = 3;

/// Dissolves rounded edges and crumbs, unless that leaves nothing. `fixed` triangles stay.
pub fn settle(energy: &Energy<'_>, label: &mut [u32], fixed: &[bool], order: &[u32], context: &Context) -> Result<()> {
    for _ in 0..SETTLE_ROUNDS {
        context.check()?;
        let pieces = Pieces::new(energy, label, fixed, order);
        let weak: Vec<bool> = (0..pieces.groups.len() as u32).map(|p| pieces.is_weak(p)).collect();
        if !weak.contains(&true) || !weak.contains(&false) {
            return Ok(());
        }
        let open: Vec<bool> = pieces.of.iter().map(|&p| weak[p as usize]).collect();
        spread(energy, label, open);
    }
    Ok(())
}

/// The connected pieces of a labelling.
struct Pieces<'a> {
    energy: &'a Energy<'a>,
    of: Vec<u32>,
    groups: Groups,
    label: Vec<u32>,
    fixed: Vec<bool>,
    /// Rings from the border to the innermost triangle.
    depth: Vec<u32>,
}

impl<'a> Pieces<'a> {
    fn new(energy: &'a Energy<'a>, label: &[u32], fixed: &[bool], order: &[u32]) -> Self {
        let of = connected(energy.surface, label, order);
        let groups = Groups::new(&of, count(&of));
        let first = |p: u32| groups.of(p)[0] as usize;
        let own = (0..groups.len() as u32).map(|p| label[first(p)]).collect();
        let held = (0..groups.len() as u32).map(|p| groups.of(p).iter().any(|&k| fixed[k as usize])).collect();
        let depth = depths(energy, &of, &groups);
        Pieces { energy, of, groups, label: own, fixed: held, depth }
    }

    fn is_free(&self, p: u32) -> bool {
        self.label[p as usize] as usize >= self.energy.models.len()
    }

    fn is_weak(&self, p: u32) -> bool {
        let members = self.groups.of(p);
        if self.fixed[p as usize] {
            return false;
        }
        if members.len() < REGION_TRIANGLES {
            return true;
        }
        if self.depth[p as usize] >= SHALLOW_RINGS {
            return false;
        }
        self.is_free(p) || self.near(p) >= ROUNDED_SHARE * members.len() as f64
    }

    /// Number of triangles of a piece that are near surfaces beside it all over, in the middle of a rounded edge not near the same
    /// ones. Of a narrow face the corners are near, the middles are not.
    fn near(&self, p: u32) -> f64 {
        let t = self.energy.surface.triangles;
        let mut beside: Vec<u32> = Vec::new();
        for o in self.groups.of(p).iter().flat_map(|&k| 3 * k..3 * k + 3).map(|c| t.opposite(c)).filter(|&o| o != NONE)
        {
            let q = self.of[o as usize / 3];
            let worthy =
                q != p && !self.is_free(q) && (self.depth[q as usize] >= SHALLOW_RINGS || self.fixed[q as usize]);
            if worthy && !beside.contains(&self.label[q as usize]) {
                beside.push(self.label[q as usize]);
            }
        }
        let reach = ROUNDED_DISTANCE * self.energy.noise.edge;
        let surfaces: Vec<_> = beside.iter().map(|&l| self.energy.models[l as usize].primitive).collect();
        let holds = |p: DVec3| surfaces.iter().any(|s| s.distance(p).abs() <= reach);
        let all_over = |k: u32| {
            let [a, b, c] = t.triangle(k).map(|v| t.points()[v as usize]);
            [a, b, c, (a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0, (a + b + c) / 3.0].into_iter().all(holds)
        };
        self.groups.of(p).iter().filter(|&&k| all_over(k)).count() as f64
    }
}

/// Rings of triangles between every triangle and the nearest border of its region.
pub fn rings(energy: &Energy<'_>, of: &[u32]) -> Vec<u32> {
    let t = energy.surface.triangles;
    let mut ring = vec![NONE; of.len()];
    let at_border =
        |k: u32| (3 * k..3 * k + 3).map(|c| t.opposite(c)).any(|o| o != NONE && of[o as usize / 3] != of[k as usize]);
    let mut front: Vec<u32> = (0..of.len() as u32).filter(|&k| at_border(k)).collect();
    front.iter().for_each(|&k| ring[k as usize] = 0);
    let mut level = 0;
    while !front.is_empty() {
        level += 1;
        let mut next = Vec::new();
        for &k in &front {
            for o in (3 * k..3 * k + 3).map(|c| t.opposite(c)).filter(|&o| o != NONE) {
                if ring[o as usize / 3] == NONE {
                    ring[o as usize / 3] = level;
                    next.push(o / 3);
                }
            }
        }
        front = next;
    }
    ring
}

/// Rings between the border of every piece and its innermost triangles; a piece without a border has no end.
fn depths(energy: &Energy<'_>, of: &[u32], groups: &Groups) -> Vec<u32> {
    let ring = rings(energy, of);
    let depth = |p: u32| {
        let mut all: Vec<u32> = groups.of(p).iter().map(|&k| ring[k as usize]).collect();
        quantile(&mut all, INNERMOST_QUANTILE, u32::cmp).unwrap_or_default()
    };
    (0..groups.len() as u32).map(depth).collect()
}

/// Lets the labels grow over the open triangles, the cheapest step first.
fn spread(energy: &Energy<'_>, label: &mut [u32], mut open: Vec<bool>) {
    let t = energy.surface.triangles;
    let mut queue: BinaryHeap<Reverse<(u64, u32, u32)>> = BinaryHeap::new();
    let offer = |k: u32, open: &[bool], l: u32, queue: &mut BinaryHeap<_>| {
        for c in 3 * k..3 * k + 3 {
            let o = t.opposite(c);
            if o != NONE && open[o as usize / 3] {
                let price = step_price(energy, o / 3, l, f64::from(energy.surface.bend[c as usize]));
                queue.push(Reverse((price.max(0.0).to_bits(), o / 3, l)));
            }
        }
    };
    for k in (0..label.len() as u32).filter(|&k| !open[k as usize]) {
        offer(k, &open, label[k as usize], &mut queue);
    }
    while let Some(Reverse((_, k, l))) = queue.pop() {
        if std::mem::replace(&mut open[k as usize], false) {
            label[k as usize] = l;
            offer(k, &open, l, &mut queue);
        }
    }
    open.iter().zip(label).filter(|(open, _)| **open).for_each(|(_, l)| *l = NONE);
}

fn step_price(energy: &Energy<'_>, k: u32, l: u32, bend: f64) -> f64 {
    let surface = energy.surface;
    let Some(model) = energy.models.get(l as usize) else { return GROWTH_PRICE };
    let p = surface.triangles.triangle(k).map(|v| surface.triangles.points()[v as usize]);
    let unit = UNIT_DISTANCE * energy.noise.edge;
    let far = p.iter().map(|&p| (model.primitive.distance(p) / unit).powi(2)).sum::<f64>() / 3.0;
    let turn =
        angle_between(surface.normals[k as usize], model.primitive.normal(surface.center(k)) * model.sign) / UNIT_TURN;
    far + turn * turn + (bend / UNIT_BEND).powi(2)
}
