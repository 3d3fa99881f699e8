//! Points moved into a box of size about one at the origin, and surfaces moved back.
//!
//! Squares of coordinates then neither overflow nor lose the shape to a large offset. The scale is a power of two, so it
//! rounds nothing: fits of scaled points are the scaled fits, bit for bit.

use super::shape::Primitive;
use glam::DVec3;

/// Scale outside of which the reciprocal or the scaled radii could leave the range of `f64`.
const LARGEST_EXPONENT: i32 = 1000;

/// x ↦ (x − origin) · scale
#[derive(Debug, Clone, Copy)]
pub(super) struct UnitBox {
    origin: DVec3,
    scale: f64,
}

impl UnitBox {
    /// The box of the points; `None` without points, where they coincide, or where a coordinate is not finite or out of
    /// range.
    pub fn of(points: &[DVec3]) -> Option<Self> {
        let first = *points.first()?;
        let (min, max) = points.iter().fold((first, first), |(min, max), p| (min.min(*p), max.max(*p)));
        let size = (max - min).max_element();
        // `min` and `max` pass over NaN.
        if !(size > 0.0 && size.is_finite() && points.iter().all(|p| p.is_finite())) {
            return None;
        }
        let exponent = size.log2().round();
        let within = exponent.abs() <= f64::from(LARGEST_EXPONENT);
        within.then(|| UnitBox { origin: min + (max - min) * 0.5, scale: (-exponent).exp2() })
    }

    /// Into the box.
    pub fn enter(&self, p: DVec3) -> DVec3 {
        (p - self.origin) * self.scale
    }

    /// Out of the box; `None` where a number leaves the range of `f64`.
    pub fn leave(&self, surface: Primitive) -> Option<Primitive> {
        let moved = surface.moved(|p| p / self.scale + self.origin, |r| r * self.scale.recip());
        moved.is_sound().then_some(moved)
    }

    /// A surface into the box; `None` where it is not sound.
    pub fn enter_surface(&self, surface: Primitive) -> Option<Primitive> {
        let moved = surface.moved(|p| self.enter(p), |r| r * self.scale);
        moved.is_sound().then_some(moved)
    }

    /// A length in the box as a length outside.
    pub fn length_outside(&self, x: f64) -> f64 {
        x / self.scale
    }

    /// A length outside as a length in the box.
    pub fn length_inside(&self, x: f64) -> f64 {
        x * self.scale
    }
}

#[cfg(test)]
mod tests {
    use super::super::shape::Kind;
    use super::*;

    #[test]
    fn surfaces_come_back_as_they_went() {
        let points = [DVec3::new(7.0, -2.0, 1e3), DVec3::new(-5.0, 3.0, 1001.0)];
        let unit = UnitBox::of(&points).unwrap();
        assert!(points.iter().all(|p| unit.enter(*p).abs().max_element() <= 1.0));
        let torus = Primitive::Torus { center: points[0], axis: DVec3::Y, major_radius: 3.0, minor_radius: 0.3 };
        assert_eq!(unit.leave(unit.enter_surface(torus).unwrap()), Some(torus));
        assert_eq!(unit.enter_surface(torus).unwrap().kind(), Kind::Torus);
    }

    #[test]
    fn sizes_out_of_range_are_refused() {
        for size in [0.0, f64::NAN, f64::INFINITY, f64::MAX, f64::MIN_POSITIVE / 8.0] {
            assert!(UnitBox::of(&[DVec3::splat(-size), DVec3::splat(size)]).is_none(), "{size}");
        }
        assert!(UnitBox::of(&[]).is_none());
        assert!(UnitBox::of(&[DVec3::ZERO, DVec3::new(1.0, f64::NAN, 0.0)]).is_none());
    }
}
