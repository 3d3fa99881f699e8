//! Repair: from a surface as found in a file to manifold sheets with a consistent outside.
//!
//! | step | file | what happens | option |
//! |---|---|---|---|
//! | 1 | `super::weld` | vertices at one place become one | `weld` |
//! | 2 | `degenerate` | faces without area go, the surface stays closed | `degenerate` |
//! | 3 | `super::prepare` | of several faces on the same vertices one stays, two between bodies | `duplicates` |
//! | 4 | `super::prepare` | neighbours are turned until they agree | `orient` |
//! | 5 | `super::prepare` | bodies that touch come apart; what is still not manifold is cut into sheets | `split` |
//! | 6 | `orient` | closed components look outward, cavities inward | `outward` |
//! | 7 | `soup` | unreferenced vertices are dropped | `unreferenced` |
//!
//! Steps 2 to 6 are those of the preparation that every verb makes, but for the cuts (Guéziec, Taubin, Lazarus, Horn, "Cutting and
//! Stitching: Converting Sets of Polygons to Manifold Surfaces", IEEE TVCG 2001, global cutting): corners of a vertex stay together
//! only where a chain of edges of two sides links their faces.
//!
//! ```text
//!   ╲ │ ╱            ╲ │ ╱
//!    ╲│╱              ╲│╱
//!     •       →        •        two umbrellas, two vertices at one place
//!    ╱│╲               •
//!   ╱ │ ╲             ╱│╲
//! ```
//!
//! The order matters: welding makes degenerate and duplicate faces, both hide the sense and the umbrellas of their
//! neighbours, and what is outside can only be told once bodies that touched are separate. Holes are not filled. A
//! repaired mesh is left as it is by a second repair with the same options.

pub(super) mod degenerate;
mod flaws;
mod options;
mod orient;
mod report;
mod run;
mod sound;
mod soup;
#[cfg(test)]
mod tests;

pub(crate) use flaws::is_flawed;
pub(super) use flaws::is_umbrella;
pub use options::RepairOptions;
pub(super) use orient::outward;
pub use report::RepairReport;
pub use run::{Repaired, repair};
pub(crate) use sound::divided;
pub use sound::sound;
pub(super) use soup::Soup;
