//! What a matching is sought in, and what it is.

use crate::error::{Error, Result};

/// An edge between two different nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Edge {
    /// The nodes it joins.
    pub ends: [u32; 2],
    /// What it costs to match them; may be negative.
    pub cost: i64,
}

/// A matching of minimum cost.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Matching {
    /// The node each node is matched to, or [`UNMATCHED`].
    pub mate: Vec<u32>,
    /// The edge by which each node is matched, or [`UNMATCHED`].
    pub matched_edge: Vec<u32>,
    /// Cost of the matched edges and the unmatched nodes together.
    pub cost: i64,
    /// The proof that no matching costs less.
    pub certificate: Certificate,
}

/// Optimal dual variables, twice as large as in the text book so that they are integers.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Certificate {
    /// Dual of every node.
    pub node_duals: Vec<i64>,
    /// The smallest blossom that contains each node, [`NO_BLOSSOM`] if there is none.
    pub node_parents: Vec<u32>,
    /// Dual of every blossom, positive.
    pub blossom_duals: Vec<i64>,
    /// The smallest blossom around each blossom, [`NO_BLOSSOM`] if there is none. Parents come before children.
    pub blossom_parents: Vec<u32>,
}

/// The parent of what lies in no blossom.
pub const NO_BLOSSOM: u32 = u32::MAX;

/// Stands for a mate, or a matched edge, that a node does not have.
pub const UNMATCHED: u32 = u32::MAX;

pub fn check_input(edges: &[Edge], unmatched: &[i64]) -> Result<()> {
    let nodes = unmatched.len();
    if 2 * (nodes as u64 + edges.len() as u64) >= u64::from(u32::MAX) {
        return Err(Error::Options(format!("matching: {nodes} nodes and {} edges are too many", edges.len())));
    }
    for (e, &Edge { ends: [a, b], .. }) in edges.iter().enumerate() {
        if a == b || a.max(b) as usize >= nodes {
            let what = format!("matching: an edge joins {a} and {b}, but must join two different of {nodes} nodes");
            return Err(Error::input(what, format!("edge {e}"), ""));
        }
    }
    let costs = edges.iter().map(|edge| edge.cost).chain(unmatched.iter().copied());
    let largest = costs.map(i64::unsigned_abs).max().unwrap_or(0);
    let limit = (1u64 << 61) / nodes.max(64) as u64;
    if largest > limit {
        return Err(Error::Options(format!("matching: costs up to {largest}, but with {nodes} nodes at most {limit}")));
    }
    Ok(())
}
