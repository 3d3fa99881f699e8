//! Planar facets: connected triangles in one plane. On a polyhedral model a facet is a face; on a tessellated curved
//! surface it is a strip between two generators or a single triangle.

use super::regions::Groups;
use super::surface::Surface;
use crate::context::Context;
use crate::error::Result;
use crate::mesh::NONE;
use glam::DVec3;

/// Radians: triangles of a facet turn away from its plane by no more, however near their vertices are, because a narrow
/// one may stand upright on it.
const FACET_TURN: f64 = 0.2;

/// Facets of all triangles.
pub struct Facets {
    /// Facet of every triangle; [`NONE`] where it was not free.
    pub of: Vec<u32>,
    groups: Groups,
    /// Unit normals and areas.
    pub normal: Vec<DVec3>,
    pub area: Vec<f64>,
}

impl Facets {
    /// Number of facets.
    pub fn len(&self) -> usize {
        self.normal.len()
    }

    /// The triangles of a facet.
    #[inline]
    pub fn triangles(&self, f: u32) -> &[u32] {
        self.groups.of(f)
    }

    /// Grows facets over the free triangles, in this order; all vertices lie within the tolerance of the plane.
    pub fn new(
        surface: &Surface<'_>,
        free: &[bool],
        order: &[u32],
        tolerance: f64,
        turn: f64,
        context: &Context,
    ) -> Result<Self> {
        let t = surface.triangles;
        let points = t.points();
        let mut of = vec![NONE; t.len()];
        let (mut normal, mut area) = (Vec::new(), Vec::new());
        let mut stack = Vec::new();
        let cos = turn.max(FACET_TURN).cos();
        for (step, &seed) in order.iter().enumerate() {
            context.check_every(step)?;
            if of[seed as usize] != NONE || !free[seed as usize] {
                continue;
            }
            let f = normal.len() as u32;
            of[seed as usize] = f;
            let mut plane = RunningPlane::new(surface, seed);
            stack.push(seed);
            while let Some(at) = stack.pop() {
                for c in 3 * at..3 * at + 3 {
                    let o = t.opposite(c);
                    if o == NONE || of[o as usize / 3] != NONE || !free[o as usize / 3] {
                        continue;
                    }
                    let next = o / 3;
                    let flat =
                        surface.areas[next as usize] <= 0.0 || surface.normals[next as usize].dot(plane.normal) > cos;
                    let near = |v: u32| (points[v as usize] - plane.origin).dot(plane.normal).abs() <= tolerance;
                    if flat && t.triangle(next).into_iter().all(near) {
                        of[next as usize] = f;
                        plane.add(surface, next);
                        stack.push(next);
                    }
                }
            }
            normal.push(plane.normal);
            area.push(plane.area);
        }
        let groups = Groups::new(&of, normal.len());
        Ok(Facets { of, groups, normal, area })
    }
}

/// The plane of a growing facet: through the weighted centroid, along the summed area vectors, renewed whenever the area
/// has doubled.
struct RunningPlane {
    origin: DVec3,
    normal: DVec3,
    vector: DVec3,
    moment: DVec3,
    area: f64,
    renewed: f64,
}

impl RunningPlane {
    fn new(surface: &Surface<'_>, seed: u32) -> Self {
        let mut plane = RunningPlane {
            origin: surface.triangles.point(3 * seed),
            normal: surface.normals[seed as usize],
            vector: DVec3::ZERO,
            moment: DVec3::ZERO,
            area: 0.0,
            renewed: 0.0,
        };
        plane.add(surface, seed);
        plane
    }

    fn add(&mut self, surface: &Surface<'_>, t: u32) {
        let a = surface.areas[t as usize];
        self.area += a;
        self.vector += a * surface.normals[t as usize];
        self.moment += a * surface.center(t);
        if self.area >= 2.0 * self.renewed && self.area > 0.0 {
            self.renewed = self.area;
            self.origin = self.moment / self.area;
            self.normal = self.vector.normalize_or(self.normal);
        }
    }
}
