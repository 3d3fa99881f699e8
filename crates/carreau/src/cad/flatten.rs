//! A region laid out in a plane: the parameters that a spline surface is fitted over.
//!
//! Regions that look one way are projected. Others are laid out by the least-squares conformal map of Lévy, Petitjean, Ray and
//! Maillot (*Least squares conformal maps for automatic texture atlas generation*, SIGGRAPH 2002): every triangle keeps its shape
//! as well as all of them together allow, and borders are free.
//!
//! ```text
//!        ╱╲___                      ______
//!       ╱    ╱╲        ▷          ╱╲    ╱╲       lengths are those of the region in the mean
//!      ╱____╱__╲                 ╱__╲__╱__╲
//! ```

use super::regions::{area_vector, vertex_ids};
use crate::brep::Frame;
use crate::mesh::Triangles;
use crate::numeric::eigen3::{Eigen3, outer};
use crate::numeric::sparse::LeastSquares;
use glam::{DMat3, DVec2, DVec3};

/// Cosine of 65°: triangles of a region that is projected are tilted by less against the plane, because lengths would
/// shrink to less than two fifths.
const FLATTEN_TILT: f64 = 0.42;
/// Ratio of the areas, in the plane and in space, of the triangle that grows most to those of the one that shrinks
/// most, because beyond it one grid does not fit all of the region.
const MOST_STRETCH: f64 = 64.0;

/// The vertices of a region and their places in the plane.
#[derive(Debug, Clone)]
pub struct Flat {
    /// Ascending.
    pub vertices: Vec<u32>,
    /// In the unit of the mesh.
    pub places: Vec<DVec2>,
}

impl Flat {
    /// The place of a vertex of the region.
    pub fn place(&self, v: u32) -> DVec2 {
        self.vertices.binary_search(&v).map_or(DVec2::ZERO, |k| self.places[k])
    }
}

/// Lays a region out with its outer side up; `None` where triangles would be turned over or sizes too uneven.
pub fn flatten(t: Triangles<'_>, triangles: &[u32]) -> Option<Flat> {
    let vertices = vertex_ids(t, triangles);
    let whole: DVec3 = triangles.iter().map(|&k| area_vector(t, k)).sum();
    let up = whole.try_normalize()?;
    let looks_up = |&k: &u32| {
        let n = area_vector(t, k);
        n.dot(up) >= FLATTEN_TILT * n.length()
    };
    let frame = principal(t, &vertices, up);
    let places = if triangles.iter().all(looks_up) {
        let flat = |&v: &u32| {
            let l = frame.local(t.points()[v as usize]);
            DVec2::new(l.x, l.y)
        };
        vertices.iter().map(flat).collect()
    } else {
        conformal(t, triangles, &vertices)?
    };
    let flat = Flat { vertices, places };
    is_even(t, triangles, &flat).then_some(flat)
}

/// A frame with a given normal whose x axis is the longest direction of the vertices.
fn principal(t: Triangles<'_>, vertices: &[u32], up: DVec3) -> Frame {
    let points = || vertices.iter().map(|&v| t.points()[v as usize]);
    let mean = points().sum::<DVec3>() / vertices.len().max(1) as f64;
    let spread = points().map(|p| outer((p - mean) - up * (p - mean).dot(up))).fold(DMat3::ZERO, |a, b| a + b);
    Frame::new(mean, up, Eigen3::new(spread).vectors[2])
}

/// Places up to a similarity, scaled so that the whole area is that in space.
fn conformal(t: Triangles<'_>, triangles: &[u32], vertices: &[u32]) -> Option<Vec<DVec2>> {
    let at = |v: u32| vertices.binary_search(&v).unwrap_or(0);
    let point = |k: usize| t.points()[vertices[k] as usize];
    // Two vertices that are far apart are held.
    let far = |from: DVec3| {
        let distance = |k: &usize| point(*k).distance_squared(from);
        (0..vertices.len()).max_by(|a, b| distance(a).total_cmp(&distance(b)).then(b.cmp(a)))
    };
    let first = far(point(0))?;
    let second = far(point(first))?;
    let held = [first, second];
    let length = point(first).distance(point(second));
    // The unknowns of a vertex; none for those that are held.
    let unknown = |k: usize| {
        let before = held.iter().filter(|&&h| h < k).count();
        (!held.contains(&k)).then_some(2 * (k - before) as u32)
    };
    let value = |k: usize| DVec2::new(if k == second { length } else { 0.0 }, 0.0);
    let mut squares = LeastSquares::new(2 * vertices.len().checked_sub(2)?);
    for &k in triangles {
        let area = area_vector(t, k).length();
        let ids = t.triangle(k);
        let p = ids.map(|v| t.points()[v as usize]);
        let Some(x) = (p[1] - p[0]).try_normalize() else { continue };
        if !(area > 0.0) {
            continue;
        }
        let y = area_vector(t, k).normalize_or_zero().cross(x);
        let local = p.map(|q| DVec2::new((q - p[0]).dot(x), (q - p[0]).dot(y)));
        let sides = [local[2] - local[1], local[0] - local[2], local[1] - local[0]];
        let (mut real, mut imaginary) = (Vec::with_capacity(6), Vec::with_capacity(6));
        let (mut rest, mut other) = (0.0, 0.0);
        for (v, w) in ids.into_iter().zip(sides) {
            let k = at(v);
            if let Some(u) = unknown(k) {
                real.extend([(u, w.x), (u + 1, -w.y)]);
                imaginary.extend([(u, w.y), (u + 1, w.x)]);
            } else {
                rest += w.x * value(k).x - w.y * value(k).y;
                other += w.y * value(k).x + w.x * value(k).y;
            }
        }
        squares.add(1.0 / area, &real, rest);
        squares.add(1.0 / area, &imaginary, other);
    }
    let solution = squares.solve(&mut None).ok()?;
    let place = |k: usize| unknown(k).map_or(value(k), |u| DVec2::new(solution[u as usize], solution[u as usize + 1]));
    let places: Vec<DVec2> = (0..vertices.len()).map(place).collect();
    let in_plane: f64 = triangles.iter().map(|&k| area_between(t.triangle(k).map(|v| places[at(v)]))).sum();
    let in_space: f64 = triangles.iter().map(|&k| 0.5 * area_vector(t, k).length()).sum();
    let scale = (in_space / in_plane).sqrt();
    scale.is_finite().then(|| places.into_iter().map(|p| p * scale).collect())
}

fn area_between([a, b, c]: [DVec2; 3]) -> f64 {
    0.5 * (b - a).perp_dot(c - a)
}

/// Whether no triangle is turned over, and their sizes are those in space within bounds; slivers have no size to compare.
fn is_even(t: Triangles<'_>, triangles: &[u32], flat: &Flat) -> bool {
    let sizes: Vec<(f64, f64)> = triangles
        .iter()
        .map(|&k| (area_between(t.triangle(k).map(|v| flat.place(v))), 0.5 * area_vector(t, k).length()))
        .collect();
    let tiny = 1e-9 * sizes.iter().map(|s| s.1).sum::<f64>();
    let (mut low, mut high) = (f64::INFINITY, 0.0f64);
    for (plane, space) in sizes.into_iter().filter(|s| s.1 > tiny) {
        if !(plane > 0.0) {
            return false;
        }
        (low, high) = (low.min(plane / space), high.max(plane / space));
    }
    high <= MOST_STRETCH * low
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::SurfaceMesh;

    /// Three quarters of a tube around x, which no projection lays out.
    #[test]
    fn a_bent_strip_becomes_flat_without_stretch() {
        let (rows, columns) = (12u32, 4u32);
        let at = |r: u32, c: u32| {
            let angle = 1.5 * std::f64::consts::PI * f64::from(r) / f64::from(rows);
            DVec3::new(f64::from(c), angle.cos(), angle.sin())
        };
        let points: Vec<DVec3> = (0..=rows).flat_map(|r| (0..=columns).map(move |c| at(r, c))).collect();
        let id = |r: u32, c: u32| r * (columns + 1) + c;
        let quads = (0..rows).flat_map(|r| (0..columns).map(move |c| (r, c)));
        let triangles: Vec<[u32; 3]> = quads
            .flat_map(|(r, c)| {
                let [a, b, d, e] = [id(r, c), id(r, c + 1), id(r + 1, c + 1), id(r + 1, c)];
                [[a, b, d], [a, d, e]]
            })
            .collect();
        let mesh = SurfaceMesh::from_triangles(points.clone(), &triangles).unwrap();
        let t = Triangles::of(&mesh).unwrap();
        let all: Vec<u32> = (0..triangles.len() as u32).collect();
        let flat = flatten(t, &all).unwrap();
        for [a, b, c] in triangles {
            for (p, q) in [(a, b), (b, c), (c, a)] {
                let (plane, space) =
                    (flat.place(p).distance(flat.place(q)), points[p as usize].distance(points[q as usize]));
                assert!((plane / space - 1.0).abs() < 1e-6, "{plane} for {space}");
            }
        }
    }
}
