//! Keeps the nature of edges: smooth edges do not become creases, and ridges do not become flat.
//!
//! Constraint (1) compares faces with normals at their corners: two faces that stray to opposite sides, each within the
//! limit, make a crease that the surface does not have. On clean models the dihedral angles of a cavity are therefore
//! looked at, too: an operation is refused where it brings a smooth edge above the feature angle or a sharp ridge below half
//! of it, and the cavity had nothing as bad before. Curves that are there for a tag or a label alone count as smooth edges. On
//! scans noise has angles of any size, and nothing is tested.

use super::dihedral::Dihedral;
use super::work::Work;
use crate::geometry::normals::unit;
use crate::mesh::{NONE, next, previous, triangle_area_vector};
use glam::DVec3;

/// Strains below are rounding.
const NO_STRAIN: f64 = 1e-12;

/// How far the edges of a cavity are from what they should be: the worst smooth edge and the worst ridge. Neither makes up for
/// the other.
#[derive(Debug, Clone, Copy, Default)]
pub struct Strain {
    smooth: f64,
    ridge: f64,
}

impl Strain {
    fn max(self, other: Strain) -> Strain {
        Strain { smooth: self.smooth.max(other.smooth), ridge: self.ridge.max(other.ridge) }
    }

    /// Whether this may follow upon another.
    pub fn may_follow(self, before: Strain) -> bool {
        self.smooth <= before.smooth + NO_STRAIN && self.ridge <= before.ridge + NO_STRAIN
    }
}

impl Work<'_> {
    /// The strain of the edges around a vertex, with the vertex at `p`.
    ///
    /// With `kept`, the vertex is about to be merged into that one, which lies at `p`.
    fn strain_around(&self, v: u32, p: DVec3, kept: u32) -> Strain {
        let Some(limits) = self.limits.dihedral else { return Strain::default() };
        let mesh = &self.mesh;
        let normal = |t: u32| {
            let [a, b, c] = mesh.triangle(t).map(|w| if w == v { p } else { self.point(w) });
            unit(triangle_area_vector(a, b, c))
        };
        // The triangle of a corner at v; where it disappears, the one behind it.
        let stands_for = |h: u32| {
            let goes = mesh.head(h) == kept || mesh.apex(h) == kept;
            if !goes {
                return Some(h / 3);
            }
            let behind = mesh.opposite(next(h));
            (behind != NONE).then_some(behind / 3)
        };
        let mut worst = Strain::default();
        for h in mesh.around(v) {
            let Some(own) = stands_for(h).map(normal) else { continue };
            let o = mesh.opposite(h);
            if mesh.head(h) != kept
                && o != NONE
                && let Some(other) = stands_for(next(o))
            {
                worst = worst.max(self.strain(limits, self.curve_after(h, kept), own, normal(other)));
            }
            let link = next(h);
            let outer = mesh.opposite(link);
            if outer != NONE && stands_for(h) == Some(h / 3) {
                worst = worst.max(self.strain(limits, mesh.curve(link), own, normal(outer / 3)));
            }
        }
        worst
    }

    /// The curve of a spoke when its vertex has been merged: the edge it falls upon may be the one on a curve.
    fn curve_after(&self, h: u32, kept: u32) -> u32 {
        let mesh = &self.mesh;
        let o = mesh.opposite(h);
        let mut curve = mesh.curve(h);
        if mesh.apex(h) == kept {
            curve = curve.min(mesh.curve(next(h)));
        }
        if o != NONE && mesh.apex(o) == kept {
            curve = curve.min(mesh.curve(previous(o)));
        }
        curve
    }

    /// Unit normal of a triangle.
    pub fn face_normal(&self, t: u32) -> DVec3 {
        let [a, b, c] = self.mesh.positions(t);
        unit(triangle_area_vector(a, b, c))
    }

    /// Strain of an outer edge of a cavity whose own face had the normal `old` and has `new`, before and after.
    fn strain_of_link(&self, limits: Dihedral, link: u32, old: DVec3, new: DVec3) -> (Strain, Strain) {
        let outer = self.mesh.opposite(link);
        if outer == NONE {
            return Default::default();
        }
        let there = self.face_normal(outer / 3);
        let of = |normal: DVec3| self.strain(limits, self.mesh.curve(link), normal, there);
        (of(old), of(new))
    }

    /// Strain of the two triangles of an edge and their neighbours, before and after it is flipped.
    pub fn strain_of_flip(&self, h: u32) -> (Strain, Strain) {
        let Some(limits) = self.limits.dihedral else { return Default::default() };
        let mesh = &self.mesh;
        let o = mesh.opposite(h);
        let [a, b, c, d] = [h, next(h), previous(h), previous(o)].map(|x| self.point(mesh.vertex(x)));
        let normal = |a, b, c| unit(triangle_area_vector(a, b, c));
        let (old_h, old_o) = (normal(a, b, c), normal(b, a, d));
        let (new_b, new_a) = (normal(c, d, b), normal(d, c, a));
        let mut before = self.strain(limits, NONE, old_h, old_o);
        let mut after = self.strain(limits, NONE, new_b, new_a);
        let sides = [
            (next(h), old_h, new_b),
            (previous(h), old_h, new_a),
            (next(o), old_o, new_a),
            (previous(o), old_o, new_b),
        ];
        for (side, old, new) in sides {
            let (was, is) = self.strain_of_link(limits, side, old, new);
            (before, after) = (before.max(was), after.max(is));
        }
        (before, after)
    }

    /// Strain of the triangles of an edge and their neighbours, before and after the edge gets a vertex at `p`.
    pub fn strain_of_split(&self, h: u32, p: DVec3) -> (Strain, Strain) {
        let Some(limits) = self.limits.dihedral else { return Default::default() };
        let mesh = &self.mesh;
        let curve = mesh.curve(h);
        let normal = |a, b, c| unit(triangle_area_vector(a, b, c));
        // Of every side the old normal and those of its halves, at the tail of `h` and at its head.
        let mut halves: [Option<[DVec3; 3]>; 2] = [None; 2];
        let (mut before, mut after) = (Strain::default(), Strain::default());
        for (side, halves) in [h, mesh.opposite(h)].into_iter().zip(&mut halves).filter(|(side, _)| *side != NONE) {
            let [a, b, c] = [side, next(side), previous(side)].map(|x| self.point(mesh.vertex(x)));
            let (old, at_tail, at_head) = (normal(a, b, c), normal(a, p, c), normal(p, b, c));
            after = after.max(self.strain(limits, NONE, at_tail, at_head));
            for (link, new) in [(next(side), at_head), (previous(side), at_tail)] {
                let (was, is) = self.strain_of_link(limits, link, old, new);
                (before, after) = (before.max(was), after.max(is));
            }
            *halves = Some(if side == h { [old, at_tail, at_head] } else { [old, at_head, at_tail] });
        }
        if let [Some(left), Some(right)] = halves {
            let of = |k: usize| self.strain(limits, curve, left[k], right[k]);
            (before, after) = (before.max(of(0)), after.max(of(1)).max(of(2)));
        }
        (before, after)
    }

    /// Whether the edges around a vertex allow it to lie at `p`; with `kept`, to be merged into that one, which lies there.
    pub fn strain_allows(&self, v: u32, p: DVec3, kept: u32) -> bool {
        let none = Strain::default();
        let after = self.strain_around(v, p, kept);
        after.may_follow(none) || after.may_follow(self.strain_around(v, self.point(v), NONE))
    }

    /// How far an edge between two faces is from what it should be.
    fn strain(&self, limits: Dihedral, curve: u32, m: DVec3, n: DVec3) -> Strain {
        let cosine = m.dot(n);
        let none = Strain::default();
        match self.curves.chains.get(curve as usize) {
            Some(chain) if chain.sharp => Strain { ridge: (cosine - limits.ridge).max(0.0), ..none },
            Some(chain) if !chain.smooth => none,
            _ => Strain { smooth: (limits.smooth - cosine).max(0.0), ..none },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::context::Context;
    use crate::remesh::{RemeshOptions, source::Source};
    use crate::sample;

    fn source(name: &str, tagged: bool) -> Source {
        let context = Context::new();
        let mut mesh = sample::make(name, None, &context).unwrap().triangulated().unwrap();
        if tagged {
            let ends = |f: &[u32]| [f[0], f[1]].map(crate::mesh::VertexId);
            let first = ends(mesh.faces().face(0));
            mesh.tagged_edges = vec![crate::mesh::TaggedEdge { ends: first, tag: 1 }];
        }
        let mut source = Source::new(&mesh, &RemeshOptions::default(), &context).unwrap();
        source.set_sizes(&RemeshOptions::default(), &context).unwrap();
        source
    }

    #[test]
    fn a_split_folds_nothing() {
        let source = source("rounded-box", false);
        let work = source.at_work(&RemeshOptions::default());
        let inner = |h: &u32| work.mesh.opposite(*h) != NONE && work.mesh.curve(*h) == NONE;
        let h = work.mesh.edges().find(inner).unwrap();
        let [a, b] = [work.mesh.vertex(h), work.mesh.head(h)].map(|v| work.point(v));
        let middle = 0.5 * (a + b);
        let (before, after) = work.strain_of_split(h, middle);
        assert!(after.may_follow(before), "{after:?} {before:?}");
        let normal = work.normal[work.mesh.wedge(h) as usize];
        let (before, after) = work.strain_of_split(h, middle + a.distance(b) * normal);
        assert!(!after.may_follow(before), "{after:?} {before:?}");
    }

    #[test]
    fn a_ridge_that_may_be_flat_excuses_no_crease() {
        let [smooth, ridge] = [Strain { smooth: 0.1, ridge: 0.0 }, Strain { smooth: 0.0, ridge: 0.3 }];
        assert!(!smooth.may_follow(ridge) && !ridge.may_follow(smooth));
        assert!(smooth.may_follow(smooth.max(ridge)) && Strain::default().may_follow(Strain::default()));
    }

    #[test]
    fn a_tagged_curve_that_is_smooth_stays_so() {
        let source = source("torus", true);
        assert!(source.curves.chains.iter().any(|c| c.smooth && !c.sharp));
    }
}
