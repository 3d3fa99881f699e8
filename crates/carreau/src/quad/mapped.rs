//! Rung 1: quads by global parametrisation, put onto the surface, smoothed and looked at.

use super::attempts::{Attempts, or_why};
use super::collapse::collapse;
use super::lift::{far_vertices, quads_beyond};
use super::map::{QuadMap, WORKING_EDGES, Wish};
use super::regular::Made;
use super::smooth::Smoothing;
use super::source::Source;
use super::tried::{STRAYS, Tried, judged};
use super::work::Work;
use super::{lifted, take_back, validate};
use crate::context::Context;
use crate::error::Result;
use std::collections::BTreeSet;

/// How often quads are made of a map, smaller ones each time where some were no good; and the share of those before that may be
/// left for another time.
const REFINEMENTS: usize = 5;
const PROGRESS: f64 = 0.9;

impl Attempts<'_> {
    /// What comes of the map alone, if it is to be tried.
    pub fn of_map(&self, is_tried: bool, context: &Context) -> Result<Tried> {
        let mut tried = self.none();
        if is_tried {
            self.map(&mut tried, context)?;
        }
        Ok(tried)
    }

    /// Working mesh after working mesh, until the quads of one are useful. Features that are whole are the same on all of them:
    /// where the first one's come to nothing, so do the others'.
    pub fn map(&self, tried: &mut Tried, context: &Context) -> Result<()> {
        let is_whole = !self.source.edges.is_empty() && !self.source.fades;
        let count = if is_whole { 1 } else { WORKING_EDGES.len() };
        for &working in &WORKING_EDGES[..count] {
            match self.of_working_mesh(working, context)? {
                Ok(found) => tried.offer(found),
                Err(why) => {
                    tracing::debug!(target: "carreau::quad", working, why, "no map");
                    tried.refused = why;
                }
            }
            if tried.is_useful() {
                break;
            }
        }
        Ok(())
    }

    fn of_working_mesh(
        &self,
        working: f64,
        context: &Context,
    ) -> Result<std::result::Result<super::tried::Attempt, String>> {
        let source = self.source;
        let wish = Wish { length: self.length, quads: self.quads, working, feature_deg: self.feature_deg };
        let mut map = match or_why(QuadMap::new(source, &wish, context))? {
            Ok(map) => map,
            Err(why) => return Ok(Err(why)),
        };
        let mut work = match self.placed(&mut map, &wish, context)? {
            Ok(work) => work,
            Err(why) => return Ok(Err(why)),
        };
        let is_good = collapse(&mut work, source, context)?;
        tracing::debug!(target: "carreau::quad", is_good, quads = work.faces.len(), "collapsed");
        if is_good {
            fitted(&mut work, source, context)?;
        }
        let gap = lifted(&mut work, source, context)?;
        // Creases that fade out may be too short, or bend too much, for an edge of the quads.
        let refusal = if source.fades { validate::unsound } else { validate::refusal };
        if let Some(why) = refusal(&work, &work.to_mesh()?, source)? {
            return Ok(Err(why));
        }
        judged(source, Made::all_on(1, work, source), gap, self.quads, false, context).map(Ok)
    }

    /// Quads of the map on the surface, as even as they become; smaller ones where some are no good or leave a part out, as on
    /// limbs that are hardly wider than they are.
    fn placed(&self, map: &mut QuadMap, wish: &Wish, context: &Context) -> Result<std::result::Result<Work, String>> {
        let mut best: Option<(usize, Work)> = None;
        for _ in 0..REFINEMENTS {
            let mut work = match or_why(map.quads(wish, context))? {
                Ok(work) => work,
                Err(why) if best.is_none() => return Ok(Err(why)),
                Err(_) => break,
            };
            put_onto(&mut work, self);
            if let Some(why) = validate::topology_refusal(&work.to_mesh()?, self.source) {
                return Ok(Err(why.into()));
            }
            Smoothing::new(&mut work, self.source).run(&mut work, self.source, context)?;
            let no_good = validate::faults(&work, self.source).map(|(q, _)| q);
            let bad: BTreeSet<usize> = no_good.chain(quads_beyond(&work, self.source, STRAYS * self.length)).collect();
            tracing::debug!(target: "carreau::quad", bad = bad.len(), quads = work.faces.len(), "placed");
            map.refine(bad.iter().copied());
            let before = best.as_ref().map_or(usize::MAX, |b| b.0);
            if bad.len() < before {
                best = Some((bad.len(), work));
            }
            if bad.is_empty() || bad.len() as f64 > PROGRESS * before as f64 {
                break;
            }
        }
        Ok(best.map(|b| b.1).ok_or_else(String::new))
    }
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
fn put_onto(work: &mut Work, attempts: &Attempts) {
    for v in 0..work.points.len() as u32 {
        work.points[v as usize] = work.put_back(attempts.source, v, work.points[v as usize]);
    }
}
