//! Collapses edges that are too short, shortest first, under the paper's three constraints:
//!
//! (1) ⟨ν(K), νᵢ(K)⟩ ≥ τ for every new triangle K and each of its corners,
//! (2) Q_l(AC′) > Q_l(BC′) for every edge BC′ that is replaced by AC′,
//! (4) Q′ ≥ 0.6 Q for the worst shapes of the cavity after and before.
//!
//! Where this departs from the paper: (1) is tested against the smaller of τ and the cavity's own worst, down to a hard
//! cap. On a sphere a triangle of length 1 deviates by asin(2 sin θ / √3) > θ, so that the strict test would keep all
//! edges below √3/2; and no choice of collapses removes the noise that a scan brings along.

use super::buckets::Buckets;
use super::curves::Rank;
use super::size::length_quality;
use super::work::{Face, Work};
use crate::context::Context;
use crate::error::Result;
use crate::mesh::{Keep, NONE, next, previous};

/// Shapes may fall by this factor: six equilateral triangles can just be retriangulated from their rim.
const SHAPE_LOSS: f32 = 0.6 - 1e-6;
/// Buckets per octave of length, as a power of two.
const LENGTH_BITS: u32 = 3;
/// Octaves of length that have buckets of their own.
const LENGTH_OCTAVES: u16 = 16;
/// Rounds over all edges.
const DECIMATION_ROUNDS: usize = 2;

/// What a collapse must respect besides constraint (1).
#[derive(Debug, Clone, Copy)]
pub struct Demand {
    /// A replaced edge may get any length whose quality is at least this, instead of a better one as constraint (2)
    /// demands; above 1: constraint (2) alone.
    pub good_length: f64,
    /// No new edge may be longer than this.
    pub longest: f64,
    /// No shape may fall below this, unless it was as low before.
    pub least_shape: f32,
    /// Ears may go: a border triangle with one neighbour, if the border stays within its tolerance.
    pub ears: bool,
}

impl Work<'_> {
    /// Collapses edges shorter than `limit`, shortest first, while there are more than `most` triangles. Returns how many.
    pub fn decimate(&mut self, limit: f64, demand: &Demand, most: usize, context: &Context) -> Result<usize> {
        let mut queue = Buckets::new(self.mesh.half_edge_slots(), limit, LENGTH_BITS, LENGTH_OCTAVES);
        let mut done = 0;
        // What was refused is asked again only where it is next to a collapse; one more round asks the others.
        for _ in 0..DECIMATION_ROUNDS {
            for h in self.mesh.edges() {
                queue.push(h, self.edge_length(h));
            }
            let collapsed = self.collapse_queued(&mut queue, demand, most, context)?;
            done += collapsed;
            if collapsed == 0 {
                break;
            }
        }
        Ok(done)
    }

    /// Collapses what a queue of edges holds, and adds what changes on the way. Returns how many.
    fn collapse_queued(
        &mut self,
        queue: &mut Buckets,
        demand: &Demand,
        most: usize,
        context: &Context,
    ) -> Result<usize> {
        let (mut done, mut step) = (0, 0);
        while self.mesh.triangle_count() > most
            && let Some(h) = queue.pop()
        {
            step += 1;
            context.check_every(step)?;
            if !self.mesh.is_edge(h) {
                continue;
            }
            let Some(keep) = self.best_collapse(h, demand) else { continue };
            let kept = self.collapse(h, keep);
            done += 1;
            let mesh = &self.mesh;
            let mut push = |h: u32| queue.push(h.min(mesh.opposite(h)), self.edge_length(h));
            for h in mesh.around(kept) {
                push(h);
                // The sides opposite to the vertex have lost a neighbour: what was refused there may be allowed now.
                push(next(h));
                // On a border the last edge is that of another half-edge.
                if mesh.opposite(previous(h)) == NONE {
                    push(previous(h));
                }
            }
        }
        Ok(done)
    }

    /// The better of the two allowed ways to collapse an edge.
    pub fn best_collapse(&self, h: u32, demand: &Demand) -> Option<Keep> {
        let ways = [Keep::Head, Keep::Tail];
        let shapes = ways.map(|keep| if self.may_go(h, keep) { self.try_collapse(h, keep, demand) } else { None });
        let keep = match shapes {
            [Some(a), Some(b)] if b > a => Keep::Tail,
            [Some(_), _] => Keep::Head,
            [None, Some(_)] => Keep::Tail,
            [None, None] => return None,
        };
        self.mesh.check_collapse(h).is_ok().then_some(keep)
    }

    /// Whether the rank of the vertex that goes allows it.
    pub fn may_go(&self, h: u32, keep: Keep) -> bool {
        let (gone, kept) = self.mesh.gone_and_kept(h, keep);
        match self.rank[gone as usize] {
            _ if self.mesh.joins_copies(h, keep) => false,
            Rank::Free => true,
            Rank::Curve => self.mesh.curve(h) != NONE && self.rank[kept as usize] >= Rank::Curve,
            Rank::Corner => false,
        }
    }

    /// The worst shape after a collapse, if the constraints allow it.
    pub fn try_collapse(&self, h: u32, keep: Keep, demand: &Demand) -> Option<f32> {
        let mesh = &self.mesh;
        let (gone, kept) = mesh.gone_and_kept(h, keep);
        let o = mesh.opposite(h);
        let p = self.point(kept);
        let (side_h, side_o) = (h / 3, if o == NONE { NONE } else { o / 3 });
        let (left_triangle, right_triangle) = if keep == Keep::Head { (side_h, side_o) } else { (side_o, side_h) };
        let [left, right] = self.wedges_beside(kept, [left_triangle, right_triangle])?;
        let apexes = [mesh.apex(h), if o == NONE { NONE } else { mesh.apex(o) }];
        // Lengths come first: they are what forbids most collapses, and the soonest known.
        let stays = |w: u32| w == kept || apexes.contains(&w);
        let holds = |w: u32| stays(w) || self.edge_becomes_better(gone, kept, w, demand);
        if !mesh.around(gone).all(|g| holds(mesh.head(g))) {
            return None;
        }

        let mut before = Face { shape: f32::INFINITY, cosine: f32::INFINITY };
        let mut after = before;
        let on_curve = self.rank[gone as usize] == Rank::Curve;
        // Counter-clockwise from the left triangle; behind the next curve comes the right side.
        let first = self.corner_in(left_triangle, gone)?;
        let mut at = if first == NONE || mesh.is_border(gone) { mesh.around(gone).next()? } else { first };
        let begin = at;
        let mut wedge = if first == NONE { right } else { left };
        loop {
            if at != begin && on_curve && mesh.curve(at) != NONE && o != NONE {
                wedge = right;
            }
            let t = at / 3;
            let old = self.face[t as usize];
            before.shape = before.shape.min(old.shape);
            before.cosine = before.cosine.min(old.cosine);
            if t != side_h && t != side_o {
                let (b, c) = (next(at), previous(at));
                let (vb, vc) = (mesh.vertex(b), mesh.vertex(c));
                let normals = [wedge, mesh.wedge(b), mesh.wedge(c)].map(|w| self.normal[w as usize]);
                let new = self.judge([p, self.point(vb), self.point(vc)], normals, self.stretches([kept, vb, vc]));
                after.shape = after.shape.min(new.shape);
                after.cosine = after.cosine.min(new.cosine);
                if new.shape < SHAPE_LOSS * before.shape && new.shape < demand.least_shape && new.shape < 0.3 {
                    return None;
                }
            }
            match mesh.opposite(c_before(at)) {
                NONE if !holds(mesh.vertex(c_before(at))) => return None,
                NONE => break,
                turned if turned == begin => break,
                turned => at = turned,
            }
        }
        let shape_holds = after.shape >= SHAPE_LOSS * before.shape
            && (after.shape >= demand.least_shape || after.shape >= before.shape);
        let holds = shape_holds
            && self.allows_cosine(after.cosine, before.cosine)
            && (!on_curve || self.curve_collapse_holds(h, gone, kept, demand))
            && self.strain_allows(gone, p, kept);
        holds.then_some(after.shape)
    }

    /// The corner of a triangle at a vertex; none where there is no triangle.
    #[inline]
    fn corner_in(&self, triangle: u32, vertex: u32) -> Option<u32> {
        if triangle == NONE {
            return Some(NONE);
        }
        (3 * triangle..3 * triangle + 3).find(|&c| self.mesh.vertex(c) == vertex)
    }

    /// Wedges of the kept vertex left and right of the edge, seen from the vertex that goes, by the triangles there; at a border
    /// both are the same.
    #[inline]
    fn wedges_beside(&self, kept: u32, triangles: [u32; 2]) -> Option<[u32; 2]> {
        let mesh = &self.mesh;
        let wedge_in = |t: u32| (3 * t..3 * t + 3).find(|&c| mesh.vertex(c) == kept).map(|c| mesh.wedge(c));
        let [left, right] = triangles.map(|t| if t == NONE { None } else { wedge_in(t) });
        Some([left.or(right)?, right.or(left)?])
    }

    #[inline]
    fn edge_becomes_better(&self, gone: u32, kept: u32, other: u32, demand: &Demand) -> bool {
        let new = self.length(kept, other);
        if new > demand.longest {
            return false;
        }
        let quality = length_quality(new);
        quality >= demand.good_length || quality > length_quality(self.length(gone, other))
    }

    /// Whether a vertex is the tip of a border triangle with one neighbour.
    pub fn is_ear(&self, v: u32) -> bool {
        self.mesh.is_border(v) && self.mesh.around(v).take(2).count() == 1
    }

    /// The curve on the other side of the vertex that goes gets a longer edge: does that hold?
    fn curve_collapse_holds(&self, h: u32, gone: u32, kept: u32, demand: &Demand) -> bool {
        let mesh = &self.mesh;
        let Some((chain, own)) = self.on_chain(h) else { return false };
        let mut other = NONE;
        let mut visit = |g: u32, w: u32| {
            if mesh.curve(g) != NONE && w != kept {
                other = w;
            }
        };
        let mut last = NONE;
        for g in mesh.around(gone) {
            visit(g, mesh.head(g));
            last = previous(g);
        }
        if last != NONE && mesh.opposite(last) == NONE {
            visit(last, mesh.vertex(last));
        }
        if other == NONE || other == kept {
            return false;
        }
        // An ear: the edge would fall upon one that is a curve already.
        if mesh.half_edge(kept, other).or(mesh.half_edge(other, kept)).is_some_and(|g| mesh.curve(g) != NONE) {
            return false;
        }
        // From the kept vertex over the one that goes to the other, so that no turn is lost.
        let at_gone = if mesh.vertex(h) == gone { [own[0], own[1]] } else { [own[1], own[0]] };
        let onward = self.span(chain, gone, other);
        let span = [at_gone[1], at_gone[0] + (onward[1] - onward[0])];
        self.curve_allows(chain, span, 0.0) || (demand.ears && self.is_ear(gone) && self.border_allows(chain, span))
    }
}

/// The half-edge that enters the vertex of `h` in its triangle.
#[inline]
fn c_before(h: u32) -> u32 {
    previous(h)
}
