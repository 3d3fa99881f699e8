//! Frames along the branches (section 3.1 "Géométrie"; spec 1.4).
//!
//! A frame is a unit vector `u` across the curve; the ring of a node has its corners at u, t × u, −u, −t × u, the middles
//! between. Frames start at a branching, from the corners of its quad, and are carried along by double reflection (Wang,
//! Jüttler, Zheng, Liu, "Computation of rotation minimizing frames", TOG 2008). Where a branch ends at a branching too,
//! what is left to the nearest of the four turns of its quad, at most 45°, is spread by arc length. On a ring the turn
//! that one round makes (holonomy) is spread likewise.
//!
//! Departure: the rings next to a branching have their corners where those of its quad are, seen along the branch, and
//! become regular over the next few rings; a long narrow quad joined to a square would fold the hexes between.

use super::connection::Connection;
use crate::mesh::{Branch, CurveNet};
use glam::{DQuat, DVec3};
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Frames of the articulations and extremities of a branch, and how its quads meet.
#[derive(Debug, Clone)]
pub struct Framed {
    /// The ring at every node of the branch; not used at branchings.
    pub rings: Vec<Ring>,
    /// Turn of the last segment: corner k of the near ring meets corner (turn − k) mod 4 of the far quad.
    pub turn: u32,
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

impl Ring {
    /// Unit vector at an angle from the frame.
    pub fn at(&self, angle: f64) -> DVec3 {
        let (sin, cos) = angle.sin_cos();
        self.frame * cos + self.tangent.cross(self.frame) * sin
    }

    /// Angle of the middle between a corner and the next.
    pub fn middle(&self, k: usize) -> f64 {
        let next = if k == 3 { self.corners[0] + TAU } else { self.corners[k + 1] };
        0.5 * (self.corners[k] + next)
    }
}

/// Rings until the corners are regular again.
const FADE: f64 = 3.0;

/// What the frames of a branch start from and end at: the quad of a branching, corner by corner, seen from the branch.
pub type Quad = [DVec3; 4];

/// Frames of every branch; `quad` gives the corners of the quad of a branching towards a segment.
pub fn frames(net: &CurveNet, branches: &[Branch], quad: impl Fn(u32, u32) -> Option<Quad> + Sync) -> Vec<Framed> {
    branches.par_iter().map(|b| frame_branch(net, b, &quad)).collect()
}

fn frame_branch(net: &CurveNet, branch: &Branch, quad: impl Fn(u32, u32) -> Option<Quad>) -> Framed {
    let points: Vec<DVec3> = branch.nodes.iter().map(|&v| net.points[v as usize]).collect();
    let tangents = tangents(&points, branch.is_ring);
    let last = points.len() - 1;
    let near = quad(branch.nodes[0], branch.edges[0]).map(|q| Fit::new(q, tangents[0]));
    let mut u = vec![near.as_ref().map_or_else(|| tangents[0].any_orthonormal_vector(), |f| f.frame)];
    for k in 0..last {
        u.push(reflect_twice(u[k], points[k + 1] - points[k], tangents[k], tangents[k + 1]));
    }
    // The quad of the far end is seen against the branch: its corners in reverse are seen along it.
    let seen_along = |q: Quad| [q[0], q[3], q[2], q[1]];
    let far = quad(branch.nodes[last], branch.edges[last - 1]).map(|q| Fit::new(seen_along(q), tangents[last]));
    let target = if branch.is_ring { Some(u[0]) } else { far.as_ref().map(|f| f.frame) };
    let mut turn = 0;
    if let Some(target) = target {
        let t = tangents[last];
        let angle = t.dot(u[last].cross(target)).atan2(u[last].dot(target));
        let quarters = (angle / FRAC_PI_2).round();
        turn = (quarters as i64).rem_euclid(4) as u32;
        spread(&points, &tangents, &mut u, angle - quarters * FRAC_PI_2);
    }
    let rings = (0..=last).map(|k| {
        let fade = |steps: usize| (1.0 - (steps as f64 - 1.0) / FADE).clamp(0.0, 1.0);
        let share =
            |fit: &Option<Fit>, steps: usize, corner: usize| fit.as_ref().map_or(0.0, |f| f.off[corner] * fade(steps));
        let corners = std::array::from_fn(|c| {
            // Corner c of this branch is corner c − turn of the far quad seen along it.
            let there = (c + 4 - turn as usize) % 4;
            c as f64 * FRAC_PI_2 + share(&near, k, c) + share(&far, last - k, there)
        });
        Ring { tangent: tangents[k], frame: u[k], corners }
    });
    Framed { rings: rings.collect(), turn }
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

/// Turns every frame by its share of an angle, in proportion to the arc length.
fn spread(points: &[DVec3], tangents: &[DVec3], u: &mut [DVec3], angle: f64) {
    let total: f64 = points.windows(2).map(|w| w[0].distance(w[1])).sum();
    let mut arc = 0.0;
    for k in 1..points.len() {
        arc += points[k].distance(points[k - 1]);
        u[k] = DQuat::from_axis_angle(tangents[k], angle * arc / total) * u[k];
    }
}

/// Unit tangents: the direction of the segment at the ends, the bisector between.
fn tangents(points: &[DVec3], is_ring: bool) -> Vec<DVec3> {
    let n = points.len();
    let chord = |k: usize| (points[k + 1] - points[k]).normalize_or(DVec3::X);
    let bisector = |a: DVec3, b: DVec3| {
        let sum = a + b;
        // A U-turn has no bisector: any direction across will do.
        if sum.length_squared() > 1e-6 { sum.normalize() } else { a.any_orthonormal_vector() }
    };
    let ends = if is_ring { [bisector(chord(n - 2), chord(0)); 2] } else { [chord(0), chord(n - 2)] };
    (0..n)
        .map(|k| match k {
            0 => ends[0],
            k if k == n - 1 => ends[1],
            k => bisector(chord(k - 1), chord(k)),
        })
        .collect()
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

/// The quads of all branchings, found by node and segment.
pub fn quad_of(connection: &Connection, slot: usize) -> Quad {
    connection.quads[slot].map(|v| connection.vertices[v as usize])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn helix(n: usize) -> CurveNet {
        let at = |k: usize| {
            let t = 0.15 * k as f64;
            DVec3::new(t.cos(), t.sin(), 0.3 * t)
        };
        let edges = (1..n as u32).map(|k| [k - 1, k]).collect();
        CurveNet::new((0..n).map(at).collect(), vec![0.1; n], edges)
    }

    fn chain(n: usize) -> Branch {
        Branch { nodes: (0..n as u32).collect(), edges: (0..n as u32 - 1).collect(), is_ring: false }
    }

    /// A frame without twist turns about the tangent by the integral of the torsion less than the Frenet frame does:
    /// what is carried must not turn about the tangent from one node to the next.
    #[test]
    fn frames_do_not_twist() {
        let framed = frame_branch(&helix(200), &chain(200), |_, _| None);
        for w in framed.rings.windows(2) {
            let [(t0, u0), (t1, u1)] = [0, 1].map(|k| (w[k].tangent, w[k].frame));
            assert!(t1.dot(u1).abs() < 1e-12);
            let shortest = DQuat::from_rotation_arc(t0, t1) * u0;
            assert!(shortest.angle_between(u1) < 2e-3, "{}", shortest.angle_between(u1));
        }
    }

    #[test]
    fn the_twist_to_the_far_quad_is_spread_evenly() {
        let line = CurveNet::new((0..5).map(|k| DVec3::X * f64::from(k)).collect(), vec![0.1; 5], Vec::new());
        for degrees in [-44.0f64, 20.0, 100.0, 250.0] {
            let corner = |a: f64| DVec3::new(0.0, a.cos(), a.sin());
            let ring = |start: f64, sense: f64| std::array::from_fn(|k| corner(start + sense * FRAC_PI_2 * k as f64));
            let quad = |node: u32, _| match node {
                0 => Some(ring(0.0, 1.0)),
                _ => Some(ring(degrees.to_radians(), -1.0)),
            };
            let framed = frame_branch(&line, &chain(5), quad);
            let twists: Vec<f64> = framed.rings.windows(2).map(|w| w[0].frame.angle_between(w[1].frame)).collect();
            assert!(twists.iter().all(|t| (t - twists[0]).abs() < 1e-9 && *t <= 45f64.to_radians() / 4.0 + 1e-9));
            // Corner 0 meets the corner `turn` of the far quad.
            let met = corner(degrees.to_radians() - FRAC_PI_2 * f64::from(framed.turn));
            assert!(met.angle_between(framed.rings[4].frame) < 1e-9, "{degrees}");
        }
    }
}
