//! Relations that the noise allows.

use super::conditions::{Radius, axis};
use super::contact::{contact, reach};
use super::{Claim, Relation};
use crate::cad::adjust::{Body, direction};
use crate::cad::clean::fitting_points;
use crate::cad::regions::{Map, Rung, area_vector, inner_vertices};
use crate::cad::topology::Graph;
use crate::cad::tuning::{FILE_PRECISION, REFINE_STEPS, TANGENT_COSINE};
use crate::geometry::primitive::{Kind, Primitive, refine};
use crate::mesh::NONE;
use glam::DVec3;

/// A count: most vertices that count for a surface; more are thinned evenly, because they would not change it.
const RELATION_SAMPLES: usize = 500;
/// A count: places along a border at which surfaces are to touch, because that is more than any pair has numbers to
/// fit.
const TOUCH_PLACES: usize = 8;
/// Cosine of 40°: normals on both sides of the border of two surfaces that touch differ by less, because a facet of a
/// coarse fillet turns by as much.
const TOUCH_COSINE: f64 = 0.766;
/// A factor: how many times the largest distances of their vertices surfaces may miss each other, because fits of few
/// vertices miss by that many.
const MISS_FACTOR: f64 = 4.0;
/// Volume of the normals of three surfaces that meet in a point, because the point of flatter ones is not certain.
const LEAST_VOLUME: f64 = 0.05;
/// A count of standard deviations within which directions are parallel or perpendicular, because normal noise leaves
/// them once in two thousand times.
const SAME_DEVIATIONS: f64 = 3.5;
/// Radians, 3°: the largest angle between directions that are parallel, because larger angles are meant.
const MOST_TURNED: f64 = 0.052;
/// A share of the diagonal: the farthest that parallel axes on one line are off each other, because farther ones are meant.
const MOST_SHIFTED: f64 = 2e-3;
/// A share of a radius: the largest standard deviation of one that may be equal to another, because of less certain ones any two
/// could be.
const CERTAIN_RADIUS: f64 = 3e-3;
/// A factor: how much larger the mean distance from a surface may be that two pieces share, because noise alone makes
/// it a little larger.
const SHARED_FACTOR: f64 = 1.3;
/// A share of the diagonal: standard deviation of distances that are zero, because floats are no more precise.
const LEAST_DEVIATION: f64 = 3e-8;

/// Lengths as shares of the diagonal.
#[derive(Debug, Clone, Copy)]
pub struct Unit {
    pub origin: DVec3,
    pub diagonal: f64,
}

impl Unit {
    pub fn enter(self, p: DVec3) -> DVec3 {
        (p - self.origin) / self.diagonal
    }

    pub fn leave(self, p: DVec3) -> DVec3 {
        self.origin + p * self.diagonal
    }
}

/// The surfaces of a map.
pub struct Found {
    /// Of every piece, the number of its surface; [`NONE`] without one.
    pub number: Vec<u32>,
    /// The surfaces, each once.
    pub bodies: Vec<Body>,
    /// Lengths.
    pub unit: Unit,
}

impl Found {
    /// The surfaces of the analytic pieces. In noisy data, pieces of one surface share it.
    pub fn of(map: &Map<'_>) -> Self {
        let unit = Unit { origin: map.t.points().first().copied().unwrap_or_default(), diagonal: map.diagonal };
        let noisy = map.is_noisy();
        let inner = if noisy { inner_vertices(map.t, &map.label) } else { Vec::new() };
        let area =
            |p: u32| map.pieces[p as usize].triangles.iter().map(|&k| area_vector(map.t, k).length()).sum::<f64>();
        let mut order: Vec<(u32, f64)> = (0..map.pieces.len() as u32).map(|p| (p, area(p))).collect();
        order.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        let mut found = Found { number: vec![NONE; map.pieces.len()], bodies: Vec::new(), unit };
        for (p, _) in order {
            let piece = &map.pieces[p as usize];
            let Some(primitive) = piece.primitive.filter(|_| piece.rung == Rung::Analytic) else { continue };
            let points = fitting_points(map.t, &piece.triangles, &inner, primitive.kind());
            let step = points.len().div_ceil(RELATION_SAMPLES).max(1);
            let some: Vec<DVec3> = points.iter().step_by(step).map(|&p| unit.enter(p)).collect();
            let body = body(primitive.moved(|p| unit.enter(p), |l| l / unit.diagonal), some);
            found.number[p as usize] = found.add(body, noisy);
        }
        found
    }

    /// The number of a surface that is new, or the same as a known one.
    fn add(&mut self, new: Body, noisy: bool) -> u32 {
        let kinds = |b: &Body| b.primitive.kind() == new.primitive.kind();
        for (k, known) in (0u32..).zip(self.bodies.iter_mut()).filter(|(_, b)| noisy && kinds(b)) {
            let [[rms, max], [new_rms, new_max]] = [known.residuals(), new.residuals()];
            let near = |&p: &DVec3| {
                let turned = known.primitive.normal(p).dot(new.primitive.normal(p)).abs();
                known.primitive.distance(p).abs() <= 2.0 * (max + new_max) + FILE_PRECISION && turned > TOUCH_COSINE
            };
            if !new.points.iter().all(near) {
                continue;
            }
            let both: Vec<DVec3> = known.points.iter().chain(&new.points).copied().collect();
            if let Some(fit) = refine(known.primitive, &both, None, REFINE_STEPS)
                && fit.rms <= SHARED_FACTOR * rms.max(new_rms) + FILE_PRECISION
            {
                *known = body(fit.primitive, both);
                return k;
            }
        }
        self.bodies.push(new);
        self.bodies.len() as u32 - 1
    }

    /// All relations that there may be.
    pub fn claims(&self, map: &Map<'_>, graph: &Graph, snap: bool) -> Vec<Claim> {
        let mut all = along_borders(map, graph, self);
        all.extend(at_corners(map, graph, self));
        if snap {
            all.extend(directions(&self.bodies));
            all.extend(axes(&self.bodies));
            all.extend(radii(&self.bodies));
        }
        all
    }
}

fn body(primitive: Primitive, points: Vec<DVec3>) -> Body {
    let mut body = Body::new(primitive, points, LEAST_DEVIATION);
    body.sigma = body.residuals()[0].max(LEAST_DEVIATION);
    body
}

/// Neighbours that may touch: where normals agree near the border, they are as near to each other as to their vertices.
fn along_borders(map: &Map<'_>, graph: &Graph, found: &Found) -> Vec<Claim> {
    let Found { number, bodies: all, unit } = found;
    let mut out = Vec::new();
    for chain in &graph.chains {
        if chain.sides.iter().any(|&p| p == NONE || number[p as usize] == NONE) {
            continue;
        }
        let n = chain.vertices.len();
        let point = |k: usize| unit.enter(map.t.points()[chain.vertices[k.min(n - 1)] as usize]);
        // A place of the border, and the length of the side that it is on.
        let place = |k: usize| {
            let s = (k as f64 + 0.5) / TOUCH_PLACES as f64 * (n - 1) as f64;
            let (low, share) = (s as usize, s.fract());
            (point(low).lerp(point(low + 1), share), point(low).distance(point(low + 1)))
        };
        let places: Vec<(DVec3, f64)> = (0..TOUCH_PLACES).map(place).collect();
        let bodies = chain.sides.map(|p| number[p as usize]);
        let [a, b] = bodies.map(|k| &all[k as usize]);
        let [x, y] = [a, b].map(|body| body.residuals()[1]);
        let (p, q) = (&a.primitive, &b.primitive);
        let room = reach(p, q, x.max(y).max(FILE_PRECISION));
        let near = MISS_FACTOR * (x + y) + FILE_PRECISION;
        let touches = |&(at, side): &(DVec3, f64)| {
            let is_near =
                |c: DVec3| p.distance(c).abs() + q.distance(c).abs() <= near && c.distance(at) <= room.max(side);
            p.normal(at).dot(q.normal(at)).abs() > TOUCH_COSINE && contact(p, q, at).is_some_and(is_near)
        };
        let curved = [p, q].iter().any(|p| !matches!(p, Primitive::Plane { .. }));
        if curved && places.iter().all(touches) {
            let places = places.into_iter().map(|p| p.0).collect();
            out.push(Claim { relation: Relation::Touch { bodies, places }, bound: near });
        }
    }
    out
}

/// At corners: surfaces that touch there, and of four and more a relation for each beyond the three that cross most squarely.
fn at_corners(map: &Map<'_>, graph: &Graph, found: &Found) -> Vec<Claim> {
    let Found { number, bodies: all, unit } = found;
    let mut around: Vec<(u32, u32)> = Vec::new();
    for chain in graph.chains.iter().filter(|c| !c.closed) {
        for v in [chain.vertices[0], chain.vertices[chain.vertices.len() - 1]] {
            around.extend(chain.sides.iter().map(|&s| (v, if s == NONE { NONE } else { number[s as usize] })));
        }
    }
    around.sort_unstable();
    around.dedup();
    let mut out = Vec::new();
    for at in around.chunk_by(|a, b| a.0 == b.0).filter(|at| at.len() > 2 && at.iter().all(|a| a.1 != NONE)) {
        let place = unit.enter(map.t.points()[at[0].0 as usize]);
        let own: Vec<u32> = at.iter().map(|a| a.1).collect();
        let pairs = own.iter().flat_map(|&a| own.iter().filter(move |&&b| a < b).map(move |&b| [a, b]));
        out.extend(pairs.filter_map(|pair| touch_at(all, pair, place)));
        let normal = |k: u32| all[k as usize].primitive.normal(place);
        let volume = |t: &[u32; 3]| normal(t[0]).cross(normal(t[1])).dot(normal(t[2])).abs();
        let triples = || {
            let n = own.len();
            (0..n).flat_map(move |i| (i + 1..n).flat_map(move |j| (j + 1..n).map(move |k| [i, j, k])))
        };
        let best = triples().map(|t| t.map(|i| own[i])).max_by(|s, t| volume(s).total_cmp(&volume(t)));
        let Some(base) = best.filter(|t| volume(t) > LEAST_VOLUME) else { continue };
        let spread: f64 = own.iter().map(|&k| all[k as usize].residuals()[1]).sum();
        for &other in own.iter().filter(|k| !base.contains(k)) {
            let relation = Relation::Concur { bodies: [base[0], base[1], base[2], other], place };
            // The flatter they cross, the less certain is their point.
            let bound = (MISS_FACTOR * spread + FILE_PRECISION) / volume(&base);
            if relation.off(all) <= bound {
                out.push(Claim { relation, bound });
            }
        }
    }
    out
}

/// Two surfaces, one of them curved, that touch at a corner.
fn touch_at(all: &[Body], bodies: [u32; 2], place: DVec3) -> Option<Claim> {
    let [a, b] = bodies.map(|k| &all[k as usize]);
    if [a, b].iter().all(|b| b.primitive.kind() == Kind::Plane) {
        return None;
    }
    let [x, y] = [a, b].map(|body| body.residuals()[1]);
    let turned = a.primitive.normal(place).dot(b.primitive.normal(place)).abs();
    let near = contact(&a.primitive, &b.primitive, place)?.distance(place)
        <= reach(&a.primitive, &b.primitive, x.max(y).max(FILE_PRECISION));
    let relation = Relation::Touch { bodies, places: vec![place] };
    let bound = MISS_FACTOR * (x + y) + FILE_PRECISION;
    (turned > TANGENT_COSINE && near && relation.off(all) <= bound).then_some(Claim { relation, bound })
}

/// Directions that are parallel to a surer one, and of those that are not, which are perpendicular to each other.
fn directions(all: &[Body]) -> Vec<Claim> {
    let mut known: Vec<(u32, DVec3, f64)> = (0u32..)
        .zip(all)
        .filter_map(|(k, body)| Some((k, direction(&body.primitive)?, body.turn_deviation())))
        .collect();
    known.sort_by(|a, b| a.2.total_cmp(&b.2).then(a.0.cmp(&b.0)));
    let mut first: Vec<(u32, DVec3, f64)> = Vec::new();
    let mut out = Vec::new();
    for (k, d, deviation) in known {
        let bound = |other: f64| (SAME_DEVIATIONS * deviation.hypot(other)).min(MOST_TURNED);
        if let Some(f) = first.iter().find(|f| f.1.cross(d).length() <= bound(f.2)) {
            out.push(Claim { relation: Relation::Parallel([f.0, k]), bound: bound(f.2) });
            continue;
        }
        let square = first.iter().filter(|f| f.1.dot(d).abs() <= bound(f.2));
        out.extend(square.map(|f| Claim { relation: Relation::Perpendicular([f.0, k]), bound: bound(f.2) }));
        first.push((k, d, deviation));
    }
    out
}

/// Parallel axes that are on the line of a surer one.
fn axes(all: &[Body]) -> Vec<Claim> {
    let across = |body: &Body| {
        let (_, d) = axis(&body.primitive)?;
        let (covariance, (x, y)) = (body.covariance()?, d.any_orthonormal_pair());
        let of = |e: DVec3| Body::deviation(&covariance, &body.carried(body.middle(), e));
        Some((of(x).hypot(of(y)), body.turn_deviation()))
    };
    let mut known: Vec<(u32, f64, f64)> =
        (0u32..).zip(all).filter_map(|(k, body)| across(body).map(|(shift, turn)| (k, shift, turn))).collect();
    known.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
    let mut first: Vec<(u32, f64, f64)> = Vec::new();
    let mut out = Vec::new();
    for (k, shift, turn) in known {
        let claim = |f: &(u32, f64, f64)| {
            let [a, b] = [f.0, k].map(|k| &all[k as usize]);
            let (d, e) = (direction(&a.primitive)?, direction(&b.primitive)?);
            let arm = a.middle().distance(b.middle());
            let bound = SAME_DEVIATIONS * shift.hypot(f.1).hypot(arm * f.2);
            let relation = Relation::Coaxial([f.0, k]);
            let is_parallel = d.cross(e).length() <= (SAME_DEVIATIONS * turn.hypot(f.2)).min(MOST_TURNED);
            let is_one = is_parallel && bound <= MOST_SHIFTED && relation.off(all) <= bound;
            is_one.then_some(Claim { relation, bound })
        };
        match first.iter().find_map(claim) {
            Some(claim) => out.push(claim),
            None => first.push((k, shift, turn)),
        }
    }
    out
}

/// Cylinders and spheres with the radius of a surer one.
fn radii(all: &[Body]) -> Vec<Claim> {
    let known = |(k, body): (u32, &Body)| {
        let radius = Radius::Only.of(&body.primitive)?;
        let deviation = Body::deviation(&body.covariance()?, &Radius::Only.row(1.0));
        (deviation <= CERTAIN_RADIUS * radius).then_some((k, radius, deviation))
    };
    let mut known: Vec<(u32, f64, f64)> = (0u32..).zip(all).filter_map(known).collect();
    known.sort_by(|a, b| a.2.total_cmp(&b.2).then(a.0.cmp(&b.0)));
    let mut first: Vec<(u32, f64, f64)> = Vec::new();
    let mut out = Vec::new();
    for (k, radius, deviation) in known {
        let bound = |f: &(u32, f64, f64)| SAME_DEVIATIONS * deviation.hypot(f.2);
        match first.iter().find(|f| (f.1 - radius).abs() <= bound(f)) {
            Some(f) => out.push(Claim { relation: Relation::SameRadius([f.0, k]), bound: bound(f) }),
            None => first.push((k, radius, deviation)),
        }
    }
    out
}
