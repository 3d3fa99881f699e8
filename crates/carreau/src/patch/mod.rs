//! Room 3: quad patches on the vertices of a triangle mesh.
//!
//! Bénière, Subsol, Gesquière, Le Breton, Puech: *Décomposition d'un maillage triangulaire 3D en carreaux
//! quadrangulés*, REFIG 5(1), 2011. Pairs of adjacent triangles become quads, quads become `m × n` grids; no vertex is
//! moved or added, and every grid line is a path of mesh edges. What fits no grid stays a triangle. The result is a
//! surface that CAD systems read as B-spline faces.
//!
//! | stage | file | paper |
//! |---|---|---|
//! | options; the result | `options`, `result` | – |
//! | the order of the stages | `decomposition` | – |
//! | edges that limit patches | `creases` | §5 |
//! | which pairs are quads, and how good | `quality` | §3.1, equation 1 |
//! | which reflex quads fold too much | `fold` | – |
//! | zones of quads | `zones` | §3.2 |
//! | or: the optimal choice of quads | `pairing` | – |
//! | rows and columns, polygons with walls | `positions`, `polygon` | §3.3, figures 5–7 |
//! | rectangles, greedily or as few as possible | `rectangles`, `dissection` | §3.3, figures 8–9 |
//! | or: all of this at once | `growth` | §5 |
//! | merging of patches | `merge` | §5 |
//! | the check of every result | `validate` | – |
//! | CAD faces: exact, bicubic or trimmed | `cad/` | §4, §5 |
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

pub mod cad;
mod concave;
mod creases;
mod decomposition;
mod dissection;
mod fold;
mod grid;
mod growth;
mod merge;
mod options;
mod output;
mod pairing;
mod polygon;
mod positions;
mod quality;
mod rectangles;
mod result;
#[cfg(test)]
mod samples;
mod statistics;
#[cfg(test)]
mod tests;
mod validate;
mod zones;

pub use decomposition::decompose;
pub use grid::Patch;
pub use options::{Dissection, PatchOptions, Strategy};
pub use output::quad_mesh;
pub use polygon::{Cell, Polygon};
pub use positions::Policy;
pub use quality::Quality;
pub use result::{PatchResult, PolygonLayout};
pub use statistics::{Figures, coverage, patches_needed};
pub use validate::{Promises, validate};
