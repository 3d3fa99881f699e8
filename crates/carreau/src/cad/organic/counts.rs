//! How many quads a scan gets.

use crate::mesh::{DisjointSets, SurfaceMesh, area_vector};
use rustc_hash::FxHashMap;

/// A count: quads of a body between which the blocks are drawn, because with fewer, quads of thin parts get worse, and
/// with more, tracks meet less often. Each number is for scans with which the one before makes no valid model.
const QUADS_A_BODY: [usize; 3] = [800, 1600, 3200];
/// A count: quads for every vertex of the scan at most, because between these nothing is known; more where these make no valid model,
/// or a coarse scan would be tried twice with the same quads.
const QUADS_A_VERTEX: [usize; 3] = [1, 4, 4];
/// A count: edges of quads around every hole, because with fewer the map of the surface has no room there: eight, and one that whole
/// numbers may take away.
pub const EDGES_A_HOLE: f64 = 9.0;
/// A count: holes that take more quads are left as they come, because time grows with the quads, and some holes are a triangle that
/// is missing.
const MOST_FOR_HOLES: f64 = 6000.0;
/// A count: quads in any case, because fewer have irregular vertices next to each other.
const LEAST_QUADS: usize = 200;
/// A count: bodies for which there are as many quads, because a scan with more has scraps among them, and time grows
/// with the quads.
const MOST_BODIES: usize = 50;

/// Numbers of quads in the order in which they are tried, each other than the one before.
pub fn counts(mesh: &SurfaceMesh) -> Vec<usize> {
    let least = LEAST_QUADS.max(around_holes(mesh));
    let bodies = bodies(mesh).min(MOST_BODIES);
    let counts = QUADS_A_BODY.into_iter().zip(QUADS_A_VERTEX);
    let mut tried: Vec<usize> =
        counts.map(|(count, most)| (bodies * count).min(most * mesh.vertex_count()).max(least)).collect();
    tried.dedup();
    tried
}

/// The number of quads with which edges are short enough for the smallest hole that is to be kept.
pub fn around_holes(mesh: &SurfaceMesh) -> usize {
    let mut sets = DisjointSets::new(mesh.vertex_count());
    let half_edges = mesh.half_edges();
    let borders: Vec<[u32; 2]> = half_edges.groups().filter(|e| e.len() == 1).map(|e| e.ends).collect();
    borders.iter().for_each(|&[a, b]| sets.union(a, b));
    let mut around: FxHashMap<u32, f64> = FxHashMap::default();
    for &[a, b] in &borders {
        *around.entry(sets.find(a)).or_default() += mesh.points()[a as usize].distance(mesh.points()[b as usize]);
    }
    let area: f64 = mesh.faces().iter().map(|f| area_vector(mesh.points(), f).length()).sum();
    let needed = around.into_values().map(|length| area * (EDGES_A_HOLE / length).powi(2));
    needed.filter(|&quads| quads <= MOST_FOR_HOLES).fold(0.0, f64::max) as usize
}

/// The number of connected parts.
fn bodies(mesh: &SurfaceMesh) -> usize {
    let mut sets = DisjointSets::new(mesh.vertex_count());
    mesh.faces().iter().for_each(|f| f.windows(2).for_each(|w| sets.union(w[0], w[1])));
    let mut used: Vec<u32> = mesh.faces().iter().map(|f| f[0]).collect();
    used.iter_mut().for_each(|v| *v = sets.find(*v));
    used.sort_unstable();
    used.dedup();
    used.len().max(1)
}
