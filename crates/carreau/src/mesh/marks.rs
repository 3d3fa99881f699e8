//! What stands for the opposite corner where there is none.

/// Opposite of a corner whose edge has one face only.
pub const BORDER: u32 = u32::MAX;
/// Opposite of a corner whose neighbour is oriented against it.
pub const INCONSISTENT: u32 = u32::MAX - 1;
/// Opposite of a corner whose edge has more than two faces; all marks are at least this.
pub const NON_MANIFOLD: u32 = u32::MAX - 2;
/// Ids from here up are marks.
pub const FIRST_MARK: u32 = NON_MANIFOLD;
