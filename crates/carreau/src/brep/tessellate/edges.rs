//! Samples of edges: halved until chords are near the curve and tangents turn little.

use super::Fineness;
use crate::brep::boundary::EdgeSamples;
use crate::brep::{Brep, Curve, Edge};
use rayon::prelude::*;
use std::f64::consts::FRAC_PI_2;

/// Most halvings of a piece.
const MAX_EDGE_HALVINGS: u32 = 10;
/// Fewest pieces of a closed edge, so that its samples are a polygon with an inside.
const CLOSED_PIECES: usize = 6;

/// Samples of all edges. Ids: the vertices of the model, then the inner samples edge by edge.
pub(crate) fn sample_edges(brep: &Brep, fineness: &Fineness) -> Vec<EdgeSamples> {
    sample_edges_each(brep, |_| *fineness)
}

/// The same with a fineness for every edge.
pub(crate) fn sample_edges_each(brep: &Brep, fineness: impl Fn(usize) -> Fineness + Sync) -> Vec<EdgeSamples> {
    let one = |(k, edge): (usize, &Edge)| sample(brep, edge, &fineness(k));
    let mut out: Vec<EdgeSamples> = brep.edges.par_iter().enumerate().map(one).collect();
    let mut next = brep.vertices.len() as u32;
    for (edge, samples) in brep.edges.iter().zip(&mut out) {
        let inner = samples.points.len() as u32 - 2;
        samples.ids = [edge.ends[0]].into_iter().chain(next..next + inner).chain([edge.ends[1]]).collect();
        next += inner;
    }
    out
}

/// Parameters and points of one edge; its ends are its vertices.
fn sample(brep: &Brep, edge: &Edge, fineness: &Fineness) -> EdgeSamples {
    let mut parameters = vec![edge.range[0]];
    for w in starts(edge).windows(2) {
        divide(&edge.curve, [w[0], w[1]], fineness, 0, &mut parameters);
    }
    let mut points: Vec<_> = parameters.iter().map(|&t| edge.curve.point(t)).collect();
    let last = points.len() - 1;
    points[0] = brep.point(edge.ends[0]);
    points[last] = brep.point(edge.ends[1]);
    EdgeSamples { parameters, points, ids: Vec::new() }
}

/// The parameters between which a curve is smooth and turns by less than a right angle or so.
pub(crate) fn starts(edge: &Edge) -> Vec<f64> {
    let [a, b] = edge.range;
    let least = if edge.is_closed() { CLOSED_PIECES } else { 1 };
    let even = |n: usize| (0..=n).map(|k| edge.parameter_at(k as f64 / n as f64)).collect::<Vec<f64>>();
    match &edge.curve {
        Curve::Line { .. } => vec![a, b],
        Curve::Circle { .. } | Curve::Ellipse { .. } => even(least.max(((b - a) / FRAC_PI_2).ceil() as usize)),
        Curve::Parabola { .. } | Curve::Hyperbola { .. } => even(2),
        Curve::Spline(s) => {
            let [low, high] = s.knots().domain();
            let period = high - low;
            // A range of a closed spline may run over its joint.
            let turns = [0.0, 1.0].into_iter().filter(|k| edge.curve.period().is_some() || *k == 0.0);
            let breaks = turns.flat_map(|k| s.knots().breaks().into_iter().map(move |t| t + k * period));
            let tiny = 1e-9 * (b - a);
            let mut inner: Vec<f64> = breaks.filter(|&t| t > a + tiny && t < b - tiny).collect();
            inner.dedup();
            let all: Vec<f64> = [a].into_iter().chain(inner).chain([b]).collect();
            if all.len() > least { all } else { even(least) }
        }
    }
}

/// Appends the parameters of a piece after its first one.
fn divide(curve: &Curve, [a, b]: [f64; 2], fineness: &Fineness, depth: u32, out: &mut Vec<f64>) {
    let middle = 0.5 * (a + b);
    let [p, q] = [curve.derivatives(a), curve.derivatives(b)];
    let sagitta = |share: f64| {
        let x = curve.point(a + share * (b - a));
        let chord = q[0] - p[0];
        let foot = (x - p[0]).dot(chord) / chord.length_squared();
        x.distance(p[0] + foot.clamp(0.0, 1.0) * chord)
    };
    // The quarters, too: a chord may pass through the middle of an S.
    let far = [0.25, 0.5, 0.75].into_iter().map(sagitta).fold(0.0, f64::max) > fineness.chord;
    let turned = p[1].angle_between(q[1]) > fineness.angle;
    if (far || turned) && curve.kind() != crate::brep::CurveKind::Line && depth < MAX_EDGE_HALVINGS {
        divide(curve, [a, middle], fineness, depth + 1, out);
        divide(curve, [middle, b], fineness, depth + 1, out);
    } else {
        out.push(b);
    }
}
