//! Parts with noise: the vertices lie near the surfaces of a part, not on them.
//!
//! Hypotheses and energy after Isack and Boykov, "Energy-Based Geometric Multi-Model Fitting", IJCV 97 (2012): surfaces are
//! proposed from patches all over the mesh, the triangles divided among them by α-expansion, the surfaces fitted again to
//! what they got, and so on; surfaces that pay less than their parameters are merged with their neighbours.
//!
//! | file | holds |
//! |---|---|
//! | `level` | how large the noise is, and what it does to normals and creases |
//! | `patch` | patches of triangles |
//! | `model` | a surface as an explanation: prices, growth, fit |
//! | `propose` | hypotheses |
//! | `expand` | which surface every triangle belongs to |
//! | `merge` | fewer, simpler surfaces |

mod expand;
mod level;
mod merge;
mod model;
mod patch;
mod propose;

use super::growth;
use super::regions::{Groups, connected, count};
use super::surface::Surface;
use crate::context::Context;
use crate::error::Result;
use crate::mesh::NONE;
use expand::Energy;
use level::Noise;
use model::{Fitter, Model};
use propose::Probe;

/// Noise below and above these shares of an edge is none, or no part is left.
const QUIETEST: f64 = 2e-3;
const LOUDEST: f64 = 0.15;
/// Paraboloids of a few triangles and surfaces of the part see the same noise, up to this factor. On organic shapes the surfaces
/// grow until they are as wrong as noise allows: measured 1.46 to 1.86 on scans, at most 1.1 on parts.
const SAME_NOISE: f64 = 1.28;
/// Some of the seeds are enough where they are apart by more.
const OTHER_NOISE: f64 = 1.55;
/// Noise that is larger than a distance by this factor cannot hide in it.
const CLEARLY: f64 = 6.0;
/// Share of the seeds, and of the area, that lies on surfaces where the mesh is a part.
const PROBED: f64 = 0.25;
const PART: f64 = 0.6;
/// Larger meshes would take minutes.
const LARGEST: usize = 400_000;
/// Rounds of division and fit.
const ROUNDS: usize = 4;
const EXPANSIONS: usize = 3;
/// Pieces of fewer triangles are no faces.
const CRUMB: usize = 4;
const FREE_CRUMB: usize = 10;

/// The faces of a noisy part.
pub struct Noisy {
    /// Region of every triangle.
    pub label: Vec<u32>,
    /// Standard deviation of the vertices from their surfaces.
    pub sigma: f64,
    /// Share of the area on recognised surfaces.
    pub share: f64,
}

/// The faces of a part with noise; `None` for other meshes. `held`: the distance from their vertices of surfaces that
/// were found already, if any were.
pub fn find(surface: &Surface<'_>, order: &[u32], held: Option<f64>, context: &Context) -> Result<Option<Noisy>> {
    if surface.len() > LARGEST {
        return Ok(None);
    }
    let Some(noise) = noise_of_part(surface, order, held, context)? else { return Ok(None) };
    let proposals = propose::propose(surface, &noise, order, context)?;
    let (models, mut label) = propose::choose(surface, &noise, &proposals);
    let mut energy = Energy::new(surface, &noise, models);
    let mut fitter = Fitter::new(surface, &noise);
    for _ in 0..ROUNDS {
        let changed = energy.minimise(&mut label, EXPANSIONS, context)?;
        refit(&mut energy, &mut fitter, &label);
        let merged = merge::merge(&mut energy, &mut fitter, &mut label, context)?;
        if !changed && !merged {
            break;
        }
    }
    energy.minimise(&mut label, EXPANSIONS, context)?;
    free_wrong(&energy, &mut label);
    let on = label.iter().zip(&surface.areas).filter(|(l, _)| **l != NONE).map(|(_, a)| a).sum::<f64>();
    let share = on / surface.total_area.max(f64::MIN_POSITIVE);
    if share < PART {
        return Ok(None);
    }
    let label = complete(surface, &noise, &energy, label, order, context)?;
    Ok(Some(Noisy { label, sigma: noise.sigma, share }))
}

/// The noise of a mesh that looks like a part with noise. Few probes decide: a scan of a million triangles is told in a
/// fraction of a second.
fn noise_of_part(surface: &Surface<'_>, order: &[u32], held: Option<f64>, context: &Context) -> Result<Option<Noise>> {
    let Some(sigma) = level::level(surface, order) else { return Ok(None) };
    // No surface could hold its vertices as closely.
    if held.is_some_and(|held| sigma > CLEARLY * held) {
        return Ok(None);
    }
    let edge = surface.mean_edge();
    if !(QUIETEST * edge..LOUDEST * edge).contains(&sigma) {
        return Ok(None);
    }
    let first = Noise::new(surface, sigma);
    let hopeless = |probe: &Probe| probe.sigma > OTHER_NOISE * sigma;
    let probe = propose::probe(surface, &first, order, hopeless, context)?;
    let is_part = probe.share >= PROBED && probe.sigma <= SAME_NOISE * sigma && probe.sigma > 0.0;
    Ok(is_part.then(|| if probe.sigma < sigma { Noise::new(surface, probe.sigma) } else { first }))
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

/// Fits every surface to the triangles it has.
fn refit(energy: &mut Energy<'_>, fitter: &mut Fitter<'_>, label: &[u32]) {
    let groups = Groups::new(label, energy.models.len());
    for l in 0..groups.len() as u32 {
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
    context: &Context,
) -> Result<Vec<u32>> {
    let models = energy.models.len() as u32;
    // Free pieces end at creases.
    let next = surface.flood(order, &mut label, models, |c| !noise.crease[c as usize], |_, _| ());
    let part = connected(surface, &label, order);
    let mut size = vec![0usize; count(&part)];
    part.iter().for_each(|&p| size[p as usize] += 1);
    for k in 0..label.len() {
        let least = if label[k] >= models { FREE_CRUMB } else { CRUMB };
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
