//! Halves segments along where the surface is far from the boundary although the boundary's vertices lie on it: the
//! cells there are too long.
//!
//! ```text
//!       ╭───────╮             ╭───·───╮
//!      ·─────────·     →     ·────┼────·        a halving along cuts the sheet of cells about one segment
//!      │         │           │    │    │
//! ```

use super::refine::TubeMesh;
use super::target::Target;
use crate::mesh::{CurveNet, NONE, boundary_faces};
use glam::DVec3;

/// Distance, as a share of the surface's diagonal, from which the surface counts as far from the boundary.
const FAR_FROM_SURFACE: f64 = 0.0025;
/// Number of places at which that is measured, about.
const FAR_SAMPLES: usize = 20_000;

/// The segments of a net, and what is left of their length in radii after the halvings.
pub struct Lengths(Vec<f64>);

impl Lengths {
    /// Of segments that are not halved; `inside` is the share of the room that the radii take.
    pub fn new(net: &CurveNet, inside: f64) -> Self {
        let in_radii = |e: usize| {
            let [a, b] = net.edges[e].map(|v| net.radii[v as usize] / inside);
            net.length(e) / (0.5 * (a + b)).max(1e-300)
        };
        Lengths((0..net.edges.len()).map(in_radii).collect())
    }

    /// Halves the segments that are longer than a limit; whether there are any.
    pub fn even_out(&mut self, tube: &mut TubeMesh, limit: f64) -> bool {
        self.halve(tube, |_, length| length > limit)
    }

    /// Halves segments whose boundary is far from the surface and would remain so after `across` refinements. Segments shorter
    /// than `shortest` radii are kept. Returns whether anything changed.
    pub fn follow(&mut self, tube: &mut TubeMesh, target: &Target, across: u32, shortest: f64) -> bool {
        let mut is_far = vec![false; self.0.len()];
        far_segments(tube, target, across).into_iter().for_each(|e| is_far[e as usize] = true);
        self.halve(tube, |e, length| is_far[e] && length > 2.0 * shortest)
    }

    fn halve(&mut self, tube: &mut TubeMesh, goes: impl Fn(usize, f64) -> bool) -> bool {
        let halved: Vec<bool> = self.0.iter().enumerate().map(|(e, &length)| goes(e, length)).collect();
        tube.refine_along(|e| halved[e as usize]);
        self.0.iter_mut().zip(&halved).filter(|l| *l.1).for_each(|l| *l.0 *= 0.5);
        halved.contains(&true)
    }
}

/// The segments at whose boundary the surface is far, and will be when cells have been halved across so often.
fn far_segments(tube: &TubeMesh, target: &Target, across: u32) -> Vec<u32> {
    let (quads, hexes): (Vec<[u32; 4]>, Vec<u32>) = boundary_faces(&tube.hexes).into_iter().unzip();
    let limit = FAR_FROM_SURFACE * target.surface().diagonal();
    // Half as long a side has a quarter of the sag.
    let cured = 1.0 - 0.25f64.powi(across as i32);
    target.looking_at(&tube.points, &quads, FAR_SAMPLES, |seen| {
        let hex = hexes[seen.quad] as usize;
        let is_far =
            seen.distance > limit && seen.distance - cured * sag_across(tube, hex, quads[seen.quad], target) > limit;
        (is_far && tube.segments[hex] != NONE).then_some(tube.segments[hex])
    })
}

/// How far the middles of those two sides of a boundary face that run across are from the surface, on average.
fn sag_across(tube: &TubeMesh, hex: usize, quad: [u32; 4], target: &Target) -> f64 {
    let [low, high] = [&tube.hexes[hex][..4], &tube.hexes[hex][4..]];
    let sides = (0..4).map(|k| [quad[k], quad[(k + 1) % 4]]);
    let across = sides.filter(|s| [low, high].iter().any(|end| s.iter().all(|v| end.contains(v))));
    across.map(|s| 0.5 * target.distance(s.map(|v| tube.points[v as usize]).iter().sum::<DVec3>() / 2.0)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hex::{Padding, assemble, refine};

    /// Two segments in a ball: one that fills none of it, and one as small that is too short to be halved.
    #[test]
    fn segments_are_halved_where_the_surface_is_far() {
        let (closed, _) =
            crate::skeleton::prepared(&crate::mesh::test_models::sphere(3), &crate::Context::new()).unwrap();
        let points = [-0.6, 0.5, 0.6].map(|x| DVec3::X * x).to_vec();
        let net = CurveNet::new(points, vec![0.3; 3], vec![[0, 1], [1, 2]]);
        let mut tube = refine::pad(&net, &assemble::base_mesh(&net, false), Padding::Sides, refine::CORE);
        let mut lengths = Lengths::new(&net, 1.0);
        let target = Target::new(&closed);
        let before = tube.hexes.len();
        assert!(!lengths.even_out(&mut tube, 4.0));
        assert!(lengths.follow(&mut tube, &target, 0, 0.3));
        assert_eq!(tube.hexes.len(), before + 12);
        assert!(!lengths.follow(&mut tube, &target, 0, 1.0));
        assert_eq!((0..9).filter(|_| lengths.follow(&mut tube, &target, 0, 0.3)).count(), 2);
    }
}
