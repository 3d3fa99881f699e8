//! The seamless map: Σ area ‖Ĵ − 1‖² least over the disc, with Ĵ the derivative of the map where the frame of the field is the
//! unit, where every edge of the cut is the same on both of its sides but for right angles, and edges on features run along one
//! coordinate. Triangles that come out turned over are turned back (`untangle`).
//!
//! Each solve is symmetric, with multipliers: the constraints, dependent ones among them, come into the matrix with a large
//! weight, and a few more solves with the same factor take what is left of them to rounding.

use super::cut::Cut;
use super::framed::{Framed, next, turned};
use super::tuning::{
    ANGLE_MISMATCH, MULTIPLIER_SOLVES, SEAM_MISMATCH, SEAM_STIFFNESS, STIFFER_FACTOR, STIFFER_ROUNDS, TURNED_AREA,
};
use super::untangle::{Derivative, untangle};
use crate::context::Context;
use crate::error::Result;
use crate::mesh::NONE;
use crate::numeric::sparse::{Matrix, Plan};
use glam::{DMat2, DVec2};
use std::f64::consts::FRAC_PI_2;

/// The map: coordinates of every corner, in edges of quads.
pub struct Map {
    pub uv: Vec<DVec2>,
    /// Turns across half-edges.
    pub turn: Vec<i32>,
}

type Row = Vec<(u32, f64)>;

/// The map for quads of a length; or why there is none.
pub fn seamless(framed: &Framed, cut: Cut, length: f64, context: &Context) -> Result<std::result::Result<Map, String>> {
    let mut system = System::new(framed, &cut, length);
    let (mut wrong, mut fewest) = (Vec::new(), usize::MAX);
    for _ in 0..STIFFER_ROUNDS {
        let Some(mut uv) = system.first(context)? else {
            return Ok(Err("the seamless map could not be solved".into()));
        };
        wrong = system.smaller_than(TURNED_AREA, &uv).collect();
        tracing::debug!(target: "carreau::quad", turned = wrong.len(), "solved");
        if wrong.len() >= fewest.max(1) {
            untangle(&system, &mut uv, context)?;
            wrong = system.smaller_than(TURNED_AREA, &uv).collect();
        } else {
            fewest = wrong.len();
        }
        if wrong.is_empty() {
            let at = |&n: &u32| DVec2::new(uv[2 * n as usize], uv[2 * n as usize + 1]);
            let map = Map { uv: cut.node.iter().map(at).collect(), turn: cut.turn.clone() };
            wrong = map.wrong_angles(framed);
            if wrong.is_empty() {
                return Ok(Ok(map));
            }
            tracing::debug!(target: "carreau::quad", wrong = wrong.len(), "wrong angles");
        }
        system.stiffen(framed, &wrong);
    }
    Ok(Err(format!("{} triangles of the map stay turned over", wrong.len())))
}

/// Gradients of the three hat functions of a triangle.
fn gradients(p: &[DVec2; 3]) -> [DVec2; 3] {
    let inverse = DMat2::from_cols(p[1] - p[0], p[2] - p[0]).inverse().transpose();
    [-inverse.x_axis - inverse.y_axis, inverse.x_axis, inverse.y_axis]
}

/// What the derivative of the map should be in a triangle.
fn target(framed: &Framed, cut: &Cut, t: usize, length: f64) -> DMat2 {
    let j = (framed.frame[t] * (length * framed.size[t])).inverse();
    DMat2::from_cols(turned(j.x_axis, -cut.comb[t]), turned(j.y_axis, -cut.comb[t]))
}

/// Linear forms of the unknowns, 2 node + coordinate, that are zero.
fn constraints(framed: &Framed, cut: &Cut) -> Vec<Row> {
    let mut rows = Vec::new();
    for &h in &cut.seams {
        let o = framed.opposite[h as usize];
        let [a, b, a_across, b_across] = [h, next(h), next(o), o].map(|c| 2 * cut.node[c as usize]);
        let turns = [DVec2::X, DVec2::Y].map(|axis| turned(axis, cut.turn[h as usize]));
        for c in 0..2usize {
            let mut row = vec![(b_across + c as u32, 1.0), (a_across + c as u32, -1.0)];
            for (d, turn) in turns.iter().enumerate().filter(|(_, turn)| turn[c] != 0.0) {
                row.extend([(b + d as u32, -turn[c]), (a + d as u32, turn[c])]);
            }
            rows.push(merged(row));
        }
    }
    for h in (0..framed.curve.len() as u32).filter(|&h| framed.curve[h as usize] != NONE) {
        let o = framed.opposite[h as usize];
        if o == NONE || h < o {
            let across = 1 - (framed.branch_along(h) - cut.comb[h as usize / 3]).rem_euclid(2) as u32;
            let [a, b] = [h, next(h)].map(|c| 2 * cut.node[c as usize] + across);
            rows.push(merged(vec![(a, -1.0), (b, 1.0)]));
        }
    }
    rows.retain(|row| !row.is_empty());
    rows
}

/// Every unknown once.
fn merged(mut row: Row) -> Row {
    row.sort_unstable_by_key(|term| term.0);
    let mut all: Row = Vec::new();
    for (i, a) in row {
        match all.last_mut().filter(|last| last.0 == i) {
            Some(last) => last.1 += a,
            None => all.push((i, a)),
        }
    }
    all.retain(|term| term.1 != 0.0);
    all
}

/// What the map minimises, and its constraints.
pub struct System<'a> {
    cut: &'a Cut,
    rows: Vec<Row>,
    /// Gradients of the three hat functions of every triangle where its frame is the unit.
    gradients: Vec<[DVec2; 3]>,
    /// Area of every triangle, in quads, times its weight.
    area: Vec<f64>,
}

impl<'a> System<'a> {
    fn new(framed: &Framed, cut: &'a Cut, length: f64) -> Self {
        let of = |t: usize| {
            let wanted = target(framed, cut, t, length).inverse().transpose();
            gradients(&framed.local[t]).map(|g| wanted * g)
        };
        let gradients = (0..framed.triangles.len()).map(of).collect();
        let quads = framed.area.iter().zip(&framed.size).map(|(a, s)| a / (length * s).powi(2));
        let area = quads.zip(&framed.weight).map(|(quads, weight)| quads * weight).collect();
        System { cut, rows: constraints(framed, cut), gradients, area }
    }

    /// Triangles weigh more, and those around them.
    fn stiffen(&mut self, framed: &Framed, triangles: &[usize]) {
        let mut is_near = vec![false; framed.points.len()];
        triangles.iter().flat_map(|&t| framed.triangles[t]).for_each(|v| is_near[v as usize] = true);
        for (area, t) in self.area.iter_mut().zip(&framed.triangles) {
            if t.iter().any(|&v| is_near[v as usize]) {
                *area *= STIFFER_FACTOR;
            }
        }
        triangles.iter().for_each(|&t| self.area[t] *= STIFFER_FACTOR);
    }

    fn nodes(&self, t: usize) -> [u32; 3] {
        [0, 1, 2].map(|k| 2 * self.cut.node[3 * t + k])
    }

    fn derivative(&self, t: usize, uv: &[f64]) -> Derivative {
        let (mut z, mut w) = (DVec2::ZERO, DVec2::ZERO);
        for (n, g) in self.nodes(t).into_iter().zip(self.gradients[t]) {
            let p = DVec2::new(uv[n as usize], uv[n as usize + 1]);
            z += 0.5 * DVec2::new(p.dot(g), g.perp_dot(p));
            w += 0.5 * DVec2::new(p.x * g.x - p.y * g.y, p.y * g.x + p.x * g.y);
        }
        Derivative { z, w }
    }

    fn triangles(&self) -> std::ops::Range<usize> {
        0..self.area.len()
    }

    pub fn smallest(&self, uv: &[f64]) -> f64 {
        self.triangles().map(|t| self.derivative(t, uv).determinant()).fold(f64::INFINITY, f64::min)
    }

    /// Triangles with less than a share of the area that is wanted.
    pub fn smaller_than<'b>(&'b self, share: f64, uv: &'b [f64]) -> impl Iterator<Item = usize> + 'b {
        self.triangles().filter(move |&t| self.derivative(t, uv).determinant() <= share)
    }

    pub fn cost(&self, uv: &[f64], epsilon: f64) -> f64 {
        self.triangles().map(|t| self.area[t] * self.derivative(t, uv).cost(epsilon)).sum()
    }

    /// The map as near as it gets to the frames; `None` where the constraints are not met.
    fn first(&self, context: &Context) -> Result<Option<Vec<f64>>> {
        let mut matrix = Matrix::new(2 * self.cut.nodes);
        let mut rhs = vec![0.0; 2 * self.cut.nodes];
        for (t, g) in self.gradients.iter().enumerate() {
            let node = self.nodes(t);
            for k in 0..3 {
                rhs[node[k] as usize] += self.area[t] * g[k].x;
                rhs[node[k] as usize + 1] += self.area[t] * g[k].y;
                for l in (0..3).filter(|&l| node[l] <= node[k]) {
                    let value = self.area[t] * g[k].dot(g[l]);
                    matrix.add(node[k], node[l], value);
                    matrix.add(node[k] + 1, node[l] + 1, value);
                }
            }
        }
        self.solve(matrix, &rhs, SEAM_STIFFNESS, &mut None, context)
    }

    /// The minimum of the model of what the map costs, about where it is.
    pub fn newton(
        &self,
        uv: &[f64],
        epsilon: f64,
        plan: &mut Option<Plan>,
        context: &Context,
    ) -> Result<Option<Vec<f64>>> {
        let mut matrix = Matrix::new(2 * self.cut.nodes);
        let mut rhs = vec![0.0; 2 * self.cut.nodes];
        let mut largest = 1f64;
        for t in self.triangles() {
            let model = self.derivative(t, uv).model(epsilon);
            let node = self.nodes(t);
            let columns: [u32; 6] = [0, 1, 2, 3, 4, 5].map(|i: usize| node[i / 2] + i as u32 % 2);
            // How z and w follow the coordinates of the corners.
            let mut by = [[0.0; 4]; 6];
            for (k, g) in self.gradients[t].iter().enumerate() {
                by[2 * k] = [0.5 * g.x, -0.5 * g.y, 0.5 * g.x, 0.5 * g.y];
                by[2 * k + 1] = [0.5 * g.y, 0.5 * g.x, -0.5 * g.y, 0.5 * g.x];
            }
            let times = |v: &[f64; 4]| [0, 1, 2, 3].map(|i| (0..4).map(|j| model.curvature[i][j] * v[j]).sum::<f64>());
            let dot = |a: &[f64; 4], b: &[f64; 4]| (0..4).map(|i| a[i] * b[i]).sum::<f64>();
            let area = self.area[t];
            for i in 0..6 {
                rhs[columns[i] as usize] -= area * dot(&by[i], &model.gradient);
                let bent = times(&by[i]);
                for j in 0..6 {
                    let value = area * dot(&bent, &by[j]);
                    rhs[columns[i] as usize] += value * uv[columns[j] as usize];
                    if columns[j] <= columns[i] {
                        matrix.add(columns[i], columns[j], value);
                    }
                }
                largest = largest.max(area * dot(&bent, &by[i]));
            }
        }
        self.solve(matrix, &rhs, SEAM_STIFFNESS * largest.min(1e3), plan, context)
    }

    /// The minimum of ½ xᵀ A x − bᵀ x under the constraints; `None` where these are not met.
    fn solve(
        &self,
        mut matrix: Matrix<f64>,
        rhs: &[f64],
        stiffness: f64,
        plan: &mut Option<Plan>,
        context: &Context,
    ) -> Result<Option<Vec<f64>>> {
        for row in &self.rows {
            for &(i, a) in row {
                row.iter().filter(|other| other.0 <= i).for_each(|&(j, b)| matrix.add(i, j, stiffness * a * b));
            }
        }
        // Where each component is does not matter.
        for i in self.cut.anchors.iter().flat_map(|&n| [2 * n, 2 * n + 1]) {
            matrix.add(i, i, 1.0);
        }
        let factor = matrix.factor(plan)?;
        let mut multiplier = vec![0.0; self.rows.len()];
        for _ in 0..MULTIPLIER_SOLVES {
            context.check()?;
            let mut right = rhs.to_vec();
            for (row, m) in self.rows.iter().zip(&multiplier) {
                row.iter().for_each(|&(i, a)| right[i as usize] -= a * m);
            }
            let x = factor.solve(&right)?;
            let mut worst = 0f64;
            for (row, m) in self.rows.iter().zip(&mut multiplier) {
                let off: f64 = row.iter().map(|&(i, a)| a * x[i as usize]).sum();
                *m += stiffness * off;
                worst = worst.max(off.abs());
            }
            if worst < SEAM_MISMATCH {
                return Ok(Some(x));
            }
        }
        Ok(None)
    }
}

impl Map {
    /// A half-edge in the frame of its triangle.
    pub fn along(&self, h: u32) -> DVec2 {
        self.uv[next(h) as usize] - self.uv[h as usize]
    }

    /// Triangles at vertices whose angle is not what their quads make: the map goes around them once too often, or too seldom.
    pub fn wrong_angles(&self, framed: &Framed) -> Vec<usize> {
        let mut angle = vec![0.0; framed.points.len()];
        for h in 0..self.uv.len() as u32 {
            angle[framed.tail(h) as usize] += self.along(h).angle_to(-self.along(super::framed::previous(h)));
        }
        let is_wrong = |v: usize| (angle[v] - f64::from(framed.quads[v]) * FRAC_PI_2).abs() > ANGLE_MISMATCH;
        (0..framed.triangles.len()).filter(|&t| framed.triangles[t].iter().any(|&v| is_wrong(v as usize))).collect()
    }
}
