//! Boxes along the axes.

use glam::DVec3;

#[derive(Clone, Copy)]
pub struct Box3 {
    pub(super) low: DVec3,
    pub(super) high: DVec3,
}

impl Box3 {
    pub const EMPTY: Box3 = Box3 { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY };

    #[inline]
    pub(super) fn around([a, b, c]: [DVec3; 3]) -> Box3 {
        Box3 { low: a.min(b).min(c), high: a.max(b).max(c) }
    }

    pub(super) fn with(self, p: DVec3) -> Box3 {
        Box3 { low: self.low.min(p), high: self.high.max(p) }
    }

    #[inline]
    pub(super) fn meets(&self, other: &Box3) -> bool {
        self.low.cmple(other.high).all() && other.low.cmple(self.high).all()
    }

    #[inline]
    pub(super) fn distance_squared(&self, p: DVec3) -> f64 {
        p.distance_squared(p.clamp(self.low, self.high))
    }

    /// The slab test; the order of the arguments of min and max drops the NaN of 0 · ∞.
    #[inline]
    pub(super) fn meets_ray(&self, origin: DVec3, inverse: DVec3, t_max: f64) -> bool {
        let (mut enter, mut leave) = (0f64, t_max);
        for k in 0..3 {
            let (a, b) = ((self.low[k] - origin[k]) * inverse[k], (self.high[k] - origin[k]) * inverse[k]);
            // A box is widened by a few rounding errors: it must not be missed where its triangle is met.
            let slack = 4.0 * f64::EPSILON * a.abs().max(b.abs());
            enter = (a.min(b) - slack).max(enter);
            leave = (a.max(b) + slack).min(leave);
        }
        enter <= leave
    }
}
