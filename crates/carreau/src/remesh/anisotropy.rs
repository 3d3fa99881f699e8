//! Anisotropic sizes: edges are longer in the direction in which the surface bends less.
//!
//! The extension that the paper announces. At a point with the principal curvatures |κ₁| ≥ |κ₂| a chord across κ₁ has the
//! sag of one across κ₂ that is √(κ₁/κ₂) times as long. The metric of a vertex is therefore
//!
//! M = h⁻² (I − w wᵀ),  |w|² = 1 − |κ₂/κ₁|,
//!
//! with h the isotropic size and the stretch w in the direction of κ₂: the size is h across w and h / √(1 − |w|²) along it.
//! On a noisy surface directions mean little at one vertex: the tensors w wᵀ are averaged over about a size, in which those
//! that contradict each other cancel.

use super::curves::Rank;
use super::rings::Rings;
use super::smoothed::rounds;
use super::support::Support;
use crate::numeric::eigen3::outer;
use glam::{DMat3, DVec3};
use rayon::prelude::*;

/// Largest |w|²: edges are at most five times as long along as across.
const MOST: f64 = 0.96;
/// Reach of the averaging of tensors, as a share of the size.
const SHARE: f64 = 1.0;
/// Most rounds of averaging.
const AVERAGING_ROUNDS: usize = 12;
/// Sweeps of the gradation of stretches.
const STRETCH_SWEEPS: usize = 12;

/// The stretch at every vertex of a support whose sizes are set. `bend` is the flat direction at every vertex, its length
/// |w| before averaging.
pub fn stretches(support: &Support, bend: &[DVec3], rank: &[Rank], beta: Option<f64>) -> Vec<DVec3> {
    let mesh = &support.mesh;
    let tensors = averaged(support, bend, rank);
    let stretch = |v: u32| {
        if rank[v as usize] != Rank::Free || !mesh.is_vertex(v) {
            return DVec3::ZERO;
        }
        dominant(tensors[v as usize], support.normal[v as usize])
    };
    let mut stretch: Vec<DVec3> = (0..mesh.vertex_slots()).into_par_iter().map(stretch).collect();
    if let Some(beta) = beta {
        grade(&support.rings, &support.size, &mut stretch, beta.ln());
    }
    stretch
}

/// Means of w wᵀ over neighbours, in as many rounds as the size at a vertex asks for.
fn averaged(support: &Support, bend: &[DVec3], rank: &[Rank]) -> Vec<DMat3> {
    let mesh = &support.mesh;
    let wanted = rounds(&support.rings, &support.size, SHARE, AVERAGING_ROUNDS);
    let mut tensor: Vec<DMat3> = bend.iter().map(|&w| outer(w)).collect();
    for round in 0..wanted.iter().copied().max().unwrap_or(0) {
        let mean = |v: u32| {
            if wanted[v as usize] <= round || rank[v as usize] != Rank::Free || !mesh.is_vertex(v) {
                return tensor[v as usize];
            }
            let (mut sum, mut count) = (tensor[v as usize], 1.0);
            for &u in support.rings.of(v).iter().filter(|&&u| rank[u as usize] == Rank::Free) {
                sum += tensor[u as usize];
                count += 1.0;
            }
            sum * (1.0 / count)
        };
        tensor = (0..mesh.vertex_slots()).into_par_iter().with_min_len(256).map(mean).collect();
    }
    tensor
}

/// The stretch that a tensor in the tangent plane stands for: its larger eigenvalue counts as far as it exceeds the other.
fn dominant(tensor: DMat3, normal: DVec3) -> DVec3 {
    if !(normal.length_squared() > 0.5) {
        return DVec3::ZERO;
    }
    let (x, y) = normal.any_orthonormal_pair();
    let (tx, ty) = (tensor * x, tensor * y);
    let (a, b, c) = (x.dot(tx), x.dot(ty), y.dot(ty));
    let half = (0.25 * (a - c) * (a - c) + b * b).sqrt();
    let angle = 0.5 * (2.0 * b).atan2(a - c);
    (x * angle.cos() + y * angle.sin()) * (2.0 * half).min(MOST).sqrt()
}

/// Shortens stretches until the size along each grows by no more than the slope towards any neighbour's in that direction.
/// All vertices at once, so that their order does not matter.
fn grade(rings: &Rings, size: &[f64], stretch: &mut Vec<DVec3>, slope: f64) {
    for _ in 0..STRETCH_SWEEPS {
        let shorter = |v: u32| {
            let w = stretch[v as usize];
            let squared = w.length_squared();
            if squared == 0.0 {
                return w;
            }
            let (h, t) = (size[v as usize], w / squared.sqrt());
            let own = h / (1.0 - squared).sqrt();
            let mut allowed = own;
            for (u, way) in rings.edges(v) {
                let across = stretch[u as usize].dot(t);
                let there = size[u as usize] / (1.0 - across * across).sqrt();
                allowed = allowed.min(there + slope * way);
            }
            if allowed >= own { w } else { t * (1.0 - (h / allowed.max(h)).powi(2)).max(0.0).sqrt() }
        };
        let graded: Vec<DVec3> = (0..rings.len()).into_par_iter().with_min_len(256).map(shorter).collect();
        if graded == *stretch {
            break;
        }
        *stretch = graded;
    }
}
