//! A feasible dual solution and a matching of tight edges to start from, found greedily.

use super::graph::{Dart, Graph, NONE};

/// Radius and matched dart of every node ([`NONE`] for a node still to be dealt with).
///
/// Every node begins with half the cost of its cheapest edge. Then, one node after the other, the radius is raised as
/// far as edges and boundary allow, and the node is matched if that made an edge to a free node tight.
pub(super) fn greedy(graph: &Graph) -> (Vec<i64>, Vec<Dart>) {
    let nodes = 0..graph.nodes() as u32;
    let half = |&dart: &Dart| graph.cost(dart) / 2;
    let cheapest = |v| graph.leaving(v).iter().map(half).min().unwrap_or(i64::MAX);
    let mut radii: Vec<i64> = nodes.clone().map(|v| cheapest(v).min(graph.unmatched(v))).collect();
    let mut mates = vec![NONE; graph.nodes()];
    for v in nodes {
        if mates[v as usize] != NONE {
            continue;
        }
        let slack = |&dart: &Dart| graph.cost(dart) - radii[v as usize] - radii[graph.head(dart) as usize];
        let room = graph.leaving(v).iter().map(slack).min().unwrap_or(i64::MAX);
        let free = |&&dart: &&Dart| slack(&dart) == room && mates[graph.head(dart) as usize] == NONE;
        let partner = graph.leaving(v).iter().find(free).copied();
        let room_to_boundary = graph.unmatched(v) - radii[v as usize];
        radii[v as usize] += room.min(room_to_boundary);
        if let Some(dart) = partner
            && room <= room_to_boundary
        {
            mates[v as usize] = dart;
            mates[graph.head(dart) as usize] = dart ^ 1;
        }
    }
    (radii, mates)
}

#[cfg(test)]
mod tests {
    use super::super::problem::Edge;
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn radii_are_feasible_and_matched_edges_tight(
            unmatched in prop::collection::vec(-20i64..40, 2..20),
            edges in prop::collection::vec((any::<prop::sample::Index>(), 1usize..20, -20i64..40), 0..60),
        ) {
            let n = unmatched.len();
            let edge = |(a, step, cost): (prop::sample::Index, usize, i64)| {
                let a = a.index(n);
                Edge { ends: [a as u32, ((a + 1 + step % (n - 1)) % n) as u32], cost }
            };
            let edges: Vec<Edge> = edges.into_iter().map(edge).collect();
            let graph = Graph::new(&edges, &unmatched);
            let (radii, mates) = greedy(&graph);
            for v in 0..n as u32 {
                prop_assert!(radii[v as usize] <= graph.unmatched(v));
                for &dart in graph.leaving(v) {
                    let head = graph.head(dart);
                    let slack = graph.cost(dart) - radii[v as usize] - radii[head as usize];
                    prop_assert!(slack >= 0);
                    if mates[v as usize] == dart {
                        prop_assert!(slack == 0 && mates[head as usize] == dart ^ 1);
                    }
                }
            }
        }
    }
}
