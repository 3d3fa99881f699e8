//! Strips between features are straightened: the vertices of both sides slide together until the rows across are upright.
//!
//! ```text
//!  ━━w━━━w━━━w━━        ━━w━━━w━━━w━━
//!     ╲   ╲   ╲     →     │   │   │
//!  ━━━━━v━━━v━━━v       ━━v━━━v━━━v━━
//! ```
//!
//! Smoothing slides one vertex after the other, and a row that leans keeps the rows beside it from getting up: how a ring is
//! turned against the next one does not change. Here all vertices move at once, by the u along their curves for which
//!
//! Σ (lean of a row / its length)² + Σ (change of an edge / its length)²
//!
//! over the rows across and the edges along features is least.

use super::around::{Around, BAD_JACOBIAN};
use super::smooth::jacobian;
use super::source::Source;
use super::validate::keeps_feature;
use super::work::{Place, Work};
use crate::context::Context;
use crate::error::Result;
use crate::mesh::NONE;
use crate::numeric::sparse::LeastSquares;
use glam::DVec3;

/// A sine: rows that lean by less need nothing, because smoothing does the rest.
const LEAN_SINE: f64 = 0.5;
/// A cosine: rows between curves whose directions differ by more are not across a strip, because they have no direction
/// to lean from.
const STRIP_COSINE: f64 = 0.7;
/// A count: steps at most, more than one because curves bend and each step takes them for straight.
const STRAIGHTEN_STEPS: usize = 8;
/// A share of its edges: no vertex moves farther in one step, because it would come past its neighbours.
const STRAIGHTEN_REACH: f64 = 0.5;
/// A weight over that of the changes of edges: it holds sides that nothing holds, small because it is not to be felt
/// elsewhere.
const SIDE_HOLD: f64 = 1e-6;

/// Straightens the strips, if there are some that lean.
pub fn straighten(work: &mut Work, around: &Around, source: &Source, context: &Context) -> Result<()> {
    let rows = rows(work, around);
    let mut known = None;
    for _ in 0..STRAIGHTEN_STEPS {
        context.check()?;
        let tangents = tangents(work, around);
        let leans: Vec<Lean> = rows.iter().filter_map(|row| Lean::of(work, &tangents, row)).collect();
        if !leans.iter().any(|lean| lean.sine.abs() > LEAN_SINE) {
            break;
        }
        // Where lengths differ beyond what doubles hold it is not to be solved: the vertices stay.
        let Some(u) = slides(work, &tangents, &leans) else { break };
        let was = known.take().unwrap_or_else(|| Skew::of(work));
        let before = move_rows(work, source, &tangents, &rows, &u);
        let is = Skew::of(work);
        if is.turned > was.turned || is.squares >= was.squares {
            work.points = before;
            break;
        }
        known = Some(is);
    }
    Ok(())
}

/// How far quads are from right angles.
#[derive(Default)]
struct Skew {
    /// Quads that are turned over, or all but.
    turned: usize,
    /// Sum of squares of what scaled Jacobians lack of one.
    squares: f64,
}

impl Skew {
    fn of(work: &Work) -> Self {
        let mut skew = Skew::default();
        for jacobian in (0..work.faces.len() as u32).map(|q| jacobian(work, q)) {
            skew.turned += usize::from(jacobian <= BAD_JACOBIAN);
            skew.squares += (1.0 - jacobian).powi(2);
        }
        skew
    }
}

/// The vertices of every row that leads straight from one feature to another.
fn rows(work: &Work, around: &Around) -> Vec<Vec<u32>> {
    let mut rows = Vec::new();
    for v in (0..work.points.len() as u32).filter(|&v| is_on_curve(work, around, v)) {
        for first in across(work, around, v) {
            let mut row = vec![v, first];
            while let Some(next) = straight_on(work, around, &row) {
                row.push(next);
            }
            let last = row[row.len() - 1];
            // Each is found from both ends.
            if v < last && is_on_curve(work, around, last) {
                rows.push(row);
            }
        }
    }
    rows
}

/// Whether a vertex is on a feature, but no corner.
fn is_on_curve(work: &Work, around: &Around, v: u32) -> bool {
    !matches!(work.place[v as usize], Place::Region(_)) && around.neighbours[v as usize].len() == 2
}

/// The neighbours of a vertex on a feature that are not along it.
fn across(work: &Work, around: &Around, v: u32) -> Vec<u32> {
    let beside = |&q: &u32| {
        let face = work.faces.face(q as usize);
        let at = face.iter().position(|&w| w == v).unwrap_or(0);
        [face[(at + 1) % face.len()], face[(at + face.len() - 1) % face.len()]]
    };
    let mut all: Vec<u32> = around.quads[v as usize].iter().flat_map(beside).collect();
    all.sort_unstable();
    all.dedup();
    all.retain(|w| !around.neighbours[v as usize].contains(w));
    all
}

/// The vertex that follows after a row, if its end is a regular one inside a region.
fn straight_on(work: &Work, around: &Around, row: &[u32]) -> Option<u32> {
    let [.., before, at] = row else { return None };
    let quads = &around.quads[*at as usize];
    if !matches!(work.place[*at as usize], Place::Region(_)) || quads.len() != 4 || row.len() > work.faces.len() {
        return None;
    }
    let mut ahead = quads.iter().map(|&q| work.faces.face(q as usize)).filter(|face| !face.contains(before));
    let (left, right) = (ahead.next()?, ahead.next()?);
    left.iter().copied().find(|w| w != at && right.contains(w))
}

/// Unit tangents at the vertices on features, zero elsewhere.
fn tangents(work: &Work, around: &Around) -> Vec<DVec3> {
    let of = |v: u32| match around.neighbours[v as usize][..] {
        [a, b] if is_on_curve(work, around, v) => {
            (work.points[b as usize] - work.points[a as usize]).normalize_or_zero()
        }
        _ => DVec3::ZERO,
    };
    (0..work.points.len() as u32).map(of).collect()
}

/// How far a row leans, and what its ends do to that.
struct Lean {
    ends: [u32; 2],
    /// Of its angle away from upright.
    sine: f64,
    /// By how much that changes as an end slides.
    by_first: f64,
    by_last: f64,
}

impl Lean {
    fn of(work: &Work, tangents: &[DVec3], row: &[u32]) -> Option<Self> {
        let ends = [row[0], row[row.len() - 1]];
        let [first, last] = ends.map(|v| v as usize);
        let (t, s) = (tangents[first], tangents[last]);
        if t.dot(s).abs() < STRIP_COSINE {
            return None;
        }
        let along = (t + s * t.dot(s).signum()).normalize_or_zero();
        let across = work.points[last] - work.points[first];
        let length = across.length();
        (length > 0.0).then(|| Lean {
            ends,
            sine: across.dot(along) / length,
            by_first: -t.dot(along) / length,
            by_last: s.dot(along) / length,
        })
    }
}

/// How far every vertex slides along its tangent.
fn slides(work: &Work, tangents: &[DVec3], leans: &[Lean]) -> Option<Vec<f64>> {
    let mut unknown = vec![NONE; work.points.len()];
    let mut count = 0;
    for (v, unknown) in unknown.iter_mut().enumerate() {
        if matches!(work.place[v], Place::Curve(_)) && tangents[v] != DVec3::ZERO {
            *unknown = count;
            count += 1;
        }
    }
    let mut system = LeastSquares::new(count as usize);
    let mut add = |weight: f64, terms: &[(u32, f64)], constant: f64| {
        let terms: Vec<(u32, f64)> =
            terms.iter().map(|&(v, a)| (unknown[v as usize], a)).filter(|t| t.0 != NONE).collect();
        if !terms.is_empty() {
            system.add(weight, &terms, constant);
        }
    };
    for lean in leans {
        let [first, last] = lean.ends;
        add(1.0, &[(first, lean.by_first), (last, lean.by_last)], lean.sine);
    }
    for ([a, b], _) in &work.features {
        let edge = work.points[*b as usize] - work.points[*a as usize];
        let (along, length) = (edge.normalize_or_zero(), edge.length());
        if length > 0.0 {
            let [by_a, by_b] = [*a, *b].map(|v| tangents[v as usize].dot(along) / length);
            add(1.0, &[(*a, -by_a), (*b, by_b)], 0.0);
            [*a, *b].into_iter().for_each(|v| add(SIDE_HOLD, &[(v, 1.0 / length)], 0.0));
        }
    }
    let found = system.solve(&mut None).ok()?;
    Some(unknown.iter().map(|&k| if k == NONE { 0.0 } else { found[k as usize] }).collect())
}

/// Slides vertices on features, all by the same share of `u`; what is in between goes along. Returns where they were.
fn move_rows(work: &mut Work, source: &Source, tangents: &[DVec3], rows: &[Vec<u32>], u: &[f64]) -> Vec<DVec3> {
    let share = largest_share(work, u);
    let before = work.points.clone();
    for v in (0..before.len()).filter(|&v| u[v] != 0.0) {
        work.points[v] = work.put_back(source, v as u32, before[v] + tangents[v] * (share * u[v]));
    }
    take_back(work, source, &before);
    for row in rows {
        let [first, last] = [row[0], row[row.len() - 1]].map(|v| work.points[v as usize] - before[v as usize]);
        for (k, &v) in row.iter().enumerate().take(row.len() - 1).skip(1) {
            let moved = first.lerp(last, k as f64 / (row.len() - 1) as f64);
            work.points[v as usize] = work.put_back(source, v, before[v as usize] + moved);
        }
    }
    before
}

/// The share of `u` by which no vertex goes too far for one step.
fn largest_share(work: &Work, u: &[f64]) -> f64 {
    let of_edge = |([a, b], _): &([u32; 2], u32)| {
        let length = work.points[*a as usize].distance(work.points[*b as usize]);
        STRAIGHTEN_REACH * length / u[*a as usize].abs().max(u[*b as usize].abs()).max(f64::MIN_POSITIVE)
    };
    work.features.iter().map(of_edge).fold(1.0, f64::min)
}

/// Takes vertices back whose edges come off their curves by it.
fn take_back(work: &mut Work, source: &Source, before: &[DVec3]) {
    let is_off = |([a, b], curve): &([u32; 2], u32), points: &[DVec3]| {
        !keeps_feature(source, *curve, [points[*a as usize], points[*b as usize]], 1.0)
    };
    let at_risk: Vec<([u32; 2], u32)> = work.features.iter().copied().filter(|edge| !is_off(edge, before)).collect();
    loop {
        let off =
            at_risk.iter().filter(|edge| is_off(edge, &work.points)).flat_map(|(ends, _)| ends.map(|v| v as usize));
        let back: Vec<usize> = off.filter(|&v| work.points[v] != before[v]).collect();
        if back.is_empty() {
            return;
        }
        back.into_iter().for_each(|v| work.points[v] = before[v]);
    }
}

#[cfg(test)]
mod tests {
    use super::super::smooth::turned;
    use super::*;
    use crate::geometry::features::FeatureOptions;
    use crate::mesh::{Polygons, SurfaceMesh};
    use std::f64::consts::TAU;

    const QUADS: u32 = 40;
    /// Radii of the rings of vertices: two strips beside each other with a feature between, three quads across each.
    const RADII: [f64; 7] = [1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6];
    const ON_FEATURES: [u32; 3] = [0, 3, 6];

    fn at(radius: f64, turn: f64) -> DVec3 {
        let (sin, cos) = (TAU * turn).sin_cos();
        // The outer strip is a cone: its inner border is a feature.
        DVec3::new(radius * cos, radius * sin, 2.0 * (radius - RADII[3]).max(0.0))
    }

    /// Two rings of quads with a common circle, every circle turned by so many quads against the one inside.
    fn rings(by: f64) -> (Work, Source) {
        let circles = ON_FEATURES.map(|k| RADII[k as usize]);
        let n = 8 * QUADS;
        let points = circles.iter().flat_map(|&r| (0..n).map(move |k| at(r, f64::from(k) / f64::from(n)))).collect();
        let mut faces = Polygons::new();
        for (ring, k) in [0, 1].into_iter().flat_map(|ring| (0..n).map(move |k| (ring, k))) {
            let [a, b, c, d] =
                [(0, k), (1, k), (1, (k + 1) % n), (0, (k + 1) % n)].map(|(out, k)| (ring + out) * n + k);
            faces.push(&[a, b, c]);
            faces.push(&[a, c, d]);
        }
        let mesh = SurfaceMesh::new(points, faces).unwrap();
        let source = Source::new(&mesh, &FeatureOptions::default(), &Context::new()).unwrap();
        let mut work = Work::default();
        for (ring, radius) in (0u32..).zip(RADII) {
            let ahead = by * f64::from(ring) / 3.0;
            let turn = |k: u32| (f64::from(k) + ahead) / f64::from(QUADS);
            work.points.extend((0..QUADS).map(|k| at(radius, turn(k))));
        }
        for (ring, k) in (0..RADII.len() as u32 - 1).flat_map(|ring| (0..QUADS).map(move |k| (ring, k))) {
            let next = (k + 1) % QUADS;
            work.faces.push(&[(0, k), (1, k), (1, next), (0, next)].map(|(out, k)| (ring + out) * QUADS + k));
            let inside =
                work.points[(ring * QUADS + k) as usize].midpoint(work.points[((ring + 1) * QUADS + next) as usize]);
            let (_, region) = (0..2)
                .filter_map(|region| Some((source.on_region(region, inside)?.0.distance(inside), region)))
                .min_by(|a, b| a.0.total_cmp(&b.0))
                .unwrap();
            work.region.push(region);
        }
        work.place = (0..RADII.len() as u32 * QUADS)
            .map(|v| Place::Region(work.region[(v.min(6 * QUADS - 1)) as usize]))
            .collect();
        for ring in ON_FEATURES {
            for k in 0..QUADS {
                let ends = [ring * QUADS + k, ring * QUADS + (k + 1) % QUADS];
                let [p, q] = ends.map(|v| work.points[v as usize]);
                let edge = source.feature_along(p.midpoint(q), (q - p).normalize(), 0.05, 0.9).unwrap();
                let curve = source.curve[edge as usize];
                work.features.push((ends, curve));
                work.place[ends[0] as usize] = Place::Curve(curve);
            }
        }
        (work, source)
    }

    /// The largest sine of a row's angle away from upright.
    fn lean(work: &Work) -> f64 {
        let around = Around::new(work);
        let (rows, tangents) = (rows(work, &around), tangents(work, &around));
        assert_eq!(rows.len() as u32, 2 * QUADS);
        rows.iter().map(|row| Lean::of(work, &tangents, row).unwrap().sine.abs()).fold(0.0, f64::max)
    }

    #[test]
    fn rings_are_turned_against_each_other_until_their_rows_are_upright() {
        let (mut work, source) = rings(3.0);
        assert!(lean(&work) > 0.7);
        let around = Around::new(&work);
        straighten(&mut work, &around, &source, &Context::new()).unwrap();
        assert!(lean(&work) < LEAN_SINE, "{}", lean(&work));
        assert!(turned(&work).is_empty());
        for (v, p) in (0u32..).zip(&work.points) {
            let ring = v / QUADS;
            let off = (p.truncate().length() - RADII[ring as usize]).abs();
            assert!(
                off < if ON_FEATURES.contains(&ring) { 1e-3 } else { 0.05 },
                "vertex {v} is off its circle by {off}"
            );
        }
    }

    #[test]
    fn rows_that_hardly_lean_stay() {
        let (mut work, source) = rings(0.5);
        let before = work.points.clone();
        assert!(lean(&work) > 0.1);
        let around = Around::new(&work);
        straighten(&mut work, &around, &source, &Context::new()).unwrap();
        assert_eq!(work.points, before);
    }
}
