//! Closes open ends by lids: a fan of triangles about the middle of every border loop.

use crate::error::Result;
use crate::mesh::{CornerId, SurfaceMesh, UnitScale, triangle_area_vector};
use glam::DVec3;

/// A border is far from a plane when it leaves its plane by more than this share of its radius.
pub const BENT: f64 = 0.35;

/// A surface without open ends.
#[derive(Debug, Clone)]
pub struct Closed {
    /// The surface; the triangles of the lids follow those of before, their middles the vertices.
    pub mesh: SurfaceMesh,
    /// The lids, in the order of their first border edges.
    pub lids: Vec<Lid>,
    /// Number of triangles that are no lids.
    pub wall: usize,
}

/// A lid.
#[derive(Debug, Clone)]
pub struct Lid {
    /// Its middle.
    pub centre: DVec3,
    /// Unit normal, outward.
    pub normal: DVec3,
    /// Mean distance of the border from the middle.
    pub radius: f64,
    /// Largest distance of the border from the plane, in radii.
    pub flatness: f64,
    /// The edges around it.
    pub border: Vec<[u32; 2]>,
    /// Its triangles.
    pub triangles: std::ops::Range<u32>,
    /// Whether it closes an open end; else it is a flat piece of the surface itself.
    pub is_open: bool,
}

impl Closed {
    /// The same in another scale.
    pub(super) fn moved(mut self, scale: UnitScale) -> Closed {
        for lid in &mut self.lids {
            (lid.centre, lid.radius) = (scale.point(lid.centre), scale.length(lid.radius));
        }
        Closed { mesh: scale.moved(self.mesh, &[]), ..self }
    }
}

/// Closes every border loop of a manifold surface of triangles.
///
/// # Errors
/// [`crate::Error::Input`] where there would be more elements than numbers for them.
pub fn closed(mesh: &SurfaceMesh) -> Result<Closed> {
    let mut points = mesh.points().to_vec();
    let mut triangles = mesh.faces().fan().0;
    let wall = triangles.len();
    let mut lids = Vec::new();
    for border in loops(mesh) {
        let first = triangles.len() as u32;
        let at: Vec<DVec3> = border.iter().map(|&v| mesh.points()[v as usize]).collect();
        // Weighted by length, so that crowded vertices do not draw the middle to their side.
        let (mut centre, mut length) = (DVec3::ZERO, 0.0);
        for (k, p) in at.iter().enumerate() {
            let q = at[(k + 1) % at.len()];
            centre += 0.5 * p.distance(q) * (*p + q);
            length += p.distance(q);
        }
        centre = if length > 0.0 { centre / length } else { at[0] };
        let middle = points.len() as u32;
        points.push(centre);
        let mut area = DVec3::ZERO;
        for (k, &v) in border.iter().enumerate() {
            // Against the sense of the surface's own half-edge.
            let next = (k + 1) % border.len();
            triangles.push([border[next], v, middle]);
            area += triangle_area_vector(at[next], at[k], centre);
        }
        let normal = area.normalize_or_zero();
        let radius = at.iter().map(|p| p.distance(centre)).sum::<f64>() / at.len() as f64;
        let off = at.iter().map(|p| (*p - centre).dot(normal).abs()).fold(0.0, f64::max);
        let flatness = if radius > 0.0 { off / radius } else { 0.0 };
        let sides = border.iter().enumerate().map(|(k, &v)| [border[(k + 1) % border.len()], v]).collect();
        let triangles = first..triangles.len() as u32;
        lids.push(Lid { centre, normal, radius, flatness, border: sides, triangles, is_open: true });
    }
    Ok(Closed { mesh: SurfaceMesh::from_triangles(points, &triangles)?, lids, wall })
}

/// The border loops of a manifold mesh, each in the sense of its faces.
fn loops(mesh: &SurfaceMesh) -> Vec<Vec<u32>> {
    let borders: Vec<CornerId> =
        (0..mesh.corner_count()).map(CornerId::new).filter(|&c| mesh.opposite(c).is_none()).collect();
    let mut leaving = vec![u32::MAX; mesh.vertex_count()];
    borders.iter().for_each(|&c| leaving[mesh.vertex(c).index()] = mesh.vertex(mesh.next(c)).0);
    let mut loops = Vec::new();
    for c in borders {
        let mut border = Vec::new();
        let mut v = mesh.vertex(c).0;
        while leaving[v as usize] != u32::MAX {
            border.push(v);
            v = std::mem::replace(&mut leaving[v as usize], u32::MAX);
        }
        if !border.is_empty() {
            loops.push(border);
        }
    }
    loops
}
