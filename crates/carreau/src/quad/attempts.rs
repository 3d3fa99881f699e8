//! Rungs 1 and 2, attempt after attempt: with fields on finer and coarser triangles, and with smaller quads where they were too
//! far from the surface. Where nothing comes of it, regions that make trouble take the quads of rung 3. The best one counts.

use super::budget::Budget;
use super::ceiling::worst_shapes;
use super::draw::{Drawn, FINER, draw};
use super::gaps::Gap;
use super::graft::Donor;
use super::regular::{MOST, Made, Refusal, USELESS, Wish, regular};
use super::source::Source;
use super::tried::{Attempt, GRADE, Tried, Trouble, judged};
use super::work::Work;
use super::{LEFT_OUT, LOST, QuadOptions, WITHIN, lifted, quality, validate};
use crate::context::Context;
use crate::error::{Error, Result};
use std::collections::BTreeSet;
use std::ops::ControlFlow;

/// Fields that are tried even where the first one does but for triangles in a patch; the others where what came of these is poor.
const USUAL: usize = 2;
/// Attempts with smaller quads where others were too far from the surface, that may come to nothing.
const FRUITLESS: u32 = 2;
/// Attempts that come to nothing before the next rung takes over, where none came to anything: others hardly ever do then.
const FUTILE: usize = 3;
/// Those of rung 3 for all take the place of others with a useless one only where all their scaled Jacobians are above this.
const USEFUL: f64 = 0.05;

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

/// What is wanted.
pub struct Attempts<'a> {
    pub source: &'a Source,
    pub length: f64,
    pub quads: Option<usize>,
    /// Rung 1 may do.
    first: bool,
    pub feature_deg: f64,
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
            context,
        }
    }

    /// What may be done, with nothing tried yet.
    pub fn none(&self) -> Tried {
        Tried::nothing(Budget::new(self.source.area / self.length.powi(2)))
    }

    /// With the first field. Returns whether others are to be tried.
    pub fn first(&self, tried: &mut Tried) -> Result<bool> {
        self.with_field(FINER[0], self.ways(0), tried, self.context)?;
        Ok(self.goes_on(1, tried))
    }

    /// Field after field, until one will do. They may be tried at the same time.
    pub fn others(&self, tried: &mut Tried) -> Result<()> {
        // Where the first one will do, the usual ones are enough, whatever comes of them.
        let others = if tried.will_do() { &FINER[1..USUAL] } else { &FINER[1..] };
        let field = |k: usize, known: &mut Tried, context: &Context| {
            self.with_field(others[k], self.ways(k + 1), known, context)
        };
        let mut fields = 1;
        let goes_on = |tried: &Tried| {
            fields += 1;
            self.goes_on(fields, tried)
        };
        self.each(others.len(), field, goes_on, tried)
    }

    /// Whether more fields are to be tried after so many.
    fn goes_on(&self, fields: usize, tried: &Tried) -> bool {
        // Borders that lie on each other meet by chance here, by force on rung 3.
        let futile = if self.source.is_shared.contains(&true) { 1 } else { FUTILE };
        let is_futile = fields >= futile && tried.best.is_none();
        !(tried.is_good()
            || tried.is_shaped()
            || tried.budget.is_spent()
            || is_futile
            || fields >= USUAL && tried.will_do())
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
    pub fn graft(&self, third: Work, gap: Gap, tried: &mut Tried) -> Result<()> {
        let whole = Made::all_on(3, third.clone(), self.source);
        let mut whole = judged(self.source, whole, gap, self.quads, false, self.context)?;
        whole.cost.useless |= tried.best.is_some() && quality::least_jacobian(&third) <= USEFUL;
        tried.offer(whole);
        // Borders that lie on each other have other curves there.
        if self.source.is_shared.contains(&true) || tried.is_over() {
            return Ok(());
        }
        let donor = Donor::new(&third, self.source);
        tried.fruitless = 0;
        let trouble = std::mem::take(&mut tried.trouble);
        let fields: Vec<&[Trouble]> = trouble.chunk_by(|a, b| a.finer == b.finer).take(FUTILE).collect();
        let field = |k: usize, known: &mut Tried, context: &Context| {
            let of_field = fields[k].iter();
            let ways: Vec<Way> = of_field.map(|t| Way { deals: t.deals, graft: Some((&donor, &t.regions)) }).collect();
            self.with_field(fields[k][0].finer, &ways, known, context)
        };
        self.each(fields.len(), field, |tried| !tried.is_over(), tried)
    }

    /// Attempts that know of what was tried before, but not of each other, so that they can be made at the same time. They count
    /// in their order, as long as it is to go on.
    fn each(
        &self,
        count: usize,
        make: impl Fn(usize, &mut Tried, &Context) -> Result<()> + Sync,
        mut goes_on: impl FnMut(&Tried) -> bool + Send,
        tried: &mut Tried,
    ) -> Result<()> {
        let known = tried.afresh();
        let attempt = |k: usize, context: &Context| {
            let mut own = known.afresh();
            make(k, &mut own, context).map(|()| own)
        };
        self.context.in_order(count, attempt, |own| {
            tried.take_up(own, &known);
            if goes_on(tried) { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        })
    }

    /// Attempts with one field, way after way, until one will do.
    fn with_field(&self, finer: f64, ways: &[Way], tried: &mut Tried, context: &Context) -> Result<()> {
        let drawn = draw(self.source, self.length, finer * self.length, self.feature_deg, context);
        let drawn = match or_why(drawn.map(|drawn| drawn.map_err(Refusal::from)))? {
            Ok(drawn) => drawn,
            Err(refusal) => {
                tried.refused = refusal.why;
                return Ok(());
            }
        };
        tried.budget.triangles(drawn.coarse.mesh.face_count());
        for way in ways {
            let regions = self.shrink(&drawn, *way, tried, context)?;
            if !regions.is_empty() && regions.len() < self.source.regions {
                tried.trouble.push(Trouble { finer, deals: way.deals, regions });
            }
            if tried.is_over() {
                break;
            }
        }
        Ok(())
    }

    /// Again with smaller quads where they were too far from the surface, as long as that helps. Returns the regions that
    /// made trouble where nothing came of it.
    fn shrink(&self, drawn: &Drawn, way: Way, tried: &mut Tried, context: &Context) -> Result<Vec<u32>> {
        let (mut tight, mut before, mut numbers) = (Vec::new(), None, Vec::new());
        loop {
            let wish = Wish {
                length: self.length,
                quads: self.quads,
                most: self.most(way, tried),
                first: self.first,
                deals: way.deals,
                graft: way.graft,
                tight: &tight,
                tried: &numbers,
            };
            let found = match one(self.source, drawn, &wish, &mut tried.budget, context)? {
                Ok(found) => found,
                Err(refusal) => {
                    tracing::debug!(target: "carreau::quad", why = %refusal.why, regions = ?refusal.regions, "came to nothing");
                    tried.refused = refusal.why;
                    tried.fruitless += u32::from(before.is_some());
                    return Ok(if before.is_none() { refusal.regions } else { Vec::new() });
                }
            };
            let helps = before.is_none_or(|before| found.cost < before);
            tried.fruitless += u32::from(!helps);
            before = Some(found.cost);
            let again = helps
                && !found.is_good
                && !tried.budget.is_spent()
                && tried.fruitless < FRUITLESS
                && !found.tight.is_empty()
                && !found.cost.useless;
            tight.extend(found.tight.iter().copied());
            numbers.clone_from(&found.made.numbers);
            let mut trouble = Vec::new();
            if found.cost.useless {
                tried.refused = "some of their quads are of no use".into();
                trouble = useless_regions(&found.made.work);
            }
            tried.offer(found);
            if !again {
                return Ok(trouble);
            }
        }
    }

    /// How many times too many quads may be: a number that is missed by more than the best attempt is off speaks for that one.
    /// Where nothing is useful, and some quads are of rung 3, it may be as many as these are for all.
    fn most(&self, way: Way, tried: &Tried) -> f64 {
        let third = way.graft.zip(self.quads).map_or(0.0, |(graft, n)| graft.0.count() as f64 / n as f64);
        tried.grades().map_or(MOST.max(third), |grades| (1.0 + WITHIN + GRADE * f64::from(grades)).min(MOST))
    }
}

/// What a rung cannot do is for the next one.
pub fn or_why<T, W: From<String>>(result: Result<std::result::Result<T, W>>) -> Result<std::result::Result<T, W>> {
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
