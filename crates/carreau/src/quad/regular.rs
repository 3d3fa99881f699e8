//! Rungs 1 and 2: the motorcycle graph of a frame field divides the surface into patches.
//!
//! Rung 1: grids in patches with four sides that add up, patterns in the others. Rung 2: triangles of twice the size, paired
//! and halved, in patches that take neither. A patch whose quads are bad after smoothing takes triangles; where these are bad,
//! too, it is joined to its neighbours; and where these are, its region takes the quads of rung 3, if there are any.

use super::budget::Budget;
use super::ceiling::worst_shapes;
use super::cut::open_holes;
use super::draw::{Drawn, place};
use super::fill::{Filled, fill};
use super::gaps::Tight;
use super::graft::Donor;
use super::layout::{Kind, Layout, Patch};
use super::sheet::Sheet;
use super::smooth::Smoothing;
use super::source::Source;
use super::ticks::find_bends;
use super::validate::{NEAR, faults, lost_features, told};
use super::work::{Place, Work};
use crate::context::Context;
use crate::error::Result;
use glam::DVec3;
use rustc_hash::{FxHashMap, FxHashSet};
use std::collections::BTreeSet;
use std::ops::ControlFlow;

/// Runs in search of a number of quads.
const RUNS: usize = 8;

/// Edges stay within this share of the distance at which a feature counts as kept; after this round it is enough that it
/// counts.
const SAG: f64 = 0.8;
const TIGHT: usize = 2;

/// Rounds in which patches with bad quads get triangles, and then lose their tracks.
const ROUNDS: usize = 8;
/// Rounds where there are quads of rung 3 to be taken.
const GRAFTED_ROUNDS: usize = 14;
/// Rounds that leave no fewer bad patches before it is given up.
const PATIENCE: usize = 2;
/// Regions beside a feature that was cut short in so many rounds take the quads of rung 3.
const LOST: usize = 3;

/// Regions with more than this share of the surface keep their tracks: triangles in all of it are what rung 3 has.
const CLEARED: f64 = 0.5;

/// Quads of a worse shape are of no use.
pub const USELESS: f64 = 0.02;

/// What has become of a triangle of the sheet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum State {
    Fresh,
    /// Its patch takes neither a grid nor a pattern.
    Barred,
    /// Its patch was joined to its neighbours.
    Joined,
    /// Its region has no tracks at all.
    Cleared,
    /// Its region takes the quads of rung 3.
    Grafted,
}

impl State {
    /// The rung of a patch that was filled.
    fn rung(self, kind: Kind) -> u32 {
        match (self, kind) {
            (State::Fresh, Kind::Grid | Kind::Pattern) => 1,
            (State::Grafted, _) => 3,
            _ => 2,
        }
    }
}

/// Numbers of quads this near to what is wanted will do: the logarithm of the ratio.
const WITHIN: f64 = 0.05;

/// Numbers that other lengths change by less than this share stay.
const STUCK: f64 = 0.005;
/// After so many such lengths no other is tried.
const UNMOVED: usize = 4;

/// Layouts with more quads than so many times those wanted are not filled.
pub const MOST: f64 = 2.5;
/// Nor are those of a thin strip, of which nobody knows how many its edge length wants, where it would be many more than these.
const MANY: f64 = 1e6;

/// Quads with the rung of every region.
pub struct Made {
    pub work: Work,
    pub rung: Vec<u32>,
    /// Edges along the motorcycle graph.
    pub tracks: Vec<[u32; 2]>,
    /// Numbers of quads along the arcs of its first layout.
    pub numbers: Vec<i64>,
}

impl Made {
    /// Quads that are all made on one rung, without a graph.
    pub fn all_on(rung: u32, work: Work, source: &Source) -> Self {
        Made { work, rung: vec![rung; source.regions], tracks: Vec::new(), numbers: Vec::new() }
    }
}

/// Why nothing came of it.
pub struct Refusal {
    pub why: String,
    /// The regions that made trouble, if these alone did.
    pub regions: Vec<u32>,
}

impl From<String> for Refusal {
    fn from(why: String) -> Self {
        Refusal { why, regions: Vec::new() }
    }
}

/// What speaks against a layout.
enum Trouble {
    All(String),
    /// Curves beside regions that take the quads of rung 3 are others there.
    Curves(Vec<u32>),
}

impl<T: Into<String>> From<T> for Trouble {
    fn from(why: T) -> Self {
        Trouble::All(why.into())
    }
}

/// What comes of it.
pub type Outcome = std::result::Result<Made, Refusal>;

/// What is wanted.
pub struct Wish<'a> {
    /// Length of the quads.
    pub length: f64,
    /// Their number; `None`: the length is what counts.
    pub quads: Option<usize>,
    /// More of them than so many times their number are of no interest.
    pub most: f64,
    /// Rung 1 may do.
    pub first: bool,
    /// The vertices of features are dealt to their bends beforehand; else those that are near go there afterwards.
    pub deals: bool,
    /// Regions that make trouble take the quads of rung 3, and those that are known to make it.
    pub graft: Option<(&'a Donor<'a>, &'a [u32])>,
    /// Where quads were too far from the surface before.
    pub tight: &'a [Tight],
    /// Numbers that have been tried.
    pub tried: &'a [i64],
}

/// Quads as wished, along a graph.
pub fn regular(source: &Source, drawn: &Drawn, wish: &Wish, budget: &mut Budget, context: &Context) -> Result<Outcome> {
    let mut rounds = Rounds::new(source, drawn, wish, budget, context);
    if let Some((_, known)) = wish.graft {
        rounds.go_on_without(known);
    }
    let most = if wish.graft.is_some() { GRAFTED_ROUNDS } else { ROUNDS };
    for round in 0..most {
        if rounds.next(round, round + 1 == most)?.is_break() {
            break;
        }
    }
    rounds.outcome()
}

/// Quads that have not been fitted to the surface yet: those of most rounds need not be.
struct Smooth {
    made: Made,
    smoothing: Smoothing,
}

impl Smooth {
    /// Fits them, if they stay good.
    fn fitted(self, source: &Source, context: &Context) -> Result<Made> {
        let Smooth { mut made, smoothing } = self;
        let before = made.work.clone();
        let lost = |work: &Work| lost_features(work, source, NEAR).len();
        smoothing.fit(&mut made.work, source, context)?;
        if faults(&made.work, source).next().is_some() || lost(&made.work) > lost(&before) {
            made.work = before;
        }
        Ok(made)
    }
}

/// One layout after the other, until its quads will do.
struct Rounds<'a> {
    source: &'a Source,
    drawn: &'a Drawn,
    wish: &'a Wish<'a>,
    budget: &'a mut Budget,
    /// What was left of it at first.
    allowance: u64,
    context: &'a Context,
    sheet: Sheet,
    state: Vec<State>,
    /// Numbers of quads along the arcs of the first layout.
    numbers: Vec<i64>,
    /// Where features lost their shape, round by round.
    lost: Vec<Vec<(u32, DVec3)>>,
    /// The number that is asked of the layout, which only estimates patches without grids.
    aim: Option<f64>,
    /// The fewest bad patches, and the rounds since then.
    fewest: (usize, usize),
    /// The result nearest to the number so far, with how far it is off.
    nearest: Option<(f64, Smooth)>,
    /// What is there in any case, while patches with useless quads give way.
    spare: Option<Smooth>,
    refusal: Refusal,
}

impl<'a> Rounds<'a> {
    fn new(source: &'a Source, drawn: &'a Drawn, wish: &'a Wish, budget: &'a mut Budget, context: &'a Context) -> Self {
        Rounds {
            source,
            drawn,
            wish,
            allowance: budget.left(),
            budget,
            context,
            sheet: drawn.sheet.clone(),
            state: vec![State::Fresh; drawn.sheet.triangles.len()],
            numbers: Vec::new(),
            lost: Vec::new(),
            aim: wish.quads.map(|n| n as f64),
            fewest: (usize::MAX, 0),
            nearest: None,
            spare: None,
            refusal: Refusal::from("a patch could not be filled".to_string()),
        }
    }

    fn outcome(self) -> Result<Outcome> {
        match self.nearest.map(|n| n.1).or(self.spare) {
            Some(smooth) => smooth.fitted(self.source, self.context).map(Ok),
            None => Ok(Err(self.refusal)),
        }
    }

    fn give_up(&mut self, why: impl Into<String>) -> Result<ControlFlow<()>> {
        self.refusal.why = why.into();
        tracing::debug!(target: "carreau::quad", why = self.refusal.why, "given up");
        Ok(ControlFlow::Break(()))
    }

    /// One round; whether it is the last one.
    fn next(&mut self, round: usize, is_last: bool) -> Result<ControlFlow<()>> {
        if self.budget.is_spent() {
            return self.give_up(format!("{}, and there were too many attempts", self.refusal.why));
        }
        if self.wish.graft.is_some() {
            self.graft_often_lost();
        }
        let layout = match self.layout(round) {
            Ok(layout) => layout,
            Err(Trouble::Curves(curves)) => {
                let beside = self.beside(&curves.into_iter().collect());
                return match self.turn(&beside, State::Grafted) {
                    true => Ok(ControlFlow::Continue(())),
                    false => self.give_up("its features are others on rung 3"),
                };
            }
            Err(Trouble::All(why)) => return self.give_up(why),
        };
        let (sheet, source) = (&self.sheet, self.source);
        let donor = self.wish.graft.map(|graft| graft.0);
        let filled = fill(sheet, &layout, |v| place(sheet, &self.drawn.coarse, v), donor, self.context)?;
        let Filled { work, patch, kind, tracks } = match filled {
            Ok(filled) => filled,
            Err(unfilled) => return Ok(self.give_way(&layout, unfilled, &[])),
        };
        let mut work = settled(work, source);
        let mut smoothing = Smoothing::new(&mut work, source);
        let near = if round < TIGHT { SAG * NEAR } else { NEAR };
        // What is lost already need not be smoothed.
        if !is_last {
            let lost = lost_features(&work, source, near);
            if !lost.is_empty() {
                // Other numbers are of no use where the coarse triangles have lost it.
                if self.wish.graft.is_none() && self.lost.last() == Some(&lost) {
                    return self.give_up("its coarse triangles lose a feature");
                }
                self.note_lost(lost);
                return Ok(ControlFlow::Continue(()));
            }
        }
        smoothing.run(&mut work, source, self.context)?;
        self.budget.quads(work.faces.len());
        let mut bad = Vec::new();
        for fault in faults(&work, source) {
            self.refusal.why = told(&work, fault);
            bad.push(patch[fault.0] as usize);
        }
        let lost = lost_features(&work, source, near);
        let is_lost = !lost.is_empty();
        if is_lost && is_last && self.nearest.is_some() {
            return Ok(ControlFlow::Break(()));
        }
        if is_lost {
            self.note_lost(lost);
        }
        if !bad.is_empty() {
            return Ok(self.give_way(&layout, bad, &kind));
        }
        if is_lost && !is_last {
            return Ok(ControlFlow::Continue(()));
        }
        let useless = worst_shapes(&work).zip(&patch).filter(|(shape, _)| *shape < USELESS);
        let useless: Vec<usize> = useless.map(|(_, &p)| p as usize).collect();
        let rung = self.rungs(&layout, &work, &patch, &kind);
        let made = Made { work, rung, tracks, numbers: self.numbers.clone() };
        let smooth = Smooth { made, smoothing };
        if useless.is_empty() || self.spare.is_some() || self.nearest.is_some() {
            return Ok(self.take(smooth));
        }
        self.refusal.why = "a quad is as flat as a triangle".into();
        self.spare = Some(smooth);
        Ok(self.give_way(&layout, useless, &kind))
    }

    /// The layout with its numbers, or what speaks against it.
    fn layout(&mut self, round: usize) -> std::result::Result<Layout, Trouble> {
        let (source, wish, sheet) = (self.source, self.wish, &self.sheet);
        let sag = SAG * NEAR * source.diagonal;
        let is_fixed = |v: u32| place(sheet, &self.drawn.coarse, v) == Some(Place::Fixed);
        let mut layout =
            Layout::new(sheet, sag, is_fixed).ok_or_else(|| Trouble::from("its tracks do not enclose patches"))?;
        // Every patch has a quad at least: noise in a scan makes a field that no layout of this size follows.
        let wanted = wish.quads.map_or(source.area / wish.length.powi(2), |n| n as f64);
        if layout.patches.len() as f64 > MOST * wanted {
            return Err(format!("its layout has {} patches", layout.patches.len()).into());
        }
        let takes_none = |p: &Patch| p.triangles.iter().any(|&t| self.state[t as usize] != State::Fresh);
        layout.patches.iter_mut().filter(|p| takes_none(p)).for_each(|p| p.kind = Kind::Triangles);
        if let Some((donor, _)) = wish.graft {
            let is_taken = |t: u32| self.state[t as usize] == State::Grafted;
            donor.graft(sheet, &mut layout, is_taken).map_err(Trouble::Curves)?;
        }
        if wish.deals {
            find_bends(&mut layout.arcs, sheet, source, wish.length, is_fixed);
        }
        // Every edge of a feature is one of the four sides of a quad.
        layout.keep_features(sheet, source, wish.length, sag, 4.0 * MOST * wanted, wish.deals);
        layout.refine(sheet, &self.lost, wish.length);
        layout.tighten(sheet, wish.tight);
        quantise(&mut layout, wish, self.aim);
        self.budget.steps(layout.steps);
        if round == 0 {
            self.numbers = layout.arcs.iter().map(|arc| arc.count).collect();
            if self.numbers == wish.tried {
                return Err("smaller quads would change nothing".into());
            }
        }
        let count_of = |kind: Kind| layout.patches.iter().filter(|p| p.kind == kind).count();
        let [grids, patterns, others, grafted] =
            [Kind::Grid, Kind::Pattern, Kind::Triangles, Kind::Grafted].map(count_of);
        let dropped = self.drawn.traced.dropped;
        tracing::debug!(target: "carreau::quad", round, dropped, grids, patterns, others, grafted);
        let count = layout.quads();
        if wish.quads.is_some_and(|n| count > wish.most * n as f64) {
            return Err(format!("its features would need {count:.0} quads").into());
        }
        // No quad has more than four edges on arcs. An edge length may ask for more than the area does.
        let most = wish.quads.map_or(MOST * wanted.max(MANY), |n| wish.most * n as f64);
        let edges = layout.edges();
        if edges > 4.0 * most {
            return Err(format!("its arcs would have {edges:.0} edges").into());
        }
        Ok(layout)
    }

    /// The rung of every region.
    fn rungs(&self, layout: &Layout, work: &Work, patch: &[u32], kind: &[Kind]) -> Vec<u32> {
        let mut rung = vec![if self.wish.first { 1 } else { 2 }; self.source.regions];
        for (region, &p) in work.region.iter().zip(patch) {
            let first = layout.patches[p as usize].triangles[0];
            let own = self.state[first as usize].rung(kind[p as usize]);
            rung[*region as usize] = rung[*region as usize].max(own);
        }
        rung
    }

    /// Takes a result if it is nearer to the number than the one before, and goes on where it is not near enough.
    fn take(&mut self, smooth: Smooth) -> ControlFlow<()> {
        let count = smooth.made.work.faces.len() as f64;
        let off = self.wish.quads.map_or(0.0, |n| (count / n as f64).ln().abs());
        if self.nearest.as_ref().is_some_and(|n| off >= n.0) {
            return ControlFlow::Break(());
        }
        self.nearest = Some((off, smooth));
        if off < WITHIN {
            return ControlFlow::Break(());
        }
        self.aim = self.aim.zip(self.wish.quads).map(|(aim, n)| aim * n as f64 / count);
        ControlFlow::Continue(())
    }

    /// Features were lost.
    fn note_lost(&mut self, lost: Vec<(u32, DVec3)>) {
        let curves: FxHashSet<u32> = lost.iter().map(|l| l.0).collect();
        tracing::debug!(target: "carreau::quad", places = lost.len(), first = ?lost[0], ?curves, "features lost");
        self.refusal.regions = self.beside(&curves);
        self.lost.push(lost);
    }

    /// The regions beside curves.
    fn beside(&self, curves: &FxHashSet<u32>) -> Vec<u32> {
        let sheet = &self.sheet;
        let is_beside = |h: &u32| sheet.curve(*h).is_some_and(|curve| curves.contains(&curve));
        let all = (0..3 * sheet.triangles.len() as u32).filter(is_beside).map(|h| sheet.region[h as usize / 3]);
        all.collect::<BTreeSet<u32>>().into_iter().collect()
    }

    /// Bad patches take something else; ends where they have nothing left to take, or it has not helped for a while. `kinds` is
    /// what patches were filled with.
    fn give_way(&mut self, layout: &Layout, mut bad: Vec<usize>, kinds: &[Kind]) -> ControlFlow<()> {
        if self.nearest.is_some() {
            return ControlFlow::Break(());
        }
        bad.sort_unstable();
        bad.dedup();
        self.fewest = if bad.len() < self.fewest.0 { (bad.len(), 0) } else { (self.fewest.0, self.fewest.1 + 1) };
        let regions = self.regions_of(layout, &bad);
        self.refusal.regions.clone_from(&regions);
        tell(&self.sheet, layout, &bad, &self.refusal.why);
        let has_changed = if self.is_hasty() {
            self.turn(&regions, State::Grafted)
        } else {
            let is_stuck = self.fewest.1 > PATIENCE;
            let stuck = if is_stuck { bad } else { self.replace(layout, bad, kinds) };
            stuck.is_empty() || self.go_on_without(&self.regions_of(layout, &stuck))
        };
        if !has_changed {
            return ControlFlow::Break(());
        }
        open_holes(&mut self.sheet, |t| self.state[t as usize] == State::Grafted);
        ControlFlow::Continue(())
    }

    /// Quads of rung 3 are there to be taken, and there is not budget enough to look for better ones.
    fn is_hasty(&self) -> bool {
        self.wish.graft.is_some() && self.budget.left() < self.allowance / 2
    }

    fn regions_of(&self, layout: &Layout, patches: &[usize]) -> Vec<u32> {
        let region = |&p: &usize| self.sheet.region[layout.patches[p].triangles[0] as usize];
        patches.iter().map(region).collect::<BTreeSet<u32>>().into_iter().collect()
    }

    /// Bad grids and patterns make way for triangles, bad triangles for those of a larger patch. Returns the patches for which
    /// there is nothing larger.
    fn replace(&mut self, layout: &Layout, bad: Vec<usize>, kinds: &[Kind]) -> Vec<usize> {
        let mut stuck = Vec::new();
        for number in bad {
            let patch = &layout.patches[number];
            let triangles = &patch.triangles;
            let least = triangles.iter().map(|&t| self.state[t as usize]).fold(State::Grafted, State::min);
            let had_others = kinds.get(number).is_some_and(|&k| k != Kind::Triangles);
            let has_tracks = patch.loops.iter().flatten().any(|s| layout.arcs[s.arc as usize].curve.is_none());
            let next = match least {
                State::Grafted => None,
                _ if had_others => Some(State::Barred),
                State::Fresh | State::Barred if has_tracks => Some(State::Joined),
                _ => None,
            };
            let Some(next) = next else {
                stuck.push(number);
                continue;
            };
            if next == State::Joined {
                self.sheet.clear_around(triangles);
            }
            triangles.iter().for_each(|&t| self.state[t as usize] = next);
        }
        stuck
    }

    /// Regions lose their tracks; those that have none left take the quads of rung 3, if there are any. Returns whether
    /// anything has changed.
    fn go_on_without(&mut self, regions: &[u32]) -> bool {
        let mut has_changed = false;
        for region in regions {
            let (one, has_donor) = (std::slice::from_ref(region), self.wish.graft.is_some());
            has_changed |= self.share(*region) <= CLEARED && self.turn(one, State::Cleared)
                || has_donor && self.turn(one, State::Grafted);
        }
        has_changed
    }

    /// The share of the surface that a region has.
    fn share(&self, region: u32) -> f64 {
        let sheet = &self.sheet;
        let inside = (0..sheet.triangles.len() as u32).filter(|&t| sheet.region[t as usize] == region);
        inside.map(|t| sheet.area(t)).sum::<f64>() / self.source.area
    }

    /// Regions become what has no tracks: a patch of triangles, or quads of rung 3. Returns whether that changes any.
    fn turn(&mut self, regions: &[u32], next: State) -> bool {
        let is_new = |t: &u32| regions.contains(&self.sheet.region[*t as usize]) && self.state[*t as usize] < next;
        let inside: Vec<u32> = (0..self.sheet.triangles.len() as u32).filter(is_new).collect();
        inside.iter().for_each(|&t| self.state[t as usize] = next);
        let had_tracks = self.sheet.clear_around(&inside);
        let has_changed = had_tracks || next == State::Grafted && !inside.is_empty();
        if has_changed {
            self.fewest = (usize::MAX, 0);
        }
        has_changed
    }

    /// So do the regions beside features that were lost in many rounds; what was said of these is forgotten.
    fn graft_often_lost(&mut self) {
        let rounds = if self.is_hasty() { 1 } else { LOST };
        let mut times: FxHashMap<u32, usize> = FxHashMap::default();
        for round in &self.lost {
            let curves: FxHashSet<u32> = round.iter().map(|lost| lost.0).collect();
            curves.into_iter().for_each(|curve| *times.entry(curve).or_default() += 1);
        }
        let often: FxHashSet<u32> = times.into_iter().filter(|t| t.1 >= rounds).map(|t| t.0).collect();
        if !often.is_empty() {
            self.turn(&self.beside(&often), State::Grafted);
            self.lost.iter_mut().for_each(|round| round.retain(|lost| !often.contains(&lost.0)));
        }
    }
}

/// Says of bad patches what they are, for who looks for the reason.
fn tell(sheet: &Sheet, layout: &Layout, bad: &[usize], why: &str) {
    for patch in bad.iter().map(|&p| &layout.patches[p]) {
        let region = sheet.region[patch.triangles[0] as usize];
        let arc = |arc: u32| &layout.arcs[arc as usize];
        let counts: Vec<Vec<_>> = patch
            .sides
            .iter()
            .map(|side| side.iter().map(|s| (arc(s.arc).count, arc(s.arc).length / layout.length)).collect())
            .collect();
        tracing::debug!(target: "carreau::quad", why, kind = ?patch.kind, region, loops = patch.loops.len(), ?counts, "bad patch");
    }
}

/// Every vertex where it belongs: the sheet's features are chords of the source's.
fn settled(mut work: Work, source: &Source) -> Work {
    for v in 0..work.points.len() as u32 {
        work.points[v as usize] = work.put_back(source, v, work.points[v as usize]);
    }
    work
}

/// Chooses numbers of quads until their sum is the one aimed at. On rung 2, and where a patch would stay odd, all are even.
fn quantise(layout: &mut Layout, wish: &Wish, aim: Option<f64>) {
    let kinds: Vec<Kind> = layout.patches.iter().map(|p| p.kind).collect();
    let mut length = wish.length;
    let mut best = (f64::INFINITY, length);
    let (mut before, mut stuck) = (f64::INFINITY, 0usize);
    for run in 0..=RUNS {
        layout.patches.iter_mut().zip(&kinds).for_each(|(p, &kind)| p.kind = kind);
        if !wish.first || !layout.quantise(length) {
            layout.quantise_doubled(length);
        }
        let Some(aim) = aim else { return };
        let ratio = layout.quads() / aim;
        let off = ratio.ln().abs();
        if off < best.0 {
            best = (off, length);
        }
        if off < 0.02 || run == RUNS {
            return;
        }
        // Other lengths that change nothing: the features alone decide.
        stuck = if (before - ratio).abs() < STUCK * ratio { stuck + 1 } else { 0 };
        if off > WITHIN && stuck == UNMOVED {
            return;
        }
        before = ratio;
        // The last run takes the best length again.
        length = if run + 1 == RUNS { best.1 } else { length * ratio.sqrt() };
    }
}
