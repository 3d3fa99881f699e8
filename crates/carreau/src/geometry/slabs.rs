//! Slabs: what a node of a search tree holds, between two planes across its mean normal.
//!
//! A box around a piece of surface that is tilted against the axes is about as deep as wide. From the middle of a tube all
//! pieces around are nearly as far away, and each box reaches nearer than what it holds: none can be left out. A slab is as
//! deep as its piece is bent, a small part of its width.
//!
//! ```text
//!   ┌────────╱╱┐
//!   │      ╱╱  │      the piece and its slab are tilted, the box is not
//!   │    ╱╱    │
//!   │  ╱╱      │    ·  looked at from here
//!   └╱╱────────┘
//! ```

use glam::DVec3;

/// The points between two planes.
#[derive(Clone, Copy)]
pub struct Slab {
    normal: DVec3,
    low: f64,
    high: f64,
}

impl Slab {
    /// The slab of some points across a direction; without a direction it is all of space.
    pub fn around(points: impl Iterator<Item = DVec3>, direction: DVec3) -> Self {
        let normal = direction.normalize_or_zero();
        let (low, high) = points
            .map(|p| normal.dot(p))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), t| (low.min(t), high.max(t)));
        Slab { normal, low, high }
    }

    /// Squared distance of a point.
    #[inline]
    pub fn distance_squared(&self, p: DVec3) -> f64 {
        let t = self.normal.dot(p);
        let off = (self.low - t).max(t - self.high).max(0.0);
        off * off
    }
}
