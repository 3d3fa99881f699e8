//! Collects the points, triangles and labels of a model.

use super::model::Model;
use super::shape::{Measure, Shape};
use crate::context::Context;
use crate::error::Result;
use crate::geometry::planar;
use crate::mesh::{Column, SurfaceMesh};
use glam::{DVec2, DVec3};

/// The name of the face column that holds the truth.
pub(super) const TRUTH: &str = "truth";

/// A model under construction. Faces share vertices by id, so what is sewn here needs no welding.
#[derive(Default)]
pub(super) struct Builder {
    pub(super) points: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    labels: Vec<i32>,
    shapes: Vec<Shape>,
    names: Vec<String>,
}

impl Builder {
    /// Adds a CAD face; returns its label.
    pub(super) fn shape(&mut self, name: impl Into<String>, shape: Shape) -> i32 {
        self.shapes.push(shape);
        self.names.push(name.into());
        self.shapes.len() as i32 - 1
    }

    /// Adds a vertex.
    pub(super) fn point(&mut self, p: DVec3) -> u32 {
        self.points.push(p);
        self.points.len() as u32 - 1
    }

    /// Adds vertices.
    pub(super) fn points(&mut self, points: impl IntoIterator<Item = DVec3>) -> Vec<u32> {
        points.into_iter().map(|p| self.point(p)).collect()
    }

    /// Position of a vertex.
    pub(super) fn at(&self, v: u32) -> DVec3 {
        self.points[v as usize]
    }

    /// Adds the inner points of the straight line between two vertices; returns the whole chain, ends included.
    pub(super) fn line(&mut self, ends: [u32; 2], divisions: u32) -> Vec<u32> {
        let [a, b] = ends.map(|v| self.at(v));
        let inner: Vec<DVec3> = (1..divisions).map(|k| a.lerp(b, f64::from(k) / f64::from(divisions))).collect();
        std::iter::once(ends[0]).chain(self.points(inner)).chain([ends[1]]).collect()
    }

    /// Adds a triangle.
    pub(super) fn triangle(&mut self, label: i32, triangle: [u32; 3]) {
        self.triangles.push(triangle);
        self.labels.push(label);
    }

    /// Adds a quad as two triangles along its shorter diagonal; on a tie along `a`–`c`, so that regular grids stay so.
    pub(super) fn quad(&mut self, label: i32, [a, b, c, d]: [u32; 4]) {
        let (ac, bd) = (self.at(a).distance(self.at(c)), self.at(b).distance(self.at(d)));
        if bd < ac * (1.0 - 1e-9) {
            self.triangle(label, [a, b, d]);
            self.triangle(label, [b, c, d]);
        } else {
            self.triangle(label, [a, b, c]);
            self.triangle(label, [a, c, d]);
        }
    }

    /// Adds the quads between two chains of equal length, `low` in the sense of the faces:
    ///
    /// ```text
    ///  high[0] ─── high[1] ─── high[2]
    ///     │           │           │
    ///   low[0] ─── low[1] ──── low[2]
    /// ```
    pub(super) fn band(&mut self, label: i32, low: &[u32], high: &[u32]) {
        for (l, h) in low.windows(2).zip(high.windows(2)) {
            self.quad(label, [l[0], l[1], h[1], h[0]]);
        }
    }

    /// Adds [`Builder::band`]s between closed rings of equal length, lowest first.
    pub(super) fn rings(&mut self, label: i32, rings: &[Vec<u32>]) {
        for pair in rings.windows(2) {
            self.band(label, &closed(&pair[0]), &closed(&pair[1]));
        }
    }

    /// Fills a planar face bounded by loops of vertices, an outline and any number of holes; returns its label.
    pub(super) fn planar_face(
        &mut self,
        name: &str,
        normal: DVec3,
        loops: &[&[u32]],
        edge: f64,
        context: &Context,
    ) -> Result<i32> {
        let origin = loops.first().and_then(|l| l.first()).map(|&v| self.at(v)).unwrap_or_default();
        let label = self.shape(name, Shape::Plane { origin, normal });
        let (u, v) = normal.any_orthonormal_pair();
        let flat: Vec<Vec<DVec2>> = loops
            .iter()
            .map(|l| l.iter().map(|&k| self.at(k) - origin).map(|d| DVec2::new(d.dot(u), d.dot(v))).collect())
            .collect();
        let filled = planar::fill(&flat, edge, context)?;
        let mut ids: Vec<u32> = loops.concat();
        ids.extend(self.points(filled.inner.iter().map(|p| origin + u * p.x + v * p.y)));
        for t in &filled.triangles {
            self.triangle(label, t.map(|k| ids[k as usize]));
        }
        Ok(label)
    }

    /// The finished model.
    pub(super) fn finish(self, exact: Option<Measure>) -> Result<Model> {
        let mut mesh = SurfaceMesh::from_triangles(self.points, &self.triangles)?;
        mesh.attributes.face.insert(TRUTH.into(), Column::Label(self.labels));
        for (label, name) in self.names.into_iter().enumerate() {
            mesh.attributes.names.insert((TRUTH.into(), label as i32), name);
        }
        Ok(Model { mesh, shapes: self.shapes, exact, noise: 0.0 })
    }
}

/// A ring with its first vertex repeated at the end.
pub(super) fn closed(ring: &[u32]) -> Vec<u32> {
    ring.iter().chain(ring.first()).copied().collect()
}

/// `count` points evenly spread on a circle from direction `x` towards direction `y`, both orthogonal and as long as
/// the radius.
pub(super) fn circle(centre: DVec3, x: DVec3, y: DVec3, count: u32) -> impl Iterator<Item = DVec3> {
    (0..count).map(move |k| {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / f64::from(count)).sin_cos();
        centre + x * cos + y * sin
    })
}
