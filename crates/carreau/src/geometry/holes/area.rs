//! The triangulation of a loop that has the least area; of several the one with the shorter diagonals.
//!
//! ```text
//! i ───────── k      the best of all m:
//!  ╲  W(i,m) ╱       W(i,k) = min W(i,m) + W(m,k) + area(i,m,k)
//!   ╲   m   ╱
//! ```

use crate::context::Context;
use crate::error::Result;
use crate::mesh::{safe_length, triangle_area_vector};
use glam::DVec3;

/// Longer loops are cut in two first, along their shortest chord between about opposite vertices: the time grows with the cube.
const LONGEST: usize = 300;
/// What a squared length of a diagonal counts beside an area.
const CHORD: f64 = 1e-3;

/// Triangles on the vertices of a loop, in its sense; `None` where every triangulation has an edge that is there already.
pub fn least_area(
    points: &[DVec3],
    ring: &[u32],
    is_edge: impl Fn(u32, u32) -> bool + Copy,
    context: &Context,
) -> Result<Option<Vec<[u32; 3]>>> {
    let mut triangles = Vec::new();
    let mut waiting = vec![ring.to_vec()];
    while let Some(ring) = waiting.pop() {
        if ring.len() > LONGEST {
            let Some([i, j]) = chord(points, &ring, is_edge) else { return Ok(None) };
            let second = ring[j..].iter().chain(&ring[..=i]).copied().collect();
            waiting.push(second);
            waiting.push(ring[i..=j].to_vec());
            continue;
        }
        match of_short(points, &ring, is_edge, context)? {
            Some(found) => triangles.extend(found),
            None => return Ok(None),
        }
    }
    Ok(Some(triangles))
}

/// The shortest chord that leaves at least a third of the loop on both sides.
fn chord(points: &[DVec3], ring: &[u32], is_edge: impl Fn(u32, u32) -> bool) -> Option<[usize; 2]> {
    let n = ring.len();
    let (mut best, mut shortest) = (None, f64::INFINITY);
    // Some thousand chords are enough to choose from.
    let step = (n / 100).max(1);
    for i in (0..n).step_by(step) {
        for j in (i + n / 3..(i + 2 * n / 3).min(n)).step_by(step) {
            let length = points[ring[i] as usize].distance_squared(points[ring[j] as usize]);
            if length < shortest && !is_edge(ring[i], ring[j]) {
                (best, shortest) = (Some([i, j]), length);
            }
        }
    }
    best
}

fn of_short(
    points: &[DVec3],
    ring: &[u32],
    is_edge: impl Fn(u32, u32) -> bool,
    context: &Context,
) -> Result<Option<Vec<[u32; 3]>>> {
    let n = ring.len();
    let p = |k: usize| points[ring[k] as usize];
    let is_side = |i: usize, k: usize| k == i + 1 || (i == 0 && k + 1 == n);
    let at = |i: usize, k: usize| i * n + k;
    let (mut weight, mut middle) = (vec![0.0; n * n], vec![0usize; n * n]);
    for span in 2..n {
        context.check()?;
        for i in 0..n - span {
            let k = i + span;
            let mut best = (f64::INFINITY, i + 1);
            if is_side(i, k) || !is_edge(ring[i], ring[k]) {
                for m in i + 1..k {
                    let below = weight[at(i, m)] + weight[at(m, k)];
                    if below < best.0 {
                        let sum = below + safe_length(triangle_area_vector(p(i), p(m), p(k)));
                        if sum < best.0 {
                            best = (sum, m);
                        }
                    }
                }
                if !is_side(i, k) {
                    best.0 += CHORD * p(i).distance_squared(p(k));
                }
            }
            (weight[at(i, k)], middle[at(i, k)]) = best;
        }
    }
    if !weight[at(0, n - 1)].is_finite() {
        return Ok(None);
    }
    let (mut triangles, mut waiting) = (Vec::with_capacity(n - 2), vec![(0, n - 1)]);
    while let Some((i, k)) = waiting.pop() {
        if k > i + 1 {
            let m = middle[at(i, k)];
            triangles.push([ring[i], ring[m], ring[k]]);
            waiting.extend([(m, k), (i, m)]);
        }
    }
    Ok(Some(triangles))
}
