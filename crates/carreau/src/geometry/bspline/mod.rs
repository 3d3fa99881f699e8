//! B-spline curves and tensor-product surfaces with clamped knots, polynomial, of degree 1 to 3.
//!
//! Source: Piegl and Tiller, The NURBS Book, 2nd ed., Springer 1997; the numbers of equations and algorithms are theirs.

mod curve;
mod knots;
mod surface;
mod tuning;

pub use curve::BSplineCurve;
pub use knots::{Knots, MAX_DEGREE};
pub use surface::{BSplineSurface, Jet};
