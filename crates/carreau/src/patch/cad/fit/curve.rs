//! Chains of mesh vertices as curves with few control points, within a tolerance.
//!
//! A chain is cut at sharp corners. Every section becomes a straight line if that is near enough, else a cubic spline by
//! least squares with fixed ends and a small bending energy; its knots are refined by bisection where vertices are too
//! far away, and its parameters are corrected by projection (Hoschek, CAGD 5, 1988). A section that no spline with fewer
//! control points than vertices can follow is cut at its worst vertex. The fit therefore always succeeds; at worst it is
//! the polyline itself.

#[cfg(test)]
mod tests;

use crate::error::Result;
use crate::geometry::bspline::{BSplineCurve, Knots};
use crate::numeric::banded::Banded;
use glam::DVec3;
use std::ops::RangeInclusive;

/// A curve near a chain of vertices, through its first and last one.
#[derive(Debug, Clone)]
pub struct ChainCurve {
    /// What the curve is.
    pub shape: Shape,
    /// The parameter of every vertex, in 0..=1.
    pub parameters: Vec<f64>,
    /// Largest distance of a vertex from the curve.
    pub deviation: f64,
}

/// A line, polyline or spline.
#[derive(Debug, Clone)]
pub enum Shape {
    /// Straight between these vertices of the chain, the first and the last included.
    Polyline(Vec<u32>),
    /// A cubic spline over 0..=1.
    Spline(BSplineCurve),
}

/// Weight of the bending energy: small enough not to flatten what the knots can follow.
pub const STIFFNESS: f64 = 1e-4;
/// Weight of a vertex that the curve goes through, against the others: what it is missed by is pulled in afterwards, and should
/// bend nothing.
const HELD: f64 = 1e6;
/// Rounds of parameter correction.
const CURVE_CORRECTIONS: usize = 3;
/// Distance from a straight line, as a share of its length, at which a vertex is on it: the rounding of its coordinates.
const STRAIGHT: f64 = 1e-14;
/// Attempts to fit a section of one chain; what is left then becomes polylines.
const ATTEMPTS: usize = 64;

impl ChainCurve {
    /// The curve of a chain of two vertices.
    pub fn straight() -> Self {
        ChainCurve { shape: Shape::Polyline(vec![0, 1]), parameters: vec![0.0, 1.0], deviation: 0.0 }
    }

    /// A curve within the tolerance, and through some of the inner vertices.
    pub fn fit(points: &[DVec3], through: &[usize], tolerance: f64) -> Result<Self> {
        let mut weights = vec![1.0; points.len()];
        through.iter().for_each(|&k| weights[k] = HELD);
        let mut out = Sections { points, weights, t: chord_lengths(points), pieces: Vec::new(), deviation: 0.0 };
        let corners = corners(points);
        let mut open: Vec<RangeInclusive<usize>> = corners.windows(2).rev().map(|w| w[0]..=w[1]).collect();
        let mut attempts = 0;
        while let Some(section) = open.pop() {
            attempts += 1;
            if let Some(cut) = out.add(section.clone(), tolerance, attempts <= ATTEMPTS)? {
                open.extend([cut..=*section.end(), *section.start()..=cut]);
            }
        }
        let mut whole = out.joined()?;
        if let Shape::Spline(curve) = &mut whole.shape {
            let held: Vec<(f64, DVec3)> = through.iter().map(|&k| (whole.parameters[k], points[k])).collect();
            curve.pull_through(&held);
        }
        Ok(whole)
    }

    /// The part from one vertex, which is that point, to a later one.
    pub fn part(&self, [i, j]: [usize; 2], ends: [DVec3; 2]) -> Result<Self> {
        let (a, b) = (self.parameters[i], self.parameters[j]);
        let shape = match &self.shape {
            Shape::Polyline(stops) => {
                let inner = stops.iter().copied().filter(|&k| i < k as usize && (k as usize) < j);
                let from = i as u32;
                Shape::Polyline([from].into_iter().chain(inner).chain([j as u32]).map(|k| k - from).collect())
            }
            Shape::Spline(curve) => {
                let [low, high] = curve.knots().domain();
                let mut part = curve.clone();
                if b < high {
                    part = part.split(b)?[0].clone();
                }
                if a > low {
                    part = part.split(a)?[1].clone();
                }
                Shape::Spline(part.between(ends).rescaled([0.0, 1.0]))
            }
        };
        let mut parameters: Vec<f64> = self.parameters[i..=j].iter().map(|t| (t - a) / (b - a)).collect();
        parameters[j - i] = 1.0;
        Ok(ChainCurve { shape, parameters, deviation: self.deviation })
    }

    /// The same the other way round.
    pub fn reversed(self) -> Self {
        let last = self.parameters.len() as u32 - 1;
        ChainCurve {
            shape: match self.shape {
                Shape::Polyline(stops) => Shape::Polyline(stops.iter().rev().map(|k| last - k).collect()),
                Shape::Spline(c) => Shape::Spline(c.reversed()),
            },
            parameters: self.parameters.iter().rev().map(|t| 1.0 - t).collect(),
            deviation: self.deviation,
        }
    }
}

/// Cumulative chord lengths over the whole length; equidistant where two vertices coincide.
fn chord_lengths(points: &[DVec3]) -> Vec<f64> {
    let mut t = Vec::with_capacity(points.len());
    let mut sum = 0.0;
    t.push(0.0);
    for w in points.windows(2) {
        sum += w[0].distance(w[1]);
        t.push(sum);
    }
    let last = points.len() - 1;
    t.iter_mut().for_each(|x| *x /= sum);
    t[last] = 1.0;
    if t.windows(2).all(|w| w[1] - w[0] > 1e-12) {
        return t;
    }
    (0..=last).map(|k| k as f64 / last as f64).collect()
}

/// First vertex, sharp corners, last vertex. A corner turns by more than 30° and by three times as much as the vertices
/// beside it: a coarse arc turns everywhere.
fn corners(points: &[DVec3]) -> Vec<usize> {
    let turn = |k: usize| (points[k] - points[k - 1]).angle_between(points[k + 1] - points[k]);
    let last = points.len() - 1;
    let turns: Vec<f64> = (0..=last).map(|k| if k == 0 || k == last { 0.0 } else { turn(k) }).collect();
    let sharp = |k: &usize| turns[*k] > 30f64.to_radians() && turns[*k] > 3.0 * turns[k - 1].max(turns[k + 1]);
    [0].into_iter().chain((1..last).filter(sharp)).chain([last]).collect()
}

/// The fitted sections of a chain, in order.
struct Sections<'a> {
    points: &'a [DVec3],
    weights: Vec<f64>,
    t: Vec<f64>,
    pieces: Vec<Section>,
    deviation: f64,
}

enum Section {
    /// A straight line between two vertices.
    Line(usize, usize),
    Spline(BSplineCurve),
}

impl Sections<'_> {
    /// Fits one section, or says where it has to be cut first.
    fn add(&mut self, range: RangeInclusive<usize>, tolerance: f64, may_fit: bool) -> Result<Option<usize>> {
        let (i, j) = (*range.start(), *range.end());
        let weights = &self.weights[range.clone()];
        let through = weights[1..weights.len() - 1].contains(&HELD);
        let slack = if through { STRAIGHT * self.points[i].distance(self.points[j]) } else { tolerance };
        if let Some((t, deviation)) = straight(&self.points[range.clone()], slack) {
            let (a, b) = (self.t[i], self.t[j]);
            (i + 1..j).zip(&t[1..]).for_each(|(k, s)| self.t[k] = a + s * (b - a));
            self.pieces.push(Section::Line(i, j));
            self.deviation = self.deviation.max(deviation);
            return Ok(None);
        }
        if !may_fit {
            (i..j).for_each(|k| self.pieces.push(Section::Line(k, k + 1)));
            return Ok(None);
        }
        let (a, b) = (self.t[i], self.t[j]);
        let local = self.t[range.clone()].iter().map(|t| (t - a) / (b - a)).collect();
        let fit = smooth(&self.points[range.clone()], weights, local, tolerance)?;
        if fit.deviation > tolerance {
            return Ok(Some(i + fit.worst.clamp(1, j - i - 1)));
        }
        (i + 1..j).zip(&fit.t[1..]).for_each(|(k, s)| self.t[k] = a + s * (b - a));
        self.pieces.push(Section::Spline(fit.curve.rescaled([a, b])));
        self.deviation = self.deviation.max(fit.deviation);
        Ok(None)
    }

    /// One polyline where all sections are straight, else one spline.
    fn joined(self) -> Result<ChainCurve> {
        let line = |s: &Section| if let Section::Line(_, j) = s { Some(*j as u32) } else { None };
        let stops: Option<Vec<u32>> = [Some(0)].into_iter().chain(self.pieces.iter().map(line)).collect();
        let shape = match stops {
            Some(stops) => Shape::Polyline(stops),
            None => {
                let as_cubic = |section: &Section| match section {
                    Section::Spline(c) => Ok(c.clone()),
                    Section::Line(i, j) => BSplineCurve::polyline(vec![self.points[*i], self.points[*j]])?
                        .rescaled([self.t[*i], self.t[*j]])
                        .elevated(),
                };
                Shape::Spline(BSplineCurve::joined(&self.pieces.iter().map(as_cubic).collect::<Result<Vec<_>>>()?)?)
            }
        };
        Ok(ChainCurve { shape, parameters: self.t, deviation: self.deviation })
    }
}

/// Positions along the segment between the ends, and the largest distance, if all vertices are near it and in order.
fn straight(points: &[DVec3], tolerance: f64) -> Option<(Vec<f64>, f64)> {
    let (a, b) = (points[0], points[points.len() - 1]);
    if points.len() == 2 {
        return Some((vec![0.0, 1.0], 0.0));
    }
    let axis = b - a;
    let scale = axis.length_squared();
    let t: Vec<f64> = points.iter().map(|p| (p - a).dot(axis) / scale).collect();
    if !t.windows(2).all(|w| w[1] - w[0] > 1e-12) {
        return None;
    }
    let deviation = points.iter().zip(&t).map(|(p, &t)| p.distance(a + t * axis)).fold(0.0, f64::max);
    (deviation <= tolerance).then_some((t, deviation))
}

/// An attempt to fit one smooth section.
struct Smooth {
    curve: BSplineCurve,
    t: Vec<f64>,
    deviation: f64,
    worst: usize,
}

/// A cubic spline over 0..=1 from the first to the last point, with as few spans as it takes, but never more control
/// points than there are vertices.
fn smooth(points: &[DVec3], weights: &[f64], mut t: Vec<f64>, tolerance: f64) -> Result<Smooth> {
    let mut breaks = vec![0.0, 1.0];
    loop {
        let knots = Knots::from_breaks(3, &breaks, 1)?;
        let mut best: Option<Smooth> = None;
        for _ in 0..=CURVE_CORRECTIONS {
            let curve = least_squares(&knots, points, weights, &t)?;
            for (t, p) in t.iter_mut().zip(points).skip(1).take(points.len() - 2) {
                *t = curve.project(*p, *t);
            }
            let at = |k: usize| curve.point(t[k]).distance(points[k]);
            let (worst, deviation) =
                (1..points.len() - 1).map(|k| (k, at(k))).fold((1, 0.0), |m, x| if x.1 > m.1 { x } else { m });
            if best.as_ref().is_none_or(|b| deviation < b.deviation) {
                best = Some(Smooth { curve, t: t.clone(), deviation, worst });
            }
            if deviation <= tolerance {
                break;
            }
        }
        let Some(best) = best else { return Err(crate::Error::Bug("a curve was not fitted".into())) };
        let far = |k: &usize| best.curve.point(best.t[*k]).distance(points[*k]) > tolerance;
        let marked: Vec<f64> = (1..points.len() - 1).filter(far).map(|k| best.t[k]).collect();
        let finer = bisected(&breaks, &marked, &best.t);
        if best.deviation <= tolerance || finer.len() == breaks.len() || finer.len() + 2 > points.len() {
            return Ok(best);
        }
        breaks = finer;
        t = best.t;
    }
}

/// Breaks with the middle of every span that holds a marked parameter and at least two parameters in all.
pub fn bisected(breaks: &[f64], marked: &[f64], all: &[f64]) -> Vec<f64> {
    let inside = |list: &[f64], w: &[f64]| list.iter().filter(|&&t| w[0] < t && t < w[1]).count();
    let mut out = vec![breaks[0]];
    for w in breaks.windows(2) {
        if inside(marked, w) > 0 && inside(all, w) >= 2 {
            out.push(0.5 * (w[0] + w[1]));
        }
        out.push(w[1]);
    }
    out
}

/// The control points that minimise Σ wᵢ |C(tᵢ) − pᵢ|² + λ ∫ |C''|², the first and the last one given.
fn least_squares(knots: &Knots, points: &[DVec3], weights: &[f64], t: &[f64]) -> Result<BSplineCurve> {
    let (n, p) = (knots.count(), knots.degree());
    let ends = [points[0], points[points.len() - 1]];
    let mut matrix = Banded::new(n - 2, p);
    let mut rhs = vec![DVec3::ZERO; n - 2];
    // Adds w · row rowᵀ for a row of p + 1 coefficients; known control points go to the right-hand side.
    let mut add = |first: usize, row: &[f64], weight: f64, target: DVec3| {
        let inner = |i: usize| (1..n - 1).contains(&i);
        for (i, &a) in (first..).zip(row).filter(|(i, _)| inner(*i)) {
            rhs[i - 1] += weight * a * target;
            for (j, &b) in (first..).zip(row) {
                match j {
                    0 => rhs[i - 1] -= weight * a * b * ends[0],
                    j if j == n - 1 => rhs[i - 1] -= weight * a * b * ends[1],
                    j if j <= i => matrix.add(i - 1, j - 1, weight * a * b),
                    _ => {}
                }
            }
        }
    };
    for ((&t, &target), &weight) in t.iter().zip(points).zip(weights).skip(1).take(points.len() - 2) {
        let (first, basis) = knots.basis(t);
        add(first, &basis[..=p], weight, target);
    }
    let breaks = knots.breaks();
    let spans = (breaks.len() - 1) as f64;
    let stiffness = STIFFNESS * (points.len() - 2).max(1) as f64 / (spans * std::f64::consts::PI).powi(4);
    for w in breaks.windows(2) {
        for g in [-1.0, 1.0] {
            // Two Gauss points: the second derivative is linear in a span.
            let (half, middle) = (0.5 * (w[1] - w[0]), 0.5 * (w[0] + w[1]));
            let (first, [_, _, second]) = knots.derivatives(middle + g * half / 3f64.sqrt());
            add(first, &second[..=p], stiffness * half, DVec3::ZERO);
        }
    }
    if !matrix.solve(&mut rhs) {
        return Err(crate::Error::Numeric("the equations of a curve fit are singular".into()));
    }
    BSplineCurve::new(knots.clone(), [ends[0]].into_iter().chain(rhs).chain([ends[1]]).collect())
}
