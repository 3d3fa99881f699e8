//! What is asked for, and what is found.

use crate::bounds::within;
use crate::error::Result;
use crate::geometry::summary::Summary;
use crate::mesh::UnitScale;
use serde::{Deserialize, Serialize};

/// How closely to look.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct DistanceOptions {
    /// Number of samples on each surface, in addition to its vertices.
    pub samples: usize,
    /// Most triangles to divide per direction in order to narrow the bounds of the maximum; 0: none.
    pub refinements: usize,
    /// Whether to compare normals as well.
    pub normals: bool,
}

/// Most samples and refinements: more do not fit into memory.
pub const MOST_SAMPLES: usize = 100_000_000;

impl DistanceOptions {
    /// Refuses numbers beyond what fits into memory.
    ///
    /// # Errors
    /// [`Error::Options`](crate::Error::Options).
    pub fn validate(&self) -> Result<()> {
        within("samples", self.samples, 0..=MOST_SAMPLES, "")?;
        within("refinements", self.refinements, 0..=MOST_SAMPLES, "")
    }
}

impl Default for DistanceOptions {
    fn default() -> Self {
        DistanceOptions { samples: 200_000, refinements: 100_000, normals: true }
    }
}

/// Distance of two surfaces, in the unit of the files.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// Bounding-box diagonal of the first surface, to which shares refer.
    pub diagonal: f64,
    /// Both directions together.
    pub distance: Distance,
    /// The same as shares of the diagonal.
    pub relative: Distance,
    /// Angle between the normals of both surfaces at samples and their closest points, in degrees, both directions
    /// together; `None` where no sample has a normal on both sides.
    pub normal_deg: Option<Summary>,
    /// From the first surface to the second.
    pub a_to_b: OneSided,
    /// From the second surface to the first.
    pub b_to_a: OneSided,
}

/// Mean and maximum of a distance.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Distance {
    /// Mean over the area.
    pub mean: f64,
    /// Root mean square, over the area.
    pub rms: f64,
    /// The same with two standard errors added: as many random samples would hardly give more. Where few places are far
    /// away, that is some percent.
    pub rms_upper: f64,
    /// The largest distance found; the true maximum (the Hausdorff distance) is not smaller.
    pub max: f64,
    /// Upper bound of the true maximum.
    pub max_upper: f64,
}

/// Distance from one surface to another.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OneSided {
    /// Mean and maximum.
    #[serde(flatten)]
    pub distance: Distance,
    /// Where the maximum was found.
    pub max_at: [f64; 3],
    /// Angle between the normals, in degrees.
    pub normal_deg: Option<Summary>,
    /// Number of points that were measured.
    pub points: usize,
}

impl Comparison {
    /// The same for the meshes in another scale; shares stay.
    pub(super) fn in_scale(mut self, scale: UnitScale) -> Comparison {
        self.diagonal = scale.length(self.diagonal);
        self.distance = self.distance.map(|x| scale.length(x));
        for side in [&mut self.a_to_b, &mut self.b_to_a] {
            side.distance = side.distance.map(|x| scale.length(x));
            side.max_at = side.max_at.map(|x| scale.length(x));
        }
        self
    }
}

impl Distance {
    /// Every figure, changed in the same way.
    pub(super) fn map(self, change: impl Fn(f64) -> f64) -> Distance {
        Distance {
            mean: change(self.mean),
            rms: change(self.rms),
            rms_upper: change(self.rms_upper),
            max: change(self.max),
            max_upper: change(self.max_upper),
        }
    }

    /// Two directions taken together.
    pub(super) fn with(self, other: Distance) -> Distance {
        let quadratic = |a: f64, b: f64| ((a * a + b * b) / 2.0).sqrt();
        Distance {
            mean: (self.mean + other.mean) / 2.0,
            rms: quadratic(self.rms, other.rms),
            rms_upper: quadratic(self.rms_upper, other.rms_upper),
            max: self.max.max(other.max),
            max_upper: self.max_upper.max(other.max_upper),
        }
    }

    /// As shares of a length; zero where the length is zero and the distance too.
    pub(super) fn over(self, length: f64) -> Distance {
        self.map(|x| if x == 0.0 { 0.0 } else { x / length })
    }
}
