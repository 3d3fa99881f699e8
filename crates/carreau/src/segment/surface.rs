//! The triangles as the stages see them: areas, sharp edges and vertices (§4.1), a numbering-free order.

use crate::context::Context;
use crate::error::Result;
use crate::geometry::normals::{angle_between, face_normals};
use crate::mesh::{NONE, SurfaceMesh, Triangles, safe_length, triangle_area_vector};
use glam::DVec3;
use rayon::prelude::*;

/// A triangle mesh with what every stage asks for.
pub struct Surface<'a> {
    pub mesh: &'a SurfaceMesh,
    pub triangles: Triangles<'a>,
    /// Unit normals; zero where a triangle has no area.
    pub normals: Vec<DVec3>,
    pub areas: Vec<f64>,
    pub total_area: f64,
    /// Angle between the normals across the half-edge that leaves a corner, in radians; both half-edges of an edge have
    /// the same number, π on borders and irregular edges.
    pub bend: Vec<f32>,
}

impl<'a> Surface<'a> {
    pub fn new(mesh: &'a SurfaceMesh, triangles: Triangles<'a>) -> Self {
        let normals = face_normals(mesh);
        let count = triangles.len() as u32;
        let areas: Vec<f64> = (0..count).into_par_iter().map(|t| area(triangles, t)).collect();
        let bend = |c: u32| match triangles.opposite(c) {
            NONE => std::f32::consts::PI,
            o => angle_between(normals[c.min(o) as usize / 3], normals[c.max(o) as usize / 3]) as f32,
        };
        let bend = (0..3 * count).into_par_iter().map(bend).collect();
        let total_area = sum(&areas);
        Surface { mesh, triangles, normals, areas, total_area, bend }
    }

    pub fn len(&self) -> usize {
        self.areas.len()
    }

    /// Length of the edge that leaves a corner.
    #[inline]
    pub fn edge_length(&self, c: u32) -> f64 {
        self.triangles.point(c).distance(self.triangles.point(self.triangles.next(c)))
    }

    /// Angle of a triangle at a corner, in radians.
    pub fn corner_angle(&self, c: u32) -> f64 {
        let t = self.triangles;
        let p = t.point(c);
        angle_between(t.point(t.next(c)) - p, t.point(t.previous(c)) - p)
    }

    /// The triangle across the half-edge, if there is one and the half-edge is no barrier.
    #[inline]
    pub fn across(&self, c: u32, barrier: &[bool]) -> Option<u32> {
        match self.triangles.opposite(c) {
            NONE => None,
            _ if barrier[c as usize] => None,
            o => Some(o / 3),
        }
    }

    /// The mean of the corners of a triangle.
    pub fn centroid(&self, t: u32) -> DVec3 {
        (3 * t..3 * t + 3).map(|c| self.triangles.point(c)).sum::<DVec3>() / 3.0
    }

    /// The triangles in an order that does not depend on their numbers: by centroid.
    pub fn canonical_order(&self) -> Vec<u32> {
        let points = self.triangles.points();
        let key = |t: u32| {
            let [a, b, c] = self.triangles.triangle(t).map(|v| points[v as usize]);
            (a + b + c).to_array()
        };
        let mut order: Vec<([f64; 3], u32)> = (0..self.len() as u32).into_par_iter().map(|t| (key(t), t)).collect();
        order.par_sort_unstable_by(|(a, s), (b, t)| {
            let by = |k: usize| a[k].total_cmp(&b[k]);
            by(0).then_with(|| by(1)).then_with(|| by(2)).then(s.cmp(t))
        });
        order.into_iter().map(|(_, t)| t).collect()
    }
}

fn area(triangles: Triangles<'_>, t: u32) -> f64 {
    let p = triangles.triangle(t).map(|v| triangles.points()[v as usize]);
    safe_length(triangle_area_vector(p[0], p[1], p[2]))
}

/// Sum over fixed chunks: the same for any number of threads.
pub fn sum(values: &[f64]) -> f64 {
    let parts: Vec<f64> = values.par_chunks(4096).map(|chunk| chunk.iter().sum()).collect();
    parts.iter().sum()
}

/// Sharp edges and vertices.
pub struct Sharp {
    /// Per corner: the half-edge bends by more than the angle, is a border, or is irregular.
    pub edge: Vec<bool>,
    /// Per vertex: end of an edge that bends more than the angle.
    pub vertex: Vec<bool>,
}

impl Sharp {
    pub fn new(surface: &Surface<'_>, angle: f64) -> Self {
        let edge: Vec<bool> = surface.bend.iter().map(|&b| f64::from(b) > angle).collect();
        let mut vertex = vec![false; surface.triangles.points().len()];
        let t = surface.triangles;
        for (c, _) in edge.iter().enumerate().filter(|(_, sharp)| **sharp) {
            let c = c as u32;
            if t.opposite(c) != NONE {
                vertex[t.vertex(c) as usize] = true;
                vertex[t.vertex(t.next(c)) as usize] = true;
            }
        }
        Sharp { edge, vertex }
    }

    /// Number of sharp vertices of a triangle.
    pub fn count(&self, triangle: [u32; 3]) -> usize {
        triangle.iter().filter(|&&v| self.vertex[v as usize]).count()
    }
}

/// The angle, in radians, that divides sharp edges from smooth ones: the middle of the widest gap in the sorted bends
/// between 15° and 40°, where there is one of at least 4°; 25° otherwise.
pub fn sharp_angle(surface: &Surface<'_>, context: &Context) -> Result<f64> {
    context.check()?;
    let (low, high, default, least) = (15f32, 40f32, 25f64, 4f32);
    let mut bends: Vec<f32> = surface.bend.iter().map(|b| b.to_degrees()).filter(|b| (low..high).contains(b)).collect();
    bends.extend([low, high]);
    bends.sort_unstable_by(f32::total_cmp);
    let gap = |w: &[f32]| w[1] - w[0];
    // Of equal gaps the one that starts first.
    let widest = bends.windows(2).fold(None::<[f32; 2]>, |best, w| match best {
        Some(b) if b[1] - b[0] >= gap(w) => Some(b),
        _ => Some([w[0], w[1]]),
    });
    let middle = widest.filter(|w| w[1] - w[0] >= least).map(|w| f64::from(w[0] + w[1]) / 2.0);
    Ok(middle.unwrap_or(default).to_radians())
}

/// A multiple of the median bend, in radians: sharp on a surface that bends at every edge.
pub fn noisy_sharp_angle(surface: &Surface<'_>, multiple: f64) -> f64 {
    let mut bends: Vec<f32> = surface.bend.iter().copied().filter(|&b| b < std::f32::consts::PI).collect();
    let middle = bends.len() / 2;
    if bends.is_empty() { 0.0 } else { multiple * f64::from(*bends.select_nth_unstable_by(middle, f32::total_cmp).1) }
}
