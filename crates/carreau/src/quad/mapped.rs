//! Rung 1: quads by global parametrisation, put onto the surface, smoothed and looked at.

use super::coarse::Coarse;
use super::collapse::{collapse, no_good, smooth_around};
use super::judged::{Judged, USELESS_STRAYING};
use super::lift::{far_vertices, quads_beyond};
use super::map::{QuadMap, WORKING_EDGES, Wish, working_mesh};
use super::release::release;
use super::smooth::Smoothing;
use super::source::Source;
use super::work::Work;
use super::{NUMBER_WITHIN, QuadOptions, lifted, off, take_back, validate};
use crate::context::Context;
use crate::error::{Error, Result};
use std::collections::BTreeSet;

/// A count: how often quads are made of a map at most, smaller ones each time because some were no good.
const MAPPED_ATTEMPTS: usize = 6;
/// A count: how often that is for all working meshes together, but once for each, because the first ones show what there is
/// to gain.
pub const ALL_ATTEMPTS: usize = 9;
/// A count: working meshes after which what will do is taken, because what keeps it from being better is the number of quads.
const ENOUGH_MESHES: usize = 2;
/// A share of the faults before: an attempt that leaves more is the last, because smaller quads are of little use
/// there.
const FAULTS_LEFT: f64 = 0.9;
/// A count of quads that are too far from the surface: one that is turned over counts as so many, because it is refused
/// where it stays so.
const TURNED_FAULTS: usize = 10;

/// A count: how often creases are let go at most, because the quads beside those that went may be in the way of others.
const RELEASES: usize = 3;

/// What a stage gives, or why it gives nothing.
type OrWhy<T> = std::result::Result<T, String>;

/// What has come of the map.
#[derive(Default)]
pub struct OfMap {
    pub best: Option<Judged>,
    /// Why nothing came of the last working mesh that gave nothing.
    pub refused: String,
}

impl OfMap {
    pub fn will_do(&self) -> bool {
        self.best.as_ref().is_some_and(Judged::will_do)
    }

    /// Field after field of a working mesh, until the quads of one will do.
    fn add_fields(
        &mut self,
        source: &Source,
        coarse: &Coarse,
        wish: &Wish,
        left: &mut usize,
        context: &Context,
    ) -> Result<()> {
        let asked = source.guidance.curvature;
        for curvature in [asked, 0.0].into_iter().take(if asked > 0.0 { 2 } else { 1 }) {
            match of_field(source, coarse, curvature, wish, left, context)? {
                Ok(found) if self.best.as_ref().is_none_or(|b| found.worth() < b.worth()) => self.best = Some(found),
                Ok(_) => {}
                Err(why) => {
                    tracing::debug!(target: "carreau::quad", working = wish.working, curvature, why, "no map");
                    self.refused = why;
                }
            }
            if self.will_do() {
                break;
            }
        }
        Ok(())
    }
}

/// Working mesh after working mesh, until the quads of one are useful. Each has two fields where the directions of curvature
/// are to draw them: the smoothest one, which has fewer singularities, is the second.
pub fn quads(source: &Source, options: &QuadOptions, context: &Context) -> Result<OfMap> {
    let (length, quads) = match options.edge_length {
        Some(length) => (length, None),
        None => ((source.area / options.quads as f64).sqrt(), Some(options.quads)),
    };
    let feature_deg = options.features.angle_deg.unwrap_or(180.0);
    let (mut of_map, mut left) = (OfMap::default(), options.attempts);
    // Creases of a scan that leave no room on two of them leave none on a third.
    let meshes = if source.is_noisy { ENOUGH_MESHES } else { WORKING_EDGES.len() };
    for (mesh, working) in WORKING_EDGES.into_iter().take(meshes.min(options.attempts)).enumerate() {
        let wish = Wish { length, quads, working, feature_deg };
        match or_why(working_mesh(source, &wish, context))? {
            Ok(coarse) => of_map.add_fields(source, &coarse, &wish, &mut left, context)?,
            Err(why) => of_map.refused = why,
        }
        let is_met = of_map.best.as_ref().is_some_and(|b| b.is_useful() && b.meets_number);
        if is_met || mesh + 1 >= ENOUGH_MESHES && of_map.will_do() {
            break;
        }
    }
    if of_map.best.as_ref().is_some_and(|b| b.loses) {
        of_map.refused = "its quads lose some of the features".into();
    }
    Ok(of_map)
}

fn of_field(
    source: &Source,
    coarse: &Coarse,
    curvature: f64,
    wish: &Wish,
    left: &mut usize,
    context: &Context,
) -> Result<OrWhy<Judged>> {
    let mut map = match or_why(QuadMap::new(source, coarse, curvature, wish, context))? {
        Ok(map) => map,
        Err(why) => return Ok(Err(why)),
    };
    let mut work = match placed(source, &mut map, wish, left, context)? {
        Ok(work) => work,
        Err(why) => return Ok(Err(why)),
    };
    let is_good = collapse(&mut work, source, context)?;
    tracing::debug!(target: "carreau::quad", is_good, quads = work.faces.len(), "collapsed");
    if is_good {
        fitted(&mut work, source, context)?;
    }
    let gap = lifted(&mut work, source, context)?;
    if let Some(why) = validate::unsound(&work, &work.to_mesh()?, source)? {
        return Ok(Err(why));
    }
    Judged::new(work, source, gap, wish.quads, context).map(Ok)
}

/// What cannot be computed is for another working mesh, or another method.
fn or_why<T>(result: Result<OrWhy<T>>) -> Result<OrWhy<T>> {
    match result {
        Err(Error::Numeric(why)) => Ok(Err(why)),
        other => other,
    }
}

/// Quads of the map on the surface, as even as they become; smaller ones where some are no good or leave a part out, as on
/// limbs that are hardly wider than they are. `left`: the attempts that are left for all working meshes.
fn placed(source: &Source, map: &mut QuadMap, wish: &Wish, left: &mut usize, context: &Context) -> Result<OrWhy<Work>> {
    let mut best: OrWhy<((bool, usize), Work)> = Err(String::new());
    for attempt in 0..MAPPED_ATTEMPTS {
        if attempt > 0 && *left == 0 {
            break;
        }
        *left = left.saturating_sub(1);
        let mut work = match or_why(map.quads(wish, context))? {
            Ok(work) => work,
            Err(why) => return Ok(best.map(|b| b.1).map_err(|_| why)),
        };
        put_onto(&mut work, source);
        if let Some(why) = validate::topology_refusal(&work.to_mesh()?, source) {
            return Ok(Err(why.into()));
        }
        Smoothing::new(&mut work, source).run(&mut work, source, context)?;
        let_go(&mut work, source, context)?;
        let mut bad: BTreeSet<usize> = validate::faults(&work, source).map(|(q, _)| q).collect();
        let (no_good, lost) = (bad.len(), lost_curves(&work, source));
        bad.extend(quads_beyond(&work, source, USELESS_STRAYING * wish.length));
        tracing::debug!(target: "carreau::quad", no_good, bad = bad.len(), lost = lost.len(), quads = work.faces.len(), "placed");
        map.refine(bad.iter().copied());
        lost.iter().for_each(|&curve| map.lengthen(curve));
        let misses = wish.quads.is_some_and(|n| off(work.faces.len(), n) > NUMBER_WITHIN);
        let faults = TURNED_FAULTS * no_good + bad.len() - no_good + lost.len();
        let (now, before) = ((misses, faults), best.as_ref().map_or((true, usize::MAX), |b| b.0));
        if now < before {
            best = Ok((now, work));
        }
        // A curve may need several edges more before any part of it is found again.
        if now.1 == 0 || lost.is_empty() && now.1 as f64 > FAULTS_LEFT * before.1 as f64 {
            break;
        }
    }
    Ok(best.map(|b| b.1))
}

/// Lets creases go that leave no room for good quads, and smooths around them.
fn let_go(work: &mut Work, source: &Source, context: &Context) -> Result<()> {
    // Of parts nothing may go: their quads are not looked at for it.
    for _ in 0..if source.may_lose_creases { RELEASES } else { 0 } {
        let (bad, _) = no_good(work, source);
        let free = release(work, source, &bad);
        if free.is_empty() {
            break;
        }
        tracing::debug!(target: "carreau::quad", bad = bad.len(), free = free.len(), "creases let go");
        smooth_around(work, source, free, context)?;
    }
    Ok(())
}

/// Curves that ask for edges and are not kept as a whole.
fn lost_curves(work: &Work, source: &Source) -> Vec<usize> {
    let lost = validate::lost(work, source);
    (0..lost.len()).filter(|&curve| lost[curve].length > 0.0 && source.asks_for_edges(curve)).collect()
}

/// Takes quads that are too far from the surface nearer to it, as long as none is turned over for it.
fn fitted(work: &mut Work, source: &Source, context: &Context) -> Result<()> {
    let is_far = far_vertices(work, source);
    if !is_far.contains(&true) {
        return Ok(());
    }
    let before = work.points.clone();
    Smoothing::new(work, source).fit_some(work, source, &is_far, context)?;
    take_back(work, &before, source);
    Ok(())
}

/// Vertices of the map are on the working mesh: they go to where they belong.
fn put_onto(work: &mut Work, source: &Source) {
    for v in 0..work.points.len() as u32 {
        work.points[v as usize] = work.put_back(source, v, work.points[v as usize]);
    }
}
