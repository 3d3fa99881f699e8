//! What layers are asked for, and what became of them.

use crate::mesh::UnitScale;
use serde::{Deserialize, Serialize};

/// Boundary layers that are asked for.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Layers {
    /// Number of layers.
    pub count: u32,
    /// Thickness of the first one, on the wall, in the unit of the file.
    pub first: f64,
    /// Thickness of a layer divided by that of the one before it.
    pub growth: f64,
}

/// Default growth: the usual value for solvers of turbulent flow.
pub const GROWTH: f64 = 1.2;
/// Most layers: more of them would be thicker than any tube.
pub const MOST_LAYERS: u32 = 50;
/// Largest growth: the third layer would be nine times as thick as the first.
pub const STEEPEST: f64 = 3.0;

/// What has become of layers; lengths in the unit of the file.
#[derive(Debug, Clone, Serialize)]
pub struct LayerFigures {
    /// What was asked for.
    #[serde(flatten)]
    pub asked: Layers,
    /// Total thickness asked for.
    pub thickness: f64,
    /// Share of the wall's area where the layers have that thickness within 10 %, measured along the normal.
    pub as_asked: f64,
    /// Smallest thickness, as a share of the one asked for.
    pub least: f64,
    /// The place of the smallest thickness.
    pub least_at: [f64; 3],
}

impl Layers {
    /// The same lengths in another scale.
    pub(in crate::hex) fn in_scale(self, scale: UnitScale) -> Layers {
        Layers { first: scale.length(self.first), ..self }
    }

    /// Total thickness of all layers.
    pub fn thickness(&self) -> f64 {
        self.first * self.heights().iter().sum::<f64>()
    }

    /// The thickness of every layer from the wall inwards, as a multiple of the first.
    pub(super) fn heights(&self) -> Vec<f64> {
        (0..self.count as i32).map(|k| self.growth.powi(k)).collect()
    }
}
