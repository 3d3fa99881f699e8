//! Tapered tubes along the segments of a skeleton, blended into one smooth surface.

use super::builder::Builder;
use super::limits::{affordable_edge, positive, within};
use super::model::Model;
use super::shape::Shape;
use super::surface_nets::{Field, polygonise};
use crate::context::Context;
use crate::error::{Error, Result};
use crate::mesh::Side;
use glam::{DVec2, DVec3};

/// A tube with round ends: the convex hull of two spheres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tube {
    /// Centres of the two spheres.
    pub ends: [DVec3; 2],
    /// Their radii.
    pub radii: [f64; 2],
}

impl Tube {
    /// Signed distance to the tube's surface, negative inside.
    ///
    /// In the half plane through the axis, with the first centre at the origin, the surface is two arcs joined by their
    /// common tangent, whose normal `n` leans by the taper; `along` is the tangent's direction:
    ///
    /// ```text
    ///        ╭───────────── along
    ///      ╱  ╲ n    ────────╮        along < 0: the first sphere is nearest,
    ///     │    ·              │·      beyond the tangent's end: the second,
    ///      ╲________________ ╱        else the tangent
    /// ```
    pub fn distance(&self, p: DVec3) -> f64 {
        let [a, b] = self.ends;
        let [ra, rb] = self.radii;
        let length = a.distance(b);
        let axis = (b - a) / length;
        let y = (p - a).dot(axis);
        let q = DVec2::new((p - a - axis * y).length(), y);
        let sin = (ra - rb) / length;
        let cos = (1.0 - sin * sin).sqrt();
        let along = q.dot(DVec2::new(-sin, cos));
        if along < 0.0 {
            q.length() - ra
        } else if along > length * cos {
            p.distance(b) - rb
        } else {
            q.dot(DVec2::new(cos, sin)) - ra
        }
    }

    fn check(&self) -> Result<()> {
        self.radii.iter().try_for_each(|&r| positive("tube radius", r))?;
        let length = self.ends[0].distance(self.ends[1]);
        if length.is_finite() && length > (self.radii[0] - self.radii[1]).abs() {
            return Ok(());
        }
        Err(Error::Options("one end of a tube lies inside the other: its skeleton segment is too short".into()))
    }
}

/// The skeleton of the sample `tube-tree`: a trunk that forks twice, one side branch.
pub fn tree() -> Vec<Tube> {
    let nodes = [
        (DVec3::new(0.0, 0.0, 0.0), 0.30),
        (DVec3::new(0.05, 0.0, 1.1), 0.24),
        (DVec3::new(-0.85, 0.25, 1.9), 0.17),
        (DVec3::new(0.75, -0.15, 2.0), 0.19),
        (DVec3::new(0.65, 0.55, 3.0), 0.12),
        (DVec3::new(1.65, -0.45, 2.55), 0.13),
        (DVec3::new(-1.15, -0.35, 2.85), 0.11),
    ];
    let segments = [(0, 1), (1, 2), (1, 3), (3, 4), (3, 5), (2, 6)];
    let tube = |(a, b): (usize, usize)| Tube { ends: [nodes[a].0, nodes[b].0], radii: [nodes[a].1, nodes[b].1] };
    segments.into_iter().map(tube).collect()
}

/// The union of tubes, smooth within about `blend` of where they meet, with edges of about this length.
///
/// Each face is labelled with its nearest tube (all freeform). The result is checked to be closed and manifold; radii
/// below one edge length are refused.
///
/// # Errors
/// [`Error::Options`] for sizes that make no such model, or one of too many triangles.
pub fn tubes(tubes: &[Tube], blend: f64, edge: f64, context: &Context) -> Result<Model> {
    let thinnest = tubes.iter().flat_map(|t| t.radii).fold(f64::INFINITY, f64::min);
    tubes.iter().try_for_each(Tube::check)?;
    within("blend", blend, 0.0, f64::MAX)?;
    positive("the edge length", edge)?;
    if edge > thinnest {
        return Err(Error::Options(format!(
            "an edge length of {edge:.4} is too long for tubes as thin as radius {thinnest:.4}; use at most that"
        )));
    }
    affordable_edge(edge, tubes.iter().map(outer_area).sum())?;
    let field = Union { tubes, blend };
    let (points, triangles) = polygonise(&field, edge, context)?;
    let mut b = Builder::default();
    let labels: Vec<i32> = (0..tubes.len()).map(|k| b.shape(format!("tube {k}"), Shape::Freeform)).collect();
    for t in &triangles {
        let centre = t.iter().map(|&v| points[v as usize]).sum::<DVec3>() / 3.0;
        b.triangle(labels[field.nearest(centre)], *t);
    }
    b.points = points;
    let model = b.finish(None)?;
    check_closed(&model)?;
    Ok(model)
}

/// An upper bound of a tube's area.
fn outer_area(tube: &Tube) -> f64 {
    let r = tube.radii[0].max(tube.radii[1]);
    std::f64::consts::TAU * r * (tube.ends[0].distance(tube.ends[1]) + 2.0 * r)
}

/// The grid of the polygoniser can join what lies closer than a cell: then the edges are too long for this skeleton.
fn check_closed(model: &Model) -> Result<()> {
    let mesh = &model.mesh;
    let regular =
        (0..mesh.corner_count() as u32).all(|c| matches!(mesh.side(crate::mesh::CornerId(c)), Side::Inner(_)));
    if regular {
        Ok(())
    } else {
        Err(Error::Options("the edge length is too long for the gaps between these tubes".into()))
    }
}

/// The smooth union of tubes as a field.
struct Union<'a> {
    tubes: &'a [Tube],
    blend: f64,
}

impl Union<'_> {
    fn nearest(&self, p: DVec3) -> usize {
        let distances = self.tubes.iter().map(|t| t.distance(p)).enumerate();
        distances.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |d| d.0)
    }
}

impl Field for Union<'_> {
    /// Each step is a convex combination of two functions with slope at most 1, so the union has slope at most 1 too.
    fn value(&self, p: DVec3) -> f64 {
        self.tubes.iter().map(|t| t.distance(p)).fold(f64::INFINITY, |a, b| smooth_minimum(a, b, self.blend))
    }

    fn bounds(&self) -> (DVec3, DVec3) {
        let spheres = self.tubes.iter().flat_map(|t| [(t.ends[0], t.radii[0]), (t.ends[1], t.radii[1])]);
        let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (low, high) = spheres.fold(start, |(l, h), (c, r)| (l.min(c - r), h.max(c + r)));
        // A union lies within half a blend of its parts.
        (low - self.blend / 2.0, high + self.blend / 2.0)
    }
}

/// The lesser of two numbers, rounded off by a parabola where they differ by less than `blend`.
fn smooth_minimum(a: f64, b: f64, blend: f64) -> f64 {
    let overlap = blend - (a - b).abs();
    if overlap > 0.0 { a.min(b) - overlap * overlap / (4.0 * blend) } else { a.min(b) }
}
