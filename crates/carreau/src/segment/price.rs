//! What a triangle costs in a region: by its distance from the region's surface where it lies on one, else by the
//! difference of curvature.

use super::regions::{Groups, count, fit_most};
use super::surface::{Surface, quantile};
use super::{Basis, Chosen};
use crate::geometry::curvature::Curvature;
use crate::geometry::primitive::Primitive;
use rayon::prelude::*;

/// Weight of a triangle that is off the surface, against boundary length: large, because a surface is sure.
const SURFACE_WEIGHT: f64 = 4.0;
/// Weight of a triangle of another curvature, against boundary length: small, because curvature is blurred near
/// boundaries.
const CURVATURE_SHARE: f64 = 0.3;

/// Prices of triangles, comparable to lengths of boundary.
pub struct Prices<'a> {
    surface: &'a Surface<'a>,
    primitives: Vec<Option<Primitive>>,
    /// |k_max|, |k_min| of every triangle, and the median of every region.
    triangle: Vec<[f64; 2]>,
    region: Vec<[f64; 2]>,
    /// Mean length of an edge.
    edge: f64,
    tolerance: f64,
}

impl<'a> Prices<'a> {
    pub fn new(surface: &'a Surface<'a>, label: &[u32], curvature: &Curvature, chosen: &Chosen) -> Self {
        let count = count(label);
        let groups = Groups::new(label, count);
        let t = surface.triangles;
        let pair = |v: u32| {
            let (a, b) = (curvature.kmin[v as usize].abs(), curvature.kmax[v as usize].abs());
            [a.max(b), a.min(b)]
        };
        let triangle: Vec<[f64; 2]> = (0..surface.len() as u32)
            .into_par_iter()
            .map(|k| {
                let p = t.triangle(k).map(pair);
                std::array::from_fn(|j| p.iter().map(|p| p[j]).sum::<f64>() / 3.0 * chosen.scale)
            })
            .collect();
        let median = |l: u32| {
            std::array::from_fn(|j| {
                let mut values: Vec<f64> = groups.of(l).iter().map(|&k| triangle[k as usize][j]).collect();
                quantile(&mut values, 0.5, f64::total_cmp).unwrap_or_default()
            })
        };
        let region = (0..count as u32).into_par_iter().map(median).collect();
        // Regions of near-constant curvature lie on no surface, or they would have been recognised.
        let fitted = |l: u32| match chosen.basis {
            Basis::Curvature => None,
            _ => fit_most(surface, label, groups.of(l), chosen.tolerance),
        };
        let primitives = (0..count as u32).into_par_iter().map(fitted).collect();
        let edge = surface.mean_edge().max(f64::MIN_POSITIVE);
        Prices { surface, primitives, triangle, region, edge, tolerance: chosen.tolerance }
    }

    /// The price of triangle `k` in region `l`.
    pub fn of(&self, k: u32, l: u32) -> f64 {
        let size = self.surface.areas[k as usize] / self.edge;
        if let Some(p) = &self.primitives[l as usize] {
            let t = self.surface.triangles;
            let far = t.triangle(k).map(|v| p.distance(t.points()[v as usize]).abs()).into_iter().fold(0.0, f64::max);
            let x = far / self.tolerance;
            let off = p.normal(self.surface.center(k)).dot(self.surface.normals[k as usize]).abs() < 0.7;
            return SURFACE_WEIGHT * size * if off { 1.0 } else { (x * x).min(1.0) };
        }
        let (a, b) = (self.triangle[k as usize], self.region[l as usize]);
        let sum = a[0] + a[1] + b[0] + b[1];
        if sum > 0.0 { CURVATURE_SHARE * size * ((a[0] - b[0]).abs() + (a[1] - b[1]).abs()) / sum } else { 0.0 }
    }
}
