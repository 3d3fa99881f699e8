//! Curves and surfaces that are exactly the mesh: lines, polylines, planes, and surfaces of degree (1, 1).

use super::chain::Chains;
use super::piece::{Block, Piece, Source};
use super::{Geometry, PieceSurface};
use crate::error::{Error, Result};
use crate::geometry::brep::{Curve, Surface};
use crate::geometry::bspline::{BSplineCurve, BSplineSurface, Knots};
use crate::mesh::SurfaceMesh;
use crate::patch::Patch;
use glam::DVec3;

/// The exact geometry of all chains and pieces.
pub fn geometry(mesh: &SurfaceMesh, patches: &[Patch], pieces: &[Piece], chains: &Chains) -> Result<Geometry> {
    let curves = chains.paths.iter().map(|path| curve(mesh, path)).collect::<Result<_>>()?;
    let surface = |piece: &Piece| match piece.source {
        Source::Block(b) => block(mesh, patches, b),
        Source::Triangle(t) => {
            let face = mesh.face(t);
            let surface = plane([0, 1, 2].map(|k| mesh.points()[face[k] as usize]));
            Ok(PieceSurface { surface, scale: None, trimmed: true })
        }
        Source::Polygon(_) => Err(Error::Bug("a polygon has no surface of its own".into())),
    };
    Ok(Geometry { curves, surfaces: pieces.iter().map(surface).collect::<Result<_>>()? })
}

/// The polyline through mesh vertices.
pub fn curve(mesh: &SurfaceMesh, path: &[u32]) -> Result<Curve> {
    if path.len() == 2 {
        return Ok(Curve::Line);
    }
    let points = path.iter().map(|&v| mesh.points()[v as usize]).collect();
    Ok(Curve::Spline(BSplineCurve::polyline(points)?))
}

/// The surface of degree (1, 1) with the mesh vertices at integer parameters, u along the columns.
pub fn block(mesh: &SurfaceMesh, patches: &[Patch], block: Block) -> Result<PieceSurface> {
    let [m, n] = block.size;
    let node = |r, c| mesh.points()[block.vertex(patches, r, c) as usize];
    let points = (0..=m).flat_map(|r| (0..=n).map(move |c| node(r, c))).collect();
    let surface = Surface::Spline(BSplineSurface::new(Knots::index(n), Knots::index(m), points)?);
    Ok(PieceSurface { surface, scale: None, trimmed: false })
}

/// The plane through three points. The longest side lies in it exactly, also where the triangle is a sliver: the normal
/// is built from that side and the height on it.
pub fn plane(corners: [DVec3; 3]) -> Surface {
    let length = |k: usize| corners[k].distance_squared(corners[(k + 1) % 3]);
    let k = (1..3).fold(0, |best, k| if length(k) > length(best) { k } else { best });
    let [a, b, c] = [0, 1, 2].map(|j| corners[(k + j) % 3]);
    let axis = (b - a).normalize_or(DVec3::X);
    let height = (c - a) - axis * axis.dot(c - a);
    let across = height.try_normalize().unwrap_or_else(|| axis.any_orthonormal_vector());
    // Once more, for the rounding errors of a height that is small against the side.
    let across = (across - axis * axis.dot(across)).normalize_or(axis.any_orthonormal_vector());
    Surface::Plane { origin: a, normal: axis.cross(across).normalize_or(DVec3::Z), axis }
}
