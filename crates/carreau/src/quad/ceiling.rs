//! What the scaled Jacobian can be at the corners of quads: 1 but where features leave a narrow sector to them.
//!
//! ```text
//!   ━━━━━━━ feature      In the sector of angle A between two features k quads have A / k each,
//!   ╲ A╱                 and sin(A / k), below a right angle, is all that they can have there.
//!    ╲╱
//! ```
//!
//! Around the tip of a cone as many quads as there are share its angle.

use super::around::normal;
use super::work::{Place, Work};
use crate::geometry::normals::{angle_between, unit};
use crate::mesh::{DisjointSets, HalfEdges};
use glam::DVec3;
use rustc_hash::FxHashSet;
use std::f64::consts::{FRAC_PI_2, PI};

/// A scaled Jacobian: no ceiling is lower, because what there is gets divided by it.
const LOWEST_CEILING: f64 = 0.01;

/// A count: quads around a tip at least, because fewer than three cannot be.
const FEWEST_AT_TIP: f64 = 3.0;

/// The ceiling of every corner, for the quads that are there.
pub fn ceilings(work: &Work) -> Vec<[f64; 4]> {
    let shared = |angle: f64, quads: u32| (angle / f64::from(quads)).min(FRAC_PI_2).sin();
    of_sectors(work, shared, shared)
}

/// The ceiling of every corner, for the best number of quads in its sector or around its tip.
fn best_ceilings(work: &Work) -> Vec<[f64; 4]> {
    let around_tip = |angle: f64, _| (angle / FEWEST_AT_TIP).min(FRAC_PI_2).sin();
    let in_sector = |angle: f64, _| {
        let few = (angle / FRAC_PI_2).floor().max(1.0);
        (angle / few).min(PI).sin().max((angle / (few + 1.0)).sin())
    };
    of_sectors(work, in_sector, around_tip)
}

/// What the angle of a sector between features, or around a tip, and the number of its quads say of their corners there.
fn of_sectors(work: &Work, ceiling: impl Fn(f64, u32) -> f64, at_tip: impl Fn(f64, u32) -> f64) -> Vec<[f64; 4]> {
    let corners = work.faces.corners();
    let next = |c: u32| c / 4 * 4 + (c + 1) % 4;
    let mut sectors = DisjointSets::new(corners.len());
    let mut is_on_feature = vec![false; work.points.len()];
    let features: FxHashSet<[u32; 2]> = work.features.iter().map(|([a, b], _)| [*a.min(b), *a.max(b)]).collect();
    features.iter().flatten().for_each(|&v| is_on_feature[v as usize] = true);
    for edge in HalfEdges::new(&work.faces, work.points.len()).groups() {
        let [a, b] = edge.ends;
        if let (2, false) = (edge.len(), features.contains(&[a.min(b), a.max(b)])) {
            let both: Vec<u32> = edge.corners().collect();
            sectors.union(both[0], next(both[1]));
            sectors.union(both[1], next(both[0]));
        }
    }
    let (sector, count) = sectors.labels();
    let (mut angle, mut quads) = (vec![0.0; count], vec![0u32; count]);
    let at = |c: u32| work.points[corners[c as usize] as usize];
    for (c, &s) in (0u32..).zip(&sector) {
        let [ahead, back] = [next(c), next(next(next(c)))].map(|d| unit(at(d) - at(c)));
        angle[s as usize] += angle_between(ahead, back);
        quads[s as usize] += 1;
    }
    let of = |c: usize| {
        let (v, angle, quads) = (corners[c] as usize, angle[sector[c] as usize], quads[sector[c] as usize]);
        match (is_on_feature[v], work.place.get(v)) {
            (true, _) => ceiling(angle, quads).max(LOWEST_CEILING),
            (false, Some(Place::Fixed)) => at_tip(angle, quads).max(LOWEST_CEILING),
            (false, _) => 1.0,
        }
    };
    (0..work.faces.len()).map(|q| [0, 1, 2, 3].map(|k| of(4 * q + k))).collect()
}

/// The scaled Jacobian at the corners of a quad, looked at from a direction.
pub fn jacobians(p: [DVec3; 4], up: DVec3) -> [f64; 4] {
    let sides = [0, 1, 2, 3].map(|k| (p[(k + 1) % 4] - p[k]).normalize_or_zero());
    [0, 1, 2, 3].map(|k| sides[(k + 3) % 4].cross(sides[k]).dot(up))
}

/// The same over what it can be there.
pub fn shape(p: [DVec3; 4], up: DVec3, ceilings: &[f64; 4]) -> [f64; 4] {
    over(jacobians(p, up), ceilings)
}

/// Scaled Jacobians over what they can be.
pub fn over(jacobians: [f64; 4], ceilings: &[f64; 4]) -> [f64; 4] {
    [0, 1, 2, 3].map(|k| jacobians[k] / ceilings[k])
}

/// The worst shape of every quad, over what the best numbers of quads between features allow.
pub fn worst_shapes(work: &Work) -> impl Iterator<Item = f64> + '_ {
    let quads = work.faces.iter().map(|f| [0, 1, 2, 3].map(|k| work.points[f[k] as usize]));
    quads.zip(best_ceilings(work)).map(|(p, c)| shape(p, normal(p), &c).into_iter().fold(f64::INFINITY, f64::min))
}

/// The worst shape there is.
pub fn worst_shape(work: &Work) -> f64 {
    worst_shapes(work).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::quality::scaled_jacobian;
    use crate::mesh::Polygons;
    use glam::DVec2;
    use std::f64::consts::TAU;

    /// A kite of 60° at its first corner, with features along its two long sides, in one quad, or cut along its axis in two.
    fn kite(is_cut: bool) -> Work {
        let at = |x: f64, y: f64| DVec3::new(x, y, 0.0);
        let side = [0.5 * 3f64.sqrt(), 0.5];
        let points = vec![at(0.0, 0.0), at(side[0], -side[1]), at(1.286, 0.0), at(side[0], side[1]), at(0.5, 0.0)];
        let mut faces = Polygons::new();
        match is_cut {
            false => faces.push(&[0, 1, 2, 3]),
            true => [[0, 1, 2, 4], [0, 4, 2, 3]].iter().for_each(|q| faces.push(q)),
        }
        let features = vec![([0, 1], 0), ([3, 0], 1)];
        Work { points, faces, features, ..Work::default() }
    }

    #[test]
    fn a_sector_between_features_is_shared_by_its_quads() {
        let one = ceilings(&kite(false))[0];
        assert!((one[0] - 60f64.to_radians().sin()).abs() < 1e-12 && one[2] == 1.0, "{one:?}");
        let two = ceilings(&kite(true));
        assert!(two.iter().all(|c| (c[0] - 0.5).abs() < 1e-12), "{two:?}");
        // One quad would have been better there.
        let best = best_ceilings(&kite(true));
        assert!(best.iter().all(|c| (c[0] - 60f64.to_radians().sin()).abs() < 1e-12), "{best:?}");
    }

    #[test]
    fn what_is_at_its_ceiling_is_as_good_as_it_can_be() {
        let one = worst_shape(&kite(false));
        assert!(one > 0.96, "{one}");
        assert!(scaled_jacobian([0, 1, 2, 3].map(|k| kite(false).points[k])) < 0.9);
    }

    /// Three quads around the tip of a pyramid; the tip is held or not.
    fn needle(is_held: bool) -> Work {
        let at = |k: u32| {
            let flat = DVec2::from_angle(TAU * f64::from(k) / 6.0);
            (flat * 20f64.to_radians().tan() / 2.0).extend(if k.is_multiple_of(2) { 1.0 } else { 0.9 })
        };
        let mut faces = Polygons::new();
        [0, 2, 4].iter().for_each(|&k| faces.push(&[6, k + 1, (k + 2) % 6, (k + 3) % 6]));
        let mut place = vec![Place::Region(0); 7];
        if is_held {
            place[6] = Place::Fixed;
        }
        Work { points: (0..6).map(at).chain([DVec3::new(0.0, 0.0, 2.0)]).collect(), place, faces, ..Work::default() }
    }

    #[test]
    fn the_quads_around_a_tip_share_its_angle() {
        let work = needle(true);
        let [ahead, tip, back] = [1, 6, 3].map(|v| work.points[v]);
        let sin = angle_between(unit(ahead - tip), unit(back - tip)).sin();
        assert!(ceilings(&work).iter().all(|c| (c[0] - sin).abs() < 1e-12 && c[1..] == [1.0; 3]), "{sin}");
        assert_eq!(ceilings(&work), best_ceilings(&work));
        assert_eq!(ceilings(&needle(false)), vec![[1.0; 4]; 3]);
    }
}
