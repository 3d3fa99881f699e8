//! The triangles as the stages see them: areas, sharp edges and vertices (§4.1), a numbering-free order.

use super::enrich::Enriched;
use super::slivers;
use crate::context::Context;
use crate::error::Result;
use crate::geometry::normals::{angle_between, face_normal, face_normals};
use crate::geometry::primitive::Primitive;
use crate::mesh::{NONE, SurfaceMesh, Triangles, safe_length, triangle_area_vector};
use glam::DVec3;
use rayon::prelude::*;
use std::cmp::Ordering;

/// A triangle mesh with what every stage asks for.
pub struct Surface<'a> {
    pub mesh: &'a SurfaceMesh,
    pub triangles: Triangles<'a>,
    /// Unit normals; slivers have that of a neighbour, and where there is none it is zero.
    pub normals: Vec<DVec3>,
    pub areas: Vec<f64>,
    pub total_area: f64,
    /// Angle between the normals across the half-edge that leaves a corner, in radians; both half-edges of an edge have
    /// the same number, π on borders and irregular edges.
    pub bend: Vec<f32>,
}

/// A share of the way from a corner to the centroid: a little inside of a triangle, because a normal at an apex or an
/// axis means nothing.
const INSIDE_SHARE: f64 = 1e-3;
/// Share of length times turn that the middle of a chord may be off its surface by: twice that of a circle, because other
/// sections are no circles.
const CHORD_SHARE: f64 = 0.25;

impl<'a> Surface<'a> {
    pub fn new(mesh: &'a SurfaceMesh, triangles: Triangles<'a>) -> Self {
        let mut normals = face_normals(mesh);
        let count = triangles.len() as u32;
        let areas: Vec<f64> = (0..count).into_par_iter().map(|t| area(triangles, t)).collect();
        slivers::borrow_normals(triangles, &areas, &mut normals);
        // Once per edge: the half-edge with the larger number gets the angle of the other.
        let bend = |c: u32| if triangles.opposite(c) < c { 0.0 } else { bend(triangles, &normals, c) };
        let mut bend: Vec<f32> = (0..3 * count).into_par_iter().map(bend).collect();
        for c in 0..3 * count {
            let o = triangles.opposite(c);
            if o < c {
                bend[c as usize] = bend[o as usize];
            }
        }
        let total_area = sum(&areas);
        Surface { mesh, triangles, normals, areas, total_area, bend }
    }

    /// [`Surface::new`] of an enriched mesh: what is as before is not computed again.
    pub fn enriched<'b>(before: &Surface<'_>, enriched: &'b Enriched, triangles: Triangles<'b>) -> Surface<'b> {
        let Enriched { mesh, parent, split } = enriched;
        let same = |t: u32| !split[parent[t as usize] as usize];
        let normal = face_normal(mesh);
        let all = || (0..triangles.len() as u32).into_par_iter();
        let old = |t: u32| parent[t as usize] as usize;
        let normals: Vec<DVec3> =
            all().map(|t| if same(t) { before.normals[old(t)] } else { normal(t as usize) }).collect();
        let areas: Vec<f64> = all().map(|t| if same(t) { before.areas[old(t)] } else { area(triangles, t) }).collect();
        let bend = |c: u32| match triangles.opposite(c) {
            o if same(c / 3) && (o == NONE || same(o / 3)) => before.bend[3 * old(c / 3) + c as usize % 3],
            _ => bend(triangles, &normals, c),
        };
        let bend = (0..3 * triangles.len() as u32).into_par_iter().map(bend).collect();
        let total_area = sum(&areas);
        Surface { mesh, triangles, normals, areas, total_area, bend }
    }

    pub fn len(&self) -> usize {
        self.areas.len()
    }

    /// Length of the edge that leaves a corner.
    #[inline]
    pub fn edge_length(&self, c: u32) -> f64 {
        self.triangles.point(c).distance(self.triangles.point(self.triangles.next(c)))
    }

    /// Angle of a triangle at a corner, in radians.
    pub fn corner_angle(&self, c: u32) -> f64 {
        let t = self.triangles;
        let p = t.point(c);
        angle_between(t.point(t.next(c)) - p, t.point(t.previous(c)) - p)
    }

    /// The triangle across the half-edge, if there is one and the half-edge is no barrier.
    #[inline]
    pub fn across(&self, c: u32, barrier: &[bool]) -> Option<u32> {
        match self.triangles.opposite(c) {
            NONE => None,
            _ if barrier[c as usize] => None,
            o => Some(o / 3),
        }
    }

    /// Centroid of a triangle.
    pub fn center(&self, t: u32) -> DVec3 {
        (3 * t..3 * t + 3).map(|c| self.triangles.point(c)).sum::<DVec3>() / 3.0
    }

    /// Whether a triangle looks along the normals of a primitive (1) or against them (−1).
    pub fn side(&self, t: u32, p: &Primitive) -> f64 {
        p.normal(self.center(t)).dot(self.normals[t as usize]).signum()
    }

    /// Twice the largest distance of a corner from the centroid: the diagonal of a box, and other than that of the bounding
    /// box the same in every position.
    pub fn extent(&self) -> f64 {
        let moment = (0..self.len() as u32).map(|t| self.center(t) * self.areas[t as usize]).sum::<DVec3>();
        let centroid = moment / self.total_area.max(f64::MIN_POSITIVE);
        let far = |c: u32| self.triangles.point(c).distance_squared(centroid);
        2.0 * (0..3 * self.len() as u32).into_par_iter().map(far).reduce(|| 0.0, f64::max).sqrt()
    }

    /// Normals of a primitive at the corners of a triangle, a little inside of it: an apex has none, and beside it rounding
    /// says which.
    pub fn normals_on(&self, t: u32, p: &Primitive) -> [DVec3; 3] {
        let center = self.center(t);
        [0, 1, 2].map(|k| p.normal(self.triangles.point(3 * t + k).lerp(center, INSIDE_SHARE)))
    }

    /// Length of the sides of equilateral triangles of the mean area.
    pub fn mean_edge(&self) -> f64 {
        (self.total_area / self.len().max(1) as f64 * 4.0 / 3f64.sqrt()).sqrt()
    }

    /// Whether the vertices of a triangle lie within a distance of a primitive and the triangle looks along its normals
    /// times `sign`: the normals at the vertices are no more than `spread` apart, its own misses their mean by no more
    /// than `turn` (radians) beyond what a chord does, which turns by half the angle between the normals at its ends, and
    /// its edges are chords: a lid on a rounded rim touches it at all corners, and along its normal.
    pub fn lies_on(&self, t: u32, p: &Primitive, sign: f64, demand: &Lies) -> bool {
        let points = self.triangles.triangle(t).map(|v| self.triangles.points()[v as usize]);
        if points.iter().any(|&x| p.distance(x).abs() > demand.distance) {
            return false;
        }
        let own = self.normals[t as usize];
        if own == DVec3::ZERO {
            return true;
        }
        let n = self.normals_on(t, p).map(|n| n * sign);
        let spread = (0..3).map(|k| angle_between(n[k], n[(k + 1) % 3])).fold(0.0, f64::max);
        (spread <= demand.spread || is_tip(&points, p))
            && angle_between(own, n[0] + n[1] + n[2]) <= 0.6 * spread + demand.turn
            && (3 * t..3 * t + 3).all(|c| self.is_chord(c, p, spread, demand.distance))
    }

    /// Whether the middle of the edge that leaves a corner is no farther off a primitive than a chord of it is where the
    /// normals turn by `spread`, beyond a distance.
    fn is_chord(&self, c: u32, p: &Primitive, spread: f64, distance: f64) -> bool {
        let (a, b) = (self.triangles.point(c), self.triangles.point(self.triangles.next(c)));
        p.distance(a.midpoint(b)).abs() <= distance + CHORD_SHARE * spread * a.distance(b)
    }

    /// Gives every triangle without a label that can be reached from a seed one; the seeds are taken in order, and each
    /// that has none yet begins the next label from `first` on. `leads` says whether the half-edge that leaves a corner may be
    /// crossed; `visit` is told every triangle and its label. Returns the first label that is not used.
    pub fn flood(
        &self,
        order: &[u32],
        label: &mut [u32],
        first: u32,
        leads: impl Fn(u32) -> bool,
        mut visit: impl FnMut(u32, u32),
    ) -> u32 {
        let mut next = first;
        let mut stack = Vec::new();
        for &seed in order {
            if label[seed as usize] != NONE {
                continue;
            }
            label[seed as usize] = next;
            stack.push(seed);
            while let Some(t) = stack.pop() {
                visit(t, next);
                for c in 3 * t..3 * t + 3 {
                    let o = self.triangles.opposite(c);
                    if o != NONE && label[o as usize / 3] == NONE && leads(c) {
                        label[o as usize / 3] = next;
                        stack.push(o / 3);
                    }
                }
            }
            next += 1;
        }
        next
    }

    /// The triangles in an order that does not depend on their numbers: by centroid.
    pub fn canonical_order(&self) -> Vec<u32> {
        let points = self.triangles.points();
        let sum = |t: u32| {
            let [a, b, c] = self.triangles.triangle(t).map(|v| points[v as usize]);
            (a + b + c).to_array().map(ordered)
        };
        // By the first coordinate alone, which most often decides; then triangles that have it in common.
        let mut order: Vec<(u64, u32)> = (0..self.len() as u32).into_par_iter().map(|t| (sum(t)[0], t)).collect();
        order.par_sort_unstable();
        order
            .par_chunk_by_mut(|a, b| a.0 == b.0)
            .filter(|run| run.len() > 1)
            .for_each(|run| run.sort_unstable_by_key(|&(_, t)| (sum(t), t)));
        order.into_iter().map(|(_, t)| t).collect()
    }

    /// Triangles of an order by area, largest first.
    pub fn by_area(&self, order: &[u32]) -> Vec<u32> {
        let key = |(&t, k): (&u32, u32)| (!ordered(self.areas[t as usize]), k);
        let mut keys: Vec<(u64, u32)> = order.iter().zip(0u32..).map(key).collect();
        keys.par_sort_unstable();
        keys.into_iter().map(|(_, k)| order[k as usize]).collect()
    }
}

/// What [`Surface::lies_on`] asks.
#[derive(Debug, Clone, Copy)]
pub struct Lies {
    /// Largest distance of a vertex.
    pub distance: f64,
    /// Noise of normals, in radians.
    pub turn: f64,
    /// Largest angle between the surface's normals at two vertices.
    pub spread: f64,
}

/// An integer that is ordered as the numbers are by [`f64::total_cmp`].
fn ordered(x: f64) -> u64 {
    let bits = x.to_bits();
    if bits >> 63 == 0 { bits | 1 << 63 } else { !bits }
}

/// The value that `share` of the numbers are below; [`None`] of no numbers. Reorders them.
pub fn quantile<T: Copy>(values: &mut [T], share: f64, order: impl Fn(&T, &T) -> Ordering) -> Option<T> {
    let last = values.len().checked_sub(1)?;
    let rank = (last as f64 * share).round() as usize;
    Some(*values.select_nth_unstable_by(rank, order).1)
}

/// See [`Surface::bend`]. In the order of the numbers, so that both half-edges get the same.
fn bend(triangles: Triangles<'_>, normals: &[DVec3], c: u32) -> f32 {
    match triangles.opposite(c) {
        NONE => std::f32::consts::PI,
        o => angle_between(normals[c.min(o) as usize / 3], normals[c.max(o) as usize / 3]) as f32,
    }
}

fn area(triangles: Triangles<'_>, t: u32) -> f64 {
    let p = triangles.triangle(t).map(|v| triangles.points()[v as usize]);
    safe_length(triangle_area_vector(p[0], p[1], p[2]))
}

/// Sum over fixed chunks: the same for any number of threads.
pub fn sum(values: &[f64]) -> f64 {
    let parts: Vec<f64> = values.par_chunks(4096).map(|chunk| chunk.iter().sum()).collect();
    parts.iter().sum()
}

/// Sharp edges and vertices.
pub struct Sharp {
    /// Per corner: the half-edge bends by more than the angle, is a border, or is irregular.
    pub edge: Vec<bool>,
    /// Per vertex: end of an edge that bends more than the angle.
    pub vertex: Vec<bool>,
}

impl Sharp {
    pub fn new(surface: &Surface<'_>, angle: f64) -> Self {
        let edge: Vec<bool> = surface.bend.iter().map(|&b| f64::from(b) > angle).collect();
        let mut vertex = vec![false; surface.triangles.points().len()];
        let t = surface.triangles;
        for (c, _) in edge.iter().enumerate().filter(|(_, sharp)| **sharp) {
            let c = c as u32;
            if t.opposite(c) != NONE {
                vertex[t.vertex(c) as usize] = true;
                vertex[t.vertex(t.next(c)) as usize] = true;
            }
        }
        Sharp { edge, vertex }
    }

    /// Number of sharp vertices of a triangle.
    pub fn count(&self, triangle: [u32; 3]) -> usize {
        triangle.iter().filter(|&&v| self.vertex[v as usize]).count()
    }
}

/// The angle, in radians, that divides sharp edges from smooth ones: the middle of the widest gap in the sorted bends
/// between 15° and 40°, where there is one of at least 4°; 25° otherwise.
pub fn sharp_angle(surface: &Surface<'_>, context: &Context) -> Result<f64> {
    context.check()?;
    let (low, high, default, least) = (15f32, 40f32, 25f64, 4f32);
    let mut bends: Vec<f32> = surface.bend.iter().map(|b| b.to_degrees()).filter(|b| (low..high).contains(b)).collect();
    bends.extend([low, high]);
    bends.sort_unstable_by(f32::total_cmp);
    let gap = |w: &[f32]| w[1] - w[0];
    // Of equal gaps the one that starts first.
    let widest = bends.windows(2).fold(None::<[f32; 2]>, |best, w| match best {
        Some(b) if b[1] - b[0] >= gap(w) => Some(b),
        _ => Some([w[0], w[1]]),
    });
    let middle = widest.filter(|w| w[1] - w[0] >= least).map(|w| f64::from(w[0] + w[1]) / 2.0);
    Ok(middle.unwrap_or(default).to_radians())
}

/// A multiple of the median bend, in radians: sharp on a surface that bends at every edge.
pub fn noisy_sharp_angle(surface: &Surface<'_>, multiple: f64) -> f64 {
    let mut bends: Vec<f32> = surface.bend.iter().copied().filter(|&b| b < std::f32::consts::PI).collect();
    multiple * quantile(&mut bends, 0.5, f32::total_cmp).map_or(0.0, f64::from)
}

/// Whether a triangle is at the tip of a cone, where normals turn by any angle.
fn is_tip(&[a, b, c]: &[DVec3; 3], p: &Primitive) -> bool {
    let Primitive::Cone { apex, .. } = *p else { return false };
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    [a, b, c].iter().any(|x| x.distance(apex) <= longest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::test_models::{grid, moved, sphere};
    use proptest::prelude::*;

    #[test]
    fn the_canonical_order_is_that_of_the_centroids() {
        // A grid has many equal coordinates, in both of its directions; the sphere has negative ones and zeros.
        for mesh in [grid(6), moved(&grid(6), |p| DVec3::new(0.0, -p.x, p.y)), sphere(2)] {
            let surface = Surface::new(&mesh, Triangles::of(&mesh).unwrap());
            let points = mesh.points();
            let key = |&t: &u32| {
                let [a, b, c] = surface.triangles.triangle(t).map(|v| points[v as usize]);
                (a + b + c).to_array()
            };
            let mut sorted: Vec<u32> = (0..surface.len() as u32).collect();
            sorted.sort_by(|a, b| {
                let (x, y) = (key(a), key(b));
                (0..3).map(|k| x[k].total_cmp(&y[k])).find(|o| o.is_ne()).unwrap_or(Ordering::Equal)
            });
            assert_eq!(surface.canonical_order(), sorted);
        }
    }

    #[test]
    fn both_sides_of_an_edge_bend_alike() {
        let mesh = sphere(2);
        let surface = Surface::new(&mesh, Triangles::of(&mesh).unwrap());
        for c in 0..3 * surface.len() as u32 {
            let o = surface.triangles.opposite(c);
            let angle = angle_between(surface.normals[c as usize / 3], surface.normals[o as usize / 3]);
            assert_eq!(surface.bend[c as usize], surface.bend[o as usize]);
            assert!((f64::from(surface.bend[c as usize]) - angle).abs() < 1e-6);
        }
    }

    proptest! {
        #[test]
        fn integers_are_ordered_as_the_numbers(a in any::<f64>(), b in any::<f64>()) {
            prop_assert_eq!(ordered(a).cmp(&ordered(b)), a.total_cmp(&b));
        }
    }
}
