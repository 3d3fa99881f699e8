//! The whole method against brute force on small graphs, and against its own certificate on larger ones.

use super::search::Counts;
use super::*;
use crate::error::Error;
use proptest::prelude::*;
use std::time::{Duration, Instant};

/// Solves and certifies; trees are cut off at `first_limit` sets in the first round.
fn solve_with(first_limit: usize, edges: &[Edge], unmatched: &[i64]) -> (Matching, Counts) {
    check_input(edges, unmatched).unwrap();
    let graph = Graph::new(edges, unmatched);
    let search = solve(&graph, first_limit, &Context::new()).unwrap();
    let counts = search.counts;
    let matching = read_off(&graph, search.family, edges, unmatched);
    certify(edges, unmatched, &matching).unwrap();
    (matching, counts)
}

fn optimum(edges: &[Edge], unmatched: &[i64]) -> Matching {
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

fn edge(a: u32, b: u32, cost: i64) -> Edge {
    Edge { ends: [a, b], cost }
}

/// A small generator of pseudo-random numbers (SplitMix64).
struct Random(u64);

impl Random {
    fn below(&mut self, n: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ (z >> 31)) % n
    }

    fn cost(&mut self, range: u64) -> i64 {
        self.below(range) as i64
    }

    fn permutation(&mut self, n: u32) -> Vec<u32> {
        let mut p: Vec<u32> = (0..n).collect();
        for k in (1..n as usize).rev() {
            p.swap(k, self.below(k as u64 + 1) as usize);
        }
        p
    }
}

/// A Hamiltonian cycle and a perfect matching on top, on an even number of nodes: every node has degree 3.
fn cubic(n: u32, range: u64, random: &mut Random) -> Vec<Edge> {
    let around = random.permutation(n);
    let across = random.permutation(n);
    let cycle = (0..n as usize).map(|k| [around[k], around[(k + 1) % n as usize]]);
    let chords = across.chunks(2).map(|pair| [pair[0], pair[1]]);
    cycle.chain(chords).map(|ends| Edge { ends, cost: random.cost(range) }).collect()
}

/// The dual graph of a triangulated grid: each square is cut along one of its diagonals.
///
/// ```text
///   ┌─────┐   ┌─────┐      triangle 2s below the diagonal of square s,
///   │2s+1╱│   │╲2s+1│      triangle 2s + 1 above
///   │  ╱2s│   │2s╲  │
///   └─────┘   └─────┘
/// ```
fn grid_dual(width: u32, height: u32, range: u64, random: &mut Random) -> Vec<Edge> {
    let slopes: Vec<bool> = (0..width * height).map(|_| random.below(2) == 0).collect();
    let left = |s: u32| 2 * s + u32::from(slopes[s as usize]);
    let right = |s: u32| 2 * s + u32::from(!slopes[s as usize]);
    let mut edges = Vec::new();
    for s in 0..width * height {
        edges.push(edge(2 * s, 2 * s + 1, random.cost(range)));
        if (s + 1) % width != 0 {
            edges.push(edge(right(s), left(s + 1), random.cost(range)));
        }
        if s + width < width * height {
            edges.push(edge(2 * s + 1, 2 * (s + width), random.cost(range)));
        }
    }
    edges
}

/// How deep blossoms with a positive dual are nested.
fn depth(matching: &Matching) -> usize {
    let parents = &matching.certificate.blossom_parents;
    let mut depths: Vec<usize> = Vec::new();
    for &parent in parents {
        depths.push(if parent == NO_BLOSSOM { 1 } else { depths[parent as usize] + 1 });
    }
    depths.into_iter().max().unwrap_or(0)
}

/// Graphs with up to `nodes` nodes, `density` edges per node, and few different costs, so that ties abound.
fn graphs(nodes: usize, density: usize) -> impl Strategy<Value = (Vec<Edge>, Vec<i64>)> {
    (1..=nodes, 1i64..12, -6i64..10).prop_flat_map(move |(n, range, base)| {
        let edge = (0..n as u32, 1..(n as u32).max(2), base..base + range)
            .prop_map(move |(a, step, cost)| edge(a, (a + step) % n as u32, cost));
        let edges = if n == 1 { 0..1 } else { 0..density * n };
        (prop::collection::vec(edge, edges), prop::collection::vec(-3i64..16, n))
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    #[test]
    fn finds_the_optimum_of_small_graphs((edges, unmatched) in graphs(11, 5), first_limit in 1usize..8) {
        prop_assert_eq!(solve_with(first_limit, &edges, &unmatched).0.cost, brute_force(&edges, &unmatched));
    }

    /// Perfect matchings where they exist: the nodes are not to be left.
    #[test]
    fn finds_the_optimum_when_nodes_are_dear((edges, mut unmatched) in graphs(11, 3)) {
        unmatched.fill(1000);
        prop_assert_eq!(optimum(&edges, &unmatched).cost, brute_force(&edges, &unmatched));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// Every matching has one edge or boundary at each node, so adding to all of these shifts all costs alike. The
    /// greedy start is a different one, though, and so are the trees if the nodes change their names.
    #[test]
    fn the_optimum_moves_with_the_nodes(
        (edges, unmatched) in graphs(60, 4),
        shifts in prop::collection::vec(-50i64..50, 60),
        seed in any::<u64>(),
    ) {
        let cost = optimum(&edges, &unmatched).cost;
        let n = unmatched.len();
        let name = Random(seed).permutation(n as u32);
        let shifted_edges: Vec<Edge> = edges
            .iter()
            .rev()
            .map(|&Edge { ends: [a, b], cost }| {
                edge(name[b as usize], name[a as usize], cost + shifts[a as usize] + shifts[b as usize])
            })
            .collect();
        let mut shifted_unmatched = vec![0; n];
        for v in 0..n {
            shifted_unmatched[name[v] as usize] = unmatched[v] + shifts[v];
        }
        let shifted = optimum(&shifted_edges, &shifted_unmatched).cost;
        prop_assert_eq!(shifted, cost + shifts[..n].iter().sum::<i64>());
    }
}

/// Ties and odd cycles everywhere: blossoms within blossoms, opened again by later trees. The certificate is the judge.
#[test]
fn nested_blossoms_are_shrunk_and_expanded() {
    let random = &mut Random(1);
    let (mut deepest, mut expanded, mut cut_off) = (0, 0, 0);
    for case in 0..1500 {
        let n = 20 + random.below(41) as u32;
        let m = u64::from(n) * (1 + random.below(9));
        let range = 1 + random.below(if case % 2 == 0 { 6 } else { 60 });
        let edges: Vec<Edge> = (0..m)
            .map(|_| {
                let a = random.below(n.into()) as u32;
                let b = (a + 1 + random.below(u64::from(n) - 1) as u32) % n;
                edge(a, b, random.cost(range))
            })
            .collect();
        let dear = [2, 5, 1000][case % 3] * range as i64;
        let unmatched: Vec<i64> = (0..n).map(|_| dear + random.cost(range)).collect();
        let (matching, counts) = solve_with([1, 8, 64][case % 3], &edges, &unmatched);
        deepest = deepest.max(depth(&matching));
        expanded += counts.expanded;
        cut_off += counts.cut_off;
    }
    assert!(deepest >= 5 && expanded >= 500 && cut_off >= 500, "{deepest} {expanded} {cut_off}");
}

/// By Petersen's theorem (here: by every other edge of the Hamiltonian cycle) nobody has to be left.
#[test]
fn cubic_graphs_are_matched_perfectly_when_nodes_are_dear() {
    let random = &mut Random(2);
    for (n, range) in [(2, 1), (4, 3), (10, 2), (1000, 3), (1000, 1_000_000), (8000, 2), (8000, 1_000_000)] {
        let edges = cubic(n, range, random);
        let matching = optimum(&edges, &vec![1_000_000_000; n as usize]);
        assert!(!matching.mate.contains(&UNMATCHED));
        let cheap = optimum(&edges, &vec![range as i64 / 3; n as usize]);
        assert!(cheap.cost <= matching.cost);
    }
}

#[test]
fn mesh_duals_are_matched() {
    let random = &mut Random(3);
    for (width, height, range) in [(1, 1, 1), (1, 9, 5), (70, 50, 1), (60, 60, 4), (60, 60, 1_000_000)] {
        let edges = grid_dual(width, height, range, random);
        let n = 2 * (width * height) as usize;
        // The two halves of a square can always be matched.
        assert!(!optimum(&edges, &vec![1_000_000_000; n]).mate.contains(&UNMATCHED));
        // The order in which trees get their turn is of no consequence for the cost.
        let cheap = vec![range as i64 * 2 / 3; n];
        let costs = [1, 16, usize::MAX].map(|first_limit| solve_with(first_limit, &edges, &cheap).0.cost);
        assert!(costs[0] == costs[1] && costs[1] == costs[2]);
    }
}

/// Squares without one corner triangle: somebody has to be left, exactly once in each component.
#[test]
fn odd_components_leave_one_node_each() {
    let random = &mut Random(4);
    let (width, height, copies) = (9, 7, 5);
    let n = 2 * width * height;
    let mut edges = Vec::new();
    for copy in 0..copies {
        let grid = grid_dual(width, height, 100, random);
        edges.extend(grid.iter().filter(|edge| !edge.ends.contains(&0)).map(|&Edge { ends: [a, b], cost }| {
            let offset = copy * (n - 1);
            edge(a - 1 + offset, b - 1 + offset, cost)
        }));
    }
    let matching = optimum(&edges, &vec![1_000_000; ((n - 1) * copies) as usize]);
    for component in matching.mate.chunks(n as usize - 1) {
        assert_eq!(component.iter().filter(|&&mate| mate == UNMATCHED).count(), 1);
    }
}

#[test]
fn a_hidden_matching_of_cost_zero_is_found() {
    let random = &mut Random(5);
    for n in [10, 100, 2000] {
        let pairs = random.permutation(n);
        let mut edges: Vec<Edge> = pairs.chunks(2).map(|pair| edge(pair[0], pair[1], 0)).collect();
        for _ in 0..3 * n {
            let a = random.below(n.into()) as u32;
            edges.push(edge(a, (a + 1 + random.below(u64::from(n) - 1) as u32) % n, 1 + random.cost(3)));
        }
        assert_eq!(optimum(&edges, &vec![5; n as usize]).cost, 0);
    }
}

/// What keeps trees small: near pairs come first (chain), of many nodes that have to be left only the first ones take a
/// lot of work (board), and ties are explored in all directions alike (ties). The bounds, in events per node, are about
/// twice what it takes, and each is exceeded without the respective measure.
#[test]
fn trees_stay_small() {
    let random = &mut Random(8);
    let chain: Vec<Edge> = (0..8000)
        .flat_map(|k| {
            let [a, b, c] = [3 * k, 3 * k + 1, 3 * k + 2];
            [edge(a, b, 0), edge(b, c, 0), edge(c, a, 0), edge(c, (a + 3) % 24000, 1)]
        })
        .collect();
    // A chess board without some of its black fields, and all edges alike.
    let mut field = |x: u32, y: u32| ((x + y) % 2 == 1 || random.below(50) > 0).then_some(100 * y + x);
    let fields: Vec<Option<u32>> = (0..10_000).map(|k| field(k % 100, k / 100)).collect();
    let board: Vec<Edge> = (0..9_900)
        .flat_map(|k| [(k % 100 < 99).then_some((k, k + 1)), Some((k, k + 100))])
        .flatten()
        .filter_map(|(a, b)| Some(edge(fields[a as usize]?, fields[b as usize]?, 0)))
        .collect();
    let mesh = grid_dual(80, 60, 1000, random);
    let ties: Vec<Edge> = (0..25_000)
        .map(|k| edge(k % 5000, (k % 5000 + 1 + random.below(4999) as u32) % 5000, random.cost(4)))
        .collect();
    for (n, edges, bound) in [(24000, chain, 12), (10000, board, 20), (9600, mesh, 4), (5000, ties, 8)] {
        let (_, counts) = solve_with(FIRST_LIMIT, &edges, &vec![1_000_000; n]);
        assert!(counts.events <= bound * n, "{counts:?} for {n} nodes");
    }
}

#[test]
fn graphs_without_choice() {
    assert_eq!(optimum(&[], &[]), Matching::default());
    let lonely = optimum(&[], &[3, -4, 0]);
    assert_eq!((lonely.mate, lonely.cost), (vec![UNMATCHED; 3], -1));
    let parallel = optimum(&[edge(0, 1, 7), edge(1, 0, 2), edge(0, 1, 5)], &[4, 4]);
    assert_eq!((parallel.mate, parallel.matched_edge, parallel.cost), (vec![1, 0], vec![1, 1], 2));
    let too_dear = optimum(&[edge(0, 1, 9)], &[4, 4]);
    assert_eq!((too_dear.matched_edge, too_dear.cost), (vec![UNMATCHED; 2], 8));
}

#[test]
fn the_largest_costs_do_not_overflow() {
    let limit = (1i64 << 61) / 64;
    let random = &mut Random(6);
    for _ in 0..200 {
        let mut pick = || [-limit, limit, limit - 1, 1 - limit, 0][random.below(5) as usize];
        let unmatched: Vec<i64> = (0..10).map(|_| pick()).collect();
        let edges: Vec<Edge> = (0..45).map(|k| edge(k % 10, (k % 10 + 1 + k / 10) % 10, pick())).collect();
        assert_eq!(optimum(&edges, &unmatched).cost, brute_force(&edges, &unmatched));
    }
    let too_large = minimum_cost_matching(&[], &[limit + 1], &Context::new());
    assert!(matches!(too_large, Err(Error::Options(_))));
    assert!(matches!(minimum_cost_matching(&[], &[i64::MIN], &Context::new()), Err(Error::Options(_))));
}

#[test]
fn impossible_edges_are_refused() {
    for ends in [[0, 0], [0, 2], [u32::MAX, 0]] {
        let result = minimum_cost_matching(&[Edge { ends, cost: 1 }], &[1, 1], &Context::new());
        assert!(matches!(result, Err(Error::Input { .. })));
    }
}

#[test]
fn a_deadline_stops_the_search() {
    let late = Context::new().with_deadline(Instant::now() - Duration::from_secs(1));
    assert!(matches!(minimum_cost_matching(&[], &[1], &late), Err(Error::Deadline)));
    let edges = cubic(8000, 1_000_000, &mut Random(7));
    let unmatched = vec![1_000_000_000; 8000];
    let graph = Graph::new(&edges, &unmatched);
    assert!(matches!(solve(&graph, FIRST_LIMIT, &late), Err(Error::Deadline)));
}
