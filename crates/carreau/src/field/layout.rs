//! The layout file: everything that a field says, for checkers and other programs.

use super::{Corner, Field};
use glam::DVec3;
use serde::Serialize;

/// The content of a layout file; contract §3.
#[derive(Serialize)]
struct Layout<'a> {
    vertices: Vec<[f64; 3]>,
    triangles: Vec<&'a [u32]>,
    u: Vec<[f64; 3]>,
    v: Vec<[f64; 3]>,
    features: &'a [[u32; 2]],
    edges: Vec<(u32, u32, i32)>,
    singularities: Vec<Singularity>,
    sectors: Vec<Sector>,
}

/// An inner vertex whose number of quads is not four.
#[derive(Serialize)]
struct Singularity {
    vertex: u32,
    quads: i32,
}

/// A sector between two features.
#[derive(Serialize)]
struct Sector {
    vertex: u32,
    angle_deg: f64,
    quads: i32,
}

impl Field {
    /// The layout file (JSON).
    pub fn layout(&self) -> Vec<u8> {
        let arrays = |all: &[DVec3]| all.iter().map(DVec3::to_array).collect();
        let singularity = |c: &Corner| Singularity { vertex: c.vertex, quads: c.quads };
        let sector = |c: &Corner| Sector { vertex: c.vertex, angle_deg: c.angle.to_degrees(), quads: c.quads };
        let layout = Layout {
            vertices: arrays(self.mesh.points()),
            triangles: self.mesh.faces().iter().collect(),
            u: arrays(&self.u),
            v: arrays(&self.v),
            features: &self.features,
            edges: self.matchings.iter().map(|m| (m.triangles[0], m.triangles[1], m.p)).collect(),
            singularities: self.corners.iter().filter(|c| c.is_singular()).map(singularity).collect(),
            sectors: self.corners.iter().filter(|c| !c.closed).map(sector).collect(),
        };
        // Numbers and lists alone: nothing that JSON could refuse.
        serde_json::to_vec(&layout).unwrap_or_default()
    }
}
