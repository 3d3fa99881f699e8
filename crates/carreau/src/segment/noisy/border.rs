//! Borders where the surfaces meet: the triangles beside a border between two known surfaces go to the one that they are nearer
//! to. The tolerance that finds surfaces is too wide to tell on which side of a rounded or cut edge a triangle lies:
//!
//! ```text
//!     ________ b                 ________ b
//!        a    ╲        →            a    ╲        c bridges the edge: it goes to the nearer surface,
//!            c │                        c │       however close both are in units of the noise
//! ```

use super::expand::Energy;
use super::level::LEAST_CREASE;
use super::settle::rings;
use crate::geometry::normals::angle_between;
use crate::mesh::NONE;
use crate::segment::regions::{Groups, connected, count};
use crate::segment::surface::quantile;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// A count: rings of triangles beside a border that are divided anew, because an edge is cut off or rounded by no more on each
/// side.
const DIVIDED_RINGS: u32 = 2;
/// A share of the triangles of a region that are no deeper than its core, which stays, because the region is to be there
/// afterwards.
const CORE_QUANTILE: f64 = 0.8;
/// Radians, 60°: a triangle that is turned more against a surface is not on it, however near, because thin walls have two
/// sides.
const OTHER_SIDE: f64 = 1.05;
/// In edges: what such a turn costs, far more than any distance beside a border, for the same reason.
const OTHER_SIDE_PRICE: f64 = 10.0;

/// Divides the triangles beside borders at which two surfaces meet at an angle. Fixed triangles stay.
pub fn divide(energy: &Energy<'_>, label: &mut [u32], order: &[u32]) {
    let open = open(energy, label, order);
    let t = energy.surface.triangles;
    let mut free = open.clone();
    let mut queue: BinaryHeap<Reverse<(u64, u32, u32)>> = BinaryHeap::new();
    let offer = |k: u32, free: &[bool], l: u32, queue: &mut BinaryHeap<_>| {
        for n in (3 * k..3 * k + 3).map(|c| t.opposite(c)).filter(|&o| o != NONE).map(|o| o / 3) {
            if free[n as usize]
                && let Some(price) = price(energy, n, l)
            {
                queue.push(Reverse((price.to_bits(), n, l)));
            }
        }
    };
    for k in (0..label.len() as u32).filter(|&k| !open[k as usize]) {
        offer(k, &free, label[k as usize], &mut queue);
    }
    // What no surface reaches keeps its label.
    while let Some(Reverse((_, k, l))) = queue.pop() {
        if std::mem::replace(&mut free[k as usize], false) {
            label[k as usize] = l;
            offer(k, &free, l, &mut queue);
        }
    }
}

/// The triangles that are divided anew: those beside a border at an angle, but for the core of every region.
fn open(energy: &Energy<'_>, label: &[u32], order: &[u32]) -> Vec<bool> {
    let t = energy.surface.triangles;
    let ring = rings(energy, label);
    let of = connected(energy.surface, label, order);
    let groups = Groups::new(&of, count(&of));
    let mut core = vec![0; groups.len()];
    for p in 0..groups.len() as u32 {
        let mut all: Vec<u32> = groups.of(p).iter().map(|&k| ring[k as usize]).collect();
        core[p as usize] = quantile(&mut all, CORE_QUANTILE, u32::cmp).unwrap_or_default();
    }
    let meets = |k: u32, n: u32| {
        let pair = [k, n].map(|k| energy.models.get(label[k as usize] as usize));
        let [Some(a), Some(b)] = pair else { return false };
        let p = energy.surface.center(k);
        angle_between(a.primitive.normal(p) * a.sign, b.primitive.normal(p) * b.sign) > LEAST_CREASE
    };
    let neighbours = |k: u32| (3 * k..3 * k + 3).map(|c| t.opposite(c)).filter(|&o| o != NONE).map(|o| o / 3);
    let mut near: Vec<bool> = (0..label.len() as u32)
        .map(|k| neighbours(k).any(|n| label[n as usize] != label[k as usize] && meets(k, n)))
        .collect();
    for _ in 1..DIVIDED_RINGS {
        let before = near.clone();
        for k in 0..label.len() as u32 {
            near[k as usize] |= neighbours(k).any(|n| before[n as usize] && label[n as usize] == label[k as usize]);
        }
    }
    (0..label.len()).map(|k| near[k] && !energy.fixed[k] && ring[k] < core[of[k] as usize].min(DIVIDED_RINGS)).collect()
}

/// How far a triangle is from the surface of a label, in edges; `None` for labels without one.
fn price(energy: &Energy<'_>, k: u32, l: u32) -> Option<f64> {
    let surface = energy.surface;
    let model = energy.models.get(l as usize)?;
    let p = surface.triangles.triangle(k).map(|v| surface.triangles.points()[v as usize]);
    let center = surface.center(k);
    let far = p.into_iter().chain([center]).map(|p| model.primitive.distance(p).abs()).sum::<f64>() / 4.0;
    let turn = angle_between(surface.normals[k as usize], model.primitive.normal(center) * model.sign);
    Some(far / energy.noise.edge + if turn > OTHER_SIDE { OTHER_SIDE_PRICE } else { 0.0 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::primitive::Primitive;
    use crate::mesh::Triangles;
    use crate::mesh::test_models::{grid, moved};
    use crate::segment::noisy::level::Noise;
    use crate::segment::noisy::model::Model;
    use crate::segment::surface::Surface;
    use glam::DVec3;

    /// A flat strip and an upright one; the edge between them is cut off: the cells that bridge it are nearer to the upright
    /// one.
    #[test]
    fn what_bridges_an_edge_goes_to_the_nearer_surface() {
        // Flat up to 0.3 before the edge at x = 6, upright from 0.8 below it on.
        let mesh = moved(&grid(12), |p| match p.x {
            x if x < 6.5 => p - DVec3::X * 0.3,
            x => DVec3::new(6.0, p.y, 6.2 - x),
        });
        let surface = Surface::new(&mesh, Triangles::of(&mesh).unwrap());
        let flat = |normal: DVec3, origin: DVec3| Model { primitive: Primitive::Plane { origin, normal }, sign: 1.0 };
        let edge = DVec3::X * 6.0;
        let noise = Noise::new(&surface, 0.2, 1.0, 4.0);
        let fixed = vec![false; surface.len()];
        let energy = Energy::new(&surface, &noise, vec![flat(DVec3::Z, edge), flat(DVec3::X, edge)], &fixed);
        let turned = |k: u32, most: f64| surface.normals[k as usize].dot(DVec3::Z) > most;
        // At first the bridge is with the flat strip.
        let mut label: Vec<u32> = (0..surface.len() as u32).map(|k| u32::from(!turned(k, 0.1))).collect();
        let bridge: Vec<usize> = (0..label.len()).filter(|&k| label[k] == 0 && !turned(k as u32, 0.9)).collect();
        assert_eq!(bridge.len(), 24);
        let order: Vec<u32> = (0..surface.len() as u32).collect();
        let before = label.clone();
        divide(&energy, &mut label, &order);
        for k in 0..label.len() {
            let wanted = if bridge.contains(&k) { 1 } else { before[k] };
            assert_eq!(label[k], wanted, "{k}: {:?}", surface.center(k as u32));
        }
    }
}
