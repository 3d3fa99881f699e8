//! The few quads that no smoothing turns the right way, as where a limb is thinner than they are, go: each is collapsed along a
//! diagonal, and a vertex that is left with two quads goes with them, which become one (Tarini, Pietroni, Cignoni, Panozzo, Puppo:
//! *Practical quad mesh simplification*, 2010).
//!
//! ```text
//!     b              b             ·──·──·          ·─────·
//!    ╱ ╲             │             │   ╲ │          │     │
//!   a   c    →     a = c           │    v│    →     │     │
//!    ╲ ╱             │             │   ╱ │          │     │
//!     d              d             ·──·──·          ·─────·
//!   diagonal collapse              doublet: v has two quads
//! ```

use super::around::Around;
use super::ceiling::worst_shapes;
use super::smooth::{jacobian, smooth_near};
use super::source::Source;
use super::validate::faults;
use super::work::{Place, Work};
use crate::context::Context;
use crate::error::Result;
use crate::mesh::Polygons;
use rustc_hash::FxHashSet;

/// A scaled Jacobian over what it can be: quads with a worse one go as well, if that leaves fewer of them, because no
/// smoothing has mended them.
const COLLAPSED_SHAPE: f64 = 0.1;
/// A share of the quads: where more are no good nothing is collapsed, because other quads are needed.
const MOST_COLLAPSED: f64 = 0.05;
/// A count: rounds at most, because collapses that touch each other are made one after the other.
const COLLAPSE_ROUNDS: usize = 30;
/// A count: rounds that leave no fewer such quads before it is given up, because one may have to grow worse before it
/// goes.
const COLLAPSE_PATIENCE: usize = 8;
/// A factor of length for each valence that becomes worse: the longer diagonal is collapsed only where the other one
/// costs more, because it takes vertices farther.
const LONGER_DIAGONAL: f64 = 1.3;
/// A count: rings of quads around a collapse that are smoothed after it, because those farther away hardly notice it.
const SMOOTHED_RINGS: usize = 3;

/// Collapses quads until all are good. Returns whether they are.
pub fn collapse(work: &mut Work, source: &Source, context: &Context) -> Result<bool> {
    let mut best: Option<(usize, usize, bool, Work)> = None;
    for round in 0..COLLAPSE_ROUNDS {
        let (bad, wrong) = no_good(work, source);
        let count = wrong * work.faces.len() + bad.len();
        tracing::debug!(target: "carreau::quad", round, wrong, bad = bad.len(), "to be collapsed");
        let is_best = best.as_ref().is_none_or(|b| count < b.0);
        if is_best {
            best = Some((count, round, wrong == 0, work.clone()));
        }
        let since = best.as_ref().map_or(0, |b| round - b.1);
        if bad.is_empty() || since > COLLAPSE_PATIENCE || bad.len() as f64 > MOST_COLLAPSED * work.faces.len() as f64 {
            break;
        }
        context.check()?;
        let near = Collapses::new(work).of(&bad);
        if near.is_empty() {
            break;
        }
        smooth_around(work, source, near, context)?;
    }
    let Some((_, _, is_good, found)) = best else { return Ok(false) };
    *work = found;
    Ok(is_good)
}

/// Quads that look the wrong way or are inverted, then those that are all but, some of them twice; and how many the first are.
pub fn no_good(work: &Work, source: &Source) -> (Vec<u32>, usize) {
    let mut bad: Vec<u32> = faults(work, source).map(|(q, _)| q as u32).collect();
    let wrong = bad.len();
    bad.extend(worst_shapes(work).zip(0u32..).filter(|&(shape, _)| shape < COLLAPSED_SHAPE).map(|(_, q)| q));
    (bad, wrong)
}

/// Smooths the vertices around some.
pub fn smooth_around(work: &mut Work, source: &Source, vertices: Vec<u32>, context: &Context) -> Result<()> {
    let around = Around::new(work);
    let near = rings(work, &around, vertices);
    smooth_near(work, &around, source, &near, context)
}

/// The vertices within some rings of quads around others.
fn rings(work: &Work, around: &Around, mut vertices: Vec<u32>) -> Vec<u32> {
    for _ in 0..SMOOTHED_RINGS {
        let quads = vertices.iter().flat_map(|&v| around.quads[v as usize].iter());
        vertices = quads.flat_map(|&q| work.faces.face(q as usize)).copied().collect();
        vertices.sort_unstable();
        vertices.dedup();
    }
    vertices
}

/// Collapses that are made at the same time: no two have a quad around them in common.
struct Collapses<'a> {
    work: &'a mut Work,
    faces: Vec<[u32; 4]>,
    quads: Vec<Vec<u32>>,
    is_gone: Vec<bool>,
    /// Vertices whose quads have changed, or are about to.
    touched: FxHashSet<u32>,
}

impl<'a> Collapses<'a> {
    fn new(work: &'a mut Work) -> Self {
        let faces: Vec<[u32; 4]> = work.faces.iter().map(|f| [f[0], f[1], f[2], f[3]]).collect();
        let mut quads = vec![Vec::new(); work.points.len()];
        for (q, face) in (0u32..).zip(&faces) {
            face.iter().for_each(|&v| quads[v as usize].push(q));
        }
        let is_gone = vec![false; faces.len()];
        Collapses { work, faces, quads, is_gone, touched: FxHashSet::default() }
    }

    /// Collapses such quads, or the worst beside one that cannot be. Returns vertices where something has changed.
    fn of(mut self, bad: &[u32]) -> Vec<u32> {
        let mut near = Vec::new();
        for &q in bad {
            let mut beside: Vec<u32> =
                self.faces[q as usize].iter().flat_map(|&v| self.quads[v as usize].iter().copied()).collect();
            beside.sort_by(|&a, &b| {
                let worth = |q: u32| jacobian(self.work, q);
                worth(a).total_cmp(&worth(b)).then(a.cmp(&b))
            });
            beside.dedup();
            let near_by: Vec<u32> = [q].into_iter().chain(beside).collect();
            let best = |may_flatten| near_by.iter().find_map(|&q| Some((q, self.diagonal(q, may_flatten)?)));
            if let Some((at, [from, to])) = best(false).or_else(|| best(true)) {
                near.extend(self.faces[at as usize].iter().filter(|&&v| v != from));
                self.merge(at, from, to);
            }
        }
        self.finish();
        near
    }

    /// The diagonal along which a quad may be collapsed: which vertex becomes which. A vertex on a feature that has a quad fewer is
    /// mostly a straight corner of the next one, which is flat then: only where nothing else is left.
    fn diagonal(&self, q: u32, may_flatten: bool) -> Option<[u32; 2]> {
        let [a, b, c, d] = self.faces[q as usize];
        let is_free = |v: u32| !self.touched.contains(&v);
        if self.is_gone[q as usize] || ![a, b, c, d].into_iter().all(is_free) {
            return None;
        }
        let cost = |[from, to]: [u32; 2]| {
            let length = self.work.points[from as usize].distance(self.work.points[to as usize]);
            length * LONGER_DIAGONAL.powi(self.worse([from, to], q) as i32)
        };
        let ways = [[a, c], [b, d]].into_iter().filter_map(|ends| self.directed(q, ends, may_flatten));
        ways.min_by(|&x, &y| cost(x).total_cmp(&cost(y)))
    }

    /// The same diagonal with the vertex first that gives way to the other, if the surface stays one.
    fn directed(&self, q: u32, [a, c]: [u32; 2], may_flatten: bool) -> Option<[u32; 2]> {
        let ends = match (self.is_inner(a), self.is_inner(c)) {
            (true, _) => [a, c],
            (false, true) => [c, a],
            (false, false) => return None,
        };
        let (of_a, of_c) = (self.beside(a), self.beside(c));
        let common: Vec<u32> = of_a.iter().copied().filter(|v| of_c.contains(v)).collect();
        let others = self.faces[q as usize].iter().filter(|&&v| v != a && v != c);
        // An edge to both others, and no quad, edge or vertex in common but for these.
        let is_sound = common.len() == 2
            && others.clone().all(|v| common.contains(v))
            && !of_a.contains(&c)
            && self.quads[a as usize].iter().filter(|&&o| self.faces[o as usize].contains(&c)).count() == 1;
        let may_lose = |&v: &u32| match self.is_inner(v) {
            true => self.quads[v as usize].len() > 3 || self.may_go(v, a, c),
            false => may_flatten,
        };
        (is_sound && others.clone().all(may_lose)).then_some(ends)
    }

    fn is_inner(&self, v: u32) -> bool {
        matches!(self.work.place[v as usize], Place::Region(_))
    }

    /// Whether a vertex that is left with two quads may go: the quads must make one.
    fn may_go(&self, v: u32, a: u32, c: u32) -> bool {
        // What is across v in the quads that stay.
        let across: Vec<u32> = self.quads[v as usize]
            .iter()
            .map(|&q| self.faces[q as usize])
            .filter(|face| !(face.contains(&a) && face.contains(&c)))
            .map(|face| face[(face.iter().position(|&w| w == v).unwrap_or(0) + 2) % 4])
            .collect();
        matches!(across[..], [x, y] if x != y && x != a && x != c && y != a && y != c)
    }

    /// The vertices that share an edge with one.
    fn beside(&self, v: u32) -> Vec<u32> {
        let of = |&q: &u32| {
            let face = self.faces[q as usize];
            let at = face.iter().position(|&w| w == v).unwrap_or(0);
            [face[(at + 1) % 4], face[(at + 3) % 4]]
        };
        let mut all: Vec<u32> = self.quads[v as usize].iter().flat_map(of).collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    /// By how much valences become worse, all together.
    fn worse(&self, [from, to]: [u32; 2], q: u32) -> i64 {
        let valence = |v: u32| self.quads[v as usize].len() as i64;
        let off = |v: u32, n: i64| if self.is_inner(v) { (n - 4).abs() } else { 0 };
        let others = self.faces[q as usize].iter().filter(|&&v| v != from && v != to);
        let of_others: i64 = others.map(|&v| off(v, valence(v) - 1) - off(v, valence(v))).sum();
        let merged = off(to, valence(from) + valence(to) - 2);
        of_others + merged - off(from, valence(from)) - off(to, valence(to))
    }

    fn merge(&mut self, q: u32, from: u32, to: u32) {
        let around: Vec<u32> = self.quads[from as usize].iter().chain(&self.quads[to as usize]).copied().collect();
        for &q in &around {
            self.touched.extend(self.faces[q as usize]);
        }
        let others: Vec<u32> = self.faces[q as usize].iter().copied().filter(|&v| v != from && v != to).collect();
        if self.is_inner(to) {
            let middle = self.work.points[from as usize].midpoint(self.work.points[to as usize]);
            self.work.points[to as usize] = middle;
        }
        self.remove(q);
        for q in std::mem::take(&mut self.quads[from as usize]) {
            self.faces[q as usize].iter_mut().filter(|v| **v == from).for_each(|v| *v = to);
            self.quads[to as usize].push(q);
        }
        for v in others {
            self.remove_doublet(v);
        }
    }

    fn remove(&mut self, q: u32) {
        self.is_gone[q as usize] = true;
        for v in self.faces[q as usize] {
            self.quads[v as usize].retain(|&other| other != q);
        }
    }

    /// Two quads around a vertex become one.
    fn remove_doublet(&mut self, v: u32) {
        let ([keep, goes], true) = (&self.quads[v as usize][..], self.is_inner(v)) else { return };
        let (keep, goes) = (*keep, *goes);
        let other = self.faces[goes as usize];
        let at = other.iter().position(|&w| w == v).unwrap_or(0);
        let across = other[(at + 2) % 4];
        self.touched.extend(other);
        self.remove(goes);
        self.faces[keep as usize].iter_mut().filter(|w| **w == v).for_each(|w| *w = across);
        self.quads[v as usize].clear();
        self.quads[across as usize].push(keep);
    }

    /// Writes what is left.
    fn finish(self) {
        let (mut faces, mut region) = (Polygons::new(), Vec::new());
        for (q, face) in self.faces.iter().enumerate().filter(|(q, _)| !self.is_gone[*q]) {
            faces.push(face);
            region.push(self.work.region[q]);
        }
        (self.work.faces, self.work.region) = (faces, region);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::features::FeatureOptions;
    use crate::mesh::{SurfaceMesh, Topology, test_models};
    use crate::quad::smooth::turned;
    use glam::DVec3;

    /// A grid of `n` by `n` quads in the plane, whose outline is held.
    fn grid(n: u32) -> (Work, Source) {
        let mesh: SurfaceMesh = test_models::grid(n);
        let source = Source::new(&mesh, &FeatureOptions::default(), &Context::new()).unwrap();
        let is_inner = |p: &DVec3| p.x > 1e-9 && p.y > 1e-9 && p.x < f64::from(n) - 1e-9 && p.y < f64::from(n) - 1e-9;
        let points = mesh.points().to_vec();
        let place = points.iter().map(|p| if is_inner(p) { Place::Region(0) } else { Place::Fixed }).collect();
        let mut work = Work { points, place, region: vec![0; (n * n) as usize], ..Work::default() };
        for k in 0..n * n {
            let at = |i: u32, j: u32| (k / n + i) * (n + 1) + k % n + j;
            work.faces.push(&[at(0, 0), at(1, 0), at(1, 1), at(0, 1)]);
        }
        (work, source)
    }

    #[test]
    fn any_quad_can_be_collapsed_and_the_surface_stays_one() {
        let n = 6;
        for q in 0..n * n {
            let (mut work, source) = grid(n);
            let had = Topology::of(&work.to_mesh().unwrap());
            let near = Collapses::new(&mut work).of(&[q]);
            assert!(!near.is_empty());
            let has = Topology::of(&work.to_mesh().unwrap());
            assert_eq!(
                (had.euler, had.boundary_loops, had.components),
                (has.euler, has.boundary_loops, has.components)
            );
            assert_eq!(
                has.nonmanifold_edges + has.nonmanifold_vertices + has.inconsistent_edges + has.duplicate_faces,
                0
            );
            assert!(work.faces.iter().all(|f| f.iter().collect::<FxHashSet<_>>().len() == 4));
            let around = Around::new(&work);
            let near = rings(&work, &around, near);
            smooth_near(&mut work, &around, &source, &near, &Context::new()).unwrap();
            assert!(turned(&work).is_empty(), "quad {q}");
        }
    }

    #[test]
    fn one_after_the_other_they_all_go_that_can() {
        let (mut work, _) = grid(7);
        let had = Topology::of(&work.to_mesh().unwrap());
        loop {
            let all: Vec<u32> = (0..work.faces.len() as u32).collect();
            if Collapses::new(&mut work).of(&all).is_empty() {
                break;
            }
            let has = Topology::of(&work.to_mesh().unwrap());
            assert_eq!((had.euler, had.boundary_loops), (has.euler, has.boundary_loops));
            assert_eq!(
                has.nonmanifold_edges + has.nonmanifold_vertices + has.inconsistent_edges + has.duplicate_faces,
                0
            );
            let around = Around::new(&work);
            let inner = (0..work.points.len()).filter(|&v| matches!(work.place[v], Place::Region(_)));
            assert!(inner.map(|v| around.quads[v].len()).all(|n| n == 0 || n > 2), "no doublet is left");
        }
        assert!(work.faces.len() < 30);
    }
}
