//! Limbs with flat sections, as ears, palms and fins have: their rings start as ellipses, corners on the axes.
//!
//! ```text
//!     ╭──────────────╮           ╭──────V──────╮
//!     │      V       │           │M           M│
//!     │     V·V      │     →     V      ·      V       the ring of a node in a flat section
//!     │      V       │           │M           M│
//!     ╰──────────────╯           ╰──────V──────╯
//! ```
//!
//! A round ring would have all of its vertices near the two flat sides, and cells drawn to the edges from there are sheared.

use super::fit::Target;
use super::sew::BaseMesh;
use crate::mesh::{CurveNet, Incidence};
use crate::numeric::eigen3::outer;
use glam::{DMat3, DQuat, DVec3};
use rayon::prelude::*;

/// Directions in which a section is looked at.
const RAYS: usize = 64;
/// Sections are flat where they are so many times longer than wide; rings are at most so many times.
const FLAT: f64 = 1.5;
const MOST: f64 = 8.0;
/// A ring takes this share of the section's length, and reaches no farther than this share of the way to a branching: what
/// is seen from near one is the body.
const SHARE: f64 = 0.75;
const FREE: f64 = 0.6;
/// Rounds of smoothing along the branches.
const ROUNDS: usize = 2;

/// The longer axis of the section at a node, and how many times longer than the ring's radius a ring may be there.
#[derive(Clone, Copy, Default)]
struct Flatness {
    axis: DVec3,
    longer: f64,
}

/// Makes the rings of nodes in flat sections elliptic; whether there are any.
pub fn flatten(base: &mut BaseMesh, net: &CurveNet, target: &Target) -> bool {
    let around = net.incidence();
    let flat: Vec<Flatness> =
        (0..net.points.len()).into_par_iter().map(|v| flatness(net, &around, v as u32, target)).collect();
    if flat.iter().all(|f| f.axis == DVec3::ZERO) {
        return false;
    }
    let stretches = smoothed(&flat, &around);
    for (v, flat) in flat.iter().enumerate().filter(|(v, _)| around.valence(*v as u32) <= 2) {
        let (centre, ring) = (net.points[v], base.first[v] as usize + 1..base.first[v + 1] as usize);
        let turn = turn(base.points[ring.start] - centre, tangent(net, &around, v as u32), flat);
        for p in &mut base.points[ring] {
            *p = centre + stretches[v] * (turn * (*p - centre));
        }
    }
    base.reach = vec![0.0; base.points.len()];
    for v in 0..net.points.len() {
        let own = base.first[v] as usize..base.first[v + 1] as usize;
        own.for_each(|k| base.reach[k] = base.points[k].distance(net.points[v]));
    }
    true
}

/// Between the nodes next to one.
fn tangent(net: &CurveNet, around: &Incidence, v: u32) -> DVec3 {
    let at = |v: u32| net.points[v as usize];
    match *around.of(v) {
        [[_, a]] => (at(v) - at(a)).normalize_or_zero(),
        [[_, a], [_, b]] => (at(b) - at(a)).normalize_or_zero(),
        _ => DVec3::ZERO,
    }
}

fn flatness(net: &CurveNet, around: &Incidence, v: u32, target: &Target) -> Flatness {
    let (centre, radius) = (net.points[v as usize], net.radii[v as usize]);
    let tangent = tangent(net, around, v);
    if tangent == DVec3::ZERO || !target.contains(centre) {
        return Flatness::default();
    }
    let forks = (0..net.points.len() as u32).filter(|&w| around.valence(w) > 2);
    let to_fork = forks.map(|w| net.points[w as usize].distance(centre)).fold(f64::INFINITY, f64::min);
    let most = (FREE * to_fork).min(MOST * radius).max(radius);
    let (x, y) = tangent.any_orthonormal_pair();
    let ray = |k: usize| {
        let (sin, cos) = (k as f64 * std::f64::consts::TAU / RAYS as f64).sin_cos();
        let direction = x * cos + y * sin;
        direction * target.leaves(centre, direction).unwrap_or(radius).min(most)
    };
    let ends: Vec<DVec3> = (0..RAYS).map(ray).collect();
    // Second moments of the triangles between the rays.
    let mut moments = DMat3::ZERO;
    let mut area = 0.0;
    for k in 0..RAYS {
        let (a, b) = (ends[k], ends[(k + 1) % RAYS]);
        let part = a.cross(b).length();
        moments += (outer(a) + outer(b) + outer(a + b)) * (part / 12.0);
        area += part;
    }
    let (xx, xy, yy) = (x.dot(moments * x), x.dot(moments * y), y.dot(moments * y));
    let angle = 0.5 * (2.0 * xy).atan2(xx - yy);
    let axis = x * angle.cos() + y * angle.sin();
    let half = |d: DVec3| 2.0 * (d.dot(moments * d) / area.max(1e-300)).sqrt();
    let (long, wide) = (half(axis), half(tangent.cross(axis)));
    let longer = (SHARE * long / radius.max(1e-300)).min(MOST);
    if long > FLAT * wide && longer > 1.0 { Flatness { axis, longer } } else { Flatness::default() }
}

/// The stretches of the rings, smoothed along the branches; branchings have none.
fn smoothed(flat: &[Flatness], around: &Incidence) -> Vec<DMat3> {
    let excess = |f: &Flatness| outer(f.axis) * (f.longer - 1.0).max(0.0);
    let mut tensors: Vec<DMat3> = flat.iter().map(excess).collect();
    for _ in 0..ROUNDS {
        let old = tensors.clone();
        for v in 0..tensors.len() as u32 {
            let near = around.of(v);
            if near.len() <= 2 {
                let sum = near.iter().fold(DMat3::ZERO, |sum, s| sum + old[s[1] as usize]);
                tensors[v as usize] = old[v as usize] * 0.5 + sum * (0.5 / near.len().max(1) as f64);
            }
        }
    }
    tensors.into_iter().map(|t| DMat3::IDENTITY + t).collect()
}

/// The turn about the tangent that brings the nearest corner of a ring onto the axis.
fn turn(corner: DVec3, tangent: DVec3, flat: &Flatness) -> DQuat {
    if flat.axis == DVec3::ZERO {
        return DQuat::IDENTITY;
    }
    let angle = tangent.dot(corner.cross(flat.axis)).atan2(corner.dot(flat.axis));
    let quarter = std::f64::consts::FRAC_PI_2;
    DQuat::from_axis_angle(tangent, angle - (angle / quarter).round() * quarter)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::context::Context;
    use crate::hex::sew;
    use crate::sample::{Tube, tubes};

    /// A tube along x, three times as wide as high; the plane of its longer axis stands at 30°.
    #[test]
    fn rings_in_a_flat_section_are_as_flat_and_have_their_corners_on_its_axes() {
        let tube = Tube { ends: [DVec3::ZERO, DVec3::X * 6.0], radii: [1.0; 2] };
        let round = tubes(&[tube], 0.1, 0.25, &Context::new()).unwrap().mesh;
        let (long, short) = (DVec3::new(0.0, 0.75f64.sqrt(), 0.5), DVec3::new(0.0, -0.5, 0.75f64.sqrt()));
        let flattened = |p: DVec3| DVec3::X * p.x + 3.0 * p.y * long + p.z * short;
        let surface = crate::mesh::test_models::moved(&round, flattened);
        let (closed, _) = crate::skeleton::prepared(&surface, &Context::new()).unwrap();
        let points = (0..=4).map(|k| DVec3::X * (1.5 * f64::from(k))).collect();
        let net = CurveNet::new(points, vec![0.85; 5], (1..5).map(|k| [k - 1, k]).collect());
        let mut base = sew::base_mesh(&net);
        assert!(flatten(&mut base, &net, &Target::new(&closed)));
        let ring = |v: usize| base.first[v] as usize + 1..base.first[v + 1] as usize;
        for v in 1..4 {
            let off = |k: usize, d: DVec3| (base.points[k] - net.points[v]).dot(d).abs();
            let most = |d: DVec3| ring(v).map(|k| off(k, d)).fold(0.0, f64::max);
            assert!(
                (2.0..3.0).contains(&most(long)) && (0.8..0.9).contains(&most(short)),
                "{} {}",
                most(long),
                most(short)
            );
            // The corners come first.
            assert!(ring(v).take(4).all(|k| off(k, long).min(off(k, short)) < 0.05));
        }
    }
}
