//! Junctions: the vertices where boundaries end, fitted again to the surfaces that meet there.
//!
//! A vertex of a mesh lies near the corner of the part; the corner is where the surfaces of the regions intersect. From the
//! vertex it is reached by Gauss–Newton steps of least length, so that along a direction that the surfaces leave free, as two
//! tangent ones do, nothing moves.

use super::boundaries::Boundary;
use super::regions::Region;
use super::surface::Surface;
use crate::geometry::primitive::Primitive;
use crate::mesh::VertexId;
use crate::numeric::eigen3::{Eigen3, outer};
use glam::{DMat3, DVec3};

/// A count: Newton steps, because convergence is quadratic but where surfaces touch.
const JUNCTION_STEPS: usize = 20;
/// A share of the steepest direction's eigenvalue: directions below it are free, because the surfaces differ by 1° only
/// across them.
const FREE_STEEPNESS: f64 = 1e-4;

/// Where boundaries end.
#[derive(Debug, Clone, PartialEq)]
pub struct Junction {
    /// The vertex of the mesh.
    pub vertex: VertexId,
    /// The regions around it, increasing.
    pub regions: Vec<u32>,
    /// The point near the vertex where their surfaces meet; the vertex itself where they do not meet nearby.
    pub position: DVec3,
    /// Largest distance of the position from one of the surfaces.
    pub distance: f64,
}

/// All junctions, by vertex.
pub fn junctions(surface: &Surface<'_>, label: &[u32], regions: &[Region], boundaries: &[Boundary]) -> Vec<Junction> {
    let t = surface.triangles;
    let mut ends = vec![false; t.points().len()];
    for b in boundaries.iter().filter(|b| !b.closed) {
        b.vertices.first().into_iter().chain(b.vertices.last()).for_each(|v| ends[v.index()] = true);
    }
    // Vertex, region, length of the edge that leaves the corner.
    let mut around: Vec<(u32, u32, f64)> = (0..3 * label.len() as u32)
        .filter(|&c| ends[t.vertex(c) as usize])
        .map(|c| (t.vertex(c), label[c as usize / 3], surface.edge_length(c)))
        .collect();
    around.sort_by_key(|&(v, l, _)| (v, l));
    let of_vertex = |corners: &[(u32, u32, f64)]| {
        let mut own: Vec<u32> = corners.iter().map(|c| c.1).collect();
        own.dedup();
        let primitives: Vec<Primitive> = own.iter().filter_map(|&l| regions[l as usize].primitive).collect();
        let room = corners.iter().map(|c| c.2).sum::<f64>() / corners.len() as f64;
        let vertex = t.points()[corners[0].0 as usize];
        let position = meeting_point(vertex, &primitives, room);
        Junction { vertex: VertexId(corners[0].0), regions: own, position, distance: farthest(position, &primitives) }
    };
    around.chunk_by(|a, b| a.0 == b.0).map(of_vertex).collect()
}

fn farthest(p: DVec3, primitives: &[Primitive]) -> f64 {
    primitives.iter().map(|s| s.distance(p).abs()).fold(0.0, f64::max)
}

/// The point nearest to a vertex that lies on all surfaces; the vertex where there is none nearer than `room`.
fn meeting_point(vertex: DVec3, primitives: &[Primitive], room: f64) -> DVec3 {
    let mut p = vertex;
    for _ in 0..JUNCTION_STEPS {
        let (mut matrix, mut rhs) = (DMat3::ZERO, DVec3::ZERO);
        for s in primitives {
            let n = s.normal(p);
            matrix += outer(n);
            rhs -= n * s.distance(p);
        }
        let eigen = Eigen3::new(matrix);
        let steepest = eigen.values.iter().copied().fold(0.0, f64::max);
        let along = |(&value, &axis): (&f64, &DVec3)| {
            if value > FREE_STEEPNESS * steepest { axis * (axis.dot(rhs) / value) } else { DVec3::ZERO }
        };
        p += eigen.values.iter().zip(&eigen.vectors).map(along).sum::<DVec3>();
    }
    let better = farthest(p, primitives) <= farthest(vertex, primitives) && p.distance(vertex) <= room;
    if better { p } else { vertex }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn corners_are_found_from_nearby(
            angle in 0.3f64..2.8,
            radius in 0.5f64..2.0,
            off in prop::array::uniform3(-0.05f64..0.05),
        ) {
            // A wall, a slope and a cylinder around z that both cut: the corner is on the circle, where the planes meet.
            let cylinder = Primitive::Cylinder { origin: DVec3::ZERO, axis: DVec3::Z, radius };
            let floor = Primitive::Plane { origin: DVec3::ZERO, normal: DVec3::Z };
            let wall = Primitive::Plane { origin: DVec3::ZERO, normal: DVec3::new(-angle.sin(), angle.cos(), 0.0) };
            let corner = DVec3::new(angle.cos(), angle.sin(), 0.0) * radius;
            let start = corner + DVec3::from(off);
            prop_assert!(meeting_point(start, &[cylinder, floor, wall], 1.0).distance(corner) < 1e-12);
            // Two surfaces leave the way along their intersection free.
            let p = meeting_point(start, &[floor, wall], 1.0);
            prop_assert!(farthest(p, &[floor, wall]) < 1e-12);
            prop_assert!((p - start).dot(corner.normalize()).abs() < 1e-12);
            // No farther than there is room.
            prop_assert_eq!(meeting_point(start, &[cylinder, floor, wall], 1e-9 * radius), start);
        }
    }
}
