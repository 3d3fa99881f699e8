//! A patch on its way to the plane: its triangles with vertices of their own, so that a vertex that the patch has on both
//! sides of a cut is two.

use super::sheet::Sheet;
use crate::error::Result;
use crate::mesh::{DisjointSets, NONE};
use crate::numeric::sparse::Matrix;
use glam::{DVec2, DVec3};
use rustc_hash::FxHashMap;

/// Cotangents in needles.
const MOST_COTANGENT: f64 = 1e3;
/// Less area, over the square of an edge, is a triangle along an outline.
const TURNED: f64 = 1e-9;

/// The triangles of a patch.
pub struct Chart<'a> {
    sheet: &'a Sheet,
    triangles: &'a [u32],
    /// The triangle's place in the list.
    row: FxHashMap<u32, u32>,
    /// Vertices of the chart at the corners of every triangle.
    corners: Vec<[u32; 3]>,
    count: usize,
}

impl<'a> Chart<'a> {
    /// Corners are the same vertex where no wall is between them.
    pub fn new(sheet: &'a Sheet, triangles: &'a [u32]) -> Self {
        let row: FxHashMap<u32, u32> = triangles.iter().copied().zip(0u32..).collect();
        let mut sets = DisjointSets::new(3 * triangles.len());
        let local = |h: u32| row.get(&(h / 3)).map(|r| 3 * r + h % 3);
        for h in triangles.iter().flat_map(|t| 3 * t..3 * t + 3).filter(|&h| !sheet.is_wall(h)) {
            let o = sheet.opposite[h as usize];
            if o == NONE {
                continue;
            }
            for (a, b) in [(h, Sheet::next(o)), (Sheet::next(h), o)] {
                if let (Some(a), Some(b)) = (local(a), local(b)) {
                    sets.union(a, b);
                }
            }
        }
        let (labels, count) = sets.labels();
        let corners = labels.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect();
        Chart { sheet, triangles, row, corners, count }
    }

    /// Number of vertices.
    pub fn len(&self) -> usize {
        self.count
    }

    /// The vertex that a half-edge leaves.
    pub fn tail(&self, h: u32) -> Option<usize> {
        self.row.get(&(h / 3)).map(|&r| self.corners[r as usize][h as usize % 3] as usize)
    }

    /// Triangles of the chart with their triangles in space.
    pub fn faces(&self) -> impl Iterator<Item = ([u32; 3], [DVec3; 3])> + '_ {
        let of = |t: u32| self.sheet.triangles[t as usize].map(|v| self.sheet.points[v as usize]);
        self.corners.iter().copied().zip(self.triangles.iter().map(move |&t| of(t)))
    }

    /// Places for all vertices: those that are given, the others at the weighted mean of their neighbours (Tutte; positive
    /// weights, so that nothing folds where the outline is convex). `None` where a part has no given place.
    pub fn spread(&self, given: &[Option<DVec2>]) -> Result<Option<Vec<DVec2>>> {
        self.solved(given, |points, k| points[k].distance(points[(k + 1) % 3]).max(f64::MIN_POSITIVE).recip())
    }

    /// The same by a harmonic map (cotangents): what is flat stays as it is, however its triangles are graded. `None` where
    /// that turns a triangle over, too.
    pub fn harmonic(&self, given: &[Option<DVec2>]) -> Option<Vec<DVec2>> {
        self.solved(given, cotangent).ok().flatten().filter(|at| !self.turns_over(at))
    }

    /// Whether a triangle looks the other way in the plane; those along an outline may be flat.
    fn turns_over(&self, at: &[DVec2]) -> bool {
        self.corners.iter().any(|vertices| {
            let [p, q, r] = vertices.map(|v| at[v as usize]);
            !((q - p).perp_dot(r - p) > -TURNED * (q - p).length().max((r - p).length()).powi(2))
        })
    }

    /// Places for all vertices by weights for the edges of triangles in space, from corner k to the next.
    fn solved(&self, given: &[Option<DVec2>], weight: impl Fn([DVec3; 3], usize) -> f64) -> Result<Option<Vec<DVec2>>> {
        let mut number = vec![NONE; self.count];
        let mut inner = 0u32;
        for (n, _) in number.iter_mut().zip(given).filter(|(_, g)| g.is_none()) {
            *n = inner;
            inner += 1;
        }
        if inner == 0 {
            return Ok(given.iter().copied().collect());
        }
        let mut matrix = Matrix::new(inner as usize);
        let mut rhs = [vec![0.0; inner as usize], vec![0.0; inner as usize]];
        for (vertices, points) in self.faces() {
            for k in 0..3 {
                let [a, b] = [k, (k + 1) % 3];
                let weight = weight(points, k);
                for (v, other) in
                    [(vertices[a] as usize, vertices[b] as usize), (vertices[b] as usize, vertices[a] as usize)]
                {
                    let (i, j) = (number[v], number[other]);
                    if i == NONE {
                        continue;
                    }
                    matrix.add(i, i, weight);
                    match given[other] {
                        Some(p) => {
                            rhs[0][i as usize] += weight * p.x;
                            rhs[1][i as usize] += weight * p.y;
                        }
                        None if j < i => matrix.add(i, j, -weight),
                        None => {}
                    }
                }
            }
        }
        let factor = matrix.factor(&mut None)?;
        let (x, y) = (factor.solve(&rhs[0])?, factor.solve(&rhs[1])?);
        let place = |(v, given): (usize, &Option<DVec2>)| {
            given.unwrap_or_else(|| DVec2::new(x[number[v] as usize], y[number[v] as usize]))
        };
        let all: Vec<DVec2> = given.iter().enumerate().map(place).collect();
        Ok(all.iter().all(|p| p.is_finite()).then_some(all))
    }

    /// The chart in the plane with as little change of angles as possible: least squares conformal maps (Lévy et al. 2002),
    /// as Dirichlet energy less area. What can be unrolled is, without any distortion. `None` where a triangle turns
    /// over, or all is in one place.
    pub fn unrolled(&self) -> Result<Option<Vec<DVec2>>> {
        let mut place = vec![DVec3::ZERO; self.count];
        for (vertices, points) in self.faces() {
            vertices.iter().zip(points).for_each(|(&v, p)| place[v as usize] = p);
        }
        // Two vertices far from each other are held.
        let farthest = |from: usize| {
            (0..self.count).fold(from, |best, v| {
                if place[v].distance_squared(place[from]) > place[best].distance_squared(place[from]) {
                    v
                } else {
                    best
                }
            })
        };
        let first = farthest(0);
        let last = farthest(first);
        if first == last {
            return Ok(None);
        }
        let held = |v: usize| match v {
            _ if v == first => Some(DVec2::ZERO),
            _ if v == last => Some(DVec2::new(place[first].distance(place[last]), 0.0)),
            _ => None,
        };
        let mut number = vec![NONE; self.count];
        let free = (0..self.count).filter(|&v| held(v).is_none());
        free.zip(0u32..).for_each(|(v, n)| number[v] = n);
        let unknowns = 2 * self.count.saturating_sub(2);
        let mut matrix = Matrix::new(unknowns);
        let mut rhs = vec![0.0; unknowns];
        // Coordinate i of vertex a with coordinate j of vertex b, once for both orders.
        let mut add = |(a, i): (usize, usize), (b, j): (usize, usize), value: f64| {
            let unknown = |v: usize, i: usize| (number[v] != NONE).then(|| 2 * number[v] + i as u32);
            match (unknown(a, i), unknown(b, j)) {
                (Some(x), Some(y)) => matrix.add(x.max(y), x.min(y), value),
                (Some(x), None) => rhs[x as usize] -= value * held(b).map_or(0.0, |p| p[j]),
                (None, Some(y)) => rhs[y as usize] -= value * held(a).map_or(0.0, |p| p[i]),
                (None, None) => {}
            }
        };
        for (vertices, points) in self.faces() {
            for k in 0..3 {
                let [a, b] = [k, (k + 1) % 3].map(|k| vertices[k] as usize);
                let weight = 0.5 * cotangent(points, k);
                for i in 0..2 {
                    add((a, i), (a, i), weight);
                    add((b, i), (b, i), weight);
                    add((a, i), (b, i), -weight);
                }
                add((a, 0), (b, 1), -0.5);
                add((b, 0), (a, 1), 0.5);
            }
        }
        let solution = matrix.factor(&mut None)?.solve(&rhs)?;
        let at = |v: usize| {
            held(v).unwrap_or_else(|| {
                let k = 2 * number[v] as usize;
                DVec2::new(solution[k], solution[k + 1])
            })
        };
        let flat: Vec<DVec2> = (0..self.count).map(at).collect();
        let (mut area, mut flat_area, mut turned) = (0.0, 0.0, false);
        for (vertices, [a, b, c]) in self.faces() {
            let [p, q, r] = vertices.map(|v| flat[v as usize]);
            let own = 0.5 * (q - p).perp_dot(r - p);
            turned |= !(own > 0.0);
            flat_area += own;
            area += 0.5 * (b - a).cross(c - a).length();
        }
        let scale = (area / flat_area).sqrt();
        Ok((!turned && scale.is_finite()).then(|| flat.into_iter().map(|p| p * scale).collect()))
    }

    /// The point of the surface over a point of the plane; over no triangle, the nearest place of the nearest one.
    pub fn above(&self, at: &[DVec2], q: DVec2) -> Option<DVec3> {
        let mut best: (f64, Option<DVec3>) = (f64::NEG_INFINITY, None);
        for (vertices, points) in self.faces() {
            let w = weights(vertices.map(|v| at[v as usize]), q);
            let inside = w[0].min(w[1]).min(w[2]);
            if inside > best.0 && inside.is_finite() {
                let w = w.map(|w| w.max(0.0));
                let sum = w[0] + w[1] + w[2];
                best = (inside, Some((0..3).map(|k| points[k] * (w[k] / sum)).sum()));
            }
        }
        best.1
    }

    /// The points of the surface over whole coordinates inside a rectangle, row by row.
    pub fn read_off(&self, at: &[DVec2], m: usize, n: usize) -> Vec<Option<DVec3>> {
        /// How far outside a triangle counts as inside.
        const SLACK: f64 = 1e-9;
        let mut best: Vec<(f64, Option<DVec3>)> = vec![(-1e-3, None); (m + 1) * (n + 1)];
        for (vertices, points) in self.faces() {
            let p = vertices.map(|v| at[v as usize]);
            let area = (p[1] - p[0]).perp_dot(p[2] - p[0]);
            if area.abs() < 1e-14 {
                continue;
            }
            let low = p[0].min(p[1]).min(p[2]).floor().max(DVec2::ONE);
            let high = p[0].max(p[1]).max(p[2]).ceil().min(DVec2::new(m as f64 - 1.0, n as f64 - 1.0));
            for j in low.y as usize..=high.y.max(0.0) as usize {
                for i in low.x as usize..=high.x.max(0.0) as usize {
                    let w = weights(p, DVec2::new(i as f64, j as f64));
                    let inside = w[0].min(w[1]).min(w[2]).min(SLACK);
                    let of = &mut best[j * (m + 1) + i];
                    if inside > of.0 {
                        *of = (inside, Some((0..3).map(|k| points[k] * w[k]).sum()));
                    }
                }
            }
        }
        best.into_iter().map(|b| b.1).collect()
    }
}

/// The cotangent opposite to the edge from corner k of a triangle to the next.
fn cotangent(points: [DVec3; 3], k: usize) -> f64 {
    let [x, y] = [k, (k + 1) % 3].map(|i| points[i] - points[(k + 2) % 3]);
    (x.dot(y) / x.cross(y).length()).clamp(-MOST_COTANGENT, MOST_COTANGENT)
}

/// Barycentric coordinates.
fn weights(p: [DVec2; 3], q: DVec2) -> [f64; 3] {
    let area = (p[1] - p[0]).perp_dot(p[2] - p[0]);
    [0, 1, 2].map(|k| (p[(k + 1) % 3] - q).perp_dot(p[(k + 2) % 3] - q) / area)
}

#[cfg(test)]
mod tests {
    use super::super::sheet::Wall;
    use super::*;

    /// Two triangles with the same first and last corner.
    fn pair(points: [DVec3; 4]) -> Sheet {
        Sheet {
            points: points.to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            opposite: vec![NONE, NONE, 3, 2, NONE, NONE],
            turn: vec![0; 6],
            wall: vec![Wall::None; 6],
            branch: vec![0; 6],
            frame: vec![[DVec3::X, DVec3::Y]; 2],
            region: vec![0; 2],
            out: vec![0, 1, 2, 5],
            length: 1.0,
            divided: FxHashMap::default(),
        }
    }

    #[test]
    fn what_is_folded_is_unrolled_but_for_what_is_in_one_place() {
        let corners = [DVec3::ZERO, DVec3::X * 3.0, DVec3::X * 3.0 + DVec3::Y, DVec3::Z];
        let sheet = pair(corners);
        let chart = Chart::new(&sheet, &[0, 1]);
        let flat = chart.unrolled().unwrap().unwrap();
        for (vertices, points) in chart.faces() {
            for k in 0..3 {
                let length = flat[vertices[k] as usize].distance(flat[vertices[(k + 1) % 3] as usize]);
                assert!((length - points[k].distance(points[(k + 1) % 3])).abs() < 1e-9);
            }
        }
        let sheet = pair([DVec3::ONE; 4]);
        assert_eq!(Chart::new(&sheet, &[0, 1]).unrolled().unwrap(), None);
    }
}
