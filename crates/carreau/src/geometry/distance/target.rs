//! A surface to measure from and to.

use crate::geometry::normals::{angle_between, face_normals};
use crate::geometry::search_tree::{Closest, TriangleTree};
use crate::mesh::{SurfaceMesh, safe_length, triangle_area_vector};
use glam::DVec3;

/// Closest points within this share of the diagonal of the true distance count as equally close.
pub const TIE: f64 = 1e-9;

/// A surface prepared for questions.
pub struct Target<'a> {
    pub(super) points: &'a [DVec3],
    /// Vertices of the triangles, neighbours close to each other.
    pub(super) used: Vec<u32>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// Normal of every triangle: that of the face it belongs to.
    pub(super) normals: Vec<DVec3>,
    pub(super) tree: TriangleTree,
    pub(super) diagonal: f64,
}

impl<'a> Target<'a> {
    pub(super) fn new(mesh: &'a SurfaceMesh) -> Self {
        let (triangles, parent) = mesh.faces().fan();
        let of_face = face_normals(mesh);
        let tree = TriangleTree::new(mesh.points(), &triangles);
        let mut is_new = vec![true; mesh.vertex_count()];
        let first = |v: &u32| std::mem::take(&mut is_new[*v as usize]);
        Target {
            points: mesh.points(),
            used: tree.in_order().flat_map(|(t, _)| triangles[t as usize]).filter(first).collect(),
            tree,
            normals: parent.into_iter().map(|f| of_face[f as usize]).collect(),
            triangles,
            diagonal: mesh.diagonal(),
        }
    }

    pub(super) fn corners(&self, triangle: u32) -> [DVec3; 3] {
        self.triangles[triangle as usize].map(|v| self.points[v as usize])
    }

    /// Twice the area of every triangle.
    pub(super) fn areas(&self) -> Vec<f64> {
        let area = |t: u32| {
            let [a, b, c] = self.corners(t);
            safe_length(triangle_area_vector(a, b, c))
        };
        (0..self.triangles.len() as u32).map(area).collect()
    }

    /// The closest point, from the answer to the question before: points in a row are near each other, as a rule. The tree
    /// is never empty here.
    pub(super) fn closest_near(&self, p: DVec3, last: &mut Option<u32>) -> Closest {
        let nothing = Closest { triangle: 0, point: p, distance_squared: f64::INFINITY };
        let found = match last {
            Some(triangle) => self.tree.closest_near(p, self.corners(*triangle)),
            None => self.tree.closest(p),
        };
        let found = found.unwrap_or(nothing);
        *last = Some(found.triangle);
        found
    }

    /// The smallest angle between a normal and those of the equally close triangles: at an edge of this surface any of
    /// its faces may be meant. `None` where there is no normal on either side.
    pub(super) fn angle_to(&self, normal: DVec3, p: DVec3, closest: &Closest) -> Option<f64> {
        let angle = |triangle: u32| angle_between(normal, self.normals[triangle as usize]);
        if normal == DVec3::ZERO {
            return None;
        }
        let mut best = f64::INFINITY;
        self.tree.within(p, closest.distance() + TIE * self.diagonal, |c| {
            if self.normals[c.triangle as usize] != DVec3::ZERO {
                best = best.min(angle(c.triangle));
            }
        });
        best.is_finite().then_some(best)
    }
}
