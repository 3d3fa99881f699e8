//! Strips of cells are put in, or taken out, where faces of the decimated metric have no cell or a feature curve has too few.
//!
//! A strip runs from face to face, all around or from border to border, and makes one side of each edge that it crosses a step
//! longer. What it adds is carried along as frames turn, so that every face stays closed; on the far side it parts one corner
//! from the other two:
//!
//! ```text
//!          A                      A
//!         ╱ ╲          d        ╱  │ ╲
//!    ═══▶╱═══╲═══▶    ──▶     ╱    │   ╲         twice the cells of the face + d × BC
//!       ╱     ╲              ╱     │     ╲
//!      B───────C            B──────┴──────C
//! ```
//!
//! So the cheapest strip through a face is a shortest path, and each one keeps all that is whole. The moves are those of
//! Campen, Bommes, Kobbelt: *Quantized global parametrization*, 2015, section 5, on triangles instead of a T-mesh.

use super::cell::Cell;
use super::flat::{Flat, Side};
use super::framed::{next, previous};
use super::tuning::{STRIP_DETOURS, STRIP_LACK_PRICE, STRIP_ROUNDS, STRIP_STEP_PRICE};
use crate::context::Context;
use crate::error::Result;
use crate::mesh::NONE;
use glam::DVec2;
use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap};

/// A step of a strip: out of a face through a half-edge, whose head goes a cell farther in a direction (a number of right angles)
/// of the frame of that face.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Step {
    half_edge: u32,
    turn: i32,
}

impl Step {
    fn new(half_edge: u32, turn: i32) -> Self {
        Step { half_edge, turn: turn.rem_euclid(4) }
    }

    fn vector(self) -> Cell {
        Cell::new(1, 0).turned(self.turn)
    }

    fn index(self) -> u32 {
        4 * self.half_edge + self.turn as u32
    }

    fn of_index(index: u32) -> Self {
        Step { half_edge: index / 4, turn: (index % 4) as i32 }
    }

    /// How the face behind is entered: through its half-edge, with the same vector in its frame; `None` at a border.
    fn entry(self, flat: &Flat) -> Option<Step> {
        let side = flat.side(self.half_edge);
        (side.opposite != NONE).then(|| Step::new(side.opposite, self.turn + side.turn))
    }
}

/// What the ways to steps cost in a search, and the step before each; what is known from searches before counts for nothing.
#[derive(Default)]
struct Known {
    /// By the index of a step: the search, the cost, the step before.
    of: Vec<(u32, f64, u32)>,
    search: u32,
    queue: BinaryHeap<Reverse<(u64, u32)>>,
}

impl Known {
    fn begin(&mut self, steps: usize) {
        self.of.resize(steps, (0, f64::INFINITY, NONE));
        self.search += 1;
        self.queue.clear();
    }

    fn cost(&self, step: u32) -> f64 {
        let (search, cost, _) = self.of[step as usize];
        if search == self.search { cost } else { f64::INFINITY }
    }

    fn set(&mut self, step: u32, cost: f64, before: u32) {
        self.of[step as usize] = (self.search, cost, before);
        // Costs are not negative: their bits are ordered as they are.
        self.queue.push(Reverse((cost.to_bits(), step)));
    }
}

/// Steps of a strip, with what they cost.
struct Strip {
    cost: f64,
    steps: Vec<Step>,
}

/// The cheapest strip through a step.
enum Way {
    Found(Strip),
    /// It costs more than so much.
    Beyond(f64),
}

impl Way {
    fn cost(&self) -> f64 {
        match self {
            Way::Found(strip) => strip.cost,
            Way::Beyond(cost) => *cost,
        }
    }

    fn steps(&self) -> &[Step] {
        match self {
            Way::Found(strip) => &strip.steps,
            Way::Beyond(_) => &[],
        }
    }
}

/// Where strips are put in.
pub struct Strips<'a> {
    flat: &'a mut Flat,
    /// What the edge of every half-edge should be near.
    goal: Vec<DVec2>,
    /// The fewest edges of every feature curve, and how many it has more than that.
    fewest: &'a [usize],
    spare: Vec<i64>,
    /// What a strip costs for each half cell that a face lacks then and did not before.
    lack_cost: f64,
    known: Known,
}

fn real(cell: Cell) -> DVec2 {
    DVec2::new(cell.x as f64, cell.y as f64)
}

impl<'a> Strips<'a> {
    pub fn new(flat: &'a mut Flat, goal: Vec<DVec2>, fewest: &'a [usize]) -> Self {
        let mut strips =
            Strips { flat, goal, fewest, spare: Vec::new(), lack_cost: f64::INFINITY, known: Known::default() };
        strips.count();
        strips
    }

    fn count(&mut self) {
        let edges = self.flat.edges_of_curves(self.fewest.len());
        self.spare = edges.into_iter().zip(self.fewest).map(|(has, &needs)| has - needs as i64).collect();
    }

    /// How much faces lack to have half a cell each.
    fn lack(&self) -> i64 {
        self.flat.faces().map(|f| (1 - self.flat.cells(f)).max(0)).sum()
    }

    /// Puts strips through faces without a cell until all have one, or no strip helps; returns whether all have one.
    pub fn give_cells(&mut self, context: &Context) -> Result<bool> {
        let mut left = self.lack();
        for _ in 0..STRIP_ROUNDS {
            let before = left;
            let bad: Vec<u32> = self.flat.faces().filter(|&f| self.flat.cells(f) <= 0).collect();
            for f in bad {
                context.check()?;
                if self.flat.cells(f) > 0 {
                    continue;
                }
                let starts = (3 * f..3 * f + 3).flat_map(|h| (0..4).map(move |turn| Step::new(h, turn)));
                self.put_in_best(starts, |strips| {
                    let now = strips.lack();
                    let is_less = now < left;
                    left = left.min(now);
                    is_less
                });
            }
            if left == 0 || left == before && self.lack_cost.is_finite() {
                break;
            }
            // Where no strip leaves all others as they are, one may come by again and give back what it takes.
            self.lack_cost = if left == before { STRIP_LACK_PRICE } else { f64::INFINITY };
        }
        Ok(left == 0)
    }

    /// Puts strips across feature curves that have fewer edges than they need, as far as that goes; returns how many they lack.
    pub fn lengthen_curves(&mut self, context: &Context) -> Result<usize> {
        let mut edges: Vec<Vec<u32>> = vec![Vec::new(); self.fewest.len()];
        self.flat.on_curves().for_each(|h| edges[self.flat.side(h).curve as usize].push(h));
        for (curve, edges) in edges.iter().enumerate() {
            // A curve without an edge in the metric is a part that it does not have.
            while self.spare[curve] < 0 && !edges.is_empty() {
                context.check()?;
                let starts: Vec<Step> = edges.iter().map(|&h| self.longer(h)).collect();
                if !self.put_in_best(starts.into_iter(), |strips| strips.lack() == 0) {
                    break;
                }
            }
        }
        let lacks = (0..edges.len()).filter(|&c| !edges[c].is_empty()).map(|c| (-self.spare[c]).max(0) as usize);
        Ok(lacks.sum())
    }

    /// The step across an edge of a feature that makes it longer.
    fn longer(&self, h: u32) -> Step {
        let along = self.flat.side(h).vector;
        (0..4)
            .map(|turn| Step::new(h, turn))
            .max_by(|a, b| real(a.vector()).dot(along).total_cmp(&real(b.vector()).dot(along)))
            .unwrap_or(Step::new(h, 0))
    }

    /// Puts in the cheapest strip of those from some starts that is as it should be; returns whether there is one. A strip that comes
    /// to the same face again may take its cells away: then it has to go around those that it spoils.
    fn put_in_best(&mut self, starts: impl Iterator<Item = Step>, mut holds: impl FnMut(&Self) -> bool) -> bool {
        let mut all: Vec<(Way, Step, Vec<u32>)> = Vec::new();
        let mut least = f64::INFINITY;
        for start in starts {
            let Some(way) = self.through(start, &[], least) else { continue };
            least = least.min(way.cost());
            all.push((way, start, Vec::new()));
        }
        let mut tries = STRIP_DETOURS * all.len();
        while tries > 0 {
            let order = |a: &Way, b: &Way| a.cost().total_cmp(&b.cost()).then_with(|| a.steps().cmp(b.steps()));
            let Some(best) = (0..all.len()).min_by(|&a, &b| order(&all[a].0, &all[b].0)) else { break };
            let (way, start, mut barred) = all.swap_remove(best);
            let Way::Found(strip) = way else {
                all.extend(self.through(start, &barred, f64::INFINITY).map(|way| (way, start, barred)));
                continue;
            };
            tries -= 1;
            let crossed: BTreeSet<u32> = strip.steps.iter().map(|step| step.half_edge / 3).collect();
            let before: Vec<i64> = crossed.iter().map(|&f| self.flat.cells(f)).collect();
            self.put_in(&strip, 1);
            if self.features_hold(&strip) && holds(self) {
                self.count();
                return true;
            }
            let is_spoilt = |f: u32, before: i64| self.flat.cells(f) <= 0 && self.flat.cells(f) < before;
            let known = barred.len();
            barred.extend(crossed.into_iter().zip(before).filter(|&(f, before)| is_spoilt(f, before)).map(|(f, _)| f));
            self.put_in(&strip, -1);
            if barred.len() > known {
                all.extend(self.through(start, &barred, f64::INFINITY).map(|way| (way, start, barred)));
            }
        }
        false
    }

    fn put_in(&mut self, strip: &Strip, times: i64) {
        for step in &strip.steps {
            let d = times * step.vector();
            let Side { opposite, turn, .. } = *self.flat.side(step.half_edge);
            self.flat.sides[step.half_edge as usize].cells += d;
            if opposite != NONE {
                self.flat.sides[opposite as usize].cells += -d.turned(turn);
            }
        }
    }

    /// Whether edges on features that a strip crosses go on in the direction of the metric.
    fn features_hold(&self, strip: &Strip) -> bool {
        let crossed = strip.steps.iter().map(|step| self.flat.side(step.half_edge));
        crossed.filter(|side| side.curve != NONE).all(|side| side.vector.dot(real(side.cells)) > 0.0)
    }

    /// The cheapest strip through a step, all around or from border to border, if it costs no more than a bound.
    fn through(&mut self, start: Step, barred: &[u32], bound: f64) -> Option<Way> {
        let cost = self.cost(start)?;
        let ahead = match start.entry(self.flat) {
            Some(entry) => match self.shortest(entry, start, barred, bound - cost)? {
                Way::Found(strip) => strip,
                Way::Beyond(_) => return Some(Way::Beyond(bound)),
            },
            None => Strip { cost: 0.0, steps: Vec::new() },
        };
        if ahead.steps.last() == Some(&start) {
            return Some(Way::Found(ahead));
        }
        // Back from the start, into its own face: what is crossed there changes as it would the other way.
        let back = Step::new(start.half_edge, start.turn + 2);
        let behind = match self.shortest(back, start, barred, bound - cost - ahead.cost)? {
            Way::Found(strip) => strip,
            Way::Beyond(_) => return Some(Way::Beyond(bound)),
        };
        let is_open = behind.steps.last().is_some_and(|s| self.flat.side(s.half_edge).opposite == NONE);
        let steps = ahead.steps.into_iter().chain([start]).chain(behind.steps).collect();
        is_open.then_some(Way::Found(Strip { cost: cost + ahead.cost + behind.cost, steps }))
    }

    /// The shortest path from where a face is entered to a step, or out of a border, if it is no longer than a bound (Dijkstra).
    fn shortest(&mut self, entry: Step, goal: Step, barred: &[u32], bound: f64) -> Option<Way> {
        let mut known = std::mem::take(&mut self.known);
        known.begin(4 * self.flat.sides.len());
        let way = self.search(&mut known, entry, goal, barred, bound);
        self.known = known;
        way
    }

    fn search(&self, known: &mut Known, entry: Step, goal: Step, barred: &[u32], bound: f64) -> Option<Way> {
        self.go_on(entry, 0.0, NONE, known);
        while let Some(Reverse((bits, index))) = known.queue.pop() {
            let (step, cost) = (Step::of_index(index), f64::from_bits(bits));
            if cost > bound {
                return Some(Way::Beyond(bound));
            }
            if cost > known.cost(index) || barred.contains(&(step.half_edge / 3)) && step != goal {
                continue;
            }
            let Some(entry) = step.entry(self.flat).filter(|_| step != goal) else {
                let (mut steps, mut at) = (Vec::new(), index);
                while at != NONE {
                    steps.push(Step::of_index(at));
                    at = known.of[at as usize].2;
                }
                steps.reverse();
                return Some(Way::Found(Strip { cost, steps }));
            };
            self.go_on(entry, cost, index, known);
        }
        None
    }

    /// The ways out of a face.
    fn go_on(&self, entry: Step, cost: f64, from: u32, known: &mut Known) {
        for exit in [next(entry.half_edge), previous(entry.half_edge)] {
            let step = Step::new(exit, entry.turn);
            let Some(crossing) = self.cost(step) else { continue };
            let cost = cost + (crossing + self.cost_of_pass(entry, exit));
            // Infinite costs are no way.
            if cost < known.cost(step.index()) {
                known.set(step.index(), cost, from);
            }
        }
    }

    /// What a strip costs in a face: something for each half cell that this lacks afterwards and did not before. It may come by again
    /// and give it back.
    fn cost_of_pass(&self, entry: Step, exit: u32) -> f64 {
        let f = entry.half_edge / 3;
        let d = entry.vector();
        let mut cells = [0, 1, 2].map(|k| self.flat.side(3 * f + k).cells);
        cells[entry.half_edge as usize % 3] += -d;
        cells[exit as usize % 3] += d;
        let [before, after] = [self.flat.cells(f), cells[0].cross(cells[1])].map(|cells| (1 - cells).max(0));
        match after > before {
            true => self.lack_cost * (after - before) as f64,
            false => 0.0,
        }
    }

    /// What it costs to cross a half-edge: how much farther its edge is from what it should be, and a little for each step.
    /// `None`: a feature would be bent, or has no edge to give away.
    fn cost(&self, step: Step) -> Option<f64> {
        let side = self.flat.side(step.half_edge);
        let d = step.vector();
        if side.curve != NONE {
            let along = real(d).dot(side.vector) / side.vector.length();
            let has_none_to_spare = || self.spare.get(side.curve as usize).is_some_and(|&spare| spare <= 0);
            if along.abs() < 0.5 || along < 0.0 && has_none_to_spare() {
                return None;
            }
        }
        let goal = self.goal[step.half_edge as usize];
        let off = |c: Cell| (real(c) - goal).length_squared();
        let more = (off(side.cells + d) - off(side.cells)) / goal.length().max(1.0);
        Some(STRIP_STEP_PRICE + more.max(0.0))
    }
}
