//! Edges keep their nature: smooth edges do not become creases, ridges do not become flat.
//!
//! Constraint (1) compares faces with normals at their corners: two faces that stray to opposite sides, each within the
//! limit, make a crease that the surface does not have. On clean models the dihedral angles of a cavity are therefore
//! looked at, too: an operation is refused where it brings a smooth edge above the feature angle or a sharp ridge below half
//! of it, and the cavity had nothing as bad before. On scans noise has angles of any size, and nothing is tested.

use super::curves::Kind;
use super::work::Work;
use crate::geometry::normals::unit;
use crate::mesh::{NONE, next, previous, triangle_area_vector};
use glam::DVec3;

/// What dihedral angles must respect, as cosines of the angle between the normals of the two faces.
#[derive(Debug, Clone, Copy)]
pub struct Dihedral {
    /// Smooth edges stay above.
    pub smooth: f64,
    /// Sharp ridges stay below.
    pub ridge: f64,
}

impl Dihedral {
    /// A little inside of what is asked for: ridges above `feature_angle`, in degrees, and none besides.
    pub fn within(feature_angle: f64) -> Self {
        Dihedral { smooth: (0.97 * feature_angle).to_radians().cos(), ridge: (0.6 * feature_angle).to_radians().cos() }
    }
}

impl Work<'_> {
    /// How far the edges around a vertex are from what they should be, with the vertex at `p`; 0: all is well.
    ///
    /// With `kept`, the vertex is about to be merged into that one, which lies at `p`.
    pub fn strain_around(&self, v: u32, p: DVec3, kept: u32) -> f64 {
        let Some(limits) = self.limits.dihedral else { return 0.0 };
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
        let mut worst: f64 = 0.0;
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

    /// Strain of the two triangles of an edge and their neighbours, before and after it is flipped.
    pub fn strain_of_flip(&self, h: u32) -> (f64, f64) {
        let Some(limits) = self.limits.dihedral else { return (0.0, 0.0) };
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
            let outer = mesh.opposite(side);
            if outer != NONE {
                let [p, q, r] = mesh.positions(outer / 3);
                let there = normal(p, q, r);
                before = before.max(self.strain(limits, mesh.curve(side), old, there));
                after = after.max(self.strain(limits, mesh.curve(side), new, there));
            }
        }
        (before, after)
    }

    /// Whether a strain may follow upon another.
    pub fn allows_strain(&self, after: f64, before: f64) -> bool {
        after <= before.max(1e-12)
    }

    /// How far an edge between two faces is from what it should be.
    fn strain(&self, limits: Dihedral, curve: u32, m: DVec3, n: DVec3) -> f64 {
        let cosine = m.dot(n);
        match self.curves.chains.get(curve as usize) {
            None => (limits.smooth - cosine).max(0.0),
            Some(chain) if chain.kind == Kind::Crease => (limits.smooth - cosine).max(0.0),
            Some(chain) if chain.sharp => (cosine - limits.ridge).max(0.0),
            Some(_) => 0.0,
        }
    }
}
