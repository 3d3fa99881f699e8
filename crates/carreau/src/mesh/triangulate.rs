//! Polygons cut into triangles: a fan from the first corner, so that everybody numbers the triangles alike. Where a triangle
//! of the fan would be flat or turned, or a diagonal an edge already, ears are taken instead, the best shaped first (Meisters,
//! "Polygons have ears", 1975). A polygon that is folded however it is cut is a fan where that has a clearly smaller area: the
//! rest lies on itself. [`nearly_fans`] are fans though triangles be turned or diagonals be edges already.
//!
//! ```text
//! 3───2        3───2
//! │   │   →    │ ╱ │    an ear: three corners in a row, cut off by the diagonal between the outer two
//! 0───1        0───1
//! ```
//!
//! An ear is better the better its shape is. It is bad where it is turned against the polygon, or where another corner lies
//! within, and worse still where its diagonal is an edge already: a third triangle on an edge makes a surface something
//! else. With four corners left both triangles count, so that a quad gets its shorter diagonal if that is allowed. Between
//! equals, as in a rectangle, the cut is that of a fan from the first corner.

#[cfg(test)]
mod tests;

use super::area::{area_vector, mean_ratio, triangle_area_vector};
use super::half_edges::HalfEdges;
use super::polygons::Polygons;
use glam::DVec3;
use std::collections::HashSet;

/// Larger polygons are fanned: ears take quadratic time, or cubic where many corners are reflex.
const MOST_CORNERS: usize = 1000;
/// What a diagonal that is an edge already costs, more than any shape is worth.
const EDGE_PENALTY: f64 = 4.0;
/// What another corner within costs.
const INSIDE_PENALTY: f64 = 2.0;
/// An ear must be better by more than this to be preferred to an earlier one: rounding shall not choose.
const MARGIN: f64 = 1e-9;

/// Cosine of the angle to a polygon that is nearly plane which its ears have at most: they are no other surface than a fan then.
const PLANE: f64 = 0.9;
/// Fans of folded polygons are smaller than this share of the ears that they are preferred to.
const SMALLER: f64 = 0.8;

/// Triangles, the corner of the polygons that each of their corners is, and the polygon of each.
pub struct Cut {
    pub triangles: Vec<[u32; 3]>,
    pub corners: Vec<u32>,
    pub parent: Vec<u32>,
    /// Vertices after those there were, each in the middle of two; they count as the polygon's first corner.
    pub middles: Vec<[u32; 2]>,
}

/// Which fans will do.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Fans {
    /// Those without a turned triangle, and without a diagonal that is an edge already.
    Sound,
    /// Those without a flat triangle. Where a diagonal is an edge already it is divided in its middle, if ears of the polygon
    /// would be another surface.
    Folded,
}

/// Cuts all polygons, in their order.
pub fn triangulate(points: &[DVec3], faces: &Polygons) -> Cut {
    cut(points, faces, Fans::Sound)
}

/// Cuts all polygons, with fans where these have no flat triangle, though one be turned. Two polygons that fold onto each other
/// may have the same diagonal, which would be an edge of four triangles. Where one of them is not plane it is cut as its fan is,
/// and its diagonal in the middle: the surface is the same, but there are two edges.
///
/// ```text
/// d───────c        d───────c
/// │     ╱ │        │ ╲   ╱ │
/// │   ╱   │   →    │   m   │     m: the middle of the diagonal a c
/// │ ╱     │        │ ╱   ╲ │
/// a───────b        a───────b
/// ```
pub fn nearly_fans(points: &[DVec3], faces: &Polygons) -> Cut {
    cut(points, faces, Fans::Folded)
}

/// Cuts polygons into fans where these will do, and the others into ears.
fn cut(points: &[DVec3], faces: &Polygons, fans: Fans) -> Cut {
    let mut cutter = Cutter::new(points, faces);
    for (f, face) in faces.iter().enumerate() {
        cutter.add(f as u32, face, faces.offsets()[f], fans);
    }
    cutter.cut
}

/// Cuts all polygons from their first corners, whatever becomes of the triangles.
pub fn fans(points: &[DVec3], faces: &Polygons) -> Cut {
    let mut cutter = Cutter::new(points, faces);
    for (f, face) in faces.iter().enumerate() {
        cutter.push(f as u32, face, faces.offsets()[f], fan(face));
    }
    cutter.cut
}

/// The triangles of a fan, as positions in the polygon.
fn fan(face: &[u32]) -> impl Iterator<Item = [u32; 3]> + Clone + use<> {
    (1..(face.len() as u32).saturating_sub(1)).map(|k| [0, k, k + 1])
}

struct Cutter<'a> {
    points: &'a [DVec3],
    edges: HalfEdges,
    /// Diagonals so far, the smaller vertex first.
    diagonals: HashSet<[u32; 2]>,
    cut: Cut,
    /// What is left of a polygon: positions in it.
    rest: Vec<u32>,
    /// How good the ear at each of them is.
    scores: Vec<f64>,
}

impl<'a> Cutter<'a> {
    fn new(points: &'a [DVec3], faces: &Polygons) -> Self {
        Self {
            points,
            edges: HalfEdges::new(faces, points.len()),
            diagonals: HashSet::new(),
            cut: Cut { triangles: Vec::new(), corners: Vec::new(), parent: Vec::new(), middles: Vec::new() },
            rest: Vec::new(),
            scores: Vec::new(),
        }
    }

    fn add(&mut self, parent: u32, face: &[u32], first: u32, fans: Fans) {
        let fan = fan(face);
        if face.len() > MOST_CORNERS {
            self.push(parent, face, first, fan);
            return;
        }
        let normal = area_vector(self.points, face);
        let is_fine = |triangle: [u32; 3]| match (fans, self.shape(face, normal, triangle)) {
            (Fans::Sound, shape) => shape > 0.0,
            (Fans::Folded, shape) => shape.abs() > MARGIN,
        };
        let fan_is_new = fan.clone().skip(1).all(|[_, k, _]| self.is_new(face[0], face[k as usize]));
        let fan_is_fine = fan.clone().all(is_fine);
        if fan_is_fine && fan_is_new {
            self.push(parent, face, first, fan);
            return;
        }
        let ears = self.ears(face, normal);
        if fan_is_fine && fans == Fans::Folded && !ears.iter().all(|&ear| self.is_along(face, normal, ear)) {
            self.push_divided(parent, face, first);
            return;
        }
        let is_turned = |triangle: &[u32; 3]| self.shape(face, normal, *triangle) < -MARGIN;
        let area = |t: [u32; 3]| {
            let [a, b, c] = t.map(|k| self.points[face[k as usize] as usize]);
            triangle_area_vector(a, b, c).length()
        };
        let fan_is_smaller =
            || fan.clone().map(area).sum::<f64>() < SMALLER * ears.iter().copied().map(area).sum::<f64>();
        if fan_is_new && ears.iter().any(is_turned) && fan_is_smaller() {
            self.push(parent, face, first, fan);
        } else {
            self.push(parent, face, first, ears.into_iter());
        }
    }

    /// Adds the triangles of a polygon, given as positions in it.
    fn push(&mut self, parent: u32, face: &[u32], first: u32, triangles: impl Iterator<Item = [u32; 3]>) {
        for triangle in triangles {
            for [a, b] in [[0, 1], [1, 2], [2, 0]].map(|side| side.map(|k| triangle[k])) {
                // A side of the polygon is no diagonal.
                if b != (a + 1) % face.len() as u32 {
                    self.diagonals.insert(sorted(face[a as usize], face[b as usize]));
                }
            }
            self.push_triangle(parent, triangle.map(|k| (face[k as usize], first + k)));
        }
    }

    /// Adds a fan whose diagonals are divided in their middles where they are edges already.
    fn push_divided(&mut self, parent: u32, face: &[u32], first: u32) {
        let at = |k: u32| (face[k as usize], first + k);
        let mut before = None;
        for [apex, left, right] in fan(face) {
            let is_diagonal = right + 1 < face.len() as u32;
            let after = is_diagonal.then(|| self.middle(face[0], face[right as usize])).flatten().map(|m| (m, first));
            let near = [before.unwrap_or(at(left)), after.unwrap_or(at(right))];
            self.push_triangle(parent, [at(apex), near[0], near[1]]);
            if let Some(before) = before {
                self.push_triangle(parent, [before, at(left), at(right)]);
            }
            if let Some(after) = after {
                self.push_triangle(parent, [near[0], at(right), after]);
            }
            before = after;
        }
    }

    /// A new vertex in the middle of a diagonal, if that is an edge already.
    fn middle(&mut self, a: u32, b: u32) -> Option<u32> {
        if self.is_new(a, b) {
            self.diagonals.insert(sorted(a, b));
            return None;
        }
        self.cut.middles.push([a, b]);
        Some((self.points.len() + self.cut.middles.len() - 1) as u32)
    }

    /// Adds a triangle of vertices and the corners that they are.
    fn push_triangle(&mut self, parent: u32, corners: [(u32, u32); 3]) {
        self.cut.triangles.push(corners.map(|c| c.0));
        self.cut.corners.extend(corners.map(|c| c.1));
        self.cut.parent.push(parent);
    }

    /// A polygon cut ear by ear.
    fn ears(&mut self, face: &[u32], normal: DVec3) -> Vec<[u32; 3]> {
        let mut ears = Vec::new();
        self.rest.clear();
        self.rest.extend(0..face.len() as u32);
        self.scores.clear();
        self.scores.resize(if face.len() > 3 { face.len() } else { 0 }, 0.0);
        for k in 0..self.scores.len() {
            self.scores[k] = self.score(face, normal, k);
        }
        while self.rest.len() > 3 {
            let n = self.rest.len();
            // From the second corner on, as a fan has it.
            let best =
                (1..=n).map(|k| k % n).reduce(|a, b| if self.scores[b] > self.scores[a] + MARGIN { b } else { a });
            let Some(k) = best else { break };
            ears.push(self.ear(k));
            self.rest.remove(k);
            self.scores.remove(k);
            let n = n - 1;
            // With four corners left the ears are judged anew, by both triangles.
            let changed = if n == 4 { 0..n } else { 0..2 };
            for j in changed.map(|j| if n == 4 { j } else { (k + n - 1 + j) % n }) {
                self.scores[j] = self.score(face, normal, j);
            }
        }
        ears.push([self.rest[0], self.rest[1], self.rest[2]]);
        ears
    }

    /// Whether a diagonal is neither an edge nor a diagonal of an earlier polygon.
    fn is_new(&self, a: u32, b: u32) -> bool {
        a != b && self.edges.find(a, b).is_none() && !self.diagonals.contains(&sorted(a, b))
    }

    /// The ear at the `k`-th of the corners left, in ascending order for those in the midst.
    fn ear(&self, k: usize) -> [u32; 3] {
        let n = self.rest.len();
        [self.rest[(k + n - 1) % n], self.rest[k], self.rest[(k + 1) % n]]
    }

    fn score(&self, face: &[u32], normal: DVec3, k: usize) -> f64 {
        let ear = self.ear(k);
        let mut score = self.shape(face, normal, ear);
        if self.rest.len() == 4 {
            score = score.min(self.shape(face, normal, self.ear((k + 2) % 4)));
        }
        let [a, b] = [ear[0], ear[2]].map(|k| face[k as usize]);
        if !self.is_new(a, b) {
            score -= EDGE_PENALTY;
        }
        if self.rest.len() > 4 && self.rest.iter().any(|&other| self.is_inside(face, normal, ear, other)) {
            score -= INSIDE_PENALTY;
        }
        score
    }

    /// The shape of a triangle of the polygon, negative where it is turned.
    fn shape(&self, face: &[u32], normal: DVec3, triangle: [u32; 3]) -> f64 {
        let [a, b, c] = triangle.map(|k| self.points[face[k as usize] as usize]);
        let turned = triangle_area_vector(a, b, c).dot(normal) < 0.0;
        if turned { -mean_ratio(a, b, c) } else { mean_ratio(a, b, c) }
    }

    /// Whether a triangle of the polygon is about parallel to it.
    fn is_along(&self, face: &[u32], normal: DVec3, triangle: [u32; 3]) -> bool {
        let [a, b, c] = triangle.map(|k| self.points[face[k as usize] as usize]);
        let area = triangle_area_vector(a, b, c);
        area.dot(normal) >= PLANE * area.length() * normal.length()
    }

    /// Whether a corner lies within an ear or on its rim, seen along the normal.
    fn is_inside(&self, face: &[u32], normal: DVec3, ear: [u32; 3], other: u32) -> bool {
        let vertex = face[other as usize];
        if ear.iter().any(|&k| face[k as usize] == vertex) {
            return false;
        }
        let p = self.points[vertex as usize];
        let [a, b, c] = ear.map(|k| self.points[face[k as usize] as usize]);
        [[a, b], [b, c], [c, a]].iter().all(|&[a, b]| triangle_area_vector(a, b, p).dot(normal) >= 0.0)
    }
}

fn sorted(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// Splits a quad along its shorter diagonal; on a tie along that of its first corner.
pub(crate) fn split_quad(points: &[DVec3], [a, b, c, d]: [u32; 4]) -> [[u32; 3]; 2] {
    let length = |p: u32, q: u32| points[p as usize].distance(points[q as usize]);
    if length(a, c) <= length(b, d) { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }
}
