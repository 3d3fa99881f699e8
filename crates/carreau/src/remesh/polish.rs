//! The worst first: whatever makes a bad triangle or a bad edge better is done.
//!
//! Goodness of a cavity: the smaller of its worst shape over 0.7 and its worst length quality over 0.63. An operation is
//! accepted if that rises. Of constraint (1) only the hard cap is left: it holds for the few, not for the mean.

use super::curves::Rank;
use super::size::{length_between, length_quality};
use super::work::Work;
use crate::context::Context;
use crate::error::Result;
use crate::mesh::{Keep, NONE};
use glam::DVec3;

/// Shape that is good enough.
const POLISHED_SHAPE: f64 = 0.7;
/// Quality of a length, 1 at length one in the metric, that is good enough.
const GOOD_LENGTH: f64 = 0.63;
/// Triangles below this are worth a search among the neighbours, too.
const POOR: f64 = 0.9;
/// Sweeps over the poor triangles.
const POLISHING_SWEEPS: usize = 6;
/// Judgements for every triangle of the mesh before the worst are left as they are.
const EFFORT: usize = 150;
/// Places that a vertex tries at most.
const PLACES: usize = 40;
/// Neighbours that are moved for the sake of one triangle.
const LARGEST_RING: usize = 32;

impl Work<'_> {
    /// Treats bad triangles and edges, the worst first, in a few sweeps.
    pub fn polish(&mut self, context: &Context) -> Result<()> {
        let allowed = std::mem::replace(&mut self.limits.cos_allowed, self.limits.cos_cap);
        let done = self.polish_within_cap(context);
        self.limits.cos_allowed = allowed;
        done
    }

    fn polish_within_cap(&mut self, context: &Context) -> Result<()> {
        // A vertex of many triangles costs as many judgements for every place that is tried.
        let mut effort = EFFORT * self.mesh.triangle_count();
        for _ in 0..POLISHING_SWEEPS {
            let mut bad = self.bad_triangles();
            bad.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            let mut done = 0;
            for (step, &(_, t)) in bad.iter().enumerate() {
                context.check_every(16 * step)?;
                if self.mesh.is_triangle(t) && self.triangle_goodness(t) < 1.0 {
                    let valences = self.mesh.triangle(t).map(|v| self.mesh.around(v).count());
                    let cost = PLACES * valences.iter().sum::<usize>();
                    if cost > effort {
                        return Ok(());
                    }
                    effort -= cost;
                    done += usize::from(self.better(t));
                }
            }
            if done == 0 {
                break;
            }
        }
        Ok(())
    }

    fn bad_triangles(&self) -> Vec<(f64, u32)> {
        (0..self.mesh.triangle_slots())
            .filter(|&t| self.mesh.is_triangle(t))
            .map(|t| (self.triangle_goodness(t), t))
            .filter(|&(g, _)| g < 1.0)
            .collect()
    }

    fn triangle_goodness(&self, t: u32) -> f64 {
        let shape = f64::from(self.face[t as usize].shape) / POLISHED_SHAPE;
        (3 * t..3 * t + 3).map(|h| length_quality(self.edge_length(h)) / GOOD_LENGTH).fold(shape, f64::min)
    }

    /// Goodness of all triangles around a vertex.
    fn goodness_around(&self, v: u32) -> f64 {
        self.mesh.around(v).map(|h| self.triangle_goodness(h / 3)).fold(f64::INFINITY, f64::min)
    }

    /// Makes a triangle better by the first means that helps.
    fn better(&mut self, t: u32) -> bool {
        let mut sides = [3 * t, 3 * t + 1, 3 * t + 2];
        sides.sort_by(|&a, &b| self.edge_length(b).total_cmp(&self.edge_length(a)));
        let [long, middle, short] = sides;
        if sides.iter().any(|&side| self.try_swap(side, 1.02)) {
            return true;
        }
        let corners = self.mesh.triangle(t);
        let mut moved = false;
        for v in corners {
            moved |= self.search_vertex(v);
        }
        if self.mesh.is_triangle(t) && self.triangle_goodness(t) >= 1.0 {
            return true;
        }
        // Of an ear the shortest side may be the one that stays.
        if self.collapse_if_better(short)
            || (corners.iter().any(|&v| self.is_ear(v)) && self.collapse_if_better(middle))
        {
            return true;
        }
        if self.mesh.is_triangle(t) && self.triangle_goodness(t) < POOR {
            moved |= self.search_around(corners);
        }
        moved | (self.mesh.is_half_edge(long) && self.split_if_better(long))
    }

    /// Moves the neighbours of a bad triangle, too, then its own corners once more.
    fn search_around(&mut self, corners: [u32; 3]) -> bool {
        let mut ring = Vec::new();
        for v in corners {
            self.mesh.for_neighbours(v, |w| ring.push(w));
        }
        ring.sort_unstable();
        ring.dedup();
        ring.truncate(LARGEST_RING);
        ring.extend(corners);
        ring.into_iter().fold(false, |moved, v| moved | self.search_vertex(v))
    }

    /// Collapses an edge if the cavity gets better.
    fn collapse_if_better(&mut self, h: u32) -> bool {
        if !self.mesh.is_half_edge(h) || self.mesh.check_collapse(h).is_err() {
            return false;
        }
        let (a, b) = (self.mesh.vertex(h), self.mesh.head(h));
        let before = self.goodness_around(a).min(self.goodness_around(b));
        for keep in [Keep::Head, Keep::Tail] {
            let (gone, _) = self.mesh.gone_and_kept(h, keep);
            let goodness = self.goodness_after(h, keep);
            // Of an ear nothing is left: as good is better.
            let gain = if self.is_ear(gone) { -1e-9 } else { 1e-3 };
            if self.rank[gone as usize] != Rank::Corner && goodness > before + gain {
                self.collapse(h, keep);
                return true;
            }
        }
        false
    }

    /// Goodness of the cavity after a collapse; negative where it is not allowed.
    fn goodness_after(&self, h: u32, keep: Keep) -> f64 {
        use super::decimate::Demand;
        let demand = Demand { good_length: 0.0, longest: f64::INFINITY, least_shape: 0.0, ears: true };
        if !self.may_go(h, keep) {
            return -1.0;
        }
        let Some(shape) = self.try_collapse(h, keep, &demand) else { return -1.0 };
        let (gone, kept) = self.mesh.gone_and_kept(h, keep);
        let mut worst = f64::from(shape) / POLISHED_SHAPE;
        self.mesh.for_neighbours(gone, |w| {
            if w != kept {
                worst = worst.min(length_quality(self.length(kept, w)) / GOOD_LENGTH);
            }
        });
        worst
    }

    /// Splits an edge if its triangles get better, with the new vertex moved to its best place.
    fn split_if_better(&mut self, h: u32) -> bool {
        if self.edge_length(h) < 1.25 {
            return false;
        }
        let o = self.mesh.opposite(h);
        let before =
            self.triangle_goodness(h / 3).min(if o == NONE { f64::INFINITY } else { self.triangle_goodness(o / 3) });
        let (a, b) = (self.mesh.vertex(h), self.mesh.head(h));
        let t = {
            let (x, y) = (self.size[a as usize].sqrt(), self.size[b as usize].sqrt());
            x / (x + y)
        };
        let p = self.point(a).lerp(self.point(b), t);
        let mut worst = f64::INFINITY;
        let metric = if self.size[a as usize] > self.size[b as usize] { self.metric(a) } else { self.metric(b) };
        for side in [h, o].into_iter().filter(|&s| s != NONE) {
            let c = self.mesh.apex(side);
            let stretches = self.stretches([a, b, c]);
            let shape =
                |q| f64::from(self.judge([q, p, self.point(c)], [DVec3::ZERO; 3], stretches).shape) / POLISHED_SHAPE;
            let l = length_between(self.point(c) - p, metric, self.metric(c));
            worst = worst.min(shape(self.point(a))).min(shape(self.point(b))).min(length_quality(l) / GOOD_LENGTH);
        }
        worst = worst.min(length_quality(0.5 * self.edge_length(h)) / GOOD_LENGTH);
        worst > before + 1e-3 && self.split(h).is_some()
    }
}
