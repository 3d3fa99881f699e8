//! Step 5: the surface is cut into manifold sheets.
//!
//! Guéziec, Taubin, Lazarus, Horn, "Cutting and Stitching: Converting Sets of Polygons to Manifold Surfaces", IEEE TVCG
//! 2001, global cutting: corners of a vertex stay together only where a chain of regular edges links their faces; every
//! further chain gets a vertex of its own.
//!
//! ```text
//!   ╲ │ ╱            ╲ │ ╱
//!    ╲│╱              ╲│╱
//!     •       →        •        two umbrellas, two vertices at one place
//!    ╱│╲               •
//!   ╱ │ ╲             ╱│╲
//! ```
//!
//! A chain has at most two ends, so an edge between two new vertices has at most two faces: no stitching is needed for
//! the result to be manifold, and two bodies that touch along an edge come apart as two closed bodies.

use super::soup::Soup;
use crate::context::Context;
use crate::error::Result;
use crate::mesh::prepare::Sheets;
use crate::mesh::surface::SurfaceMesh;

/// Duplicates vertices until no edge has more than two faces and no vertex more than one umbrella. Bodies that touch are told
/// apart first; what is left is cut. Returns the number of new vertices. Faces that use a vertex twice are left alone.
pub fn into_sheets(soup: &mut Soup, original: &SurfaceMesh, context: &Context) -> Result<usize> {
    let before = soup.points.len();
    Sheets::of(soup, original, context)?.separate(soup, original, true);
    // A body that touches itself in one edge cannot come apart there: it is cut.
    if soup.half_edges().groups().any(|edge| edge.len() > 2) {
        Sheets::without_pairs(soup).separate(soup, original, true);
    }
    Ok(soup.points.len() - before)
}
