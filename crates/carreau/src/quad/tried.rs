//! What speaks against quads, and what has come of attempts so far: the best one counts.

use super::budget::Budget;
use super::ceiling::worst_shape;
use super::gaps::{Gap, Tight};
use super::regular::{Made, USELESS};
use super::source::Source;
use super::validate::{RECALL, recall};
use super::{WITHIN, off, quality};
use crate::context::Context;
use crate::error::Result;

/// Quads farther from the surface than this share of their edges make way for another attempt's.
pub const STRAYS: f64 = 0.4;
/// Quads of a worse shape make way, too, by grades of this size; as many cost a number that is missed.
const POOR: f64 = 0.5;
pub const GRADE: f64 = 0.1;
/// So does a distance from the surface above this share of the diagonal, by grades of the other.
const FAR: f64 = 0.002;
const FARTHER: f64 = 0.001;
/// So do quads whose scaled Jacobian is less than this in the mean.
const DULL: f64 = 0.93;
const DULLER: f64 = 0.03;

/// So do features that are lost, by their share, and quads that lose more than the other share of them are of no use.
const LOST: f64 = 0.02;
const MOST_LOST: f64 = 0.2;

/// What speaks against a result; the less the better.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct Cost {
    /// It strays from the surface, or a quad is of no use.
    pub useless: bool,
    /// Grades of poor shapes, the worst and the mean, of a number missed, of a distance, of lost features.
    pub grades: u32,
    pub irregular: usize,
}

/// What came of one.
pub struct Attempt {
    pub made: Made,
    pub cost: Cost,
    /// How far it leaves the surface, or leaves part of it out, over the length of edges.
    pub strays: f64,
    /// There is nothing to be said against it: no other is needed.
    pub is_good: bool,
    /// Nothing but a distance, lost features or a mean that is a little low speak against it, which another field hardly changes.
    pub is_shaped: bool,
    /// It has as many quads as were asked for.
    pub meets_number: bool,
    /// Where smaller quads would be near enough to the surface.
    pub tight: Vec<Tight>,
}

/// An attempt that came to nothing because of some regions.
pub struct Trouble {
    /// The length of the triangles of its field, over that of the quads.
    pub finer: f64,
    pub deals: bool,
    pub regions: Vec<u32>,
}

/// What has come of attempts so far.
pub struct Tried {
    pub budget: Budget,
    /// The one that stays on the surface, has no poor quads, has the fewest irregular vertices.
    pub best: Option<Attempt>,
    /// Grades of the best one before these, if that one is useful.
    pub before: Option<u32>,
    /// Smaller quads that came to nothing.
    pub fruitless: u32,
    /// Why the last one came to nothing.
    pub refused: String,
    pub trouble: Vec<Trouble>,
}

impl Tried {
    /// Nothing, with so much to be done at most.
    pub fn nothing(budget: Budget) -> Self {
        Tried { budget, best: None, before: None, fruitless: 0, refused: String::new(), trouble: Vec::new() }
    }

    /// The best one, and why the last one that came to nothing did.
    pub fn best(self) -> (Option<Made>, String) {
        (self.best.map(|b| b.made), self.refused)
    }

    pub fn is_useful(&self) -> bool {
        self.best.as_ref().is_some_and(|b| !b.cost.useless)
    }

    /// Nothing speaks against the best one but how many irregular vertices it has.
    pub fn will_do(&self) -> bool {
        self.is_useful() && self.best.as_ref().is_some_and(|b| b.cost.grades == 0)
    }

    /// Nothing more is to be tried: one will do, or the budget is spent.
    pub fn is_over(&self) -> bool {
        self.budget.is_spent() || self.will_do()
    }

    /// See [`Attempt::is_shaped`].
    pub fn is_shaped(&self) -> bool {
        self.best.as_ref().is_some_and(|b| b.is_shaped)
    }

    /// See [`Attempt::meets_number`].
    pub fn meets_number(&self) -> bool {
        self.best.as_ref().is_some_and(|b| b.meets_number)
    }

    pub fn is_good(&self) -> bool {
        self.best.as_ref().is_some_and(|b| b.is_good)
    }

    /// Grades of the best one that is useful.
    pub fn grades(&self) -> Option<u32> {
        self.best.as_ref().filter(|b| !b.cost.useless).map(|b| b.cost.grades).or(self.before)
    }

    /// For attempts that know of these, but not of each other.
    pub fn afresh(&self) -> Self {
        Tried { before: self.grades(), fruitless: self.fruitless, ..Tried::nothing(self.budget.clone()) }
    }

    /// Takes up what came of others that knew of `known`.
    pub fn take_up(&mut self, others: Tried, known: &Tried) {
        self.budget.spend(known.budget.left() - others.budget.left());
        self.fruitless += others.fruitless - known.fruitless;
        others.best.into_iter().for_each(|best| self.offer(best));
        if !others.refused.is_empty() {
            self.refused = others.refused;
        }
        self.trouble.extend(others.trouble);
    }

    /// Keeps an attempt if it is better than the best one.
    pub fn offer(&mut self, found: Attempt) {
        if found.is_good || self.best.as_ref().is_none_or(|b| found.cost < b.cost) {
            self.best = Some(found);
        }
    }
}

/// Quads of a wanted number with what speaks against them; whether their number has been raised.
pub fn judged(
    source: &Source,
    made: Made,
    gap: Gap,
    quads: Option<usize>,
    is_raised: bool,
    context: &Context,
) -> Result<Attempt> {
    let strays = quality::straying(&made.work, source, context)?;
    let grade = |beyond: f64, size: f64| (beyond / size).ceil().max(0.0) as u32;
    let misses = quads.map_or(0, |n| grade(off(made.work.faces.len(), n) - WITHIN, GRADE));
    let shape = worst_shape(&made.work);
    let poor = grade(POOR - shape, GRADE);
    let dull = grade(DULL - quality::mean_jacobian(&made.work), DULLER);
    let kept = recall(&made.work, source).0;
    let lost = grade(RECALL - kept, LOST);
    let far = grade(gap.largest / source.diagonal - FAR, FARTHER);
    let cost = Cost {
        useless: strays > STRAYS || shape < USELESS || kept < 1.0 - MOST_LOST,
        grades: poor + dull + misses + far + lost,
        irregular: quality::irregular(&made.work),
    };
    tracing::debug!(target: "carreau::quad", strays, shape, poor, dull, misses, far, lost, ?cost, rungs = ?made.rung, "attempt");
    // Another field does not change what the features need, but smaller quads do.
    let misses_more = misses > 0 && is_raised;
    let is_first = made.rung.iter().all(|&r| r == 1);
    let is_good = is_first && strays <= STRAYS && poor + dull + far + lost == 0 && !misses_more;
    let is_shaped = !cost.useless && is_first && poor + misses == 0 && dull <= 1;
    let tight = if far > 0 { gap.tight } else { Vec::new() };
    Ok(Attempt { made, cost, strays, is_good, is_shaped, meets_number: misses == 0, tight })
}
