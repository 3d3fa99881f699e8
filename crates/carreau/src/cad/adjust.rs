//! Surfaces adjusted together: least squares over all vertices, with conditions that hold between the surfaces.
//!
//! A condition is met exactly, not on average: a fillet that misses its plane by the noise of a remesh has no edge with it. The
//! minimum under conditions is found by the method of multipliers (Hestenes, *Multiplier and gradient methods*, Journal of
//! Optimization Theory and Applications 4, 1969), which minds no condition that follows from others, and Gauss–Newton steps.
//!
//! Every surface moves as a rigid body and changes its shape by up to two numbers. Motions that leave it as it is are held by a small
//! weight, so that all kinds have the same unknowns:
//!
//! | unknowns | what |
//! |---|---|
//! | 0, 1, 2 | translation |
//! | 3, 4, 5 | rotation around the middle of its vertices, times its size |
//! | 6 | radius; half angle of a cone, times its size; major radius of a torus |
//! | 7 | minor radius of a torus |

use super::tuning::NAMED_DISTANCE;
use crate::context::Context;
use crate::error::Result;
use crate::geometry::primitive::Primitive;
use crate::numeric::dense::{cholesky, inverse};
use crate::numeric::sparse::{Matrix, Plan};
use glam::{DQuat, DVec3};

/// A count: unknowns of a surface, which are three of a shift, three of a turn and two of its radii.
const UNKNOWNS: usize = 8;
/// Derivatives of a number by the unknowns of a surface.
pub type Row = [f64; UNKNOWNS];

/// A count: most steps. Convergence is quadratic but for the multipliers, which gain some digits a step.
const ADJUST_STEPS: usize = 40;
/// A count: steps in which the conditions are to come nearer by half, because those that contradict each other never
/// do.
const STUCK_STEPS: usize = 8;
/// A share of the diagonal: conditions are met when all are nearer than this, some hundred roundings of a double.
const MET_DISTANCE: f64 = 1e-13;
/// A share of the diagonal: conditions that come no nearer are taken for met from here on, because edges that are half of
/// a named curve's distance off their surfaces are as good as exact.
const NEARLY_MET_DISTANCE: f64 = 0.5 * NAMED_DISTANCE;
/// A share of the diagonal: a step below this changes nothing, because motions that change nothing go on by their
/// roundings.
const SETTLED_STEP: f64 = 1e-7;
/// Weight of a condition where every surface has a largest curvature of one, because a larger one needs fewer steps and
/// a smaller one keeps more digits.
const CONDITION_WEIGHT: f64 = 1e4;
/// A count: rounds of the multipliers of a step; five suffice because each gains as many digits as the weight of a
/// condition has.
const MULTIPLIER_ROUNDS: usize = 5;
/// Weight of a step in the same measure: small, because it only holds motions that change nothing. The minimum is the
/// same.
const STAY_WEIGHT: f64 = 1e-7;

/// A surface with the vertices that it is to be near, lengths as shares of the diagonal.
#[derive(Debug, Clone)]
pub struct Body {
    /// The surface.
    pub primitive: Primitive,
    /// Vertices.
    pub points: Vec<DVec3>,
    /// Standard deviation of their distances.
    pub sigma: f64,
    middle: DVec3,
    size: f64,
}

impl Body {
    /// A surface near points.
    pub fn new(primitive: Primitive, points: Vec<DVec3>, sigma: f64) -> Self {
        let middle = points.iter().sum::<DVec3>() / points.len().max(1) as f64;
        let size = points.iter().map(|p| p.distance(middle)).fold(f64::MIN_POSITIVE, f64::max);
        Body { primitive, points, sigma, middle, size }
    }

    /// Signed distance of a point, and its derivatives by the unknowns.
    pub fn distance(&self, p: DVec3) -> (f64, Row) {
        let g = self.primitive.normal(p);
        let turn = g.cross(p - self.middle) / self.size;
        let shape = match self.primitive {
            Primitive::Plane { .. } => [0.0, 0.0],
            Primitive::Sphere { .. } | Primitive::Cylinder { .. } => [-1.0, 0.0],
            Primitive::Cone { apex, axis, half_angle } => {
                let (z, (sin, cos)) = ((p - apex).dot(axis), half_angle.sin_cos());
                let rho = (p - apex - axis * z).length();
                [-(rho * sin + z * cos) / self.size, 0.0]
            }
            Primitive::Torus { center, axis, .. } => {
                let radial = (p - center - axis * axis.dot(p - center)).normalize_or_zero();
                [-g.dot(radial), -1.0]
            }
        };
        let row = [-g.x, -g.y, -g.z, turn.x, turn.y, turn.z, shape[0], shape[1]];
        (self.primitive.distance(p), row)
    }

    /// Root mean square and largest distance of the points.
    pub fn residuals(&self) -> [f64; 2] {
        let far = self.points.iter().map(|&p| self.primitive.distance(p).abs());
        let [sum, max] = far.fold([0.0, 0.0f64], |[sum, max], d| [sum + d * d, max.max(d)]);
        [(sum / self.points.len().max(1) as f64).sqrt(), max]
    }

    /// Derivatives of what changes by `moment · ω` where the surface turns by ω.
    pub fn turned(&self, moment: DVec3) -> Row {
        let turn = moment / self.size;
        [0.0, 0.0, 0.0, turn.x, turn.y, turn.z, 0.0, 0.0]
    }

    /// Derivatives of `along · p` where the point p moves with the surface.
    pub fn carried(&self, p: DVec3, along: DVec3) -> Row {
        let [_, _, _, x, y, z, ..] = self.turned((p - self.middle).cross(along));
        [along.x, along.y, along.z, x, y, z, 0.0, 0.0]
    }

    /// The middle of its vertices.
    pub fn middle(&self) -> DVec3 {
        self.middle
    }

    /// Covariance of the unknowns, row by row, from the standard deviation of the distances.
    pub fn covariance(&self) -> Option<Vec<f64>> {
        let (block, _) = normal_equations(self);
        let largest = (0..UNKNOWNS).map(|k| block[k][k]).fold(f64::MIN_POSITIVE, f64::max);
        let entry = |i: usize, j: usize| block[i.max(j)][i.min(j)] + if i == j { STAY_WEIGHT * largest } else { 0.0 };
        let full: Vec<f64> = (0..UNKNOWNS * UNKNOWNS).map(|k| entry(k / UNKNOWNS, k % UNKNOWNS)).collect();
        Some(inverse(&cholesky(&full, UNKNOWNS)?, UNKNOWNS))
    }

    /// Standard deviation of a number that follows the unknowns with these derivatives.
    pub fn deviation(covariance: &[f64], row: &Row) -> f64 {
        let of = |k: usize| row[k / UNKNOWNS] * row[k % UNKNOWNS] * covariance[k];
        (0..UNKNOWNS * UNKNOWNS).map(of).sum::<f64>().max(0.0).sqrt()
    }

    /// Standard deviation of the surface's direction in radians, from that of its distances.
    pub fn turn_deviation(&self) -> f64 {
        let least = self.sigma / self.size;
        let Some(covariance) = self.covariance() else { return least };
        let Some(own) = direction(&self.primitive) else { return f64::INFINITY };
        let (x, y) = own.any_orthonormal_pair();
        let of = |e: DVec3| Self::deviation(&covariance, &[0.0, 0.0, 0.0, e.x, e.y, e.z, 0.0, 0.0]);
        (of(x).hypot(of(y)) / self.size).max(0.5 * least)
    }

    pub fn moved(&self, step: &[f64]) -> Option<Primitive> {
        let shift = DVec3::new(step[0], step[1], step[2]);
        let turn = DQuat::from_scaled_axis(DVec3::new(step[3], step[4], step[5]) / self.size);
        let at = |p: DVec3| self.middle + shift + turn * (p - self.middle);
        let along = |d: DVec3| (turn * d).normalize_or(d);
        let [a, b] = [step[6], step[7]];
        let primitive = match self.primitive {
            Primitive::Plane { origin, normal } => Primitive::Plane { origin: at(origin), normal: along(normal) },
            Primitive::Sphere { center, radius } => Primitive::Sphere { center: at(center), radius: radius + a },
            Primitive::Cylinder { origin, axis, radius } => {
                Primitive::Cylinder { origin: at(origin), axis: along(axis), radius: radius + a }
            }
            Primitive::Cone { apex, axis, half_angle } => {
                Primitive::Cone { apex: at(apex), axis: along(axis), half_angle: half_angle + a / self.size }
            }
            Primitive::Torus { center, axis, major_radius, minor_radius } => Primitive::Torus {
                center: at(center),
                axis: along(axis),
                major_radius: major_radius + a,
                minor_radius: minor_radius + b,
            },
        };
        primitive.is_sound().then_some(primitive)
    }
}

/// The normal of a plane or the axis of what is round; a sphere has none.
pub fn direction(primitive: &Primitive) -> Option<DVec3> {
    match *primitive {
        Primitive::Plane { normal, .. } => Some(normal),
        Primitive::Cylinder { axis, .. } | Primitive::Cone { axis, .. } | Primitive::Torus { axis, .. } => Some(axis),
        Primitive::Sphere { .. } => None,
    }
}

/// A number that is to be zero, by the surfaces that it depends on and its derivatives by their unknowns.
#[derive(Debug, Clone)]
pub struct Condition {
    /// What it is now.
    pub value: f64,
    /// Surfaces, each once.
    pub by: Vec<(u32, Row)>,
}

/// Moves surfaces to the least sum of squares under conditions, which are stated anew for every step, in the same order. Returns the
/// multiplier of every condition, `None` where they cannot all be met; surfaces then are where the last step left them.
pub fn adjust(
    bodies: &mut [Body],
    conditions: impl Fn(&[Body]) -> Vec<Condition>,
    context: &Context,
) -> Result<Option<Vec<f64>>> {
    let mut plan = None;
    let mut stated = conditions(bodies);
    let mut before = [f64::INFINITY; STUCK_STEPS];
    let mut nearly_met = None;
    for k in 0..ADJUST_STEPS {
        context.check()?;
        let system = System::new(bodies, &stated);
        let Some((step, multipliers)) = system.step(&stated, &mut plan) else { return Ok(None) };
        for (body, step) in bodies.iter_mut().zip(step.chunks(UNKNOWNS)) {
            let Some(primitive) = body.moved(step) else { return Ok(None) };
            body.primitive = primitive;
        }
        stated = conditions(bodies);
        let worst = stated.iter().map(|c| c.value.abs()).fold(0.0, f64::max);
        let moved = step.iter().map(|x| x.abs()).fold(0.0, f64::max);
        tracing::debug!(worst, moved, "step");
        // Conditions that contradict each other stop at what they disagree by.
        let stuck = worst > 0.5 * std::mem::replace(&mut before[k % STUCK_STEPS], worst) && worst > MET_DISTANCE;
        if !(worst.is_finite() && moved < 1.0) {
            return Ok(None);
        }
        if worst <= MET_DISTANCE && moved <= SETTLED_STEP {
            return Ok(Some(multipliers));
        }
        nearly_met = (worst <= NEARLY_MET_DISTANCE).then_some(multipliers);
        if stuck {
            break;
        }
    }
    Ok(nearly_met)
}

/// ½ Σ (d / σ)² + Σ (m c + ½ w c²), all linearised, with unknowns scaled so that every surface has a largest curvature of one.
struct System {
    squares: Vec<([Row; UNKNOWNS], Row)>,
    /// One for every surface: a step is so many times its scaled unknowns.
    scales: Vec<f64>,
    /// One for every condition.
    weights: Vec<f64>,
}

impl System {
    fn new(bodies: &[Body], stated: &[Condition]) -> Self {
        let squares: Vec<([Row; UNKNOWNS], Row)> = bodies.iter().map(normal_equations).collect();
        let largest = |s: &([Row; UNKNOWNS], Row)| (0..UNKNOWNS).map(|k| s.0[k][k]).fold(f64::MIN_POSITIVE, f64::max);
        let scales: Vec<f64> = squares.iter().map(|s| largest(s).sqrt().recip()).collect();
        let weight = |c: &Condition| {
            let square = |(b, row): &(u32, Row)| row.iter().map(|x| (x * scales[*b as usize]).powi(2)).sum::<f64>();
            CONDITION_WEIGHT / c.by.iter().map(square).sum::<f64>().max(f64::MIN_POSITIVE)
        };
        let weights = stated.iter().map(weight).collect();
        System { squares, scales, weights }
    }

    /// The step to its minimum where the linearised conditions are zero, and the multipliers, which are found anew for every step:
    /// conditions that follow from each other agree to first order only, and what they disagree by must not add up.
    fn step(&self, stated: &[Condition], plan: &mut Option<Plan>) -> Option<(Vec<f64>, Vec<f64>)> {
        let n = UNKNOWNS * self.squares.len();
        let mut matrix = Matrix::new(n);
        let mut rhs = vec![0.0; n];
        for (b, ((block, slope), scale)) in self.squares.iter().zip(&self.scales).enumerate() {
            let first = UNKNOWNS * b;
            for (i, (line, slope)) in block.iter().zip(slope).enumerate() {
                for (j, x) in line[..=i].iter().enumerate() {
                    let held = if i == j { STAY_WEIGHT } else { 0.0 };
                    matrix.add((first + i) as u32, (first + j) as u32, x * scale * scale + held);
                }
                rhs[first + i] -= slope * scale;
            }
        }
        let scaled = |c: &Condition| -> Vec<(u32, f64)> {
            let of = |(b, row): &(u32, Row)| {
                let (first, scale) = (UNKNOWNS as u32 * b, self.scales[*b as usize]);
                row.map(|x| x * scale).into_iter().zip(first..).map(|(x, i)| (i, x)).collect::<Vec<_>>()
            };
            c.by.iter().flat_map(of).collect()
        };
        let rows: Vec<Vec<(u32, f64)>> = stated.iter().map(scaled).collect();
        for (row, w) in rows.iter().zip(&self.weights) {
            for &(i, x) in row {
                row.iter().filter(|t| t.0 <= i).for_each(|&(j, y)| matrix.add(i, j, w * x * y));
            }
        }
        let factor = matrix.factor(plan).ok()?;
        let mut multipliers = vec![0.0; stated.len()];
        let mut step = Vec::new();
        for _ in 0..MULTIPLIER_ROUNDS {
            let mut all = rhs.clone();
            for (((row, w), m), c) in rows.iter().zip(&self.weights).zip(&multipliers).zip(stated) {
                row.iter().for_each(|&(i, x)| all[i as usize] -= x * (m + w * c.value));
            }
            step = factor.solve(&all).ok()?;
            for (((row, w), m), c) in rows.iter().zip(&self.weights).zip(&mut multipliers).zip(stated) {
                *m += w * (c.value + row.iter().map(|&(i, x)| x * step[i as usize]).sum::<f64>());
            }
        }
        step.chunks_mut(UNKNOWNS).zip(&self.scales).for_each(|(x, s)| x.iter_mut().for_each(|x| *x *= s));
        Some((step, multipliers))
    }
}

/// Σ row rowᵀ / σ² and Σ d row / σ² over the points of a surface.
fn normal_equations(body: &Body) -> ([Row; UNKNOWNS], Row) {
    let (mut block, mut slope) = ([[0.0; UNKNOWNS]; UNKNOWNS], [0.0; UNKNOWNS]);
    let weight = (body.sigma * body.sigma).recip();
    for &p in &body.points {
        let (d, row) = body.distance(p);
        for (i, x) in row.iter().enumerate() {
            slope[i] += weight * d * x;
            block[i].iter_mut().zip(&row[..=i]).for_each(|(sum, y)| *sum += weight * x * y);
        }
    }
    (block, slope)
}
