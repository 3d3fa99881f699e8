//! The skeleton of straight tubes from one point, by their flat ends alone: pipes, tees, crosses, mitres as CAD systems have them.
//!
//! ```text
//!        ┌──┐              the axes of all ends meet in one point, all tubes are round about these lines, and there is no part of the
//!   ┌────┘┊ └────┐         surface besides: the lines are the skeleton
//!   ┆┄┄┄┄┄•┄┄┄┄┄┄┆
//!   └────────────┘
//! ```
//!
//! The flow needs tubes that are longer than thick, and the fittings of pipes are short: a pipe as long as wide has no axis
//! for it, and the side of a short tee vanishes in the ball of the run.

use super::body::Body;
use super::lids::{BENT, Closed, Lid};
use super::limbs::distances;
use super::sections::{is_round, section};
use crate::geometry::closest::closest_to_lines;
use crate::mesh::CurveNet;
use glam::DVec3;

/// The axis of an end passes the common point within this share of the end's radius.
const OFF_POINT: f64 = 0.05;
/// Of three ends and more each is this many times as far from the common point as the surface: sides of a prism are not.
const BEYOND_BALL: f64 = 1.15;
/// On the way to an end there is this share of the room of the end, or of the common point where that has less.
const WAY_ROOM: f64 = 0.8;
/// Sections are looked at on this part of the way from the point to an end, where that has left the others' ball.
const OUTER: [f64; 2] = [0.75, 0.95];
/// No place of the surface is farther from the axes, in radii: corners between tubes are, bends and limbs without an end are farther.
const COVERED: f64 = 1.45;
/// Distance of nodes, in radii of the end.
const NODE_STEP: f64 = 0.25;
/// Most nodes on the way to an end.
const MOST_NODES: f64 = 400.0;
/// The last node stays inside by this share of the radius.
const BEFORE_LID: f64 = 0.02;
/// Weight that keeps the common point of parallel axes in the middle.
const WEAK: f64 = 1e-6;

/// The straight skeleton that leads to all of these ends, if the surface is one of straight round tubes.
pub fn straight(closed: &Closed, ends: &[Lid], body: &Body) -> Option<CurveNet> {
    if ends.len() < 2 || ends.iter().any(|end| end.flatness > BENT || !(end.radius > 0.0)) {
        return None;
    }
    let hub = common_point(ends)?;
    if !body.inside.contains(hub) {
        return None;
    }
    let room = body.tree.distance(hub);
    if !ends.iter().all(|end| leads_to(end, hub, room, ends.len() > 2, body)) {
        return None;
    }
    // An elbow bends beside the point that its ends aim at.
    if let [a, b] = ends
        && !(a.normal - b.normal).try_normalize().is_some_and(|along| is_round(hub, along, body.tree))
    {
        return None;
    }
    let net = lines(hub, ends, body);
    let is_covered = distances(&net, closed.mesh.points()).into_iter().all(|far| far.0 < COVERED);
    is_covered.then_some(net)
}

/// The point nearest to the axes of all ends, if it is near each.
fn common_point(ends: &[Lid]) -> Option<DVec3> {
    let middle = ends.iter().map(|end| end.centre).sum::<DVec3>() / ends.len() as f64;
    let point = closest_to_lines(ends.iter().map(|end| (end.centre, end.normal)), middle, WEAK)?;
    let is_near = |end: &Lid| {
        let to = end.centre - point;
        to.dot(end.normal) > 0.0 && to.reject_from_normalized(end.normal).length() < OFF_POINT * end.radius
    };
    ends.iter().all(is_near).then_some(point)
}

/// Whether a straight round tube leads from a point to an end.
fn leads_to(end: &Lid, hub: DVec3, room: f64, is_star: bool, body: &Body) -> bool {
    let length = hub.distance(end.centre);
    if is_star && length < BEYOND_BALL * room {
        return false;
    }
    let at = |share: f64| hub.lerp(end.centre, share);
    // The end itself is nearer than the wall within its radius.
    let wide = (1.0 - end.radius / length).max(0.0);
    let least = WAY_ROOM * room.min(end.radius);
    let has_room = |k: usize| {
        let p = at(wide * k as f64 / 8.0);
        body.inside.contains(p) && (wide == 0.0 || body.tree.distance(p) > least)
    };
    let is_tube = |share: f64| is_round(at(share), end.normal, body.tree);
    (0..=8).all(has_room) && OUTER.into_iter().all(is_tube)
}

/// The lines from a point to the ends.
fn lines(hub: DVec3, ends: &[Lid], body: &Body) -> CurveNet {
    let (mut points, mut radii, mut edges) = (vec![hub], vec![body.tree.distance(hub)], Vec::new());
    for end in ends {
        let to = end.centre - end.normal * (BEFORE_LID * end.radius);
        let length = hub.distance(to);
        let count = (length / (NODE_STEP * end.radius)).ceil().clamp(2.0, MOST_NODES) as u32;
        let mut last = 0;
        for k in 1..=count {
            let p = hub.lerp(to, f64::from(k) / f64::from(count));
            let is_before = (end.centre - p).dot(end.normal) < end.radius;
            let across = if is_before { section(p, end.normal, body) } else { body.tree.distance(p) };
            edges.push([last, points.len() as u32]);
            last = points.len() as u32;
            radii.push(if across.is_finite() { across } else { end.radius });
            points.push(p);
        }
    }
    // A short pipe is nothing but ends.
    if ends.len() == 2 {
        radii[0] = section(hub, ends[0].normal, body).min(ends[0].radius.max(ends[1].radius));
    }
    CurveNet::new(points, radii, edges)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::context::Context;
    use crate::mesh::SurfaceMesh;
    use crate::skeleton::{SkeletonOptions, extract};

    fn found(mesh: &SurfaceMesh) -> crate::skeleton::Skeleton {
        extract(mesh, &SkeletonOptions::default(), &Context::new()).unwrap()
    }

    /// A pipe as long as wide, of long thin triangles: its axis, from end to end.
    #[test]
    fn a_short_pipe_has_its_axis() {
        let mesh = crate::sample::open_cylinder(1.0, 2.0, 24, 1).unwrap().mesh.triangulated().unwrap();
        let skeleton = found(&mesh);
        assert_eq!((skeleton.figures.extremities, skeleton.figures.branchings, skeleton.figures.steps), (2, 0, 0));
        assert!(skeleton.net.points.iter().all(|p| p.truncate().length() < 1e-9), "{:?}", skeleton.net.points);
        assert!(skeleton.net.radii.iter().all(|r| (r - 1.0).abs() < 0.02), "{:?}", skeleton.net.radii);
        assert_eq!(skeleton.preimage.len(), skeleton.closed.mesh.vertex_count());
    }

    /// What bulges between its ends, or has a limb that ends round, is left to the flow.
    #[test]
    fn what_is_more_than_straight_tubes_is_left_to_the_flow() {
        let tube = crate::sample::open_cylinder(1.0, 8.0, 24, 24).unwrap().mesh.triangulated().unwrap();
        assert_eq!(found(&tube).figures.steps, 0);
        let bulge = |p: &DVec3| {
            let aside = 2.5 * (1.0 - (p.z - 4.0).abs() / 2.0).max(0.0);
            if p.x > 0.0 { *p + DVec3::X * (aside * p.x) } else { *p }
        };
        let bent =
            SurfaceMesh::from_triangles(tube.points().iter().map(bulge).collect(), &tube.faces().fan().0).unwrap();
        assert!(found(&bent).figures.steps > 0);
    }
}
