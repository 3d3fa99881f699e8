//! What happens to odd circles of a tree: they shrink to blossoms, which are opened again.

use super::event::Event;
use super::family::{Label, Set};
use super::graph::{Dart, NONE};
use super::search::TreeSearch;

impl<'a> TreeSearch<'a> {
    /// A tight edge between two outer sets closes an odd cycle: shrinks it.
    ///
    /// ```text
    ///            base                 A cycle goes one way round: up the tree from `tail` to `base`, where the darts
    ///         ↗        ↘              are those of the tree, down to `head`, where they are reversed, and back
    ///      inner      inner           over the edge.
    ///        ⇑          ⇓
    ///      tail  ←───  head
    /// ```
    pub(super) fn shrink(&mut self, dart: Dart, tail: u32, head: u32) {
        self.counts.shrunk += 1;
        let base = self.common_ancestor(tail, head);
        let mut set = tail;
        while set != base {
            let inner = self.chain(set, self.family[set].mate);
            set = self.chain(inner, self.family[inner].up);
        }
        let mut set = head;
        while set != base {
            let inner = self.chain_back(set, self.family[set].mate);
            set = self.chain_back(inner, self.family[inner].up);
        }
        self.chain(head, dart ^ 1);

        let mut inner = std::mem::take(&mut self.sets);
        inner.extend(self.family.cycle(base).filter(|&set| self.family[set].label == Label::Inner));
        let mut set = base;
        loop {
            self.family.set_label(set, Label::Resting, self.now);
            set = self.family[set].next;
            if set == base {
                break;
            }
        }
        let blossom = self.family.close(base);
        self.family.set_label(blossom, Label::Outer, self.now);
        self.tree.push(blossom);
        for part in inner.drain(..) {
            self.watch_outer(part);
        }
        self.sets = inner;
    }

    /// Puts the set beyond a dart behind `set` in a cycle, and returns it.
    fn chain(&mut self, set: u32, dart: Dart) -> u32 {
        let next = self.beyond(dart);
        self.family[set].next = next;
        self.family[set].link = dart;
        next
    }

    /// Puts the set beyond a dart before `set` in a cycle, and returns it.
    fn chain_back(&mut self, set: u32, dart: Dart) -> u32 {
        let before = self.beyond(dart);
        self.family[before].next = set;
        self.family[before].link = dart ^ 1;
        before
    }

    /// The first outer set that is on the ways of two outer sets to the root. Walks both ways by turns, so the work
    /// depends on the length of the cycle and not on the height of the tree.
    fn common_ancestor(&mut self, a: u32, b: u32) -> u32 {
        let mut marked = std::mem::take(&mut self.sets);
        let mut ways = [a, b];
        let ancestor = loop {
            let [set, other] = ways;
            if set != NONE {
                if self.family[set].marked {
                    break set;
                }
                self.family[set].marked = true;
                marked.push(set);
            }
            ways = [other, if set == NONE { NONE } else { self.outer_above(set) }];
        };
        for set in marked.drain(..) {
            self.family[set].marked = false;
        }
        self.sets = marked;
        ancestor
    }

    /// The next outer set towards the root, [`NONE`] for the root.
    fn outer_above(&self, set: u32) -> u32 {
        match self.family[set].mate {
            NONE => NONE,
            mate => self.beyond(self.family[self.beyond(mate)].up),
        }
    }

    /// Replaces an inner blossom with dual 0 by its children. Of the two ways round its cycle, from the child that the
    /// tree enters to the child that it leaves from, the one with an even number of edges stays in the tree; the
    /// children on the other are matched in pairs and rest.
    ///
    /// ```text
    ///                    up
    ///                     │                first, last: inner       a: outer
    ///     b ════ c ──── first              b, c: resting
    ///     │               ║
    ///   last ───────────  a                (the path may have length 0, first = last)
    ///     ║
    ///    mate
    /// ```
    pub(super) fn expand(&mut self, blossom: u32) {
        self.counts.expanded += 1;
        let Set { up, mate, .. } = self.family[blossom];
        self.family.set_label(blossom, Label::Resting, self.now);
        self.family.open(blossom);
        let first = self.family.around(self.graph.tail(up));
        let last = self.family.around(self.graph.tail(mate));
        let ahead = self.family.cycle(first).take_while(|&set| set != last).count();
        let (start, finish) = if ahead % 2 == 0 { (first, last) } else { (last, first) };

        let rest = self.family[finish].next;
        self.family.pair_up(rest, start);
        if start == first {
            self.lead_down(start, finish);
        } else {
            self.lead_up(start, finish);
        }
        self.family[first].up = up;
        self.family[last].mate = mate;

        let mut sets = std::mem::take(&mut self.sets);
        sets.extend(self.family.cycle(rest).take_while(|&set| set != start));
        for set in sets.drain(..) {
            let nearest = self.family[set].nearest;
            if nearest != NONE {
                self.queue(self.now + self.slack(nearest), Event::Tight(nearest));
            }
        }
        sets.extend(self.family.cycle(start).take_while(|&set| set != finish));
        sets.push(finish);
        for &inner in sets.iter().step_by(2) {
            self.join_as_inner(inner);
        }
        for &outer in sets.iter().skip(1).step_by(2) {
            self.join_as_outer(outer);
        }
        sets.clear();
        self.sets = sets;
    }

    /// Makes a piece of a cycle with an even number of edges a path of the tree that leads away from the root.
    fn lead_down(&mut self, start: u32, finish: u32) {
        self.family.pair_up(start, finish);
        let mut inner = start;
        while inner != finish {
            let outer = self.family[inner].next;
            let Set { next, link, .. } = self.family[outer];
            self.family[next].up = link ^ 1;
            inner = next;
        }
    }

    /// Makes a piece of a cycle with an even number of edges a path of the tree that leads towards the root.
    fn lead_up(&mut self, start: u32, finish: u32) {
        let mut inner = start;
        while inner != finish {
            let Set { next: outer, link: up, .. } = self.family[inner];
            let Set { next, link: mate, .. } = self.family[outer];
            self.family[inner].up = up;
            self.family[outer].mate = mate;
            self.family[next].mate = mate ^ 1;
            inner = next;
        }
    }

    /// Exchanges matched and other edges from the end of an exposing dart up to the root.
    pub(super) fn augment(&mut self, end: Dart) {
        self.counts.augmented += 1;
        if !self.graph.is_exposed(end) {
            let exposed = self.beyond(end);
            self.family[exposed].mate = end ^ 1;
        }
        let mut outer = self.family.around(self.graph.tail(end));
        let mut dart = end;
        loop {
            let old = std::mem::replace(&mut self.family[outer].mate, dart);
            if old == NONE {
                break;
            }
            let inner = self.beyond(old);
            let up = self.family[inner].up;
            self.family[inner].mate = up;
            outer = self.beyond(up);
            dart = up ^ 1;
        }
    }

    /// Takes all labels away; the duals stay as they are now.
    pub(super) fn dismantle(&mut self) {
        self.events.clear();
        self.queued = 0;
        while let Some(set) = self.approached.pop() {
            self.family[set].nearest = NONE;
        }
        while let Some(set) = self.tree.pop() {
            if self.family[set].label != Label::Resting {
                self.family.set_label(set, Label::Resting, self.now);
            }
        }
    }
}
