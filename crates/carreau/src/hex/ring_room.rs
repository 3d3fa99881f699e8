//! Reduces radii that leave no room for cells: discs wider than their segments are long cannot be joined without folds.
//!
//! ```text
//!        ╲  θ  ╱            at a branching: the first-ring rule turned round, r ≤ d / max(1.2, 0.7 / tan(θ/2)),
//!      ───╲───╱───          and for the ring at the distance d: r ≤ 1.5 d tan(θ/2)
//!          ╲ ╱
//!           ·
//! ```
//!
//! At a bend by φ the discs of the two ends of a segment of length d lean towards each other: r sin(φ/2) ≤ 0.4 d.

use crate::mesh::CurveNet;
use glam::DVec3;

/// Reduces the radii; returns how many by more than a tenth.
pub fn limit_radii(net: &mut CurveNet) -> usize {
    let around = net.incidence();
    let direction = |v: u32, w: u32| (net.points[w as usize] - net.points[v as usize]).normalize_or(DVec3::X);
    let mut limit = vec![f64::INFINITY; net.points.len()];
    for v in 0..net.points.len() as u32 {
        let own = around.of(v);
        for &[edge, w] in own {
            let length = net.length(edge as usize);
            let others = own.iter().filter(|s| s[0] != edge);
            let theta =
                others.map(|s| direction(v, w).angle_between(direction(v, s[1]))).fold(std::f64::consts::PI, f64::min);
            let tan = (0.5 * theta).tan();
            if own.len() > 2 {
                limit[v as usize] = limit[v as usize].min(length / (0.7 / tan).max(1.2));
                limit[w as usize] = limit[w as usize].min((1.5 * length * tan).max(0.05 * length));
            } else if own.len() == 2 {
                // The bend is what is left of a straight angle.
                limit[v as usize] = limit[v as usize].min(0.4 * length / (0.5 * theta).cos().max(1e-9));
            }
        }
    }
    let reduced = net.radii.iter().zip(&limit).filter(|(r, l)| **l < 0.9 * **r).count();
    net.radii.iter_mut().zip(limit).for_each(|(r, l)| *r = r.min(l));
    reduced
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thin_chain_keeps_its_radii_and_a_thick_fork_does_not() {
        let points = vec![DVec3::ZERO, DVec3::X, DVec3::new(2.0, 0.1, 0.0), DVec3::new(-1.0, 1.0, 0.0), -DVec3::Y];
        let chain = CurveNet::new(points.clone(), vec![0.3; 5], vec![[0, 1], [1, 2]]);
        assert_eq!(limit_radii(&mut chain.clone()), 0);
        let mut fork = CurveNet::new(points, vec![3.0; 5], vec![[0, 1], [1, 2], [0, 3], [0, 4]]);
        assert!(limit_radii(&mut fork) > 0);
        assert!(fork.radii[0] <= 1.0 / 1.2 + 1e-12 && fork.radii.iter().all(|r| *r > 0.0));
        assert_eq!(limit_radii(&mut fork), 0);
    }
}
