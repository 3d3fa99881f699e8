//! Words and numbers of the format.

/// The version of carreau, for the header.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");
/// Sequence numbers have seven digits.
pub const MAX_LINES: u32 = 9_999_999;

/// Status number of an entity that stands for itself; two digits each for blank, subordinate, use, hierarchy.
pub const INDEPENDENT: &str = "00000000";
/// Status number of an entity that belongs to another.
pub const DEPENDENT: &str = "00010000";
/// Status number of such a curve in the parameter plane.
pub const PARAMETRIC: &str = "00010500";
