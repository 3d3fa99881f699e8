//! How noisy a surface is.

use serde::{Deserialize, Serialize};

/// Free tips per length, in edges of the usual size, from which sharp edges are looked at one by one. Parts have up to .16 and
/// scans .26 to 3.2.
pub const NOISY: f64 = 0.2;

/// How noisy the sharp edges of a surface are.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Noise {
    /// Free tips of sharp edges over their length, times the length of an edge of the usual size.
    pub tips: f64,
    /// The same for the pieces that they are in.
    pub pieces: f64,
    /// Root mean square of the angles at the other edges, in degrees.
    pub spread_deg: f64,
}

impl Noise {
    /// Whether sharp edges are noise to a part.
    pub fn is_high(&self) -> bool {
        self.tips >= NOISY
    }
}
