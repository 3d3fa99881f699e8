//! How many quads go along every arc.
//!
//! Every arc starts with its length over the wanted one. In a patch with a grid opposite sides have to add up to the same
//! number; around any other one the number has to be even. What a side has too many or too few is passed on along the
//! cheapest chain of arcs that ends where another patch is off, too, or at an open border. Where no chain exists, the grid with
//! most room on the ways that were looked at is given up: then it only has to be even, and chains may turn round in it.

use super::layout::{Kind, Layout, whole};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Numbers of quads stay between these shares of what their length asks for; the next where that does not do.
const LIMITS: [[f64; 2]; 3] = [[0.75, 1.4], [0.5, 2.0], [0.35, 3.0]];
/// The last ones, where there is no grid on the way that tapers more than this: opposite sides of the same number would make
/// the quads at one of them wide or narrow by that much.
const LOOSE: [f64; 2] = [0.2, 8.0];
const TAPER: f64 = 2.5;

/// Quads across a grid that a pattern fits into without being squeezed.
const ROOM: i64 = 3;

/// Grids that are given up one by one, each with new numbers for all; then as many as fail together.
const ONE_BY_ONE: usize = 32;

/// What the numbers along arcs have to fulfil.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Demand {
    /// One side of a grid less the opposite one is zero; so is what a strand has too many.
    Same,
    /// The number around is even.
    Even,
}

/// A condition with the patch that it comes from.
struct Condition {
    patch: usize,
    demand: Demand,
    /// Arcs with how often they count.
    arcs: Vec<(u32, i64)>,
    value: i64,
}

impl Condition {
    fn new(patch: usize, demand: Demand, arcs: impl Iterator<Item = (u32, i64)>) -> Self {
        let mut all: Vec<(u32, i64)> = arcs.collect();
        all.sort_unstable();
        let mut merged: Vec<(u32, i64)> = Vec::new();
        for (arc, times) in all {
            match merged.last_mut().filter(|last| last.0 == arc) {
                Some(last) => last.1 += times,
                None => merged.push((arc, times)),
            }
        }
        merged.retain(|m| if demand == Demand::Even { m.1 % 2 != 0 } else { m.1 != 0 });
        Condition { patch, demand, arcs: merged, value: 0 }
    }

    /// How far its value is from what it should be.
    fn off(&self) -> i64 {
        if self.demand == Demand::Even { self.value.rem_euclid(2) } else { self.value.abs() }
    }

    fn is_met(&self) -> bool {
        self.off() == 0
    }

    /// Whether a change of its value brings it nearer to what it should be; by two, where the change begins here, too.
    fn welcomes(&self, change: i64, is_start: bool) -> bool {
        match self.demand {
            Demand::Even => !is_start && !self.is_met(),
            Demand::Same => -self.value * change >= if is_start { 2 } else { 1 },
        }
    }
}

/// The conditions of a layout, and those that every arc is part of.
struct Conditions {
    list: Vec<Condition>,
    /// Number and share.
    of_arc: Vec<Vec<(u32, i64)>>,
}

impl Conditions {
    fn new(layout: &Layout) -> Self {
        let mut list = Vec::new();
        for (p, patch) in layout.patches.iter().enumerate() {
            if patch.kind == Kind::Grafted {
                continue;
            }
            if patch.kind == Kind::Grid {
                for k in 0..2 {
                    let side = |k: usize, times: i64| patch.sides[k].iter().map(move |s| (s.arc, times));
                    list.push(Condition::new(p, Demand::Same, side(k, 1).chain(side(k + 2, -1))));
                }
            } else {
                let all = patch.loops.iter();
                list.extend(all.map(|sides| Condition::new(p, Demand::Even, sides.iter().map(|s| (s.arc, 1)))));
            }
        }
        for strand in &layout.strands {
            let condition = Condition::new(strand.patch, Demand::Same, strand.arcs.iter().map(|a| (a.0, 1)));
            list.push(Condition { value: -strand.total, ..condition });
        }
        let mut of_arc = vec![Vec::new(); layout.arcs.len()];
        for (c, condition) in (0u32..).zip(&mut list) {
            for &(arc, times) in &condition.arcs {
                of_arc[arc as usize].push((c, times));
                condition.value += times * layout.arcs[arc as usize].count;
            }
        }
        Conditions { list, of_arc }
    }

    fn change(&mut self, arc: u32, by: i64) {
        for &(c, times) in &self.of_arc[arc as usize] {
            self.list[c as usize].value += times * by;
        }
    }
}

/// A state is a condition and the sign of the change of its value that is still owed.
type State = usize;

/// The bit of an arc; others share it.
fn bit(arc: u32) -> u64 {
    1 << (arc % u64::BITS)
}

/// What a search for a chain has found so far: kept between searches, so that each pays for the states it reaches only.
struct Search {
    cost: Vec<f64>,
    /// The state before, and the arc with its change that led from there.
    from: Vec<Option<(State, u32, i64)>>,
    /// A bit for some of all arcs: set for those of the steps that led there.
    passed: Vec<u64>,
    reached: Vec<State>,
    queue: BinaryHeap<Reverse<(u64, u32, i64)>>,
    /// All that were reached by searches before.
    steps: u64,
}

impl Search {
    fn new(conditions: usize) -> Self {
        let states = 2 * conditions;
        let (cost, from, passed) = (vec![f64::INFINITY; states], vec![None; states], vec![0; states]);
        Search { cost, from, passed, reached: Vec::new(), queue: BinaryHeap::new(), steps: 0 }
    }

    fn clear(&mut self) {
        self.steps += self.reached.len() as u64;
        for state in self.reached.drain(..) {
            self.cost[state] = f64::INFINITY;
            self.from[state] = None;
        }
        self.queue.clear();
    }

    fn reach(&mut self, state: State, cost: f64, from: Option<(State, u32, i64)>, (condition, owed): (u32, i64)) {
        self.cost[state] = cost;
        self.from[state] = from;
        self.passed[state] = from.map_or(0, |(before, arc, _)| self.passed[before] | bit(arc));
        self.reached.push(state);
        self.queue.push(Reverse((cost.to_bits(), condition, owed)));
    }

    /// What the steps that led to a state have changed an arc by.
    fn so_far(&self, mut at: State, arc: u32) -> i64 {
        if self.passed[at] & bit(arc) == 0 {
            return 0;
        }
        let mut sum = 0;
        while let Some((before, step, change)) = self.from[at] {
            sum += if step == arc { change } else { 0 };
            at = before;
        }
        sum
    }

    /// The steps that led to a state, and the last one.
    fn back(&self, mut at: State, last: (u32, i64)) -> Vec<(u32, i64)> {
        let mut chain = vec![last];
        while let Some((before, arc, change)) = self.from[at] {
            chain.push((arc, change));
            at = before;
        }
        chain
    }
}

impl Layout {
    /// Chooses the numbers of quads, of about a length. Patches that cannot add up lose their grid. Returns whether all
    /// that have none are even around.
    pub fn quantise(&mut self, length: f64) -> bool {
        self.length = length;
        let mut given_up = 0;
        loop {
            self.as_long(length);
            let most = if given_up < ONE_BY_ONE { 1 } else { usize::MAX };
            let mut failed = self.settle(length, most);
            if failed.is_empty() {
                return true;
            }
            failed.retain(|&patch| self.patches[patch].kind == Kind::Grid);
            if failed.is_empty() {
                return false;
            }
            given_up += failed.len();
            failed.into_iter().for_each(|patch| self.patches[patch].kind = Kind::Pattern);
        }
    }

    /// Numbers that arcs would have for themselves: every patch that gives its grid up sets its neighbours free.
    fn as_long(&mut self, length: f64) {
        for arc in &mut self.arcs {
            arc.room = 0;
            arc.count = whole(arc.ideal(length).round()).max(arc.least);
        }
        let without_grid = |p: &usize| !matches!(self.patches[*p].kind, Kind::Grid | Kind::Grafted);
        let without_grid: Vec<usize> = (0..self.patches.len()).filter(without_grid).collect();
        without_grid.into_iter().for_each(|p| self.make_room(p));
    }

    /// The same for twice the length, doubled: even everywhere.
    pub fn quantise_doubled(&mut self, length: f64) {
        let before: Vec<(i64, Option<f64>)> = self.arcs.iter().map(|arc| (arc.least, arc.given)).collect();
        for arc in &mut self.arcs {
            (arc.least, arc.given) = ((arc.least + 1) / 2, arc.given.map(|given| given / 2.0));
        }
        // Those of rung 3 are even.
        self.strands.iter_mut().for_each(|strand| strand.total /= 2);
        self.quantise(2.0 * length);
        self.strands.iter_mut().for_each(|strand| strand.total *= 2);
        for (arc, (least, given)) in self.arcs.iter_mut().zip(before) {
            (arc.count, arc.least, arc.given) = (2 * arc.count, least, given);
        }
        self.length = length;
    }

    /// Changes numbers until every condition is met, or so many are not. Returns the patches that should do without a grid.
    fn settle(&mut self, length: f64, most: usize) -> Vec<usize> {
        let mut conditions = Conditions::new(self);
        let mut search = Search::new(conditions.list.len());
        let mut failed = Vec::new();
        // Grids first: a patch that gives its own up may be odd.
        'all: for demand in [Demand::Same, Demand::Even] {
            for start in 0..conditions.list.len() {
                if conditions.list[start].demand == demand
                    && let Err(patch) = self.meet(start, &mut conditions, length, &mut search)
                {
                    failed.push(patch);
                    if failed.len() >= most {
                        break 'all;
                    }
                }
            }
        }
        self.steps += search.steps;
        failed.sort_unstable();
        failed.dedup();
        failed
    }

    /// Changes numbers until a condition is met. The error is a patch that should do without a grid.
    ///
    /// It ends: every chain brings what is off nearer to what it should be.
    fn meet(
        &mut self,
        start: usize,
        conditions: &mut Conditions,
        length: f64,
        search: &mut Search,
    ) -> Result<(), usize> {
        while !conditions.list[start].is_met() {
            let mut chain = |limits: &[f64; 2]| self.chain(start as u32, conditions, length, limits, search);
            let mut found = LIMITS.iter().find_map(&mut chain);
            if found.is_none() {
                if let Some(patch) = self.steepest(conditions, search) {
                    return Err(patch);
                }
                found = self.chain(start as u32, conditions, length, &LOOSE, search);
            }
            let patch = conditions.list[start].patch;
            let Some(chain) = found else { return Err(self.roomiest(conditions, search).unwrap_or(patch)) };
            let before = conditions.list[start].off();
            for (arc, change) in chain {
                self.arcs[arc as usize].count += change;
                conditions.change(arc, change);
            }
            if conditions.list[start].off() >= before {
                return Err(patch);
            }
        }
        Ok(())
    }

    /// The grids that a search has reached.
    fn reached<'a>(&'a self, conditions: &'a Conditions, search: &'a Search) -> impl Iterator<Item = usize> + 'a {
        let patches = search.reached.iter().map(|state| conditions.list[state / 2].patch);
        patches.filter(|&p| self.patches[p].kind == Kind::Grid)
    }

    /// The one of them that tapers most, if any tapers too much.
    fn steepest(&self, conditions: &Conditions, search: &Search) -> Option<usize> {
        let taper = |p: usize| {
            let length =
                |k: usize| self.patches[p].sides[k].iter().map(|s| self.arcs[s.arc as usize].length).sum::<f64>();
            (0..2).map(|k| length(k) / length(k + 2)).map(|r| r.max(1.0 / r)).fold(1.0, f64::max)
        };
        let all = self.reached(conditions, search).map(|p| (taper(p), p));
        let steepest = all.max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)))?;
        (steepest.0 > TAPER).then_some(steepest.1)
    }

    /// The one of them with most room: where a pattern costs least, and chains may turn round.
    fn roomiest(&self, conditions: &Conditions, search: &Search) -> Option<usize> {
        let grids = self.reached(conditions, search);
        let room = |&p: &usize| self.patches[p].sides.iter().map(|side| self.sum(side)).min().unwrap_or(0);
        let best = grids.max_by_key(|p| (room(p), Reverse(*p)))?;
        (room(&best) >= ROOM).then_some(best)
    }

    /// The cheapest chain of changes by one that brings a condition nearer to what it should be and leaves no other one worse.
    fn chain(
        &self,
        start: u32,
        all: &Conditions,
        length: f64,
        limits: &[f64; 2],
        search: &mut Search,
    ) -> Option<Vec<(u32, i64)>> {
        let state = |c: u32, owed: i64| match all.list[c as usize].demand {
            Demand::Same => 2 * c as usize + usize::from(owed > 0),
            Demand::Even => 2 * c as usize,
        };
        let owed = if all.list[start as usize].value > 0 { -1 } else { 1 };
        search.clear();
        search.reach(state(start, owed), 0.0, None, (start, owed));
        while let Some(Reverse((bits, c, owed))) = search.queue.pop() {
            let (so_far, at) = (f64::from_bits(bits), state(c, owed));
            if so_far > search.cost[at] {
                continue;
            }
            let here = &all.list[c as usize];
            let both = here.demand == Demand::Even;
            for &(arc, times) in here.arcs.iter().filter(|a| both || a.1.abs() == 1) {
                for change in [owed * times.signum(), -owed * times.signum()].into_iter().take(1 + usize::from(both)) {
                    // A chain may come along an arc again, but not take back what it has done.
                    let before = search.so_far(at, arc);
                    if before * change < 0 {
                        continue;
                    }
                    let Some(price) = self.price(arc, before + change, length, limits) else { continue };
                    let next = all.of_arc[arc as usize].iter().find(|u| u.0 != c);
                    let is_end = |&(other, times): &(u32, i64)| {
                        all.list[other as usize].welcomes(times * change, other == start)
                    };
                    if next.is_none_or(is_end) {
                        return Some(search.back(at, (arc, change)));
                    }
                    let Some(&(other, times)) = next.filter(|n| n.1.abs() == 1) else { continue };
                    let (debt, total) = (-times * change, so_far + price);
                    let to = state(other, debt);
                    if total < search.cost[to] {
                        search.reach(to, total, Some((at, arc, change)), (other, debt));
                    }
                }
            }
        }
        None
    }

    /// What a change of an arc costs: what the square of the difference from the ideal number grows by, over that number;
    /// never negative. `None` where it would be too far off.
    fn price(&self, arc: u32, change: i64, length: f64, [fewest, most]: &[f64; 2]) -> Option<f64> {
        let arc = &self.arcs[arc as usize];
        let ideal = arc.ideal(length).max(0.5);
        let count = arc.count + change;
        let is_far = (count as f64) < (fewest * ideal).floor() || count as f64 > (most * ideal).ceil() + 1.0;
        let off = arc.count as f64 - ideal;
        (!is_far && count >= arc.least.max(arc.room))
            .then(|| (1.0 + ((2.0 * off + change as f64) * change as f64).max(0.0)) / ideal)
    }
}
