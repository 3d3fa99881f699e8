//! Geometry: untangling and smoothing.
//!
//! 1. While a determinant is not positive: minimise the regularised energy, ε following the worst one (energy.rs); first for
//!    the folded cells of a large mesh and their surroundings alone (untangle.rs), then for all, or the other way round.
//! 2. Then ε = 0: the energy is infinite outside the valid set, which no step leaves. The power p rises, so that the
//!    worst cells count more and more; target lengths follow the cells, so that only angles are asked for.
//! 3. Bernstein certificate of every cell; where some have none, the springs are loosened, those cells get more weight,
//!    and step 2 is repeated.
//!
//! 4. The worst cells once more, with their surroundings alone; there the least scaled Jacobian itself is raised (corners.rs), and
//!    before and after that the mean of all (mean.rs).
//!
//! The cells at work and one descent are in optimiser.rs, these steps in steps.rs, how hard each is tried in effort.rs.
//!
//! Wall vertices are tied to where they belong by springs, stiff along the normal and weak along the surface.

mod corners;
mod effort;
mod energy;
mod mean;
mod onto_surface;
mod optimiser;
mod patches;
mod simd;
#[cfg(test)]
mod slopes;
mod steps;
mod tuning;
mod untangle;
mod worst_cells;

pub use effort::{COARSE, Effort, FINE, INNER, PASSING};
pub use onto_surface::seat;
pub use optimiser::{Optimiser, Spring};
pub use patches::Ties;
pub use worst_cells::{polish, relieve};
