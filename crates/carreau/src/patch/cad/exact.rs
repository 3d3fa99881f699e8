//! Curves and surfaces that are exactly the mesh: lines, polylines, planes, and surfaces of degree (1, 1).

use super::chain::Chains;
use super::fit::side;
use super::model::{Geometry, PieceSurface};
use super::piece::{Block, Piece, Source};
use super::scene::{Scene, longest_side};
use crate::brep::{Curve, Frame, Surface};
use crate::error::{Error, Result};
use crate::geometry::bspline::{BSplineCurve, BSplineSurface, Knots};
use crate::mesh::FaceId;
use glam::DVec3;

/// The exact geometry of all chains and pieces.
pub fn geometry(scene: &Scene, pieces: &[Piece], chains: &Chains) -> Result<Geometry> {
    let curves = chains.paths.iter().map(|path| curve(scene, path)).collect::<Result<_>>()?;
    let surface = |piece: &Piece| match piece.source {
        Source::Block(b) => block(scene, b),
        Source::Triangle(t) => Ok(triangle(scene, t)),
        Source::Flat(flat) => Ok(plane_of_flat(scene, piece, flat.normal)),
        Source::Polygon => Err(Error::Bug("a polygon has no surface of its own".into())),
    };
    let stops = vec![None; chains.paths.len()];
    Ok(Geometry { curves, stops, surfaces: pieces.iter().map(surface).collect::<Result<_>>()? })
}

/// The line from the first to the last vertex.
pub fn segment(scene: &Scene, path: &[u32]) -> Curve {
    Curve::segment(scene.point(path[0]), scene.point(path[path.len() - 1])).0
}

/// The polyline through mesh vertices.
pub fn curve(scene: &Scene, path: &[u32]) -> Result<Curve> {
    if path.len() == 2 {
        return Ok(segment(scene, path));
    }
    Ok(Curve::Spline(BSplineCurve::polyline(path.iter().map(|&v| scene.point(v)).collect())?))
}

/// The surface of degree (1, 1) with the mesh vertices at integer parameters, u along the columns.
pub fn block(scene: &Scene, block: Block) -> Result<PieceSurface> {
    let [m, n] = block.size;
    let node = |r, c| scene.point(block.vertex(scene.patches, r, c));
    let points = (0..=m).flat_map(|r| (0..=n).map(move |c| node(r, c))).collect();
    let surface = Surface::Spline(BSplineSurface::new(Knots::index(n), Knots::index(m), points)?);
    Ok(PieceSurface { surface, border: None, trimmed: false })
}

/// The same surface with parameters by length, so that it is as smooth as its cells.
pub fn block_by_length(scene: &Scene, block: Block) -> Result<PieceSurface> {
    if block.size == [1, 1] {
        return self::block(scene, block);
    }
    let [m, n] = block.size;
    let node = |r, c| scene.point(block.vertex(scene.patches, r, c));
    let points = (0..=m).flat_map(|r| (0..=n).map(move |c| node(r, c))).collect();
    let [u, v] = side::scale(scene, &block);
    let knots = |at: &[f64]| Knots::from_breaks(1, at, 1);
    let surface = Surface::Spline(BSplineSurface::new(knots(&u)?, knots(&v)?, points)?);
    Ok(PieceSurface { surface, border: Some([u.clone(), v.clone(), u, v]), trimmed: false })
}

/// The plane of a part of a flat region: at the mean height of its triangles, so that the volume below stays theirs where the
/// file's rounding has left vertices off any plane; an axis along the longest side of its border.
pub fn plane_of_flat(scene: &Scene, piece: &Piece, normal: DVec3) -> PieceSurface {
    let border = &piece.loops[0].vertices;
    let point = |k: usize| scene.point(border[k % border.len()]);
    let length = |k: usize| point(k).distance_squared(point(k + 1));
    let longest = (1..border.len()).fold(0, |best, k| if length(k) > length(best) { k } else { best });
    // Along the normal only, so that the point stays a vertex where all are exactly in the plane.
    let (mut volume, mut area) = (0.0, 0.0);
    for &[a, b, c, _] in &piece.cells {
        let [a, b, c] = [a, b, c].map(|v| scene.point(v) - point(longest));
        let seen = (b - a).cross(c - a).dot(normal);
        volume += seen * (a + b + c).dot(normal) / 3.0;
        area += seen;
    }
    let height = if area > 0.0 { volume / area } else { 0.0 };
    let axis = (point(longest + 1) - point(longest)).reject_from(normal);
    let axis = axis.try_normalize().unwrap_or(normal.any_orthonormal_vector());
    let frame = Frame { origin: point(longest) + height * normal, z: normal, x: axis };
    let surface = Surface::Plane { frame };
    PieceSurface { surface, border: None, trimmed: true }
}

/// The plane of a leftover triangle.
pub fn triangle(scene: &Scene, t: FaceId) -> PieceSurface {
    PieceSurface { surface: plane(scene.corners(t)), border: None, trimmed: true }
}

/// The plane through three points. The longest side lies in it exactly, also where the triangle is a sliver: the normal
/// is built from that side and the height on it.
fn plane(corners: [DVec3; 3]) -> Surface {
    let k = longest_side(corners);
    let [a, b, c] = [0, 1, 2].map(|j| corners[(k + j) % 3]);
    let axis = (b - a).normalize_or(DVec3::X);
    let height = (c - a) - axis * axis.dot(c - a);
    let across = height.try_normalize().unwrap_or_else(|| axis.any_orthonormal_vector());
    // Once more, for the rounding errors of a height that is small against the side.
    let across = (across - axis * axis.dot(across)).normalize_or(axis.any_orthonormal_vector());
    Surface::Plane { frame: Frame { origin: a, z: axis.cross(across).normalize_or(DVec3::Z), x: axis } }
}
