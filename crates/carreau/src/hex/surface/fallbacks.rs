//! Fallbacks for fitting hexes to the surface. The attempt with the smallest shortfall is returned.

use super::coarse::{COARSELY, Coarse, skin_of};
use super::prepared::Ready;
use super::tuning::MANY_TRIED;
use crate::context::Context;
use crate::error::{Error, Result};
use crate::geometry::distance::compare;
use crate::hex::cells::least_scaled_jacobian;
use crate::hex::judge::MAX_DISTANCE;
use crate::hex::refine::TubeMesh;
use crate::hex::target::Target;
use crate::mesh::boundary_faces;
use crate::skeleton::Closed;
use std::cell::OnceCell;

/// A result is good where the surface is this near to the boundary at most, and on average, and the boundary to the
/// surface, as shares of the diagonal, and no vertex is off the surface. Few samples tell it here: more of them find farther places,
/// and farther than [`MAX_DISTANCE`] is refused.
const WANTED: [f64; 3] = [0.0145, 0.001, 0.018];
/// Distance, both ways, as a share of the diagonal, from which the boundary reaches for the surface in what is good, too: it
/// costs little, and tubes of CAD are within 1 % then.
const NEAR_ENOUGH: f64 = 0.008;
/// Where the surface is farther than wanted the boundary reaches what is farther than this share of the diagonal; more would be
/// ragged.
const REACHED: f64 = 0.01;
/// The same in what is good.
const REACHED_IN_GOOD: f64 = 0.006;
/// Nothing that is good is refused.
const _: () = assert!(WANTED[0] < MAX_DISTANCE && WANTED[2] < MAX_DISTANCE);
/// Score of cells whose segments are not halved for their length, over that of those whose segments are, up to which the first are
/// taken: halved segments have flat cells, which may be in each other's way.
const NEARLY_AS_NEAR: f64 = 1.1;
/// Least scaled Jacobian of a good result.
const POOR_RESULT: f64 = 0.4;
/// Where short cells are poor no segment becomes shorter than this, in radii.
const LONGER: f64 = 0.6;
/// Shortfall of a mesh with a folded cell: more than that of all else.
const FOLDED: f64 = 100.0;
/// Shortfall of a mesh with vertices off the surface.
const OFF_SURFACE: f64 = 2.0;
/// Share of the boundary vertices off the surface that adds one to the shortfall.
const MANY_OFF: f64 = 0.01;
/// Cells this much farther from the surface than the nearest ones are a second try.
const SECOND: f64 = 1.25;

/// Fits the first cells, and where the result is not good others, too.
pub fn best(tried: Vec<Coarse>, closed: &Closed, target: &Target, context: &Context) -> Result<Coarse> {
    let by_facing = OnceCell::new();
    let mut tried = tried.into_iter();
    let Some(mut first) = tried.next() else { return Err(Error::Numeric("no cells were made".into())) };
    let score = first.score();
    let mut uneven = None;
    if first.is_even {
        let mut other = Coarse::new(Ready { evenly: false, ..first.ready.clone() }, target, context)?;
        tracing::debug!(
            left = first.left,
            mean = first.mean,
            uneven = other.left,
            uneven_mean = other.mean,
            "uneven cells"
        );
        if other.score() < NEARLY_AS_NEAR * first.score() {
            std::mem::swap(&mut first, &mut other);
        }
        uneven = Some(other);
    }
    let ready = first.ready.clone();
    let mut coarsely_left = first.left;
    let mut best = Fitted::new(first, target, context)?;
    let mut cells = best.cells.tube.hexes.len();
    let mut others: Vec<Fitted> = Vec::new();
    for other in Other::ALL {
        if best.lacks() == 0.0 || best.cells.is_hopeless || cells > MANY_TRIED {
            break;
        }
        let (next, target) = match other {
            Other::Facing => {
                let by_facing = by_facing.get_or_init(|| Target::new(closed).by_facing());
                (Some(Coarse::new(ready.clone(), by_facing, context)?), by_facing)
            }
            Other::Uneven => (uneven.take(), target),
            Other::Skeleton if best.cells.left > 0 => (tried.next().filter(|c| c.score() < SECOND * score), target),
            Other::Longer if best.is_poor() => {
                let ready = Ready { shortest: LONGER, ..best.cells.ready.clone() };
                (Some(Coarse::new(ready, best.target, context)?), best.target)
            }
            Other::Skeleton | Other::Longer => (None, target),
        };
        // Where coarse cells cannot be put onto the surface, fine ones hardly can.
        let Some(next) = next.filter(|c| best.cells.left > 0 || c.left <= coarsely_left) else { continue };
        let left = next.left;
        let mut fitted = Fitted::new(next, target, context)?;
        cells += fitted.cells.tube.hexes.len();
        if fitted.lacks() < best.lacks() {
            coarsely_left = left;
            std::mem::swap(&mut best, &mut fitted);
        }
        others.push(fitted);
    }
    if best.cells.is_hopeless {
        return Ok(best.cells);
    }
    let mut best = best_improved(best, others, context)?.reaching(context)?;
    best.cells.swell(best.target);
    Ok(best.cells)
}

/// What is tried where the first cells are not good.
#[derive(Clone, Copy)]
enum Other {
    /// Segments are not halved for their length, or they are: the ones that were not taken first.
    Uneven,
    /// The skeleton that came second, where vertices are off the surface.
    Skeleton,
    /// The surface is looked for by its facing.
    Facing,
    /// Segments at which the surface is far are halved less often, where cells are poor.
    Longer,
}

impl Other {
    const ALL: [Other; 4] = [Other::Uneven, Other::Skeleton, Other::Facing, Other::Longer];
}

/// The best, or the nearest of the others, when poor cells have been improved. That takes as long as following the surface, and
/// hardly changes distances: what misses more by these alone than the best in all cannot become better.
fn best_improved<'a>(best: Fitted<'a>, others: Vec<Fitted<'a>>, context: &Context) -> Result<Fitted<'a>> {
    let best = best.improved(context)?;
    let Some(nearest) = others.into_iter().min_by(|a, b| a.far_by().total_cmp(&b.far_by())) else { return Ok(best) };
    if nearest.far_by() >= best.lacks() {
        return Ok(best);
    }
    let nearest = nearest.improved(context)?;
    Ok(if nearest.lacks() < best.lacks() { nearest } else { best })
}

/// Cells that follow the surface, and what they are worth.
struct Fitted<'a> {
    cells: Coarse,
    /// What they are on.
    target: &'a Target<'a>,
    /// Whether poor cells have been improved.
    is_improved: bool,
    /// The largest distance of the surface from the boundary, the mean, and the largest of the boundary from the surface, as
    /// shares of the diagonal.
    far: [f64; 3],
    /// The least scaled Jacobian.
    least: f64,
}

impl<'a> Fitted<'a> {
    /// Cells that all are on the surface are improved, too.
    fn new(mut cells: Coarse, target: &'a Target<'a>, context: &Context) -> Result<Self> {
        cells.fit(target, context)?;
        let fitted = Fitted::measured(cells, target, context)?;
        if fitted.cells.left == 0 { fitted.improved(context) } else { Ok(fitted) }
    }

    /// The same with its poor cells improved, and vertices that are off the surface put onto it.
    fn improved(self, context: &Context) -> Result<Self> {
        if self.is_improved || self.cells.is_hopeless {
            return Ok(self);
        }
        let target = self.target;
        let improved = self.changed(|cells| cells.slide(target, context), context)?.complete(context)?;
        Ok(Fitted { is_improved: true, ..improved })
    }

    /// The same with the last vertices on the surface, too: better poor cells than that. They are improved once more.
    fn complete(mut self, context: &Context) -> Result<Self> {
        if self.cells.left == 0 {
            return Ok(self);
        }
        let target = self.target;
        self.cells.put_rest(target, context)?;
        let put = Fitted::measured(self.cells, target, context)?;
        put.changed(|cells| cells.slide(target, context), context)
    }

    fn measured(cells: Coarse, target: &'a Target<'a>, context: &Context) -> Result<Self> {
        let _stage = context.stage("fit");
        let TubeMesh { points, hexes, .. } = &cells.tube;
        let skin = skin_of(points, boundary_faces(hexes).into_iter().map(|f| f.0))?;
        let found = compare(target.surface(), &skin, &COARSELY, context)?;
        let diagonal = target.surface().diagonal().max(f64::MIN_POSITIVE);
        let far = [found.a_to_b.distance.max, found.a_to_b.distance.mean, found.b_to_a.distance.max];
        let least = least_scaled_jacobian(points, hexes);
        let fitted = Fitted { far: far.map(|d| d / diagonal), least, cells, target, is_improved: false };
        tracing::debug!(left = fitted.cells.left, far = ?fitted.far, least, lacks = fitted.lacks(), "fitted cells");
        Ok(fitted)
    }

    /// The same where the boundary reaches what of the surface is far from it, and its faces do not span what is hollow, if that is
    /// better: where distances miss what is wanted, and then in what is good as far as CAD tubes need.
    fn reaching(self, context: &Context) -> Result<Self> {
        // Of a size asked for cells are as coarse as that.
        if !self.cells.ready.freely {
            return Ok(self);
        }
        let target = self.target;
        let is_far = self.far[0] > WANTED[0] || self.far[2] > WANTED[2];
        let reached = match is_far {
            true => self.changed(|cells| cells.reach(target, REACHED, context), context)?,
            false => self,
        };
        if reached.lacks() > 0.0 || reached.farthest() <= NEAR_ENOUGH {
            return Ok(reached);
        }
        reached.changed(|cells| cells.reach(target, REACHED_IN_GOOD, context), context)
    }

    /// The same after a change, if that is better.
    fn changed(mut self, change: impl FnOnce(&mut Coarse) -> Result<()>, context: &Context) -> Result<Self> {
        let (before, far, least) = (self.rank(), self.far, self.least);
        let (points, free, left) = (self.cells.tube.points.clone(), self.cells.free.clone(), self.cells.left);
        change(&mut self.cells)?;
        let mut changed = Fitted::measured(self.cells, self.target, context)?;
        if changed.rank() >= before {
            (changed.far, changed.least) = (far, least);
            (changed.cells.tube.points, changed.cells.free, changed.cells.left) = (points, free, left);
        }
        Ok(changed)
    }

    /// Whether cells have poor shapes, or would have them with all vertices on the surface; finer ones may be the reason.
    fn is_poor(&self) -> bool {
        self.cells.ready.freely && (self.least < POOR_RESULT || self.cells.left > 0)
    }

    /// The larger of both distances.
    fn farthest(&self) -> f64 {
        self.far[0].max(self.far[2])
    }

    /// Less is better: what misses as little is the better the nearer it is.
    fn rank(&self) -> [f64; 2] {
        [self.lacks(), self.farthest()]
    }

    /// By how much distances miss what is wanted, zero for not at all: each counts by the share that is too much.
    fn far_by(&self) -> f64 {
        self.far.iter().zip(WANTED).map(|(d, wanted)| (d / wanted - 1.0).max(0.0)).sum()
    }

    /// By how much the cells miss what is wanted in all.
    fn lacks(&self) -> f64 {
        let off = self.cells.left as f64 / self.cells.tube.points.len() as f64;
        let poor = (1.0 - self.least / POOR_RESULT).max(0.0);
        let folded = if self.least > 0.0 { 0.0 } else { FOLDED };
        self.far_by() + poor + folded + if self.cells.left > 0 { OFF_SURFACE + off / MANY_OFF } else { 0.0 }
    }
}
