//! Prepares the skeleton of a surface for meshing: extracted or given, cleaned up, led to the ends, resampled for the
//! size asked for.

use super::joining::Joining;
use crate::context::Context;
use crate::error::{Error, Result};
use crate::hex::choices::Stage;
use crate::hex::options::{HexOptions, check_size, check_steps};
use crate::hex::resample::{self, Step};
use crate::hex::size::finest;
use crate::hex::target::Target;
use crate::hex::{fork_trunks, hubs, junction_centres, ring_room, tips, webs};
use crate::mesh::{CurveNet, SurfaceMesh};
use crate::skeleton::{self, Closed, Reach, SkeletonOptions};
use glam::DVec3;
use rustc_hash::FxHashSet;

/// Step along the branches, in radii, where no size is asked for.
const SURFACE_STEP: f64 = 1.2;
/// Levels of halving across where no size is asked for.
const ACROSS: u32 = 2;
/// Levels of halving along where no size is asked for.
const ALONG: u32 = 1;
/// There is less halving where it would make more hexes than these.
const MOST_UNASKED: f64 = 300_000.0;
/// Steps are at most this long, in radii, and cells at least this much longer than wide before they are made finer across.
const LONGEST_RATIO: f64 = 1.6;
/// None becomes shorter than this, in radii.
const SHORTEST: f64 = 0.3;
/// Where a node is nearer to the surface than its neighbours let expect, its radius is this share of theirs.
const LEAST_RADIUS: f64 = 0.6;
/// The first cells take this share of the room about the skeleton.
pub(super) const INSIDE: f64 = 0.85;

/// The skeleton made ready for cells.
#[derive(Clone)]
pub(super) struct Ready {
    pub(super) net: CurveNet,
    /// The options with the levels of halving that the size asks for.
    pub(super) options: HexOptions,
    /// The lid of every end, from 1; zero for a round tip.
    pub(super) lid_of: Vec<u32>,
    /// Whether no size is asked for.
    pub(super) freely: bool,
    /// Whether long segments are halved.
    pub(super) evenly: bool,
    /// Segments at which the surface is far do not become shorter than this, in radii.
    pub(super) shortest: f64,
    pub(super) warnings: Vec<String>,
}

impl Ready {
    pub(super) fn new(
        net: &CurveNet,
        joining: Joining,
        narrow: f64,
        target: &Target,
        options: &HexOptions,
        context: &Context,
    ) -> Result<Self> {
        let _stage = context.stage("skeleton");
        let (mut net, mut options, mut warnings) = (net.clone(), options.clone(), Vec::new());
        let freely = options.hexes.is_none() && options.edge_length.is_none() && options.stage == Stage::Full;
        let lid_of_node = clean_up_for_surface(&mut net, joining, narrow, target, &mut options, &mut warnings)?;
        check_size(&net, &options)?;
        let lid_of = net.incidence().tips().map(|v| lid_of_node(&net, v)).collect();
        Ok(Ready { net, options, lid_of, freely, evenly: freely, shortest: SHORTEST, warnings })
    }
}

/// A skeleton of the surface, and what is to be said of it and of the surface.
pub(super) type Known = (CurveNet, Vec<String>);

/// The surface closed, and its skeletons: the given one; or that of the flow, which knows any tubes, and the axes of straight ones, where
/// these are short.
pub(super) fn skeletons_of(
    mesh: &SurfaceMesh,
    given: Option<&CurveNet>,
    context: &Context,
) -> Result<(Closed, Vec<Known>)> {
    let (closed, mut warnings) = skeleton::prepared(mesh, context)?;
    if let Some(net) = given {
        let repaired = net.repaired(None)?;
        warnings.extend(repaired.warnings);
        return Ok((closed, vec![(repaired.net, warnings)]));
    }
    let mut all: Vec<Known> = skeleton::straight_net(&closed).map(|net| (net, warnings)).into_iter().collect();
    // Round and open ends are met by the cells themselves.
    match skeleton::extract_with(mesh, &SkeletonOptions::default(), Reach::Sharp, context) {
        Ok(found) => all.push((found.net, found.warnings)),
        Err(e) if all.is_empty() || !is_of_shape(&e) => return Err(e),
        Err(_) => {}
    }
    Ok((closed, all))
}

/// Whether an error says that a shape cannot be worked on in one way, so that another one may do.
pub(super) fn is_of_shape(error: &Error) -> bool {
    matches!(error, Error::Input { .. } | Error::Numeric(_))
}

/// Clean-up with the branchings that become one and the angle of forks that get a trunk, resampling and the size
/// asked for; the answer says in which lid (from 1) a node lies, zero for none.
fn clean_up_for_surface(
    net: &mut CurveNet,
    joining: Joining,
    narrow: f64,
    target: &Target,
    options: &mut HexOptions,
    warnings: &mut Vec<String>,
) -> Result<impl Fn(&CurveNet, u32) -> u32 + use<>> {
    net.radii = net.points.iter().map(|&p| target.distance(p)).collect();
    if options.stage == Stage::Full {
        resample::prune(net, &FxHashSet::default());
        if joining.hubs {
            hubs::gather(net, target);
        }
        net.merge_branchings(|[a, b]| joining.within * (a + b));
        webs::merge_webs(net, target);
    }
    let lids = tips::ready(net, target);
    let in_lids: Vec<(DVec3, u32)> = net.points.iter().zip(&lids).filter(|l| *l.1 > 0).map(|(p, l)| (*p, *l)).collect();
    let missed = target.lids().len() - in_lids.len();
    if missed > 0 {
        warnings.push(format!("{missed} open ends have no branch of the skeleton and were taken as wall"));
    }
    if options.stage == Stage::Full {
        junction_centres::meet(net, target);
        junction_centres::straighten_in_balls(net, target);
        fork_trunks::zip(net, narrow, fork_trunks::APART_DEGREES);
        check_steps(net, options)?;
        let round = tips_of(net).saturating_sub(in_lids.len());
        *net = sized(net, round, options);
        let around = net.incidence();
        for v in (0..net.points.len()).filter(|&v| around.valence(v as u32) != 1) {
            net.radii[v] = target.room(net.points[v]).max(LEAST_RADIUS * net.radii[v]);
        }
    } else {
        options.refine_across.get_or_insert(ACROSS);
    }
    net.radii.iter_mut().for_each(|r| *r *= INSIDE);
    ring_room::limit_radii(net);
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
        let sized = resample::resample(net, Step::Eased(SURFACE_STEP, mean_radius(net)));
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
        let longest = resample::resample(net, eased(LONGEST_RATIO / f64::from(1 << across.min(2)) * 2.0));
        if fits(&longest) {
            return finest(net, eased, fits);
        }
    }
    finest(net, eased, |n| options.hexes_of(n.edges.len(), round) <= wanted)
}

/// Weighted by length.
fn mean_radius(net: &CurveNet) -> f64 {
    let sum = |f: &dyn Fn(usize) -> f64| (0..net.edges.len()).map(|e| f(e) * net.length(e)).sum::<f64>();
    let radius = |e: usize| net.edges[e].iter().map(|&v| 0.5 * net.radii[v as usize]).sum::<f64>();
    sum(&radius) / sum(&|_| 1.0)
}
