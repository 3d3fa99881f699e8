//! Slivers are taken out before anything is looked at: a cap has a vertex in the middle of a chord, which is on no surface of the
//! part, and parts the triangles beside it. Edges of slivers are collapsed where that moves the surface by no more than the
//! files of careless kernels are exact:
//!
//! ```text
//!            c                     c
//!          ╱ │ ╲                 ╱   ╲
//!        ╱   │   ╲             ╱       ╲         the cap (a, b, m) and the half (a, m, c) are gone,
//!       a────m────b     →     a─────────b        (m, b, c) has become (a, b, c)
//!        ╲       ╱             ╲       ╱
//!          ╲   ╱                 ╲   ╱
//!            d                     d
//! ```
//!
//! The regions are those of the healed mesh; what was taken out joins the neighbour that it bends least towards.

use super::slivers::{self, SLIVER_ROUNDS};
use super::surface::Surface;
use crate::context::Context;
use crate::error::Result;
use crate::geometry::closest::closest_on_triangle;
use crate::mesh::{EditMesh, Keep, NONE, SurfaceMesh, Triangles, next, previous};
use glam::DVec3;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Radians: a collapse turns no triangle by more, because a vertex that is off by a tenth of a sliver's height turns
/// one that is hardly higher than a sliver by 0.1.
const COLLAPSE_TURN: f64 = 0.2;

/// A mesh without the slivers of another one.
pub struct Healed {
    pub mesh: SurfaceMesh,
    /// The triangle that each one was.
    source: Vec<u32>,
}

/// Takes out slivers; `None` where there are none that can be.
pub fn heal(mesh: &SurfaceMesh, triangles: Triangles<'_>, context: &Context) -> Result<Option<Healed>> {
    let height = slivers::height(triangles.points());
    let slivers: Vec<u32> = (0..triangles.len() as u32).filter(|&t| is_sliver(corners(triangles, t), height)).collect();
    if slivers.is_empty() {
        return Ok(None);
    }
    let Some(edit) = EditMesh::new(mesh) else { return Ok(None) };
    let mut healer = Healer { edit, height };
    for _ in 0..SLIVER_ROUNDS {
        let mut changed = false;
        for (step, &t) in slivers.iter().enumerate() {
            context.check_every(step)?;
            changed |= healer.remove(t);
        }
        if !changed {
            break;
        }
    }
    if healer.edit.triangle_count() == triangles.len() || healer.edit.triangle_count() == 0 {
        return Ok(None);
    }
    // Vertices keep their numbers, those without triangles too; copies at irregular edges become one again.
    let edit = &healer.edit;
    let source: Vec<u32> = (0..edit.triangle_slots()).filter(|&t| edit.is_triangle(t)).collect();
    let faces: Vec<[u32; 3]> = source.iter().map(|&t| edit.triangle(t).map(|v| edit.origin[v as usize])).collect();
    let mesh = SurfaceMesh::from_triangles(triangles.points().to_vec(), &faces)?;
    Ok(Some(Healed { mesh, source }))
}

impl Healed {
    /// What was said of every triangle, of those that are left.
    pub fn project<T: Copy>(&self, of_all: &[T]) -> Vec<T> {
        self.source.iter().map(|&t| of_all[t as usize]).collect()
    }

    /// The labels of all triangles from those of the healed mesh: from the triangles that are left they go over the smallest
    /// bends first.
    pub fn restore(&self, surface: &Surface<'_>, labels: &[u32]) -> Vec<u32> {
        let mut label = vec![NONE; surface.len()];
        let mut queue = BinaryHeap::new();
        let offer = |label: &[u32], t: u32, queue: &mut BinaryHeap<_>| {
            for c in 3 * t..3 * t + 3 {
                let o = surface.triangles.opposite(c);
                if o != NONE && label[o as usize / 3] == NONE {
                    // Bends are not negative, so their bits are in their order.
                    queue.push(Reverse((surface.bend[c as usize].to_bits(), o / 3, label[t as usize])));
                }
            }
        };
        self.source.iter().zip(labels).for_each(|(&t, &l)| label[t as usize] = l);
        self.source.iter().for_each(|&t| offer(&label, t, &mut queue));
        while let Some(Reverse((_, t, l))) = queue.pop() {
            if label[t as usize] == NONE {
                label[t as usize] = l;
                offer(&label, t, &mut queue);
            }
        }
        // Pieces that consist of slivers alone.
        let free = labels.iter().max().map_or(0, |&l| l + 1);
        let order: Vec<u32> = (0..surface.len() as u32).collect();
        surface.flood(&order, &mut label, free, |_| true, |_, _| ());
        label
    }
}

fn corners(triangles: Triangles<'_>, t: u32) -> [DVec3; 3] {
    [0, 1, 2].map(|k| triangles.point(3 * t + k))
}

fn area_vector([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

fn is_sliver(p: [DVec3; 3], height: f64) -> bool {
    let longest = (0..3).map(|k| p[k].distance(p[(k + 1) % 3])).fold(0.0, f64::max);
    area_vector(p).length() < height * longest
}

struct Healer {
    edit: EditMesh,
    /// Below this height triangles are slivers, and vertices move no farther from the surface.
    height: f64,
}

impl Healer {
    /// Collapses an edge of a sliver that may be, of those one whose vertex with the fewest neighbours goes, then the shortest;
    /// returns whether there was one.
    fn remove(&mut self, t: u32) -> bool {
        if !self.edit.is_triangle(t) || !is_sliver(self.edit.positions(t), self.height) {
            return false;
        }
        let edit = &self.edit;
        let mut ways: Vec<(usize, u64, u32, Keep)> = Vec::with_capacity(6);
        for h in 3 * t..3 * t + 3 {
            let length = self.point(edit.vertex(h)).distance(self.point(edit.head(h)));
            for keep in [Keep::Tail, Keep::Head] {
                ways.push((edit.valence(edit.gone_and_kept(h, keep).0), length.to_bits(), h, keep));
            }
        }
        ways.sort_by_key(|&(valence, length, h, keep)| (valence, length, h, keep == Keep::Head));
        let Some(&(_, _, h, keep)) = ways.iter().find(|&&(_, _, h, keep)| self.may(h, keep)) else { return false };
        self.edit.collapse(h, keep);
        true
    }

    fn point(&self, v: u32) -> DVec3 {
        self.edit.points[v as usize]
    }

    /// Whether a collapse leaves the surface as it is.
    fn may(&self, h: u32, keep: Keep) -> bool {
        let edit = &self.edit;
        let (gone, kept) = edit.gone_and_kept(h, keep);
        if edit.is_copy(gone)
            || edit.is_copy(kept)
            || edit.check_collapse(h).is_err()
            || !self.keeps_border(h, gone, kept)
        {
            return false;
        }
        let (origin, target) = (self.point(gone), self.point(kept));
        // Where the triangles around look: slivers do not say.
        let all = || edit.around(gone).map(|h| edit.positions(h / 3));
        let normals: Vec<DVec3> =
            all().filter(|&p| !is_sliver(p, self.height)).map(|p| area_vector(p).normalize_or_zero()).collect();
        let mut nearest = origin.distance(target);
        for h in edit.around(gone).filter(|&h| ![edit.head(h), edit.apex(h)].contains(&kept)) {
            let before = edit.positions(h / 3);
            let after = [target, self.point(edit.head(h)), self.point(edit.apex(h))];
            nearest = nearest.min(origin.distance(closest_on_triangle(origin, after)));
            let along = |n: DVec3| area_vector(after).normalize_or_zero().dot(n) >= COLLAPSE_TURN.cos();
            let same = if is_sliver(before, self.height) {
                is_sliver(after, self.height) || normals.iter().any(|&n| along(n))
            } else {
                !is_sliver(after, self.height) && along(area_vector(before).normalize_or_zero())
            };
            if !same {
                return false;
            }
        }
        nearest <= self.height
    }

    /// Whether the vertex that goes is on no border, or on the straight border that it is moved along.
    fn keeps_border(&self, h: u32, gone: u32, kept: u32) -> bool {
        let edit = &self.edit;
        if !edit.is_border(gone) {
            return true;
        }
        if edit.opposite(h) != NONE {
            return false;
        }
        // The ends of the two border edges of the vertex: the first half-edge around it has no opposite, nor has the last's previous.
        let Some(last) = edit.around(gone).last() else { return false };
        let ends = [edit.around(gone).next().map_or(NONE, |h| edit.head(h)), edit.vertex(previous(last))];
        let other = if ends[0] == kept { ends[1] } else { ends[0] };
        let (p, a, b) = (self.point(gone), self.point(kept), self.point(other));
        let nearest = closest_on_triangle(p, [a, b, b]);
        edit.vertex(next(h)) != other && nearest.distance(p) <= self.height
    }
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use crate::mesh::test_models::{grid, sphere};

    /// A cap with its vertex on every `step`-th edge, in the middle part or next to an end, and off by a tenth of a sliver's
    /// height.
    pub fn with_slivers(mesh: &SurfaceMesh, step: usize) -> SurfaceMesh {
        let t = Triangles::of(mesh).unwrap();
        let mut points = mesh.points().to_vec();
        let mut faces: Vec<[u32; 3]> = (0..t.len() as u32).map(|k| t.triangle(k)).collect();
        let mut used = vec![false; t.len()];
        let off = 0.1 * slivers::height(mesh.points());
        for c in (0..3 * t.len() as u32).step_by(step) {
            if std::mem::replace(&mut used[c as usize / 3], true) {
                continue;
            }
            let (a, b, d) = (t.vertex(c), t.vertex(t.next(c)), t.vertex(t.previous(c)));
            let m = points.len() as u32;
            let shift = DVec3::new(1.0, -1.0, 1.0) * off * f64::from(m % 3);
            let along = if m.is_multiple_of(4) { 1e-7 } else { 0.37 };
            points.push(t.point(c).lerp(t.point(t.next(c)), along) + shift);
            faces[c as usize / 3] = [a, m, d];
            faces.extend([[m, b, d], [a, b, m]]);
        }
        SurfaceMesh::from_triangles(points, &faces).unwrap()
    }

    #[test]
    fn slivers_are_taken_out_and_nothing_else() {
        for mesh in [sphere(3), grid(8).triangulated().unwrap()] {
            assert!(heal(&mesh, Triangles::of(&mesh).unwrap(), &Context::new()).unwrap().is_none());
            let spoiled = with_slivers(&mesh, 7);
            assert!(spoiled.face_count() > mesh.face_count() + 20);
            let triangles = Triangles::of(&spoiled).unwrap();
            let healed = heal(&spoiled, triangles, &Context::new()).unwrap().unwrap();
            assert_eq!(healed.mesh.face_count(), mesh.face_count());
            let set = |mesh: &SurfaceMesh| -> std::collections::BTreeSet<[u32; 3]> {
                let t = Triangles::of(mesh).unwrap();
                let from_least = |k: u32| {
                    let mut f = t.triangle(k);
                    let first = (0..3).min_by_key(|&k| f[k]).unwrap();
                    f.rotate_left(first);
                    f
                };
                (0..t.len() as u32).map(from_least).collect()
            };
            assert_eq!(set(&healed.mesh), set(&mesh));
            if mesh.face_count() == grid(8).triangulated().unwrap().face_count() {
                // All neighbours are in one plane: none is nearer than the other.
                continue;
            }
            // Every triangle, the caps too, gets the label of the triangle that it lies in.
            let surface = Surface::new(&spoiled, triangles);
            let labels: Vec<u32> = (0..healed.mesh.face_count() as u32).collect();
            let all = healed.restore(&surface, &labels);
            let inside = Surface::new(&healed.mesh, Triangles::of(&healed.mesh).unwrap());
            for (t, &l) in (0..).zip(&all) {
                let center = surface.center(t);
                let flat = closest_on_triangle(center, corners(inside.triangles, l)).distance(center);
                assert!(flat <= slivers::height(spoiled.points()), "triangle {t} is {flat} off its own");
            }
        }
    }
}
