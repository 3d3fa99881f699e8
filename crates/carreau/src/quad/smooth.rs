//! Smoothing: vertices move to the mean of their neighbours, back to their curve or region, and only as far as the worst
//! quad around them allows; then quads that are turned over and the worst ones are looked after one by one.

use super::bends;
use super::ceiling::{ceilings, shape};
use super::fit::fit;
use super::source::Source;
use super::tips;
use super::work::{Place, Work};
use crate::context::Context;
use crate::error::Result;
use crate::geometry::quality::scaled_jacobian;
use crate::mesh::HalfEdges;
use glam::DVec3;

const SWEEPS: usize = 20;
/// A move may worsen quads down to this shape.
pub const GOOD: f64 = 0.75;
/// Shares of the way that are tried.
pub const SHARES: [f64; 3] = [1.0, 0.5, 0.2];
/// Vertices with a worse quad are looked after, in so many rounds, with steps of these shares of their edges in turn.
const POOR: f64 = 0.6;
const ROUNDS: usize = 30;
const STEPS: [f64; 5] = [0.3, 0.15, 0.07, 0.03, 0.015];
/// How much more a worse shape counts.
const STEEP: f64 = 10.0;
/// No edge becomes shorter for it than this share of the mean of those around.
const LEAST: f64 = 0.05;
/// Quads with a smaller scaled Jacobian have no normal of their own to go by.
const BAD: f64 = 0.02;
/// Rounds for quads that are turned over, their steps, and the rounds without progress before it is given up.
const TANGLED: usize = 24;
const TANGLED_STEPS: [f64; 4] = [0.45, 0.3, 0.15, 0.07];
const PATIENCE: usize = 4;
/// A quad may turn by less than this cosine in one move.
const TURN: f64 = 0.5;

/// The quads and neighbours of every vertex.
pub struct Around {
    pub quads: Vec<Vec<u32>>,
    /// Along edges; for vertices on curves, along their curve.
    pub neighbours: Vec<Vec<u32>>,
    /// What the scaled Jacobian can be at the corners of every quad.
    ceilings: Vec<[f64; 4]>,
}

impl Around {
    fn new(work: &Work) -> Self {
        let n = work.points.len();
        let mut around =
            Around { quads: vec![Vec::new(); n], neighbours: vec![Vec::new(); n], ceilings: ceilings(work) };
        for (q, face) in (0u32..).zip(work.faces.iter()) {
            face.iter().for_each(|&v| around.quads[v as usize].push(q));
        }
        for edge in HalfEdges::new(&work.faces, n).groups() {
            let [a, b] = edge.ends;
            let is_inner = |v: u32| matches!(work.place[v as usize], Place::Region(_));
            for (v, w) in [(a, b), (b, a)] {
                if is_inner(v) {
                    around.neighbours[v as usize].push(w);
                }
            }
        }
        for ([a, b], _) in &work.features {
            for (v, w) in [(*a, *b), (*b, *a)] {
                around.neighbours[v as usize].push(w);
            }
        }
        around
    }

    /// How near a vertex would be to its neighbours.
    pub fn shortest_edge(&self, work: &Work, v: u32, at: DVec3) -> f64 {
        let neighbours = self.neighbours[v as usize].iter();
        neighbours.map(|&w| work.points[w as usize].distance(at)).fold(f64::INFINITY, f64::min)
    }

    /// Mean length of the edges at a vertex.
    pub fn mean_edge(&self, work: &Work, v: u32) -> f64 {
        let (from, neighbours) = (work.points[v as usize], &self.neighbours[v as usize]);
        let sum: f64 = neighbours.iter().map(|&w| work.points[w as usize].distance(from)).sum();
        sum / neighbours.len().max(1) as f64
    }

    /// Unit normal at a vertex; zero where its quads look everywhere.
    pub fn up(&self, work: &Work, v: u32) -> DVec3 {
        let of = |&q: &u32| normal(corners(work, q, v, work.points[v as usize]));
        self.quads[v as usize].iter().map(of).sum::<DVec3>().normalize_or_zero()
    }
}

/// The corners of a quad, with one vertex elsewhere.
fn corners(work: &Work, q: u32, v: u32, at: DVec3) -> [DVec3; 4] {
    let face = work.faces.face(q as usize);
    [0, 1, 2, 3].map(|k| if face[k] == v { at } else { work.points[face[k] as usize] })
}

/// Unit normal of a quad, across its diagonals.
pub fn normal(q: [DVec3; 4]) -> DVec3 {
    (q[2] - q[0]).cross(q[3] - q[1]).normalize_or_zero()
}

/// The shape of the quads around a vertex that would be elsewhere: the scaled Jacobian at every corner over what it can be
/// there; −1 where one turned over. One that is turned over already is measured against the quads around.
fn shapes(work: &Work, around: &Around, v: u32, at: DVec3) -> impl Iterator<Item = [f64; 4]> {
    around.quads[v as usize].iter().map(move |&q| {
        let (before, after) = (corners(work, q, v, work.points[v as usize]), corners(work, q, v, at));
        if scaled_jacobian(before) > BAD {
            let up = normal(after);
            return if up.dot(normal(before)) < TURN {
                [-1.0; 4]
            } else {
                shape(after, up, &around.ceilings[q as usize])
            };
        }
        let up: DVec3 = beside(work, around, q)
            .map(|other| work.faces.face(other as usize))
            .map(|f| [0, 1, 2, 3].map(|k| work.points[f[k] as usize]))
            .filter(|&p| scaled_jacobian(p) > BAD)
            .map(normal)
            .sum();
        shape(after, up.normalize_or(normal(before)), &around.ceilings[q as usize])
    })
}

/// The worst of the shapes.
pub fn worst(work: &Work, around: &Around, v: u32, at: DVec3) -> f64 {
    shapes(work, around, v, at).flatten().fold(f64::INFINITY, f64::min)
}

/// A sum that the worst of the shapes make most of: what cannot become better does not hide what can.
fn distress(work: &Work, around: &Around, v: u32, at: DVec3) -> f64 {
    shapes(work, around, v, at).flatten().map(|shape| (-STEEP * shape).exp()).sum()
}

/// The quads that share a vertex with a quad, some of them more than once.
fn beside<'a>(work: &'a Work, around: &'a Around, q: u32) -> impl Iterator<Item = u32> + 'a {
    work.faces.face(q as usize).iter().flat_map(|&v| around.quads[v as usize].iter().copied())
}

/// Puts vertices on features to where these bend, and smooths what may move.
pub fn smooth(work: &mut Work, source: &Source, context: &Context) -> Result<()> {
    let _stage = context.stage("smooth");
    let around = Around::new(work);
    let mut held = bends::follow(work, &around, source);
    held.extend(tips::follow(work, &around, source));
    for _ in 0..SWEEPS {
        let mut moved = 0usize;
        for v in 0..work.points.len() as u32 {
            context.check_every(v as usize)?;
            moved += usize::from(relax(work, &around, source, v));
        }
        if moved * 100 < work.points.len() {
            break;
        }
    }
    // What stays tangled is refused: how near it is to the surface does not matter.
    if untangle(work, &around, source, context)? {
        fit(work, &around, source, context)?;
    }
    look_after(work, &around, source, context)?;
    if bends::let_go(work, &around, &held) {
        look_after(work, &around, source, context)?;
    }
    Ok(())
}

/// Looks for better places for all that have a poor quad.
fn look_after(work: &mut Work, around: &Around, source: &Source, context: &Context) -> Result<()> {
    let mut moves = Moves::new(work);
    for round in 0..ROUNDS {
        for v in 0..work.points.len() as u32 {
            context.check_every(v as usize)?;
            if moves.any_since(round, STEPS.len(), work, around, v) {
                let from = work.points[v as usize];
                improve(work, around, source, v, STEPS[round % STEPS.len()]);
                moves.note(round, v, work.points[v as usize] != from);
            }
        }
    }
    Ok(())
}

/// When vertices last moved: what found no better place will find none as long as nothing around has moved.
pub struct Moves(Vec<usize>);

impl Moves {
    pub fn new(work: &Work) -> Self {
        Moves(vec![0; work.points.len()])
    }

    pub fn note(&mut self, round: usize, v: u32, has_moved: bool) {
        if has_moved {
            self.0[v as usize] = round + 1;
        }
    }

    /// Whether any vertex of the quads around one has moved in so many rounds; all count as moved before the first.
    pub fn any_since(&self, round: usize, rounds: usize, work: &Work, around: &Around, v: u32) -> bool {
        let mut near = around.quads[v as usize].iter().flat_map(|&q| work.faces.face(q as usize));
        round < rounds || near.any(|&w| self.0[w as usize] + rounds > round)
    }
}

/// Moves the vertices of quads that are turned over, and of those beside, until there are none or it is of no use. Returns
/// whether there are none.
fn untangle(work: &mut Work, around: &Around, source: &Source, context: &Context) -> Result<bool> {
    let mut least = (usize::MAX, 0);
    for round in 0..TANGLED {
        let is_bad = |q: &u32| {
            let face = work.faces.face(*q as usize);
            scaled_jacobian([0, 1, 2, 3].map(|k| work.points[face[k] as usize])) <= BAD
        };
        let bad: Vec<u32> = (0..work.faces.len() as u32).filter(is_bad).collect();
        if bad.len() < least.0 {
            least = (bad.len(), round);
        }
        if bad.is_empty() || round > least.1 + PATIENCE {
            return Ok(bad.is_empty());
        }
        let mut near: Vec<u32> = bad
            .iter()
            .flat_map(|&q| beside(work, around, q))
            .flat_map(|q| work.faces.face(q as usize))
            .copied()
            .collect();
        near.sort_unstable();
        near.dedup();
        for v in near {
            context.check_every(v as usize)?;
            relax(work, around, source, v);
            improve(work, around, source, v, TANGLED_STEPS[round % TANGLED_STEPS.len()]);
        }
    }
    Ok(false)
}

/// Moves a vertex towards the mean of its neighbours.
fn relax(work: &mut Work, around: &Around, source: &Source, v: u32) -> bool {
    let neighbours = &around.neighbours[v as usize];
    // Vertices on features are where these turn, and stay there.
    if !matches!(work.place[v as usize], Place::Region(_)) || neighbours.is_empty() {
        return false;
    }
    let from = work.points[v as usize];
    let mean = neighbours.iter().map(|&w| work.points[w as usize]).sum::<DVec3>() / neighbours.len() as f64;
    let before = worst(work, around, v, from);
    for share in SHARES {
        let to = work.put_back(source, v, from + (mean - from) * share);
        if worst(work, around, v, to) >= before.min(GOOD) {
            work.points[v as usize] = to;
            return to.distance_squared(from) > 1e-4 * mean.distance_squared(work.points[neighbours[0] as usize]);
        }
    }
    false
}

/// Looks around a vertex with a poor quad for a better place.
fn improve(work: &mut Work, around: &Around, source: &Source, v: u32, step: f64) {
    if work.place[v as usize] == Place::Fixed || around.neighbours[v as usize].is_empty() {
        return;
    }
    let from = work.points[v as usize];
    if worst(work, around, v, from) >= POOR {
        return;
    }
    let mut best = (distress(work, around, v, from), from);
    let length = around.mean_edge(work, v);
    let least = around.shortest_edge(work, v, from).min(LEAST * length);
    let (x, y) = around.up(work, v).any_orthonormal_pair();
    for k in 0..8 {
        let (sin, cos) = (std::f64::consts::FRAC_PI_4 * f64::from(k)).sin_cos();
        let to = work.put_back(source, v, from + (x * cos + y * sin) * step * length);
        let found = distress(work, around, v, to);
        if found < best.0 * (1.0 - 1e-6) && around.shortest_edge(work, v, to) >= least {
            best = (found, to);
        }
    }
    work.points[v as usize] = best.1;
}
