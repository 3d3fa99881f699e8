//! Stretches the first cells about a branch to ellipses where the sections of the surface are flat.
//!
//! ```text
//!     ╭──────────────────╮         ╭──────────────────╮
//!     │        (╋)       │    →    │ (───────╋──────) │
//!     ╰──────────────────╯         ╰──────────────────╯
//! ```
//!
//! Round cells, with the radius of the ball that fits in, would have to be drawn out to many times their width.

use super::optimise::Optimiser;
use super::refine::TubeMesh;
use super::target::Target;
use crate::mesh::{CurveNet, Incidence};
use crate::numeric::eigen3::outer;
use glam::{DMat3, DVec3};
use rustc_hash::FxHashMap;

/// Rays from a node across its branch.
const RAYS: usize = 32;
/// Width of a section over its thickness from which on it is flat.
const FLAT: f64 = 2.0;
/// Largest factor by which cells are made wider.
const WIDEST: f64 = 8.0;
/// They take this share of the room.
const SHARE_OF_ROOM: f64 = 0.8;
/// Shares of the stretch that are tried, until no cell is folded.
const STRETCHES: [f64; 3] = [1.0, 0.5, 0.25];

/// Stretches cells across the branches of a net where the sections of the surface are flat.
pub fn stretch(tube: &mut TubeMesh, net: &CurveNet, target: &Target) {
    let around = net.incidence();
    let own: Vec<DMat3> = (0..net.points.len() as u32).map(|v| of_node(net, around.of(v), v, target)).collect();
    if own.iter().all(|m| *m == DMat3::ZERO) {
        return;
    }
    let by = evened(&around, &own);
    let nodes = nodes_of(tube, net);
    let optimiser = Optimiser::new(&tube.points, &tube.hexes);
    for share in STRETCHES {
        let to = |(p, &v): (&DVec3, &usize)| *p + share * (by[v] * (*p - net.points[v]));
        let stretched: Vec<DVec3> = tube.points.iter().zip(&nodes).map(to).collect();
        if optimiser.is_valid(&stretched) {
            tube.points = stretched;
            return;
        }
    }
}

/// The node of the skeleton that each vertex belongs to.
fn nodes_of(tube: &TubeMesh, net: &CurveNet) -> Vec<usize> {
    let mut known: FxHashMap<[u64; 3], usize> = FxHashMap::default();
    // The centres of layers on ends lie beside their nodes.
    let nearest = |p: DVec3| {
        let far = |v: &usize| net.points[*v].distance_squared(p);
        (0..net.points.len()).min_by(|a, b| far(a).total_cmp(&far(b))).unwrap_or(0)
    };
    tube.centres.iter().map(|&p| *known.entry(p.to_array().map(f64::to_bits)).or_insert_with(|| nearest(p))).collect()
}

/// Half of what a node has itself, half of what its neighbours have.
fn evened(around: &Incidence, own: &[DMat3]) -> Vec<DMat3> {
    let even = |v: u32| {
        let near = around.of(v);
        let sum = near.iter().fold(DMat3::ZERO, |sum, s| sum + own[s[1] as usize]);
        0.5 * own[v as usize] + sum * (0.5 / near.len().max(1) as f64)
    };
    (0..own.len() as u32).map(even).collect()
}

/// What is added to the place of a vertex as seen from its node, which has segments `around`: nothing at branchings and where
/// the section is round.
fn of_node(net: &CurveNet, around: &[[u32; 2]], v: u32, target: &Target) -> DMat3 {
    let at = |v: u32| net.points[v as usize];
    let axis = match *around {
        [[_, a], [_, b]] => at(b) - at(a),
        [[_, a]] => at(v) - at(a),
        _ => return DMat3::ZERO,
    };
    let radius = net.radii[v as usize];
    let section = axis.try_normalize().and_then(|axis| Oval::new(at(v), axis, WIDEST * radius, target));
    let Some(oval) = section.filter(|o| o.radii[0] > FLAT * o.radii[1]) else { return DMat3::ZERO };
    let more = |k: usize| (SHARE_OF_ROOM * oval.radii[k] / radius).clamp(1.0, WIDEST) - 1.0;
    outer(oval.axes[0]) * more(0) + outer(oval.axes[1]) * more(1)
}

/// An ellipse like a section of the surface.
struct Oval {
    /// Half axes, the longer one first.
    radii: [f64; 2],
    /// Their unit directions.
    axes: [DVec3; 2],
}

impl Oval {
    /// The ellipse with the same moments as what rays across an axis meet within reach; `None` where one meets nothing.
    ///
    /// Seen from the middle of an ellipse with the half axes a and b, the mean of d² e eᵀ over all directions e has the
    /// eigenvalues a² b / (a + b) and a b² / (a + b): their sum is a b, their ratio a / b.
    fn new(middle: DVec3, axis: DVec3, reach: f64, target: &Target) -> Option<Oval> {
        let (x, y) = axis.any_orthonormal_pair();
        let (mut sum, mut difference, mut mixed) = (0.0, 0.0, 0.0);
        for k in 0..RAYS {
            let (sin, cos) = (std::f64::consts::TAU * k as f64 / RAYS as f64).sin_cos();
            let d = target.leaves(middle, x * cos + y * sin)?.min(reach);
            sum += d * d / RAYS as f64;
            difference += d * d * (cos * cos - sin * sin) / RAYS as f64;
            mixed += d * d * 2.0 * cos * sin / RAYS as f64;
        }
        let ratio = {
            let apart = difference.hypot(mixed);
            (sum + apart) / (sum - apart).max(1e-9 * sum)
        };
        let (sin, cos) = (0.5 * mixed.atan2(difference)).sin_cos();
        Some(Oval { radii: [(sum * ratio).sqrt(), (sum / ratio).sqrt()], axes: [x * cos + y * sin, y * cos - x * sin] })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::context::Context;
    use crate::hex::{Padding, assemble, refine};
    use crate::mesh::test_models::{moved, sphere};
    use crate::skeleton::{self, Closed};

    /// A ball drawn out to the half axes 2, 1, and a thickness.
    fn ellipsoid(thickness: f64) -> Closed {
        let mesh = moved(&sphere(4), |p| DVec3::new(2.0, 1.0, thickness) * p);
        skeleton::prepared(&mesh, &Context::new()).unwrap().0
    }

    #[test]
    fn a_section_of_an_ellipsoid_is_an_ellipse() {
        let closed = ellipsoid(0.25);
        let Oval { radii, axes } = Oval::new(DVec3::ZERO, DVec3::X, 9.0, &Target::new(&closed)).unwrap();
        assert!((radii[0] - 1.0).abs() < 0.03 && (radii[1] - 0.25).abs() < 0.01, "{radii:?}");
        assert!(axes[0].y.abs() > 0.999 && axes[1].z.abs() > 0.999, "{axes:?}");
        assert!(Oval::new(5.0 * DVec3::X, DVec3::X, 9.0, &Target::new(&closed)).is_none());
    }

    /// Cells in a flat body become flat, those in a round one stay.
    #[test]
    fn cells_in_a_flat_body_become_flat() {
        let points: Vec<DVec3> = [-1.0, -0.5, 0.0, 0.5, 1.0].map(|x| DVec3::X * x).to_vec();
        let net = CurveNet::new(points, vec![0.2; 5], vec![[0, 1], [1, 2], [2, 3], [3, 4]]);
        let start = refine::pad(&net, &assemble::base_mesh(&net, false), Padding::All, refine::CORE);
        let extent = |tube: &TubeMesh| tube.points.iter().fold(DVec3::ZERO, |most, p| most.max(p.abs()));
        let mut flat = start.clone();
        let closed = ellipsoid(0.25);
        stretch(&mut flat, &net, &Target::new(&closed));
        assert!(extent(&flat).y > 0.6 && extent(&flat).z < 0.25, "{}", extent(&flat));
        assert!(Optimiser::new(&flat.points, &flat.hexes).is_valid(&flat.points));
        let mut round = start.clone();
        let closed = ellipsoid(1.0);
        stretch(&mut round, &net, &Target::new(&closed));
        assert_eq!(round.points, start.points);
    }
}
