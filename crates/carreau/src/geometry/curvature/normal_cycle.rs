//! Normal cycles: the bending of a surface sits in its edges.
//!
//! Source: Cohen-Steiner, Morvan, "Restricted Delaunay triangulations and normal cycle", SoCG 2003, as used by Lavoué,
//! Dupont, Baskurt (4.2):
//!
//! ```text
//! T(v) = 1/|B| Σ β(e) |e ∩ B| ê êᵀ       β signed angle between the normals beside edge e, positive where convex
//! ```
//!
//! over the edges in a region B around v. The curvature across an edge belongs to the direction across it, so the
//! eigenvalues of the tangential part go with each other's eigenvectors.
//!
//! On the faces around v, B is taken as a third of their area: the half of each edge next to v. The program of the paper's
//! authors (MEPP) divides the whole incident edges by the whole area, though edges on the rim, which also bound that
//! area, are missing in the sum: its curvatures are a third too small. [`MEPP_SHARE`] brings them about.
//!
//! Departure: angles are taken by atan2, which tells 100° from 80°; the sine that MEPP uses does not.

use super::per_vertex::map;
use super::sectors::Sectors;
use super::tensor::{Form, Frame};
use super::tuning::NO_AREA;
use crate::context::Context;
use crate::error::Result;
use crate::mesh::NONE;

/// MEPP's estimate as a share of the one without its bias.
pub(super) const MEPP_SHARE: f64 = 2.0 / 3.0;

/// β/|e| of every half-edge; see [`turn`].
pub(super) fn turns(sectors: &Sectors<'_>, context: &Context) -> Result<Vec<f64>> {
    map(sectors.of_corner.len(), context, |c| turn(sectors, c))
}

/// β/|e| of a half-edge; zero where there is no way across.
#[inline]
pub(super) fn turn(sectors: &Sectors<'_>, c: u32) -> f64 {
    let across = sectors.across[c as usize];
    if across == NONE {
        return 0.0;
    }
    // In the order of the corners, so that both half-edges get the same number.
    let (c, o) = (c.min(across), c.max(across));
    let t = &sectors.triangles;
    let along = t.point(t.next(c)) - t.point(c);
    let length = along.length();
    let own = sectors.faces[c as usize / 3].area_vector;
    let other = sectors.faces[o as usize / 3].area_vector;
    let share = own.cross(other).dot(along / length).atan2(own.dot(other)) / length;
    if share.is_finite() { share } else { 0.0 }
}

/// The second fundamental form on the faces around a vertex.
pub(super) struct Ring {
    pub turns: Vec<f64>,
    /// 1, or [`MEPP_SHARE`].
    pub share: f64,
}

impl Ring {
    /// The form at a sector and the area around it.
    pub fn at(&self, sectors: &Sectors<'_>, sector: u32, plane: &Frame) -> (Form, f64) {
        let t = &sectors.triangles;
        let mut sum = Form::default();
        // Every inner edge of a sector leaves one of its corners.
        for &c in sectors.corners(sector) {
            let half = 0.5 * self.turns[c as usize];
            sum = sum.plus(half, plane.square(t.point(t.next(c)) - t.point(c)));
        }
        let area = sectors.fans[sector as usize].area;
        if !(area > NO_AREA) {
            return (Form::default(), 0.0);
        }
        (Form::default().plus(3.0 * self.share / area, sum.turned()), area)
    }
}
