//! The laminar family: nodes of the graph and the blossoms they are shrunk into, with their dual variables.
//!
//! A *set* is a node of the graph (ids below the number of nodes) or a blossom. A blossom is an odd cycle of sets, each
//! joined to the next by a tight edge. Sets that lie in no other set are *outermost*; the search sees only those.
//!
//! The *radius* of a node is the sum of the duals of all sets that contain it, so the slack of an edge `(u, v)` between
//! different outermost sets is `2 cost − radius(u) − radius(v)`. Radii are kept relative in a union–find forest over
//! the nodes: a node's radius is the sum of the offsets on its way to the root, and raising the dual of an outermost
//! set changes one number. Linking is by size and paths are not compressed, so that a blossom can be opened again by
//! cutting the links that closed it; a look-up takes O(log n), and nothing is ever relabelled.
//!
//! How a blossom is matched inside follows from the one dart that leaves it: the child at the tail of that dart takes
//! it, the others are matched in pairs along the cycle. It is worked out only when the blossom is opened.

use super::graph::{Dart, Graph, NONE};

/// What the search thinks of an outermost set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Label {
    /// Not in the tree; its dual rests.
    Resting,
    /// In the tree at an even distance from the root; its dual grows with time.
    Outer,
    /// In the tree at an odd distance from the root; its dual shrinks with time.
    Inner,
}

/// A node of the graph or a blossom.
#[derive(Clone)]
pub(super) struct Set {
    /// Dual variable at time `since`; not negative for a blossom.
    pub(super) dual: i64,
    /// When the label was given.
    pub(super) since: i64,
    /// Meaningful for an outermost set.
    pub(super) label: Label,
    /// Used while the cycle of a new blossom is looked for.
    pub(super) marked: bool,
    /// The matched dart that leaves this set, [`NONE`] where none was chosen yet. Meaningful for an outermost set.
    pub(super) mate: Dart,
    /// The dart of the tree towards the root. Meaningful for an inner set.
    pub(super) up: Dart,
    /// The dart with the least slack that leads here from an outer set, [`NONE`] where none was found yet. Meaningful
    /// for a set that is not outer, nor in an outer one.
    pub(super) nearest: Dart,
    /// The blossom around, [`NONE`] for an outermost set.
    pub(super) parent: u32,
    /// The next set in the cycle of the blossom around.
    pub(super) next: u32,
    /// The dart from this set to `next`.
    pub(super) link: Dart,
    /// Any child of a blossom, [`NONE`] for a node of the graph.
    pub(super) child: u32,
    /// The root of this set's nodes in the union–find forest, as long as the set is outermost.
    root: u32,
    /// Number of nodes.
    size: u32,
}

/// A node in the union–find forest.
#[derive(Clone)]
struct Member {
    /// The radius relative to the one above; for a root the radius itself, but for the time since the last label.
    offset: i64,
    /// The node above; a root is above itself.
    above: u32,
    /// The outermost set. Meaningful for a root.
    set: u32,
}

/// All sets, nested.
pub(super) struct Family {
    sets: Vec<Set>,
    members: Vec<Member>,
    /// Blossoms that were opened: their ids are used again.
    opened: Vec<u32>,
}

impl std::ops::Index<u32> for Family {
    type Output = Set;
    #[inline]
    fn index(&self, set: u32) -> &Set {
        &self.sets[set as usize]
    }
}

impl std::ops::IndexMut<u32> for Family {
    #[inline]
    fn index_mut(&mut self, set: u32) -> &mut Set {
        &mut self.sets[set as usize]
    }
}

impl Family {
    /// Every node on its own, with these duals and matched darts.
    pub(super) fn new(duals: &[i64], mates: &[Dart]) -> Self {
        let set = |(v, (&dual, &mate)): (u32, (&i64, &Dart))| Set {
            dual,
            since: 0,
            label: Label::Resting,
            marked: false,
            mate,
            up: NONE,
            nearest: NONE,
            parent: NONE,
            next: NONE,
            link: NONE,
            child: NONE,
            root: v,
            size: 1,
        };
        Family {
            sets: (0..).zip(duals.iter().zip(mates)).map(set).collect(),
            members: (0..).zip(duals).map(|(v, &offset)| Member { offset, above: v, set: v }).collect(),
            opened: Vec::new(),
        }
    }

    /// The outermost set around a node.
    #[inline]
    pub(super) fn around(&self, node: u32) -> u32 {
        self.locate(node).0
    }

    /// The outermost set around a node, and the node's radius when that set got its label.
    #[inline]
    fn locate(&self, node: u32) -> (u32, i64) {
        let mut member = &self.members[node as usize];
        let mut radius = member.offset;
        let mut at = node;
        while member.above != at {
            at = member.above;
            member = &self.members[at as usize];
            radius += member.offset;
        }
        (member.set, radius)
    }

    /// The outermost set around a node, its label, and the node's radius now.
    #[inline]
    pub(super) fn look_up(&self, node: u32, now: i64) -> (u32, Label, i64) {
        let (at, radius) = self.locate(node);
        let set = &self[at];
        (at, set.label, radius + set.drift(now))
    }

    /// Gives an outermost set a label from now on.
    #[inline]
    pub(super) fn set_label(&mut self, set: u32, label: Label, now: i64) {
        let drift = self[set].drift(now);
        let root = self[set].root;
        self.members[root as usize].offset += drift;
        let set = &mut self[set];
        set.dual += drift;
        set.since = now;
        set.label = label;
    }

    /// Collects the nodes of a set into `nodes`.
    pub(super) fn nodes(&self, set: u32, stack: &mut Vec<u32>, nodes: &mut Vec<u32>) {
        nodes.clear();
        stack.push(set);
        while let Some(set) = stack.pop() {
            match self[set].child {
                NONE => nodes.push(set),
                child => stack.extend(self.cycle(child)),
            }
        }
    }

    /// The cycle that a set is in, from this set on.
    pub(super) fn cycle(&self, start: u32) -> impl Iterator<Item = u32> + '_ {
        std::iter::successors(Some(start), move |&set| Some(self[set].next).filter(|&next| next != start))
    }

    /// Shrinks the cycle that `base` is in into a blossom with dual 0, which takes over the mate of `base`. All sets of
    /// the cycle must be resting.
    pub(super) fn close(&mut self, base: u32) -> u32 {
        let blossom = self.opened.pop().unwrap_or(self.sets.len() as u32);
        let largest = self.cycle(base).max_by_key(|&set| self[set].size).unwrap_or(base);
        let root = self[largest].root;
        let size = self.cycle(base).map(|set| self[set].size).sum();
        let raised = self.members[root as usize].offset;
        let mut set = base;
        loop {
            self[set].parent = blossom;
            if set != largest {
                let member = &mut self.members[self.sets[set as usize].root as usize];
                member.above = root;
                member.offset -= raised;
            }
            set = self[set].next;
            if set == base {
                break;
            }
        }
        self.members[root as usize].set = blossom;
        let set = Set { dual: 0, nearest: NONE, parent: NONE, child: base, root, size, ..self[base].clone() };
        match self.sets.get_mut(blossom as usize) {
            Some(place) => *place = set,
            None => self.sets.push(set),
        }
        blossom
    }

    /// Undoes [`Family::close`]: the sets of the cycle become outermost and rest. How they are matched is up to the
    /// caller. The blossom must be resting.
    pub(super) fn open(&mut self, blossom: u32) {
        let Set { child: base, root, .. } = self[blossom];
        let raised = self.members[root as usize].offset;
        let mut set = base;
        loop {
            let child = &mut self.sets[set as usize];
            child.label = Label::Resting;
            child.parent = NONE;
            let member = &mut self.members[child.root as usize];
            if child.root != root {
                member.above = child.root;
                member.offset += raised;
            }
            member.set = set;
            set = child.next;
            if set == base {
                break;
            }
        }
        self.opened.push(blossom);
    }

    /// Matches the sets of a cycle from `from` up to, but without, `to` in pairs.
    pub(super) fn pair_up(&mut self, from: u32, to: u32) {
        let mut set = from;
        while set != to {
            let Set { next: partner, link, .. } = self[set];
            self[set].mate = link;
            self[partner].mate = link ^ 1;
            set = self[partner].next;
        }
    }

    /// Opens a blossom and matches its children as its mate asks for.
    pub(super) fn open_matched(&mut self, blossom: u32, graph: &Graph) {
        let mate = self[blossom].mate;
        self.open(blossom);
        let base = self.around(graph.tail(mate));
        self[base].mate = mate;
        self.pair_up(self[base].next, base);
    }
}

impl Set {
    /// By how much the dual has changed since the label was given.
    #[inline]
    fn drift(&self, now: i64) -> i64 {
        match self.label {
            Label::Resting => 0,
            Label::Outer => now - self.since,
            Label::Inner => self.since - now,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// What the family stands for, spelled out: the nodes of every outermost set, and every node's radius.
    struct Plain {
        outermost: Vec<(u32, Vec<u32>)>,
        radii: Vec<i64>,
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(400))]

        /// Labels, passing time, shrinking and opening in any order: look-ups agree with plain book-keeping.
        #[test]
        fn look_ups_agree_with_plain_book_keeping(
            duals in prop::collection::vec(-50i64..50, 3..30),
            actions in prop::collection::vec((0u8..4, any::<prop::sample::Index>(), 0i64..20), 1..80),
        ) {
            let mates = vec![NONE; duals.len()];
            let mut family = Family::new(&duals, &mates);
            let nodes = 0..duals.len() as u32;
            let mut plain = Plain { outermost: nodes.clone().map(|v| (v, vec![v])).collect(), radii: duals };
            let mut now = 0;
            for (action, pick, amount) in actions {
                let at = pick.index(plain.outermost.len());
                let set = plain.outermost[at].0;
                match action {
                    0 => {
                        for (set, nodes) in &plain.outermost {
                            let step = match family[*set].label {
                                Label::Resting => 0,
                                Label::Outer => amount,
                                Label::Inner => -amount,
                            };
                            nodes.iter().for_each(|&v| plain.radii[v as usize] += step);
                        }
                        now += amount;
                    }
                    1 => {
                        let label = [Label::Outer, Label::Inner, Label::Resting][amount as usize % 3];
                        family.set_label(set, label, now);
                    }
                    2 if plain.outermost.len() >= 3 => {
                        let cycle: Vec<_> = (0..3).map(|_| plain.outermost.remove(at % plain.outermost.len())).collect();
                        for k in 0..3 {
                            family.set_label(cycle[k].0, Label::Resting, now);
                            family[cycle[k].0].next = cycle[(k + 1) % 3].0;
                        }
                        let blossom = family.close(cycle[0].0);
                        plain.outermost.push((blossom, cycle.into_iter().flat_map(|(_, nodes)| nodes).collect()));
                    }
                    3 if family[set].child != NONE => {
                        family.set_label(set, Label::Resting, now);
                        let child = family[set].child;
                        family.open(set);
                        plain.outermost.remove(at);
                        let (mut stack, mut nodes) = (Vec::new(), Vec::new());
                        for set in family.cycle(child) {
                            family.nodes(set, &mut stack, &mut nodes);
                            plain.outermost.push((set, nodes.clone()));
                        }
                    }
                    _ => {}
                }
                for (set, nodes) in &plain.outermost {
                    for &v in nodes {
                        prop_assert_eq!(family.look_up(v, now), (*set, family[*set].label, plain.radii[v as usize]));
                    }
                }
                prop_assert_eq!(plain.outermost.iter().map(|(_, nodes)| nodes.len()).sum::<usize>(), nodes.len());
            }
        }
    }
}
