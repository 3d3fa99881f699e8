//! The cells about a net: an untangled base mesh, padded, halved and optimised.

use super::assemble::{self, BaseMesh};
use super::choices::Padding;
use super::insert;
use super::optimise::{COARSE, Effort, FINE, Optimiser, PASSING, Spring, relieve};
use super::options::HexOptions;
use super::refine::{self, CORE, TubeMesh};
use crate::context::Context;
use crate::error::Result;
use crate::geometry::hexes::scaled_jacobian;
use crate::mesh::CurveNet;
use glam::DVec3;

/// Shares of the radius that stay inside of the layer, tried one after the other where a layer of the usual thickness
/// folds.
const CORES: [f64; 4] = [0.75, 0.88, 0.95, 0.98];
/// Strength of the springs that hold ends in their planes; those of the wall and of nodes are weaker because ends are
/// exact.
const PLANE: f64 = 10.0;
/// Strength of the springs that hold the wall at its radius.
const WALL: f64 = 0.3;
/// Strength of the springs that hold nodes at their places.
const NODE: f64 = 0.3;
/// Strength of the springs that hold the wall across its radius: it may slide.
const WEAK: f64 = 0.02;

/// Places, with a radius, around which the vertices at the nodes of the skeleton stay, as extremities do; others are drawn
/// to their nodes by springs: cells have better shapes.
pub(super) type Held = [(DVec3, f64)];

/// The base mesh padded, halved, and optimised.
pub(super) fn refined(
    net: &CurveNet,
    base: &BaseMesh,
    held: &Held,
    options: &HexOptions,
    context: &Context,
) -> Result<TubeMesh> {
    // What is not refined is not optimised again.
    let halved = options.refine_across() + options.refine_along > 0;
    let levels = if options.adapt_radius { insert::levels(net) } else { Vec::new() };
    let grows = levels.iter().any(|&l| l > 0);
    let mut tube = padded(net, base, options, &[], if halved || grows { &PASSING } else { &COARSE }, held, context)?;
    if grows {
        insert::insert(&mut tube, refine::places(net, base, options.padding), &levels);
        optimise(&mut tube, if halved { &PASSING } else { &COARSE }, held, context)?;
    }
    (0..options.refine_across()).for_each(|_| tube.refine_across());
    (0..options.refine_along).for_each(|_| tube.refine_along(|_| true));
    if halved {
        let _stage = context.stage("optimise");
        optimise(&mut tube, &FINE, held, context)?;
    }
    let _stage = context.stage("poor cells");
    let mut optimiser = Optimiser::new(&tube.points, &tube.hexes);
    hold(&mut optimiser, &tube, held);
    relieve(&mut tube.points, &tube.hexes, &optimiser, context)?;
    Ok(tube)
}

/// The coarsest mesh, its folds undone: where cells are few that costs little, and what refines a valid mesh is nearly valid.
/// `cubic` allows cubic junctions.
pub(super) fn valid_base(net: &CurveNet, cubic: bool, held: &Held, context: &Context) -> Result<BaseMesh> {
    let _stage = context.stage("base mesh");
    let mut base = assemble::base_mesh(net, cubic);
    let mut coarse = refine::pad(net, &base, Padding::None, CORE);
    optimise(&mut coarse, &COARSE, held, context)?;
    base.points = coarse.points;
    Ok(base)
}

/// Untangles and smooths a mesh that has no surface.
pub(super) fn optimise(tube: &mut TubeMesh, effort: &Effort, held: &Held, context: &Context) -> Result<()> {
    let mut optimiser = Optimiser::new(&tube.points, &tube.hexes);
    hold(&mut optimiser, tube, held);
    optimiser.run(&mut tube.points, effort, context)
}

pub(super) fn least_scaled_jacobian(points: &[DVec3], hexes: &[[u32; 8]]) -> f64 {
    hexes.iter().map(|h| scaled_jacobian(&h.map(|v| points[v as usize]))).fold(f64::INFINITY, f64::min)
}

/// The base mesh with its layer: as thick as it should be where that folds nothing, else as thin as it must be, and then
/// let grow. No layer on the ends that are `flat`.
pub(super) fn padded(
    net: &CurveNet,
    base: &BaseMesh,
    options: &HexOptions,
    flat: &[bool],
    effort: &Effort,
    held: &Held,
    context: &Context,
) -> Result<TubeMesh> {
    let _stage = context.stage("padding");
    let mut tube = refine::pad_but(net, base, options.padding, CORE, flat);
    if options.padding == Padding::None {
        return Ok(tube);
    }
    let mut optimiser = Optimiser::new(&tube.points, &tube.hexes);
    hold(&mut optimiser, &tube, held);
    let mut points = tube.points.clone();
    for core in CORES {
        if optimiser.is_valid(&points) {
            break;
        }
        points = refine::pad_but(net, base, options.padding, core, flat).points;
    }
    optimiser.run(&mut points, effort, context)?;
    tube.points = points;
    Ok(tube)
}

/// What holds a mesh that has no surface: springs pull the wall to its radius, ends to their planes, and the vertices at
/// the nodes of the skeleton to these.
pub(super) fn hold(optimiser: &mut Optimiser, tube: &TubeMesh, held: &Held) {
    let is_held = |p: DVec3| held.iter().any(|&(at, reach)| p.distance(at) <= reach);
    let mut springs = Vec::with_capacity(tube.points.len());
    for v in 0..tube.points.len() {
        let (vertex, c) = (v as u32, tube.centres[v]);
        let mut away = tube.points[v] - c;
        if let Some(end) = tube.ends.get((tube.caps[v] as usize).wrapping_sub(1)) {
            let normal = end.outward;
            springs.push(Spring { vertex, to: end.centre, normal, along: PLANE, across: 0.0 });
            away -= normal * normal.dot(away);
        }
        if tube.radii[v] > 0.0 {
            let normal = away.normalize_or_zero();
            springs.push(Spring { vertex, to: c + normal * tube.radii[v], normal, along: WALL, across: WEAK });
        }
    }
    let mut fixed = vec![false; tube.points.len()];
    for &vertex in &tube.nodes {
        let to = tube.centres[vertex as usize];
        springs.push(Spring { vertex, to, normal: DVec3::ZERO, along: 0.0, across: NODE });
        fixed[vertex as usize] = tube.caps[vertex as usize] > 0 || is_held(to);
    }
    optimiser.tie(springs);
    optimiser.fix(fixed);
}
