//! Frames along the branches (section 3.1 "Géométrie" of the paper).
//!
//! A frame is a unit vector `u` across the curve; the ring of a node has its corners at u, t × u, −u, −t × u, the middles
//! between. Frames start at a branching, from the corners of its quad, and are carried along by double reflection (Wang,
//! Jüttler, Zheng, Liu, "Computation of rotation minimizing frames", TOG 2008). Where a branch ends at a branching too,
//! what is left to the nearest of the four turns of its quad, at most 45°, is spread by arc length. On a ring the turn
//! that one round makes (holonomy) is spread likewise.
//!
//! Departure: the rings next to a branching have their corners where those of its quad are, seen along the branch, and
//! become regular over the next few rings; a long narrow quad joined to a square would fold the hexes between.

use crate::mesh::{Chains, CurveNet};
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2, TAU};

/// Frames of the articulations and extremities, and how the quads at the ends of the branches meet.
#[derive(Debug, Clone)]
pub struct Frames {
    /// The ring at every node of the branches, in their order; not used at branchings.
    pub rings: Vec<Ring>,
    /// Turn of the segment behind every such node: corner k of the near ring meets corner (turn − k) mod 4 of the far quad.
    /// Not zero only at the last segment of a branch.
    pub turns: Vec<u8>,
}

/// The ring of an articulation or extremity.
#[derive(Debug, Clone, Copy, Default)]
pub struct Ring {
    /// Unit tangent of the curve.
    pub tangent: DVec3,
    /// Unit vector across it.
    pub frame: DVec3,
    /// Angles of the four corners from the frame, counter-clockwise about the tangent, ascending.
    pub corners: [f64; 4],
}

/// The angles of a square.
const REGULAR: [f64; 4] = [0.0, FRAC_PI_2, 2.0 * FRAC_PI_2, 3.0 * FRAC_PI_2];

impl Ring {
    /// Unit vectors to the four corners, then to the middles between a corner and the next.
    pub fn directions(&self) -> [DVec3; 8] {
        let (u, v) = (self.frame, self.tangent.cross(self.frame));
        if self.corners == REGULAR {
            let (sum, difference) = ((u + v) * FRAC_1_SQRT_2, (v - u) * FRAC_1_SQRT_2);
            return [u, v, -u, -v, sum, difference, -sum, -difference];
        }
        let at = |angle: f64| {
            let (sin, cos) = angle.sin_cos();
            u * cos + v * sin
        };
        let c = self.corners;
        let middle = |k: usize| 0.5 * (c[k] + if k == 3 { c[0] + TAU } else { c[k + 1] });
        std::array::from_fn(|k| if k < 4 { at(c[k]) } else { at(middle(k - 4)) })
    }
}

/// Rings until the corners are regular again.
const FADE: f64 = 3.0;
/// Nodes whose frames are made by one task, at least.
const TASK: usize = 1024;

/// What the frames of a branch start from and end at: the quad of a branching, corner by corner, seen from the branch.
pub type Quad = [DVec3; 4];

/// Frames of every branch; `quad` gives the corners of the quad of a branching towards a segment.
pub fn frames(net: &CurveNet, all: &Chains, quad: impl Fn(u32, u32) -> Option<Quad> + Sync) -> Frames {
    let mut frames = Frames { rings: vec![Ring::default(); all.nodes.len()], turns: vec![0; all.nodes.len()] };
    let (mut rings, mut turns) = (&mut frames.rings[..], &mut frames.turns[..]);
    let mut tasks = Vec::with_capacity(all.nodes.len().div_ceil(TASK));
    let mut first = 0;
    while first < all.count() {
        let from = all.starts[first] as usize;
        let last = all.starts.partition_point(|&s| (s as usize) < from + TASK).min(all.count());
        let count = all.starts[last] as usize - from;
        let (own_rings, own_turns);
        (own_rings, rings) = rings.split_at_mut(count);
        (own_turns, turns) = turns.split_at_mut(count);
        tasks.push((first..last, own_rings, own_turns));
        first = last;
    }
    tasks.into_par_iter().for_each(|(branches, mut rings, mut turns)| {
        for branch in branches {
            let nodes = all.span(branch).len();
            let (own, own_turns);
            (own, rings) = rings.split_at_mut(nodes);
            (own_turns, turns) = turns.split_at_mut(nodes);
            own_turns[nodes - 2] = frame_branch(net, all, branch, own, &quad);
        }
    });
    frames
}

/// Fills in the rings of a branch; returns the turn of its last segment.
fn frame_branch(
    net: &CurveNet,
    all: &Chains,
    branch: usize,
    rings: &mut [Ring],
    quad: impl Fn(u32, u32) -> Option<Quad>,
) -> u8 {
    let span = all.span(branch);
    let (nodes, edges, is_ring) = (&all.nodes[span.clone()], &all.edges[span], branch >= all.first_ring);
    let point = |k: usize| net.points[nodes[k] as usize];
    let last = nodes.len() - 1;
    let total = set_tangents(&point, is_ring, rings);
    let near = quad(nodes[0], edges[0]).map(|q| Fit::new(q, rings[0].tangent));
    rings[0].frame = near.as_ref().map_or_else(|| rings[0].tangent.any_orthonormal_vector(), |f| f.frame);
    for k in 0..last {
        let [from, to] = [rings[k].tangent, rings[k + 1].tangent];
        rings[k + 1].frame = reflect_twice(rings[k].frame, point(k + 1) - point(k), from, to);
    }
    // The quad of the far end is seen against the branch: its corners in reverse are seen along it.
    let seen_along = |q: Quad| [q[0], q[3], q[2], q[1]];
    let far = quad(nodes[last], edges[last - 1]).map(|q| Fit::new(seen_along(q), rings[last].tangent));
    let target = if is_ring { Some(rings[0].frame) } else { far.as_ref().map(|f| f.frame) };
    let mut turn = 0;
    if let Some(target) = target {
        let Ring { tangent, frame, .. } = rings[last];
        let angle = tangent.dot(frame.cross(target)).atan2(frame.dot(target));
        let quarters = (angle / FRAC_PI_2).round();
        turn = (quarters as i64).rem_euclid(4) as u8;
        spread(&point, rings, (angle - quarters * FRAC_PI_2) / total.max(1e-300));
    }
    let fade = |steps: usize| (1.0 - (steps as f64 - 1.0) / FADE).clamp(0.0, 1.0);
    let share =
        |fit: &Option<Fit>, steps: usize, corner: usize| fit.as_ref().map_or(0.0, |f| f.off[corner] * fade(steps));
    for (k, ring) in rings.iter_mut().enumerate() {
        // Corner c of this branch is corner c − turn of the far quad seen along it.
        let there = |c: usize| (c + 4 - turn as usize) % 4;
        ring.corners = std::array::from_fn(|c| REGULAR[c] + share(&near, k, c) + share(&far, last - k, there(c)));
    }
    turn
}

/// The frame that fits the corners of a quad best, and how far each corner is off it.
struct Fit {
    frame: DVec3,
    off: [f64; 4],
}

impl Fit {
    /// `q` counter-clockwise about the tangent.
    fn new(q: Quad, tangent: DVec3) -> Fit {
        let x = tangent.any_orthonormal_vector();
        let y = tangent.cross(x);
        let angles = q.map(|p| p.dot(y).atan2(p.dot(x)));
        let mut off = [0.0; 4];
        for k in 0..4 {
            let raw = angles[k] - angles[0] - k as f64 * FRAC_PI_2;
            // The quad includes the tangent: its corners come in order, within one round.
            let gap = (angles[k] - angles[0]).rem_euclid(TAU);
            off[k] = if k == 0 { 0.0 } else { raw - (angles[k] - angles[0]) + gap };
        }
        let mean = off.iter().sum::<f64>() / 4.0;
        let angle = angles[0] + mean;
        Fit { frame: x * angle.cos() + y * angle.sin(), off: off.map(|o| o - mean) }
    }
}

/// Turns every frame about its tangent, in proportion to the arc length.
fn spread(point: &impl Fn(usize) -> DVec3, rings: &mut [Ring], turn_by_length: f64) {
    let mut arc = 0.0;
    for (k, ring) in rings.iter_mut().enumerate().skip(1) {
        arc += point(k).distance(point(k - 1));
        let (sin, cos) = (turn_by_length * arc).sin_cos();
        ring.frame = ring.frame * cos + ring.tangent.cross(ring.frame) * sin;
    }
}

/// Unit tangents: the direction of the segment at the ends, the bisector between. Returns the length of the branch.
fn set_tangents(point: &impl Fn(usize) -> DVec3, is_ring: bool, rings: &mut [Ring]) -> f64 {
    let last = rings.len() - 1;
    let bisector = |a: DVec3, b: DVec3| {
        let sum = a + b;
        // A U-turn has no bisector: any direction across will do.
        if sum.length_squared() > 1e-6 { sum.normalize() } else { a.any_orthonormal_vector() }
    };
    let (mut total, mut first, mut before) = (0.0, DVec3::X, DVec3::X);
    for k in 0..last {
        let step = point(k + 1) - point(k);
        let length = step.length();
        total += length;
        let chord = if length > 0.0 { step / length } else { DVec3::X };
        rings[k].tangent = if k == 0 { chord } else { bisector(before, chord) };
        (first, before) = (if k == 0 { chord } else { first }, chord);
    }
    rings[last].tangent = before;
    if is_ring {
        rings[0].tangent = bisector(before, first);
        rings[last].tangent = rings[0].tangent;
    }
    total
}

/// One step of the double reflection: first in the plane between the two points, then in the plane between the
/// reflected tangent and the new one.
fn reflect_twice(u: DVec3, step: DVec3, from: DVec3, to: DVec3) -> DVec3 {
    let reflect = |x: DVec3, v: DVec3| {
        let square = v.length_squared();
        if square > 1e-24 { x - v * (2.0 * v.dot(x) / square) } else { x }
    };
    let (left_u, left_t) = (reflect(u, step), reflect(from, step));
    let carried = reflect(left_u, to - left_t);
    // Across the tangent to the last bit, and never zero.
    (carried - to * to.dot(carried)).normalize_or(to.any_orthonormal_vector())
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DQuat;

    fn helix(n: usize) -> CurveNet {
        let at = |k: usize| {
            let t = 0.15 * k as f64;
            DVec3::new(t.cos(), t.sin(), 0.3 * t)
        };
        let edges = (1..n as u32).map(|k| [k - 1, k]).collect();
        CurveNet::new((0..n).map(at).collect(), vec![0.1; n], edges)
    }

    /// The frames of a net that is one chain.
    fn framed(net: &CurveNet, quad: impl Fn(u32, u32) -> Option<Quad> + Sync) -> Frames {
        frames(net, &Chains::new(net, &net.incidence()), quad)
    }

    /// A frame without twist turns about the tangent by the integral of the torsion less than the Frenet frame does:
    /// what is carried must not turn about the tangent from one node to the next.
    #[test]
    fn frames_do_not_twist() {
        let framed = framed(&helix(200), |_, _| None);
        for w in framed.rings.windows(2) {
            let [(t0, u0), (t1, u1)] = [0, 1].map(|k| (w[k].tangent, w[k].frame));
            assert!(t1.dot(u1).abs() < 1e-12);
            let shortest = DQuat::from_rotation_arc(t0, t1) * u0;
            assert!(shortest.angle_between(u1) < 2e-3, "{}", shortest.angle_between(u1));
        }
    }

    #[test]
    fn the_twist_to_the_far_quad_is_spread_evenly() {
        let edges = (1..5).map(|k| [k - 1, k]).collect();
        let line = CurveNet::new((0..5).map(|k| DVec3::X * f64::from(k)).collect(), vec![0.1; 5], edges);
        for degrees in [-44.0f64, 20.0, 100.0, 250.0] {
            let corner = |a: f64| DVec3::new(0.0, a.cos(), a.sin());
            let ring = |start: f64, sense: f64| std::array::from_fn(|k| corner(start + sense * FRAC_PI_2 * k as f64));
            let quad = |node: u32, _| match node {
                0 => Some(ring(0.0, 1.0)),
                _ => Some(ring(degrees.to_radians(), -1.0)),
            };
            let framed = framed(&line, quad);
            let twists: Vec<f64> = framed.rings.windows(2).map(|w| w[0].frame.angle_between(w[1].frame)).collect();
            assert!(twists.iter().all(|t| (t - twists[0]).abs() < 1e-9 && *t <= 45f64.to_radians() / 4.0 + 1e-9));
            // Corner 0 meets the corner `turn` of the far quad.
            let met = corner(degrees.to_radians() - FRAC_PI_2 * f64::from(framed.turns[3]));
            assert!(met.angle_between(framed.rings[4].frame) < 1e-9, "{degrees}");
        }
    }
}
