//! The surface cut along its features: what one-sided measures at a vertex are taken on.
//!
//! ```text
//!      ╲   1   ╱        Around a vertex on a crease (double lines) each part between creases is a sector. Sectors are the
//!       ╲     ╱         vertices of the surface cut along all creases, borders and irregular edges: a smooth vertex
//!   ═════•═════         is its own sector, with its own id; the further sectors of other vertices follow after the last
//!       ╱     ╲         vertex.
//!      ╱   2   ╲
//! ```
//!
//! The normal of a sector weights the area vectors A of its faces, with edges a and b at the vertex, by 1/(|a|² |b|²)
//! (Max, "Weights for Computing Vertex Normals from Facet Normals", Journal of Graphics Tools 1999): exact where the
//! vertices lie on a sphere, however the faces are cut. On irregular meshes of tori and cylinders the curvatures that
//! follow from it are three times as exact as with weights by angle, six times as with weights by area.

use super::per_vertex::map;
use crate::context::Context;
use crate::error::Result;
use crate::geometry::normals::unit;
use crate::mesh::{NONE, Triangles, triangle_area_vector};
use glam::DVec3;

/// Of two edges of a face, the shorter counts as at least this share of the longer: the weight of a needle would grow
/// without bound, and its normal is mostly rounding.
const SHORTEST: f64 = 1e-4;

/// What the measures need of a triangle.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Face {
    /// As long as the area is large.
    pub area_vector: DVec3,
    pub area: f64,
    /// What the area vector counts for in the normal at each corner.
    pub weights: [f64; 3],
}

/// What the faces of a sector have together.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Fan {
    /// Unit normal; zero without a face of positive area.
    pub normal: DVec3,
    /// Area of the faces.
    pub area: f64,
}

/// A triangle mesh cut along its features.
pub(super) struct Sectors<'a> {
    /// The mesh.
    pub triangles: Triangles<'a>,
    /// Sector of every corner.
    pub of_corner: Vec<u32>,
    /// The half-edge on the other side of every half-edge, [`NONE`] where there is no way across.
    pub across: Vec<u32>,
    /// One per triangle.
    pub faces: Vec<Face>,
    /// One per sector.
    pub fans: Vec<Fan>,
    /// (vertex, sector) of all sectors that are not their vertex, sorted.
    further: Vec<(u32, u32)>,
    /// The corners of sector `s` are `corners[start[s]..start[s + 1]]`, ascending.
    start: Vec<u32>,
    corners: Vec<u32>,
}

impl<'a> Sectors<'a> {
    /// Cuts a mesh; `feature[c]` tells whether the half-edge that leaves corner `c` lies on a feature.
    pub fn new(triangles: Triangles<'a>, feature: &[bool], context: &Context) -> Result<Self> {
        Self::around(triangles, feature, |_| true, context)
    }

    /// [`Sectors::new`] with faces and fans around wanted vertices only; others are empty.
    pub fn around(
        triangles: Triangles<'a>,
        feature: &[bool],
        wanted: impl Fn(u32) -> bool + Send + Sync,
        context: &Context,
    ) -> Result<Self> {
        let open = |(&closed, c)| if closed { NONE } else { triangles.opposite(c) };
        let across: Vec<u32> = feature.iter().zip(0u32..).map(open).collect();
        let (of_corner, further, count) = cut(triangles, &across, context)?;
        let (start, corners) = grouped(&of_corner, count);
        let faces = map(triangles.len(), context, |t| {
            if triangles.triangle(t).into_iter().any(&wanted) { face(&triangles, t) } else { Face::default() }
        })?;
        let fans = Vec::new();
        let mut sectors = Sectors { triangles, of_corner, across, faces, fans, further, start, corners };
        let vertices = triangles.points().len() as u32;
        let fan = |s: u32| if s >= vertices || wanted(s) { sectors.fan(s) } else { Fan::default() };
        sectors.fans = map(count, context, fan)?;
        Ok(sectors)
    }

    /// The corners of a sector, ascending.
    #[inline]
    pub fn corners(&self, sector: u32) -> &[u32] {
        let s = sector as usize;
        &self.corners[self.start[s] as usize..self.start[s + 1] as usize]
    }

    /// The sectors of a vertex other than the one with its own id, in order.
    #[inline]
    pub fn further(&self, vertex: u32) -> &[(u32, u32)] {
        if self.further.is_empty() {
            return &[];
        }
        let from = self.further.partition_point(|&(v, _)| v < vertex);
        let more = self.further[from..].iter().take_while(|&&(v, _)| v == vertex).count();
        &self.further[from..from + more]
    }

    #[inline]
    fn fan(&self, sector: u32) -> Fan {
        let (mut normal, mut area) = (DVec3::ZERO, 0.0);
        for &c in self.corners(sector) {
            let face = &self.faces[c as usize / 3];
            normal += face.weights[c as usize % 3] * face.area_vector;
            area += face.area;
        }
        Fan { normal: unit(normal), area }
    }
}

#[inline]
fn face(triangles: &Triangles<'_>, t: u32) -> Face {
    let [i, j, k] = triangles.triangle(t);
    let points = triangles.points();
    let (x, y, z) = (points[i as usize], points[j as usize], points[k as usize]);
    let area_vector = triangle_area_vector(x, y, z);
    let (a, b, c) = (y.distance_squared(z), z.distance_squared(x), x.distance_squared(y));
    let weight = |p: f64, q: f64| {
        let least = SHORTEST * SHORTEST * p.max(q);
        let weight = 1.0 / (p.max(least) * q.max(least));
        if weight.is_finite() { weight } else { 0.0 }
    };
    Face { area_vector, area: area_vector.length(), weights: [weight(b, c), weight(c, a), weight(a, b)] }
}

/// Sector of every corner, the (vertex, sector) pairs of sectors that are not their vertex, and the number of sectors.
type Cut = (Vec<u32>, Vec<(u32, u32)>, usize);

/// Numbers the sectors: of each vertex the one with the smallest corner gets the vertex's id, others new ones.
fn cut(triangles: Triangles<'_>, across: &[u32], context: &Context) -> Result<Cut> {
    let vertices = triangles.points().len();
    let mut of_corner = vec![NONE; 3 * triangles.len()];
    let mut taken = vec![false; vertices];
    let mut further = Vec::new();
    for c in 0..3 * triangles.len() as u32 {
        context.check_every(c as usize)?;
        if of_corner[c as usize] != NONE {
            continue;
        }
        let v = triangles.vertex(c);
        let sector = if taken[v as usize] { (vertices + further.len()) as u32 } else { v };
        if taken[v as usize] {
            further.push((v, sector));
        }
        taken[v as usize] = true;
        // Clockwise across the half-edges that leave the vertex until a barrier, then counter-clockwise across those
        // that enter it; once around, the second walk has nothing left to do.
        let mut at = c;
        while at != NONE && of_corner[at as usize] == NONE {
            of_corner[at as usize] = sector;
            let other = across[at as usize];
            at = if other == NONE { NONE } else { triangles.next(other) };
        }
        let mut at = across[triangles.previous(c) as usize];
        while at != NONE && of_corner[at as usize] == NONE {
            of_corner[at as usize] = sector;
            at = across[triangles.previous(at) as usize];
        }
    }
    let count = vertices + further.len();
    further.sort_unstable();
    Ok((of_corner, further, count))
}

/// The corners of every sector side by side, ascending, and where each begins.
fn grouped(of_corner: &[u32], count: usize) -> (Vec<u32>, Vec<u32>) {
    let mut start = vec![0u32; count + 1];
    of_corner.iter().for_each(|&s| start[s as usize + 1] += 1);
    for s in 1..start.len() {
        start[s] += start[s - 1];
    }
    let mut fill = start.clone();
    let mut corners = vec![0u32; of_corner.len()];
    for (&s, c) in of_corner.iter().zip(0u32..) {
        corners[fill[s as usize] as usize] = c;
        fill[s as usize] += 1;
    }
    (start, corners)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::features::{FeatureOptions, feature_edges};
    use crate::geometry::normals::{corner_normals, face_normals};
    use crate::mesh::test_models::*;
    use crate::mesh::{CornerId, SurfaceMesh};

    fn features(mesh: &SurfaceMesh) -> Vec<bool> {
        feature_edges(mesh, &FeatureOptions { angle_deg: Some(35.0), ..FeatureOptions::default() }).unwrap().corners
    }

    #[test]
    fn corners_share_a_sector_where_they_share_a_normal() {
        let models = [
            cube(DVec3::ZERO, 1.0).triangulated().unwrap(),
            cubes_sharing_an_edge().triangulated().unwrap(),
            cubes_sharing_a_vertex().triangulated().unwrap(),
            grid(4),
            strip(9, 1).triangulated().unwrap(),
            sphere(2),
        ];
        for mesh in models {
            let feature = features(&mesh);
            let sectors = Sectors::new(Triangles::of(&mesh).unwrap(), &feature, &Context::new()).unwrap();
            let faces = face_normals(&mesh);
            let expected = corner_normals(&mesh, &faces, &feature);
            for c in 0..mesh.corner_count() {
                let s = sectors.of_corner[c];
                assert!(sectors.corners(s).contains(&(c as u32)));
                assert!(sectors.fans[s as usize].normal.dot(expected[c]) > 0.99);
                let v = mesh.vertex(CornerId::new(c)).0;
                assert!(s == v || sectors.further(v).contains(&(v, s)));
            }
            assert_eq!(
                (0..sectors.fans.len() as u32).map(|s| sectors.corners(s).len()).sum::<usize>(),
                mesh.corner_count()
            );
        }
    }

    #[test]
    fn normals_are_exact_on_spheres() {
        // A sphere of which every vertex is moved along the surface: nothing is regular any more.
        let mesh =
            moved(&sphere(2), |p| unit(p + 0.1 * DVec3::new((9.0 * p.y).sin(), (7.0 * p.z).sin(), (8.0 * p.x).cos())));
        let none = vec![false; mesh.corner_count()];
        let sectors = Sectors::new(Triangles::of(&mesh).unwrap(), &none, &Context::new()).unwrap();
        assert!(mesh.points().iter().zip(&sectors.fans).all(|(p, fan)| p.distance(fan.normal) < 1e-12));
    }
}
