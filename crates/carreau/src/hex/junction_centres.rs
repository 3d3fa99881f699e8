//! Finds the point where branches meet. Within the ball of a branching all branches run straight, because there is room
//! for any way, and a curl of a curve in there would be taken for its direction.
//!
//! Where many meet, their common point is where their lines come closest to each other.
//!
//! Tubes that leave one point side by side part far from it, and the curves of a skeleton run together on the way. When
//! such branchings are merged, their middle is not the point that the tubes aim at:
//!
//! ```text
//!     ╲    ╱            ╲    ╱
//!      ╲  ╱              ╲  ╱
//!       ╲╱       →        ╲╱        the lines of the branches, where these are apart, meet in v
//!    ────v───          ───v────
//! ```

use super::target::Target;
use crate::geometry::closest::closest_to_lines;
use crate::mesh::{Branch, CurveNet, branches};
use glam::DVec3;

/// Number of branches from which on they meet in the point that their lines aim at.
const MANY: usize = 4;
/// Distance from the branching, in its radii, from which the nodes of a branch make its line.
pub const FROM: f64 = 4.0;
/// Distance, in radii, up to which they do. A branch that ends before [`FROM`] says nothing.
const TO: f64 = 8.0;
/// Weight of the place where the branching is, against that of a branch's line.
const STAY: f64 = 0.05;
/// The new place has at least this share of the room of the old one.
const ROOM_KEPT: f64 = 0.7;
/// And in the ball of a branching, where a node may have been in the middle of the body.
const IN_BALL: f64 = 0.3;

/// Moves branchings of many branches to where the lines of these meet, and straightens the branches up to there.
pub fn meet(net: &mut CurveNet, target: &Target) {
    let around = net.incidence();
    let all = branches(net, &around);
    for v in (0..net.points.len() as u32).filter(|&v| around.valence(v) >= MANY) {
        let from = net.points[v as usize];
        let room = target.distance(from);
        let ways: Vec<Vec<u32>> = all.iter().flat_map(|b| leaving(b, v)).collect();
        let lines: Vec<(DVec3, DVec3)> = ways.iter().filter_map(|w| line(net, w, from, room)).collect();
        if lines.len() < MANY {
            continue;
        }
        let Some(to) = nearest_to(&lines, from) else { continue };
        if !target.contains(to) || target.distance(to) < ROOM_KEPT * room {
            continue;
        }
        net.points[v as usize] = to;
        for way in &ways {
            if let Some(end) = leaves(net, way, FROM * room) {
                straighten(net, &way[..=end], ROOM_KEPT, target);
            }
        }
    }
}

/// Lets branches run straight in the balls of their branchings.
pub fn straighten_in_balls(net: &mut CurveNet, target: &Target) {
    let around = net.incidence();
    let all = branches(net, &around);
    for v in (0..net.points.len() as u32).filter(|&v| around.valence(v) > 2) {
        let room = target.distance(net.points[v as usize]);
        for way in all.iter().flat_map(|b| leaving(b, v)) {
            let end = leaves(net, &way, room).unwrap_or(way.len() - 1);
            straighten(net, &way[..=end], IN_BALL, target);
        }
    }
}

/// The nodes of a branch as seen from a node, once for each end that is there.
pub fn leaving(branch: &Branch, v: u32) -> Vec<Vec<u32>> {
    let mut ways = Vec::new();
    if branch.nodes.first() == Some(&v) {
        ways.push(branch.nodes.clone());
    }
    if branch.nodes.last() == Some(&v) {
        ways.push(branch.nodes.iter().rev().copied().collect());
    }
    ways
}

/// A point and the direction of the line of a branch where it has left the branching at a place.
pub fn line(net: &CurveNet, way: &[u32], from: DVec3, room: f64) -> Option<(DVec3, DVec3)> {
    let points = way[1..].iter().map(|&v| net.points[v as usize]);
    let part: Vec<DVec3> =
        points.skip_while(|p| p.distance(from) < FROM * room).take_while(|p| p.distance(from) < TO * room).collect();
    let (first, last) = (part.first()?, part.last()?);
    let middle = part.iter().sum::<DVec3>() / part.len() as f64;
    let direction = if part.len() > 1 { *last - *first } else { *first - from };
    Some((middle, direction.try_normalize()?))
}

/// The point with the least sum of squared distances from lines.
pub fn nearest_to(lines: &[(DVec3, DVec3)], stay: DVec3) -> Option<DVec3> {
    closest_to_lines(lines.iter().copied(), stay, STAY)
}

/// Where on a way its nodes are farther than a distance from the first for the first time.
fn leaves(net: &CurveNet, way: &[u32], distance: f64) -> Option<usize> {
    let from = net.points[way[0] as usize];
    (1..way.len()).find(|&k| net.points[way[k] as usize].distance(from) > distance)
}

/// The nodes of a way go onto the line from its first to its last, where they keep a share of their room.
fn straighten(net: &mut CurveNet, way: &[u32], share: f64, target: &Target) {
    let at = |k: usize| net.points[way[k] as usize];
    let end = way.len() - 1;
    let on = |k: usize| at(0).lerp(at(end), k as f64 / end as f64);
    let fits = |k: usize| target.contains(on(k)) && target.distance(on(k)) > share * target.distance(at(k));
    if (1..end).all(fits) {
        let points: Vec<DVec3> = (1..end).map(on).collect();
        points.into_iter().zip(&way[1..]).for_each(|(p, &v)| net.points[v as usize] = p);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A curl in the ball of a branching goes, what is out of it stays.
    #[test]
    fn branches_leave_a_ball_straight() {
        let (closed, _) =
            crate::skeleton::prepared(&crate::mesh::test_models::sphere(3), &crate::Context::new()).unwrap();
        let flat = |[x, y]: [f64; 2]| DVec3::new(x, y, 0.0);
        let points = [[0.0, 0.0], [0.0, 0.2], [0.3, 0.2], [0.7, 0.0], [-0.7, 0.0], [0.0, -0.7]].map(flat).to_vec();
        let mut net = CurveNet::new(points, vec![0.3; 6], vec![[0, 1], [1, 2], [2, 3], [0, 4], [0, 5]]);
        let ends: Vec<DVec3> = net.points[3..].to_vec();
        straighten_in_balls(&mut net, &Target::new(&closed));
        assert!(net.points[1].y == 0.0 && net.points[2].y == 0.0 && net.points[1].x < net.points[2].x);
        assert_eq!(net.points[3..], ends);
    }

    #[test]
    fn lines_meet_where_they_aim_at() {
        let aim = DVec3::new(0.1, -0.2, 0.3);
        let directions = [DVec3::X, DVec3::Y, DVec3::new(1.0, 1.0, 1.0), DVec3::new(-1.0, 0.2, 0.0)];
        let lines = directions.map(|d| (aim + 3.0 * d, d.normalize()));
        assert!(nearest_to(&lines, aim + 0.1).unwrap().distance(aim) < 0.02);
        // Lines side by side say nothing along them.
        let stay = nearest_to(&[(DVec3::Y, DVec3::X); 3], DVec3::X).unwrap();
        assert!(stay.distance(DVec3::new(1.0, 1.0, 0.0)) < 0.1, "{stay}");
    }
}
