//! Minimum-cost matching in sparse general graphs, where every node may also be left unmatched at a cost of its own.
//!
//! Minimises `Σ cost(e)` over the matched edges plus `Σ unmatched(v)` over the unmatched nodes, exactly, in integers.
//! The method is Edmonds' primal–dual blossom algorithm (J. Edmonds, *Maximum matching and a polyhedron with
//! 0,1-vertices*, J. Res. NBS 69B, 1965), made for sparse graphs in which an augmenting path is usually short:
//!
//! 1. `graph`: edges become pairs of darts; leaving a node unmatched is a private edge to a boundary.
//! 2. `start`: a greedy feasible dual and a matching of tight edges that covers most nodes.
//! 3. `search`, `blossoms`: from each node left, one alternating tree at a time, driven by a queue of events (among the variants in
//!    V. Kolmogorov, *Blossom V*, Math. Prog. Comp. 1, 2009, this is single-tree growth). A tree touches only the nodes
//!    it reaches before an augmenting path is found. `solve` below says in which order the trees grow.
//! 4. `family`: blossoms in a union–find forest without path compression, so that they can be opened again, with
//!    dual variables stored as differences, so that raising a blossom changes one number. This departs from the
//!    literature, where look-up structures are rebuilt or repaired when a blossom is expanded.
//! 5. `certificate`: the dual solution is kept and checked against the matching, always.

mod blossoms;
mod certificate;
mod event;
mod family;
mod graph;
mod problem;
mod search;
mod start;
#[cfg(test)]
mod tests;

use crate::context::Context;
use crate::error::Result;
use family::{Family, Set};
use graph::{Graph, NONE};
use problem::check_input;
use search::TreeSearch;

pub use certificate::certify;
pub use problem::{Certificate, Edge, Matching, NO_BLOSSOM, UNMATCHED};

/// Finds a matching of minimum cost, and certifies it. `unmatched` has the cost of leaving each node unmatched, so its
/// length is the number of nodes.
///
/// The graph may have any number of components and parallel edges; costs may be negative. The same input gives the same
/// matching. Where most nodes find a partner nearby, as in dual graphs of meshes, time grows almost in proportion to the
/// number of nodes. The worst case is that of growing single trees: nodes · edges, up to logarithms and the depth of the
/// blossoms. Large regular grids come near it when their free nodes are dear to leave and far apart.
///
/// # Errors
/// - [`Error::Input`](crate::Error::Input): an edge has an end that is not a node, or two equal ends.
/// - [`Error::Options`](crate::Error::Options): nodes and edges are together 2³¹ or more; or the largest absolute cost times the number of
///   nodes (but at least 64) exceeds 2⁶¹, so that sums might overflow.
/// - [`Error::Deadline`](crate::Error::Deadline), [`Error::Cancelled`](crate::Error::Cancelled).
pub fn minimum_cost_matching(edges: &[Edge], unmatched: &[i64], context: &Context) -> Result<Matching> {
    check_input(edges, unmatched)?;
    context.check()?;
    let graph = Graph::new(edges, unmatched);
    let search = solve(&graph, FIRST_LIMIT, context)?;
    tracing::debug!(target: "carreau::matching", nodes = unmatched.len(), edges = edges.len(), work = ?search.counts);
    context.check()?;
    let matching = read_off(&graph, search.family, edges, unmatched);
    certify(edges, unmatched, &matching)?;
    Ok(matching)
}

/// How many sets a tree may have in the first round of searches.
const FIRST_LIMIT: usize = 64;

/// How many sets, as a multiple of the number of nodes, may go into trees that are cut off before the limit is raised.
const PATIENCE: usize = 4;

/// Matches every node, or decides that it is to be left.
///
/// A node that has to be left lets its tree sweep far around, and makes blossoms of all it meets, before it gives up.
/// If it comes too early, all trees after it have to go through these blossoms (on a mesh of 160,000 triangles with
/// dear nodes that takes 40 times as long). So trees are cut off at a limit that doubles from round to round: near
/// pairs come first. Where many nodes have to be left, though, the duals that the first of them leaves behind help all
/// others to give up soon. So if a round did not settle half of the nodes, the next one doubles the limit as soon as
/// too much work has gone into trees that were cut off.
fn solve<'a>(graph: &'a Graph<'a>, first_limit: usize, context: &Context) -> Result<TreeSearch<'a>> {
    let (radii, mates) = start::greedy(graph);
    let mut left: Vec<u32> = (0..).zip(&mates).filter(|&(_, &mate)| mate == NONE).map(|(v, _)| v).collect();
    let mut search = TreeSearch::new(graph, Family::new(&radii, &mates));
    let mut limit = first_limit;
    let mut patience = usize::MAX;
    while !left.is_empty() {
        let mut still_left = Vec::new();
        let mut wasted = 0;
        for (step, &v) in left.iter().enumerate() {
            context.check_every(step)?;
            let root = search.family.around(v);
            // A tree from another node may have ended here.
            if search.family[root].mate == NONE && !search.augment_from(root, limit, context)? {
                still_left.push(v);
                wasted += limit;
            }
            if wasted > patience {
                (limit, wasted) = (limit.saturating_mul(2), 0);
            }
        }
        limit = limit.saturating_mul(2);
        patience = if still_left.len() > left.len() / 2 { PATIENCE * graph.nodes() } else { usize::MAX };
        left = still_left;
    }
    Ok(search)
}

/// Opens all blossoms and writes down what is left: every node with its mate and its dual.
fn read_off(graph: &Graph, mut family: Family, edges: &[Edge], unmatched: &[i64]) -> Matching {
    let mut matching = Matching { certificate: open_all(graph, &mut family), ..Matching::default() };
    for (v, &cost) in (0..).zip(unmatched) {
        let dart = family[v].mate;
        matching.certificate.node_duals.push(family[v].dual);
        if graph.is_exposed(dart) {
            matching.mate.push(UNMATCHED);
            matching.matched_edge.push(UNMATCHED);
            matching.cost += cost;
        } else {
            matching.mate.push(graph.head(dart));
            matching.matched_edge.push(dart / 2);
            // Either end of an edge comes by here; the first one counts it.
            matching.cost += if dart.is_multiple_of(2) { edges[dart as usize / 2].cost } else { 0 };
        }
    }
    matching
}

/// Opens all blossoms from the outside in, and writes down how they are nested and their duals.
fn open_all(graph: &Graph, family: &mut Family) -> Certificate {
    let mut certificate = Certificate { node_parents: vec![NO_BLOSSOM; graph.nodes()], ..Certificate::default() };
    let mut stack = Vec::new();
    for v in 0..graph.nodes() as u32 {
        stack.push((family.around(v), NO_BLOSSOM));
        while let Some((set, parent)) = stack.pop() {
            let Set { dual, child, .. } = family[set];
            if child == NONE {
                if parent != NO_BLOSSOM {
                    certificate.node_parents[set as usize] = parent;
                }
                continue;
            }
            // A blossom with dual 0 proves nothing.
            let mut inside = parent;
            if dual != 0 {
                inside = certificate.blossom_duals.len() as u32;
                certificate.blossom_duals.push(dual);
                certificate.blossom_parents.push(parent);
            }
            family.open_matched(set, graph);
            stack.extend(family.cycle(child).map(|set| (set, inside)));
        }
    }
    certificate
}
