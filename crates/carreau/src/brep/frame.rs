//! Local coordinate systems, and the motions that carry models about.

use glam::{DMat3, DVec2, DVec3};

/// A right-handed orthonormal frame: where a curve or a surface stands, and which way it is turned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// The origin.
    pub origin: DVec3,
    /// The axis: normal of planes and conics, axis of rotation of everything round. A unit vector.
    pub z: DVec3,
    /// Where angles begin. A unit vector perpendicular to `z`.
    pub x: DVec3,
}

impl Frame {
    /// The frame with this origin and axis, turned so that x is as near to `towards` as it can be; any x where `towards` is
    /// parallel to the axis. An axis without length gives z.
    pub fn new(origin: DVec3, axis: DVec3, towards: DVec3) -> Self {
        let z = axis.normalize_or(DVec3::Z);
        let x = (towards - z * towards.dot(z)).normalize_or(z.any_orthonormal_vector());
        // Once more, because the difference of nearly parallel vectors is not exactly perpendicular.
        let x = (x - z * x.dot(z)).normalize_or(z.any_orthonormal_vector());
        Frame { origin, z, x }
    }

    /// The frame with this origin and axis, and any x.
    pub fn along(origin: DVec3, axis: DVec3) -> Self {
        let z = axis.normalize_or(DVec3::Z);
        Frame { origin, z, x: z.any_orthonormal_vector() }
    }

    /// The third direction.
    pub fn y(&self) -> DVec3 {
        self.z.cross(self.x)
    }

    /// Coordinates of a point in the frame.
    pub fn local(&self, p: DVec3) -> DVec3 {
        let offset = p - self.origin;
        DVec3::new(offset.dot(self.x), offset.dot(self.y()), offset.dot(self.z))
    }

    /// The point with these coordinates.
    pub fn global(&self, local: DVec3) -> DVec3 {
        self.origin + self.vector(local)
    }

    /// The vector with these components.
    pub fn vector(&self, local: DVec3) -> DVec3 {
        local.x * self.x + local.y * self.y() + local.z * self.z
    }

    /// The unit vector at an angle from x, about z.
    pub fn radial(&self, angle: f64) -> DVec3 {
        let (sin, cos) = angle.sin_cos();
        cos * self.x + sin * self.y()
    }

    /// Distance from the axis and height.
    pub fn profile(&self, p: DVec3) -> DVec2 {
        let l = self.local(p);
        DVec2::new(l.x.hypot(l.y), l.z)
    }

    /// The angle of a point about the axis, in [−π, π]; 0 on the axis.
    pub fn angle(&self, p: DVec3) -> f64 {
        let l = self.local(p);
        l.y.atan2(l.x)
    }

    /// Whether the directions are unit vectors at a right angle, and the origin is finite.
    pub fn is_sound(&self) -> bool {
        let unit = |d: DVec3| (d.length() - 1.0).abs() < 1e-9;
        self.origin.is_finite() && unit(self.z) && unit(self.x) && self.z.dot(self.x).abs() < 1e-9
    }

    /// The frame after a motion.
    pub fn moved(&self, by: &Motion) -> Self {
        Frame { origin: by.point(self.origin), z: by.rotation * self.z, x: by.rotation * self.x }
    }
}

/// A similarity without reflection: p ↦ scale · rotation · p + translation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion {
    /// A rotation.
    pub rotation: DMat3,
    /// Above 0.
    pub scale: f64,
    /// Applied last.
    pub translation: DVec3,
}

impl Motion {
    /// The motion that changes nothing.
    pub const IDENTITY: Motion = Motion { rotation: DMat3::IDENTITY, scale: 1.0, translation: DVec3::ZERO };

    /// Where a point goes.
    pub fn point(&self, p: DVec3) -> DVec3 {
        self.scale * (self.rotation * p) + self.translation
    }
}
