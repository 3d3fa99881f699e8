//! Control points of least squares: the limit surface goes near the points of the scan.
//!
//! Every sample has a foot on the surface, and the surface is fitted to the samples at their feet (Hoschek, *Intrinsic
//! parametrization for approximation*, CAGD 5, 1988), in turns. The control points' second Laplacian is kept small, so that the
//! surface is fair where samples are few.

use super::limit::{Limit, Piece, basis};
use super::net::{Net, Role};
use super::refine::{Row, Value, rim};
use crate::context::Context;
use crate::error::Result;
use crate::geometry::search_tree::TriangleTree;
use crate::mesh::SurfaceMesh;
use crate::numeric::sparse::Matrix;
use glam::DVec3;
use rayon::prelude::*;

/// A point of the scan with its foot.
#[derive(Debug, Clone, Copy)]
pub struct Sample {
    /// Where it is.
    pub point: DVec3,
    /// What it counts, for 1 of a vertex.
    pub weight: f64,
    /// The part of the surface with its foot.
    pub part: u32,
    /// Its place there.
    pub at: [f64; 2],
}

impl Sample {
    /// A point whose foot is not known yet.
    pub fn new(point: DVec3, weight: f64) -> Self {
        Sample { point, weight, part: 0, at: [0.0; 2] }
    }
}

/// Weight of a point inside a facet, for 1 of a vertex: small, because facets cut off what is round.
const INSIDE_WEIGHT: f64 = 0.03;
/// A count: samples of a part where vertices are few, because each part is to have some.
const SAMPLES_A_PART: f64 = 2.0;
/// A count: most samples in all, because time grows with them.
const FIT_SAMPLES: usize = 120_000;
/// A count: divisions towards irregular vertices during the fit, because no sample needs to be looked at nearer.
const FIT_LEVELS: usize = 5;
/// A count: steps of the search for a foot, few because it starts at the nearest of many points on the surface.
const FOOT_STEPS: usize = 4;
/// Weight of fairness for a control point in every round, for all the samples of one: large first, because the first
/// rounds untangle.
const FAIRNESS_WEIGHTS: [f64; 12] = [
    1e-2,
    1e-3,
    1e-4,
    LEAST_FAIRNESS,
    LEAST_FAIRNESS,
    LEAST_FAIRNESS,
    LEAST_FAIRNESS,
    LEAST_FAIRNESS,
    LEAST_FAIRNESS,
    LEAST_FAIRNESS,
    LEAST_FAIRNESS,
    LEAST_FAIRNESS,
];
/// The same in the last rounds: small, because the samples are to decide there.
const LEAST_FAIRNESS: f64 = 1e-5;
/// A share of the mean distance before: rounds go on while they bring it below, because each costs as much as the
/// first.
const ROUND_GAIN: f64 = 0.97;
/// A count: divisions of the side of a part into the triangles among which feet are looked for, two because the search
/// for a foot only has to start near it.
const CELLS_A_SIDE: usize = 2;

/// Of every vertex whether it has a face.
pub fn used(mesh: &SurfaceMesh) -> Vec<bool> {
    let mut used = vec![false; mesh.vertex_count()];
    mesh.faces().corners().iter().for_each(|&v| used[v as usize] = true);
    used
}

/// The points that are fitted: vertices, and points inside large facets.
pub fn samples(mesh: &SurfaceMesh, parts: usize) -> Vec<Sample> {
    let step = mesh.vertex_count().div_ceil(FIT_SAMPLES).max(1);
    let vertices = mesh.points().iter().zip(used(mesh)).filter(|v| v.1);
    let mut out: Vec<Sample> = vertices.step_by(step).map(|(&p, _)| Sample::new(p, 1.0)).collect();
    let corners = |f: &[u32]| [f[0], f[1], f[2]].map(|v| mesh.points()[v as usize]);
    let area = |[a, b, c]: [DVec3; 3]| 0.5 * (b - a).cross(c - a).length();
    let total: f64 = mesh.faces().iter().map(|f| area(corners(f))).sum();
    let cell = total / (SAMPLES_A_PART * parts as f64).min(FIT_SAMPLES as f64);
    for face in mesh.faces().iter() {
        let [a, b, c] = corners(face);
        let n = (area([a, b, c]) / cell).sqrt().floor().min(64.0) as u32;
        for i in 0..n {
            for j in 0..n - i {
                let [x, y] = [i, j].map(|k| (f64::from(k) + 1.0 / 3.0) / f64::from(n));
                out.push(Sample::new(a + x * (b - a) + y * (c - a), INSIDE_WEIGHT));
            }
        }
    }
    out
}

/// Gives every sample its foot on a surface. Returns the largest and the root mean square distance of vertices.
pub fn find_feet(
    samples: &mut [Sample],
    surface: &Limit<'_, DVec3>,
    parts: usize,
    context: &Context,
) -> Result<[f64; 2]> {
    let per = CELLS_A_SIDE + 1;
    let mut points = Vec::with_capacity(parts * per * per);
    let mut triangles: Vec<[u32; 3]> = Vec::with_capacity(parts * 2 * CELLS_A_SIDE * CELLS_A_SIDE);
    for part in 0..parts as u32 {
        context.check_every(part as usize)?;
        let first = points.len() as u32;
        for k in 0..per * per {
            let at = [k % per, k / per].map(|x| x as f64 / CELLS_A_SIDE as f64);
            let apex = if k == 0 { surface.apex(part).copied() } else { None };
            points.push(apex.unwrap_or_else(|| surface.piece(part, at).point(at)));
        }
        for k in 0..CELLS_A_SIDE * CELLS_A_SIDE {
            let a = first + (k / CELLS_A_SIDE * per + k % CELLS_A_SIDE) as u32;
            let [b, c, d] = [a + 1, a + 1 + per as u32, a + per as u32];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    let tree = TriangleTree::new(&points, &triangles);
    let one = |(k, sample): (usize, &mut Sample)| -> Result<f64> {
        context.check_every(k)?;
        let Some(near) = tree.closest(sample.point) else { return Ok(0.0) };
        let part = near.triangle / (2 * CELLS_A_SIDE * CELLS_A_SIDE) as u32;
        let corners = triangles[near.triangle as usize].map(|v| (v, points[v as usize]));
        let weights = barycentric(near.point, corners.map(|c| c.1));
        let place = |v: u32| {
            let k = v as usize % (per * per);
            [k % per, k / per].map(|x| x as f64 / CELLS_A_SIDE as f64)
        };
        let mut at = [0.0; 2];
        for (w, (v, _)) in weights.iter().zip(corners) {
            let p = place(v);
            at = [at[0] + w * p[0], at[1] + w * p[1]];
        }
        (sample.part, sample.at) = (part, at);
        Ok(approach(sample, surface))
    };
    let far: Vec<f64> = context.install(|| samples.par_iter_mut().enumerate().map(one).collect::<Result<_>>())?;
    let of_vertices = || far.iter().zip(samples.iter()).filter(|(_, s)| s.weight == 1.0).map(|(&d, _)| d);
    let count = of_vertices().count().max(1) as f64;
    Ok([of_vertices().fold(0.0, f64::max), (of_vertices().map(|d| d * d).sum::<f64>() / count).sqrt()])
}

/// Newton steps to the foot within the part. Returns the distance.
fn approach(sample: &mut Sample, surface: &Limit<'_, DVec3>) -> f64 {
    let mut best = surface.piece(sample.part, sample.at).point(sample.at).distance(sample.point);
    for _ in 0..FOOT_STEPS {
        let piece = surface.piece(sample.part, sample.at);
        let [u, v] = piece.local(sample.at).map(basis);
        let r = piece.mix(&u[0], &v[0]) - sample.point;
        let (su, sv) = (piece.mix(&u[1], &v[0]), piece.mix(&u[0], &v[1]));
        let (e, f, g) = (su.dot(su), su.dot(sv), sv.dot(sv));
        let (a, b) = (r.dot(su), r.dot(sv));
        let d = e * g - f * f;
        if !(d > 1e-12 * e * g) {
            break;
        }
        let step = [(f * b - g * a) / d, (f * a - e * b) / d];
        let at = [0, 1].map(|k| (sample.at[k] + piece.size * step[k]).clamp(0.0, 1.0));
        let next = surface.piece(sample.part, at).point(at).distance(sample.point);
        if !(next < best) {
            break;
        }
        (sample.at, best) = (at, next);
    }
    best
}

fn barycentric(p: DVec3, [a, b, c]: [DVec3; 3]) -> [f64; 3] {
    let normal = (b - a).cross(c - a);
    let square = normal.length_squared();
    if square <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let v = (p - a).cross(c - a).dot(normal) / square;
    let w = (b - a).cross(p - a).dot(normal) / square;
    [1.0 - v - w, v, w]
}

/// The surface as sums over control points, and what fairness asks of these.
pub struct Fit<'a> {
    net: &'a Net,
    rows: Limit<'a, Row>,
    fair: Vec<Row>,
}

impl<'a> Fit<'a> {
    /// The system of a net.
    pub fn new(net: &'a Net) -> Self {
        let own: Vec<Row> = (0..net.role.len() as u32).map(|v| Row(vec![(v, 1.0)])).collect();
        Fit { net, rows: Limit::new(net, &own, FIT_LEVELS), fair: fairness(net, &own) }
    }

    /// Rounds of feet and least squares, as long as they bring the surface nearer. Returns the largest and the root mean square
    /// distance of the vertices.
    pub fn run(&self, points: &mut [DVec3], samples: &mut [Sample], context: &Context) -> Result<[f64; 2]> {
        let parts = self.net.edge.len();
        let mut off = find_feet(samples, &Limit::new(self.net, points, FIT_LEVELS), parts, context)?;
        for fairness in FAIRNESS_WEIGHTS {
            self.solve(points, samples, fairness, context)?;
            let before = off;
            off = find_feet(samples, &Limit::new(self.net, points, FIT_LEVELS), parts, context)?;
            tracing::debug!(max = off[0], rms = off[1], "surface");
            if fairness <= LEAST_FAIRNESS && off[1] > ROUND_GAIN * before[1] {
                break;
            }
        }
        Ok(off)
    }

    fn solve(&self, points: &mut [DVec3], samples: &[Sample], fairness: f64, context: &Context) -> Result<()> {
        let n = points.len();
        let mut order: Vec<&Sample> = samples.iter().collect();
        order.sort_by_key(|s| s.part);
        let groups: Vec<&[&Sample]> = order.chunk_by(|a, b| a.part == b.part).collect();
        let one = |group: &&[&Sample]| {
            context.check()?;
            Ok(Local::of(&self.rows, group))
        };
        let locals: Vec<Local> = context.install(|| groups.par_iter().map(one).collect::<Result<_>>())?;
        let mut matrix = Matrix::new(n);
        let mut rhs = [vec![0.0; n], vec![0.0; n], vec![0.0; n]];
        for local in &locals {
            local.add_to(&mut matrix, &mut rhs);
        }
        let weight = fairness * samples.iter().map(|s| s.weight).sum::<f64>() / n as f64;
        for row in &self.fair {
            for &(i, a) in &row.0 {
                for &(j, b) in row.0.iter().filter(|t| t.0 <= i) {
                    matrix.add(i, j, weight * a * b);
                }
            }
        }
        // Control points without samples stay where they are.
        let hold = 1e-6 * weight.max(1e-9);
        for (k, p) in points.iter().enumerate() {
            matrix.add(k as u32, k as u32, hold);
            (0..3).for_each(|d| rhs[d][k] += hold * p[d]);
        }
        let factor = matrix.factor(&mut None)?;
        let [x, y, z] = [factor.solve(&rhs[0])?, factor.solve(&rhs[1])?, factor.solve(&rhs[2])?];
        points.iter_mut().enumerate().for_each(|(k, p)| *p = DVec3::new(x[k], y[k], z[k]));
        Ok(())
    }
}

/// What the samples of a part add to the normal equations.
struct Local {
    controls: Vec<u32>,
    matrix: Vec<f64>,
    rhs: Vec<DVec3>,
}

impl Local {
    fn of(rows: &Limit<'_, Row>, group: &[&Sample]) -> Self {
        // Samples on one piece are sums over the same sixteen rows.
        let mut pieces: Vec<Piece<Row>> = Vec::new();
        let mut on = Vec::with_capacity(group.len());
        for sample in group {
            if pieces.last().is_none_or(|p| p.size < 1.0) {
                pieces.push(rows.piece(sample.part, sample.at));
            }
            on.push(pieces.len() - 1);
        }
        let all = pieces.iter().flat_map(|p| p.points.as_flattened()).flat_map(|row| row.0.iter().map(|t| t.0));
        let mut controls: Vec<u32> = all.collect();
        controls.sort_unstable();
        controls.dedup();
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
        Local { controls, matrix, rhs }
    }

    fn add_to(&self, matrix: &mut Matrix<f64>, rhs: &mut [Vec<f64>; 3]) {
        let n = self.controls.len();
        for (i, &row) in self.controls.iter().enumerate() {
            (0..3).for_each(|d| rhs[d][row as usize] += self.rhs[i][d]);
            for (j, &column) in self.controls.iter().enumerate().take(i + 1) {
                matrix.add(row, column, self.matrix[i * n + j]);
            }
        }
    }
}

/// The second Laplacian of every control point; along borders that of the border.
fn fairness(net: &Net, own: &[Row]) -> Vec<Row> {
    let mut around: Vec<Vec<u32>> = vec![Vec::new(); own.len()];
    for fan in &net.fans {
        let v = fan.vertex as usize;
        match net.role[v] {
            Role::Smooth => around[v] = fan.spokes.iter().map(|&h| net.end(h)).collect(),
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
    (0..own.len()).filter(|&v| !around[v].is_empty()).map(|v| laplacian(&once, v)).collect()
}
