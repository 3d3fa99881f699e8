//! Directions and axes that pieces may be swept along or around: those of their triangles, and those of borders and neighbours, which
//! know them better.

use super::borders::circle;
use super::regions::{Map, area_vector};
use super::topology::Graph;
use super::tuning::{ALONG_ANGLE, COLUMN_DISTANCE, NAMED_DISTANCE};
use crate::brep::Curve;
use crate::geometry::normals::unit;
use crate::geometry::primitive::Primitive;
use crate::mesh::{NONE, Triangles};
use crate::numeric::eigen3::{Eigen3, outer};
use glam::{DMat3, DVec3};

/// A count: most axes that are tried for a region, because each costs a fit and the surest come first.
const MOST_AXES: usize = 8;
/// Sine of the angle between triangles and the direction of an extrusion: beyond 30° corners are at three places of the
/// profile and two heights, because triangles are wider then than they are tilted.
const MOST_TILT: f64 = 0.5;
/// A share of the largest eigenvalue: what is below has no inverse, because all normals are in a plane.
const LEAST_EIGENVALUE: f64 = 1e-9;

/// Directions that pieces may be extruded along: normals of planes beside them, and axes of what is round.
pub fn directions(map: &Map<'_>, pieces: &[u32], graph: &Graph) -> Vec<DVec3> {
    let own = |s: u32| pieces.contains(&s);
    let mut out: Vec<DVec3> = Vec::new();
    for chain in graph.chains.iter().filter(|c| own(c.sides[0]) != own(c.sides[1])) {
        let other = chain.sides.into_iter().find(|&s| !own(s) && s != NONE);
        let along = match other.and_then(|s| map.pieces[s as usize].primitive) {
            Some(Primitive::Plane { normal, .. }) => normal,
            Some(Primitive::Cylinder { axis, .. }) => axis,
            _ => continue,
        };
        let tilt = |&k: &u32| unit(area_vector(map.t, k)).dot(along).abs() < MOST_TILT;
        let upright = pieces.iter().flat_map(|&p| &map.pieces[p as usize].triangles).all(tilt);
        if upright && out.len() < MOST_AXES && out.iter().all(|o| o.cross(along).length() > NAMED_DISTANCE) {
            out.push(along);
        }
    }
    out
}

/// The direction that all triangles contain.
pub fn direction(t: Triangles<'_>, triangles: &[u32]) -> Option<DVec3> {
    let mut matrix = DMat3::ZERO;
    for &k in triangles {
        let n = area_vector(t, k);
        matrix += outer(n.normalize_or_zero()) * n.length();
    }
    let eigen = Eigen3::new(matrix);
    let one = eigen.values[0] <= ALONG_ANGLE * ALONG_ANGLE * eigen.values[2]
        && eigen.values[1] > ALONG_ANGLE * eigen.values[2];
    one.then_some(eigen.vectors[0])
}

/// Axes that pieces may be round about, the surest first: points and directions.
pub fn axes(map: &Map<'_>, pieces: &[u32], triangles: &[u32], graph: &Graph) -> Vec<(DVec3, DVec3)> {
    let mut out: Vec<(DVec3, DVec3)> = Vec::new();
    let diagonal = map.diagonal;
    let mut add = |axis: (DVec3, DVec3)| {
        let same = |o: &(DVec3, DVec3)| {
            let offset = axis.0 - o.0;
            axis.1.cross(o.1).length() < NAMED_DISTANCE
                && (offset - o.1 * offset.dot(o.1)).length() < NAMED_DISTANCE * diagonal
        };
        if !out.iter().any(same) && out.len() < MOST_AXES {
            out.push(axis);
        }
    };
    let own = |s: u32| pieces.contains(&s);
    for chain in graph.chains.iter().filter(|c| own(c.sides[0]) != own(c.sides[1])) {
        let other = chain.sides.into_iter().find(|&s| !own(s) && s != NONE);
        match other.and_then(|s| map.pieces[s as usize].primitive) {
            Some(Primitive::Cylinder { origin, axis, .. }) => add((origin, axis)),
            Some(Primitive::Cone { apex, axis, .. }) => add((apex, axis)),
            Some(Primitive::Torus { center, axis, .. }) => add((center, axis)),
            _ => {}
        }
        let polyline: Vec<DVec3> = chain.vertices.iter().map(|&v| map.t.points()[v as usize]).collect();
        let closed = chain.vertices[0] == chain.vertices[chain.vertices.len() - 1];
        if let Some(Curve::Circle { frame, .. }) =
            circle(&polyline, closed, COLUMN_DISTANCE * diagonal).map(|t| t.curve)
        {
            add((frame.origin, frame.z));
        }
    }
    if let Some(axis) = complex(map.t, triangles) {
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
    let inverse = |b: DVec3| shift.solve(b, LEAST_EIGENVALUE);
    let back = mixed.transpose();
    let solved = DMat3::from_cols(inverse(back.x_axis), inverse(back.y_axis), inverse(back.z_axis));
    let direction = Eigen3::new(turn - mixed * solved).vectors[0];
    let moment = -(solved * direction);
    let axis = (about + direction.cross(moment), direction);
    (axis.0.is_finite() && axis.1.is_finite()).then_some(axis)
}
