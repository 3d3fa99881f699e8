//! Parts with noise: the vertices lie near the surfaces of a part, not on them.
//!
//! Hypotheses and energy after Isack and Boykov, "Energy-Based Geometric Multi-Model Fitting", IJCV 97 (2012): surfaces are
//! proposed from patches all over the mesh, the triangles divided among them by α-expansion, the surfaces fitted again to
//! what they got, and so on; surfaces that pay less than their parameters are merged with their neighbours.
//!
//! Noise is of three kinds. White noise is the same everywhere and independent from vertex to vertex: its deviation is measured, and
//! decides. Where exact surfaces hold some triangles for certain, these stay theirs, and all else (chords of a remeshed part, edges
//! that smoothing rounded) is within a tolerance in proportion to the edges. Where they hold none (waves, scans) the tolerance is
//! raised until the surfaces that it allows are no more wrong than it says; two pieces of a face may then be a wave apart.
//!
//! | file | holds |
//! |---|---|
//! | `held` | which exact surfaces are no chance |
//! | `level` | how large the noise is, and what it does to normals and creases |
//! | `patch` | patches of triangles |
//! | `model` | a surface as an explanation: prices, growth, fit |
//! | `propose` | hypotheses |
//! | `expand` | which surface every triangle belongs to |
//! | `merge` | fewer, simpler surfaces |
//! | `ambiguous` | surfaces that are pieces of freeform ones |
//! | `settle` | rounded edges, which are no faces |
//! | `simplest` | the simplest kind for what a surface got |

mod ambiguous;
mod expand;
mod held;
mod level;
mod merge;
mod model;
mod patch;
mod propose;
mod settle;
mod simplest;

use super::regions::{Groups, connected, count};
use super::surface::{Surface, quantile};
use super::surfaces::Surfaces;
use super::{PART_SHARE, growth};
use crate::context::Context;
use crate::error::Result;
use crate::geometry::primitive::Primitive;
use crate::mesh::NONE;
use expand::Energy;
use level::Noise;
use model::{Fitter, Model};
use propose::Probe;

/// A share of an edge: deviations below are no noise, because chords of exact surfaces deviate by more.
const QUIETEST_NOISE: f64 = 2e-3;
/// A share of an edge: deviations above leave no part, because faces cannot be told from noise there.
const LOUDEST_NOISE: f64 = 0.15;
/// A factor: paraboloids of a few triangles and surfaces of the part see the same noise up to this. On organic shapes
/// the surfaces grow until they are as wrong as noise allows: measured 1.46 to 1.86 on scans, at most 1.1 on parts.
const SAME_NOISE: f64 = 1.28;
/// A factor: some of the seeds are enough where both are apart by more, because all of them would not bring them
/// together.
const OTHER_NOISE: f64 = 1.55;
/// A factor: the rougher part of a mesh with white noise is rougher than the quieter part by no more, because white
/// noise is the same everywhere.
const EVEN_FACTOR: f64 = 2.5;
/// A factor: noise that is larger than a distance by this cannot hide in it, because no surface could hold its vertices
/// as closely.
const HIDDEN_FACTOR: f64 = 6.0;
/// A share of the seeds that lies on surfaces where the mesh is a part: small, because those on blends and borders
/// miss.
const PROBED_SHARE: f64 = 0.25;
/// A share of the area that lies on surfaces where the mesh is a part: more than half, because a mesh of which most is
/// free is none.
const DIVIDED_SHARE: f64 = 0.6;
/// A share of the area: where exact surfaces hold more there is no white noise, because that is the same everywhere.
const EXACT_SHARE: f64 = 0.5;
/// A share of the area: what no exact surface is sure to hold is crumbs where it is no more, because no face of a part
/// is smaller.
const UNSURE_CRUMBS: f64 = 2e-3;
/// A share of the area: what no exact surface holds at all is crumbs where it is no more, because a few triangles of
/// every file are spoiled.
const FREE_CRUMBS: f64 = 1e-4;
/// Height over longest side of the middle triangle below which triangles are those of a kernel, because smoothing,
/// remeshing and scanning leave better ones, 0.87 at most.
const WELL_SHAPED: f64 = 0.3;
/// A share of an edge: free triangles whose vertices lie this near to a smooth surface are freeform, beside exact
/// surfaces, because noise would be larger.
const SMOOTH_ROUGHNESS: f64 = 5e-3;
/// A share of an edge: least tolerance of triangles that came about somehow, because noise, chords and the waves of
/// smoothing are within that.
const LEAST_TOLERANCE: f64 = 0.045;
/// A count: triangles that say as much as a single one with independent noise would, because such deviations are those
/// of the neighbours too.
const TRIANGLES_A_SAMPLE: f64 = 4.0;
/// A count: triangles whose deviations from the right surface are alike where smooth waves are a part of the noise,
/// because such waves are some ten edges long.
const TRIANGLES_A_WAVE: f64 = 200.0;
/// A share of the seeds whose surfaces are large where the mesh is a part, because smooth waves that look like white
/// noise to paraboloids have none.
const LARGE_PROBES: f64 = 0.8;
/// The same where the noise is white: less, because a part of small faces has fewer.
const LARGE_WHITE: f64 = 0.3;
/// The same before the tolerance is raised, because what has hardly a large surface then has rounded edges, not waves.
const LARGE_FIRST: f64 = 0.5;
/// A factor: the tolerance is raised until the surfaces that it allows are wrong by no more than this times it, because
/// those of a part then have their whole faces and organic shapes have no such tolerance.
const SETTLED_FACTOR: f64 = 1.1;
/// A factor: the tolerance is a little more, because one surface is to hold all of its face.
const AMPLE_FACTOR: f64 = 1.2;
/// A share of an edge: no part is left where the vertices are farther off, because faces cannot be told from waves
/// there.
const WAVIEST_TOLERANCE: f64 = 0.3;
/// A count: most times that the tolerance is raised, because six steps of [`AMPLE_FACTOR`] reach its limit in general.
const RAISES: usize = 6;
/// A count: most triangles of the mesh, because larger ones would take minutes.
const MOST_TRIANGLES: usize = 400_000;
/// A count: most triangles that no exact surface holds, because more would take minutes as well.
const MOST_OPEN: usize = 60_000;
/// A count: rounds of division and fit, few because hardly a triangle changes after some.
const DIVISION_ROUNDS: usize = 4;
/// A count: rounds in which every label is offered, few because hardly a triangle changes after some.
const EXPANSIONS: usize = 3;
/// A count: pieces of fewer triangles are no faces, because noise makes such pieces.
const FACE_TRIANGLES: usize = 4;
/// A count: the same of pieces without a surface, more because nothing speaks for them.
const FREE_TRIANGLES: usize = 10;

/// The faces of a noisy part.
pub struct Noisy {
    /// Region of every triangle.
    pub label: Vec<u32>,
    /// Their surfaces, where these cannot be fitted to all vertices because those of rounded edges are far off; regions beyond
    /// have none.
    pub primitives: Vec<Primitive>,
    /// Standard deviation of the vertices from their surfaces.
    pub sigma: f64,
    /// Share of the area on recognised surfaces.
    pub share: f64,
}

/// What was found exactly before, and what the user asks for.
pub struct Before<'a> {
    pub exact: &'a Surfaces,
    /// Share of the area that lies on its surfaces.
    pub share: f64,
    /// Largest distance of a vertex from its surface.
    pub tolerance: Option<f64>,
}

/// The faces of a part with noise; `None` for other meshes.
pub fn find(surface: &Surface<'_>, order: &[u32], before: &Before<'_>, context: &Context) -> Result<Option<Noisy>> {
    if surface.len() > MOST_TRIANGLES {
        return Ok(None);
    }
    let white = if before.share < EXACT_SHARE { noise_of_part(surface, order, before, context)? } else { None };
    if let Some(noise) = white {
        let start = Start { models: Vec::new(), label: vec![NONE; surface.len()], fixed: vec![false; surface.len()] };
        return divide(surface, &noise, order, start, true, context);
    }
    let start = Start::of(surface, before.exact);
    match tolerant(surface, order, before, &start, context)? {
        Some(noise) => divide(surface, &noise, order, start, false, context),
        None => Ok(None),
    }
}

/// Where the division starts from.
struct Start {
    /// Models that are held.
    models: Vec<Model>,
    label: Vec<u32>,
    /// Triangles of the models that are held.
    fixed: Vec<bool>,
}

impl Start {
    /// The exact surfaces that are no chance.
    fn of(surface: &Surface<'_>, exact: &Surfaces) -> Self {
        let held = held::held(surface, exact);
        let groups = Groups::new(&exact.label, exact.primitives.len());
        let mut start =
            Start { models: Vec::new(), label: vec![NONE; surface.len()], fixed: vec![false; surface.len()] };
        let held: Vec<u32> =
            (0..groups.len() as u32).filter(|&l| held[l as usize] && !groups.of(l).is_empty()).collect();
        let members: Vec<&[u32]> = held.iter().map(|&l| groups.of(l)).collect();
        start.models = held
            .iter()
            .zip(&members)
            .map(|(&l, members)| Model::of(exact.primitives[l as usize], surface, members))
            .collect();
        let home = held::same(surface, &start.models, &members, held::TWIN_FACTOR * exact.tolerance);
        for (members, &home) in members.iter().zip(&home) {
            for &k in *members {
                (start.label[k as usize], start.fixed[k as usize]) = (home, true);
            }
        }
        start
    }
}

/// Divides the triangles that are not held among surfaces.
fn divide(
    surface: &Surface<'_>,
    noise: &Noise,
    order: &[u32],
    start: Start,
    white: bool,
    context: &Context,
) -> Result<Option<Noisy>> {
    let Start { mut models, mut label, fixed } = start;
    let held = models.len() as u32;
    let proposals = propose::propose(surface, noise, order, &fixed, context)?;
    propose::choose(surface, noise, &proposals, &mut models, &mut label);
    let mut energy = Energy::new(surface, noise, models, &fixed);
    let mut fitter = Fitter::new(surface, noise, &fixed);
    for _ in 0..DIVISION_ROUNDS {
        let changed = energy.minimise(&mut label, EXPANSIONS, context)?;
        refit(&mut energy, &mut fitter, &label, held);
        let merged = merge::merge(&mut energy, &mut fitter, &mut label, held, context)?;
        if !changed && !merged {
            break;
        }
    }
    energy.minimise(&mut label, EXPANSIONS, context)?;
    if white {
        free_wrong(&energy, &mut label);
    } else {
        refit(&mut energy, &mut fitter, &label, held);
        simplest::simplify(&mut energy, &mut fitter, &label, held);
        // Pieces of a plane are one where they were bent, each otherwise, to the rounded edges around.
        merge::merge(&mut energy, &mut fitter, &mut label, held, context)?;
        ambiguous::free(&energy, &mut label, held);
    }
    let on = label.iter().zip(&surface.areas).filter(|(l, _)| **l != NONE).map(|(_, a)| a).sum::<f64>();
    let share = on / surface.total_area.max(f64::MIN_POSITIVE);
    if share < DIVIDED_SHARE {
        return Ok(None);
    }
    let mut label = complete(surface, noise, &energy, label, order, white, context)?;
    if !white {
        settle::settle(&energy, &mut label, &fixed, order, context)?;
        let next = count(&label) as u32;
        label.iter_mut().filter(|l| **l == NONE).for_each(|l| *l = next);
    }
    refit(&mut energy, &mut fitter, &label, held);
    if !white {
        simplest::simplify(&mut energy, &mut fitter, &label, held);
    }
    let primitives = if white { Vec::new() } else { energy.models.iter().map(|m| m.primitive).collect() };
    Ok(Some(Noisy { label, primitives, sigma: noise.sigma, share }))
}

/// The noise of a mesh that looks like a part with noise. Few probes decide: a scan of a million triangles is told in a
/// fraction of a second.
fn noise_of_part(
    surface: &Surface<'_>,
    order: &[u32],
    before: &Before<'_>,
    context: &Context,
) -> Result<Option<Noise>> {
    let Some(sigma) = level::level(surface, order) else { return Ok(None) };
    // No surface could hold its vertices as closely.
    if before.share >= PART_SHARE && sigma > HIDDEN_FACTOR * before.exact.tolerance {
        return Ok(None);
    }
    let edge = surface.mean_edge();
    if !(QUIETEST_NOISE * edge..LOUDEST_NOISE * edge).contains(&sigma) {
        return Ok(None);
    }
    // White noise is the same everywhere; smoothed edges are rougher than what lies between.
    let rough = level::roughness(surface, order).unwrap_or_default();
    if rough > EVEN_FACTOR * sigma {
        return Ok(None);
    }
    let first = Noise::white(surface, sigma);
    let hopeless = |probe: &Probe| probe.sigma > OTHER_NOISE * sigma;
    let probe = propose::probe(surface, &first, order, hopeless, context)?;
    tracing::debug!(sigma, rough, probe = probe.sigma, share = probe.share, large = probe.large, "white noise");
    let same = probe.sigma > 0.0 && probe.sigma <= SAME_NOISE * sigma;
    let is_part = same && probe.share >= PROBED_SHARE && probe.large >= LARGE_WHITE;
    Ok(is_part.then(|| if probe.sigma < sigma { Noise::white(surface, probe.sigma) } else { first }))
}

/// The tolerance of a mesh that looks like a part, however its triangles came about; `None` where what is free is as smooth as a
/// freeform surface beside exact ones.
fn tolerant(
    surface: &Surface<'_>,
    order: &[u32],
    before: &Before<'_>,
    start: &Start,
    context: &Context,
) -> Result<Option<Noise>> {
    let open: Vec<u32> = order.iter().copied().filter(|&k| !start.fixed[k as usize]).collect();
    if open.len() > MOST_OPEN {
        return Ok(None);
    }
    let area: f64 = open.iter().map(|&k| surface.areas[k as usize]).sum();
    let free: f64 =
        open.iter().filter(|&&k| before.exact.label[k as usize] == NONE).map(|&k| surface.areas[k as usize]).sum();
    let nothing_left = area <= UNSURE_CRUMBS * surface.total_area || free <= FREE_CRUMBS * surface.total_area;
    if nothing_left && before.tolerance.is_none() {
        return Ok(None);
    }
    let mut areas: Vec<f64> = open.iter().map(|&k| surface.areas[k as usize]).collect();
    let middle = quantile(&mut areas, 0.5, f64::total_cmp).unwrap_or_default();
    let edge = (middle * 4.0 / 3f64.sqrt()).sqrt();
    // Where there are too few patches to tell there are too few triangles to divide.
    let Some(rough) = level::roughness(surface, &open) else { return Ok(None) };
    let shape = |&k: &u32| {
        let longest = (3 * k..3 * k + 3).map(|c| surface.edge_length(c)).fold(0.0, f64::max);
        2.0 * surface.areas[k as usize] / (longest * longest).max(f64::MIN_POSITIVE)
    };
    let mut shapes: Vec<f64> = open.iter().map(shape).collect();
    if before.tolerance.is_none() && quantile(&mut shapes, 0.5, f64::total_cmp).is_none_or(|s| s < WELL_SHAPED) {
        return Ok(None);
    }
    let held = 1.0 - area / surface.total_area.max(f64::MIN_POSITIVE);
    if held >= PART_SHARE && rough < SMOOTH_ROUGHNESS * edge && before.tolerance.is_none() {
        return Ok(None);
    }
    let measured = level::level(surface, &open).unwrap_or_default();
    let sigma = match before.tolerance {
        Some(tolerance) => tolerance / model::MODEL_REACH,
        None => measured.clamp(LEAST_TOLERANCE * edge, LOUDEST_NOISE * edge),
    };
    if held >= PART_SHARE {
        return Ok(Some(Noise::new(surface, sigma, edge, TRIANGLES_A_SAMPLE)));
    }
    raise(surface, order, sigma, edge, before.tolerance.is_some(), context)
}

/// The tolerance at which a few surfaces, evenly spread, are the large ones of a part; `None` where there is none.
fn raise(
    surface: &Surface<'_>,
    order: &[u32],
    mut sigma: f64,
    edge: f64,
    given: bool,
    context: &Context,
) -> Result<Option<Noise>> {
    for step in 0..RAISES {
        let noise = Noise::new(surface, sigma, edge, TRIANGLES_A_SAMPLE);
        // Organic shapes need no more seeds to be told.
        let hopeless = |probe: &Probe| !given && probe.sigma > OTHER_NOISE * sigma;
        let probe = propose::probe(surface, &noise, order, hopeless, context)?;
        if given || probe.sigma <= SETTLED_FACTOR * sigma {
            return Ok((probe.large >= LARGE_PROBES).then(|| {
                let ample = if given { sigma } else { sigma.max(AMPLE_FACTOR * probe.sigma) };
                Noise { triangles_a_wave: TRIANGLES_A_WAVE, ..Noise::new(surface, ample, edge, TRIANGLES_A_SAMPLE) }
            }));
        }
        sigma = AMPLE_FACTOR * probe.sigma;
        if sigma > WAVIEST_TOLERANCE * edge || step == 0 && probe.large < LARGE_FIRST {
            break;
        }
    }
    Ok(None)
}

/// Takes the surfaces away that are pieces of freeform ones, found because noise hides what they are wrong by.
fn free_wrong(energy: &Energy<'_>, label: &mut [u32]) {
    let groups = Groups::new(label, energy.models.len());
    for l in 0..groups.len() as u32 {
        if model::is_wrong(energy.models[l as usize].wrongness(energy.surface, energy.noise, groups.of(l))) {
            groups.of(l).iter().for_each(|&k| label[k as usize] = NONE);
        }
    }
}

/// Fits every surface that is not held to the triangles it has.
fn refit(energy: &mut Energy<'_>, fitter: &mut Fitter<'_>, label: &[u32], held: u32) {
    // Labels beyond the models are free.
    let own: Vec<u32> = label.iter().map(|&l| if (l as usize) < energy.models.len() { l } else { NONE }).collect();
    let groups = Groups::new(&own, energy.models.len());
    for l in held..groups.len() as u32 {
        let old = energy.models[l as usize];
        let on: Vec<u32> =
            groups.of(l).iter().copied().filter(|&k| old.holds(energy.surface, energy.noise, k)).collect();
        let kind = old.primitive.kind();
        if let Some(fit) = fitter.fit(kind, &on, Some(old.primitive)) {
            energy.models[l as usize] = Model::of(fit.primitive, energy.surface, &on);
        }
    }
}

/// Labels for all: crumbs go to their neighbours, larger pieces without a surface are faces of their own.
fn complete(
    surface: &Surface<'_>,
    noise: &Noise,
    energy: &Energy<'_>,
    mut label: Vec<u32>,
    order: &[u32],
    white: bool,
    context: &Context,
) -> Result<Vec<u32>> {
    let models = energy.models.len() as u32;
    // Free pieces end at creases.
    let next = surface.flood(order, &mut label, models, |c| !noise.crease[c as usize], |_, _| ());
    if !white {
        return Ok(label);
    }
    let part = connected(surface, &label, order);
    let mut size = vec![0usize; count(&part)];
    part.iter().for_each(|&p| size[p as usize] += 1);
    for k in 0..label.len() {
        let least = if label[k] >= models { FREE_TRIANGLES } else { FACE_TRIANGLES };
        if size[part[k] as usize] < least {
            label[k] = NONE;
        }
    }
    growth::fill(surface, &noise.crease, &mut label, context)?;
    growth::fill(surface, &vec![false; 3 * label.len()], &mut label, context)?;
    // A mesh of crumbs alone.
    label.iter_mut().filter(|l| **l == NONE).for_each(|l| *l = next);
    Ok(label)
}
