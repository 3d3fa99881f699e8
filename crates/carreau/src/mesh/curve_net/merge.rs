//! Branchings near each other become one.

use super::branches;
use super::net::CurveNet;
use rustc_hash::FxHashMap;

/// The branch between branchings that become one may be this much longer than what they may be apart.
const ROUNDABOUT: f64 = 3.0;

impl CurveNet {
    /// Branchings joined by a branch that is shorter than what `near` says of their radii become one at the middle; returns how
    /// many went.
    pub fn merge_branchings(&mut self, near: impl Fn([f64; 2]) -> f64) -> usize {
        let mut merged = 0;
        loop {
            let around = self.incidence();
            let all = branches(self, &around);
            let mut joined: FxHashMap<[u32; 2], u32> = FxHashMap::default();
            all.iter().for_each(|b| *joined.entry(b.ends()).or_default() += 1);
            let near = all.into_iter().find(|b| {
                let [a, z] = b.ends();
                let way: f64 = b.edges.iter().map(|&e| self.length(e as usize)).sum();
                let line = self.points[a as usize].distance(self.points[z as usize]);
                let limit = near([self.radii[a as usize], self.radii[z as usize]]);
                // A second branch between the two would become a loop.
                let alone = a != z && joined[&[a, z]] == 1;
                alone && around.valence(a) > 2 && around.valence(z) > 2 && line < limit && way < ROUNDABOUT * limit
            });
            let Some(branch) = near else { return merged };
            let (a, z) = (branch.nodes[0], branch.nodes[branch.nodes.len() - 1]);
            self.points[a as usize] = 0.5 * (self.points[a as usize] + self.points[z as usize]);
            self.radii[a as usize] = self.radii[a as usize].max(self.radii[z as usize]);
            let mut keep = vec![true; self.points.len()];
            branch.nodes[1..].iter().for_each(|&v| keep[v as usize] = false);
            self.edges.iter_mut().for_each(|e| *e = e.map(|v| if v == z { a } else { v }));
            self.edges.retain(|e| e[0] != e[1] && keep[e[0] as usize] && keep[e[1] as usize]);
            self.drop_multiple_edges();
            keep[a as usize] = true;
            self.retain_nodes(&keep);
            merged += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// A cross whose four branches leave from two places: one, if that is near enough; a loop between the two stays.
    #[test]
    fn near_branchings_become_one() {
        let points = [[-5, 0], [-1, 0], [1, 0], [5, 0], [-1, 5], [1, -5], [0, 1]];
        let points = points.map(|p: [i32; 2]| DVec3::new(f64::from(p[0]), f64::from(p[1]), 0.0)).to_vec();
        let mut edges = vec![[0, 1], [1, 2], [2, 3], [1, 4], [2, 5]];
        let cross = CurveNet::new(points.clone(), vec![2.0, 2.0, 3.0, 2.0, 2.0, 2.0, 1.0], edges.clone());
        let mut far = cross.clone();
        assert_eq!(far.merge_branchings(|[a, b]| 0.9 * a.min(b)), 0);
        let mut near = cross;
        assert_eq!(near.merge_branchings(|[a, b]| 1.1 * a.min(b)), 1);
        let around = near.incidence();
        let forks: Vec<u32> = (0..near.points.len() as u32).filter(|&v| around.valence(v) > 2).collect();
        assert_eq!(forks.len(), 1);
        assert_eq!((near.points[forks[0] as usize], near.radii[forks[0] as usize]), (DVec3::ZERO, 3.0));
        edges.extend([[1, 6], [6, 2]]);
        let mut looped = CurveNet::new(points, vec![2.0; 7], edges);
        assert_eq!(looped.merge_branchings(|_| 9.0), 0);
        assert_eq!(looped.cycles(), [1]);
    }
}
