//! The fit in rounds: feet of the samples, then least squares (Hoschek, *Intrinsic parametrization for approximation*, CAGD 5,
//! 1988). Feet only creep along the surface from round to round; Anderson's extrapolation of the rounds before (*Iterative
//! procedures for nonlinear integral equations*, J. ACM 12, 1965) takes many of their steps at once.
//!
//! Closest points alone do not unfold what quads left folded, in grooves and between fingers: there the surface is made stiffer, from
//! round to round, until it rounds the place off.

use super::feet::{Sample, Scan, find_feet, find_first_feet, own};
use super::fit::{FIT_LEVELS, Fit};
use super::limit::Limit;
use super::net::Net;
use super::relax::relax;
use crate::context::Context;
use crate::error::Result;
use crate::numeric::dense;
use glam::DVec3;

/// Weight of fairness for a control point in the first rounds, for all the samples of one: large first, because these untangle.
const FIRST_FAIRNESS: [f64; 3] = [1e-2, 1e-3, 1e-4];
/// The same in all other rounds: small, because the samples are to decide there.
const LEAST_FAIRNESS: f64 = 1e-5;
/// A count: most rounds with the least fairness.
const ROUNDS: usize = 12;
/// A count: most rounds besides in which the surface becomes stiffer where it is turned over, because each costs as much as the
/// first.
const UNFOLDING_ROUNDS: usize = 12;
/// A count: such rounds without gain, because stiffness spreads from what is turned over and takes some rounds to get around it.
const UNFOLDING_PATIENCE: usize = 4;
/// A share of the distances before: rounds go on while they bring one of them below, because each costs as much as the first.
const ROUND_GAIN: f64 = 0.95;
/// A count: rounds that are remembered, because older ones were about other feet.
const MEMORY: usize = 5;
/// A share of the squares of the steps: what keeps the extrapolation from making much of steps that are nearly the same.
const RIDGE: f64 = 1e-8;

/// How near the surface is to be.
#[derive(Debug, Clone, Copy)]
pub struct Goal {
    /// The largest distance of a vertex.
    pub max: f64,
    /// The root mean square of the distances.
    pub rms: f64,
}

/// Which of the fits it is.
#[derive(Debug, Clone, Copy)]
pub struct Turn {
    /// Before any division.
    pub is_first: bool,
    /// After the last one.
    pub is_last: bool,
    /// Whether there are vertices for more control points: without, the mean is what it is.
    pub has_finer: bool,
}

impl Turn {
    /// Whether no other fit comes after one that is so near.
    pub fn ends(self, goal: Goal, [max, rms]: [f64; 2]) -> bool {
        self.is_last || max <= goal.max && (rms <= goal.rms || !self.has_finer)
    }
}

/// Fits a surface, as long as rounds bring it nearer and it is not near enough. Returns the largest and the root mean square distance
/// of the vertices.
pub fn run(
    net: &Net,
    points: &mut Vec<DVec3>,
    vertices: &mut [Sample],
    scan: &Scan,
    (turn, goal): (Turn, Goal),
    context: &Context,
) -> Result<[f64; 2]> {
    let mut fitting = Fitting::new(net, scan, context);
    let (mut surface, mut off) = if turn.is_first {
        find_first_feet(vertices, net, points, context)?;
        (None, [f64::INFINITY; 2])
    } else {
        relax(net, points);
        let (surface, off) = fitting.surface(points, vertices)?;
        (Some(surface), off)
    };
    let mut memory = Memory::default();
    let first: &[f64] = if turn.is_first { &FIRST_FAIRNESS } else { &[] };
    for round in 0..first.len() + ROUNDS {
        let is_last_fairness = round >= first.len();
        let fairness = first.get(round).copied().unwrap_or(LEAST_FAIRNESS);
        let mut samples = vertices.to_vec();
        if let Some(surface) = &surface {
            samples.extend(own(net, surface, points, scan, context)?.0);
        }
        let solved = fitting.fit.solve(points, &samples, fairness, context)?;
        let guess = if is_last_fairness { memory.extrapolated(points, &solved) } else { None };
        let before = off;
        *points = guess.as_ref().unwrap_or(&solved).clone();
        if !is_last_fairness {
            relax(net, points);
        }
        let mut found = fitting.surface(points, vertices)?;
        if guess.is_some() && found.1[1] > before[1] {
            *points = solved;
            memory = Memory::default();
            found = fitting.surface(points, vertices)?;
        }
        off = found.1;
        surface = Some(found.0);
        tracing::debug!(max = off[0], rms = off[1], extrapolated = guess.is_some(), "surface");
        let is_near = off[0] <= goal.max && off[1] <= goal.rms;
        let gains = off[0] < ROUND_GAIN * before[0] || off[1] < ROUND_GAIN * before[1];
        if is_last_fairness && (is_near || !gains) {
            break;
        }
    }
    tracing::debug!(quads = net.quads.len(), max = off[0], rms = off[1], "fitted");
    Ok(off)
}

/// What rounds need.
pub struct Fitting<'a> {
    net: &'a Net,
    scan: &'a Scan,
    fit: Fit<'a>,
    context: &'a Context,
}

impl<'a> Fitting<'a> {
    /// Of a net.
    pub fn new(net: &'a Net, scan: &'a Scan, context: &'a Context) -> Self {
        Fitting { net, scan, fit: Fit::new(net), context }
    }

    /// The surface of control points, and how far the vertices are from it, which get their feet there.
    pub fn surface(&self, points: &[DVec3], vertices: &mut [Sample]) -> Result<(Limit<'a, DVec3>, [f64; 2])> {
        let surface = Limit::new(self.net, points, FIT_LEVELS);
        let off = find_feet(vertices, &surface, self.net, points, self.context)?;
        Ok((surface, off))
    }

    /// Makes the surface stiffer where it is turned over, as long as that helps.
    pub fn unfold(&mut self, points: &mut Vec<DVec3>, vertices: &mut [Sample]) -> Result<()> {
        let (mut surface, _) = self.surface(points, vertices)?;
        let (mut least, mut waited) = (usize::MAX, 0);
        for _ in 0..UNFOLDING_ROUNDS {
            let (own, turned) = own(self.net, &surface, points, self.scan, self.context)?;
            waited = if turned.len() < least { 0 } else { waited + 1 };
            least = least.min(turned.len());
            if turned.is_empty() || waited == UNFOLDING_PATIENCE {
                break;
            }
            self.fit.stiffen(&turned);
            let samples = [&*vertices, &own[..]].concat();
            *points = self.fit.solve(points, &samples, LEAST_FAIRNESS, self.context)?;
            let off;
            (surface, off) = self.surface(points, vertices)?;
            tracing::debug!(turned = turned.len(), max = off[0], rms = off[1], "unfolded");
        }
        Ok(())
    }
}

/// What the last rounds began with and came to.
#[derive(Default)]
struct Memory {
    /// Control points that were solved for, and how far they were from those before.
    rounds: Vec<(Vec<DVec3>, Vec<DVec3>)>,
}

impl Memory {
    /// Remembers a round. Returns where the steps of all of them would come to rest, if there are several.
    fn extrapolated(&mut self, from: &[DVec3], to: &[DVec3]) -> Option<Vec<DVec3>> {
        let step: Vec<DVec3> = to.iter().zip(from).map(|(a, b)| a - b).collect();
        self.rounds.push((to.to_vec(), step));
        if self.rounds.len() > MEMORY {
            self.rounds.remove(0);
        }
        let (last, before) = self.rounds.split_last()?;
        let change =
            |of: &[DVec3], other: &[DVec3]| -> Vec<DVec3> { of.iter().zip(other).map(|(a, b)| a - b).collect() };
        let changes: Vec<[Vec<DVec3>; 2]> =
            before.iter().map(|r| [change(&last.0, &r.0), change(&last.1, &r.1)]).collect();
        let dot = |a: &[DVec3], b: &[DVec3]| a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum::<f64>();
        let n = changes.len();
        let mut matrix: Vec<f64> = (0..n * n).map(|k| dot(&changes[k / n][1], &changes[k % n][1])).collect();
        (0..n).for_each(|k| matrix[k * n + k] *= 1.0 + RIDGE);
        let rhs: Vec<f64> = changes.iter().map(|c| dot(&c[1], &last.1)).collect();
        let shares = dense::solve(&dense::cholesky(&matrix, n)?, n, &rhs);
        let mut out = to.to_vec();
        for (share, [change, _]) in shares.iter().zip(&changes) {
            out.iter_mut().zip(change).for_each(|(p, c)| *p -= share * c);
        }
        (n > 0 && out.iter().all(|p| p.is_finite())).then_some(out)
    }
}
