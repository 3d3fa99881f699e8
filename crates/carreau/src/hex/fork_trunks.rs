//! Gives branches that leave a branching side by side a common trunk, up to where they can be told apart.
//!
//! ```text
//!       ╱╱ j            │ ╱ j
//!      ╱╱ i      →      i╱         trunk v–t, then t–i and t–j
//!     v                 t
//!                       v
//! ```

use crate::mesh::CurveNet;
use glam::DVec3;

/// Directions closer than this are zipped in any case, as the paper's connection surfaces have no room for them.
pub const NARROW_DEGREES: f64 = 15.0;
/// Directions closer than this are zipped where the skeleton may be worked on: the cells between two segments at an angle θ
/// have a scaled Jacobian of about sin θ/2 where both leave one node, and twice that at the end of a trunk.
pub const CLOSE_DEGREES: f64 = 30.0;
/// The trunk ends where the directions are this far apart, usually.
pub const APART_DEGREES: f64 = 40.0;
/// Rounds; every zip makes one trunk, whose end may be narrow again.
const ZIPPING_ROUNDS: usize = 4;

/// Zips all pairs of directions closer than an angle, up to where they are `apart`; returns how many.
pub fn zip(net: &mut CurveNet, degrees: f64, apart: f64) -> usize {
    let narrow = degrees.to_radians().cos();
    let mut zipped = 0;
    for round in 0..ZIPPING_ROUNDS {
        let mut found = 0;
        let around = net.incidence();
        for v in (0..net.points.len() as u32).filter(|&v| around.valence(v) > 2) {
            let mut at: Vec<u32> = around.of(v).iter().map(|s| s[0]).collect();
            while let Some(pair) = narrowest(net, v, &at, narrow) {
                at.retain(|e| !pair.contains(e));
                at.push(part(net, v, pair, apart));
                found += 1;
            }
        }
        zipped += found;
        if found == 0 || round + 1 == ZIPPING_ROUNDS {
            break;
        }
    }
    zipped
}

/// The two segments with the smallest angle of those at a branching, where its cosine is larger than `narrow`.
fn narrowest(net: &CurveNet, v: u32, at: &[u32], narrow: f64) -> Option<[u32; 2]> {
    if at.len() < 3 {
        return None;
    }
    let direction = |e: u32| (net.points[other(net, e, v) as usize] - net.points[v as usize]).normalize_or_zero();
    let mut best = (narrow, None);
    for (k, &a) in at.iter().enumerate() {
        for &b in &at[k + 1..] {
            let cos = direction(a).dot(direction(b));
            if cos > best.0 {
                best = (cos, Some([a, b]));
            }
        }
    }
    best.1
}

fn other(net: &CurveNet, e: u32, v: u32) -> u32 {
    let [a, b] = net.edges[e as usize];
    if a == v { b } else { a }
}

/// Puts the end of the trunk on the bisector, as near as the directions from there are far enough apart; returns the trunk.
fn part(net: &mut CurveNet, v: u32, [e, f]: [u32; 2], apart: f64) -> u32 {
    let (i, j) = (other(net, e, v), other(net, f, v));
    let [p, a, b] = [v, i, j].map(|k| net.points[k as usize]);
    let (la, lb) = (p.distance(a), p.distance(b));
    let axis = ((a - p) / la + (b - p) / lb).normalize_or_zero();
    let shorter = la.min(lb);
    let angle = |q: DVec3| (a - q).angle_between(b - q);
    let steps = (2..=18).map(|k| p + axis * (0.05 * f64::from(k) * shorter));
    let open = steps.clone().find(|q| angle(*q) >= apart.to_radians());
    let end = open.or_else(|| steps.max_by(|x, y| angle(*x).total_cmp(&angle(*y))));
    let end = end.unwrap_or(0.5 * (p + a));
    let radius = {
        let t = end.distance(p) / shorter;
        let near = net.radii[i as usize].min(net.radii[j as usize]);
        (1.0 - t) * net.radii[v as usize] + t * near
    };
    let t = net.points.len() as u32;
    net.points.push(end);
    net.radii.push(radius);
    net.ids.push(-1);
    net.edges[e as usize] = [t, i];
    net.edges[f as usize] = [t, j];
    net.edges.push([v, t]);
    net.edges.len() as u32 - 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_narrow_fork_gets_a_trunk() {
        let points = vec![DVec3::ZERO, -DVec3::X, DVec3::new(2.0, 0.1, 0.0), DVec3::new(2.0, -0.1, 0.0)];
        let mut net = CurveNet::new(points, vec![0.1; 4], vec![[0, 1], [0, 2], [0, 3]]);
        let cycles = net.cycles();
        assert_eq!(zip(&mut net.clone(), 5.0, APART_DEGREES), 0);
        assert_eq!(zip(&mut net, NARROW_DEGREES, APART_DEGREES), 1);
        assert_eq!((net.points.len(), net.edges.len(), net.cycles()), (5, 4, cycles));
        let around = net.incidence();
        let at = |v: u32| around.of(v).iter().map(|s| s[0]).collect::<Vec<u32>>();
        assert!((0..5).all(|v| narrowest(&net, v, &at(v), CLOSE_DEGREES.to_radians().cos()).is_none()));
        assert_eq!(zip(&mut net, CLOSE_DEGREES, APART_DEGREES), 0);
    }
}
