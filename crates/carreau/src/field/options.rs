//! What frames follow, and how.

use crate::bounds::within;
use crate::error::Result;
use crate::geometry::features::FeatureOptions;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// A weight: directions of curvature do not count more, because nothing but them would.
pub(crate) const MOST_CURVATURE_WEIGHT: f64 = 1e3;

/// Which corners are pinned to one quad.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Pin {
    /// None, and no repair: the classic field.
    #[serde(rename = "none")]
    None,
    /// Those below 45°.
    #[serde(rename = "45")]
    Below45,
    /// Those below 90°.
    #[default]
    #[serde(rename = "90")]
    Below90,
}

/// How far the rotation that pins ask for spreads.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Propagation {
    /// Not at all.
    None,
    /// Over a few hundredths of the root of the area.
    #[default]
    Local,
    /// Everywhere.
    Global,
}

/// Options of [`field`](super::field()).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct FieldOptions {
    /// What the frames are aligned with.
    #[serde(skip)]
    pub features: FeatureOptions,
    /// The frames stay orthogonal.
    pub orthogonal: bool,
    /// Which corners are pinned.
    pub pin: Pin,
    /// How far they reach.
    pub propagation: Propagation,
    /// Largest angle between the branches away from 90°, in degrees.
    pub lean_deg: f64,
    /// Weight of the directions of curvature beside the smoothness: 0 for none; with 1 they count where the field would turn from
    /// one of them to the next within the radius of the curvature.
    pub curvature: f64,
    /// Segments on the surface that the frames follow.
    #[serde(skip)]
    pub guides: Vec<[DVec3; 2]>,
}

impl Default for FieldOptions {
    fn default() -> Self {
        let (features, pin, propagation) = (FeatureOptions::auto(), Pin::default(), Propagation::default());
        FieldOptions {
            features,
            orthogonal: false,
            pin,
            propagation,
            lean_deg: 60.0,
            curvature: 0.0,
            guides: Vec::new(),
        }
    }
}

impl FieldOptions {
    /// These options for the classic field: smoothest, orthogonal, no corner pinned or repaired.
    pub fn classic(&self) -> Self {
        FieldOptions { orthogonal: true, pin: Pin::None, ..self.clone() }
    }

    /// Refuses values out of range.
    ///
    /// # Errors
    /// [`Error::Options`](crate::Error::Options).
    pub fn validate(&self) -> Result<()> {
        self.features.validate()?;
        within("lean", self.lean_deg, 0.0..90.0, "degrees")?;
        within("curvature", self.curvature, 0.0..=MOST_CURVATURE_WEIGHT, "")
    }
}
