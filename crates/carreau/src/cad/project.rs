//! Noisy vertices put on the surfaces around them, so that the stages after this one work on exact data.
//!
//! ```text
//!      ●  ╲ ●                   ╲
//!     ─────●╲────      →    ─●───●╲────    a vertex inside of a piece goes to the foot on its surface, one of a border
//!        ●   ╲ ●                   ╲●      to the point that all surfaces around it have in common
//! ```
//!
//! Where surfaces touch, their common point is not sought along them, because the border of the mesh may be rows of triangles away from
//! the contact there. A vertex that would move by more than the noise of the mesh allows stays where it is.

use super::regions::{Map, Rung};
use super::trace::meet;
use super::tuning::{BRANCH_DISTANCE, NOISY_BRANCH};
use crate::brep::Surface;
use crate::context::Context;
use crate::error::Result;
use crate::mesh::Triangles;
use glam::DVec3;
use rayon::prelude::*;

impl Map<'_> {
    /// The places of all vertices on the surfaces of the pieces around them.
    pub fn projected(&self, context: &Context) -> Result<Vec<DVec3>> {
        let _stage = context.stage("project");
        let mut around: Vec<(u32, u32)> = Vec::with_capacity(3 * self.label.len());
        for (k, &l) in (0u32..).zip(&self.label) {
            around.extend(self.t.triangle(k).map(|v| (v, l)));
        }
        around.sort_unstable();
        around.dedup();
        let of_vertex: Vec<&[(u32, u32)]> = around.chunk_by(|a, b| a.0 == b.0).collect();
        let room = (BRANCH_DISTANCE * self.diagonal).max(2.0 * NOISY_BRANCH * self.tolerance);
        let place = |at: &&[(u32, u32)]| {
            context.check()?;
            let start = self.t.points()[at[0].0 as usize];
            let pieces = at.iter().map(|a| &self.pieces[a.1 as usize]).filter(|p| p.rung < Rung::Spline);
            let p = meet(&pieces.map(|p| &p.surface).collect::<Vec<&Surface>>(), start);
            Ok((at[0].0, if p.distance(start) <= room { p } else { start }))
        };
        let places: Vec<(u32, DVec3)> =
            context.install(|| of_vertex.par_iter().with_min_len(256).map(place).collect::<Result<_>>())?;
        let mut points = self.t.points().to_vec();
        places.into_iter().for_each(|(v, p)| points[v as usize] = p);
        Ok(points)
    }

    /// The same map on the same triangles with other vertices.
    pub fn with_vertices_of<'b>(self, t: Triangles<'b>) -> Map<'b> {
        let Map { diagonal, tolerance, precision, label, pieces, next, .. } = self;
        Map { t, diagonal, tolerance, precision, label, pieces, next }
    }
}
