//! The graph as the search sees it: darts, and the darts leaving each node.
//!
//! A dart is an edge with a direction: dart `2e + s` goes from `ends[s]` of edge `e` to the other end, and `d ^ 1` is
//! the way back. One more dart per node, `2 · edges + v`, leads from node `v` to its private boundary: taking it means
//! to leave `v` unmatched.

use super::problem::Edge;

/// An edge with a direction, or the way to the boundary.
pub(super) type Dart = u32;

/// No dart, no node.
pub(super) const NONE: u32 = u32::MAX;

/// A graph with costs. All costs handed out are doubled: the dual variables then stay integers.
pub(super) struct Graph<'a> {
    edges: &'a [Edge],
    unmatched: &'a [i64],
    /// Start of each node's range in `leaving`.
    first: Vec<u32>,
    /// The darts of edges, grouped by tail.
    leaving: Vec<Dart>,
}

impl<'a> Graph<'a> {
    /// Groups the darts by tail. The caller has checked the ends of the edges.
    pub(super) fn new(edges: &'a [Edge], unmatched: &'a [i64]) -> Self {
        let mut first = vec![0u32; unmatched.len() + 1];
        for end in edges.iter().flat_map(|edge| edge.ends) {
            first[end as usize + 1] += 1;
        }
        for v in 1..first.len() {
            first[v] += first[v - 1];
        }
        let mut fill = first.clone();
        let mut leaving = vec![0; 2 * edges.len()];
        for (dart, end) in (0..).zip(edges.iter().flat_map(|edge| edge.ends)) {
            leaving[fill[end as usize] as usize] = dart;
            fill[end as usize] += 1;
        }
        Graph { edges, unmatched, first, leaving }
    }

    /// Number of nodes.
    pub(super) fn nodes(&self) -> usize {
        self.unmatched.len()
    }

    /// The darts of edges that leave a node.
    #[inline]
    pub(super) fn leaving(&self, node: u32) -> &[Dart] {
        &self.leaving[self.first[node as usize] as usize..self.first[node as usize + 1] as usize]
    }

    /// The dart from a node to its boundary.
    #[inline]
    pub(super) fn boundary(&self, node: u32) -> Dart {
        2 * self.edges.len() as u32 + node
    }

    /// Does this dart lead nowhere: to the boundary, or is it [`NONE`]?
    #[inline]
    pub(super) fn is_exposed(&self, dart: Dart) -> bool {
        dart as usize >= 2 * self.edges.len()
    }

    /// Where a dart comes from.
    #[inline]
    pub(super) fn tail(&self, dart: Dart) -> u32 {
        match self.edges.get(dart as usize / 2) {
            Some(edge) => edge.ends[dart as usize % 2],
            None => dart - 2 * self.edges.len() as u32,
        }
    }

    /// Where the dart of an edge goes to.
    #[inline]
    pub(super) fn head(&self, dart: Dart) -> u32 {
        self.edges[dart as usize / 2].ends[1 - dart as usize % 2]
    }

    /// Twice the cost of the dart's edge.
    #[inline]
    pub(super) fn cost(&self, dart: Dart) -> i64 {
        2 * self.edges[dart as usize / 2].cost
    }

    /// Twice the cost of leaving a node unmatched.
    #[inline]
    pub(super) fn unmatched(&self, node: u32) -> i64 {
        2 * self.unmatched[node as usize]
    }
}
