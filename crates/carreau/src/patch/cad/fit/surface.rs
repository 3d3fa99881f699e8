//! The surface inside the sides of a block: least squares with a small bending energy, refined until every vertex is
//! within the tolerance.

use super::curve::{STIFFNESS, bisected};
use super::side::Frame;
use super::stencil::Stencil;
use crate::error::Result;
use crate::geometry::bspline::{BSplineSurface, Knots};
use crate::patch::cad::piece::Block;
use crate::patch::cad::scene::Scene;
use glam::DVec3;
use std::f64::consts::PI;

/// A surface near the vertices of a block, with the given sides.
pub struct Fitted {
    pub surface: BSplineSurface,
    /// Largest distance of an inner vertex.
    pub deviation: f64,
    /// Mean square of what the distances exceed the tolerance by.
    excess: f64,
    /// Parameters of all vertices, row by row.
    parameters: Vec<[f64; 2]>,
    plan: Plan,
}

/// What the knots have besides those of the sides.
#[derive(Clone, Default)]
struct Plan {
    /// Whether directions in which the sides are straight are of degree 3 all the same.
    cubic: [bool; 2],
    /// Break points in u and in v.
    extra: [Vec<f64>; 2],
}

/// Rounds of parameter correction.
const SURFACE_CORRECTIONS: usize = 3;
/// Rounds of refinement.
const LEVELS: usize = 12;

/// The vertices of a block, and the frame they are to be spanned in.
pub struct Problem<'a> {
    frame: &'a Frame,
    /// Numbers of nodes: columns, rows.
    nodes: [usize; 2],
    points: Vec<DVec3>,
    /// Mean lengths of rows and columns.
    lengths: [f64; 2],
    tolerance: f64,
    /// Most control points.
    limit: usize,
}

impl<'a> Problem<'a> {
    pub fn new(scene: &Scene, block: &Block, frame: &'a Frame, tolerance: f64, limit: usize) -> Self {
        let [m, n] = block.size;
        let at = |r, c| scene.point(block.vertex(scene.patches, r, c));
        let points: Vec<DVec3> = (0..=m).flat_map(|r| (0..=n).map(move |c| at(r, c))).collect();
        let nodes = [n as usize + 1, m as usize + 1];
        let total = |step: usize, skip: &dyn Fn(usize) -> bool| -> f64 {
            let starts = (0..points.len() - step).filter(|&k| !skip(k));
            starts.map(|k| points[k].distance(points[k + step])).sum()
        };
        let rows = total(1, &|k| (k + 1) % nodes[0] == 0) / nodes[1] as f64;
        let columns = total(nodes[0], &|_| false) / nodes[0] as f64;
        // Never zero: coinciding vertices have no length.
        let least = 1e-6 * (rows + columns) + f64::MIN_POSITIVE;
        Problem { frame, nodes, points, lengths: [rows.max(least), columns.max(least)], tolerance, limit }
    }

    /// A surface within the tolerance and with no more control points than the limit, if one is found.
    pub fn solve(&self) -> Result<Option<Fitted>> {
        let Some(mut best) = self.attempt(Plan::default(), None)? else { return Ok(None) };
        for _ in 0..LEVELS {
            if best.deviation <= self.tolerance {
                return Ok(if self.strays(&best) { None } else { Some(best) });
            }
            // Whichever direction gains more per control point is refined; both where neither does.
            let size = best.surface.points().len() as f64;
            let mut next: Option<(f64, Fitted)> = None;
            for directions in [&[0][..], &[1], &[0, 1]] {
                let Some(plan) = self.refined(&best, directions) else { continue };
                if directions.len() == 2 && next.as_ref().is_some_and(|(gain, _)| *gain > 0.0) {
                    continue;
                }
                let Some(trial) = self.attempt(plan, Some(&best))? else { continue };
                let more = trial.surface.points().len() as f64 - size;
                let gain = (1.0 - (trial.excess / best.excess).sqrt()) / more;
                if next.as_ref().is_none_or(|(g, _)| gain > *g) {
                    next = Some((gain, trial));
                }
            }
            let Some((_, trial)) = next else { return Ok(None) };
            best = trial;
        }
        Ok(None)
    }

    /// The plan with the spans of vertices that are too far halved in these directions; `None` where nothing is halved.
    fn refined(&self, from: &Fitted, directions: &[usize]) -> Option<Plan> {
        let mut plan = from.plan.clone();
        let mut changed = false;
        for &d in directions {
            let knots = from.surface.knots()[d];
            if knots.degree() == 1 {
                // Straight so far: bend first.
                changed |= self.nodes[d] > 2;
                plan.cubic[d] |= self.nodes[d] > 2;
                continue;
            }
            let far = |k: &usize| self.distance(from, *k) > self.tolerance;
            let marked: Vec<f64> = self.inner().filter(far).map(|k| from.parameters[k][d]).collect();
            let breaks = knots.breaks();
            let finer = bisected(&breaks, &marked, &self.frame.scale[d]);
            changed |= finer.len() > breaks.len();
            plan.extra[d] = finer;
        }
        changed.then_some(plan)
    }

    /// Indices of the vertices that are on no side.
    fn inner(&self) -> impl Iterator<Item = usize> + use<> {
        let [columns, rows] = self.nodes;
        (1..rows.max(1) - 1).flat_map(move |r| (1..columns - 1).map(move |c| r * columns + c))
    }

    fn distance(&self, fit: &Fitted, k: usize) -> f64 {
        let [u, v] = fit.parameters[k];
        fit.surface.point(u, v).distance(self.points[k])
    }

    /// Solves on the knots of a plan, correcting parameters while that helps; `None` where there would be
    /// too many control points.
    fn attempt(&self, plan: Plan, from: Option<&Fitted>) -> Result<Option<Fitted>> {
        let Some([u, v]) = self.frame.knots(plan.cubic)? else { return Ok(None) };
        let with = |knots: Knots, extra: &[f64]| -> Result<Knots> {
            if extra.len() < 2 { Ok(knots) } else { Ok(knots.union(&Knots::from_breaks(knots.degree(), extra, 1)?)) }
        };
        let (u, v) = (with(u, &plan.extra[0])?, with(v, &plan.extra[1])?);
        if u.count() * v.count() > self.limit {
            return Ok(None);
        }
        let mut parameters = from.map_or_else(|| self.first_parameters(), |f| f.parameters.clone());
        let mut net = self.first_net(&u, &v)?;
        let mut best: Option<Fitted> = None;
        for _ in 0..=SURFACE_CORRECTIONS {
            self.least_squares(&u, &v, &parameters, &mut net);
            let surface = BSplineSurface::new(u.clone(), v.clone(), net.clone())?;
            for k in self.inner() {
                parameters[k] = surface.project(self.points[k], parameters[k]);
            }
            let mut fit =
                Fitted { surface, deviation: 0.0, excess: 0.0, parameters: parameters.clone(), plan: plan.clone() };
            for k in self.inner() {
                let d = self.distance(&fit, k);
                fit.deviation = fit.deviation.max(d);
                fit.excess += (d - self.tolerance).max(0.0).powi(2);
            }
            let better = best.as_ref().is_none_or(|b| fit.deviation < 0.95 * b.deviation);
            let done = fit.deviation <= self.tolerance || !better;
            if best.as_ref().is_none_or(|b| fit.deviation < b.deviation) {
                best = Some(fit);
            }
            if done {
                break;
            }
        }
        Ok(best)
    }

    /// Parameters of columns and rows, shifted as the vertices on the sides are against them.
    fn first_parameters(&self) -> Vec<[f64; 2]> {
        let [bottom, right, top, left] = &self.frame.sides;
        let [us, vs] = &self.frame.scale;
        let between = |a: f64, b: f64, t: f64| a * (1.0 - t) + b * t;
        let mut out = Vec::with_capacity(self.points.len());
        for (&v, (&l, &r)) in vs.iter().zip(left.parameters.iter().zip(&right.parameters)) {
            for (&u, (&b, &t)) in us.iter().zip(bottom.parameters.iter().zip(&top.parameters)) {
                out.push([between(b, t, v), between(l, r, u)]);
            }
        }
        out
    }

    /// The sides' control points, and inside the bilinear cells sampled at the averages of the knots (Greville).
    fn first_net(&self, u: &Knots, v: &Knots) -> Result<Vec<DVec3>> {
        let (m, n) = (u.count(), v.count());
        let (us, vs) = (greville(u), greville(v));
        let mut net: Vec<DVec3> = vs.iter().flat_map(|&v| us.iter().map(move |&u| self.cell_point(u, v))).collect();
        let sides = [
            self.frame.curve_on(0, u)?,
            self.frame.curve_on(2, u)?,
            self.frame.curve_on(1, v)?,
            self.frame.curve_on(3, v)?,
        ];
        for i in 0..m {
            net[i] = sides[0].points()[i];
            net[(n - 1) * m + i] = sides[1].points()[i];
        }
        for j in 0..n {
            net[j * m + m - 1] = sides[2].points()[j];
            net[j * m] = sides[3].points()[j];
        }
        Ok(net)
    }

    /// The point of the bilinear cells at a pair of parameters of columns and rows.
    fn cell_point(&self, u: f64, v: f64) -> DVec3 {
        let locate = |t: f64, at: &[f64]| {
            let k = at.partition_point(|&x| x <= t).clamp(1, at.len() - 1) - 1;
            (k, ((t - at[k]) / (at[k + 1] - at[k])).clamp(0.0, 1.0))
        };
        let ((c, s), (r, t)) = (locate(u, &self.frame.scale[0]), locate(v, &self.frame.scale[1]));
        let at = |r: usize, c: usize| self.points[r * self.nodes[0] + c];
        at(r, c).lerp(at(r, c + 1), s).lerp(at(r + 1, c).lerp(at(r + 1, c + 1), s), t)
    }

    /// The inner control points that minimise Σ |S(uᵢ, vᵢ) − pᵢ|² + λ ∫∫ |S_xx|² + 2 |S_xy|² + |S_yy|², where x and y are
    /// u and v times the mean lengths of rows and columns.
    ///
    /// λ falls with the fourth power of the length of the shorter spans, so that it flattens nothing as wide as a span;
    /// it decides where there are no vertices. A hundredth of it on the first derivatives keeps the equations definite
    /// where a direction is of degree 1.
    fn least_squares(&self, u: &Knots, v: &Knots, parameters: &[[f64; 2]], net: &mut [DVec3]) {
        let (m, n) = (u.count(), v.count());
        let mut matrix = Stencil::new(m, n);
        let mut rhs = vec![DVec3::ZERO; m * n];
        for k in self.inner() {
            let ((i0, a), (j0, b)) = (u.basis(parameters[k][0]), v.basis(parameters[k][1]));
            for (j, wj) in (j0..).zip(&b[..=v.degree()]) {
                for (i, wi) in (i0..).zip(&a[..=u.degree()]) {
                    let weight = wi * wj;
                    rhs[j * m + i] += weight * self.points[k];
                    for (l, wl) in (j0..).zip(&b[..=v.degree()]) {
                        for (h, wh) in (i0..).zip(&a[..=u.degree()]) {
                            matrix.add([i, j], [h, l], weight * wh * wl);
                        }
                    }
                }
            }
        }
        let data = self.inner().count().max(1) as f64;
        let span = |k: &Knots, length: f64| length / ((k.breaks().len() - 1) as f64 * PI);
        let shorter = span(u, self.lengths[0]).min(span(v, self.lengths[1]));
        let [lu, lv] = self.lengths.map(|length| STIFFNESS * data * (shorter / length).powi(4));
        let (gu, gv) = (grams(u), grams(v));
        let mixed = 2.0 * (lu * lv).sqrt();
        for j in 0..n {
            for l in j.saturating_sub(v.degree())..=(j + v.degree()).min(n - 1) {
                let b = gv[j][l + 3 - j];
                for i in 0..m {
                    for h in i.saturating_sub(u.degree())..=(i + u.degree()).min(m - 1) {
                        let a = gu[i][h + 3 - i];
                        let bending = lu * a[2] * b[0] + mixed * a[1] * b[1] + lv * a[0] * b[2];
                        let stretching = 0.01 * (lu * a[1] * b[0] + lv * a[0] * b[1]);
                        matrix.add([i, j], [h, l], bending + stretching);
                    }
                }
            }
        }
        matrix.solve(&rhs, net);
    }

    /// Whether the surface turns over or leaves the mesh between its vertices: at the middle of every cell its normal
    /// must be on the side of the cell's, and its distance from the cell's middle what the bend of the mesh there explains
    /// (an arc leaves its chord by an eighth of the second difference).
    fn strays(&self, fit: &Fitted) -> bool {
        let [columns, rows] = self.nodes;
        let bend = |k: usize| {
            let (r, c) = (k / columns, k % columns);
            let second = |step: usize| (self.points[k - step] + self.points[k + step] - 2.0 * self.points[k]).length();
            let along = if c > 0 && c + 1 < columns { second(1) } else { 0.0 };
            let across = if r > 0 && r + 1 < rows { second(columns) } else { 0.0 };
            along + across
        };
        (0..rows - 1).flat_map(|r| (0..columns - 1).map(move |c| r * columns + c)).any(|k| {
            let corners = [k, k + 1, k + columns + 1, k + columns];
            let [a, b, c, d] = corners.map(|k| self.points[k]);
            let [u, v] = [0, 1].map(|x| corners.iter().map(|&k| fit.parameters[k][x]).sum::<f64>() / 4.0);
            let jet = fit.surface.jet(u, v);
            let turned = jet.first[0].cross(jet.first[1]).dot((c - a).cross(d - b)) <= 0.0;
            let explained = 0.25 * corners.map(bend).into_iter().fold(0.0, f64::max);
            turned || off_cell(jet.point, [a, b, c, d]) > 2.0 * self.tolerance + explained
        })
    }
}

/// Distance of a point from the bilinear cell, along its normal in the middle.
fn off_cell(p: DVec3, [a, b, c, d]: [DVec3; 4]) -> f64 {
    let normal = (c - a).cross(d - b).normalize_or_zero();
    (p - (a + b + c + d) / 4.0).dot(normal).abs()
}

/// Averages of `degree` successive knots: where a control point has most influence.
fn greville(knots: &Knots) -> Vec<f64> {
    let p = knots.degree();
    (0..knots.count()).map(|i| knots.values()[i + 1..=i + p].iter().sum::<f64>() / p as f64).collect()
}

/// Integrals of products of basis functions i and i + k − 3, of their first, and of their second derivatives:
/// `out[i][k][derivative]`. Four Gauss points integrate degree 6 exactly.
fn grams(knots: &Knots) -> Vec<[[f64; 3]; 7]> {
    const GAUSS: [(f64, f64); 4] = [
        (-0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
        (-0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
        (0.339_981_043_584_856_26, 0.652_145_154_862_546_1),
        (0.861_136_311_594_052_6, 0.347_854_845_137_453_85),
    ];
    let mut out = vec![[[0.0; 3]; 7]; knots.count()];
    for w in knots.breaks().windows(2) {
        let (half, middle) = (0.5 * (w[1] - w[0]), 0.5 * (w[0] + w[1]));
        for (x, weight) in GAUSS {
            let (first, rows) = knots.derivatives(middle + half * x);
            for i in 0..=knots.degree() {
                for j in 0..=knots.degree() {
                    for (d, row) in rows.iter().enumerate() {
                        out[first + i][j + 3 - i][d] += half * weight * row[i] * row[j];
                    }
                }
            }
        }
    }
    out
}
