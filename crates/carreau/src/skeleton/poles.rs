//! Poles: the centre of the largest ball inside that touches the surface at a vertex.
//!
//! The shrinking ball (Ma, Bae, Choi, "3D medial axis point approximation using nearest neighbors and the normal field",
//! The Visual Computer 2012): a ball that touches at p and is too large has a vertex q nearest to its centre; the ball
//! that touches at p and passes through q is smaller, and so on until no vertex is inside.
//!
//! ```text
//!      p ───n         r = |p − q|² / (2 n·(p − q))
//!     ╱│╲
//!    ╱ c ╲·q
//! ```
//!
//! A ball that is stopped by a vertex next door is stopped by noise: when p and q are seen from the new centre under a
//! small angle, the ball of before is kept. A ball is small enough when no vertex is much nearer to its centre than p: in a
//! tube whole rings of vertices are about as near, and which of them is the nearest takes the longer to tell the more there
//! are. So the balls of a surface of very many vertices are stopped by some of them only, spread as all are: what lies
//! between is nearer to a ball by no more than the sagitta of an edge between two of these.

use super::tuning::MANY;
use crate::context::Context;
use crate::error::Result;
use crate::geometry::normals::{face_normals, vertex_normals};
use crate::geometry::search_tree::TriangleTree;
use crate::mesh::SurfaceMesh;
use glam::DVec3;
use rayon::prelude::*;

/// p and q seen under less than this angle from the centre: noise.
const LEAST_ANGLE: f64 = 0.55;
/// Most times that a ball shrinks.
const SHRINKINGS: usize = 30;
/// No vertex is nearer to the centre of a ball than its radius less this share.
const SLACK: f64 = 1e-4;

/// The pole of every vertex.
pub fn poles(mesh: &SurfaceMesh, context: &Context) -> Result<Vec<DVec3>> {
    let points = mesh.points();
    let normals = vertex_normals(mesh, &face_normals(mesh));
    let tree = stops(points, &normals);
    let start = 0.5 * mesh.diagonal();
    context.check()?;
    Ok(points.par_iter().zip(&normals).map(|(&p, &n)| shrink(p, n, start, &tree)).collect())
}

/// The vertices that stop balls.
fn stops(points: &[DVec3], normals: &[DVec3]) -> TriangleTree {
    // Points are triangles of three equal corners.
    let vertices: Vec<[u32; 3]> = (0..points.len() as u32).map(|v| [v; 3]).collect();
    let tree = TriangleTree::new(points, &vertices);
    if points.len() <= MANY {
        return tree.with_slabs(normals);
    }
    let some: Vec<u32> = tree.ids().step_by(points.len().div_ceil(MANY)).collect();
    let normals: Vec<DVec3> = some.iter().map(|&v| normals[v as usize]).collect();
    let vertices: Vec<[u32; 3]> = some.iter().map(|&v| [v; 3]).collect();
    TriangleTree::new(points, &vertices).with_slabs(&normals)
}

fn shrink(p: DVec3, n: DVec3, start: f64, tree: &TriangleTree) -> DVec3 {
    let mut r = start;
    for round in 0..SHRINKINGS {
        let centre = p - n * r;
        let Some(near) = tree.closest_within(centre, r * (1.0 - SLACK)) else { break };
        let to = p - near.point;
        let depth = 2.0 * n.dot(to);
        if !(depth > 0.0) {
            break;
        }
        let smaller = to.length_squared() / depth;
        let inner = p - n * smaller;
        let angle = (p - inner).angle_between(near.point - inner);
        if !(smaller < r) || (round > 0 && angle < LEAST_ANGLE) {
            break;
        }
        r = smaller;
    }
    p - n * r
}
