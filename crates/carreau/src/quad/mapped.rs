//! Rung 1: quads by global parametrisation, put onto the surface, smoothed and looked at.

use super::attempts::{Attempts, or_why};
use super::lift::far_vertices;
use super::map::{WORKING_EDGES, Wish, quads_of_map};
use super::regular::Made;
use super::smooth::Smoothing;
use super::source::Source;
use super::tried::{Tried, judged};
use super::work::Work;
use super::{LEFT_OUT, LOST, lifted, take_back, validate};
use crate::context::Context;
use crate::error::Result;

impl Attempts<'_> {
    /// Working mesh after working mesh, until the quads of one are useful. Features are the same on all of them: where the first
    /// one's come to nothing, so do the others'.
    pub fn map(&self, tried: &mut Tried, context: &Context) -> Result<()> {
        let count = if self.source.edges.is_empty() { WORKING_EDGES.len() } else { 1 };
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
        let mut work = match or_why(quads_of_map(source, &wish, context))? {
            Ok(work) => work,
            Err(why) => return Ok(Err(why)),
        };
        put_onto(&mut work, self);
        if let Some(why) = validate::topology_refusal(&work.to_mesh()?, source) {
            return Ok(Err(why.into()));
        }
        smoothed(&mut work, source, context)?;
        let gap = lifted(&mut work, source, context)?;
        if let Some(why) = validate::refusal(&work, &work.to_mesh()?, source)? {
            return Ok(Err(why));
        }
        let found = judged(source, Made::all_on(1, work, source), gap, self.quads, false, context)?;
        Ok(if found.strays > LOST { Err(LEFT_OUT.into()) } else { Ok(found) })
    }
}

/// Makes quads even, and takes those that are too far from the surface nearer to it, as long as none is turned over for it.
pub fn smoothed(work: &mut Work, source: &Source, context: &Context) -> Result<()> {
    let mut smoothing = Smoothing::new(work, source);
    smoothing.run(work, source, context)?;
    let is_far = far_vertices(work, source);
    if !is_far.contains(&true) || validate::faults(work, source).next().is_some() {
        return Ok(());
    }
    let before = work.points.clone();
    smoothing.fit_some(work, source, &is_far, context)?;
    take_back(work, &before, source);
    Ok(())
}

/// Vertices of the map are on the working mesh: they go to where they belong.
fn put_onto(work: &mut Work, attempts: &Attempts) {
    for v in 0..work.points.len() as u32 {
        work.points[v as usize] = work.put_back(attempts.source, v, work.points[v as usize]);
    }
}
