//! Whether a mesh lies on surfaces at all: a few patches, spread evenly over the area, tell a part from a scan.
//!
//! A part has surfaces nearly everywhere, a scan nowhere; to ask every triangle of a scan at every tolerance would take longer
//! than all that follows. The patches are small meshes of their own, with facets and hypotheses as in the whole search.

use super::facets::Facets;
use super::recognise::{Accuracy, finds_any};
use super::surface::Surface;
use super::surfaces::{Planes, WORTH_AREA};
use crate::context::Context;
use crate::error::Result;
use crate::mesh::NONE;

/// A count: smaller meshes are asked everywhere, because that takes no time.
const PROBED_TRIANGLES: usize = 2000;
/// A count: patches that are asked for planes, because where a twentieth of the area lies on some, all miss it once in
/// 27 times.
const PLANE_PATCHES: usize = 64;
/// A count: curved surfaces are asked for at every second patch, because they take longer.
const CURVED_STEP: usize = 2;
/// A count: triangles of a patch, because a curved surface needs some facets to be told.
const PATCH_TRIANGLES: usize = 200;

/// Whether some patch lies on surfaces at the loosest accuracy, or at the tightest; true for small meshes. `order` lists the
/// triangles independently of their numbers.
pub fn has_surfaces(
    surface: &Surface<'_>,
    order: &[u32],
    sharp_angle: f64,
    [tightest, loosest]: [&Accuracy; 2],
    context: &Context,
) -> Result<bool> {
    if surface.len() < PROBED_TRIANGLES {
        return Ok(true);
    }
    let sample = Sample::new(surface, order);
    let loose = sample.facets(loosest, context)?;
    if sample.finds(&sample.seeds, &loose, loosest, sharp_angle, context)? {
        return Ok(true);
    }
    // Facets of one triangle are the same at every accuracy, and what no surface fits loosely none fits exactly.
    let merged = |t: u32| loose.of[t as usize] != NONE && loose.triangles(loose.of[t as usize]).len() > 1;
    let around = |&t: &u32| {
        let beyond = (3 * t..3 * t + 3).map(|c| surface.triangles.opposite(c)).filter(|&o| o != NONE);
        merged(t) || beyond.map(|o| o / 3).any(merged)
    };
    let again: Vec<u32> = sample.seeds.iter().copied().filter(around).collect();
    if again.is_empty() || tightest.distance >= loosest.distance {
        return Ok(false);
    }
    sample.finds(&again, &sample.facets(tightest, context)?, tightest, sharp_angle, context)
}

/// Patches of a mesh.
struct Sample<'a> {
    surface: &'a Surface<'a>,
    /// The middles of the patches.
    seeds: Vec<u32>,
    /// Whether a triangle is in a patch.
    inside: Vec<bool>,
    /// The triangles of all patches, by area.
    members: Vec<u32>,
}

impl<'a> Sample<'a> {
    fn new(surface: &'a Surface<'a>, order: &[u32]) -> Self {
        let (inside, members) = (vec![false; surface.len()], Vec::new());
        let mut sample = Sample { surface, seeds: seeds(surface, order), inside, members };
        for k in 0..sample.seeds.len() {
            sample.take_in(sample.seeds[k]);
        }
        sample.members = surface.by_area(&sample.members);
        sample
    }

    /// Adds the patch around a seed, ring by ring; patches do not overlap.
    fn take_in(&mut self, seed: u32) {
        let t = self.surface.triangles;
        let from = self.members.len();
        let mut at = from;
        let mut next = [seed, NONE, NONE];
        loop {
            for n in next.into_iter().filter(|&n| n != NONE) {
                if !std::mem::replace(&mut self.inside[n as usize], true) {
                    self.members.push(n);
                }
            }
            if at == self.members.len() || self.members.len() >= from + PATCH_TRIANGLES {
                return;
            }
            let k = self.members[at];
            at += 1;
            next = [0, 1, 2].map(|side| match t.opposite(3 * k + side) {
                NONE => NONE,
                o => o / 3,
            });
        }
    }

    fn facets(&self, accuracy: &Accuracy, context: &Context) -> Result<Facets> {
        Facets::new(self.surface, &self.inside, &self.members, accuracy.distance, accuracy.turn, context)
    }

    /// Whether some seed lies on a plane or a curved surface.
    fn finds(
        &self,
        seeds: &[u32],
        facets: &Facets,
        accuracy: &Accuracy,
        sharp_angle: f64,
        context: &Context,
    ) -> Result<bool> {
        let mut of: Vec<u32> = seeds.iter().map(|&t| facets.of[t as usize]).collect();
        of.dedup();
        let owner = vec![NONE; facets.len()];
        let planes = Planes { surface: self.surface, facets, owner: &owner, sharp_angle, accuracy, last: true };
        let is_plane = |&f: &u32| {
            let large = facets.area[f as usize] > WORTH_AREA * self.surface.total_area;
            (large || self.leaves(facets.triangles(f))) && planes.contains(f)
        };
        Ok(of.iter().any(is_plane)
            || finds_any(self.surface, facets, accuracy, of.into_iter().step_by(CURVED_STEP), context)?)
    }

    /// Whether triangles have neighbours outside of the patches.
    fn leaves(&self, triangles: &[u32]) -> bool {
        let beyond = triangles.iter().flat_map(|&t| 3 * t..3 * t + 3).map(|c| self.surface.triangles.opposite(c));
        beyond.filter(|&o| o != NONE).any(|o| !self.inside[o as usize / 3])
    }
}

/// Triangles at equal steps of the area before them.
fn seeds(surface: &Surface<'_>, order: &[u32]) -> Vec<u32> {
    let step = surface.total_area / PLANE_PATCHES as f64;
    let (mut before, mut seeds) = (0.0, Vec::with_capacity(PLANE_PATCHES));
    for &t in order {
        before += surface.areas[t as usize];
        if before > step * (seeds.len() as f64 + 0.5) && seeds.len() < PLANE_PATCHES {
            seeds.push(t);
        }
    }
    seeds
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{SurfaceMesh, Triangles};
    use crate::sample;
    use glam::DVec3;

    fn answer(mesh: &SurfaceMesh) -> bool {
        let surface = Surface::new(mesh, Triangles::of(mesh).unwrap());
        let accuracy =
            |share: f64| Accuracy { distance: share * mesh.diagonal(), turn: 0.0175, bend: 0.8, seed_vertices: 8 };
        let order = surface.canonical_order();
        has_surfaces(&surface, &order, 0.44, [&accuracy(1e-9), &accuracy(2e-5)], &Context::new()).unwrap()
    }

    /// A wave in all directions, which no plane or surface of revolution follows.
    fn wave(p: DVec3) -> DVec3 {
        let high = (1.3 * p.x).sin() * (1.7 * p.y + 0.4).cos() + (2.1 * p.z).sin();
        p * (1.0 + 0.15 * high)
    }

    #[test]
    fn parts_have_surfaces_and_waves_have_none() {
        let part = sample::make("torus", None, &Context::new()).unwrap();
        let sphere = crate::mesh::test_models::sphere(5);
        for mesh in [part, sphere] {
            assert!(mesh.face_count() >= PROBED_TRIANGLES, "{}", mesh.face_count());
            assert!(answer(&mesh));
            assert!(!answer(&crate::mesh::test_models::moved(&mesh, wave)));
        }
    }
}
