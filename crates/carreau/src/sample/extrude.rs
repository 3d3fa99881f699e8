//! Solids swept from a plane profile of lines and arcs, with round holes between parallel flat faces.
//!
//! Every curve is divided once and its vertices are shared by the faces on both sides, so the solid is watertight by
//! construction.

use super::builder::{Builder, circle};
use super::limits::divisions;
use super::shape::Shape;
use crate::context::Context;
use crate::error::Result;
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// A piece of a profile. It begins where the one before ends.
#[derive(Debug, Clone, Copy)]
pub(super) enum Piece {
    /// A straight line to a point.
    Line(DVec2),
    /// An arc around a centre by an angle, counter-clockwise if positive.
    Arc(DVec2, f64),
}

/// A profile: the point where it starts and ends, and its named pieces, counter-clockwise.
pub(super) struct Profile<'a> {
    pub(super) start: DVec2,
    pub(super) pieces: &'a [(&'static str, Piece)],
}

/// Where a profile lies: its point (s, t) is `origin + s·u + t·v`, and it is swept along `u × v`.
pub(super) struct Frame {
    pub(super) origin: DVec3,
    pub(super) u: DVec3,
    pub(super) v: DVec3,
}

/// A cylindrical hole between two straight pieces of the profile.
pub(super) struct Hole {
    /// The face name of its wall.
    pub(super) name: &'static str,
    /// The names of the faces it enters and leaves through.
    pub(super) faces: [&'static str; 2],
    /// Centre of the circle it enters through.
    pub(super) centre: DVec3,
    /// From there to the centre of the other circle.
    pub(super) through: DVec3,
    /// Radius.
    pub(super) radius: f64,
}

/// Sweeps a profile by `length`. Labels: the pieces in order, the two ends, the holes in order.
pub(super) fn extrude(
    b: &mut Builder,
    frame: &Frame,
    profile: &Profile<'_>,
    length: f64,
    holes: &[Hole],
    edge: f64,
    context: &Context,
) -> Result<()> {
    let sweep = Sweep::new(b, frame, profile, length, edge);
    let rings: Vec<Vec<Vec<u32>>> = holes.iter().map(|h| hole_rings(b, h, edge)).collect();
    for (k, &(name, piece)) in profile.pieces.iter().enumerate() {
        match piece {
            Piece::Line(_) => {
                let outline = sweep.side_outline(k);
                let loops: Vec<&[u32]> = std::iter::once(&outline[..]).chain(mouths(holes, &rings, name)).collect();
                b.planar_face(name, sweep.side_normal(b, k), &loops, edge, context)?;
            }
            Piece::Arc(centre, _) => {
                let origin = frame.place(centre);
                let radius = b.at(sweep.near[k][0]).distance(origin);
                let label = b.shape(name, Shape::Cylinder { origin, axis: sweep.axis, radius });
                sweep.curved_side(b, label, k);
            }
        }
    }
    b.planar_face("near end", -sweep.axis, &[&sweep.near.concat()], edge, context)?;
    b.planar_face("far end", sweep.axis, &[&sweep.far.concat()], edge, context)?;
    for (hole, rings) in holes.iter().zip(&rings) {
        let axis = hole.through.normalize();
        let label = b.shape(hole.name, Shape::Cylinder { origin: hole.centre, axis, radius: hole.radius });
        b.rings(label, rings);
    }
    Ok(())
}

impl Frame {
    fn place(&self, p: DVec2) -> DVec3 {
        self.origin + self.u * p.x + self.v * p.y
    }
}

impl Profile<'_> {
    /// The points of every piece from its start; its end is the start of the next.
    fn points(&self, edge: f64) -> Vec<Vec<DVec2>> {
        let mut from = self.start;
        let mut out = Vec::with_capacity(self.pieces.len());
        for &(_, piece) in self.pieces {
            let (points, to) = divided(from, piece, edge);
            out.push(points);
            from = to;
        }
        out
    }
}

/// The points of a piece, its end left out, and its end.
fn divided(from: DVec2, piece: Piece, edge: f64) -> (Vec<DVec2>, DVec2) {
    match piece {
        Piece::Line(to) => {
            let n = divisions(from.distance(to), edge, 1);
            ((0..n).map(|k| from.lerp(to, f64::from(k) / f64::from(n))).collect(), to)
        }
        Piece::Arc(centre, angle) => {
            let arm = from - centre;
            let n = divisions(angle.abs() * arm.length(), edge, 3);
            let at = |k: u32| centre + DVec2::from_angle(angle * f64::from(k) / f64::from(n)).rotate(arm);
            ((0..n).map(at).collect(), at(n))
        }
    }
}

/// The vertices on the edges of a swept profile.
///
/// ```text
///          far[k] ────────▶
///            │                     near and far: the pieces, without their ends
///   joints[k]│     side k          joints: from near[k][0] to far[k][0], both included
///            │
///         near[k] ────────▶
/// ```
struct Sweep {
    axis: DVec3,
    near: Vec<Vec<u32>>,
    far: Vec<Vec<u32>>,
    joints: Vec<Vec<u32>>,
}

impl Sweep {
    fn new(b: &mut Builder, frame: &Frame, profile: &Profile<'_>, length: f64, edge: f64) -> Self {
        let axis = frame.u.cross(frame.v).normalize();
        let points = profile.points(edge);
        let mut chains = |shift: DVec3| -> Vec<Vec<u32>> {
            points.iter().map(|piece| b.points(piece.iter().map(|&p| frame.place(p) + shift))).collect()
        };
        let (near, far) = (chains(DVec3::ZERO), chains(axis * length));
        let rows = divisions(length, edge, 1);
        let joints = near.iter().zip(&far).map(|(n, f)| b.line([n[0], f[0]], rows)).collect();
        Sweep { axis, near, far, joints }
    }

    /// Piece `k` of the near or far chain with its end.
    fn chain(&self, chains: &[Vec<u32>], k: usize) -> Vec<u32> {
        chains[k].iter().copied().chain([chains[(k + 1) % chains.len()][0]]).collect()
    }

    /// The outline of a side, counter-clockwise from outside.
    fn side_outline(&self, k: usize) -> Vec<u32> {
        let (left, right) = (&self.joints[k], &self.joints[(k + 1) % self.joints.len()]);
        let (low, high) = (self.chain(&self.near, k), self.chain(&self.far, k));
        let mut out = low;
        out.extend(&right[1..]);
        out.extend(high.iter().rev().skip(1));
        out.extend(left[1..left.len() - 1].iter().rev());
        out
    }

    /// The outward normal of a straight side.
    fn side_normal(&self, b: &Builder, k: usize) -> DVec3 {
        let along = b.at(self.near[(k + 1) % self.near.len()][0]) - b.at(self.near[k][0]);
        along.cross(self.axis).normalize()
    }

    /// Adds a grid of quads on a curved side.
    fn curved_side(&self, b: &mut Builder, label: i32, k: usize) {
        let (left, right) = (&self.joints[k], &self.joints[(k + 1) % self.joints.len()]);
        let mut row = self.chain(&self.near, k);
        let foot: Vec<DVec3> = row.iter().map(|&v| b.at(v)).collect();
        for r in 1..left.len() {
            let above = if r + 1 == left.len() {
                self.chain(&self.far, k)
            } else {
                let shift = b.at(left[r]) - b.at(left[0]);
                let inner = b.points(foot[1..foot.len() - 1].iter().map(|&p| p + shift));
                std::iter::once(left[r]).chain(inner).chain([right[r]]).collect()
            };
            b.band(label, &row, &above);
            row = above;
        }
    }
}

/// The circles of a hole from its entry to its exit. They run clockwise seen along the hole, so that its wall faces the
/// axis.
fn hole_rings(b: &mut Builder, hole: &Hole, edge: f64) -> Vec<Vec<u32>> {
    let segments = divisions(TAU * hole.radius, edge, 12);
    let rows = divisions(hole.through.length(), edge, 1);
    let x = hole.through.normalize().any_orthonormal_vector() * hole.radius;
    let y = x.cross(hole.through.normalize());
    (0..=rows)
        .map(|k| hole.centre + hole.through * (f64::from(k) / f64::from(rows)))
        .map(|centre| b.points(circle(centre, x, y, segments)))
        .collect()
}

/// The circles of all holes that open in the face of this name.
fn mouths<'a>(holes: &'a [Hole], rings: &'a [Vec<Vec<u32>>], face: &'a str) -> impl Iterator<Item = &'a [u32]> {
    holes.iter().zip(rings).flat_map(move |(hole, rings)| {
        let entry = rings.first().filter(|_| hole.faces[0] == face);
        let exit = rings.last().filter(|_| hole.faces[1] == face);
        entry.into_iter().chain(exit).map(Vec::as_slice)
    })
}
