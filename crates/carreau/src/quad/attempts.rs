//! Rungs 1 and 2, attempt after attempt: with fields on finer and coarser triangles, and with smaller quads where they were too
//! far from the surface. Where nothing comes of it, regions that make trouble take the quads of rung 3. The best one counts.

use super::budget::Budget;
use super::ceiling::{worst_shape, worst_shapes};
use super::draw::{Drawn, FINER, draw};
use super::gaps::{Gap, Tight};
use super::graft::Donor;
use super::regular::{MOST, Made, Refusal, USELESS, Wish, regular};
use super::source::Source;
use super::work::Work;
use super::{LEFT_OUT, LOST, QuadOptions, WITHIN, lifted, off, quality, validate};
use crate::context::Context;
use crate::error::{Error, Result};
use std::collections::BTreeSet;

/// Fields that are tried even where the first one does but for triangles in a patch; the others where what came of these is poor.
const USUAL: usize = 2;
/// Attempts with smaller quads where others were too far from the surface, that may come to nothing.
const FRUITLESS: u32 = 2;
/// Attempts that come to nothing before the next rung takes over, where none came to anything: others hardly ever do then.
const FUTILE: usize = 3;
/// Quads farther from the surface than this share of their edges make way for another attempt's.
const STRAYS: f64 = 0.4;
/// Quads of a worse shape make way, too, by grades of this size; as many cost a number that is missed.
const POOR: f64 = 0.5;
const GRADE: f64 = 0.1;
/// So does a distance from the surface above this share of the diagonal, by grades of the other.
const FAR: f64 = 0.002;
const FARTHER: f64 = 0.001;
/// So do quads whose scaled Jacobian is less than this in the mean.
const DULL: f64 = 0.93;
const DULLER: f64 = 0.03;
/// Those of rung 3 for all take the place of others with a useless one only where all their scaled Jacobians are above this.
const USEFUL: f64 = 0.05;

/// What speaks against a result; the less the better.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
struct Cost {
    /// It strays from the surface, or a quad is of no use.
    useless: bool,
    /// Grades of poor shapes, the worst and the mean, of a number missed, of a distance.
    grades: u32,
    irregular: usize,
}

/// What came of one.
struct Attempt {
    made: Made,
    cost: Cost,
    /// How far it leaves the surface, or leaves part of it out, over the length of edges.
    strays: f64,
    /// There is nothing to be said against it: no other is needed.
    is_good: bool,
    /// Where smaller quads would be near enough to the surface.
    tight: Vec<Tight>,
}

/// How quads are made with a field.
#[derive(Clone, Copy)]
struct Way<'a> {
    /// Whether vertices are dealt to bends beforehand.
    deals: bool,
    /// What gives the quads of some regions, and which ones.
    graft: Option<(&'a Donor<'a>, &'a [u32])>,
}

/// Beforehand they keep a feature with fewer quads, but unevenly, which strips whose sides bend in other places do not take well.
const DEALT: Way = Way { deals: true, graft: None };
/// Where features bend, evenly spaced vertices come to it afterwards.
const EVEN: Way = Way { deals: false, graft: None };

/// An attempt that came to nothing because of some regions.
struct Trouble {
    /// The length of the triangles of its field, over that of the quads.
    finer: f64,
    deals: bool,
    regions: Vec<u32>,
}

/// What is wanted, and what there is.
pub struct Attempts<'a> {
    source: &'a Source,
    length: f64,
    quads: Option<usize>,
    /// Rung 1 may do.
    first: bool,
    feature_deg: f64,
    budget: Budget,
    /// The one that stays on the surface, has no poor quads, has the fewest irregular vertices.
    best: Option<Attempt>,
    /// Why the last one came to nothing.
    refused: String,
    trouble: Vec<Trouble>,
    context: &'a Context,
}

impl<'a> Attempts<'a> {
    pub fn new(source: &'a Source, options: &QuadOptions, context: &'a Context) -> Self {
        let (length, quads) = match options.edge_length {
            Some(length) => (length, None),
            None => ((source.area / options.quads as f64).sqrt(), Some(options.quads)),
        };
        Attempts {
            source,
            length,
            quads,
            first: options.rung == 1,
            feature_deg: options.features.angle_deg.unwrap_or(180.0),
            budget: Budget::new(source.area / length.powi(2)),
            best: None,
            refused: String::new(),
            trouble: Vec::new(),
            context,
        }
    }

    /// The best one, and why the last one that came to nothing did.
    pub fn best(self) -> (Option<Made>, String) {
        (self.best.map(|b| b.made), self.refused)
    }

    pub fn is_useful(&self) -> bool {
        self.best.as_ref().is_some_and(|b| !b.cost.useless)
    }

    /// Nothing speaks against the best one but how many irregular vertices it has.
    fn will_do(&self) -> bool {
        self.is_useful() && self.best.as_ref().is_some_and(|b| b.cost.grades == 0)
    }

    fn is_good(&self) -> bool {
        self.best.as_ref().is_some_and(|b| b.is_good)
    }

    /// Field after field, until one will do.
    pub fn run(&mut self) -> Result<()> {
        // Borders that lie on each other meet by chance here, by force on rung 3.
        let futile = if self.source.is_shared.contains(&true) { 1 } else { FUTILE };
        let mut fruitless = 0;
        for (k, finer) in FINER.into_iter().enumerate() {
            let is_futile = k >= futile && self.best.is_none();
            if self.is_good() || self.budget.is_spent() || is_futile || k >= USUAL && self.will_do() {
                break;
            }
            self.with_field(finer, self.ways(k), &mut fruitless)?;
        }
        Ok(())
    }

    /// Both are tried with the first field, and one with each of the others, in turn: there would be no budget for more.
    fn ways(&self, field: usize) -> &'static [Way<'static>] {
        match field {
            _ if self.source.bends.is_empty() => &[EVEN],
            0 => &[DEALT, EVEN],
            _ if field.is_multiple_of(2) => &[DEALT],
            _ => &[EVEN],
        }
    }

    /// The same with quads of rung 3 for the regions that made trouble; those of rung 3 for all are an attempt, too.
    pub fn graft(&mut self, third: Work, gap: Gap) -> Result<()> {
        let whole = Made::all_on(3, third.clone(), self.source);
        let mut whole = judged(self.source, whole, gap, self.quads, false, self.context)?;
        whole.cost.useless |= self.best.is_some() && quality::least_jacobian(&third) <= USEFUL;
        self.offer(whole);
        // Borders that lie on each other have other curves there.
        if self.source.is_shared.contains(&true) {
            return Ok(());
        }
        let donor = Donor::new(&third, self.source);
        let mut fruitless = 0;
        let trouble = std::mem::take(&mut self.trouble);
        for of_field in trouble.chunk_by(|a, b| a.finer == b.finer).take(FUTILE) {
            if self.budget.is_spent() || self.will_do() {
                break;
            }
            let ways: Vec<Way> =
                of_field.iter().map(|t| Way { deals: t.deals, graft: Some((&donor, &t.regions)) }).collect();
            self.with_field(of_field[0].finer, &ways, &mut fruitless)?;
        }
        Ok(())
    }

    /// Attempts with one field, way after way, until one will do.
    fn with_field(&mut self, finer: f64, ways: &[Way], fruitless: &mut u32) -> Result<()> {
        let drawn = draw(self.source, self.length, finer * self.length, self.feature_deg, self.context);
        match or_why(drawn.map(|drawn| drawn.map_err(Refusal::from)))? {
            Ok(drawn) => {
                self.budget.triangles(drawn.coarse.mesh.face_count());
                for way in ways {
                    let regions = self.shrink(&drawn, *way, fruitless)?;
                    if !regions.is_empty() && regions.len() < self.source.regions {
                        self.trouble.push(Trouble { finer, deals: way.deals, regions });
                    }
                    if self.budget.is_spent() || self.will_do() {
                        break;
                    }
                }
            }
            Err(refusal) => self.refused = refusal.why,
        }
        Ok(())
    }

    /// Again with smaller quads where they were too far from the surface, as long as that helps. Returns the regions that
    /// made trouble where nothing came of it.
    fn shrink(&mut self, drawn: &Drawn, way: Way, fruitless: &mut u32) -> Result<Vec<u32>> {
        let (mut tight, mut before, mut tried) = (Vec::new(), None, Vec::new());
        loop {
            let wish = Wish {
                length: self.length,
                quads: self.quads,
                most: self.most(way),
                first: self.first,
                deals: way.deals,
                graft: way.graft,
                tight: &tight,
                tried: &tried,
            };
            let found = match one(self.source, drawn, &wish, &mut self.budget, self.context)? {
                Ok(found) => found,
                Err(refusal) => {
                    self.refused = refusal.why;
                    *fruitless += u32::from(before.is_some());
                    return Ok(if before.is_none() { refusal.regions } else { Vec::new() });
                }
            };
            let helps = before.is_none_or(|before| found.cost < before);
            *fruitless += u32::from(!helps);
            before = Some(found.cost);
            let again = helps
                && !found.is_good
                && !self.budget.is_spent()
                && *fruitless < FRUITLESS
                && !found.tight.is_empty()
                && !found.cost.useless;
            tight.extend(found.tight.iter().copied());
            tried.clone_from(&found.made.numbers);
            let mut trouble = Vec::new();
            if found.cost.useless {
                self.refused = "some of their quads are of no use".into();
                trouble = useless_regions(&found.made.work);
            }
            self.offer(found);
            if !again {
                return Ok(trouble);
            }
        }
    }

    /// Keeps an attempt if it is better than the best one.
    fn offer(&mut self, found: Attempt) {
        if found.is_good || self.best.as_ref().is_none_or(|b| found.cost < b.cost) {
            self.best = Some(found);
        }
    }

    /// How many times too many quads may be: a number that is missed by more than the best attempt is off speaks for that one.
    /// Where nothing is useful, and some quads are of rung 3, it may be as many as these are for all.
    fn most(&self, way: Way) -> f64 {
        let useful = self.best.as_ref().filter(|b| !b.cost.useless);
        let third = way.graft.zip(self.quads).map_or(0.0, |(graft, n)| graft.0.count() as f64 / n as f64);
        useful.map_or(MOST.max(third), |b| (1.0 + WITHIN + GRADE * f64::from(b.cost.grades)).min(MOST))
    }
}

/// What a rung cannot do is for the next one.
fn or_why<T>(result: Result<std::result::Result<T, Refusal>>) -> Result<std::result::Result<T, Refusal>> {
    match result {
        Err(Error::Numeric(why)) => Ok(Err(why.into())),
        other => other,
    }
}

/// The regions with quads of no use.
fn useless_regions(work: &Work) -> Vec<u32> {
    let useless = worst_shapes(work).zip(&work.region).filter(|(shape, _)| *shape < USELESS);
    useless.map(|(_, &region)| region).collect::<BTreeSet<u32>>().into_iter().collect()
}

/// One attempt, or why nothing came of it.
fn one(
    source: &Source,
    drawn: &Drawn,
    wish: &Wish,
    budget: &mut Budget,
    context: &Context,
) -> Result<std::result::Result<Attempt, Refusal>> {
    let mut made = match or_why(regular(source, drawn, wish, budget, context))? {
        Ok(made) => made,
        Err(refusal) => return Ok(Err(refusal)),
    };
    let gap = lifted(&mut made.work, source, context)?;
    if let Some(why) = validate::refusal(&made.work, &made.work.to_mesh()?, source)? {
        return Ok(Err(why.into()));
    }
    let found = judged(source, made, gap, wish.quads, !wish.tight.is_empty(), context)?;
    Ok(if found.strays > LOST { Err(LEFT_OUT.to_string().into()) } else { Ok(found) })
}

/// Quads of a wanted number with what speaks against them; whether their number has been raised.
fn judged(
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
    let far = grade(gap.largest / source.diagonal - FAR, FARTHER);
    let cost = Cost {
        useless: strays > STRAYS || shape < USELESS,
        grades: poor + dull + misses + far,
        irregular: quality::irregular(&made.work),
    };
    tracing::debug!(target: "carreau::quad", strays, shape, poor, dull, misses, far, ?cost, rungs = ?made.rung, "attempt");
    // Another field does not change what the features need, but smaller quads do.
    let misses_more = misses > 0 && is_raised;
    let is_good = made.rung.iter().all(|&r| r == 1) && strays <= STRAYS && poor + dull + far == 0 && !misses_more;
    let tight = if far > 0 { gap.tight } else { Vec::new() };
    Ok(Attempt { made, cost, strays, is_good, tight })
}
