//! How patches are sought.

use super::cad;
use super::positions::Policy;
use super::quality::{Filters, Quality};
use super::validate::Promises;
use crate::bounds::angle;
use crate::error::{Error, Result};
use crate::geometry::features::Creases;
use crate::mesh::VertexId;
use serde::{Deserialize, Serialize};

/// How patches are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Strategy {
    /// Rectangles grown directly on the triangles: the fewest patches.
    #[default]
    Grow,
    /// The paper: greedy zones of quads, then rectangles in them.
    Zones,
    /// Quads by minimum-cost matching (best quads, few leftovers), then rectangles.
    Matching,
    /// Quads by maximum matching (fewest leftovers), then rectangles.
    MatchingCardinality,
}

/// How a rectilinear polygon is cut into rectangles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Dissection {
    /// Largest rectangle first, as in the paper: all rectangles from each corner are tried.
    Greedy,
    /// Largest rectangle first, where each corner is tried only with its longest row: figure 8 taken to the letter.
    LongestRow,
    /// As few rectangles as possible.
    #[default]
    Minimum,
}

/// Options of [`decompose`](super::decomposition::decompose).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct PatchOptions {
    /// How patches are found.
    pub strategy: Strategy,
    /// How contradictions between rows and columns are resolved (not used by [`Strategy::Grow`]).
    pub policy: Policy,
    /// Smallest number of cells of a patch; smaller ones stay triangles. 1 keeps single quads.
    pub min_cells: u32,
    /// Q_max of equation 1 in degrees, 0..=180; from 135 on it rejects no shape. Large quads that fold over themselves are
    /// never accepted.
    pub q_max: f64,
    /// ε_φ: largest angle between the normals of the two triangles of a quad, in degrees.
    pub dihedral: f64,
    /// Accept a larger angle where the surrounding surface bends as much.
    pub adapt_dihedral: bool,
    /// Reject quads with a corner above 180°.
    pub convex_only: bool,
    /// Accept only quads whose bilinear surface has the area and volume that CAD programs will compute.
    pub faces: bool,
    /// How far such a surface may be off the two triangles of the quad; [`cad::decompose_for_faces`] decides.
    #[serde(skip)]
    pub off_mesh: Option<cad::OffLimit>,
    /// How candidate quads are ranked.
    pub quality: Quality,
    /// How polygons are cut into rectangles (not used by [`Strategy::Grow`]).
    pub dissection: Dissection,
    /// Join patches along complete common sides.
    pub merge: bool,
    /// How many rectangles [`Strategy::Grow`] tries through each triangle: more take longer and give larger patches.
    /// Low 1, high 32; 0 tries every seed. By default 16, fewer on large meshes so that the time stays linear.
    pub probes: Option<u32>,
    /// Rectangles of [`Strategy::Grow`] end at creases: connected edges with more than this angle between the face
    /// normals, in degrees. Merging may join them across, along complete sides. 180: creases are nothing special.
    pub crease_angle: f64,
    /// Edges with more than this angle between the face normals, in degrees, are never crossed.
    pub feature_angle: Option<f64>,
    /// Whether every such edge is meant, or only creases at the size of 3,000 squares.
    pub creases: Creases,
    /// Edges that are never crossed, by their vertices.
    #[serde(skip)]
    pub feature_edges: Vec<[VertexId; 2]>,
    /// Edges tagged in the file are never crossed.
    pub tagged_edges: bool,
}

impl Default for PatchOptions {
    fn default() -> Self {
        PatchOptions {
            strategy: Strategy::default(),
            policy: Policy::default(),
            min_cells: 2,
            q_max: 90.0,
            dihedral: 30.0,
            adapt_dihedral: false,
            convex_only: false,
            faces: false,
            off_mesh: None,
            quality: Quality::default(),
            dissection: Dissection::default(),
            merge: true,
            probes: None,
            crease_angle: 40.0,
            feature_angle: None,
            creases: Creases::Every,
            feature_edges: Vec::new(),
            tagged_edges: true,
        }
    }
}

impl PatchOptions {
    /// The paper's pipeline: zones, greedy rectangles, no merging.
    pub fn paper() -> Self {
        PatchOptions {
            strategy: Strategy::Zones,
            dissection: Dissection::Greedy,
            merge: false,
            ..PatchOptions::default()
        }
    }

    /// Refuses values out of range.
    ///
    /// # Errors
    /// [`Error::Options`].
    pub fn validate(&self) -> Result<()> {
        angle("q-max", self.q_max)?;
        angle("dihedral", self.dihedral)?;
        angle("crease-angle", self.crease_angle)?;
        angle("feature-angle", self.feature_angle.unwrap_or(0.0))?;
        if self.min_cells == 0 {
            return Err(Error::Options("min-cells is 0, a patch has at least one cell".into()));
        }
        Ok(())
    }

    /// Probes per triangle. Rectangles grow with the mesh, and their triangles leave the cache: sixteen probes on every
    /// triangle are affordable up to some 200,000 triangles, and on a million one finds nearly as much.
    pub(super) fn probes(&self, triangles: usize) -> u32 {
        match self.probes {
            None => (1_600_000 / triangles.max(1)).clamp(1, 16) as u32,
            Some(0) => u32::MAX,
            Some(n) => n,
        }
    }

    pub(super) fn filters(&self) -> Filters {
        Filters {
            quality: self.quality,
            q_max: self.q_max.to_radians(),
            dihedral: self.dihedral.to_radians(),
            adapt_dihedral: self.adapt_dihedral,
            convex_only: self.convex_only,
            faces: self.faces,
            off_mesh: self.off_mesh,
        }
    }

    pub(super) fn promises(&self) -> Promises {
        Promises {
            q_max: self.q_max.to_radians(),
            dihedral: if self.adapt_dihedral { f64::INFINITY } else { self.dihedral.to_radians() },
            convex_only: self.convex_only,
            min_cells: self.min_cells as usize,
        }
    }
}
