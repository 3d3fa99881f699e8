//! Rungs 1 and 2: the motorcycle graph of a frame field divides the surface into patches.
//!
//! Rung 1: grids in patches with four sides that add up, patterns in the others. Rung 2: triangles of twice the size, paired
//! and halved, in patches that take neither. A patch whose quads are bad after smoothing takes triangles; where these are bad,
//! too, it is joined to its neighbours. Where nothing comes of it, regions that make trouble lose all their tracks, and take a
//! grid or a pattern as one patch, or triangles: rung 3 for that region alone.

use super::budget::Budget;
use super::ceiling::worst_shapes;
use super::cut::open_holes;
use super::draw::{Drawn, draw, place};
use super::fill::{Filled, fill};
use super::layout::{Kind, Layout, Patch};
use super::lift::Tight;
use super::pins::pin;
use super::sheet::Sheet;
use super::smooth::Smoothing;
use super::source::Source;
use super::validate::{NEAR, faults, lost_features};
use super::work::{Place, Work};
use crate::context::Context;
use crate::error::Result;
use glam::DVec3;
use rustc_hash::FxHashSet;
use std::collections::{BTreeMap, BTreeSet};

/// Runs in search of a number of quads.
const RUNS: usize = 8;

/// Edges stay within this share of the distance at which a feature counts as kept; after this round it is enough that it
/// counts.
const SAG: f64 = 0.8;
const TIGHT: usize = 2;

/// Rounds in which patches with bad quads get triangles, and then lose their tracks.
const ROUNDS: usize = 8;
/// Further ones in which features that were cut short get more quads.
const LOSSES: usize = 6;
/// Rounds that leave no fewer bad patches before it is given up.
const PATIENCE: usize = 2;

/// Quads of a worse shape are of no use.
pub const USELESS: f64 = 0.02;

/// A region loses all its tracks at once where at least so many of its patches are bad, and this share of them.
const HOPELESS: (usize, f64) = (4, 0.3);

/// A feature that was cut short in so many rounds gets nodes at its bends.
const LOST: usize = 2;

/// What has become of a triangle of the sheet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum State {
    Fresh,
    /// Its patch takes neither a grid nor a pattern.
    Barred,
    /// Its patch was joined to its neighbours.
    Joined,
    /// Its region has no tracks: one patch, with corners by their angle.
    Cleared,
    /// It takes neither a grid nor a pattern.
    Meshed,
    /// Its holes are cut open.
    Opened,
}

impl State {
    fn takes_triangles(self) -> bool {
        !matches!(self, State::Fresh | State::Cleared)
    }

    /// The rung of a patch that was filled.
    fn rung(self, kind: Kind) -> u32 {
        match (self, kind) {
            (State::Fresh, Kind::Grid | Kind::Pattern) => 1,
            (State::Cleared | State::Meshed | State::Opened, Kind::Triangles) => 3,
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

/// What comes of it, or why nothing does.
pub type Outcome = std::result::Result<Made, String>;

/// What is wanted.
pub struct Wish<'a> {
    /// Length of the quads.
    pub length: f64,
    /// Their number; `None`: the length is what counts.
    pub quads: Option<usize>,
    /// More of them than so many times their number are of no interest.
    pub most: f64,
    /// Edges of the triangles that carry the field, over those of the quads.
    pub finer: f64,
    /// Rung 1 may do.
    pub first: bool,
    /// Regions that make trouble do without tracks, and features that were cut short get nodes at their bends: the last resort
    /// before rung 3 takes all.
    pub by_region: bool,
    /// Where quads were too far from the surface before.
    pub tight: &'a [Tight],
    /// Numbers that have been tried.
    pub tried: &'a [i64],
}

/// Quads as wished.
pub fn regular(
    source: &Source,
    wish: &Wish,
    feature_deg: f64,
    budget: &mut Budget,
    context: &Context,
) -> Result<Outcome> {
    let Drawn { coarse, mut sheet, traced, .. } =
        match draw(source, wish.length, wish.finer * wish.length, feature_deg, context)? {
            Ok(drawn) => drawn,
            Err(why) => return Ok(Err(why)),
        };
    budget.triangles(coarse.mesh.face_count());
    let mut state = vec![State::Fresh; sheet.triangles.len()];
    let mut numbers = Vec::new();
    // Where features lost their shape, round by round.
    let mut lost_places = Vec::new();
    let mut why = "a patch could not be filled".to_string();
    // The fewest bad patches, and the rounds since then.
    let mut fewest = (usize::MAX, 0);
    // The number that is asked of the layout, which only estimates patches without grids; and the nearest result so far.
    let mut aim = wish.quads.map(|n| n as f64);
    let mut nearest: Option<(f64, Made)> = None;
    // Vertices of the sheet at bends that are nodes, and the curves that they are on.
    let (mut pinned, mut sharp) = (FxHashSet::default(), FxHashSet::default());
    // What is there in any case, while patches with useless quads give way.
    let mut spare: Option<Made> = None;
    // Rounds in which features were cut short do not count as long as there are few.
    let losses = if wish.by_region { LOSSES } else { 0 };
    for round in 0..ROUNDS + losses {
        if round >= ROUNDS + lost_places.len().min(losses) {
            break;
        }
        let is_last = if wish.by_region { lost_places.len() >= losses } else { round + 1 == ROUNDS };
        if budget.is_spent() {
            why = format!("{why}, and there were too many attempts");
            break;
        }
        let often = if wish.by_region { often_lost(&mut lost_places, &mut sharp) } else { Vec::new() };
        for curve in often {
            pin(&mut sheet, source, curve, &mut pinned, &mut state);
        }
        let place = |v: u32| if pinned.contains(&v) { Some(Place::Fixed) } else { place(&sheet, &coarse, v) };
        let sag = SAG * NEAR * source.diagonal;
        let by_shape = |t: u32| state[t as usize] >= State::Cleared;
        let Some(mut layout) = Layout::new(&sheet, sag, |v| place(v) == Some(Place::Fixed), by_shape) else {
            return Ok(Err("its tracks do not enclose patches".into()));
        };
        // Every patch has a quad at least: noise in a scan makes a field that no layout of this size follows.
        let wanted = wish.quads.map_or(source.area / wish.length.powi(2), |n| n as f64);
        if layout.patches.len() as f64 > MOST * wanted {
            return Ok(Err(format!("its layout has {} patches", layout.patches.len())));
        }
        let takes_none = |p: &Patch| p.triangles.iter().any(|&t| state[t as usize].takes_triangles());
        layout.patches.iter_mut().filter(|p| takes_none(p)).for_each(|p| p.kind = Kind::Triangles);
        // Every edge of a feature is one of the four sides of a quad.
        layout.keep_features(&sheet, source, wish.length, sag, 4.0 * MOST * wanted);
        layout.refine(&sheet, &lost_places, wish.length);
        layout.tighten(&sheet, wish.tight);
        quantise(&mut layout, wish, aim);
        budget.steps(layout.steps);
        if round == 0 {
            numbers = layout.arcs.iter().map(|arc| arc.count).collect();
            if numbers == wish.tried {
                return Ok(Err("smaller quads would change nothing".into()));
            }
        }
        let count_of = |kind: Kind| layout.patches.iter().filter(|p| p.kind == kind).count();
        let [grids, patterns, others] = [Kind::Grid, Kind::Pattern, Kind::Triangles].map(count_of);
        tracing::debug!(target: "carreau::quad", round, dropped = traced.dropped, grids, patterns, others);
        let count = layout.quads();
        if wish.quads.is_some_and(|n| count > wish.most * n as f64) {
            why = format!("its features would need {count:.0} quads");
            break;
        }
        let (mut bad, mut kinds) = (Vec::new(), Vec::new());
        match fill(&sheet, &layout, place, context)? {
            Err(unfilled) => bad = unfilled,
            Ok(Filled { work, patch, kind, tracks }) => {
                let mut work = settled(work, source);
                let smoothing = Smoothing::new(&mut work, source);
                let near = if round < TIGHT { SAG * NEAR } else { NEAR };
                // What is lost already need not be smoothed.
                if !is_last {
                    let lost = lost_features(&work, source, near);
                    if !lost.is_empty() {
                        lost_places.push(lost);
                        continue;
                    }
                }
                smoothing.run(&mut work, source, context)?;
                budget.quads(work.faces.len());
                for (q, what) in faults(&work, source) {
                    why = format!("quad {q} {what}");
                    bad.push(patch[q] as usize);
                }
                let lost = lost_features(&work, source, near);
                let is_lost = !lost.is_empty() && !is_last;
                if !lost.is_empty() && !is_lost && nearest.is_some() {
                    break;
                }
                if is_lost {
                    lost_places.push(lost);
                }
                if bad.is_empty() && is_lost {
                    continue;
                }
                if bad.is_empty() {
                    let mut rung = vec![if wish.first { 1 } else { 2 }; source.regions];
                    for (region, &p) in work.region.iter().zip(&patch) {
                        let first = layout.patches[p as usize].triangles[0];
                        let own = state[first as usize].rung(kind[p as usize]);
                        rung[*region as usize] = rung[*region as usize].max(own);
                    }
                    let count = work.faces.len() as f64;
                    let useless = worst_shapes(&work).zip(&patch).filter(|(shape, _)| *shape < USELESS);
                    bad.extend(useless.map(|(_, &p)| p as usize));
                    let made = Made { work, rung, tracks, numbers: numbers.clone() };
                    if bad.is_empty() || spare.is_some() || nearest.is_some() {
                        let off = wish.quads.map_or(0.0, |n| (count / n as f64).ln().abs());
                        if nearest.as_ref().is_some_and(|n| off >= n.0) {
                            break;
                        }
                        nearest = Some((off, made));
                        if off < WITHIN {
                            break;
                        }
                        aim = aim.zip(wish.quads).map(|(aim, n)| aim * n as f64 / count);
                        continue;
                    }
                    why = "a quad is as flat as a triangle".into();
                    spare = Some(made);
                }
                kinds = kind;
            }
        }
        if nearest.is_some() {
            break;
        }
        bad.sort_unstable();
        bad.dedup();
        fewest = if bad.len() < fewest.0 { (bad.len(), 0) } else { (fewest.0, fewest.1 + 1) };
        if fewest.1 > PATIENCE {
            break;
        }
        tell(&sheet, &layout, &bad, &why);
        match give_way(&mut sheet, &layout, &bad, &kinds, &mut state, wish.by_region) {
            None => break,
            Some(regions) if regions > 0 => fewest = (usize::MAX, 0),
            Some(_) => {}
        }
        open_holes(&mut sheet, |t| matches!(state[t as usize], State::Cleared | State::Meshed));
    }
    Ok(nearest.map(|n| n.1).or(spare).ok_or(why))
}

/// Features that were lost in many rounds, each once; what was said of them is forgotten.
fn often_lost(rounds: &mut [Vec<(u32, DVec3)>], known: &mut FxHashSet<u32>) -> Vec<u32> {
    let mut count: BTreeMap<u32, usize> = BTreeMap::new();
    for round in rounds.iter() {
        let curves: BTreeSet<u32> = round.iter().map(|lost| lost.0).collect();
        curves.into_iter().for_each(|curve| *count.entry(curve).or_default() += 1);
    }
    let often = count.into_iter().filter(|(_, times)| *times >= LOST).map(|(curve, _)| curve);
    let often: Vec<u32> = often.filter(|&curve| known.insert(curve)).collect();
    rounds.iter_mut().for_each(|round| round.retain(|(curve, _)| !often.contains(curve)));
    often
}

/// Bad grids give way to triangles, bad triangles to those of a larger patch, and `by_region` to one patch for the whole region:
/// first with a grid or a pattern, then with triangles. `kinds` is what patches were filled with. Returns the number of
/// regions that lost their tracks; `None` where there is nothing larger.
fn give_way(
    sheet: &mut Sheet,
    layout: &Layout,
    bad: &[usize],
    kinds: &[Kind],
    state: &mut [State],
    by_region: bool,
) -> Option<usize> {
    let mut regions = if by_region { hopeless(sheet, layout, bad) } else { BTreeMap::new() };
    for &number in bad {
        let patch = &layout.patches[number];
        let (triangles, region) = (&patch.triangles, sheet.region[patch.triangles[0] as usize]);
        if regions.contains_key(&region) {
            continue;
        }
        let least = triangles.iter().map(|&t| state[t as usize]).fold(State::Opened, State::min);
        let had_others = kinds.get(number).is_some_and(|&k| k != Kind::Triangles);
        let has_tracks = patch.loops.iter().flatten().any(|s| layout.arcs[s.arc as usize].curve.is_none());
        let next = match least {
            State::Fresh | State::Barred | State::Joined if had_others => State::Barred,
            State::Fresh | State::Barred if has_tracks => State::Joined,
            State::Fresh | State::Barred | State::Joined if by_region => State::Cleared,
            State::Cleared if had_others => State::Meshed,
            State::Cleared | State::Meshed if patch.loops.len() > 1 => State::Opened,
            _ => return None,
        };
        if next >= State::Cleared {
            regions.insert(region, next);
            continue;
        }
        if next == State::Joined {
            sheet.clear_around(triangles);
        }
        triangles.iter().for_each(|&t| state[t as usize] = next);
    }
    for (&region, &next) in &regions {
        let of_region = |&t: &u32| sheet.region[t as usize] == region;
        let inside: Vec<u32> = (0..sheet.triangles.len() as u32).filter(of_region).collect();
        inside.iter().for_each(|&t| state[t as usize] = next);
        sheet.clear_around(&inside);
    }
    Some(regions.len())
}

/// The regions of which so many patches are bad that they are better off without tracks.
fn hopeless(sheet: &Sheet, layout: &Layout, bad: &[usize]) -> BTreeMap<u32, State> {
    let region_of = |p: &Patch| sheet.region[p.triangles[0] as usize];
    let mut count: BTreeMap<u32, [usize; 2]> = BTreeMap::new();
    layout.patches.iter().for_each(|p| count.entry(region_of(p)).or_default()[0] += 1);
    bad.iter().for_each(|&p| count.entry(region_of(&layout.patches[p])).or_default()[1] += 1);
    let is_hopeless = |&(_, [all, bad]): &(u32, [usize; 2])| bad >= HOPELESS.0 && bad as f64 >= HOPELESS.1 * all as f64;
    count.into_iter().filter(is_hopeless).map(|(region, _)| (region, State::Cleared)).collect()
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
