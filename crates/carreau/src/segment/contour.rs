//! Contour following (§5.3): the paper's rectification of boundaries.
//!
//! Boundary edges with a good score stay (correct boundary edges); from their open ends the contour is continued by the
//! edge of least weight P until every contour is closed; the regions are then what the contours enclose.

use super::cut::BAND_RINGS;
use super::score::Scores;
use super::surface::Surface;
use crate::context::Context;
use crate::error::Result;
use crate::geometry::normals::angle_between;
use crate::mesh::NONE;
use rustc_hash::FxHashMap;
use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::f64::consts::PI;

/// w_J of equation 8, which has no unit: 1, because score and turn have about the same range.
const TURN_WEIGHT: f64 = 1.0;
/// Radians, 100°: a contour turns by no more at a vertex, because boundaries have right angles and no sharper ones.
const CONTOUR_TURN: f64 = 100.0 / 180.0 * PI;

/// An edge that may continue a contour at a vertex.
struct Potential {
    weight: f64,
    edge: u32,
    end: u32,
}

impl Ord for Potential {
    /// Reversed: the heap gives the least weight first.
    fn cmp(&self, other: &Self) -> Ordering {
        other.weight.total_cmp(&self.weight).then(other.edge.cmp(&self.edge)).then(other.end.cmp(&self.end))
    }
}
impl PartialOrd for Potential {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl PartialEq for Potential {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Potential {}

/// Rectifies the boundaries between labels; `limit` is ST. Returns the new labels.
pub fn follow(
    surface: &Surface<'_>,
    scores: &Scores<'_>,
    label: &[u32],
    limit: f64,
    context: &Context,
) -> Result<Vec<u32>> {
    let mut contours = Contours::new(surface, scores, label, limit);
    contours.close(context)?;
    contours.prune();
    contours.enclosed(label, context)
}

struct Contours<'a> {
    surface: &'a Surface<'a>,
    scores: &'a Scores<'a>,
    /// Per corner; both half-edges of an edge agree.
    correct: Vec<bool>,
    /// Number of correct edges at a vertex.
    degree: Vec<u32>,
    in_band: Vec<bool>,
    /// Edges at every vertex of the band, by their first corner.
    edges_at: FxHashMap<u32, Vec<u32>>,
}

impl<'a> Contours<'a> {
    fn new(surface: &'a Surface<'a>, scores: &'a Scores<'a>, label: &[u32], limit: f64) -> Self {
        let t = surface.triangles;
        let corners = 3 * t.len() as u32;
        let mut contours = Contours {
            surface,
            scores,
            correct: vec![false; corners as usize],
            degree: vec![0; t.points().len()],
            in_band: band(surface, label),
            edges_at: FxHashMap::default(),
        };
        let mut best: FxHashMap<(u32, u32), (f64, u32)> = FxHashMap::default();
        for c in 0..corners {
            let o = t.opposite(c);
            if o == NONE {
                contours.mark(c);
                continue;
            }
            let (a, b) = (label[c as usize / 3], label[o as usize / 3]);
            if o < c || a == b {
                continue;
            }
            let score = scores.score(c);
            if score < limit {
                contours.mark(c);
            }
            let entry = best.entry((a.min(b), a.max(b))).or_insert((score, c));
            if score < entry.0 {
                *entry = (score, c);
            }
        }
        // A pair of regions without a single correct edge would vanish.
        let mut kept: Vec<u32> = best.into_values().map(|(_, c)| c).collect();
        kept.sort_unstable();
        kept.into_iter().for_each(|c| contours.mark(c));
        for c in (0..corners).filter(|&c| t.opposite(c) == NONE || c < t.opposite(c)) {
            let o = t.opposite(c);
            if contours.in_band[c as usize / 3] || (o != NONE && contours.in_band[o as usize / 3]) {
                for v in [t.vertex(c), t.vertex(t.next(c))] {
                    contours.edges_at.entry(v).or_default().push(c);
                }
            }
        }
        contours
    }

    fn mark(&mut self, c: u32) {
        if !self.correct[c as usize] {
            self.set(c, true);
            self.ends(c).into_iter().for_each(|v| self.degree[v as usize] += 1);
        }
    }

    fn unmark(&mut self, c: u32) {
        self.set(c, false);
        self.ends(c).into_iter().for_each(|v| self.degree[v as usize] -= 1);
    }

    fn set(&mut self, c: u32, to: bool) {
        self.correct[c as usize] = to;
        let o = self.surface.triangles.opposite(c);
        if o != NONE {
            self.correct[o as usize] = to;
        }
    }

    fn ends(&self, c: u32) -> [u32; 2] {
        let t = self.surface.triangles;
        [t.vertex(c), t.vertex(t.next(c))]
    }

    /// The only correct edge at an open end.
    fn last(&self, v: u32) -> Option<u32> {
        self.edges_at.get(&v)?.iter().copied().find(|&c| self.correct[c as usize])
    }

    /// The edges that may continue the contour that ends at `v`.
    fn potentials(&self, v: u32, out: &mut BinaryHeap<Potential>) {
        let (Some(last), Some(edges)) = (self.last(v), self.edges_at.get(&v)) else { return };
        let points = self.surface.triangles.points();
        let away = |c: u32| {
            let [a, b] = self.ends(c);
            points[(a + b - v) as usize] - points[v as usize]
        };
        let back = away(last);
        for &edge in edges.iter().filter(|&&c| !self.correct[c as usize]) {
            let turn = angle_between(-back, away(edge));
            if turn <= CONTOUR_TURN {
                let weight = self.scores.score(edge) + TURN_WEIGHT * turn / PI;
                out.push(Potential { weight, edge, end: v });
            }
        }
    }

    /// Continues every open contour until it meets another.
    fn close(&mut self, context: &Context) -> Result<()> {
        let mut heap = BinaryHeap::new();
        let mut open: Vec<u32> = self.edges_at.keys().copied().filter(|&v| self.degree[v as usize] == 1).collect();
        open.sort_unstable();
        open.into_iter().for_each(|v| self.potentials(v, &mut heap));
        let mut step = 0;
        while let Some(Potential { edge, end, .. }) = heap.pop() {
            context.check_every(step)?;
            step += 1;
            if self.degree[end as usize] != 1 || self.correct[edge as usize] {
                continue;
            }
            self.mark(edge);
            let [a, b] = self.ends(edge);
            let far = a + b - end;
            if self.degree[far as usize] == 1 {
                self.potentials(far, &mut heap);
            }
        }
        Ok(())
    }

    /// Removes contours that still end openly.
    fn prune(&mut self) {
        let mut loose: Vec<u32> = self.edges_at.keys().copied().filter(|&v| self.degree[v as usize] == 1).collect();
        while let Some(v) = loose.pop() {
            if self.degree[v as usize] != 1 {
                continue;
            }
            let Some(c) = self.last(v) else { continue };
            if self.surface.triangles.opposite(c) == NONE {
                continue;
            }
            let [a, b] = self.ends(c);
            self.unmark(c);
            loose.push(a + b - v);
        }
    }

    /// The parts between contours, each with the old label of most of its area.
    fn enclosed(&self, label: &[u32], context: &Context) -> Result<Vec<u32>> {
        let mut new = vec![NONE; label.len()];
        let (mut stack, mut part) = (Vec::new(), Vec::new());
        let mut area: FxHashMap<u32, f64> = FxHashMap::default();
        for seed in 0..label.len() as u32 {
            context.check_every(seed as usize)?;
            if new[seed as usize] != NONE {
                continue;
            }
            part.clear();
            area.clear();
            stack.push(seed);
            new[seed as usize] = 0;
            while let Some(t) = stack.pop() {
                part.push(t);
                *area.entry(label[t as usize]).or_default() += self.surface.areas[t as usize];
                for n in (3 * t..3 * t + 3).filter_map(|c| self.surface.across(c, &self.correct)) {
                    if new[n as usize] == NONE {
                        new[n as usize] = 0;
                        stack.push(n);
                    }
                }
            }
            let most = area.iter().max_by(|a, b| a.1.total_cmp(b.1).then(b.0.cmp(a.0))).map_or(NONE, |x| *x.0);
            part.iter().for_each(|&t| new[t as usize] = most);
        }
        Ok(new)
    }
}

/// The triangles within some rings of a boundary between labels.
fn band(surface: &Surface<'_>, label: &[u32]) -> Vec<bool> {
    let t = surface.triangles;
    let differs = |c: u32| t.opposite(c) == NONE || label[t.opposite(c) as usize / 3] != label[c as usize / 3];
    let mut inside: Vec<bool> = (0..t.len() as u32).map(|k| (3 * k..3 * k + 3).any(differs)).collect();
    let mut front: Vec<u32> = (0..t.len() as u32).filter(|&k| inside[k as usize]).collect();
    for _ in 1..BAND_RINGS {
        let mut next = Vec::new();
        for n in
            front.iter().flat_map(|&k| 3 * k..3 * k + 3).map(|c| t.opposite(c)).filter(|&o| o != NONE).map(|o| o / 3)
        {
            if !inside[n as usize] {
                inside[n as usize] = true;
                next.push(n);
            }
        }
        front = next;
    }
    inside
}
