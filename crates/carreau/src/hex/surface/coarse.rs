//! The coarsest cells about a skeleton, pulled to the surface; then halved level by level and put onto it.

use super::prepared::{INSIDE, Ready};
use crate::context::Context;
use crate::error::Result;
use crate::geometry::distance::{DistanceOptions, compare};
use crate::hex::adapt::Lengths;
use crate::hex::assemble::BaseMesh;
use crate::hex::boundary::Skin;
use crate::hex::boundary_fit::{self, Rise, Seat};
use crate::hex::cells::{padded, valid_base};
use crate::hex::far_surface::reach;
use crate::hex::flat_sections;
use crate::hex::optimise::{INNER, Optimiser, PASSING};
use crate::hex::refine::TubeMesh;
use crate::hex::target::Target;
use crate::hex::tubes::warn_of_poor;
use crate::mesh::{SurfaceMesh, boundary_faces, split_quad};
use glam::DVec3;

/// Length, in radii, from which on segments are halved.
const UNEVEN: f64 = 3.0;
/// Most times that they are.
const EVENINGS: usize = 3;
/// Number of halvings of the cells after which segments are halved where the surface is far.
const FOLLOWED: u32 = 1;
/// Most times that they are.
const FOLLOWINGS: usize = 3;
/// Where a larger share of the boundary vertices could not be put onto the surface they are not looked after with the cells
/// around them.
const FEW_STUCK: f64 = 0.05;
/// Cells with vertices that cannot be put there are taken for so much farther from the surface.
const STUCK: f64 = 1.5;
/// Shares of its quality that a cell keeps when its vertices are put onto the surface, in attempt after attempt.
const KEPT_WHEN_SEATED: [f64; 2] = [0.4, 0.2];
/// How the boundary of the coarsest cells is compared with the surface.
pub(super) const COARSELY: DistanceOptions = DistanceOptions { samples: 10_000, refinements: 0, normals: false };
/// How the springs to the surface become stiff for the coarsest cells.
const FIRST: Rise = Rise { strength: [0.05, 100.0], rounds: 9, power: 1, iterations: 30 };
/// The same after each halving.
const NEXT: Rise = Rise { strength: [1.0, 100.0], rounds: 3, power: 2, iterations: 30 };
/// The same after the last one: what follows is stiff, and brings the boundary there, too.
const FINEST: Rise = Rise { rounds: 1, ..NEXT };
/// The same for vertices that are left off the surface.
const AGAIN: Rise = Rise { strength: [100.0, 1000.0], rounds: 2, power: 4, iterations: 25 };
/// The same at last.
const LAST: Rise = Rise { strength: [30.0, 1000.0], rounds: 4, power: 4, iterations: 20 };

/// The skeleton made ready, and the coarsest cells about it, drawn to the surface.
pub(super) struct Coarse {
    pub(super) ready: Ready,
    pub(super) tube: TubeMesh,
    /// Of its segments.
    pub(super) lengths: Lengths,
    /// Of the cells.
    pub(super) warnings: Vec<String>,
    /// Boundary vertices that cannot be put onto the surface.
    pub(super) left: usize,
    /// Whether these are so numerous that the shape is not made of tubes; then nothing else is tried.
    pub(super) is_hopeless: bool,
    /// The largest distance of the boundary from the surface: what spans the room between two branches shows here. Infinite
    /// where a cell is folded.
    pub(super) off: f64,
    /// Sum of the mean distances from the boundary to the surface and back: the less, the better the skeleton.
    pub(super) mean: f64,
    /// Whether segments were halved for their length.
    pub(super) is_even: bool,
    /// Vertices that are inside, or could not be put onto the surface; empty for the coarsest cells.
    pub(super) free: Vec<bool>,
}

impl Coarse {
    /// Less is better. Where a vertex of coarse cells cannot be put onto the surface, many of fine ones cannot.
    pub(super) fn score(&self) -> f64 {
        if self.left > 0 { STUCK * self.mean } else { self.mean }
    }

    /// Whether no cell is folded.
    pub(super) fn is_valid(&self) -> bool {
        self.off.is_finite()
    }

    pub(super) fn new(ready: Ready, target: &Target, context: &Context) -> Result<Self> {
        let base = valid_base(&ready.net, false, &[], context)?;
        Coarse::about(ready, &base, target, context)
    }

    /// Where there are `others` without a folded cell nothing comes of a base mesh that has one: its layer would be folded, too.
    pub(super) fn found(ready: Ready, target: &Target, others: bool, context: &Context) -> Result<Option<Self>> {
        let base = valid_base(&ready.net, false, &[], context)?;
        if others && !Optimiser::new(&base.points, &base.hexes).is_valid(&base.points) {
            return Ok(None);
        }
        Coarse::about(ready, &base, target, context).map(Some)
    }

    pub(super) fn about(ready: Ready, base: &BaseMesh, target: &Target, context: &Context) -> Result<Self> {
        let Ready { net, options, lid_of, evenly, .. } = &ready;
        let mut warnings = Vec::new();
        warn_of_poor(base, &mut warnings);
        let flat: Vec<bool> = lid_of.iter().map(|&lid| lid > 0).collect();
        let mut tube = padded(net, base, options, &flat, &PASSING, &[], context)?;
        flat_sections::stretch(&mut tube, net, target);
        // Segments much longer than thick, as those of a narrow fork are by the first-ring rule: their cells must reach into
        // the cleft between the tubes.
        let mut lengths = Lengths::new(net, INSIDE);
        let mut is_even = false;
        for _ in 0..EVENINGS {
            is_even |= *evenly && lengths.even_out(&mut tube, UNEVEN);
        }
        let _stage = context.stage("fit");
        let skin = Skin::new(&tube.hexes, &tube.caps, lid_of);
        let TubeMesh { points, hexes, .. } = &mut tube;
        let mut optimiser = Optimiser::new(points, hexes);
        boundary_fit::pull(&mut optimiser, points, &skin, target, &FIRST, context)?;
        let free = boundary_fit::snap(&optimiser, &mut points.clone(), &skin, target, KEPT_WHEN_SEATED[0]);
        let left = stuck(&free, &skin);
        let is_valid = optimiser.is_valid(points);
        let skin = skin_of(points, boundary_faces(hexes).into_iter().map(|f| f.0))?;
        let found = compare(&skin, target.surface(), &COARSELY, context)?;
        let off = if is_valid { found.a_to_b.distance.max } else { f64::INFINITY };
        let mean = if is_valid { found.a_to_b.distance.mean + found.b_to_a.distance.mean } else { f64::INFINITY };
        Ok(Coarse { ready, tube, lengths, warnings, left, is_hopeless: false, off, mean, is_even, free: Vec::new() })
    }

    /// Cells that are on the surface, where iterations cost little, are halved, level by level, and follow it.
    pub(super) fn fit(&mut self, target: &Target, context: &Context) -> Result<()> {
        let stage = context.stage("fit");
        let Coarse { tube, lengths, ready: Ready { options, lid_of, freely, shortest, .. }, .. } = self;
        let levels = options.refine_across().max(options.refine_along);
        let (mut left, mut is_hopeless) = (0, false);
        for level in 0..=levels {
            stage.step(level as usize, levels as usize + 1)?;
            if level > 0 {
                if level <= options.refine_across() {
                    tube.refine_across();
                }
                if level <= options.refine_along {
                    tube.refine_along(|_| true);
                }
            }
            if level > 0 {
                pull(tube, lid_of, target, if level == levels { &FINEST } else { &NEXT }, context)?;
            }
            // Finer cells than the coarsest show where these are too long, and do not cost much yet.
            let followings = if level == FOLLOWED.min(levels) && *freely { FOLLOWINGS } else { 0 };
            for _ in 0..followings {
                if !lengths.follow(tube, target, options.refine_across().saturating_sub(level), *shortest) {
                    break;
                }
                pull(tube, lid_of, target, &NEXT, context)?;
            }
            let skin = Skin::new(&tube.hexes, &tube.caps, lid_of);
            let TubeMesh { points, hexes, .. } = tube;
            let mut optimiser = Optimiser::new(points, hexes);
            if level == levels {
                boundary_fit::pull(&mut optimiser, points, &skin, target, &LAST, context)?;
                let mut free = Vec::new();
                for (attempt, kept) in KEPT_WHEN_SEATED.into_iter().enumerate() {
                    if attempt > 0 {
                        // What cannot be put onto the surface at once may have room when its neighbours are there.
                        optimiser.fix(free.iter().map(|f| !f).collect());
                        boundary_fit::pull(&mut optimiser, points, &skin, target, &AGAIN, context)?;
                        optimiser.fix(vec![false; free.len()]);
                    }
                    free = boundary_fit::snap(&optimiser, points, &skin, target, kept);
                    left = stuck(&free, &skin);
                    is_hopeless = left as f64 > FEW_STUCK * skin.len() as f64;
                    if left > 0 && !is_hopeless {
                        boundary_fit::seat(points, hexes, &skin, target, &mut free, Seat::Own, context)?;
                        left = stuck(&free, &skin);
                    }
                    if left == 0 || is_hopeless {
                        break;
                    }
                }
                optimiser.fix((0..free.len()).map(|v| skin.has(v)).collect());
                optimiser.tie(Vec::new());
                optimiser.run(points, &INNER, context)?;
                self.free = free;
            }
        }
        (self.left, self.is_hopeless) = (left, is_hopeless);
        Ok(())
    }

    /// What is not on the surface yet is put where that is closest; boundary vertices slide along it where cells are poor.
    pub(super) fn slide(&mut self, target: &Target, context: &Context) -> Result<()> {
        let _stage = context.stage("fit");
        self.put(&[Seat::Closest, Seat::Singly], target, context)?;
        let TubeMesh { points, hexes, caps, .. } = &mut self.tube;
        let skin = Skin::new(hexes, caps, &self.ready.lid_of);
        boundary_fit::slide(points, hexes, &skin, target, &self.free, context)
    }

    /// Better poor cells than vertices that are not on the surface.
    pub(super) fn put_rest(&mut self, target: &Target, context: &Context) -> Result<()> {
        let _stage = context.stage("fit");
        self.put(&[Seat::Poorly], target, context)
    }

    /// Puts boundary vertices onto the surface that are not there yet.
    pub(super) fn put(&mut self, seats: &[Seat], target: &Target, context: &Context) -> Result<()> {
        let TubeMesh { points, hexes, caps, .. } = &mut self.tube;
        let skin = Skin::new(hexes, caps, &self.ready.lid_of);
        for &seat in seats {
            if self.left > 0 {
                boundary_fit::seat(points, hexes, &skin, target, &mut self.free, seat, context)?;
                self.left = stuck(&self.free, &skin);
            }
        }
        Ok(())
    }

    /// The boundary takes the volume of the surface, as far as its vertices may leave that.
    pub(super) fn swell(&mut self, target: &Target) {
        let TubeMesh { points, hexes, caps, .. } = &mut self.tube;
        let skin = Skin::new(hexes, caps, &self.ready.lid_of);
        boundary_fit::swell(points, hexes, &skin, target, &self.free);
    }

    /// Boundary vertices go to where the surface is farther than a share of the diagonal.
    pub(super) fn reach(&mut self, target: &Target, farther: f64, context: &Context) -> Result<()> {
        let _stage = context.stage("fit");
        let TubeMesh { points, hexes, caps, .. } = &mut self.tube;
        let skin = Skin::new(hexes, caps, &self.ready.lid_of);
        let limit = farther * target.surface().diagonal();
        reach(points, hexes, &skin, target, &self.free, limit, context)
    }
}

/// Pulls the boundary of a mesh to the surface.
fn pull(tube: &mut TubeMesh, lid_of: &[u32], target: &Target, rise: &Rise, context: &Context) -> Result<()> {
    let skin = Skin::new(&tube.hexes, &tube.caps, lid_of);
    let mut optimiser = Optimiser::new(&tube.points, &tube.hexes);
    boundary_fit::pull(&mut optimiser, &mut tube.points, &skin, target, rise, context)
}

/// How many boundary vertices could not be put onto the surface, of those that were left free.
fn stuck(free: &[bool], skin: &Skin) -> usize {
    (0..free.len()).filter(|&v| free[v] && skin.has(v)).count()
}

/// Boundary faces as triangles.
pub(super) fn skin_of(points: &[DVec3], quads: impl Iterator<Item = [u32; 4]>) -> Result<SurfaceMesh> {
    let triangles: Vec<[u32; 3]> = quads.flat_map(|q| split_quad(points, q)).collect();
    SurfaceMesh::from_triangles(points.to_vec(), &triangles)
}
