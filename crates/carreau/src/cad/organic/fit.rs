//! Control points of least squares: the limit surface goes near the points of the scan.
//!
//! Every sample has a foot on the surface, and the surface is fitted to the samples at their feet. The control points' second
//! Laplacian is kept small, so that the surface is fair where samples are few.

use super::feet::Sample;
use super::limit::{Limit, Piece, basis};
use super::net::{Net, Role};
use super::refine::{Row, Value, rim};
use crate::context::Context;
use crate::error::Result;
use crate::numeric::sparse::{Matrix, Plan};
use glam::DVec3;
use rayon::prelude::*;

/// A count: divisions towards irregular vertices during the fit, because no sample needs to be looked at nearer.
pub const FIT_LEVELS: usize = 5;

/// A factor: fairness counts so much more in every round in which the surface is turned over, because how much it takes is not known.
const STIFFENING: f64 = 100.0;
/// A factor: the most, because with it samples hardly count.
const MOST_STIFFNESS: f64 = 1e9;

/// The surface as sums over control points, and what fairness asks of these.
pub struct Fit<'a> {
    rows: Limit<'a, Row>,
    fair: Vec<(u32, Row)>,
    /// Of every control point how much more its fairness counts: more where the surface has been turned over.
    stiffness: Vec<f64>,
    /// Of every quad the control points of the surface on it, ascending: those of the quads that it has a corner in common with.
    controls: Vec<Vec<u32>>,
    /// How the normal equations are eliminated, which is the same in every round.
    plan: Option<Plan>,
}

impl<'a> Fit<'a> {
    /// The system of a net.
    pub fn new(net: &'a Net) -> Self {
        let own: Vec<Row> = (0..net.role.len() as u32).map(|v| Row(vec![(v, 1.0)])).collect();
        let rows = Limit::new(net, &own, FIT_LEVELS);
        let stiffness = vec![1.0; own.len()];
        Fit { rows, fair: fairness(net, &own), stiffness, controls: controls(net), plan: None }
    }

    /// Makes the surface stiffer around parts where it is turned over.
    pub fn stiffen(&mut self, turned: &[u32]) {
        let mut around: Vec<u32> = turned.iter().flat_map(|&p| self.controls[p as usize / 4].iter().copied()).collect();
        around.sort_unstable();
        around.dedup();
        for v in around {
            let stiffness = &mut self.stiffness[v as usize];
            *stiffness = (STIFFENING * *stiffness).min(MOST_STIFFNESS);
        }
    }

    /// The control points of least squares for samples at their feet; where samples say nothing, they stay where they are.
    pub fn solve(
        &mut self,
        points: &[DVec3],
        samples: &[Sample],
        fairness: f64,
        context: &Context,
    ) -> Result<Vec<DVec3>> {
        let n = points.len();
        let mut of_quad: Vec<Vec<&Sample>> = vec![Vec::new(); self.controls.len()];
        samples.iter().for_each(|s| of_quad[s.part as usize / 4].push(s));
        of_quad.iter_mut().for_each(|group| group.sort_by_key(|s| s.part));
        let one = |(group, controls): (&Vec<&Sample>, &Vec<u32>)| {
            context.check()?;
            Ok(Local::of(&self.rows, group, controls))
        };
        let locals: Vec<Local> =
            context.install(|| of_quad.par_iter().zip(&self.controls).map(one).collect::<Result<_>>())?;
        let mut matrix = Matrix::new(n);
        let mut rhs = [vec![0.0; n], vec![0.0; n], vec![0.0; n]];
        for (local, controls) in locals.iter().zip(&self.controls) {
            local.add_to(controls, &mut matrix, &mut rhs);
        }
        let weight = fairness * samples.iter().map(|s| s.weight).sum::<f64>() / n as f64;
        for (v, row) in &self.fair {
            let weight = weight * self.stiffness[*v as usize];
            for &(i, a) in &row.0 {
                for &(j, b) in row.0.iter().filter(|t| t.0 <= i) {
                    matrix.add(i, j, weight * a * b);
                }
            }
        }
        let hold = 1e-6 * weight.max(1e-9);
        for (k, p) in points.iter().enumerate() {
            matrix.add(k as u32, k as u32, hold);
            (0..3).for_each(|d| rhs[d][k] += hold * p[d]);
        }
        let factor = matrix.factor(&mut self.plan)?;
        let [x, y, z] = [factor.solve(&rhs[0])?, factor.solve(&rhs[1])?, factor.solve(&rhs[2])?];
        Ok((0..n).map(|k| DVec3::new(x[k], y[k], z[k])).collect())
    }
}

/// Of every quad the vertices of all quads at its corners.
fn controls(net: &Net) -> Vec<Vec<u32>> {
    let of_fan = |fan: &super::net::Fan| -> Vec<u32> {
        let mut all: Vec<u32> = fan.spokes.iter().flat_map(|&h| net.quads[h as usize / 4]).collect();
        all.sort_unstable();
        all.dedup();
        all
    };
    let fans: Vec<Vec<u32>> = net.fans.iter().map(of_fan).collect();
    let of_quad = |q: usize| {
        let mut all: Vec<u32> = (4 * q..4 * q + 4).flat_map(|h| fans[net.fan_of[h] as usize].iter().copied()).collect();
        all.sort_unstable();
        all.dedup();
        all
    };
    (0..net.quads.len()).map(of_quad).collect()
}

/// What the samples of a quad add to the normal equations of its control points.
struct Local {
    matrix: Vec<f64>,
    rhs: Vec<DVec3>,
}

impl Local {
    /// `group` is sorted by parts.
    fn of(rows: &Limit<'_, Row>, group: &[&Sample], controls: &[u32]) -> Self {
        // Samples on one piece are sums over the same sixteen rows.
        let mut pieces: Vec<Piece<Row>> = Vec::new();
        let mut on = Vec::with_capacity(group.len());
        for (k, sample) in group.iter().enumerate() {
            if k == 0 || group[k - 1].part != sample.part || pieces.last().is_none_or(|p| p.size < 1.0) {
                pieces.push(rows.piece(sample.part, sample.at));
            }
            on.push(pieces.len() - 1);
        }
        let n = controls.len();
        let dense = |piece: &Piece<Row>| {
            let mut out = vec![0.0; 16 * n];
            for (k, row) in piece.points.as_flattened().iter().enumerate() {
                for (control, weight) in &row.0 {
                    out[k * n + controls.partition_point(|c| c < control)] += weight;
                }
            }
            out
        };
        let dense: Vec<Vec<f64>> = pieces.iter().map(dense).collect();
        let (mut matrix, mut rhs) = (vec![0.0; n * n], vec![DVec3::ZERO; n]);
        for (sample, &k) in group.iter().zip(&on) {
            let [u, v] = pieces[k].local(sample.at).map(|t| basis(t)[0]);
            let mut row = vec![0.0; n];
            for (of_control, weight) in dense[k].chunks(n).zip(v.iter().flat_map(|b| u.map(|a| a * b))) {
                row.iter_mut().zip(of_control).for_each(|(r, x)| *r += weight * x);
            }
            for (i, &a) in row.iter().enumerate().filter(|r| *r.1 != 0.0) {
                let a = sample.weight * a;
                rhs[i] += a * sample.point;
                matrix[i * n..=i * n + i].iter_mut().zip(&row).for_each(|(m, b)| *m += a * b);
            }
        }
        Local { matrix, rhs }
    }

    fn add_to(&self, controls: &[u32], matrix: &mut Matrix<f64>, rhs: &mut [Vec<f64>; 3]) {
        let n = controls.len();
        for (i, &row) in controls.iter().enumerate() {
            (0..3).for_each(|d| rhs[d][row as usize] += self.rhs[i][d]);
            for (j, &column) in controls.iter().enumerate().take(i + 1) {
                matrix.add(row, column, self.matrix[i * n + j]);
            }
        }
    }
}

/// The second Laplacian of every control point; along borders that of the border.
fn fairness(net: &Net, own: &[Row]) -> Vec<(u32, Row)> {
    let mut around: Vec<Vec<u32>> = vec![Vec::new(); own.len()];
    for fan in &net.fans {
        let v = fan.vertex as usize;
        match net.role[v] {
            Role::Smooth | Role::Dart => around[v] = fan.spokes.iter().map(|&h| net.end(h)).collect(),
            Role::Border => around[v] = rim(net, &fan.spokes).to_vec(),
            Role::Corner => {}
        }
    }
    let laplacian = |of: &[Row], v: usize| {
        let share = -1.0 / around[v].len() as f64;
        let mut terms = vec![(1.0, &of[v])];
        terms.extend(around[v].iter().map(|&o| (share, &of[o as usize])));
        Row::mix(&terms)
    };
    let once: Vec<Row> =
        (0..own.len()).map(|v| if around[v].is_empty() { Row(Vec::new()) } else { laplacian(own, v) }).collect();
    (0..own.len()).filter(|&v| !around[v].is_empty()).map(|v| (v as u32, laplacian(&once, v))).collect()
}
