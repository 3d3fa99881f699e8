//! Cells whose faces enclose what their triangles do.
//!
//! ```text
//!   d ──── c      The bilinear surface through four corners that lie in no plane runs halfway between the two ways of cutting
//!   │ ╲  ⁄ │      them: it is off the triangles a b d, b c d by a twelfth of |(b − a, c − a, d − a)|, half the volume of the
//!   │ ⁄  ╲ │      tetrahedron of the corners. On a coarse convex mesh whose diagonals all go one way this adds up to
//!   a ──── b      a percent of the volume.
//! ```
//!
//! Cells that are far off are refused only where all of them together matter: then the limit falls until they do not. Such quads
//! become two planes.

use super::off_limit::{OffLimit, area, bilinear_area, twelfth};
use crate::context::Context;
use crate::error::Result;
use crate::mesh::{NONE, SurfaceMesh, Triangles};
use crate::patch::Patch;
use crate::patch::decomposition::decompose;
use crate::patch::options::PatchOptions;
use crate::patch::result::PatchResult;

/// Largest difference of area and volume between all cells and their triangles, as a share of the mesh's: half of what a user
/// who compares the model with the mesh may find.
const OFF: f64 = 5e-4;
/// The first limit for one cell, as a share of its area, and of the volume that it would have if the mesh were a plate.
const FIRST: f64 = 1e-2;
/// Meshes with less volume than this share of their area to the power of 1.5 enclose none to speak of.
const FLAT: f64 = 1e-6;

/// Decomposes a mesh into patches for faces of degree (1, 1), whose area and volume are those of the mesh.
///
/// # Errors
/// As [`decompose`].
pub fn decompose_for_faces(mesh: &SurfaceMesh, options: &PatchOptions, ctx: &Context) -> Result<PatchResult> {
    let mut result = decompose(mesh, options, ctx)?;
    let Some(whole) = Whole::of(mesh) else { return Ok(result) };
    let mut options = options.clone();
    let mut share = FIRST;
    // At the last limit the shares of all cells together keep it.
    while share > OFF / 2.0 && whole.off(&result.patches) > OFF {
        options.off_mesh = Some(OffLimit { share, thickness: whole.thickness() });
        result = decompose(mesh, &options, ctx)?;
        share /= 2.0;
    }
    Ok(result)
}

/// Area and volume of a mesh.
struct Whole<'a> {
    triangles: Triangles<'a>,
    area: f64,
    /// None where the mesh is open.
    volume: Option<f64>,
}

impl<'a> Whole<'a> {
    fn of(mesh: &'a SurfaceMesh) -> Option<Self> {
        let triangles = Triangles::of(mesh)?;
        let corners = |t: u32| triangles.triangle(t).map(|v| triangles.points()[v as usize]);
        let count = triangles.len() as u32;
        let area = (0..count).map(|t| area(corners(t))).sum();
        let origin = corners(0)[0];
        let volume: f64 =
            (0..count).map(|t| corners(t).map(|p| p - origin)).map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum();
        let is_closed = (0..3 * count).all(|c| triangles.opposite(c) != NONE);
        let encloses = is_closed && volume.abs() > FLAT * f64::powf(area, 1.5);
        Some(Whole { triangles, area, volume: encloses.then_some(volume.abs()) })
    }

    fn thickness(&self) -> Option<f64> {
        self.volume.map(|volume| volume / self.area)
    }

    /// The larger of the differences of area and volume that the cells of all patches make, as shares.
    fn off(&self, patches: &[Patch]) -> f64 {
        let point = |v: u32| self.triangles.points()[v as usize];
        let [mut more_area, mut more_volume] = [0.0; 2];
        for patch in patches {
            for (pair, corners) in patch.triangles.chunks_exact(2).zip(patch.cell_corners()) {
                let own = [pair[0], pair[1]].map(|t| self.triangles.triangle(t.0));
                let has = |k: usize| own.iter().all(|t| t.contains(&corners[k].0));
                let sense = if has(0) && has(2) { 1.0 } else { -1.0 };
                let places = corners.map(|v| point(v.0));
                more_area += bilinear_area(places) - own.map(|t| area(t.map(point))).iter().sum::<f64>();
                more_volume += sense * twelfth(places);
            }
        }
        let volume = self.volume.map_or(0.0, |volume| more_volume.abs() / volume);
        volume.max(more_area.abs() / self.area)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Topology;
    use crate::patch::cad::{BrepOptions, to_brep};
    use glam::DVec3;
    use std::f64::consts::TAU;

    /// A coarse frustum whose upper ring is turned against the lower one: no quad of its side is plane.
    fn frustum(sides: u32, turn: f64) -> SurfaceMesh {
        let ring = |r: f64, z: f64, turn: f64| {
            (0..sides).map(move |k| {
                let angle = TAU * (f64::from(k) + turn) / f64::from(sides);
                DVec3::new(r * angle.cos(), r * angle.sin(), z)
            })
        };
        let points: Vec<DVec3> =
            ring(1.0, 0.0, 0.0).chain(ring(0.6, 1.0, turn)).chain([DVec3::ZERO, DVec3::Z]).collect();
        let side = |k: u32| {
            let n = (k + 1) % sides;
            let [low, high] = [2 * sides, 2 * sides + 1];
            [[k, n, sides + n], [k, sides + n, sides + k], [n, k, low], [sides + k, sides + n, high]]
        };
        let triangles: Vec<[u32; 3]> = (0..sides).flat_map(side).collect();
        SurfaceMesh::from_triangles(points, &triangles).unwrap()
    }

    #[test]
    fn faces_enclose_what_the_mesh_does() {
        let options = PatchOptions { faces: true, q_max: 180.0, feature_angle: Some(30.0), ..PatchOptions::default() };
        let ctx = Context::new();
        let (mut plain, mut mended) = (0.0f64, 0.0f64);
        for (sides, turn) in [(12, 0.3), (16, 0.4), (24, 0.4), (48, 0.3)] {
            let mesh = frustum(sides, turn);
            let whole = Whole::of(&mesh).unwrap();
            assert!((whole.volume.unwrap() - Topology::of(&mesh).volume.unwrap()).abs() < 1e-12);
            plain = plain.max(whole.off(&decompose(&mesh, &options, &ctx).unwrap().patches));
            let result = decompose_for_faces(&mesh, &options, &ctx).unwrap();
            mended = mended.max(whole.off(&result.patches));
            let model = to_brep(&mesh, &result.patches, &result.leftover, &BrepOptions::default(), &ctx).unwrap();
            let exact = super::super::weigh::weigh(&model.brep).exact;
            assert!((exact.volume / whole.volume.unwrap() - 1.0).abs() < 1e-3, "{sides} {turn}");
            assert!((exact.area / whole.area - 1.0).abs() < 1e-3, "{sides} {turn}");
        }
        assert!(plain > 3e-3 && mended <= OFF, "{plain} {mended}");
    }

    #[test]
    fn plane_quads_are_never_off() {
        let mesh = frustum(24, 0.0);
        let options = PatchOptions { faces: true, q_max: 180.0, feature_angle: Some(30.0), ..PatchOptions::default() };
        let ctx = Context::new();
        let [a, b] = [decompose(&mesh, &options, &ctx), decompose_for_faces(&mesh, &options, &ctx)].map(Result::unwrap);
        assert_eq!(a.patches.len(), b.patches.len());
        assert_eq!(a.leftover, b.leftover);
    }
}
