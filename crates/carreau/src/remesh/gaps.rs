//! Moves vertices to where the surface is farthest from the mesh.
//!
//! The size map knows how large triangles may be, not where their vertices lie: on a soft edge, bent by less than the
//! feature angle, a vertex beside it leaves a gap that one upon it closes.
//!
//! ```text
//!         ╱•╲  gap                 •
//!     •──────────•      →       ╱     ╲        the source above, the mesh below
//!                             •         •
//! ```
//!
//! The source vertices with the largest gaps draw a free vertex of the triangle next to them, if the largest gap of all
//! that this triangle and its neighbours stand for becomes smaller. Where none can be drawn, a few triangles may get one.

use super::curves::Rank;
use super::relocate::Accept;
use super::work::Work;
use crate::context::Context;
use crate::error::Result;
use crate::geometry::closest::closest_on_triangle;
use crate::geometry::search_tree::TriangleTree;
use crate::mesh::{NONE, next, previous};
use glam::DVec3;
use rayon::prelude::*;
use std::iter::successors;

/// Rounds with new gaps.
const GAP_ROUNDS: usize = 4;
/// Gaps above this share of the largest are closed in a round.
const LARGE: f64 = 0.75;
/// The largest gap of a ball must fall to this share: a move that costs shapes has to be worth it.
const GAP_KEPT: f64 = 0.65;
/// The worse of two shapes may fall by this factor in a flip.
const FLIP_LOSS: f32 = 0.6;
/// New triangles, as a share of those there are.
pub const ADDED: f64 = 0.003;

/// Which source vertices every triangle stands for.
struct Gaps {
    /// Closest triangle of every source vertex, and the distance.
    of: Vec<(u32, f64)>,
    /// The source vertices of every triangle in a row: the last of them, and the one before each.
    last: Vec<u32>,
    before: Vec<u32>,
}

impl Gaps {
    /// Puts a source vertex to its triangle.
    fn put(&mut self, s: u32) {
        let t = self.of[s as usize].0 as usize;
        self.before[s as usize] = std::mem::replace(&mut self.last[t], s);
    }

    /// The source vertices that triangles stand for.
    fn under(&self, triangles: &[u32]) -> Vec<u32> {
        let some = |s: u32| (s != NONE).then_some(s);
        let row = |&t: &u32| successors(some(self.last[t as usize]), move |&s| some(self.before[s as usize]));
        triangles.iter().flat_map(row).collect()
    }

    /// Source vertices that triangles stood for find their place anew among them.
    fn seat(&mut self, triangles: &[u32], below: &[u32], closest: &[(u32, f64)]) {
        triangles.iter().for_each(|&t| self.last[t as usize] = NONE);
        for (&s, &found) in below.iter().zip(closest) {
            self.of[s as usize] = found;
            self.put(s);
        }
    }
}

impl Work<'_> {
    /// Moves free vertices to the source vertices that are farthest from the mesh.
    pub fn close_gaps(&mut self, context: &Context) -> Result<()> {
        let most = ((1.0 + ADDED) * self.mesh.triangle_count() as f64) as usize;
        for _ in 0..GAP_ROUNDS {
            let mut gaps = self.gaps();
            context.check()?;
            let largest = gaps.of.iter().map(|g| g.1).fold(0.0, f64::max);
            let mut open: Vec<u32> =
                (0..gaps.of.len() as u32).filter(|&s| gaps.of[s as usize].1 > LARGE * largest).collect();
            open.sort_by(|&a, &b| gaps.of[b as usize].1.total_cmp(&gaps.of[a as usize].1).then(a.cmp(&b)));
            let mut done = 0;
            for (step, s) in open.into_iter().enumerate() {
                context.check_every(step)?;
                if gaps.of[s as usize].1 > LARGE * largest {
                    let room = self.mesh.triangle_count() + 2 <= most;
                    done += usize::from(self.close(s, &mut gaps) || (room && self.insert(s, &mut gaps)));
                }
            }
            if done == 0 {
                break;
            }
        }
        Ok(())
    }

    fn gaps(&self) -> Gaps {
        let mesh = &self.mesh;
        let live: Vec<u32> = (0..mesh.triangle_slots()).filter(|&t| mesh.is_triangle(t)).collect();
        let triangles: Vec<[u32; 3]> = live.iter().map(|&t| mesh.triangle(t)).collect();
        let tree = TriangleTree::new(&mesh.points, &triangles);
        let source = &self.support.mesh;
        let closest = |s: u32| match tree.closest(source.points[s as usize]) {
            Some(c) if source.is_vertex(s) => (live[c.triangle as usize], c.distance()),
            _ => (NONE, 0.0),
        };
        let of: Vec<(u32, f64)> = (0..source.vertex_slots()).into_par_iter().map(closest).collect();
        let (last, before) = (vec![NONE; mesh.triangle_slots() as usize], vec![NONE; of.len()]);
        let mut gaps = Gaps { of, last, before };
        for s in 0..gaps.of.len() as u32 {
            if gaps.of[s as usize].0 != NONE {
                gaps.put(s);
            }
        }
        gaps
    }

    /// Draws a corner of the triangle below a source vertex to it, the nearest that helps.
    fn close(&mut self, s: u32, gaps: &mut Gaps) -> bool {
        let p = self.support.mesh.points[s as usize];
        let below = gaps.of[s as usize].0;
        if (3 * below..3 * below + 3).any(|h| self.flip_towards(h, gaps)) {
            return true;
        }
        let mut corners = self.mesh.triangle(below);
        corners.sort_by(|&a, &b| self.point(a).distance(p).total_cmp(&self.point(b).distance(p)).then(a.cmp(&b)));
        corners.into_iter().any(|v| self.rank[v as usize] == Rank::Free && self.draw(v, p, gaps))
    }

    /// Flips an edge if the largest gap of its two triangles becomes smaller.
    fn flip_towards(&mut self, h: u32, gaps: &mut Gaps) -> bool {
        let o = self.mesh.opposite(h);
        if o == NONE || self.mesh.curve(h) != NONE {
            return false;
        }
        let pair = [h / 3, o / 3];
        let [a, b, c, d] = [h, next(h), previous(h), previous(o)].map(|x| self.point(self.mesh.vertex(x)));
        let below = gaps.under(&pair);
        let largest = |gap: &dyn Fn(u32) -> f64| below.iter().map(|&s| gap(s)).fold(0.0, f64::max);
        let flipped = |s: u32| {
            let p = self.support.mesh.points[s as usize];
            [[c, d, b], [d, c, a]]
                .map(|t| closest_on_triangle(p, t).distance(p))
                .into_iter()
                .fold(f64::INFINITY, f64::min)
        };
        let helps = largest(&flipped) < GAP_KEPT * largest(&|s| gaps.of[s as usize].1);
        if !(helps && self.try_swap(h, FLIP_LOSS)) {
            return false;
        }
        let now = self.closest_of(&pair, &below);
        gaps.seat(&pair, &below, &now);
        true
    }

    /// Moves a free vertex to a point, or half way, if the largest gap of its triangles becomes smaller.
    fn draw(&mut self, v: u32, p: DVec3, gaps: &mut Gaps) -> bool {
        let ring: Vec<u32> = self.mesh.around(v).map(|h| h / 3).collect();
        let below = gaps.under(&ring);
        let Some(first) = self.mesh.around(v).next() else { return false };
        let wedge = self.mesh.wedge(first);
        let before = below.iter().map(|&s| gaps.of[s as usize].1).fold(0.0, f64::max);
        let kept = (self.point(v), self.metric(v), self.normal[wedge as usize], self.seat[wedge as usize]);
        let ball = self.ball(v);
        for share in [1.0, 0.5] {
            let found = self.try_free(v, wedge, kept.0.lerp(p, share), &ball, Accept::Harmless);
            if !self.go(v, found) {
                continue;
            }
            let now = self.closest_of(&ring, &below);
            if now.iter().map(|g| g.1).fold(0.0, f64::max) < GAP_KEPT * before {
                gaps.seat(&ring, &below, &now);
                return true;
            }
            self.mesh.points[v as usize] = kept.0;
            self.set_metric(v, kept.1);
            (self.normal[wedge as usize], self.seat[wedge as usize]) = (kept.2, kept.3);
            self.refresh_around(v);
        }
        false
    }

    /// Splits the longest edge of the triangle below a source vertex that is on no curve, and draws the new vertex there.
    fn insert(&mut self, s: u32, gaps: &mut Gaps) -> bool {
        let below = gaps.of[s as usize].0;
        let inner = (3 * below..3 * below + 3).filter(|&h| self.mesh.curve(h) == NONE && self.mesh.opposite(h) != NONE);
        let length = |h: &u32| self.point(self.mesh.vertex(*h)).distance(self.point(self.mesh.head(*h)));
        let Some(h) = inner.max_by(|a, b| length(a).total_cmp(&length(b))) else { return false };
        let above = gaps.under(&[h / 3, self.mesh.opposite(h) / 3]);
        let Some(m) = self.split(h) else { return false };
        gaps.last.resize(self.mesh.triangle_slots() as usize, NONE);
        let ring: Vec<u32> = self.mesh.around(m).map(|h| h / 3).collect();
        let now = self.closest_of(&ring, &above);
        gaps.seat(&ring, &above, &now);
        self.draw(m, self.support.mesh.points[s as usize], gaps);
        true
    }

    /// The closest of some triangles to every one of some source vertices, and the distance.
    fn closest_of(&self, triangles: &[u32], below: &[u32]) -> Vec<(u32, f64)> {
        let closest = |&s: &u32| {
            let p = self.support.mesh.points[s as usize];
            let distance = |&t: &u32| (t, closest_on_triangle(p, self.mesh.positions(t)).distance(p));
            triangles.iter().map(distance).min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((NONE, f64::INFINITY))
        };
        below.iter().map(closest).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::remesh::RemeshOptions;
    use crate::remesh::source::Source;
    use crate::sample;

    #[test]
    fn the_largest_gap_becomes_smaller_and_nothing_folds() {
        let context = Context::new();
        let mesh = sample::make("rounded-box", None, &context).unwrap().triangulated().unwrap();
        let options = RemeshOptions { deviation: 30.0, ..RemeshOptions::default() };
        let mut source = Source::new(&mesh, &options, &context).unwrap();
        source.set_sizes(&options, &context).unwrap();
        let mut work = source.at_work(&options);
        work.adapt(None, &context).unwrap();
        // A vertex astray leaves a gap.
        let v = (0..work.mesh.vertex_slots())
            .find(|&v| work.mesh.is_vertex(v) && work.rank[v as usize] == Rank::Free)
            .unwrap();
        let wedge = work.mesh.wedge(work.mesh.around(v).next().unwrap()) as usize;
        work.mesh.points[v as usize] -= work.normal[wedge] * 0.2 * work.size[v as usize];
        work.refresh_around(v);
        let largest = |work: &Work| work.gaps().of.iter().map(|g| g.1).fold(0.0, f64::max);
        let before = largest(&work);
        work.close_gaps(&context).unwrap();
        assert!(largest(&work) < 0.8 * before, "{} of {before}", largest(&work));
        let turned = |t: u32| work.mesh.is_triangle(t) && work.face[t as usize].cosine <= 0.0;
        assert!(!(0..work.mesh.triangle_slots()).any(turned));
    }
}
