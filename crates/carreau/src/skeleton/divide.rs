//! Long edges are divided before the flow, so that the skeleton does not depend on the triangles.
//!
//! The flow moves vertices. A pipe from a CAD system has none between its ends: its triangles are as long as it is, and the
//! flow would draw one end into the other. So edges longer than half of the local radius, which is half of the way through
//! the body, are halved until none is:
//!
//! ```text
//!   ┌──────────────────┐        ┌──┬──┬──┬──┬──┬──┐
//!   │        ____/     │   →    │╲ │╲ │╲ │╲ │╲ │╲ │      the shape stays to the bit
//!   └───────/──────────┘        └──┴──┴──┴──┴──┴──┘
//! ```
//!
//! Surfaces without such triangles, scans and segmentations, are left as they are.

use crate::context::Context;
use crate::error::Result;
use crate::geometry::normals::face_normals;
use crate::geometry::search_tree::TriangleTree;
use crate::mesh::{SurfaceMesh, safe_length, triangle_area_vector};
use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

/// A triangle with a side longer than this many local radii is long: beyond that a tube has no ring of vertices per length of
/// its diameter.
const LONG_SIDE: f64 = 2.0;
/// A surface is divided where long triangles are more than this share of its area: where an ear is thin a scan has some, too.
const SHARE: f64 = 0.1;
/// The longest edges then, in local radii: about twelve vertices around a tube and along as much of it.
const FINE: f64 = 0.5;
/// Growth of the local radius per length away from where it is known: as fast as a cone of 27° opens.
const RADIUS_GROWTH: f64 = 0.5;
/// The least local radius, as a share of the diagonal: below it sheets would take millions of triangles.
const LEAST: f64 = 0.01;
/// Rounds of halving: an edge as long as the diagonal is below the least length after eight.
const HALVING_ROUNDS: usize = 16;

/// The same surface with short edges, its own vertices first; `None` where they are short already.
pub fn divided(surface: &SurfaceMesh, context: &Context) -> Result<Option<SurfaceMesh>> {
    let mut work = Work::of(surface, context)?;
    let share = work.long_share();
    tracing::debug!(share, "long triangles");
    if share <= SHARE {
        return Ok(None);
    }
    for _ in 0..HALVING_ROUNDS {
        context.check()?;
        if !work.halve() {
            break;
        }
    }
    SurfaceMesh::from_triangles(work.points, &work.triangles).map(Some)
}

/// Triangles with the local radius at their vertices and on their faces.
struct Work {
    points: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    at_vertex: Vec<f64>,
    on_face: Vec<f64>,
}

impl Work {
    /// Half of the way through the body from the middle of every triangle, and at a vertex the least of those around it: from
    /// the lid of a tube it is far through.
    fn of(surface: &SurfaceMesh, context: &Context) -> Result<Work> {
        let triangles = surface.faces().fan().0;
        let points = surface.points().to_vec();
        let tree = TriangleTree::new(&points, &triangles);
        let normals = face_normals(surface);
        let (least, most) = (LEAST * surface.diagonal(), 0.5 * surface.diagonal());
        context.check()?;
        let half_way = |t: usize| {
            let middle = triangles[t].map(|v| points[v as usize]).iter().sum::<DVec3>() / 3.0;
            let mut through = 2.0 * most;
            tree.along_ray(middle, -normals[t], through, |hit| {
                if hit.triangle as usize != t && hit.t > 0.0 {
                    through = through.min(hit.t);
                }
            });
            (0.5 * through).max(least)
        };
        let on_face: Vec<f64> = (0..triangles.len()).into_par_iter().map(half_way).collect();
        let mut at_vertex = vec![most; points.len()];
        for (t, &radius) in triangles.iter().zip(&on_face) {
            t.iter().for_each(|&v| at_vertex[v as usize] = at_vertex[v as usize].min(radius));
        }
        Ok(Work { points, triangles, at_vertex, on_face })
    }

    /// The share of the area in triangles that are long.
    fn long_share(&self) -> f64 {
        let (mut long, mut all) = (0.0, 0.0);
        for (t, triangle) in self.triangles.iter().enumerate() {
            let [a, b, c] = triangle.map(|v| self.points[v as usize]);
            let area = safe_length(triangle_area_vector(a, b, c));
            all += area;
            if (0..3).any(|k| self.length(t, k) > LONG_SIDE * self.radius(t, k)) {
                long += area;
            }
        }
        if all > 0.0 { long / all } else { 0.0 }
    }

    /// The ends of a side of a triangle.
    fn ends(&self, t: usize, side: usize) -> [usize; 2] {
        [side, (side + 1) % 3].map(|k| self.triangles[t][k] as usize)
    }

    fn length(&self, t: usize, side: usize) -> f64 {
        let [a, b] = self.ends(t, side);
        self.points[a].distance(self.points[b])
    }

    /// The local radius in the middle of a side, as its own triangle knows it.
    fn radius(&self, t: usize, side: usize) -> f64 {
        let [a, b] = self.ends(t, side);
        let grown = self.at_vertex[a].min(self.at_vertex[b]) + RADIUS_GROWTH * 0.5 * self.length(t, side);
        grown.min(self.on_face[t])
    }

    /// Halves the sides that are too long for one of their two triangles; whether there were any.
    ///
    /// ```text
    ///     one                two                three
    ///      c                  c                  c
    ///     ╱│╲               n╱─╲m              n╱─╲m
    ///    ╱ │ ╲              ╱╲  ╲              ╱╲ ╱╲
    ///   a──m──b            a──╲──b            a──l──b
    /// ```
    fn halve(&mut self) -> bool {
        let key = |[a, b]: [usize; 2]| [a.min(b) as u32, a.max(b) as u32];
        let mut middle: FxHashMap<[u32; 2], u32> = FxHashMap::default();
        for t in 0..self.triangles.len() {
            for side in 0..3 {
                let radius = self.radius(t, side);
                if self.length(t, side) <= FINE * radius {
                    continue;
                }
                let ends = self.ends(t, side);
                let new = self.points.len() as u32;
                let m = *middle.entry(key(ends)).or_insert(new);
                if m == new {
                    self.points.push(0.5 * (self.points[ends[0]] + self.points[ends[1]]));
                    self.at_vertex.push(radius);
                }
                self.at_vertex[m as usize] = self.at_vertex[m as usize].min(radius);
            }
        }
        for t in 0..self.triangles.len() {
            let halves = [0, 1, 2].map(|side| middle.get(&key(self.ends(t, side))).copied());
            let own = self.on_face[t];
            let parts = self.parts(self.triangles[t], halves);
            self.triangles[t] = parts[0];
            self.on_face.extend(parts[1..].iter().map(|_| own));
            self.triangles.extend(&parts[1..]);
        }
        !middle.is_empty()
    }

    /// A triangle cut at the middles of its sides, all in its own sense.
    fn parts(&self, corners: [u32; 3], halves: [Option<u32>; 3]) -> Vec<[u32; 3]> {
        let split = halves.iter().flatten().count();
        // Turned so that the pattern's first side is cut, and with two of them the second as well.
        let first = (0..3).find(|&k| match split {
            1 => halves[k].is_some(),
            2 => halves[k].is_some() && halves[(k + 1) % 3].is_some(),
            _ => true,
        });
        let k = first.unwrap_or(0);
        let [a, b, c] = [0, 1, 2].map(|i| corners[(k + i) % 3]);
        match [0, 1, 2].map(|i| halves[(k + i) % 3]) {
            [Some(l), None, None] => vec![[a, l, c], [l, b, c]],
            [Some(l), Some(m), None] => {
                let [p, q, r, s] = [a, m, l, c].map(|v| self.points[v as usize]);
                // The four-sided rest along its shorter diagonal.
                let rest = if p.distance(q) <= r.distance(s) { [[a, l, m], [a, m, c]] } else { [[a, l, c], [l, m, c]] };
                vec![[l, b, m], rest[0], rest[1]]
            }
            [Some(l), Some(m), Some(n)] => vec![[a, l, n], [l, b, m], [n, m, c], [l, m, n]],
            _ => vec![corners],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Topology;

    /// A closed cylinder along z of triangles as long as it is.
    fn pipe(sides: u32, radius: f64, height: f64) -> SurfaceMesh {
        let at = |k: u32, z: f64| {
            let (sin, cos) = (f64::from(k) * std::f64::consts::TAU / f64::from(sides)).sin_cos();
            DVec3::new(radius * cos, radius * sin, z)
        };
        let points = (0..2 * sides).map(|k| at(k % sides, if k < sides { 0.0 } else { height })).collect();
        let mut triangles = Vec::new();
        for k in 0..sides {
            let (a, b) = (k, (k + 1) % sides);
            triangles.extend([[a, b, sides + b], [a, sides + b, sides + a]]);
        }
        for k in 1..sides - 1 {
            triangles.extend([[0, k + 1, k], [sides, sides + k, sides + k + 1]]);
        }
        SurfaceMesh::from_triangles(points, &triangles).unwrap()
    }

    #[test]
    fn long_edges_are_divided_and_the_shape_stays() {
        let context = Context::new();
        for (sides, height) in [(12, 20.0), (24, 16.0), (7, 9.0)] {
            let before = pipe(sides, 1.0, height);
            let after = divided(&before, &context).unwrap().unwrap();
            let [a, b] = [&before, &after].map(Topology::of);
            assert!(b.closed && b.manifold && b.consistently_oriented);
            assert!((a.volume.unwrap() - b.volume.unwrap()).abs() < 1e-9 * a.volume.unwrap());
            assert_eq!(before.points(), &after.points()[..before.vertex_count()]);
            let length = |t: &[u32; 3], k: usize| {
                after.points()[t[k] as usize].distance(after.points()[t[(k + 1) % 3] as usize])
            };
            let halves = after.faces().fan().0;
            let longest = halves.iter().map(|t| (0..3).map(|k| length(t, k)).fold(0.0, f64::max));
            // In the middle of an end the local radius has grown.
            assert!(longest.fold(0.0, f64::max) <= 1.5 * FINE, "edges are about half a radius long");
            assert!(divided(&after, &context).unwrap().is_none());
        }
    }

    #[test]
    fn even_surfaces_stay_as_they_are() {
        let sphere = crate::mesh::test_models::sphere(3);
        assert!(divided(&sphere, &Context::new()).unwrap().is_none());
    }
}
