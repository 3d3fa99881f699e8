//! Rungs 1 and 2: the motorcycle graph of a frame field divides the surface into patches.
//!
//! Rung 1: grids in patches with four sides that add up, patterns in the others. Rung 2: triangles of twice the size, paired
//! and halved, in patches that take neither. A patch whose quads are bad after smoothing takes triangles; where these are bad,
//! too, it is joined to its neighbours.

use super::budget::Budget;
use super::ceiling::worst_shapes;
use super::cut::open_holes;
use super::draw::{Drawn, draw, place};
use super::fill::{Filled, fill};
use super::layout::{Kind, Layout, Patch};
use super::lift::Tight;
use super::sheet::Sheet;
use super::smooth::Smoothing;
use super::source::Source;
use super::validate::{NEAR, faults, lost_features};
use super::work::{Place, Work};
use crate::context::Context;
use crate::error::Result;

/// Runs in search of a number of quads.
const RUNS: usize = 8;

/// Edges stay within this share of the distance at which a feature counts as kept; after this round it is enough that it
/// counts.
const SAG: f64 = 0.8;
const TIGHT: usize = 2;

/// Rounds in which patches with bad quads get triangles, and then lose their tracks.
const ROUNDS: usize = 8;
/// Rounds that leave no fewer bad patches before it is given up.
const PATIENCE: usize = 2;

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
    // What is there in any case, while patches with useless quads give way.
    let mut spare: Option<Made> = None;
    for round in 0..ROUNDS {
        if budget.is_spent() {
            why = format!("{why}, and there were too many attempts");
            break;
        }
        let place = |v: u32| place(&sheet, &coarse, v);
        let sag = SAG * NEAR * source.diagonal;
        let Some(mut layout) = Layout::new(&sheet, sag, |v| place(v) == Some(Place::Fixed)) else {
            return Ok(Err("its tracks do not enclose patches".into()));
        };
        // Every patch has a quad at least: noise in a scan makes a field that no layout of this size follows.
        let wanted = wish.quads.map_or(source.area / wish.length.powi(2), |n| n as f64);
        if layout.patches.len() as f64 > MOST * wanted {
            return Ok(Err(format!("its layout has {} patches", layout.patches.len())));
        }
        // Every edge of a feature is one of the four sides of a quad.
        let along = layout.arcs.iter().filter(|a| a.curve.is_some()).map(|a| a.length).sum::<f64>() / wish.length;
        if !(along <= 4.0 * MOST * wanted) {
            return Ok(Err(format!("its features are {along:.0} quads long")));
        }
        let takes_none = |p: &Patch| p.triangles.iter().any(|&t| state[t as usize] != State::Fresh);
        layout.patches.iter_mut().filter(|p| takes_none(p)).for_each(|p| p.kind = Kind::Triangles);
        layout.keep_features(&sheet, source, wish.length, sag);
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
            Err(patch) => bad.push(patch),
            Ok(Filled { work, patch, kind, tracks }) => {
                let mut work = settled(work, source);
                let smoothing = Smoothing::new(&mut work, source);
                let near = if round < TIGHT { SAG * NEAR } else { NEAR };
                let is_last = round + 1 == ROUNDS;
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
                        if kind[p as usize] == Kind::Triangles {
                            rung[*region as usize] = 2;
                        }
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
        tell(&layout, &bad, &why);
        if !give_way(&mut sheet, &layout, &bad, &kinds, &mut state) {
            break;
        }
        open_holes(&mut sheet);
    }
    Ok(nearest.map(|n| n.1).or(spare).ok_or(why))
}

/// Bad grids give way to triangles, bad triangles to those of a larger patch; `kinds` is what patches were filled with. False
/// where there is nothing larger.
fn give_way(sheet: &mut Sheet, layout: &Layout, bad: &[usize], kinds: &[Kind], state: &mut [State]) -> bool {
    for &number in bad {
        let triangles = &layout.patches[number].triangles;
        let least = triangles.iter().map(|&t| state[t as usize]).fold(State::Joined, State::min);
        let next = match least {
            _ if kinds.get(number).is_some_and(|&k| k != Kind::Triangles) => State::Barred,
            State::Joined => return false,
            _ => State::Joined,
        };
        if next == State::Joined && !sheet.clear_around(triangles) {
            return false;
        }
        triangles.iter().for_each(|&t| state[t as usize] = next);
    }
    true
}

/// Says of bad patches what they are, for who looks for the reason.
fn tell(layout: &Layout, bad: &[usize], why: &str) {
    for patch in bad.iter().map(|&p| &layout.patches[p]) {
        let arc = |arc: u32| &layout.arcs[arc as usize];
        let counts: Vec<Vec<_>> = patch
            .sides
            .iter()
            .map(|side| side.iter().map(|s| (arc(s.arc).count, arc(s.arc).length / layout.length)).collect())
            .collect();
        tracing::debug!(target: "carreau::quad", why, kind = ?patch.kind, ?counts, "bad patch");
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
