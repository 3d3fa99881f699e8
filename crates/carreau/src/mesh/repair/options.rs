//! What is repaired.

use crate::error::{Error, Result};
use crate::length::Length;
use crate::mesh::prepare::Steps;
use serde::{Deserialize, Serialize};

/// Which steps to take. By default all, with vertices welded at exactly equal positions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct RepairOptions {
    /// Weld vertices nearer than this; 0: at exactly equal positions; `None`: not at all.
    pub weld: Option<Length>,
    /// Remove repeated corners, slivers and faces without area.
    pub degenerate: bool,
    /// Drop all but the first of the faces on the same vertices, in whatever sense.
    pub duplicates: bool,
    /// Turn faces so that neighbours agree.
    pub orient: bool,
    /// Cut along non-manifold edges and at non-manifold vertices.
    pub split: bool,
    /// Turn closed components outward, and cavities (components nested in an odd number of others) inward.
    pub outward: bool,
    /// Drop vertices that no face uses.
    pub unreferenced: bool,
}

impl Default for RepairOptions {
    fn default() -> Self {
        RepairOptions {
            weld: Some(Length::Absolute(0.0)),
            degenerate: true,
            duplicates: true,
            orient: true,
            split: true,
            outward: true,
            unreferenced: true,
        }
    }
}

impl RepairOptions {
    pub(super) fn steps(&self) -> Steps {
        Steps {
            degenerate: self.degenerate,
            doubles: self.duplicates,
            orient: self.orient,
            sheets: self.split,
            cut: self.split,
            outward: self.outward,
        }
    }

    /// Refuses a tolerance that is no length.
    ///
    /// # Errors
    /// [`Error::Options`].
    pub fn validate(&self) -> Result<()> {
        self.weld.map_or(Ok(()), |tolerance| resolved(tolerance, 1.0).map(drop))
    }
}

pub fn resolved(tolerance: Length, diagonal: f64) -> Result<f64> {
    let length = tolerance.resolve(diagonal);
    if length >= 0.0 && length.is_finite() {
        return Ok(length);
    }
    Err(Error::Options(format!("weld: {tolerance} is not a length such as 0.01 or 0.001%")))
}
