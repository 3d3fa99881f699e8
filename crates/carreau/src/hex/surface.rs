//! Hexes of a tubular surface: its skeleton, the cells about it, and their boundary on the surface.

mod fitted;

use super::adapt::Lengths;
use super::fit::{self, Rise, Seat};
use super::optimise::{Optimiser, PASSING};
use super::reach::reach;
use super::refine::TubeMesh;
use super::resample::{self, Step};
use super::sew::BaseMesh;
use super::skin::Skin;
use super::target::Target;
use super::{HexOptions, HexResult, Stage, deliver, ends, judge, limit, meet, oval, padded, tips, web, zip};
use crate::context::Context;
use crate::error::{Error, Result};
use crate::geometry::distance::{DistanceOptions, compare};
use crate::mesh::{CurveNet, SurfaceMesh, UnitScale, boundary_faces, split_quad};
use crate::skeleton::{self, Closed, Reach, SkeletonOptions};
use glam::DVec3;
use rustc_hash::FxHashSet;

/// Steps along the branches, in radii, and levels of halving across and along, where no size is asked for.
const STEP: f64 = 1.2;
const ACROSS: u32 = 2;
const ALONG: u32 = 1;
/// There is less halving where it would make more hexes than these.
const MOST_UNASKED: f64 = 300_000.0;
/// Steps are at most this long, in radii, and cells at least this much longer than wide before they are made finer across.
const LONGEST: f64 = 1.6;
/// Segments longer than this, in radii, are halved, at most so many times.
const UNEVEN: f64 = 3.0;
const EVENINGS: usize = 3;
/// Segments are halved where the surface is far, when cells have been halved so often, and at most so many times.
const FOLLOWED: u32 = 1;
const FOLLOWINGS: usize = 3;
/// None becomes shorter than this, in radii.
const SHORTEST: f64 = 0.3;
/// No other cells are tried when so many have been made.
const MANY_TRIED: usize = 150_000;
/// Where the surface is farther than wanted the boundary reaches what is farther than this.
const REACHED: f64 = 0.01;
/// Where a larger share of the boundary vertices could not be put onto the surface they are not looked after with the cells
/// around them.
const FEW_STUCK: f64 = 0.05;
/// Branchings closer than this share of the sum of their radii become one: shares tried in turn, until the coarsest cells
/// can be put onto the surface. Tubes that leave a ball side by side part far from its centre, and branchings on the way
/// have no room for cells; but those of a tree do.
const MERGES: [f64; 4] = [1.0, 0.6, 1.4, 0.3];
/// Directions closer than this get a trunk, in degrees: both are tried with every share. Cells in wider forks have better
/// shapes, but limbs beside each other on a body are none.
const NARROW: [f64; 2] = [zip::CLOSE_DEGREES, zip::NARROW_DEGREES];
/// Cells with vertices that cannot be put there are taken for so much farther from the surface.
const STUCK: f64 = 1.5;
/// A boundary this near to the surface, as a share of the diagonal, needs no second try.
const WELL: f64 = 0.02;
/// How the boundary of the coarsest cells is compared with the surface.
const COARSELY: DistanceOptions = DistanceOptions { samples: 10_000, refinements: 0, normals: false };
/// Where a node is nearer to the surface than its neighbours let expect, its radius is this share of theirs.
const LEAST: f64 = 0.6;
/// Shares of its quality that a cell keeps when its vertices are put onto the surface, in attempt after attempt.
const KEPT: [f64; 2] = [0.4, 0.2];
/// The first cells take this share of the room about the skeleton.
const INSIDE: f64 = 0.85;

/// Meshes a surface; its skeleton is extracted where none is given.
///
/// # Errors
/// Those of [`skeleton::extract`] and [`super::from_net`]; [`Error::Input`] for a skeleton that lies outside; [`Error::Numeric`]
/// for cells that are farther from the surface than allowed, or lie where others are, unless `allow_far` is set.
pub fn from_surface(
    mesh: &SurfaceMesh,
    skeleton: Option<&CurveNet>,
    options: &HexOptions,
    context: &Context,
) -> Result<HexResult> {
    let mut result = meshed(mesh, skeleton, options, context)?;
    judge::accept(&mut result, options, mesh.diagonal())?;
    judge::tell(&mut result);
    Ok(result)
}

/// The mesh, not yet judged.
fn meshed(
    mesh: &SurfaceMesh,
    skeleton: Option<&CurveNet>,
    options: &HexOptions,
    context: &Context,
) -> Result<HexResult> {
    options.validate()?;
    let scale = UnitScale::of_mesh(mesh);
    if let Some(mesh) = scale.mesh(mesh, &[]) {
        let skeleton = skeleton.map(|net| scale.moved_net(net.clone()));
        let made = meshed(&mesh, skeleton.as_ref(), &options.in_scale(scale), context)?;
        return Ok(made.in_scale(scale.back()));
    }
    let (closed, net, mut warnings) = skeleton_of(mesh, skeleton, context)?;
    let closed = ends::told_apart(closed, &net)?;
    let target = Target::new(&closed);
    let mut tried: Vec<Coarse> = Vec::new();
    let (mut known, mut made): (Vec<CurveNet>, usize) = (Vec::new(), 0);
    for (merge, narrow) in MERGES.into_iter().flat_map(|merge| NARROW.map(|narrow| (merge, narrow))) {
        let ready = Ready::new(&net, [merge, narrow], &target, options, context)?;
        if known.contains(&ready.net) {
            continue;
        }
        known.push(ready.net.clone());
        let Some(cells) = Coarse::found(ready, &target, tried.iter().any(Coarse::is_valid), context)? else {
            continue;
        };
        tracing::debug!(
            merge,
            narrow,
            left = cells.left,
            off = cells.off,
            mean = cells.mean,
            segments = cells.ready.net.edges.len(),
            "coarse cells"
        );
        let fits = cells.left == 0 && cells.off < WELL * closed.mesh.diagonal();
        made += cells.tube.hexes.len();
        tried.push(cells);
        if fits || options.stage == Stage::Base || made > MANY_TRIED {
            break;
        }
    }
    tried.sort_by(|a, b| a.score().total_cmp(&b.score()));
    let coarse = fitted::best(tried, &closed, &target, context)?;
    let left = coarse.left;
    let Ready { net, options, lid_of, .. } = coarse.ready;
    let mut tube = coarse.tube;
    warnings.extend(coarse.ready.warnings.into_iter().chain(coarse.warnings));
    if left > 0 {
        warnings.push(format!("{left} boundary vertices could not be put onto the surface without folding a cell"));
    }
    if coarse.is_hopeless {
        warnings.push("the surface is not that of tubes about its skeleton".into());
    }
    tube.caps.iter_mut().filter(|c| **c > 0).for_each(|c| *c = lid_of[*c as usize - 1]);
    let mut result = deliver::with_boundary(tube, net, warnings, &options, context)?;
    deliver::certify(&mut result, &options)?;
    judge::measure(&mut result, &closed.mesh, &options, context)?;
    let numbered = (2..).zip(target.lids());
    result.flat_caps = numbered.filter(|(_, lid)| !lid.is_open).map(|(tag, _)| tag).collect();
    deliver::finish(&mut result, &options, Some(&target), context)?;
    Ok(result)
}

/// The skeleton made ready for cells.
#[derive(Clone)]
struct Ready {
    net: CurveNet,
    /// The options with the levels of halving that the size asks for.
    options: HexOptions,
    /// The lid of every end, from 1; zero for a round tip.
    lid_of: Vec<u32>,
    /// Whether no size is asked for.
    freely: bool,
    /// Whether long segments are halved.
    evenly: bool,
    /// Segments at which the surface is far do not become shorter than this, in radii.
    shortest: f64,
    warnings: Vec<String>,
}

impl Ready {
    fn new(net: &CurveNet, forks: [f64; 2], target: &Target, options: &HexOptions, context: &Context) -> Result<Self> {
        let _stage = context.stage("skeleton");
        let (mut net, mut options, mut warnings) = (net.clone(), options.clone(), Vec::new());
        let freely = options.hexes.is_none() && options.edge_length.is_none() && options.stage == Stage::Full;
        let lid_of_node = prepare(&mut net, forks, target, &mut options, &mut warnings)?;
        super::check_size(&net, &options)?;
        let lid_of = net.incidence().tips().map(|v| lid_of_node(&net, v)).collect();
        Ok(Ready { net, options, lid_of, freely, evenly: freely, shortest: SHORTEST, warnings })
    }
}

/// The skeleton made ready, and the coarsest cells about it, drawn to the surface.
struct Coarse {
    ready: Ready,
    tube: TubeMesh,
    /// Of its segments.
    lengths: Lengths,
    /// Of the cells.
    warnings: Vec<String>,
    /// Boundary vertices that cannot be put onto the surface.
    left: usize,
    /// These are so many that the shape is not made of tubes: nothing else is tried.
    is_hopeless: bool,
    /// The largest distance of the boundary from the surface: what spans the room between two branches shows here. Infinite
    /// where a cell is folded.
    off: f64,
    /// Sum of the mean distances from the boundary to the surface and back: the less, the better the skeleton.
    mean: f64,
    /// Whether segments were halved for their length.
    is_even: bool,
    /// Vertices that are inside, or could not be put onto the surface; empty for the coarsest cells.
    free: Vec<bool>,
}

impl Coarse {
    /// Less is better. Where a vertex of coarse cells cannot be put onto the surface, many of fine ones cannot.
    fn score(&self) -> f64 {
        if self.left > 0 { STUCK * self.mean } else { self.mean }
    }

    /// Whether no cell is folded.
    fn is_valid(&self) -> bool {
        self.off.is_finite()
    }

    fn new(ready: Ready, target: &Target, context: &Context) -> Result<Self> {
        let base = super::valid_base(&ready.net, false, &[], context)?;
        Coarse::about(ready, &base, target, context)
    }

    /// Where there are `others` without a folded cell nothing comes of a base mesh that has one: its layer would be folded, too.
    fn found(ready: Ready, target: &Target, others: bool, context: &Context) -> Result<Option<Self>> {
        let base = super::valid_base(&ready.net, false, &[], context)?;
        if others && !Optimiser::new(&base.points, &base.hexes).is_valid(&base.points) {
            return Ok(None);
        }
        Coarse::about(ready, &base, target, context).map(Some)
    }

    fn about(ready: Ready, base: &BaseMesh, target: &Target, context: &Context) -> Result<Self> {
        let Ready { net, options, lid_of, evenly, .. } = &ready;
        let mut warnings = Vec::new();
        super::warn_of_poor(base, &mut warnings);
        let flat: Vec<bool> = lid_of.iter().map(|&lid| lid > 0).collect();
        let mut tube = padded(net, base, options, &flat, &PASSING, &[], context)?;
        oval::stretch(&mut tube, net, target);
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
        fit::pull(&mut optimiser, points, &skin, target, &FIRST, context)?;
        let free = fit::snap(&optimiser, &mut points.clone(), &skin, target, KEPT[0]);
        let left = stuck(&free, &skin);
        let is_valid = optimiser.is_valid(points);
        let skin = skin_of(points, boundary_faces(hexes).into_iter().map(|f| f.0))?;
        let found = compare(&skin, target.surface(), &COARSELY, context)?;
        let off = if is_valid { found.a_to_b.distance.max } else { f64::INFINITY };
        let mean = if is_valid { found.a_to_b.distance.mean + found.b_to_a.distance.mean } else { f64::INFINITY };
        Ok(Coarse { ready, tube, lengths, warnings, left, is_hopeless: false, off, mean, is_even, free: Vec::new() })
    }

    /// Cells that are on the surface, where iterations cost little, are halved, level by level, and follow it.
    fn fit(&mut self, target: &Target, context: &Context) -> Result<()> {
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
                pull(tube, lid_of, target, &NEXT, context)?;
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
                fit::pull(&mut optimiser, points, &skin, target, &LAST, context)?;
                let mut free = Vec::new();
                for (attempt, kept) in KEPT.into_iter().enumerate() {
                    if attempt > 0 {
                        // What cannot be put onto the surface at once may have room when its neighbours are there.
                        optimiser.fix(free.iter().map(|f| !f).collect());
                        fit::pull(&mut optimiser, points, &skin, target, &AGAIN, context)?;
                        optimiser.fix(vec![false; free.len()]);
                    }
                    free = fit::snap(&optimiser, points, &skin, target, kept);
                    left = stuck(&free, &skin);
                    is_hopeless = left as f64 > FEW_STUCK * skin.len() as f64;
                    if left > 0 && !is_hopeless {
                        fit::seat(points, hexes, &skin, target, &mut free, Seat::Own, context)?;
                        left = stuck(&free, &skin);
                    }
                    if left == 0 || is_hopeless {
                        break;
                    }
                }
                optimiser.fix((0..free.len()).map(|v| skin.has(v)).collect());
                optimiser.tie(Vec::new());
                optimiser.run(points, &super::optimise::INNER, context)?;
                self.free = free;
            }
        }
        (self.left, self.is_hopeless) = (left, is_hopeless);
        Ok(())
    }

    /// What is not on the surface yet is put where that is closest; boundary vertices slide along it where cells are poor.
    fn slide(&mut self, target: &Target, context: &Context) -> Result<()> {
        let _stage = context.stage("fit");
        self.put(&[Seat::Closest, Seat::Singly], target, context)?;
        let TubeMesh { points, hexes, caps, .. } = &mut self.tube;
        let skin = Skin::new(hexes, caps, &self.ready.lid_of);
        fit::slide(points, hexes, &skin, target, &self.free, context)
    }

    /// Better poor cells than vertices that are not on the surface.
    fn put_rest(&mut self, target: &Target, context: &Context) -> Result<()> {
        let _stage = context.stage("fit");
        self.put(&[Seat::Poorly], target, context)
    }

    /// Puts boundary vertices onto the surface that are not there yet.
    fn put(&mut self, seats: &[Seat], target: &Target, context: &Context) -> Result<()> {
        let TubeMesh { points, hexes, caps, .. } = &mut self.tube;
        let skin = Skin::new(hexes, caps, &self.ready.lid_of);
        for &seat in seats {
            if self.left > 0 {
                fit::seat(points, hexes, &skin, target, &mut self.free, seat, context)?;
                self.left = stuck(&self.free, &skin);
            }
        }
        Ok(())
    }

    /// The boundary takes the volume of the surface, as far as its vertices may leave that.
    fn swell(&mut self, target: &Target) {
        let TubeMesh { points, hexes, caps, .. } = &mut self.tube;
        let skin = Skin::new(hexes, caps, &self.ready.lid_of);
        fit::swell(points, hexes, &skin, target, &self.free);
    }

    /// Boundary vertices go to where the surface is far.
    fn reach(&mut self, target: &Target, context: &Context) -> Result<()> {
        let _stage = context.stage("fit");
        let TubeMesh { points, hexes, caps, .. } = &mut self.tube;
        let skin = Skin::new(hexes, caps, &self.ready.lid_of);
        let limit = REACHED * target.surface().diagonal();
        reach(points, hexes, &skin, target, &self.free, limit, context)
    }
}

/// Pulls the boundary of a mesh to the surface.
fn pull(tube: &mut TubeMesh, lid_of: &[u32], target: &Target, rise: &Rise, context: &Context) -> Result<()> {
    let skin = Skin::new(&tube.hexes, &tube.caps, lid_of);
    let mut optimiser = Optimiser::new(&tube.points, &tube.hexes);
    fit::pull(&mut optimiser, &mut tube.points, &skin, target, rise, context)
}

/// How many boundary vertices could not be put onto the surface, of those that were left free.
fn stuck(free: &[bool], skin: &Skin) -> usize {
    (0..free.len()).filter(|&v| free[v] && skin.has(v)).count()
}

/// The surface closed, and a skeleton.
fn skeleton_of(
    mesh: &SurfaceMesh,
    given: Option<&CurveNet>,
    context: &Context,
) -> Result<(Closed, CurveNet, Vec<String>)> {
    match given {
        None => {
            // Round and open ends are met by the cells themselves.
            let found = skeleton::extract_with(mesh, &SkeletonOptions::default(), Reach::Sharp, context)?;
            Ok((found.closed, found.net, found.warnings))
        }
        Some(net) => {
            let (closed, mut warnings) = skeleton::prepared(mesh, context)?;
            let repaired = net.repaired(None)?;
            warnings.extend(repaired.warnings);
            Ok((closed, repaired.net, warnings))
        }
    }
}

/// Clean-up with the shares of branchings that become one and the angle of forks that get a trunk, resampling and the size
/// asked for; the answer says in which lid (from 1) a node lies, zero for none.
fn prepare(
    net: &mut CurveNet,
    [merge, narrow]: [f64; 2],
    target: &Target,
    options: &mut HexOptions,
    warnings: &mut Vec<String>,
) -> Result<impl Fn(&CurveNet, u32) -> u32 + use<>> {
    net.radii = net.points.iter().map(|&p| target.distance(p)).collect();
    if options.stage == Stage::Full {
        resample::prune(net, &FxHashSet::default());
        net.merge_branchings(|[a, b]| merge * (a + b));
        web::merge_webs(net, target);
    }
    let lids = tips::ready(net, target);
    let in_lids: Vec<(DVec3, u32)> = net.points.iter().zip(&lids).filter(|l| *l.1 > 0).map(|(p, l)| (*p, *l)).collect();
    let missed = target.lids().len() - in_lids.len();
    if missed > 0 {
        warnings.push(format!("{missed} open ends have no branch of the skeleton and were taken as wall"));
    }
    if options.stage == Stage::Full {
        meet::meet(net, target);
        meet::straighten_in_balls(net, target);
        zip::zip(net, narrow, zip::APART_DEGREES);
        super::check_steps(net, options)?;
        let round = tips_of(net).saturating_sub(in_lids.len());
        *net = sized(net, round, options);
        let around = net.incidence();
        for v in (0..net.points.len()).filter(|&v| around.valence(v as u32) != 1) {
            net.radii[v] = target.room(net.points[v]).max(LEAST * net.radii[v]);
        }
    } else {
        options.refine_across.get_or_insert(ACROSS);
    }
    net.radii.iter_mut().for_each(|r| *r *= INSIDE);
    limit::limit_radii(net);
    if net.edges.is_empty() {
        return Err(Error::input("the skeleton has no segment", "", "give a skeleton"));
    }
    Ok(move |net: &CurveNet, v: u32| in_lids.iter().find(|l| l.0 == net.points[v as usize]).map_or(0, |l| l.1))
}

fn tips_of(net: &CurveNet) -> usize {
    net.incidence().tips().count()
}

/// The net resampled to the size asked for, and the levels of halving that go with it; so many of its ends are `round`, with a
/// layer of cells.
fn sized(net: &CurveNet, round: usize, options: &mut HexOptions) -> CurveNet {
    if options.hexes.is_none() && options.edge_length.is_none() {
        let sized = resample::resample(net, Step::Eased(STEP, mean_radius(net)));
        if options.refine_across.is_none() && options.refine_along == 0 {
            let segments = sized.edges.len();
            for [across, along] in [[ACROSS, ALONG], [ACROSS, 0], [1, 0], [0, 0]] {
                (options.refine_across, options.refine_along) = (Some(across), along);
                if options.hexes_of(segments, round) <= MOST_UNASKED {
                    break;
                }
            }
        }
        options.refine_across.get_or_insert(ACROSS);
        return sized;
    }
    if let Some(length) = options.edge_length {
        let radius = mean_radius(net);
        let fits = (std::f64::consts::TAU * radius / (8.0 * length)).log2().round().clamp(0.0, 4.0) as u32;
        options.refine_across.get_or_insert(fits);
        let step = length * f64::from(1 << options.refine_along.min(6));
        return resample::resample(net, Step::Length(step));
    }
    let usual = mean_radius(net);
    let eased = |k: f64| Step::Eased(k, usual);
    let wanted = options.hexes.unwrap_or(usize::MAX) as f64;
    let levels: Vec<u32> = options.refine_across.map_or((0..=3).rev().collect(), |a| vec![a]);
    for across in levels {
        options.refine_across = Some(across);
        let fits = |n: &CurveNet| options.hexes_of(n.edges.len(), round) <= wanted;
        let longest = resample::resample(net, eased(LONGEST / f64::from(1 << across.min(2)) * 2.0));
        if fits(&longest) {
            return super::finest(net, eased, fits);
        }
    }
    super::finest(net, eased, |n| options.hexes_of(n.edges.len(), round) <= wanted)
}

/// Weighted by length.
fn mean_radius(net: &CurveNet) -> f64 {
    let sum = |f: &dyn Fn(usize) -> f64| (0..net.edges.len()).map(|e| f(e) * net.length(e)).sum::<f64>();
    let radius = |e: usize| net.edges[e].iter().map(|&v| 0.5 * net.radii[v as usize]).sum::<f64>();
    sum(&radius) / sum(&|_| 1.0)
}

const FIRST: Rise = Rise { strength: [0.05, 100.0], rounds: 9, power: 1, iterations: 30 };
const NEXT: Rise = Rise { strength: [1.0, 100.0], rounds: 3, power: 2, iterations: 30 };
const AGAIN: Rise = Rise { strength: [100.0, 1000.0], rounds: 2, power: 4, iterations: 25 };
const LAST: Rise = Rise { strength: [30.0, 1000.0], rounds: 4, power: 4, iterations: 25 };

/// Boundary faces as triangles.
fn skin_of(points: &[DVec3], quads: impl Iterator<Item = [u32; 4]>) -> Result<SurfaceMesh> {
    let triangles: Vec<[u32; 3]> = quads.flat_map(|q| split_quad(points, q)).collect();
    SurfaceMesh::from_triangles(points.to_vec(), &triangles)
}
