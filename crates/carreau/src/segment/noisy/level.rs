//! How noisy a mesh is: the residuals of small patches from the paraboloids through them.

use super::patch::Patches;
use crate::mesh::NONE;
use crate::numeric::levenberg::solve_cholesky;
use crate::segment::surface::{Surface, quantile};
use glam::DVec3;
use rayon::prelude::*;

/// A count: most patches that are asked, because a quartile of more is hardly surer.
const LEVEL_PATCHES: usize = 800;
/// A count: triangles of a patch that a paraboloid is fitted to, small because the surface is to be no more than one
/// there.
const PARABOLOID_TRIANGLES: usize = 24;
/// A count: triangles of a patch that a cubic surface is fitted to, more because it has more coefficients.
const CUBIC_TRIANGLES: usize = 40;
/// A count: fewer patches say nothing, because a quartile of them is chance.
const LEAST_PATCHES: usize = 8;
/// Radians: patches end where the mesh bends by more, because no polynomial over a plane follows an edge.
const PATCH_FOLD: f64 = 0.7;
/// The lower quartile of the root mean square of about 13 normal numbers, over their deviation: so many are free,
/// because a patch has that many vertices beyond the coefficients.
const RESIDUAL_QUARTILE: f64 = 0.86;
/// A count: coefficients of a paraboloid, the terms of two variables up to degree two.
const PARABOLOID_COEFFICIENTS: usize = 6;
/// A count: coefficients of a cubic surface, the terms of two variables up to degree three.
const CUBIC_COEFFICIENTS: usize = 10;

/// The standard deviation of the vertices from a smooth surface, along the normal, as the quieter part of the mesh has it;
/// `None` where there are too few patches to tell.
pub fn level(surface: &Surface<'_>, order: &[u32]) -> Option<f64> {
    let mut residuals = residuals::<PARABOLOID_COEFFICIENTS>(surface, order, PARABOLOID_TRIANGLES);
    let enough = residuals.len() >= LEAST_PATCHES;
    let quartile = quantile(&mut residuals, 0.25, f64::total_cmp)?;
    enough.then_some(quartile / RESIDUAL_QUARTILE)
}

/// How rough the rougher part of some triangles is: the upper quartile of the residuals from cubic surfaces, which all that is
/// smooth follows over a few edges; `None` where there are too few patches to tell.
pub fn roughness(surface: &Surface<'_>, order: &[u32]) -> Option<f64> {
    let mut residuals = residuals::<CUBIC_COEFFICIENTS>(surface, order, CUBIC_TRIANGLES);
    let enough = residuals.len() >= LEAST_PATCHES;
    quantile(&mut residuals, 0.75, f64::total_cmp).filter(|_| enough)
}

/// Residuals of patches around some of the triangles.
fn residuals<const N: usize>(surface: &Surface<'_>, order: &[u32], size: usize) -> Vec<f64> {
    let barrier = |c: u32| f64::from(surface.bend[c as usize]) > PATCH_FOLD;
    let mut patches = Patches::new(surface);
    let mut residuals = Vec::new();
    for &seed in order.iter().step_by(order.len().div_ceil(LEVEL_PATCHES).max(1)) {
        patches.around(seed, size, &barrier);
        if patches.triangles.len() == size {
            residuals.extend(residual::<N>(surface, &patches.triangles, &patches.points));
        }
    }
    residuals
}

/// Root mean square residual of points from their polynomial surface of `N` coefficients over the mean plane of triangles.
fn residual<const N: usize>(surface: &Surface<'_>, triangles: &[u32], points: &[DVec3]) -> Option<f64> {
    if points.len() < N + 4 {
        return None;
    }
    let up = triangles.iter().map(|&k| surface.normals[k as usize] * surface.areas[k as usize]).sum::<DVec3>();
    let up = up.try_normalize()?;
    let u = up.any_orthonormal_vector();
    let v = up.cross(u);
    let mean = points.iter().sum::<DVec3>() / points.len() as f64;
    let size = points.iter().map(|p| p.distance(mean)).fold(0.0, f64::max);
    let row = |p: DVec3| {
        let d = (p - mean) / size;
        let (x, y) = (d.dot(u), d.dot(v));
        let all = [1.0, x, y, x * x, x * y, y * y, x * x * x, x * x * y, x * y * y, y * y * y];
        (std::array::from_fn::<f64, N, _>(|k| all[k.min(9)]), d.dot(up))
    };
    let (mut matrix, mut rhs) = ([[0.0; N]; N], [0.0; N]);
    for (r, z) in points.iter().map(|&p| row(p)) {
        for i in 0..N {
            (0..N).for_each(|j| matrix[i][j] += r[i] * r[j]);
            rhs[i] += r[i] * z;
        }
    }
    let c = solve_cholesky(&matrix, &rhs)?;
    let square = |p: DVec3| {
        let (r, z) = row(p);
        (z - r.iter().zip(&c).map(|(a, b)| a * b).sum::<f64>()).powi(2)
    };
    let sum: f64 = points.iter().map(|&p| square(p)).sum();
    let rms = size * (sum / (points.len() - N) as f64).sqrt();
    rms.is_finite().then_some(rms)
}

/// What noise of a given deviation does to the triangles.
pub struct Noise {
    pub sigma: f64,
    /// Length of an edge.
    pub edge: f64,
    /// Triangles that say what one says whose noise is independent of that of its neighbours.
    pub triangles_a_sample: f64,
    /// Triangles whose deviations from the right surface are alike, because the noise is a wave.
    pub triangles_a_wave: f64,
    /// Deviation of the normal of every triangle, in radians, about each of two axes.
    pub turn: Vec<f64>,
    /// Per corner: the half-edge is a border or bends more than noise does.
    pub crease: Vec<bool>,
}

/// A count of standard deviations: larger bends are creases, because noise makes no such bends.
const CREASE_DEVIATIONS: f64 = 4.0;
/// Radians: creases bend by this at least, because facets of coarse smooth surfaces bend by nearly as much.
pub const LEAST_CREASE: f64 = 0.35;
/// Radians: largest deviation of a normal, because normals of slivers say nothing and this says so.
const LARGEST_TURN: f64 = 1.0;

impl Noise {
    /// Noise that is independent from vertex to vertex.
    pub fn white(surface: &Surface<'_>, sigma: f64) -> Self {
        Self::new(surface, sigma, surface.mean_edge(), 1.0)
    }

    pub fn new(surface: &Surface<'_>, sigma: f64, edge: f64, triangles_a_sample: f64) -> Self {
        let turn: Vec<f64> = (0..surface.len() as u32)
            .into_par_iter()
            .map(|k| {
                let longest = (3 * k..3 * k + 3).map(|c| surface.edge_length(c)).fold(0.0, f64::max);
                // √2 σ / edge for an equilateral triangle.
                let height = 2.0 * surface.areas[k as usize] / longest;
                if height > 0.0 { (1.23 * sigma / height).min(LARGEST_TURN) } else { LARGEST_TURN }
            })
            .collect();
        let crease = (0..3 * surface.len() as u32).into_par_iter().map(|c| is_crease(surface, &turn, c)).collect();
        Noise { sigma, edge, triangles_a_sample, triangles_a_wave: triangles_a_sample, turn, crease }
    }

    /// Whether deviations may be alike over more triangles than a sample has.
    pub fn has_waves(&self) -> bool {
        self.triangles_a_wave > self.triangles_a_sample
    }

    /// Deviation of the bend of a half-edge, in radians.
    pub fn bend(&self, surface: &Surface<'_>, c: u32) -> f64 {
        bend_deviation(surface, &self.turn, c)
    }
}

fn bend_deviation(surface: &Surface<'_>, turn: &[f64], c: u32) -> f64 {
    match surface.triangles.opposite(c) {
        NONE => LARGEST_TURN,
        o => turn[c as usize / 3].hypot(turn[o as usize / 3]),
    }
}

/// Borders have the bend π.
fn is_crease(surface: &Surface<'_>, turn: &[f64], c: u32) -> bool {
    f64::from(surface.bend[c as usize]) > (CREASE_DEVIATIONS * bend_deviation(surface, turn, c)).max(LEAST_CREASE)
}
