//! Room 3: quad patches on the vertices of a triangle mesh.
//!
//! Bénière, Subsol, Gesquière, Le Breton, Puech: *Décomposition d'un maillage triangulaire 3D en carreaux
//! quadrangulés*, REFIG 5(1), 2011. Pairs of adjacent triangles become quads, quads become `m × n` grids; no vertex is
//! moved or added, and every grid line is a path of mesh edges. What fits no grid stays a triangle. The result is a
//! surface that CAD systems read as B-spline faces.
//!
//! | stage | file | paper |
//! |---|---|---|
//! | which pairs are quads, and how good | `quality` | §3.1, equation 1 |
//! | zones of quads | `zones` | §3.2 |
//! | or: the optimal choice of quads | `pairing` | – |
//! | rows and columns, polygons with walls | `positions`, `polygon` | §3.3, figures 5–7 |
//! | rectangles, greedily or as few as possible | `rectangles`, `dissection` | §3.3, figures 8–9 |
//! | or: all of this at once | `growth` | §5 |
//! | merging of patches | `merge` | §5 |
//! | the check of every result | `validate` | – |
//! | figures | `statistics` | table 1 |
//!
//! Where this departs from the paper:
//! - Corner angles are sums of triangle angles. With angles in 0..π, as a quad's own angles are usually taken, Q could
//!   never exceed π/2 and the limit Q_max would do nothing.
//! - The default strategy, [`Strategy::Grow`], grows rectangles on the triangles instead of choosing quads first and
//!   cutting them into rectangles later: a quarter of the patches for the same coverage. `PatchOptions::paper()` gives
//!   the paper's pipeline.
//! - A polygon has walls as well as cells: quads may lie side by side in the layout without sharing a mesh edge, which
//!   the paper does not mention.

mod concave;
mod dissection;
mod grid;
mod polygon;
mod rectangles;
#[cfg(test)]
mod samples;

pub use dissection::minimum;
pub use grid::Patch;
pub use polygon::{Cell, NONE, Polygon, Rectangle};
pub use rectangles::{CornerRule, greedy};
