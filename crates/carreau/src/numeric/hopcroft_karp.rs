//! Bipartite graphs: maximum matching, minimum vertex cover, maximum independent set.
//!
//! The matching is that of Hopcroft and Karp (SIAM J. Comput. 2, 1973): each phase finds the length of a shortest
//! augmenting path by breadth-first layers and then augments along a maximal set of such paths; O(√V) phases of O(E).
//! König's theorem turns it into a minimum vertex cover: with Z the vertices that alternating paths reach from the
//! unmatched left vertices, the cover is (left ∖ Z) ∪ (right ∩ Z). What is not in the cover is a maximum independent set.
//!
//! The result depends only on the numbering of the vertices and on the order of the edges.

/// No mate; not reached.
const NO_NODE: u32 = u32::MAX;

/// A bipartite graph.
pub struct Bipartite {
    /// Start of the neighbours of each left vertex, and their end.
    offsets: Vec<u32>,
    neighbours: Vec<u32>,
    rights: u32,
}

/// One flag for each left and each right vertex.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Subset {
    /// Flags of the left vertices.
    pub left: Vec<bool>,
    /// Flags of the right vertices.
    pub right: Vec<bool>,
}

/// A set of edges without common ends.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Matching {
    left_mates: Vec<u32>,
    right_mates: Vec<u32>,
}

#[cfg(test)]
impl Matching {
    /// The edges (left, right), by left vertex.
    pub fn edges(&self) -> impl Iterator<Item = (u32, u32)> + '_ {
        (0..).zip(self.left_mates.iter().copied()).filter(|&(_, right)| right != NO_NODE)
    }
}

impl Bipartite {
    /// The graph with these (left, right) edges. Their ends must be below `lefts` and `rights`.
    pub fn new(lefts: u32, rights: u32, edges: &[(u32, u32)]) -> Self {
        debug_assert!(edges.iter().all(|&(l, r)| l < lefts && r < rights));
        let mut offsets = vec![0; lefts as usize + 1];
        for &(left, _) in edges {
            offsets[left as usize + 1] += 1;
        }
        for left in 0..lefts as usize {
            offsets[left + 1] += offsets[left];
        }
        let (mut free, mut neighbours) = (offsets.clone(), vec![0; edges.len()]);
        for &(left, right) in edges {
            neighbours[free[left as usize] as usize] = right;
            free[left as usize] += 1;
        }
        Self { offsets, neighbours, rights }
    }

    fn lefts(&self) -> usize {
        self.offsets.len() - 1
    }

    fn neighbours(&self, left: u32) -> &[u32] {
        &self.neighbours[self.offsets[left as usize] as usize..self.offsets[left as usize + 1] as usize]
    }

    /// A matching with as many edges as possible.
    pub fn maximum_matching(&self) -> Matching {
        let unmatched =
            Matching { left_mates: vec![NO_NODE; self.lefts()], right_mates: vec![NO_NODE; self.rights as usize] };
        let mut search = Augmentation {
            graph: self,
            matching: unmatched,
            layer: vec![NO_NODE; self.lefts()],
            tried: vec![0; self.lefts()],
            queue: Vec::new(),
            path: Vec::new(),
        };
        while search.find_layers() {
            search.augment();
        }
        search.matching
    }

    /// A smallest set of vertices that has an end of every edge.
    pub fn minimum_cover(&self) -> Subset {
        let matching = self.maximum_matching();
        let reached = self.reached(&matching);
        // A right vertex in Z is matched, or else there would be an augmenting path, and Z goes on to its mate.
        let in_z = |&mate: &u32| mate != NO_NODE && reached[mate as usize];
        Subset {
            right: matching.right_mates.iter().map(in_z).collect(),
            left: reached.iter().map(|&in_z| !in_z).collect(),
        }
    }

    /// A largest set of vertices without an edge between them.
    pub fn maximum_independent_set(&self) -> Subset {
        let mut set = self.minimum_cover();
        set.left.iter_mut().chain(&mut set.right).for_each(|flag| *flag = !*flag);
        set
    }

    /// The left vertices that alternating paths reach from the unmatched left vertices.
    fn reached(&self, matching: &Matching) -> Vec<bool> {
        let mut reached: Vec<bool> = matching.left_mates.iter().map(|&mate| mate == NO_NODE).collect();
        let mut stack: Vec<u32> = (0..).zip(&reached).filter(|&(_, &start)| start).map(|(left, _)| left).collect();
        while let Some(left) = stack.pop() {
            for &right in self.neighbours(left) {
                let mate = matching.right_mates[right as usize];
                if mate != NO_NODE && !std::mem::replace(&mut reached[mate as usize], true) {
                    stack.push(mate);
                }
            }
        }
        reached
    }
}

/// The state of the search for a maximum matching.
struct Augmentation<'a> {
    graph: &'a Bipartite,
    matching: Matching,
    /// Number of matched edges on a shortest alternating path from an unmatched left vertex.
    layer: Vec<u32>,
    /// How many neighbours of each left vertex this phase has tried.
    tried: Vec<u32>,
    queue: Vec<u32>,
    /// The left vertices of the alternating path under construction.
    path: Vec<u32>,
}

impl Augmentation<'_> {
    /// Computes the layers as far as the nearest unmatched right vertex; false if none can be reached.
    fn find_layers(&mut self) -> bool {
        self.layer.fill(NO_NODE);
        self.queue.clear();
        for (left, &mate) in (0..).zip(&self.matching.left_mates) {
            if mate == NO_NODE {
                self.layer[left as usize] = 0;
                self.queue.push(left);
            }
        }
        let (mut at, mut last_layer) = (0, NO_NODE);
        while at < self.queue.len() {
            let left = self.queue[at];
            let layer = self.layer[left as usize];
            if layer >= last_layer {
                break;
            }
            at += 1;
            for &right in self.graph.neighbours(left) {
                let mate = self.matching.right_mates[right as usize];
                if mate == NO_NODE {
                    last_layer = layer + 1;
                } else if self.layer[mate as usize] == NO_NODE {
                    self.layer[mate as usize] = layer + 1;
                    self.queue.push(mate);
                }
            }
        }
        last_layer != NO_NODE
    }

    /// Augments along shortest paths until the layers hold no more.
    fn augment(&mut self) {
        self.tried.fill(0);
        for root in 0..self.graph.lefts() as u32 {
            if self.matching.left_mates[root as usize] == NO_NODE && self.find_path(root) {
                self.flip_path();
            }
        }
    }

    /// Finds a path through the layers to an unmatched right vertex; each left vertex on it was left by the neighbour
    /// that it tried last.
    fn find_path(&mut self, root: u32) -> bool {
        self.path.clear();
        self.path.push(root);
        while let Some(&left) = self.path.last() {
            let Some(&right) = self.graph.neighbours(left).get(self.tried[left as usize] as usize) else {
                self.path.pop();
                continue;
            };
            self.tried[left as usize] += 1;
            let mate = self.matching.right_mates[right as usize];
            if mate == NO_NODE {
                return true;
            }
            if self.layer[mate as usize] == self.layer[left as usize] + 1 {
                self.path.push(mate);
            }
        }
        false
    }

    fn flip_path(&mut self) {
        for &left in &self.path {
            let right = self.graph.neighbours(left)[self.tried[left as usize] as usize - 1];
            self.matching.left_mates[left as usize] = right;
            self.matching.right_mates[right as usize] = left;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Size of a maximum matching by one augmenting path at a time.
    fn matching_number(lefts: u32, rights: u32, edges: &[(u32, u32)]) -> usize {
        fn augment(left: u32, edges: &[(u32, u32)], seen: &mut [bool], mates: &mut [u32]) -> bool {
            for &(_, right) in edges.iter().filter(|e| e.0 == left) {
                let mate = mates[right as usize];
                if !std::mem::replace(&mut seen[right as usize], true)
                    && (mate == NO_NODE || augment(mate, edges, seen, mates))
                {
                    mates[right as usize] = left;
                    return true;
                }
            }
            false
        }
        let mut mates = vec![NO_NODE; rights as usize];
        (0..lefts).filter(|&left| augment(left, edges, &mut vec![false; rights as usize], &mut mates)).count()
    }

    fn size(subset: &Subset) -> usize {
        subset.left.iter().chain(&subset.right).filter(|&&flag| flag).count()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]
        #[test]
        fn matching_cover_and_independent_set_certify_each_other(
            lefts in 1u32..12,
            rights in 1u32..12,
            edges in prop::collection::vec((0u32..12, 0u32..12), 0..50),
        ) {
            let edges: Vec<_> = edges.into_iter().map(|(l, r)| (l % lefts, r % rights)).collect();
            let graph = Bipartite::new(lefts, rights, &edges);
            let matching: Vec<_> = graph.maximum_matching().edges().collect();
            for (i, &(l, r)) in matching.iter().enumerate() {
                prop_assert!(edges.contains(&(l, r)));
                prop_assert!(matching[..i].iter().all(|&(l2, r2)| l != l2 && r != r2));
            }
            prop_assert_eq!(matching.len(), matching_number(lefts, rights, &edges));

            let cover = graph.minimum_cover();
            prop_assert!(edges.iter().all(|&(l, r)| cover.left[l as usize] || cover.right[r as usize]));
            prop_assert_eq!(size(&cover), matching.len());

            let set = graph.maximum_independent_set();
            prop_assert!(!edges.iter().any(|&(l, r)| set.left[l as usize] && set.right[r as usize]));
            prop_assert_eq!(size(&set), (lefts + rights) as usize - matching.len());
        }
    }

    /// Path 0-0-1-1-2-2-…, its edges given so that the first choice is always the wrong one: the last augmenting path
    /// has all vertices. Recursion would overflow the stack.
    #[test]
    fn long_augmenting_paths() {
        let n = 200_000;
        let mut edges: Vec<(u32, u32)> = (1..n).map(|i| (i, i - 1)).collect();
        edges.extend((0..n).map(|i| (i, i)));
        let graph = Bipartite::new(n, n, &edges);
        assert_eq!(graph.maximum_matching().edges().count(), n as usize);
    }

    #[test]
    fn empty_graphs() {
        assert_eq!(Bipartite::new(0, 0, &[]).maximum_matching().edges().count(), 0);
        let set = Bipartite::new(2, 3, &[]).maximum_independent_set();
        assert_eq!(size(&set), 5);
    }
}
