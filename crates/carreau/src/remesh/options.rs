//! How a mesh is graded.

use crate::bounds::{angle, positive, within};
use crate::error::{Error, Result};
use crate::geometry::features::Creases;
use crate::mesh::VertexId;
use serde::{Deserialize, Serialize};
use std::ops::Bound;

/// Options of [`enrich`](super::enrich) and [`simplify`](super::simplify).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct RemeshOptions {
    /// θ: the angle between edges and the surface, in degrees, above 0 and below 90. Smaller angles give more triangles.
    pub deviation: f64,
    /// β: largest ratio of sizes over one unit of length, above 1; `None`: no limit. Larger values let sizes change faster.
    pub gradation: Option<f64>,
    /// Edges whose face normals differ by more are ridges, in degrees; 180: none.
    #[serde(skip)]
    pub feature_angle: f64,
    /// Whether every such edge is a ridge, or only creases at the size of the resulting triangles.
    #[serde(skip)]
    pub creases: Creases,
    /// Further ridges, by their end vertices.
    #[serde(skip)]
    pub feature_edges: Vec<[VertexId; 2]>,
    /// Whether edges tagged in the file are ridges.
    #[serde(skip)]
    pub tags: bool,
    /// A face property of integers: edges between two values are ridges.
    pub labels: Option<String>,
    /// Smallest size, as a share of the diagonal.
    #[serde(skip)]
    pub min_size: f64,
    /// Largest size, as a share of the diagonal.
    #[serde(skip)]
    pub max_size: f64,
    /// How far ridges may move, as a share of the diagonal.
    pub ridge_tolerance: f64,
    /// Whether borders may be ragged, as those of scans are, and so move more freely than ridges; otherwise they are ridges.
    #[serde(skip)]
    pub ragged_borders: bool,
    /// Edges with this tag stay as they are.
    #[serde(skip)]
    pub held_tag: Option<i32>,
    /// Factor on all sizes, above 0.
    pub scale: f64,
    /// Target number of triangles, met within 1 % by scaling the sizes.
    pub triangles: Option<usize>,
    /// Largest distance from the input, in the unit of the file. The sizes are scaled until an upper bound of the distance is
    /// below it.
    #[serde(skip)]
    pub distance: Option<f64>,
    /// Enrich to this angle first, in degrees.
    pub enrich: Option<f64>,
    /// Ignore shapes and lengths: collapse in order of quadric error, into the points of least error.
    pub geometric: bool,
    /// Make edges longer in the direction in which the surface bends less.
    pub anisotropic: bool,
    /// Name of a vertex property that bounds the sizes from above, in the unit of the file.
    pub sizes: Option<String>,
}

impl Default for RemeshOptions {
    fn default() -> Self {
        RemeshOptions {
            deviation: 14.0,
            gradation: Some(1.5),
            feature_angle: 35.0,
            creases: Creases::Auto,
            feature_edges: Vec::new(),
            tags: true,
            labels: None,
            min_size: 2e-4,
            max_size: 0.2,
            ridge_tolerance: 4.8e-4,
            ragged_borders: true,
            held_tag: None,
            scale: 1.0,
            triangles: None,
            distance: None,
            enrich: None,
            geometric: false,
            anisotropic: false,
            sizes: None,
        }
    }
}

/// Most triangles that may be asked for: more have no 32-bit numbers for their corners.
pub const MOST_TRIANGLES: usize = 1_000_000_000;

impl RemeshOptions {
    /// Refuses values out of range, and those that contradict each other.
    ///
    /// # Errors
    /// [`Error::Options`].
    pub fn validate(&self) -> Result<()> {
        let acute = (Bound::Excluded(0.0), Bound::Excluded(90.0));
        within("deviation", self.deviation, acute, "degrees")?;
        self.enrich.map_or(Ok(()), |degrees| within("enrich", degrees, acute, "degrees, or off"))?;
        if self.gradation.is_some_and(|b| !(b > 1.0 && b <= 1e6)) {
            return Err(Error::Options("gradation must be above 1, or off".into()));
        }
        angle("feature-angle", self.feature_angle)?;
        if !(self.min_size >= 0.0 && self.min_size.is_finite()) {
            return Err(Error::Options(format!("min-size is {}, it must not be below 0", self.min_size)));
        }
        positive("max-size", self.max_size)?;
        if self.min_size > self.max_size {
            return Err(Error::Options("min-size is above max-size: no edge could be as long as both allow".into()));
        }
        within("ridge-tolerance", self.ridge_tolerance, 0.0..=1.0, "of the diagonal")?;
        within("scale", self.scale, (Bound::Excluded(0.0), Bound::Included(1e6)), "")?;
        self.triangles.map_or(Ok(()), |wanted| within("triangles", wanted, 1..=MOST_TRIANGLES, ""))?;
        self.distance.map_or(Ok(()), |distance| positive("distance", distance))
    }
}
