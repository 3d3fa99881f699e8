//! What was achieved: shapes, lengths, deviation, distance.

use super::size::{Metric, length_between};
use crate::context::Context;
use crate::error::Result;
use crate::geometry::distance::{DistanceOptions, compare};
use crate::geometry::features::{FeatureOptions, feature_edges};
use crate::geometry::normals::{angle_between, corner_normals, face_normals};
use crate::geometry::quality::mean_ratio;
use crate::mesh::{Column, CornerId, SurfaceMesh, safe_length, triangle_area_vector};
use glam::DVec3;
use serde::Serialize;

/// Edges above this angle have one normal per side where deviations are measured.
const SPLIT_DEG: f64 = 45.0;

/// Quality of a result, in the terms of the paper's tables.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct RemeshQuality {
    /// Smallest shape q = 4 √3 A / Σ l².
    pub shape_min: f64,
    /// Mean shape.
    pub shape_mean: f64,
    /// Shortest edge in the metric.
    pub length_min: f64,
    /// Longest edge in the metric.
    pub length_max: f64,
    /// Mean length in the metric.
    pub length_mean: f64,
    /// Share of the edges with a length in [½, 2].
    pub length_in_half_two: f64,
    /// Share of the edges with a length in [.6, 1.7].
    pub length_in_06_17: f64,
    /// Mean angle between faces and the normals at their corners, in degrees.
    pub deviation_mean_deg: f64,
    /// The same, weighted by area.
    pub deviation_area_mean_deg: f64,
    /// The largest such angle.
    pub deviation_max_deg: f64,
    /// Largest distance from the source that was found, both directions, as a share of its diagonal.
    pub distance_max: Option<f64>,
    /// Root mean square of the distance, both directions, as a share of the diagonal, with two standard errors of the
    /// samples added.
    pub distance_rms: Option<f64>,
}

/// Measures a result, in the metric of its vertex properties `size` and `stretch`.
pub fn measure(mesh: &SurfaceMesh) -> Result<RemeshQuality> {
    let [size, stretch] = ["size", "stretch"].map(|name| mesh.attributes.vertex.get(name));
    let metric = |v: usize| Metric {
        size: if let Some(Column::Scalar(size)) = size { size[v] } else { 1.0 },
        stretch: if let Some(Column::Vector3(w)) = stretch { DVec3::from(w[v]) } else { DVec3::ZERO },
    };
    let p = |v: u32| mesh.points()[v as usize];
    let shapes: Vec<f64> = mesh.faces().iter().map(|f| mean_ratio(p(f[0]), p(f[1]), p(f[2]))).collect();
    let lengths: Vec<f64> = mesh
        .half_edges()
        .groups()
        .map(|e| {
            let [a, b] = e.ends;
            length_between(p(b) - p(a), metric(a as usize), metric(b as usize))
        })
        .collect();
    let share = |low: f64, high: f64| {
        lengths.iter().filter(|l| (low..=high).contains(*l)).count() as f64 / lengths.len().max(1) as f64
    };
    let least = |x: &[f64]| x.iter().copied().fold(f64::INFINITY, f64::min);
    let mean = |x: &[f64]| crate::geometry::summary::sum(x) / x.len().max(1) as f64;
    let sharp = FeatureOptions { angle_deg: Some(SPLIT_DEG), tags: false, ..FeatureOptions::default() };
    let normals = face_normals(mesh);
    let corners = corner_normals(mesh, &normals, &feature_edges(mesh, &sharp)?.corners);
    let angles: Vec<f64> = (0..mesh.corner_count())
        .map(|c| angle_between(corners[c], normals[mesh.face_of(CornerId::new(c)).index()]).to_degrees())
        .collect();
    let areas: Vec<f64> =
        mesh.faces().iter().map(|f| safe_length(triangle_area_vector(p(f[0]), p(f[1]), p(f[2])))).collect();
    let weighted: Vec<f64> = areas.iter().zip(angles.chunks(3)).map(|(a, d)| a * d.iter().sum::<f64>() / 3.0).collect();
    Ok(RemeshQuality {
        shape_min: least(&shapes),
        shape_mean: mean(&shapes),
        length_min: least(&lengths),
        length_max: lengths.iter().copied().fold(0.0, f64::max),
        length_mean: mean(&lengths),
        length_in_half_two: share(0.5, 2.0),
        length_in_06_17: share(0.6, 1.7),
        deviation_mean_deg: mean(&angles),
        deviation_area_mean_deg: weighted.iter().sum::<f64>() / areas.iter().sum::<f64>(),
        deviation_max_deg: angles.iter().copied().fold(0.0, f64::max),
        distance_max: None,
        distance_rms: None,
    })
}

/// Triangles divided in search of the largest distance, times the faces of the source.
const REFINED: usize = 200_000_000;

impl RemeshQuality {
    /// Adds the distance between the source and the result.
    ///
    /// # Errors
    /// [`Error::Input`](crate::Error::Input) for a surface without faces,
    /// [`Error::Cancelled`](crate::Error::Cancelled), [`Error::Deadline`](crate::Error::Deadline).
    pub fn with_distance(mut self, source: &SurfaceMesh, result: &SurfaceMesh, context: &Context) -> Result<Self> {
        // A fine mesh has a vertex wherever the distance may be largest, and all vertices are looked at.
        let refinements = (REFINED / source.face_count().max(1)).clamp(2_000, 50_000);
        let options = DistanceOptions { samples: 40_000, refinements, normals: false };
        let found = compare(source, result, &options, context)?;
        self.distance_max = Some(found.relative.max);
        self.distance_rms = Some(found.relative.rms_upper);
        Ok(self)
    }
}
