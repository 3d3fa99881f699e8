//! Edges are flipped where that makes the worse of the two triangles better by one per cent, or repairs constraint (1).
//!
//! Departure: a triangle is worth q cos² of its deviation instead of q alone. Of two diagonals with about the same shapes
//! the one that follows the surface wins, which costs nothing and lowers the mean deviation by several per cent.

use super::curves::Rank;
use super::work::{Face, Work};
use crate::context::Context;
use crate::error::Result;
use crate::geometry::normals::angle_between;
use crate::mesh::{NONE, next, previous};
use rayon::prelude::*;
use std::f64::consts::FRAC_PI_3;

/// Gain in the worst shape for which a flip is worth it.
const SHAPE_GAIN: f32 = 1.01;
/// Shapes may fall by this factor where valences become regular.
const REGULAR_LOSS: f32 = 0.6;
/// And cosines with the normals not below this, unless they were.
const REGULAR_COSINE: f32 = 0.8;
/// Gain in the sum of squared excesses for which they do: a whole number, but at curves.
const REGULAR_GAIN: f64 = 0.1;
/// Flips make no edges longer than this, unless the old one was as long.
const LONGEST_FLIPPED: f64 = 1.6;

/// Edges that a thread takes at least.
const EDGES_PER_TASK: usize = 256;

/// What flips make better: the shape, and how well the triangle fits the surface.
fn value(face: Face) -> f32 {
    face.shape * face.cosine.max(0.0).powi(2)
}

impl Work<'_> {
    /// Flips edges until nothing gets better, or for the given number of sweeps. Returns the number of flips.
    pub fn swap(&mut self, sweeps: usize, context: &Context) -> Result<usize> {
        let mut done = 0;
        let mut pending: Vec<u32> = self.mesh.edges().collect();
        for _ in 0..sweeps {
            context.check()?;
            let mut touched = Vec::new();
            for h in self.worth_a_swap(&pending, SHAPE_GAIN) {
                if self.try_swap(h, SHAPE_GAIN) {
                    done += 1;
                    let o = self.mesh.opposite(h);
                    touched.extend([next(h), previous(h), next(o), previous(o)]);
                }
            }
            if touched.is_empty() {
                break;
            }
            pending = touched;
        }
        Ok(done)
    }

    /// Flips edges that bring the valences of the four vertices nearer to regular, where shapes stay good. Returns how
    /// many. Relocation turns better valences into better shapes.
    pub fn regularise(&mut self, context: &Context) -> Result<usize> {
        let mut excess = self.excess();
        context.check()?;
        let irregular: Vec<u32> =
            self.mesh.edges().filter(|&h| self.wedges_of_regular_swap(h, &excess).is_some()).collect();
        let mut done = 0;
        for h in self.worth_a_swap(&irregular, REGULAR_LOSS) {
            if let Some((ends, tips)) = self.wedges_of_regular_swap(h, &excess)
                && self.try_swap(h, REGULAR_LOSS)
            {
                ends.iter().for_each(|&w| excess[w as usize] -= 1.0);
                tips.iter().for_each(|&w| excess[w as usize] += 1.0);
                done += 1;
            }
        }
        Ok(done)
    }

    /// The wedges that lose an edge and those that gain one, where a flip makes valences more regular.
    fn wedges_of_regular_swap(&self, h: u32, excess: &[f64]) -> Option<([u32; 2], [u32; 2])> {
        let mesh = &self.mesh;
        let o = mesh.opposite(h);
        if o == NONE || mesh.curve(h) != NONE {
            return None;
        }
        let ends = [h, next(h)].map(|x| mesh.wedge(x));
        let tips = [h, o].map(|x| mesh.wedge(previous(x)));
        let gain = |w: &u32, change: f64| excess[*w as usize].powi(2) - (excess[*w as usize] + change).powi(2);
        let gained: f64 = ends.iter().map(|w| gain(w, -1.0)).chain(tips.iter().map(|w| gain(w, 1.0))).sum();
        (gained > REGULAR_GAIN).then_some((ends, tips))
    }

    /// How many triangles every wedge has beyond the regular number: six around a free vertex, one for every 60° between
    /// two curves.
    fn excess(&self) -> Vec<f64> {
        let mesh = &self.mesh;
        let mut excess = vec![0.0; self.normal.len()];
        for h in (0..mesh.half_edge_slots()).filter(|&h| mesh.is_half_edge(h)) {
            let v = mesh.vertex(h);
            excess[mesh.wedge(h) as usize] += 1.0;
            if self.rank[v as usize] == Rank::Free {
                continue;
            }
            let [p, q, r] = [h, next(h), previous(h)].map(|x| self.point(mesh.vertex(x)));
            excess[mesh.wedge(h) as usize] -= angle_between(q - p, r - p) / FRAC_PI_3;
        }
        for v in (0..mesh.vertex_slots()).filter(|&v| mesh.is_vertex(v) && self.rank[v as usize] == Rank::Free) {
            if let Some(h) = mesh.around(v).next() {
                excess[mesh.wedge(h) as usize] -= 6.0;
            }
        }
        excess
    }

    /// The edges of a list whose flips are allowed and worth it, looked at in parallel. Flips move half-edges to other edges:
    /// what is worth it is asked once more before it is done.
    fn worth_a_swap(&self, edges: &[u32], gain: f32) -> Vec<u32> {
        let is_worth_it = |h: &u32| self.flipped(*h, gain).is_some();
        edges.par_iter().with_min_len(EDGES_PER_TASK).copied().filter(is_worth_it).collect()
    }

    /// Flips an edge if that is allowed and worth it.
    pub fn try_swap(&mut self, h: u32, gain: f32) -> bool {
        let Some([f, g]) = self.flipped(h, gain) else { return false };
        let o = self.mesh.opposite(h);
        self.mesh.flip(h);
        self.face[h as usize / 3] = f;
        self.face[o as usize / 3] = g;
        true
    }

    /// What the triangles of an edge become when it is flipped, if that is allowed and worth it.
    fn flipped(&self, h: u32, gain: f32) -> Option<[Face; 2]> {
        let mesh = &self.mesh;
        if mesh.opposite(h) == NONE || mesh.curve(h) != NONE {
            return None;
        }
        let o = mesh.opposite(h);
        let [a, b, c, d] = [h, next(h), previous(h), previous(o)];
        let [pa, pb, pc, pd] = [a, b, c, d].map(|x| self.point(mesh.vertex(x)));
        let [na, nb, nc, nd] = [a, b, c, d].map(|x| self.normal[mesh.wedge(x) as usize]);
        let (old_f, old_g) = (self.face[h as usize / 3], self.face[o as usize / 3]);
        let before = old_f.worse(old_g);
        let [wa, wb, wc] = self.stretches([a, b, c].map(|x| mesh.vertex(x)));
        let wd = self.stretches([mesh.vertex(d); 3])[0];
        let [f, g] = [
            self.judge([pc, pd, pb], [nc, nd, nb], [wc, wd, wb]),
            self.judge([pd, pc, pa], [nd, nc, na], [wd, wc, wa]),
        ];
        let after = f.worse(g);
        let repairs = f64::from(before.cosine) < self.limits.cos_cap
            && after.cosine > before.cosine + 0.01
            && after.shape > 0.7 * before.shape;
        let [old, new] = [[old_f, old_g], [f, g]].map(|pair| value(pair[0]).min(value(pair[1])));
        // What only makes valences regular turns no face away from the surface.
        let turns = gain < 1.0 && after.cosine < before.cosine.min(REGULAR_COSINE);
        let improves = new > gain * old && !turns && self.allows_cosine(after.cosine, before.cosine);
        if !improves && !repairs {
            return None;
        }
        let (old, new) = (self.edge_length(h), self.length(mesh.vertex(c), mesh.vertex(d)));
        if new > LONGEST_FLIPPED.max(old) && after.shape > 0.05 && before.shape > 0.1 {
            return None;
        }
        let (strain_before, strain_after) = self.strain_of_flip(h);
        (mesh.can_flip(h) && strain_after.may_follow(strain_before)).then_some([f, g])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Polygons, SurfaceMesh};
    use crate::remesh::{RemeshOptions, source::Source};
    use glam::DVec3;

    /// A square of n × n cells, each cut along the diagonal that its neighbours are not cut along: valences are 4 and 8.
    fn union_jack(n: u32) -> SurfaceMesh {
        let at = |i: u32, j: u32| j * (n + 1) + i;
        let points = (0..=n).flat_map(|j| (0..=n).map(move |i| DVec3::new(f64::from(i), f64::from(j), 0.0))).collect();
        let mut faces = Polygons::new();
        for (i, j) in (0..n).flat_map(|j| (0..n).map(move |i| (i, j))) {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            let [first, second] = if (i + j) % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[b, c, d], [b, d, a]] };
            faces.push(&first);
            faces.push(&second);
        }
        SurfaceMesh::new(points, faces).unwrap()
    }

    #[test]
    fn valences_become_more_regular_up_to_the_border() {
        let (context, options) = (Context::new(), RemeshOptions::default());
        let mut source = Source::new(&union_jack(9), &options, &context).unwrap();
        source.set_sizes(&options, &context).unwrap();
        let mut work = source.at_work(&options);
        let irregularity = |work: &Work| work.excess().iter().map(|e| e.powi(2)).sum::<f64>();
        let before = irregularity(&work);
        let flips = work.regularise(&context).unwrap();
        assert!(flips > 0 && irregularity(&work) < 0.5 * before, "{flips}: {before} to {}", irregularity(&work));
        assert_eq!(work.mesh.triangle_count(), 162);
    }
}
