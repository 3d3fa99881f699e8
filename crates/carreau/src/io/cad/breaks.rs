//! Faces that readers would integrate wrongly.

use crate::brep::{Brep, Face, Surface};
use crate::geometry::bspline::BSplineSurface;
use glam::DVec3;

/// Grid lines where the area vector ∂x/∂u × ∂x/∂v jumps by more than this share of its length are breaks: a twentieth is a
/// bend by three degrees, or two neighbouring cells of a flat face whose widths differ by 5 %.
pub const BREAK: f64 = 0.05;

/// Whether a face is written with its border in the parameter plane: trimmed faces, and those with breaks. Readers
/// integrate over a face between the breaks of its border curves; where these are missing, areas and volumes come out wrong
/// by up to 1e-3 of the face in OpenCASCADE, on flat faces with cells of unequal size as on bent ones.
pub fn needs_parameter_curves(brep: &Brep, face: &Face) -> bool {
    face.trimmed || matches!(brep.surface(face), Surface::Spline(surface) if has_breaks(surface))
}

/// Whether the area vector of a surface of degree (1, 1) jumps across some grid line. It is linear along the line between
/// two grid points, so the grid points tell.
///
/// ```text
///   q ─ q ─ q      Across the line p q the vectors (p − p₋) × (q − p) and (p₊ − p) × (q − p) meet at p,
///   │   │   │      (q − q₋) × (q − p) and (q₊ − q) × (q − p) at q.
///   p₋─ p ─ p₊
/// ```
pub fn has_breaks(surface: &BSplineSurface) -> bool {
    let [u, v] = surface.knots();
    if u.degree() != 1 || v.degree() != 1 {
        return false;
    }
    let (cols, rows) = (u.count(), v.count());
    let across_columns = |r: usize, c: usize| surface.control(c, r);
    let across_rows = |r: usize, c: usize| surface.control(r, c);
    breaks_across_columns(rows, cols, across_columns) || breaks_across_columns(cols, rows, across_rows)
}

/// [`has_breaks`] for the grid lines of constant column.
pub fn breaks_across_columns(rows: usize, cols: usize, point: impl Fn(usize, usize) -> DVec3) -> bool {
    let jumps = |r: usize, c: usize, along: DVec3| {
        let (before, after) = (point(r, c) - point(r, c - 1), point(r, c + 1) - point(r, c));
        let (before, after) = (before.cross(along), after.cross(along));
        before.distance(after) > BREAK * before.length().max(after.length())
    };
    (1..cols.saturating_sub(1)).any(|c| {
        (1..rows).any(|r| {
            let along = point(r, c) - point(r - 1, c);
            jumps(r - 1, c, along) || jumps(r, c, along)
        })
    })
}
