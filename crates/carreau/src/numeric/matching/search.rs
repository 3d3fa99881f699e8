//! The search for one augmenting path: an alternating tree that grows from an unmatched node in its own time.
//!
//! Time is the amount by which the root's dual was raised. Duals of outer sets grow with it, those of inner sets
//! shrink, all others rest, so that tree edges stay tight. What happens next is read from a queue of events:
//!
//! ```text
//!   outer ── resting ══ its mate     the edge becomes tight: both join the tree, as inner and outer     (grow)
//!   outer ── outer                   the edge becomes tight: the cycle through the tree is a blossom    (shrink)
//!   inner blossom, dual 0            its children take its place                                        (expand)
//!   outer ── exposed                 the path from the root ends here                                   (augment)
//!   outer ── boundary                likewise: the node at the end is left unmatched                    (augment)
//! ```
//!
//! Entries of the queue are not withdrawn: one that is out of date is told by the edge not being tight. An augmenting
//! end once found cannot get lost, so the earliest is kept aside, and events after it are not even queued. This is
//! what keeps a tree small.
//!
//! An inner blossom may be expanded and some of its children leave the tree, at any depth, and to scan them for edges
//! to outer sets each time would take quadratic time. So all sets that a tree comes close to, nested ones too, know
//! the nearest edge from an outer set. As outer sets stay outer, and the nodes of a set move together as long as the
//! set exists, the nearest edge can only be replaced by one that is found later.

use super::event::Event;
use super::family::{Family, Label};
use super::graph::{Dart, Graph, NONE};
use crate::context::Context;
use crate::error::Result;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// What all searches together have done.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Counts {
    pub(super) events: usize,
    pub(super) grown: usize,
    pub(super) shrunk: usize,
    pub(super) expanded: usize,
    pub(super) augmented: usize,
    pub(super) cut_off: usize,
}

/// The matching found so far and the tree that grows in it.
pub(super) struct TreeSearch<'a> {
    pub(super) graph: &'a Graph<'a>,
    pub(super) family: Family,
    pub(super) counts: Counts,
    pub(super) now: i64,
    /// When and with which dart the search will end at the latest.
    pub(super) end: (i64, Dart),
    /// What may happen, with the time and the number of the entry: first come, first served, so that a tree among equal
    /// costs grows in all directions alike.
    pub(super) events: BinaryHeap<Reverse<(i64, u32, Event)>>,
    pub(super) queued: u32,
    /// All sets with a `nearest` dart.
    pub(super) approached: Vec<u32>,
    /// All sets that were given a label.
    pub(super) tree: Vec<u32>,
    /// Buffers.
    stack: Vec<u32>,
    nodes: Vec<u32>,
    pub(super) sets: Vec<u32>,
}

impl<'a> TreeSearch<'a> {
    pub(super) fn new(graph: &'a Graph<'a>, family: Family) -> Self {
        TreeSearch {
            graph,
            family,
            counts: Counts::default(),
            now: 0,
            end: (i64::MAX, NONE),
            events: BinaryHeap::new(),
            queued: 0,
            approached: Vec::new(),
            tree: Vec::new(),
            stack: Vec::new(),
            nodes: Vec::new(),
            sets: Vec::new(),
        }
    }

    /// Grows a tree from an outermost set without a mate until it can be augmented, and augments it. Returns `false`
    /// if the tree got more than `limit` sets before: then the matching is as it was, but the duals have made progress.
    pub(super) fn augment_from(&mut self, root: u32, limit: usize, context: &Context) -> Result<bool> {
        self.now = 0;
        self.end = (i64::MAX, NONE);
        self.join_as_outer(root);
        while let Some(Reverse((time, _, event))) = self.events.pop() {
            if time >= self.end.0 {
                break;
            }
            self.now = time;
            if self.tree.len() > limit {
                self.counts.cut_off += 1;
                self.dismantle();
                return Ok(false);
            }
            self.counts.events += 1;
            context.check_every(self.counts.events)?;
            match event {
                Event::Tight(dart) => self.edge_tight(dart),
                Event::Zero(blossom) => self.dual_zero(blossom),
            }
        }
        self.now = self.end.0;
        self.augment(self.end.1);
        self.dismantle();
        Ok(true)
    }

    /// If the slack is not 0, or the head is inner, then the head was inner when its set should have been reached. The
    /// edge was queued again when that set left the tree or became outer.
    fn edge_tight(&mut self, dart: Dart) {
        let (tail, _, near) = self.family.look_up(self.graph.tail(dart), self.now);
        let (head, label, far) = self.family.look_up(self.graph.head(dart), self.now);
        if head == tail || near + far < self.graph.cost(dart) {
            return;
        }
        match label {
            Label::Inner => {}
            Label::Resting => self.grow(dart, head),
            Label::Outer => self.shrink(dart, tail, head),
        }
    }

    fn dual_zero(&mut self, blossom: u32) {
        let set = &self.family[blossom];
        if set.label == Label::Inner && set.dual == self.now - set.since {
            self.expand(blossom);
        }
    }

    /// A resting set and its mate join the tree.
    fn grow(&mut self, dart: Dart, inner: u32) {
        self.counts.grown += 1;
        self.family[inner].up = dart ^ 1;
        self.join_as_inner(inner);
        let outer = self.beyond(self.family[inner].mate);
        self.join_as_outer(outer);
    }

    /// The set at the other end of a dart.
    pub(super) fn beyond(&self, dart: Dart) -> u32 {
        self.family.around(self.graph.head(dart))
    }

    pub(super) fn join_as_inner(&mut self, set: u32) {
        self.family.set_label(set, Label::Inner, self.now);
        self.tree.push(set);
        if self.family[set].child != NONE {
            self.queue(self.now + self.family[set].dual, Event::Zero(set));
        }
    }

    pub(super) fn join_as_outer(&mut self, set: u32) {
        self.family.set_label(set, Label::Outer, self.now);
        self.tree.push(set);
        self.watch_outer(set);
    }

    pub(super) fn queue(&mut self, time: i64, event: Event) {
        if time < self.end.0 {
            self.events.push(Reverse((time, self.queued, event)));
            self.queued = self.queued.wrapping_add(1);
        }
    }

    fn end_by(&mut self, time: i64, dart: Dart) {
        if time < self.end.0 {
            self.end = (time, dart);
        }
    }

    /// Queues what can happen to the nodes of `part`, an outer set or a part of one that just became outer.
    pub(super) fn watch_outer(&mut self, part: u32) {
        let mut nodes = std::mem::take(&mut self.nodes);
        self.family.nodes(part, &mut self.stack, &mut nodes);
        for &node in &nodes {
            let (set, _, radius) = self.family.look_up(node, self.now);
            self.end_by(self.now + self.graph.unmatched(node) - radius, self.graph.boundary(node));
            for &dart in self.graph.leaving(node) {
                let (other, label, far) = self.family.look_up(self.graph.head(dart), self.now);
                let slack = self.graph.cost(dart) - radius - far;
                match label {
                    Label::Outer if other == set => {}
                    // Both ends move. All nodes of a tree have radii of the same parity, so the slack is even.
                    Label::Outer => self.queue(self.now + slack / 2, Event::Tight(dart)),
                    Label::Resting if self.graph.is_exposed(self.family[other].mate) => {
                        self.end_by(self.now + slack, dart);
                    }
                    Label::Resting | Label::Inner => self.approach(dart, slack),
                }
            }
        }
        self.nodes = nodes;
    }

    /// Remembers a dart that leads from an outer set to another set that is not outer: for the node at its head, and
    /// for all sets around that node to which it is the nearest way so far.
    fn approach(&mut self, dart: Dart, slack: i64) {
        let mut set = self.graph.head(dart);
        loop {
            let nearest = self.family[set].nearest;
            if nearest == NONE {
                self.approached.push(set);
            } else if self.slack(nearest) <= slack {
                return;
            }
            self.family[set].nearest = dart;
            match self.family[set].parent {
                NONE => break,
                parent => set = parent,
            }
        }
        if self.family[set].label == Label::Resting {
            self.queue(self.now + slack, Event::Tight(dart));
        }
    }

    /// The slack of an edge between two outermost sets.
    pub(super) fn slack(&self, dart: Dart) -> i64 {
        let (_, _, near) = self.family.look_up(self.graph.tail(dart), self.now);
        let (_, _, far) = self.family.look_up(self.graph.head(dart), self.now);
        self.graph.cost(dart) - near - far
    }
}
