//! Sharp edges that are no features.

use glam::DVec3;

/// A strand of edges above the angle that are no features.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DroppedStrand {
    /// Its length.
    pub length: f64,
    /// The middle of its longest edge.
    pub place: DVec3,
}
