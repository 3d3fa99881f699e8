//! The proof of optimality that goes with a matching, and its check.
//!
//! The check knows nothing of how the matching was found: it rests on weak duality alone. Let node duals `y(v)` of any
//! sign and duals `Y(S) ≥ 0` of odd node sets satisfy
//!
//! ```text
//!   y(u) + y(v) + Σ Y(S) over the S that separate u from v  ≤  cost(u, v)         for every edge
//!   y(v) + Σ Y(S) over the S that contain v                 ≤  unmatched(v)       for every node
//! ```
//!
//! Every matching leaves at least one node of an odd set S to an edge out of S or unmatched, so no matching costs less
//! than `Σ y(v) + Σ Y(S)` (Edmonds 1965). A matching that costs exactly that much is optimal.

use super::problem::{Certificate, Edge, Matching, NO_BLOSSOM, UNMATCHED, check_input};
use crate::error::{Error, Result};

/// Checks that a matching is one, that its cost is stated correctly, and that its certificate proves it optimal.
///
/// Takes linear time, but for a logarithm where blossoms are nested.
///
/// # Errors
/// [`Error::Bug`] if the matching is not proven to be optimal, [`Error::Input`] or [`Error::Options`] for a graph that
/// [`minimum_cost_matching`](super::minimum_cost_matching) would not have taken.
pub fn certify(edges: &[Edge], unmatched: &[i64], matching: &Matching) -> Result<()> {
    check_input(edges, unmatched)?;
    check(edges, unmatched, matching).map_err(|what| Error::Bug(format!("minimum-cost matching: {what}")))
}

type Check<T> = std::result::Result<T, String>;

fn check(edges: &[Edge], unmatched: &[i64], matching: &Matching) -> Check<()> {
    let primal = primal_cost(edges, unmatched, matching)?;
    let dual = dual_cost(edges, unmatched, &matching.certificate)?;
    if primal != i128::from(matching.cost) {
        return Err(format!("the cost is {primal}, not {}", matching.cost));
    }
    if 2 * primal != dual {
        return Err(format!("twice the cost is {}, the dual bound {dual}", 2 * primal));
    }
    Ok(())
}

/// The cost of the matching, if it is one.
fn primal_cost(edges: &[Edge], unmatched: &[i64], matching: &Matching) -> Check<i128> {
    let Matching { mate, matched_edge, .. } = matching;
    if mate.len() != unmatched.len() || matched_edge.len() != unmatched.len() {
        return Err("wrong number of nodes".into());
    }
    let mut cost = 0;
    for (v, ((&mate, &edge), &unmatched)) in (0..).zip(mate.iter().zip(matched_edge).zip(unmatched)) {
        if mate == UNMATCHED && edge == UNMATCHED {
            cost += i128::from(unmatched);
            continue;
        }
        let Some(Edge { ends, cost: edge_cost }) = edges.get(edge as usize) else {
            return Err(format!("node {v} is matched by edge {edge}, which does not exist"));
        };
        if *ends != [v, mate] && *ends != [mate, v] {
            return Err(format!(
                "node {v} is matched to {mate} by edge {edge}, which joins {} and {}",
                ends[0], ends[1]
            ));
        }
        if matched_edge.get(mate as usize) != Some(&edge) {
            return Err(format!("node {v} is matched to {mate}, but not the other way round"));
        }
        if v == ends[0] {
            cost += i128::from(*edge_cost);
        }
    }
    Ok(cost)
}

/// The lower bound that the duals give, if they are feasible.
fn dual_cost(edges: &[Edge], unmatched: &[i64], certificate: &Certificate) -> Check<i128> {
    let nest = Nest::new(certificate)?;
    let Certificate { node_duals, node_parents, blossom_duals, .. } = certificate;
    if node_duals.len() != unmatched.len() {
        return Err("wrong number of node duals".into());
    }
    let radius = |v: usize| i128::from(node_duals[v]) + nest.around(node_parents[v]);
    for (v, &unmatched) in unmatched.iter().enumerate() {
        if radius(v) > 2 * i128::from(unmatched) {
            return Err(format!("the dual at node {v} exceeds the cost of leaving it unmatched"));
        }
    }
    for (e, &Edge { ends, cost }) in edges.iter().enumerate() {
        let [u, v] = ends.map(|end| end as usize);
        let common = nest.around(nest.innermost_common(node_parents[u], node_parents[v]));
        if radius(u) + radius(v) - 2 * common > 2 * i128::from(cost) {
            return Err(format!("the reduced cost of edge {e} is negative"));
        }
    }
    Ok(node_duals.iter().chain(blossom_duals).map(|&dual| i128::from(dual)).sum())
}

/// The blossoms as a forest, with heavy paths for finding common ancestors.
struct Nest<'a> {
    parents: &'a [u32],
    /// The top of the heavy path that each blossom is on.
    top: Vec<u32>,
    /// The sum of the duals from each blossom outwards.
    around: Vec<i128>,
}

impl<'a> Nest<'a> {
    /// Checks that parents come before children, duals are positive and all blossoms odd.
    fn new(certificate: &'a Certificate) -> Check<Self> {
        let Certificate { node_duals, node_parents, blossom_duals, blossom_parents } = certificate;
        let count = blossom_duals.len();
        let known = |parent: u32, limit: usize| parent == NO_BLOSSOM || (parent as usize) < limit;
        if node_parents.len() != node_duals.len()
            || blossom_parents.len() != count
            || !node_parents.iter().all(|&parent| known(parent, count))
            || !blossom_parents.iter().enumerate().all(|(b, &parent)| known(parent, b))
        {
            return Err("the blossoms are not nested".into());
        }
        let mut size = vec![0u32; count];
        for &parent in node_parents.iter().filter(|&&parent| parent != NO_BLOSSOM) {
            size[parent as usize] += 1;
        }
        for b in (0..count).rev() {
            if size[b].is_multiple_of(2) {
                return Err(format!("blossom {b} has {} nodes, an even number", size[b]));
            }
            if blossom_parents[b] != NO_BLOSSOM {
                size[blossom_parents[b] as usize] += size[b];
            }
        }
        let mut nest = Nest { parents: blossom_parents, top: vec![NO_BLOSSOM; count], around: Vec::new() };
        for (b, (&dual, &parent)) in blossom_duals.iter().zip(blossom_parents).enumerate() {
            if dual < 0 {
                return Err(format!("blossom {b} has the negative dual {dual}"));
            }
            nest.around.push(i128::from(dual) + nest.around(parent));
        }
        nest.find_heavy_paths(&size);
        Ok(nest)
    }

    fn find_heavy_paths(&mut self, size: &[u32]) {
        let mut heaviest = vec![NO_BLOSSOM; size.len()];
        for (b, &parent) in self.parents.iter().enumerate().filter(|&(_, &parent)| parent != NO_BLOSSOM) {
            let best = &mut heaviest[parent as usize];
            if *best == NO_BLOSSOM || size[b] > size[*best as usize] {
                *best = b as u32;
            }
        }
        for (b, &parent) in self.parents.iter().enumerate() {
            let goes_on = parent != NO_BLOSSOM && heaviest[parent as usize] == b as u32;
            self.top[b] = if goes_on { self.top[parent as usize] } else { b as u32 };
        }
    }

    /// The sum of the duals of this blossom and those around it.
    fn around(&self, blossom: u32) -> i128 {
        if blossom == NO_BLOSSOM { 0 } else { self.around[blossom as usize] }
    }

    /// The smallest blossom in which both lie: leaves the path whose top comes later until both are on one path.
    fn innermost_common(&self, mut a: u32, mut b: u32) -> u32 {
        while a != NO_BLOSSOM && b != NO_BLOSSOM {
            let (top_a, top_b) = (self.top[a as usize], self.top[b as usize]);
            if top_a == top_b {
                return a.min(b);
            }
            if top_a > top_b {
                a = self.parents[top_a as usize];
            } else {
                b = self.parents[top_b as usize];
            }
        }
        NO_BLOSSOM
    }
}

#[cfg(test)]
mod tests {
    use super::super::minimum_cost_matching;
    use super::*;
    use crate::context::Context;

    /// Two triangles of triangles with a dear edge in between: each has an even rest only if that edge is taken, so
    /// there are two blossoms of nine nodes with three blossoms of three in each.
    fn example() -> (Vec<Edge>, Vec<i64>, Matching) {
        let mut edges = Vec::new();
        for half in [0, 9] {
            for corner in [0, 3, 6] {
                for [a, b] in [[0, 1], [1, 2], [2, 0]] {
                    edges.push(Edge { ends: [half + corner + a, half + corner + b], cost: 0 });
                }
                edges.push(Edge { ends: [half + corner, half + (corner + 4) % 9], cost: 4 });
            }
        }
        edges.push(Edge { ends: [8, 17], cost: 100 });
        let unmatched = vec![1000; 18];
        let matching = minimum_cost_matching(&edges, &unmatched, &Context::new()).unwrap();
        (edges, unmatched, matching)
    }

    #[test]
    fn the_example_has_nested_blossoms() {
        let (_, _, matching) = example();
        assert_eq!(matching.cost, 108);
        assert!(matching.certificate.blossom_parents.iter().any(|&parent| parent != NO_BLOSSOM));
    }

    /// Spoils one thing after the other in a good matching and its certificate.
    #[test]
    fn nothing_may_be_changed() {
        let (edges, unmatched, good) = example();
        let refused = |spoil: &dyn Fn(&mut Matching)| {
            let mut bad = good.clone();
            spoil(&mut bad);
            matches!(certify(&edges, &unmatched, &bad), Err(Error::Bug(_)))
        };
        assert!(!refused(&|_| {}));
        assert!(refused(&|m| m.cost += 1));
        assert!(refused(&|m| {
            m.mate.pop();
        }));
        for v in 0..18 {
            assert!(refused(&|m| m.certificate.node_duals[v] += 1));
            assert!(refused(&|m| m.certificate.node_duals[v] -= 1));
            for other in [0, 1, 5, 77, UNMATCHED].into_iter().filter(|&other| other != good.mate[v]) {
                assert!(refused(&|m| m.mate[v] = other));
            }
            for other in [0, 3, 9, 77, UNMATCHED].into_iter().filter(|&other| other != good.matched_edge[v]) {
                assert!(refused(&|m| m.matched_edge[v] = other));
            }
            // A node that changes its blossom leaves two even ones.
            for other in 0..good.certificate.blossom_duals.len() as u32 {
                assert!(
                    other == good.certificate.node_parents[v] || refused(&|m| m.certificate.node_parents[v] = other)
                );
            }
            assert!(refused(&|m| m.certificate.node_parents[v] = 77));
        }
        for b in 0..good.certificate.blossom_duals.len() {
            assert!(refused(&|m| m.certificate.blossom_duals[b] += 2));
            assert!(refused(&|m| m.certificate.blossom_duals[b] = -m.certificate.blossom_duals[b]));
            assert!(refused(&|m| m.certificate.blossom_parents[b] = b as u32));
        }
    }

    /// Another matching with the duals of the best one: dearer, and told so.
    #[test]
    fn a_matching_that_is_not_the_best_is_refused() {
        let (edges, unmatched, mut matching) = example();
        for v in [8, 17] {
            matching.mate[v] = UNMATCHED;
            matching.matched_edge[v] = UNMATCHED;
        }
        matching.cost += 2 * 1000 - 100;
        assert!(matches!(certify(&edges, &unmatched, &matching), Err(Error::Bug(what)) if what.contains("bound")));
    }

    /// Common ancestors by heavy paths against those by walking.
    #[test]
    fn common_blossoms_are_the_innermost() {
        let parents: Vec<u32> =
            (0..200u32).map(|b| if b % 67 == 0 { NO_BLOSSOM } else { b - 1 - (b * b * 7 + b) % b.min(9) }).collect();
        // Two more nodes than needed to be odd in each: the blossom's own and, for every even one, another.
        let mut node_parents: Vec<u32> = (0..200).collect();
        let mut size = vec![1u32; 200];
        for b in (0..200).rev() {
            if size[b].is_multiple_of(2) {
                node_parents.push(b as u32);
                size[b] += 1;
            }
            if parents[b] != NO_BLOSSOM {
                size[parents[b] as usize] += size[b];
            }
        }
        let certificate = Certificate {
            node_duals: vec![0; node_parents.len()],
            node_parents,
            blossom_duals: vec![1; 200],
            blossom_parents: parents.clone(),
        };
        let nest = Nest::new(&certificate).unwrap();
        let ancestors = |b| std::iter::successors(Some(b), |&b| Some(parents[b as usize]).filter(|&p| p != NO_BLOSSOM));
        for a in 0..200 {
            for b in 0..200 {
                let walked = ancestors(a).find(|&above| ancestors(b).any(|other| other == above));
                assert_eq!(nest.innermost_common(a, b), walked.unwrap_or(NO_BLOSSOM));
            }
            assert_eq!(nest.around(a), ancestors(a).count() as i128);
            assert_eq!(nest.innermost_common(a, NO_BLOSSOM), NO_BLOSSOM);
        }
    }
}
