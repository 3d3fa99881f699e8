//! Interpolated corrected curvature measures over the faces around a vertex.
//!
//! Source: Lachaud, Romon, Thibert, Coeurjolly, "Interpolated corrected curvature measures for polygonal surfaces",
//! Computer Graphics Forum 2020. With normals u_i at the corners x_i of a triangle, ū their mean, X and Y any vectors:
//!
//! ```text
//! μ⁰    = ½ ū · (x_j − x_i) × (x_k − x_i)
//! μ^X,Y = ½ ū · [ (Y · (u_k − u_i)) X × (x_j − x_i) − (Y · (u_j − u_i)) X × (x_k − x_i) ]
//! ```
//!
//! −Σ μ^X,Y / Σ μ⁰ over the faces is the second fundamental form, positive where the surface is convex. As a matrix,
//! −μ^X,Y = ½ [(b × ū)(u_j − u_i)ᵀ + (ū × a)(u_k − u_i)ᵀ] with a = x_j − x_i, b = x_k − x_i.
//!
//! Departures: the normals are those of [`super::sectors`], so that nothing leaks over creases; Σ μ⁰ is not let below half the
//! area, which matters only where the normals contradict the faces, and keeps every quotient finite.

use super::per_vertex::map;
use super::sectors::Sectors;
use super::tensor::{Form, Frame, Tensor};
use super::tuning::NO_AREA;
use crate::context::Context;
use crate::error::Result;

/// The measures of one triangle.
#[derive(Clone, Copy, Default)]
struct Measures {
    /// −μ^X,Y, symmetrised.
    bending: Tensor,
    /// μ⁰
    area: f64,
}

/// The measures of all triangles.
pub(super) struct Corrected {
    triangles: Vec<Measures>,
}

impl Corrected {
    pub fn new(sectors: &Sectors<'_>, context: &Context) -> Result<Self> {
        Ok(Corrected { triangles: map(sectors.triangles.len(), context, |t| measures(sectors, t))? })
    }

    /// Second fundamental form at a sector and the area of the faces that it is the mean over.
    #[inline]
    pub fn at(&self, sectors: &Sectors<'_>, sector: u32, plane: &Frame) -> (Form, f64) {
        let mut sum = Measures::default();
        for &c in sectors.corners(sector) {
            let triangle = &self.triangles[c as usize / 3];
            sum.bending += triangle.bending;
            sum.area += triangle.area;
        }
        let area = sectors.fans[sector as usize].area;
        let corrected = sum.area.max(0.5 * area);
        if !(corrected > NO_AREA) {
            return (Form::default(), 0.0);
        }
        (Form::default().plus(1.0 / corrected, sum.bending.on(plane)), area)
    }
}

#[inline]
fn measures(sectors: &Sectors<'_>, t: u32) -> Measures {
    let (c, points) = (3 * t as usize, sectors.triangles.points());
    let [i, j, k] = sectors.triangles.triangle(t);
    let normal = |corner: usize| sectors.fans[sectors.of_corner[corner] as usize].normal;
    let (u, v, w) = (normal(c), normal(c + 1), normal(c + 2));
    let mean = (u + v + w) / 3.0;
    let (a, b) = (points[j as usize] - points[i as usize], points[k as usize] - points[i as usize]);
    let mut bending = Tensor::product(0.5 * b.cross(mean), v - u);
    bending += Tensor::product(0.5 * mean.cross(a), w - u);
    Measures { bending, area: mean.dot(sectors.faces[t as usize].area_vector) }
}
