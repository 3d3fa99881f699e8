//! Primitive surfaces of mechanical parts: planes, spheres, cylinders, cones and tori; distance, normal and fit.
//!
//! | file | holds |
//! |---|---|
//! | `anchored` | primitives in a form that stays regular where radii grow to infinity, with derivatives: what is minimised |
//! | `unit` | points moved into a box of size one at the origin, and surfaces moved back |
//! | `refine` | orthogonal least squares from a start |
//! | `axis` | axes from normals (kinematic fit) and from the spread of points |
//! | `circle` | circles and lines through profile points |
//! | `paraboloid` | principal directions of a patch of points |
//! | `starts` | start values for every kind |
//! | `fit` | best fit of a kind, the simplest kind that will do |
//! | `robust` | fits that outliers do not spoil |

mod anchored;
mod axis;
mod circle;
mod fit;
mod paraboloid;
mod refine;
mod robust;
mod shape;
mod starts;
#[cfg(test)]
mod tests;
mod unit;

pub(crate) use circle::circle;
pub use fit::{Demand, Scratch, fit, fit_within, simplest};
pub use refine::{Fit, refine};
pub use robust::{RobustFit, fit_robust};
pub use shape::{Kind, Primitive};
