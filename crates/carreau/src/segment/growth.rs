//! Region growth (§4.3): from classified vertices to connected regions of triangles.
//!
//! ```text
//!        vᵢ           a triangle beyond a smooth edge joins when its opposite vertex vᵢ is sharp
//!       ╱ ╲           or has the region's cluster
//!      ╱ tᵢ╲
//!     ───eᵢ───
//!      ╲ t_L╱
//! ```

use super::classify::Pair;
use super::surface::{Sharp, Surface};
use crate::context::Context;
use crate::error::Result;
use crate::mesh::NONE;
use std::collections::VecDeque;

/// Labels of triangles, and the curvature of every region.
pub struct Regions {
    /// Region of every triangle; [`NONE`] where it takes no part.
    pub label: Vec<u32>,
    /// c_L of every region.
    pub curvature: Vec<Pair>,
}

/// Grows regions. `cluster` holds the cluster of every vertex, [`NONE`] for sharp ones.
pub fn grow(
    surface: &Surface<'_>,
    sharp: &Sharp,
    cluster: &[u32],
    centers: &[Pair],
    order: &[u32],
    context: &Context,
) -> Result<Regions> {
    let t = surface.triangles;
    let mut label = vec![NONE; t.len()];
    let mut curvature = Vec::new();
    let mut queue = VecDeque::new();
    for (step, (own, seed)) in seeds(surface, cluster, order).into_iter().enumerate() {
        context.check_every(step)?;
        if label[seed as usize] != NONE {
            continue;
        }
        let region = curvature.len() as u32;
        curvature.push(centers[own as usize]);
        label[seed as usize] = region;
        queue.push_back(seed);
        while let Some(at) = queue.pop_front() {
            for c in 3 * at..3 * at + 3 {
                let Some(next) = surface.across(c, &sharp.edge) else { continue };
                let apex = cluster[t.apex(t.opposite(c)) as usize];
                if label[next as usize] == NONE && (apex == NONE || apex == own) {
                    label[next as usize] = region;
                    queue.push_back(next);
                }
            }
        }
    }
    let mut regions = Regions { label, curvature };
    fill(surface, &sharp.edge, &mut regions.label, context)?;
    islands(surface, sharp, cluster, centers, order, &mut regions);
    Ok(regions)
}

/// The clusters and triangles of all seeds: one cluster after the other, large triangles first. What lies between two
/// clusters goes to the first that asks, which should not be a question of where the model lies in space.
fn seeds(surface: &Surface<'_>, cluster: &[u32], order: &[u32]) -> Vec<(u32, u32)> {
    let seed = |&t: &u32| seed_cluster(surface.triangles.triangle(t), cluster).map(|own| (own, t));
    let mut seeds: Vec<(u32, u32)> = order.iter().filter_map(seed).collect();
    let area = |t: u32| surface.areas[t as usize];
    seeds.sort_by(|a, b| a.0.cmp(&b.0).then_with(|| area(b.1).total_cmp(&area(a.1))));
    seeds
}

/// The cluster that makes a triangle a seed: all of its vertices that are not sharp have it.
fn seed_cluster(triangle: [u32; 3], cluster: &[u32]) -> Option<u32> {
    let mut classes = triangle.iter().map(|&v| cluster[v as usize]).filter(|&c| c != NONE);
    let first = classes.next()?;
    classes.all(|c| c == first).then_some(first)
}

/// Gives triangles without a label that of the neighbours with the longest common smooth boundary, in rounds; ties go to
/// the lowest label. The next round asks only around the triangles labelled in the last one.
pub fn fill(surface: &Surface<'_>, barrier: &[bool], label: &mut [u32], context: &Context) -> Result<()> {
    let open = |t: u32, label: &[u32]| label[t as usize] == NONE;
    let mut front: Vec<u32> = (0..surface.len() as u32).filter(|&t| open(t, label)).collect();
    while !front.is_empty() {
        context.check()?;
        let found: Vec<(u32, u32)> =
            front.iter().filter_map(|&t| Some((t, longest_neighbour(surface, barrier, label, t)?))).collect();
        found.iter().for_each(|&(t, l)| label[t as usize] = l);
        front.clear();
        for &(t, _) in &found {
            front.extend((3 * t..3 * t + 3).filter_map(|c| surface.across(c, barrier)).filter(|&n| open(n, label)));
        }
        front.sort_unstable();
        front.dedup();
    }
    Ok(())
}

/// The label with the longest smooth boundary with triangle `t`.
fn longest_neighbour(surface: &Surface<'_>, barrier: &[bool], label: &[u32], t: u32) -> Option<u32> {
    let mut sides = [(NONE, 0.0); 3];
    for (side, c) in sides.iter_mut().zip(3 * t..3 * t + 3) {
        if let Some(n) = surface.across(c, barrier) {
            *side = (label[n as usize], surface.edge_length(c));
        }
    }
    let length = |l: u32| -> f64 { sides.iter().filter(|s| s.0 == l).map(|s| s.1).sum() };
    let candidates = sides.iter().map(|s| s.0).filter(|&l| l != NONE);
    candidates.max_by(|&a, &b| length(a).total_cmp(&length(b)).then(b.cmp(&a)))
}

/// What no seed reaches becomes regions of its own, with the mean curvature of its vertices that have one.
fn islands(
    surface: &Surface<'_>,
    sharp: &Sharp,
    cluster: &[u32],
    centers: &[Pair],
    order: &[u32],
    regions: &mut Regions,
) {
    let first = regions.curvature.len() as u32;
    let mut sums: Vec<[f64; 3]> = Vec::new();
    let visit = |t: u32, region: u32| {
        sums.resize((region - first) as usize + 1, [0.0; 3]);
        let Some(sum) = sums.last_mut() else { return };
        for c in surface.triangles.triangle(t).iter().filter_map(|&v| centers.get(cluster[v as usize] as usize)) {
            *sum = [sum[0] + c[0], sum[1] + c[1], sum[2] + 1.0];
        }
    };
    surface.flood(order, &mut regions.label, first, |c| !sharp.edge[c as usize], visit);
    let mean = |s: [f64; 3]| if s[2] > 0.0 { [s[0] / s[2], s[1] / s[2]] } else { [0.0; 2] };
    regions.curvature.extend(sums.into_iter().map(mean));
}
