//! How much an edge may bend.

/// What dihedral angles must respect, as cosines of the angle between the normals of the two faces.
#[derive(Debug, Clone, Copy)]
pub struct Dihedral {
    /// Smooth edges stay above.
    pub smooth: f64,
    /// Sharp ridges stay below.
    pub ridge: f64,
}

impl Dihedral {
    /// A little inside of what is asked for: ridges above `feature_angle`, in degrees, and none besides.
    pub fn within(feature_angle: f64) -> Self {
        Dihedral { smooth: (0.97 * feature_angle).to_radians().cos(), ridge: (0.6 * feature_angle).to_radians().cos() }
    }
}
