//! Constants of hexes in surfaces.

use crate::hex::fork_trunks;

/// Number of cells, in all attempts together, after which no other skeleton is tried.
pub const MANY_TRIED: usize = 150_000;

/// Directions closer than this get a trunk, in degrees: both are tried with every share. Cells in wider forks have better
/// shapes, but limbs beside each other on a body are none.
pub const NARROW: [f64; 2] = [fork_trunks::CLOSE_DEGREES, fork_trunks::NARROW_DEGREES];
/// A boundary this near to the surface, as a share of the diagonal, needs no second try.
pub const WELL: f64 = 0.02;
