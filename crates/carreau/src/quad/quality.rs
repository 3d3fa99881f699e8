//! The figures of a quad mesh.

use super::source::Source;
use super::validate::recall;
use super::work::Work;
use crate::context::Context;
use crate::error::Result;
use crate::geometry::distance::{Comparison, DistanceOptions, compare};
use crate::geometry::quality::scaled_jacobian;
use crate::mesh::{HalfEdges, SurfaceMesh};
use glam::DVec3;
use serde::Serialize;
use std::f64::consts::FRAC_PI_2;

/// Figures of a quad mesh.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct QuadQuality {
    /// Inner vertices without four quads, and border vertices whose quads do not fit their angle.
    pub irregular: usize,
    /// Worst scaled Jacobian.
    pub scaled_jacobian_min: f64,
    /// Mean of the quads' worst corners.
    pub scaled_jacobian_mean: f64,
    /// Quads with a scaled Jacobian of zero or less.
    pub inverted: usize,
    /// Share of the features that have an edge near and parallel.
    pub feature_recall: f64,
    /// Two-sided distance as a share of the diagonal: a bound, no sample.
    pub distance_max: Option<f64>,
    /// The largest distance that was found in search of that bound: the truth is between the two.
    pub distance_found: Option<f64>,
}

/// A count: samples in search of what quads leave out, few because a part that matters is as large as a quad.
const STRAYING_SAMPLES: usize = 5_000;

/// All but the distance.
pub fn measure(work: &Work, source: &Source) -> QuadQuality {
    QuadQuality {
        irregular: irregular(work),
        scaled_jacobian_min: least_jacobian(work),
        scaled_jacobian_mean: mean_jacobian(work),
        inverted: jacobians(work).filter(|j| !(*j > 0.0)).count(),
        feature_recall: recall(work, source).0,
        distance_max: None,
        distance_found: None,
    }
}

/// The scaled Jacobian of every quad.
fn jacobians(work: &Work) -> impl Iterator<Item = f64> + '_ {
    work.faces.iter().map(|f| scaled_jacobian([0, 1, 2, 3].map(|k| work.points[f[k] as usize])))
}

/// The least of them.
pub fn least_jacobian(work: &Work) -> f64 {
    jacobians(work).fold(f64::INFINITY, f64::min)
}

/// Their mean.
pub fn mean_jacobian(work: &Work) -> f64 {
    jacobians(work).sum::<f64>() / work.faces.len().max(1) as f64
}

/// The distance from a surface, both ways: the largest that was found, and a bound.
pub fn distance(work: &Work, surface: &SurfaceMesh, context: &Context) -> Result<[f64; 2]> {
    let options = DistanceOptions { samples: 40_000, refinements: 20_000, normals: false };
    let found = compared(work, surface, &options, context)?.relative;
    Ok([found.max, found.max_upper])
}

/// How far the quads leave the source, or leave part of it out: the largest distance of some samples, over the length of edges.
pub fn straying(work: &Work, source: &Source, context: &Context) -> Result<f64> {
    let options = DistanceOptions { samples: STRAYING_SAMPLES, refinements: 0, normals: false };
    let edge = (source.area / work.faces.len() as f64).sqrt();
    Ok(compared(work, &source.surface.mesh, &options, context)?.distance.max / edge)
}

/// Two triangles for each quad, along its shorter diagonal.
pub fn halves(work: &Work) -> Vec<[u32; 3]> {
    let mut triangles = Vec::with_capacity(2 * work.faces.len());
    for f in work.faces.iter() {
        triangles.extend(halves_of([0, 1, 2, 3].map(|k| work.points[f[k] as usize])).map(|half| half.map(|k| f[k])));
    }
    triangles
}

/// The corners of the halves of a quad.
pub fn halves_of(p: [DVec3; 4]) -> [[usize; 3]; 2] {
    match p[1].distance_squared(p[3]) < p[0].distance_squared(p[2]) {
        false => [[0, 1, 2], [0, 2, 3]],
        true => [[1, 2, 3], [1, 3, 0]],
    }
}

/// How the quads are compared with a surface.
fn compared(work: &Work, surface: &SurfaceMesh, options: &DistanceOptions, context: &Context) -> Result<Comparison> {
    let mesh = SurfaceMesh::from_triangles(work.points.clone(), &halves(work))?;
    compare(surface, &mesh, options, context)
}

/// Inner vertices without four quads, and border vertices whose quads do not fit their angle.
pub fn irregular(work: &Work) -> usize {
    let n = work.points.len();
    let (mut valence, mut angle, mut on_border) = (vec![0u32; n], vec![0.0; n], vec![false; n]);
    for f in work.faces.iter() {
        for k in 0..4 {
            let p = |k: usize| work.points[f[k % 4] as usize];
            valence[f[k] as usize] += 1;
            angle[f[k] as usize] += (p(k + 1) - p(k)).angle_between(p(k + 3) - p(k));
        }
    }
    for edge in HalfEdges::new(&work.faces, n).groups().filter(|e| e.len() == 1) {
        edge.ends.iter().for_each(|&v| on_border[v as usize] = true);
    }
    let fits = |v: usize| match on_border[v] {
        true => f64::from(valence[v]) == (angle[v] / FRAC_PI_2).round().max(1.0),
        false => valence[v] == 4,
    };
    (0..n).filter(|&v| valence[v] > 0 && !fits(v)).count()
}
