//! Branches of a net: chains of segments between nodes that are no articulations, and closed chains.

use super::{CurveNet, Incidence};

/// A chain of segments.
#[derive(Debug, Clone, PartialEq)]
pub struct Branch {
    /// Nodes from one end to the other; a closed chain without branching repeats its first node at the end.
    pub nodes: Vec<u32>,
    /// Segments between them, one fewer.
    pub edges: Vec<u32>,
    /// Whether no node of it is a branching or an extremity.
    pub is_ring: bool,
}

impl Branch {
    /// The nodes it joins, in ascending order.
    pub fn ends(&self) -> [u32; 2] {
        let (from, to) = (self.nodes[0], self.nodes[self.nodes.len() - 1]);
        [from.min(to), from.max(to)]
    }
}

/// All branches: from branchings first, then between extremities, then rings. Each segment is in one.
pub fn branches(net: &CurveNet, around: &Incidence) -> Vec<Branch> {
    let mut seen = vec![false; net.edges.len()];
    let mut all = Vec::new();
    let kind = |v: u32| around.valence(v).min(3);
    for wanted in [3, 1, 2] {
        for v in (0..net.points.len() as u32).filter(|&v| kind(v) == wanted) {
            for &[edge, _] in around.of(v) {
                if !seen[edge as usize] {
                    all.push(follow(around, v, edge, wanted == 2, &mut seen));
                }
            }
        }
    }
    all
}

fn follow(around: &Incidence, start: u32, first: u32, is_ring: bool, seen: &mut [bool]) -> Branch {
    let mut branch = Branch { nodes: vec![start], edges: Vec::new(), is_ring };
    let (mut node, mut edge) = (start, first);
    loop {
        seen[edge as usize] = true;
        branch.edges.push(edge);
        node = around.of(node).iter().find(|s| s[0] == edge).map_or(node, |s| s[1]);
        branch.nodes.push(node);
        let next = around.of(node).iter().find(|s| s[0] != edge);
        match next {
            Some(&[e, _]) if around.valence(node) == 2 && !seen[e as usize] => edge = e,
            _ => return branch,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn every_segment_is_in_one_branch() {
        // A fork, a handle on it, a ring.
        let edges = vec![[0, 1], [1, 2], [2, 3], [3, 1], [1, 4], [5, 6], [6, 7], [7, 5]];
        let net = CurveNet::new(vec![DVec3::ZERO; 8], vec![1.0; 8], edges);
        let all = branches(&net, &net.incidence());
        let mut used: Vec<u32> = all.iter().flat_map(|b| b.edges.clone()).collect();
        used.sort_unstable();
        assert_eq!(used, (0..8).collect::<Vec<u32>>());
        assert_eq!(all.iter().filter(|b| b.is_ring).count(), 1);
        assert!(all.iter().any(|b| b.nodes == [1, 2, 3, 1] && !b.is_ring));
    }
}
