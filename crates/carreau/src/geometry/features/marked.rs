//! Features as marks on half-edges, and the angles that make them.

use super::dropped::DroppedStrand;
use super::noise::Noise;
use crate::geometry::normals::angle_between;
use crate::mesh::{CornerId, SurfaceMesh, VertexId, area_vector};
use glam::DVec3;

/// Edge length of squares, given their number, that cover a surface.
pub fn length_of_squares(mesh: &SurfaceMesh, count: f64) -> f64 {
    let area: f64 = mesh.faces().iter().map(|face| area_vector(mesh.points(), face).length()).sum();
    (area / count.max(1.0)).sqrt()
}

/// The feature edges of a mesh.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Features {
    /// For every corner whether the half-edge that leaves it lies on a feature; the half-edges of an edge agree.
    pub corners: Vec<bool>,
    /// Listed and tagged edges that the mesh does not have.
    pub missing: Vec<[VertexId; 2]>,
    /// Edges above the angle that are none, as the corner that the first half-edge leaves from.
    pub dropped: Vec<CornerId>,
    /// The longest strand of these.
    pub longest_dropped: Option<DroppedStrand>,
    /// How noisy the edges above the angle are; nothing where all of them count.
    pub noise: Noise,
}

impl Features {
    /// Whether the half-edge that leaves this corner lies on a feature.
    #[inline]
    pub fn contains(&self, c: CornerId) -> bool {
        self.corners[c.index()]
    }

    /// Every feature edge once, as the corner that its first half-edge leaves from, in order.
    pub fn edges<'a>(&'a self, mesh: &'a SurfaceMesh) -> impl Iterator<Item = CornerId> + 'a {
        let first = |group: crate::mesh::EdgeGroup| group.corners().next();
        let half_edges = mesh.half_edges();
        let firsts: Vec<u32> = half_edges.groups().filter_map(first).collect();
        firsts.into_iter().map(CornerId).filter(|&c| self.contains(c))
    }
}

/// The normals on both sides of a half-edge, in the order of the corners, so that both half-edges get the same angle.
pub fn sides(mesh: &SurfaceMesh, normals: &[DVec3], c: CornerId, o: CornerId) -> [DVec3; 2] {
    [c.min(o), c.max(o)].map(|c| normals[mesh.face_of(c).index()])
}

/// Signed angle between the normals on both sides of a regular inner edge, in radians: 0 where the surface is flat,
/// positive where it is convex, negative where it is concave. `None` on borders and irregular edges.
///
/// The angle through the material, which CAD calls dihedral, is π minus this.
pub fn dihedral_turn(mesh: &SurfaceMesh, face_normals: &[DVec3], c: CornerId) -> Option<f64> {
    let o = mesh.opposite(c)?;
    let along = mesh.point(mesh.vertex(mesh.next(c))) - mesh.point(mesh.vertex(c));
    let [own, other] = [c, o].map(|c| face_normals[mesh.face_of(c).index()]);
    let [a, b] = sides(mesh, face_normals, c, o);
    let angle = angle_between(a, b);
    Some(if own.cross(other).dot(along) < 0.0 { -angle } else { angle })
}
