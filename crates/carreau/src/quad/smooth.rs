//! Smoothing: vertices move to the mean of their neighbours, back to their curve or region, and only as far as the worst
//! quad around them allows; then the worst are looked after one by one.

use super::source::Source;
use super::work::{Place, Work};
use crate::context::Context;
use crate::error::Result;
use crate::geometry::quality::scaled_jacobian;
use crate::mesh::HalfEdges;
use glam::DVec3;

const SWEEPS: usize = 12;
/// A move may worsen quads down to this scaled Jacobian.
const GOOD: f64 = 0.75;
/// Shares of the way that are tried.
const SHARES: [f64; 3] = [1.0, 0.5, 0.2];
/// Vertices with a worse quad are looked after, in so many rounds, with steps that start at this share of their edges.
const POOR: f64 = 0.6;
const ROUNDS: usize = 6;
const STEP: f64 = 0.3;
/// A quad may turn by less than this cosine in one move.
const TURN: f64 = 0.5;

/// The quads and neighbours of every vertex.
struct Around {
    quads: Vec<Vec<u32>>,
    /// Along edges; for vertices on curves, along their curve.
    neighbours: Vec<Vec<u32>>,
}

impl Around {
    fn new(work: &Work) -> Self {
        let n = work.points.len();
        let mut around = Around { quads: vec![Vec::new(); n], neighbours: vec![Vec::new(); n] };
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
}

/// The corners of a quad, with one vertex elsewhere.
fn corners(work: &Work, q: u32, v: u32, at: DVec3) -> [DVec3; 4] {
    let face = work.faces.face(q as usize);
    [0, 1, 2, 3].map(|k| if face[k] == v { at } else { work.points[face[k] as usize] })
}

fn normal(q: [DVec3; 4]) -> DVec3 {
    (q[2] - q[0]).cross(q[3] - q[1]).normalize_or_zero()
}

/// The worst quad around a vertex that would be elsewhere; −1 where one turned over.
fn worst(work: &Work, around: &Around, v: u32, at: DVec3) -> f64 {
    let of = |&q: &u32| {
        let after = corners(work, q, v, at);
        let before = corners(work, q, v, work.points[v as usize]);
        if normal(after).dot(normal(before)) < TURN { -1.0 } else { scaled_jacobian(after) }
    };
    around.quads[v as usize].iter().map(of).fold(f64::INFINITY, f64::min)
}

/// Smooths what may move.
pub fn smooth(work: &mut Work, source: &Source, context: &Context) -> Result<()> {
    let _stage = context.stage("smooth");
    let around = Around::new(work);
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
    for round in 0..ROUNDS {
        for v in 0..work.points.len() as u32 {
            context.check_every(v as usize)?;
            improve(work, &around, source, v, STEP / f64::from(1 << (round / 2)));
        }
    }
    Ok(())
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
    let neighbours = &around.neighbours[v as usize];
    if work.place[v as usize] == Place::Fixed || neighbours.is_empty() {
        return;
    }
    let from = work.points[v as usize];
    let mut best = (worst(work, around, v, from), from);
    if best.0 >= POOR {
        return;
    }
    let length =
        neighbours.iter().map(|&w| work.points[w as usize].distance(from)).sum::<f64>() / neighbours.len() as f64;
    let up =
        around.quads[v as usize].iter().map(|&q| normal(corners(work, q, v, from))).sum::<DVec3>().normalize_or_zero();
    let (x, y) = up.any_orthonormal_pair();
    for k in 0..8 {
        let (sin, cos) = (std::f64::consts::FRAC_PI_4 * f64::from(k)).sin_cos();
        let to = work.put_back(source, v, from + (x * cos + y * sin) * step * length);
        let found = worst(work, around, v, to);
        if found > best.0 + 1e-6 {
            best = (found, to);
        }
    }
    work.points[v as usize] = best.1;
}
