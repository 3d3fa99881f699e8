//! Regions that a curve sweeps along a straight line or around an axis: extrusions and surfaces of revolution.
//!
//! All triangles of an extruded region contain its direction. The normals of a surface of revolution meet its axis: they belong to
//! a linear complex (Pottmann and Randrup, *Rotational and helical surface approximation for reverse engineering*, Computing 60,
//! 1998). Borders and neighbours know the axis better: a border around it is a circle.
//!
//! ```text
//!           axis                 the profile is in the half plane of the frame's x and z;
//!      z ↑   │   ╲  n            a normal n at p meets the axis c through x:
//!            │────●                  n · (x × c) + (p × n) · c = 0
//!            │   ╱ p
//! ```

use super::borders::circle;
use super::profile::profile;
use super::regions::{Map, Piece, Rung, area_vector, looks_along, mean_square, vertices};
use super::topology::Graph;
use super::tuning::{ALONG, COLUMN, NAMED};
use crate::brep::{Curve, Frame, Surface};
use crate::error::Result;
use crate::geometry::primitive::Primitive;
use crate::mesh::{NONE, Triangles};
use crate::numeric::eigen3::{Eigen3, outer};
use glam::{DMat3, DVec3};

/// Least number of places of an extruded profile: fewer are a plane or a wedge.
const LEAST: usize = 4;
/// The same of a revolved one: two are a cone.
const LEAST_REVOLVED: usize = 3;
/// Most axes that are tried for a region.
const MOST_AXES: usize = 8;
/// Of its largest eigenvalue: what is below has no inverse, because all normals are in a plane.
const SINGULAR: f64 = 1e-9;

/// Gives swept surfaces to the pieces without a surface that lie on some; the others stay in the list.
pub fn sweep(map: &mut Map<'_>) -> Result<()> {
    if map.free.is_empty() {
        return Ok(());
    }
    let graph = Graph::of(map.t, &map.label, map.pieces.len(), &[])?;
    let mut chains_of: Vec<Vec<u32>> = vec![Vec::new(); map.pieces.len()];
    for (chain, k) in graph.chains.iter().zip(0u32..) {
        chain.sides.iter().filter(|&&s| s != NONE).for_each(|&s| chains_of[s as usize].push(k));
    }
    let free = std::mem::take(&mut map.free);
    let mut left = Vec::new();
    for p in free {
        let triangles = &map.pieces[p as usize].triangles;
        let surface = extrusion(map.t, triangles, map.diagonal)
            .or_else(|| revolution(map, p, &axes(map, p, &graph, &chains_of[p as usize])));
        if let Some(surface) = surface {
            let piece = &mut map.pieces[p as usize];
            *piece = Piece { surface, rung: Rung::Swept, ..piece.clone() };
            piece.same_sense = looks_along(map.t, piece);
            piece.square = mean_square(map.t, &piece.triangles, |q| piece.surface.distance(q));
            let far = |q: &DVec3| piece.surface.distance(*q);
            piece.max = vertices(map.t, &piece.triangles).iter().map(far).fold(0.0, f64::max);
        } else {
            left.push(p);
        }
    }
    map.free = left;
    Ok(())
}

fn extrusion(t: Triangles<'_>, triangles: &[u32], diagonal: f64) -> Option<Surface> {
    let mut matrix = DMat3::ZERO;
    for &k in triangles {
        let n = area_vector(t, k);
        matrix += outer(n.normalize_or_zero()) * n.length();
    }
    let eigen = Eigen3::new(matrix);
    if !(eigen.values[0] <= ALONG * ALONG * eigen.values[2]) || eigen.values[1] <= ALONG * eigen.values[2] {
        return None;
    }
    let direction = eigen.vectors[0];
    let origin = t.point(3 * triangles[0]);
    let flat = |p: DVec3| p - direction * (p - origin).dot(direction);
    let across = direction.any_orthonormal_vector();
    let profile = profile(t, triangles, flat, across, COLUMN * diagonal, LEAST)?;
    Some(Surface::Extrusion { profile, direction })
}

/// Axes that a piece may be round about, the surest first: points and directions.
fn axes(map: &Map<'_>, p: u32, graph: &Graph, chains: &[u32]) -> Vec<(DVec3, DVec3)> {
    let mut out: Vec<(DVec3, DVec3)> = Vec::new();
    let diagonal = map.diagonal;
    let mut add = |axis: (DVec3, DVec3)| {
        let same = |o: &(DVec3, DVec3)| {
            let offset = axis.0 - o.0;
            axis.1.cross(o.1).length() < NAMED && (offset - o.1 * offset.dot(o.1)).length() < NAMED * diagonal
        };
        if !out.iter().any(same) && out.len() < MOST_AXES {
            out.push(axis);
        }
    };
    for &k in chains {
        let chain = &graph.chains[k as usize];
        let other = chain.sides.into_iter().find(|&s| s != p && s != NONE);
        match other.and_then(|s| map.pieces[s as usize].primitive) {
            Some(Primitive::Cylinder { origin, axis, .. }) => add((origin, axis)),
            Some(Primitive::Cone { apex, axis, .. }) => add((apex, axis)),
            Some(Primitive::Torus { center, axis, .. }) => add((center, axis)),
            _ => {}
        }
        let polyline: Vec<DVec3> = chain.vertices.iter().map(|&v| map.t.points()[v as usize]).collect();
        let closed = chain.vertices[0] == chain.vertices[chain.vertices.len() - 1];
        if let Some(Curve::Circle { frame, .. }) = circle(&polyline, closed, COLUMN * diagonal).map(|t| t.curve) {
            add((frame.origin, frame.z));
        }
    }
    if let Some(axis) = complex(map.t, &map.pieces[p as usize].triangles) {
        add(axis);
    }
    out
}

/// The axis that the normals of triangles meet, in the sense of least squares.
fn complex(t: Triangles<'_>, triangles: &[u32]) -> Option<(DVec3, DVec3)> {
    let about = t.point(3 * triangles[0]);
    let (mut turn, mut mixed, mut shift) = (DMat3::ZERO, DMat3::ZERO, DMat3::ZERO);
    for &k in triangles {
        let n = area_vector(t, k);
        let weight = n.length();
        let n = n.normalize_or_zero();
        let p = t.triangle(k).map(|v| t.points()[v as usize]).iter().sum::<DVec3>() / 3.0 - about;
        let m = p.cross(n);
        turn += outer(m) * weight;
        shift += outer(n) * weight;
        mixed += DMat3::from_cols(m * n.x, m * n.y, m * n.z) * weight;
    }
    // The moment is that of least residual for a direction: what is left is a quadratic form of the direction.
    let shift = Eigen3::new(shift);
    let inverse = |b: DVec3| shift.solve(b, SINGULAR);
    let back = mixed.transpose();
    let solved = DMat3::from_cols(inverse(back.x_axis), inverse(back.y_axis), inverse(back.z_axis));
    let direction = Eigen3::new(turn - mixed * solved).vectors[0];
    let moment = -(solved * direction);
    let axis = (about + direction.cross(moment), direction);
    (axis.0.is_finite() && axis.1.is_finite()).then_some(axis)
}

fn revolution(map: &Map<'_>, p: u32, axes: &[(DVec3, DVec3)]) -> Option<Surface> {
    let (t, triangles) = (map.t, &map.pieces[p as usize].triangles);
    let near = COLUMN * map.diagonal;
    axes.iter().find_map(|&(origin, axis)| {
        let frame = Frame::along(origin, axis);
        let flat = |q: DVec3| {
            let at = frame.profile(q);
            // On the axis, to the bit.
            let x = if at.x < near { 0.0 } else { at.x };
            frame.origin + frame.x * x + frame.z * at.y
        };
        let profile = profile(t, triangles, flat, frame.z + 0.5 * frame.x, near, LEAST_REVOLVED)?;
        Some(Surface::Revolution { profile, frame })
    })
}
