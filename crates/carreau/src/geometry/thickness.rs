//! Thin walls and narrow gaps: how far it is from a face to the opposite one, through the material or through the room before it.
//!
//! From the middle of every face a ray goes against its normal (walls) or along it (gaps), up to a limit. What it meets counts where it
//! is opposite, its normal turned by more than 120° from the face's own, and has no corner at a place of the face.
//!
//! ```text
//!  ────────────
//!     ↓ wall         material between the lines
//!  ────────────
//!     ↕ gap
//!  ────────────
//! ```

use super::normals::face_normals;
use super::search_tree::TriangleTree;
use crate::context::Context;
use crate::error::Result;
use crate::mesh::SurfaceMesh;
use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

/// Cosine of the angle between normals from which faces are opposite: 120°.
const OPPOSITE: f64 = -0.5;
/// How many places are kept.
const FACES_KEPT: usize = 10;

/// On which side of a face is looked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// Behind it: the wall that it bounds.
    Wall,
    /// Before it: the gap to the next face.
    Gap,
}

/// Faces with an opposite one nearer than a limit.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Thin {
    /// Number of faces.
    pub faces: usize,
    /// The least distance, in the unit of the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub least: Option<f64>,
    /// The first: a face and the one that is opposite.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub places: Vec<[u32; 2]>,
}

/// The faces whose opposite ones are nearer than a limit, on one side; polygons are fans.
///
/// # Errors
/// [`crate::Error::Cancelled`], [`crate::Error::Deadline`].
pub fn thin(mesh: &SurfaceMesh, side: Side, limit: f64, context: &Context) -> Result<Thin> {
    let (triangles, face) = mesh.faces().fan();
    let points = mesh.points();
    let tree = TriangleTree::new(points, &triangles);
    let normals = face_normals(mesh);
    let distance = |t: usize| -> Result<Option<(f64, u32)>> {
        context.check_every(t)?;
        let own = triangles[t].map(|v| points[v as usize]);
        let normal = normals[face[t] as usize];
        let middle = own.iter().sum::<DVec3>() / 3.0;
        let way = if side == Side::Wall { -normal } else { normal };
        let mut nearest: Option<(f64, u32)> = None;
        if way != DVec3::ZERO {
            tree.along_ray(middle, way, limit, |hit| {
                let other = triangles[hit.triangle as usize];
                let is_opposite = normals[face[hit.triangle as usize] as usize].dot(normal) < OPPOSITE;
                let is_beside = other.iter().any(|&v| own.contains(&points[v as usize]));
                if is_opposite && !is_beside && nearest.is_none_or(|known| (hit.t, hit.triangle) < known) {
                    nearest = Some((hit.t, hit.triangle));
                }
            });
        }
        Ok(nearest)
    };
    let found: Vec<Option<(f64, u32)>> = (0..triangles.len()).into_par_iter().map(distance).collect::<Result<_>>()?;
    let mut thin = Thin::default();
    let mut last = None;
    for (t, (distance, other)) in found.iter().enumerate().filter_map(|(t, found)| Some((t, (*found)?))) {
        thin.least = Some(thin.least.map_or(distance, |least| least.min(distance)));
        // The triangles of a polygon follow each other.
        if last != Some(face[t]) {
            thin.faces += 1;
            if thin.places.len() < FACES_KEPT {
                thin.places.push([face[t], face[other as usize]]);
            }
        }
        last = Some(face[t]);
    }
    Ok(thin)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::test_models::*;

    fn of(mesh: &SurfaceMesh, side: Side, limit: f64) -> Thin {
        thin(mesh, side, limit, &Context::new()).unwrap()
    }

    #[test]
    fn plates_are_thin_and_what_lies_between_them_is_narrow() {
        let plate = |z: f64| moved(&cube(DVec3::ZERO, 1.0), |p| DVec3::new(p.x, p.y, 0.1 * p.z + z));
        let two = together(&[plate(0.0), plate(0.3)]);
        let walls = of(&two, Side::Wall, 0.15);
        assert_eq!(walls.faces, 4);
        assert!((walls.least.unwrap() - 0.1).abs() < 1e-12);
        let gaps = of(&two, Side::Gap, 0.25);
        assert_eq!((gaps.faces, gaps.places.len()), (2, 2));
        assert!((gaps.least.unwrap() - 0.2).abs() < 1e-12);
        assert_eq!(of(&two, Side::Wall, 0.05), Thin::default());
        assert_eq!(of(&sphere(2), Side::Gap, 10.0), Thin::default());
    }
}
