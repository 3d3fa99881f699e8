//! Drops nodes at which a branch turns back within the ball of its next node, as a slip of the tracing makes it: cells
//! cannot follow such a turn, and the tube about the node covers it anyway.
//!
//! ```text
//!          v ╲
//!        ╱    b──          ╭ b──
//!      ╱             →     │
//!     a                    a
//! ```

use crate::mesh::CurveNet;

/// Cosine of the angle between two segments of a branch from which on it turns back.
const BACK: f64 = 0.5;

/// Articulations at which a branch turns back within the ball of a neighbour go; returns how many.
pub fn drop_turns(net: &mut CurveNet) -> usize {
    let before = net.points.len();
    loop {
        let around = net.incidence();
        let mut keep = vec![true; net.points.len()];
        // What was joined in this round is looked at again in the next one.
        let mut joined = vec![false; net.points.len()];
        for v in 0..net.points.len() {
            let &[[kept, a], [gone, b]] = around.of(v as u32) else { continue };
            let is_free = [v as u32, a, b].iter().all(|&k| !joined[k as usize]);
            let makes_loop = a == b || around.of(a).iter().any(|s| s[1] == b);
            if is_free && !makes_loop && turns_back(net, v, [a as usize, b as usize]) {
                net.edges[kept as usize] = [a, b];
                // Without length, it goes below.
                net.edges[gone as usize] = [b, b];
                keep[v] = false;
                (joined[a as usize], joined[b as usize]) = (true, true);
            }
        }
        if keep.iter().all(|&k| k) {
            return before - net.points.len();
        }
        net.edges.retain(|e| e[0] != e[1]);
        net.retain_nodes(&keep);
    }
}

fn turns_back(net: &CurveNet, v: usize, neighbours: [usize; 2]) -> bool {
    let ways = neighbours.map(|w| net.points[w] - net.points[v]);
    let [a, b] = ways.map(|w| w.normalize_or_zero());
    let is_held = neighbours.iter().zip(ways).any(|(&w, way)| way.length() < net.radii[w]);
    a.dot(b) > BACK && is_held
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// A chain along x with a node that steps back into the ball of the next one, or to where no ball is.
    fn chain(slip: DVec3) -> CurveNet {
        let mut points: Vec<DVec3> = (0..6).map(|k| DVec3::X * f64::from(k)).collect();
        points.insert(3, slip);
        CurveNet::new(points, vec![1.0; 7], (1..7).map(|k| [k - 1, k]).collect())
    }

    #[test]
    fn a_turn_within_a_ball_goes_and_a_sharp_bend_outside_stays() {
        let mut net = chain(DVec3::new(3.6, 0.3, 0.0));
        assert_eq!(drop_turns(&mut net), 1);
        assert_eq!((net.points.len(), net.cycles()), (6, vec![0]));
        assert!(net.points.iter().all(|p| p.y == 0.0) && net.edges.contains(&[2, 3]));
        let mut far = chain(DVec3::new(2.5, 3.0, 0.0));
        assert_eq!(drop_turns(&mut far), 0);
        let mut bent = chain(DVec3::new(2.5, 0.5, 0.0));
        assert_eq!(drop_turns(&mut bent), 0);
    }

    /// Three nodes in one ball keep their cycle, and so do two.
    #[test]
    fn a_small_ring_stays() {
        let points = vec![DVec3::ZERO, DVec3::X, DVec3::new(0.5, 0.2, 0.0)];
        let mut net = CurveNet::new(points, vec![2.0; 3], vec![[0, 1], [1, 2], [2, 0]]);
        assert_eq!((drop_turns(&mut net), net.cycles()), (0, vec![1]));
        let mut pair = CurveNet::new(vec![DVec3::ZERO, DVec3::X], vec![2.0; 2], vec![[0, 1], [0, 1]]);
        assert_eq!((drop_turns(&mut pair), pair.cycles()), (0, vec![1]));
    }
}
