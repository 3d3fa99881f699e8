//! Curves and surfaces that are exactly the mesh: lines, polylines, planes, and surfaces of degree (1, 1).

use super::chain::Chains;
use super::piece::{Block, Piece, Source};
use super::scene::{Scene, longest_side};
use super::{Geometry, PieceSurface};
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
        Source::Polygon => Err(Error::Bug("a polygon has no surface of its own".into())),
    };
    let stops = vec![None; chains.paths.len()];
    Ok(Geometry { curves, stops, surfaces: pieces.iter().map(surface).collect::<Result<_>>()? })
}

/// The polyline through mesh vertices.
pub fn curve(scene: &Scene, path: &[u32]) -> Result<Curve> {
    if path.len() == 2 {
        return Ok(Curve::segment(scene.point(path[0]), scene.point(path[1])).0);
    }
    Ok(Curve::Spline(BSplineCurve::polyline(path.iter().map(|&v| scene.point(v)).collect())?))
}

/// The surface of degree (1, 1) with the mesh vertices at integer parameters, u along the columns.
pub fn block(scene: &Scene, block: Block) -> Result<PieceSurface> {
    let [m, n] = block.size;
    let node = |r, c| scene.point(block.vertex(scene.patches, r, c));
    let points = (0..=m).flat_map(|r| (0..=n).map(move |c| node(r, c))).collect();
    let surface = Surface::Spline(BSplineSurface::new(Knots::index(n), Knots::index(m), points)?);
    Ok(PieceSurface { surface, scale: None, trimmed: false })
}

/// The plane of a leftover triangle.
pub fn triangle(scene: &Scene, t: FaceId) -> PieceSurface {
    PieceSurface { surface: plane(scene.corners(t)), scale: None, trimmed: true }
}

/// The plane of a block whose vertices are no farther from it than `flatness`.
pub fn plane_of_block(scene: &Scene, block: Block, flatness: f64) -> Option<Surface> {
    let cells = || block.cells(scene.patches).map(|cell| cell.map(|v| scene.point(v)));
    let vector: DVec3 = cells().map(|[a, b, c, d]| (c - a).cross(d - b)).sum();
    let normal = vector.try_normalize()?;
    let [origin, end] = [0, block.size[1]].map(|c| scene.point(block.vertex(scene.patches, 0, c)));
    let axis = (end - origin).reject_from(normal).try_normalize().unwrap_or(normal.any_orthonormal_vector());
    let flat = cells().flatten().all(|p| (p - origin).dot(normal).abs() <= flatness);
    flat.then_some(Surface::Plane { frame: Frame { origin, z: normal, x: axis } })
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
