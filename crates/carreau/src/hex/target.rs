//! The surface that the boundary of a mesh is pulled to. For a vertex it gives the place ahead or behind along the
//! vertex's normal, on the side that faces the same way, or the closest one; in the plane of a lid, or on its border.

use crate::geometry::normals::face_normals;
use crate::geometry::search_tree::{Closest, TriangleTree};
use crate::geometry::winding::WindingTree;
use crate::mesh::{CurveNet, SurfaceMesh, split_quad};
use crate::skeleton::{self, Closed, Lid};
use glam::DVec3;
use rayon::prelude::*;
use std::ops::Range;

/// A hit counts when its normal is at most about 75° off.
pub const AGREES: f64 = 0.25;
/// What is met along the normal is taken for this much nearer than the closest point.
const AHEAD: f64 = 0.5;

/// The surface, its lids and borders.
pub struct Target<'a> {
    closed: &'a Closed,
    normals: Vec<DVec3>,
    all: TriangleTree,
    /// Those without the lids, where there are some.
    wall: Option<TriangleTree>,
    inside: WindingTree,
    /// Borders of the lids, as triangles without width.
    rims: Vec<TriangleTree>,
    by_facing: bool,
}

/// A place of the surface, and what of a boundary is nearest to it.
pub struct Seen {
    /// The place, in the middle of a triangle of the wall, and the normal there.
    pub place: DVec3,
    pub normal: DVec3,
    /// How far the boundary is.
    pub distance: f64,
    /// Its face, and the half of it.
    pub quad: usize,
    pub half: [u32; 3],
}

/// What a boundary vertex belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// Inside.
    Inner,
    /// The surface.
    Wall,
    /// A lid, from 0.
    Lid(u32),
    /// The border of a lid.
    Rim(u32),
}

impl<'a> Target<'a> {
    /// The target of a surface with lids.
    pub fn new(closed: &'a Closed) -> Self {
        let triangles = closed.mesh.faces().fan().0;
        let rim = |lid: &Lid| TriangleTree::of_segments(closed.mesh.points(), lid.border.iter().copied());
        let wall = &triangles[..closed.wall];
        let all = TriangleTree::new(closed.mesh.points(), &triangles);
        Target {
            normals: face_normals(&closed.mesh),
            inside: WindingTree::new(&all),
            wall: (!closed.lids.is_empty()).then(|| TriangleTree::new(closed.mesh.points(), wall)),
            all,
            rims: closed.lids.iter().map(rim).collect(),
            by_facing: false,
            closed,
        }
    }

    /// What faces another way than a vertex is taken for farther from it, so that a vertex in a body between two branches
    /// goes ahead to where these part, not to the flank of the body. Some surfaces are met better with, some without.
    ///
    /// ```text
    ///     ╲   ╱          s faces as v does; f is nearer, but faces aside
    ///      ╲s╱
    ///       ↑
    ///   f   v   f
    /// ```
    pub fn by_facing(self) -> Self {
        Target { by_facing: true, ..self }
    }

    /// The closed surface.
    pub fn surface(&self) -> &SurfaceMesh {
        &self.closed.mesh
    }

    /// The lids.
    pub fn lids(&self) -> &[Lid] {
        &self.closed.lids
    }

    /// The triangles of the surface without its lids.
    fn wall_triangles(&self) -> Range<usize> {
        0..self.closed.wall
    }

    fn wall(&self) -> &TriangleTree {
        self.wall.as_ref().unwrap_or(&self.all)
    }

    /// The corners of a triangle.
    pub fn corners(&self, triangle: u32) -> [DVec3; 3] {
        let (points, corners) = (self.surface().points(), self.surface().faces().corners());
        [0, 1, 2].map(|k| points[corners[3 * triangle as usize + k] as usize])
    }

    /// Its unit normal.
    pub fn normal(&self, triangle: u32) -> DVec3 {
        self.normals[triangle as usize]
    }

    /// What places of the wall find when they look at a boundary; the last number bounds the number of places, about.
    pub fn looking_at<T: Send>(
        &self,
        points: &[DVec3],
        quads: &[[u32; 4]],
        samples: usize,
        find: impl Fn(Seen) -> Option<T> + Sync,
    ) -> Vec<T> {
        let halves: Vec<[u32; 3]> = quads.iter().flat_map(|&q| split_quad(points, q)).collect();
        let tree = TriangleTree::new(points, &halves);
        let look = |t: usize| {
            let [a, b, c] = self.corners(t as u32);
            let place = (a + b + c) / 3.0;
            let found = tree.closest(place)?;
            let half = found.triangle as usize;
            let (distance, normal) = (found.distance(), self.normal(t as u32));
            find(Seen { place, normal, distance, quad: half / 2, half: halves[half] })
        };
        let step = self.wall_triangles().len().div_ceil(samples).max(1);
        self.wall_triangles().into_par_iter().step_by(step).filter_map(look).collect()
    }

    /// Distance to the closed surface.
    pub fn distance(&self, p: DVec3) -> f64 {
        self.all.distance(p)
    }

    /// Distance to the surface without its lids: the room that a tube has about its branch, which goes on to the end.
    pub fn room(&self, p: DVec3) -> f64 {
        self.wall().distance(p)
    }

    /// Whether a point is inside.
    pub fn contains(&self, p: DVec3) -> bool {
        self.inside.contains(p)
    }

    /// Moves the nodes of a net to the middle of the surface.
    pub fn centre(&self, net: &mut CurveNet) {
        skeleton::centre(net, self.wall(), &self.inside);
    }

    /// How far along a ray from inside the surface is left.
    pub fn leaves(&self, from: DVec3, direction: DVec3) -> Option<f64> {
        let mut first: Option<f64> = None;
        self.all.along_ray(from, direction, f64::INFINITY, |hit| {
            if !hit.front && first.is_none_or(|t| hit.t < t) {
                first = Some(hit.t);
            }
        });
        first
    }

    fn is_wall(&self, triangle: u32) -> bool {
        (triangle as usize) < self.closed.wall
    }

    /// Where a wall vertex with a normal belongs, and the surface's normal there: ahead or behind along the normal, or,
    /// where that glances off, where the surface is closest.
    fn on_wall(&self, p: DVec3, n: DVec3, reach: f64) -> (DVec3, DVec3) {
        let farther = |distance: f64, triangle: u32| {
            let cos = self.normal(triangle).dot(n);
            (self.is_wall(triangle) && cos > AGREES).then(|| if self.by_facing { distance / cos } else { distance })
        };
        let mut best: Option<(f64, DVec3, u32)> = None;
        for sense in [1.0, -1.0] {
            self.all.along_ray(p, n * sense, reach, |hit| {
                let Some(far) = farther(AHEAD * hit.t, hit.triangle) else { return };
                if best.is_none_or(|b| far < b.0) {
                    best = Some((far, p + n * (sense * hit.t), hit.triangle));
                }
            });
        }
        let reach = best.map_or(reach, |b| b.0.min(reach));
        if let Some((far, c)) = self.all.cheapest(p, reach, |c| farther(c.distance(), c.triangle))
            && best.is_none_or(|b| (far, c.triangle) < (b.0, b.2))
        {
            best = Some((far, c.point, c.triangle));
        }
        match best {
            Some((_, point, triangle)) => (point, self.normal(triangle)),
            None => self.closest_wall(p).unwrap_or((p, n)),
        }
    }

    /// Where a vertex belongs that was on the wall and has been moved along it: at the closest place that faces as the vertex
    /// does, or as the wall did where the vertex was. The two differ much where a few faces span a fork.
    pub fn along_wall(&self, p: DVec3, facings: [DVec3; 2], reach: f64) -> Option<(DVec3, DVec3)> {
        let agrees = |t: u32| facings.iter().any(|n| self.normal(t).dot(*n) > AGREES);
        let cost = |c: &Closest| (self.is_wall(c.triangle) && agrees(c.triangle)).then(|| c.distance());
        let (_, c) = self.all.cheapest(p, reach, cost)?;
        Some((c.point, self.normal(c.triangle)))
    }

    /// The closest place of the surface without its lids, and the normal there.
    pub fn closest_wall(&self, p: DVec3) -> Option<(DVec3, DVec3)> {
        let c = self.wall().closest(p)?;
        Some((c.point, self.normal(c.triangle)))
    }

    /// Where a boundary vertex belongs, and the direction in which it must be there; others are free.
    pub fn place(&self, part: Part, p: DVec3, n: DVec3, reach: f64) -> (DVec3, DVec3) {
        match part {
            Part::Inner => (p, DVec3::ZERO),
            Part::Wall => self.on_wall(p, n, reach),
            Part::Lid(k) => {
                let lid = &self.lids()[k as usize];
                (p - lid.normal * (p - lid.centre).dot(lid.normal), lid.normal)
            }
            Part::Rim(k) => {
                // About across the border, in the lid's plane.
                let (lid, to) = (&self.lids()[k as usize], self.rims[k as usize].closest(p).map_or(p, |c| c.point));
                let outward = to - lid.centre;
                (to, (outward - lid.normal * lid.normal.dot(outward)).normalize_or_zero())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::context::Context;
    use crate::mesh::test_models::sphere;

    /// Beyond an open end the lid is nearer than the wall.
    #[test]
    fn a_lid_is_no_wall() {
        let ball = sphere(4);
        let below = |t: &&[u32; 3]| t.iter().all(|&v| ball.points()[v as usize].z < 0.6);
        let open: Vec<[u32; 3]> = ball.faces().fan().0.iter().filter(below).copied().collect();
        let raw = SurfaceMesh::from_triangles(ball.points().to_vec(), &open).unwrap();
        let (closed, _) = skeleton::prepared(&raw, &Context::new()).unwrap();
        let target = Target::new(&closed);
        let top = target.lids()[0].centre;
        assert!(target.distance(top) < 1e-9);
        let (on_wall, _) = target.closest_wall(top).unwrap();
        assert!((on_wall.length() - 1.0).abs() < 0.02 && on_wall.distance(top) > 0.5, "{on_wall}");
    }

    /// Faces that span a fork face another way than the surface under their corners: a vertex stays where it is, and slides from
    /// there, though by the faces alone it belongs on the other side.
    #[test]
    fn a_vertex_slides_from_where_it_is() {
        let (closed, _) = skeleton::prepared(&sphere(4), &Context::new()).unwrap();
        let target = Target::new(&closed);
        let (here, across) = (target.closest_wall(DVec3::Z).unwrap(), -DVec3::Z);
        assert!(target.on_wall(here.0, across, 4.0).0.z < -0.9);
        let along = |p: DVec3| target.along_wall(p, [across, here.1], 4.0).unwrap().0;
        assert!(along(here.0).distance(here.0) < 1e-12);
        let beside = along(here.0 + DVec3::X * 0.1);
        assert!(beside.x > 0.05 && beside.z > 0.9, "{beside}");
        assert!(target.along_wall(DVec3::Z * 9.0, [across, here.1], 4.0).is_none());
    }

    /// A vertex in a long body looks ahead, a little upward: the flank above it is nearer, but faces aside.
    #[test]
    fn by_facing_a_vertex_goes_ahead_not_aside() {
        let ball = sphere(4);
        let points = ball.points().iter().map(|p| DVec3::new(4.0 * p.x, p.y, p.z)).collect();
        let long = SurfaceMesh::from_triangles(points, &ball.faces().fan().0).unwrap();
        let (closed, _) = skeleton::prepared(&long, &Context::new()).unwrap();
        let (p, n) = (DVec3::new(1.5, 0.4, 0.0), DVec3::new(0.95, 0.31, 0.0).normalize());
        let near = Target::new(&closed).on_wall(p, n, 5.0).0;
        let ahead = Target::new(&closed).by_facing().on_wall(p, n, 5.0).0;
        assert!(near.x < 1.8 && ahead.x > 2.3, "{near} {ahead}");
        assert!([near, ahead].iter().all(|q| ((q.x / 4.0).powi(2) + q.y * q.y + q.z * q.z - 1.0).abs() < 0.02));
    }
}
