//! Closes open ends by lids: a fan of triangles about the middle of every border loop.

use crate::error::Result;
use crate::mesh::{CornerId, SurfaceMesh, UnitScale, triangle_area_vector};
use glam::DVec3;

/// A border is far from a plane when it leaves its plane by more than this share of its radius.
pub const BENT: f64 = 0.35;

/// A lid closes an end of a branch where it is at least this wide, in the branch's radii: a hole in a wall is narrower, and a
/// vessel is hardly cut where it is half as wide as a radius before.
pub const LEAST_WIDTH: f64 = 0.5;
/// The axis of a branch that ends in a lid meets the lid's plane within this many of the lid's radii of its middle.
const AIMED: f64 = 1.25;
/// Least cosine between the axis and the lid's normal: ends may be cut at a slant, but a side is none.
const LEAST_FACING: f64 = 0.3;

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

impl Lid {
    /// Whether a branch of this radius that heads somewhere from a place ends in the lid: it is as wide as the branch, or nearly, and
    /// the axis of the branch goes through it.
    ///
    /// ```text
    ///          hole
    ///   ───────╴ ╶──────╮
    ///      •───→        │ lid      the branch ends in the lid, and beside the hole
    ///   ────────────────╯
    /// ```
    pub(crate) fn ends(&self, from: DVec3, heading: DVec3, radius: f64) -> bool {
        let facing = self.normal.dot(heading);
        if facing < LEAST_FACING || self.radius < LEAST_WIDTH * radius {
            return false;
        }
        let meets = from + heading * ((self.centre - from).dot(self.normal) / facing);
        meets.distance(self.centre) < AIMED * self.radius
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    /// The open end of a tube along x, a narrow hole in its round tip, a wide one in its wall.
    #[test]
    fn a_branch_ends_in_an_open_end_and_in_no_hole() {
        let lid = |centre: DVec3, normal: DVec3, radius: f64| Lid {
            centre,
            normal,
            radius,
            flatness: 0.0,
            border: Vec::new(),
            triangles: 0..0,
            is_open: true,
        };
        let ends = |lid: Lid| lid.ends(DVec3::ZERO, DVec3::X, 1.0);
        assert!(ends(lid(DVec3::X, DVec3::X, 0.9)));
        assert!(ends(lid(DVec3::new(2.0, 0.5, 0.0), DVec3::new(1.0, 1.0, 0.0).normalize(), 0.8)));
        assert!(!ends(lid(DVec3::X, DVec3::X, 0.3)));
        assert!(!ends(lid(DVec3::Y, DVec3::Y, 0.7)));
        assert!(!ends(lid(DVec3::new(-0.5, 0.9, 0.0), DVec3::new(0.5, 0.87, 0.0), 0.6)));
    }
}
