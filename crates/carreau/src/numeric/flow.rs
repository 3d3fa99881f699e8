//! Minimum cut of an undirected graph with terminals: Dinic's algorithm (Dinitz 1970), integer capacities.
//!
//! Meant for narrow bands of a mesh, where a few hundred phases suffice; the cut is the one nearest to the source, which
//! makes it unique.

/// An undirected edge with its capacity.
#[derive(Debug, Clone, Copy)]
pub struct Edge {
    /// The two nodes.
    pub ends: [u32; 2],
    /// Capacity in both directions, not negative.
    pub capacity: i64,
}

/// A graph with capacities from the source and to the sink.
#[derive(Debug, Clone, Default)]
pub struct CutGraph {
    /// Edges between nodes.
    pub edges: Vec<Edge>,
    /// Capacity from the source to every node.
    pub source: Vec<i64>,
    /// Capacity from every node to the sink.
    pub sink: Vec<i64>,
}

/// An arc of the residual graph; the reverse of arc `k` is arc `k ^ 1`.
struct Residual {
    head: Vec<u32>,
    room: Vec<i64>,
    /// Arcs grouped by tail.
    start: Vec<u32>,
    order: Vec<u32>,
    level: Vec<u32>,
    next: Vec<u32>,
}

const UNSEEN: u32 = u32::MAX;

impl CutGraph {
    /// For every node whether it is on the source's side of the minimum cut nearest to the source.
    pub fn min_cut(&self) -> Vec<bool> {
        let mut residual = Residual::new(self);
        let (source, sink) = (self.source.len() as u32, self.source.len() as u32 + 1);
        while residual.levels(source, sink) {
            residual.block(source, sink);
        }
        residual.level[..self.source.len()].iter().map(|&l| l != UNSEEN).collect()
    }
}

impl Residual {
    fn new(graph: &CutGraph) -> Self {
        let n = graph.source.len() as u32;
        let (mut tail, mut head, mut room) = (Vec::new(), Vec::new(), Vec::new());
        let mut add = |a: u32, b: u32, there: i64, back: i64| {
            tail.extend([a, b]);
            head.extend([b, a]);
            room.extend([there, back]);
        };
        graph.edges.iter().for_each(|e| add(e.ends[0], e.ends[1], e.capacity, e.capacity));
        graph.source.iter().enumerate().filter(|(_, c)| **c > 0).for_each(|(v, &c)| add(n, v as u32, c, 0));
        graph.sink.iter().enumerate().filter(|(_, c)| **c > 0).for_each(|(v, &c)| add(v as u32, n + 1, c, 0));
        let mut start = vec![0u32; n as usize + 3];
        tail.iter().for_each(|&t| start[t as usize + 1] += 1);
        (1..start.len()).for_each(|k| start[k] += start[k - 1]);
        let (mut fill, mut order) = (start.clone(), vec![0u32; tail.len()]);
        for (arc, &t) in tail.iter().enumerate() {
            order[fill[t as usize] as usize] = arc as u32;
            fill[t as usize] += 1;
        }
        let nodes = n as usize + 2;
        Residual { head, room, start, order, level: vec![UNSEEN; nodes], next: vec![0; nodes] }
    }

    /// Distances from the source over arcs with room; whether the sink is reached.
    fn levels(&mut self, source: u32, sink: u32) -> bool {
        self.level.fill(UNSEEN);
        self.level[source as usize] = 0;
        let mut queue = vec![source];
        let mut at = 0;
        while at < queue.len() {
            let v = queue[at];
            at += 1;
            for k in self.start[v as usize]..self.start[v as usize + 1] {
                let arc = self.order[k as usize] as usize;
                let to = self.head[arc];
                if self.room[arc] > 0 && self.level[to as usize] == UNSEEN {
                    self.level[to as usize] = self.level[v as usize] + 1;
                    queue.push(to);
                }
            }
        }
        self.level[sink as usize] != UNSEEN
    }

    /// A blocking flow: augments along level-increasing paths until there is none.
    fn block(&mut self, source: u32, sink: u32) {
        self.next.copy_from_slice(&self.start[..self.level.len()]);
        let mut path: Vec<u32> = Vec::new();
        let mut v = source;
        loop {
            if v == sink {
                let least = path.iter().map(|&arc| self.room[arc as usize]).min().unwrap_or(0);
                let mut back = 0;
                for (k, &arc) in path.iter().enumerate().rev() {
                    self.room[arc as usize] -= least;
                    self.room[arc as usize ^ 1] += least;
                    if self.room[arc as usize] == 0 {
                        back = k;
                    }
                }
                // Go on from the tail of the first arc that is full now.
                v = self.head[path[back] as usize ^ 1];
                path.truncate(back);
                continue;
            }
            let onward = (self.next[v as usize]..self.start[v as usize + 1]).find(|&k| {
                let arc = self.order[k as usize] as usize;
                self.room[arc] > 0 && self.level[self.head[arc] as usize] == self.level[v as usize] + 1
            });
            match onward {
                Some(k) => {
                    self.next[v as usize] = k;
                    let arc = self.order[k as usize];
                    path.push(arc);
                    v = self.head[arc as usize];
                }
                None => {
                    // A dead end for the rest of this phase.
                    self.next[v as usize] = self.start[v as usize + 1];
                    let Some(arc) = path.pop() else { return };
                    v = self.head[arc as usize ^ 1];
                    self.next[v as usize] += 1;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Capacity of the cut that separates these nodes from the sink's side.
    fn cost(graph: &CutGraph, source_side: &[bool]) -> i64 {
        let across = graph.edges.iter().filter(|e| source_side[e.ends[0] as usize] != source_side[e.ends[1] as usize]);
        let terminals = (0..source_side.len()).map(|v| if source_side[v] { graph.sink[v] } else { graph.source[v] });
        across.map(|e| e.capacity).sum::<i64>() + terminals.sum::<i64>()
    }

    fn graphs() -> impl Strategy<Value = CutGraph> {
        (2usize..9).prop_flat_map(|n| {
            let edge =
                (0..n as u32, 0..n as u32, 0i64..20).prop_map(|(a, b, capacity)| Edge { ends: [a, b], capacity });
            let terminal = || prop::collection::vec(prop_oneof![Just(0i64), 0i64..30], n);
            (prop::collection::vec(edge, 0..20), terminal(), terminal()).prop_map(|(edges, source, sink)| CutGraph {
                edges,
                source,
                sink,
            })
        })
    }

    proptest! {
        #[test]
        fn the_cut_is_the_least_of_all_and_the_nearest_to_the_source(graph in graphs()) {
            let n = graph.source.len();
            let sides = |mask: usize| (0..n).map(|v| mask >> v & 1 == 1).collect::<Vec<bool>>();
            let least = (0..1 << n).map(|mask| cost(&graph, &sides(mask))).min().unwrap();
            let cut = graph.min_cut();
            prop_assert_eq!(cost(&graph, &cut), least);
            for mask in 0..1 << n {
                let other = sides(mask);
                if cost(&graph, &other) == least {
                    prop_assert!((0..n).all(|v| !cut[v] || other[v]), "{:?} {:?}", cut, other);
                }
            }
        }
    }

    #[test]
    fn an_empty_graph_has_an_empty_cut() {
        assert!(CutGraph::default().min_cut().is_empty());
    }
}
