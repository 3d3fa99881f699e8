//! How a skeleton is sought.

use crate::bounds::within;
use crate::error::Result;
use serde::{Deserialize, Serialize};
use std::ops::Bound;

/// Options of [`extract`](super::extract); the defaults are the paper's.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct SkeletonOptions {
    /// Weight that pulls a vertex back to its place, above 0 to 10. Larger values make the flow slower and follow the shape more
    /// closely.
    pub speed: f64,
    /// Weight that pulls a vertex to the centre of its inner ball, above 0 to 10.
    pub medial: f64,
    /// Edges shorter than this are collapsed, as a share of the diagonal, above 0 to .1.
    pub detail: f64,
    /// Drop branches that end within the ball of their branching (stubs).
    pub prune: bool,
}

impl Default for SkeletonOptions {
    fn default() -> Self {
        SkeletonOptions { speed: 0.1, medial: 0.2, detail: 0.002, prune: true }
    }
}

impl SkeletonOptions {
    /// Refuses values out of range.
    ///
    /// # Errors
    /// [`Error::Options`](crate::Error::Options).
    pub fn validate(&self) -> Result<()> {
        let above_zero = |most: f64| (Bound::Excluded(0.0), Bound::Included(most));
        within("speed", self.speed, above_zero(10.0), "")?;
        within("medial", self.medial, above_zero(10.0), "")?;
        within("detail", self.detail, above_zero(0.1), "")
    }
}
