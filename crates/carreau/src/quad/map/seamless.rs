//! The seamless map: Σ area |∇(u, v) − frame⁻¹/h|² least over the disc, where every edge of the cut is the same on both of its
//! sides but for right angles, and edges on features run along one coordinate.
//!
//! One symmetric solve with multipliers: the constraints, dependent ones among them, come into the matrix with a large weight,
//! and a few more solves with the same factor take what is left of them to rounding. Triangles that come out turned over are
//! made stiffer, and it is solved again.

use super::cut::Cut;
use super::framed::{Framed, next, turned};
use super::tuning::{ANGLE, MULTIPLIERS, PATIENCE, SEAMLESS, STIFFER, STIFFER_ROUNDS, STIFFNESS, TURNED};
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
    let rows = constraints(framed, &cut);
    let gradients: Vec<[DVec2; 3]> = framed.local.iter().map(gradients).collect();
    let targets: Vec<DMat2> = (0..framed.frame.len()).map(|t| target(framed, &cut, t, length)).collect();
    let mut weight = vec![1.0; framed.triangles.len()];
    let mut plan = None;
    let mut least = (usize::MAX, 0);
    for round in 0..STIFFER_ROUNDS {
        context.check()?;
        let system = System { framed, cut: &cut, rows: &rows, gradients: &gradients, targets: &targets };
        let Some(uv) = system.solve(&weight, &mut plan, context)? else {
            return Ok(Err("the seamless map could not be solved".into()));
        };
        let is_turned = |t: &usize| {
            let g = &gradients[*t];
            let j = (0..3).fold(DMat2::ZERO, |sum, k| sum + outer(uv[3 * t + k], g[k]));
            j.determinant() <= TURNED * targets[*t].determinant()
        };
        let bad: Vec<usize> = (0..framed.triangles.len()).filter(is_turned).collect();
        tracing::debug!(target: "carreau::quad", turned = bad.len(), "solved");
        if bad.is_empty() {
            let map = Map { uv, turn: cut.turn };
            let wrong = map.wrong_angles(framed);
            let why = || format!("{wrong} angles of the map are not those of the field");
            return Ok(if wrong == 0 { Ok(map) } else { Err(why()) });
        }
        if bad.len() < least.0 {
            least = (bad.len(), round);
        } else if round - least.1 >= PATIENCE {
            break;
        }
        stiffen(framed, &bad, &mut weight);
    }
    Ok(Err("triangles of the map stay turned over".into()))
}

fn outer(a: DVec2, b: DVec2) -> DMat2 {
    DMat2::from_cols(a * b.x, a * b.y)
}

/// Triangles that are turned over weigh more, and those around them.
fn stiffen(framed: &Framed, bad: &[usize], weight: &mut [f64]) {
    let mut is_near = vec![false; framed.points.len()];
    bad.iter().flat_map(|&t| framed.triangles[t]).for_each(|v| is_near[v as usize] = true);
    for (t, weight) in framed.triangles.iter().zip(weight.iter_mut()) {
        if t.iter().any(|&v| is_near[v as usize]) {
            *weight *= STIFFER;
        }
    }
    bad.iter().for_each(|&t| weight[t] *= STIFFER);
}

/// Gradients of the three hat functions of a triangle.
fn gradients(p: &[DVec2; 3]) -> [DVec2; 3] {
    let inverse = DMat2::from_cols(p[1] - p[0], p[2] - p[0]).inverse().transpose();
    [-inverse.x_axis - inverse.y_axis, inverse.x_axis, inverse.y_axis]
}

/// What the derivative of the map should be in a triangle.
fn target(framed: &Framed, cut: &Cut, t: usize, length: f64) -> DMat2 {
    let j = (framed.frame[t] * length).inverse();
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

struct System<'a> {
    framed: &'a Framed,
    cut: &'a Cut,
    rows: &'a [Row],
    gradients: &'a [[DVec2; 3]],
    targets: &'a [DMat2],
}

impl System<'_> {
    /// Coordinates of all corners; `None` where the constraints are not met.
    fn solve(&self, weight: &[f64], plan: &mut Option<Plan>, context: &Context) -> Result<Option<Vec<DVec2>>> {
        let (matrix, rhs) = self.assembled(weight);
        let factor = matrix.factor(plan)?;
        let mut multiplier = vec![0.0; self.rows.len()];
        for _ in 0..MULTIPLIERS {
            context.check()?;
            let mut right = rhs.clone();
            for (row, m) in self.rows.iter().zip(&multiplier) {
                row.iter().for_each(|&(i, a)| right[i as usize] -= a * m);
            }
            let x = factor.solve(&right)?;
            let mut worst = 0f64;
            for (row, m) in self.rows.iter().zip(&mut multiplier) {
                let off: f64 = row.iter().map(|&(i, a)| a * x[i as usize]).sum();
                *m += STIFFNESS * off;
                worst = worst.max(off.abs());
            }
            if worst < SEAMLESS {
                let at = |&n: &u32| DVec2::new(x[2 * n as usize], x[2 * n as usize + 1]);
                return Ok(Some(self.cut.node.iter().map(at).collect()));
            }
        }
        Ok(None)
    }

    fn assembled(&self, weight: &[f64]) -> (Matrix<f64>, Vec<f64>) {
        let mut matrix = Matrix::new(2 * self.cut.nodes);
        let mut rhs = vec![0.0; 2 * self.cut.nodes];
        for (t, g) in self.gradients.iter().enumerate() {
            let w = weight[t] * self.framed.area[t];
            let node = |k: usize| 2 * self.cut.node[3 * t + k];
            for k in 0..3 {
                let wanted = self.targets[t] * g[k] * w;
                rhs[node(k) as usize] += wanted.x;
                rhs[node(k) as usize + 1] += wanted.y;
                for l in (0..3).filter(|&l| node(l) <= node(k)) {
                    let value = w * g[k].dot(g[l]);
                    matrix.add(node(k), node(l), value);
                    matrix.add(node(k) + 1, node(l) + 1, value);
                }
            }
        }
        for row in self.rows {
            for &(i, a) in row {
                row.iter().filter(|other| other.0 <= i).for_each(|&(j, b)| matrix.add(i, j, STIFFNESS * a * b));
            }
        }
        // Where each component is does not matter.
        for i in self.cut.anchors.iter().flat_map(|&n| [2 * n, 2 * n + 1]) {
            matrix.add(i, i, 1.0);
        }
        (matrix, rhs)
    }
}

impl Map {
    /// A half-edge in the frame of its triangle.
    pub fn along(&self, h: u32) -> DVec2 {
        self.uv[next(h) as usize] - self.uv[h as usize]
    }

    /// Vertices whose angle is not what their quads make.
    pub fn wrong_angles(&self, framed: &Framed) -> usize {
        let mut angle = vec![0.0; framed.points.len()];
        for h in 0..self.uv.len() as u32 {
            angle[framed.tail(h) as usize] += self.along(h).angle_to(-self.along(super::framed::previous(h)));
        }
        let is_wrong = |v: &usize| (angle[*v] - f64::from(framed.quads[*v]) * FRAC_PI_2).abs() > ANGLE;
        (0..angle.len()).filter(is_wrong).count()
    }
}
