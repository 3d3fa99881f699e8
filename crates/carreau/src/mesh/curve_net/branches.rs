//! Branches of a net: chains of segments between nodes that are no articulations, and closed chains.

use super::super::triangles::NONE;
use super::net::{CurveNet, Incidence};
use std::ops::Range;

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

    /// Whether it leads from a branching to an extremity.
    pub fn is_leaf(&self, around: &Incidence) -> bool {
        around.valence(self.nodes[0]) > 2 && around.valence(self.nodes[self.nodes.len() - 1]) == 1
    }
}

/// All branches in flat arrays: from branchings first, then between extremities, then rings. Each segment is in one.
#[derive(Debug, Clone, Default)]
pub struct Chains {
    /// The nodes of all branches, one branch behind the other.
    pub nodes: Vec<u32>,
    /// The segment from each of those nodes to the next; [`NONE`] at the last node of a branch.
    pub edges: Vec<u32>,
    /// Where every branch starts, and the number of nodes.
    pub starts: Vec<u32>,
    /// Branches from here on are rings.
    pub first_ring: usize,
}

impl Chains {
    /// Follows the segments of a net.
    pub fn new(net: &CurveNet, around: &Incidence) -> Chains {
        let mut all = Chains::default();
        // A branch has a node more than segments; few nets have more branches than half their segments.
        all.nodes.reserve(net.edges.len() + net.edges.len() / 2);
        all.edges.reserve(net.edges.len() + net.edges.len() / 2);
        let mut seen = vec![false; net.edges.len()];
        let kind = |v: u32| around.valence(v).min(3);
        for wanted in [3, 1, 2] {
            if wanted == 2 {
                all.first_ring = all.starts.len();
            }
            for v in (0..net.points.len() as u32).filter(|&v| kind(v) == wanted) {
                for &[edge, next] in around.of(v) {
                    if !seen[edge as usize] {
                        all.starts.push(all.nodes.len() as u32);
                        all.follow(around, v, [edge, next], &mut seen);
                    }
                }
            }
        }
        all.starts.push(all.nodes.len() as u32);
        all
    }

    fn follow(&mut self, around: &Incidence, start: u32, first: [u32; 2], seen: &mut [bool]) {
        let (mut from, [mut edge, mut node]) = (start, first);
        loop {
            seen[edge as usize] = true;
            self.nodes.push(from);
            self.edges.push(edge);
            from = node;
            match *around.of(node) {
                [a, b] => [edge, node] = if a[0] == edge { b } else { a },
                _ => break,
            }
            if seen[edge as usize] {
                break;
            }
        }
        self.nodes.push(from);
        self.edges.push(NONE);
    }

    /// Number of branches.
    pub fn count(&self) -> usize {
        self.starts.len() - 1
    }

    /// Where a branch stands in the lists of nodes and segments.
    pub fn span(&self, branch: usize) -> Range<usize> {
        self.starts[branch] as usize..self.starts[branch + 1] as usize
    }
}

/// All branches, one by one.
pub fn branches(net: &CurveNet, around: &Incidence) -> Vec<Branch> {
    let all = Chains::new(net, around);
    let one = |b: usize| {
        let span = all.span(b);
        let edges = all.edges[span.start..span.end - 1].to_vec();
        Branch { nodes: all.nodes[span].to_vec(), edges, is_ring: b >= all.first_ring }
    };
    (0..all.count()).map(one).collect()
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
        assert_eq!(all.iter().filter(|b| b.is_leaf(&net.incidence())).count(), 2);
    }
}
