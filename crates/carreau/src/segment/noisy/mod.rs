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
use super::regions::{Groups, connected};
use super::surface::Surface;
use crate::context::Context;
use crate::error::Result;
use crate::mesh::NONE;
use expand::Energy;
use level::Noise;
use model::{Fitter, Model};

/// Noise below and above these shares of an edge is none, or no part is left.
const QUIETEST: f64 = 2e-3;
const LOUDEST: f64 = 0.15;
/// Share of the seeds, and of the area, that lies on surfaces where the mesh is a part.
const PROBED: f64 = 0.4;
const PART: f64 = 0.6;
/// Rounds of division and fit.
const ROUNDS: usize = 4;
const EXPANSIONS: usize = 3;
/// Pieces of fewer triangles are no faces.
const CRUMB: usize = 4;
const FREE_CRUMB: usize = 10;

fn knob(name: &str, default: f64) -> f64 {
    std::env::var(name).ok().and_then(|v| v.parse().ok()).unwrap_or(default)
}

/// The faces of a noisy part.
pub struct Noisy {
    /// Region of every triangle.
    pub label: Vec<u32>,
    /// Standard deviation of the vertices from their surfaces.
    pub sigma: f64,
    /// Share of the area on recognised surfaces.
    pub share: f64,
}

/// The faces of a part with noise; `None` for other meshes.
pub fn find(surface: &Surface<'_>, order: &[u32], context: &Context) -> Result<Option<Noisy>> {
    let verbose = std::env::var_os("NOISY").is_some();
    let clock = std::time::Instant::now();
    let Some(noise) = noise_of_part(surface, order, context)? else { return Ok(None) };
    let t_probe = clock.elapsed().as_secs_f64();
    let proposals = propose::propose(surface, &noise, order, context)?;
    let t_propose = clock.elapsed().as_secs_f64();
    let (models, mut label) = propose::choose(surface, &noise, &proposals);
    let n_chosen = models.len();
    let mut energy = Energy::new(surface, &noise, models);
    let mut fitter = Fitter::new(surface, &noise);
    let (mut t_expand, mut t_merge) = (0.0, 0.0);
    for _ in 0..ROUNDS {
        let t0 = clock.elapsed().as_secs_f64();
        let changed = energy.minimise(&mut label, EXPANSIONS, context)?;
        t_expand += clock.elapsed().as_secs_f64() - t0;
        refit(&mut energy, &mut fitter, &label);
        let t0 = clock.elapsed().as_secs_f64();
        let merged = merge::merge(&mut energy, &mut fitter, &mut label, context)?;
        t_merge += clock.elapsed().as_secs_f64() - t0;
        if !changed && !merged {
            break;
        }
    }
    energy.minimise(&mut label, EXPANSIONS, context)?;
    free_soft(&energy, &mut label);
    let on: Vec<f64> = (0..surface.len()).filter(|&k| label[k] != NONE).map(|k| surface.areas[k]).collect();
    let share = on.iter().sum::<f64>() / surface.total_area.max(f64::MIN_POSITIVE);
    if verbose {
        eprintln!(
            "{} proposals {n_chosen} chosen share {share:.3} probe {t_probe:.2} propose {:.2} expand {t_expand:.2} merge {t_merge:.2} all {:.2}",
            proposals.len(),
            t_propose - t_probe,
            clock.elapsed().as_secs_f64()
        );
    }
    if share < knob("PART", PART) {
        return Ok(None);
    }
    let label = complete(surface, &noise, &energy, label, order, context)?;
    Ok(Some(Noisy { label, sigma: noise.sigma, share }))
}

/// The noise of a mesh that looks like a part with noise, from few probes: what is left of scans is decided quickly.
fn noise_of_part(surface: &Surface<'_>, order: &[u32], context: &Context) -> Result<Option<Noise>> {
    let Some(level) = level::level(surface, order) else { return Ok(None) };
    let edge = level::mean_edge(surface);
    let likely = |sigma: f64| (QUIETEST * edge..LOUDEST * edge).contains(&sigma);
    if std::env::var_os("NOISY").is_some() {
        eprintln!("sigma {:.4} wide {:.4} of edge", level.sigma / edge, level.wide / edge);
    }
    if !likely(level.sigma) {
        return Ok(None);
    }
    let first = Noise::new(surface, level.sigma);
    let probe = propose::probe(surface, &first, order, context)?;
    if std::env::var_os("NOISY").is_some() {
        eprintln!("probe share {:.2} sigma {:.4}", probe.share, probe.sigma / edge);
    }
    if probe.share < knob("PROBED", PROBED) || !likely(probe.sigma) {
        return Ok(None);
    }
    Ok(Some(Noise::new(surface, probe.sigma.min(level.sigma))))
}

/// Takes the surfaces away that only the noise made possible: pieces of freeform ones.
fn free_soft(energy: &Energy<'_>, label: &mut [u32]) {
    let groups = Groups::new(label, energy.models.len());
    for l in 0..groups.len() as u32 {
        let (correlation, edges) = energy.models[l as usize].correlation(energy.surface, energy.noise, groups.of(l));
        if model::is_soft(correlation, edges) {
            groups.of(l).iter().for_each(|&k| label[k as usize] = NONE);
        }
    }
}

/// Fits every surface to the triangles it has.
fn refit(energy: &mut Energy<'_>, fitter: &mut Fitter<'_>, label: &[u32]) {
    let groups = Groups::new(label, energy.models.len());
    for l in 0..groups.len() as u32 {
        let old = energy.models[l as usize];
        let on: Vec<u32> = groups.of(l).iter().copied().filter(|&k| old.holds(energy.surface, energy.noise, k)).collect();
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
    let mut next = models;
    let mut stack = Vec::new();
    for &seed in order {
        if label[seed as usize] != NONE {
            continue;
        }
        label[seed as usize] = next;
        stack.push(seed);
        while let Some(k) = stack.pop() {
            for n in (3 * k..3 * k + 3).filter_map(|c| surface.across(c, &noise.crease)) {
                if label[n as usize] == NONE {
                    label[n as usize] = next;
                    stack.push(n);
                }
            }
        }
        next += 1;
    }
    let part = connected(surface, &label, order);
    let mut size = vec![0usize; part.iter().max().map_or(0, |&m| m as usize + 1)];
    part.iter().for_each(|&p| size[p as usize] += 1);
    for k in 0..label.len() {
        let least = if label[k] >= models { FREE_CRUMB } else { CRUMB };
        if size[part[k] as usize] < least {
            label[k] = NONE;
        }
    }
    let all = vec![true; label.len()];
    growth::fill(surface, &noise.crease, &all, &mut label, context)?;
    growth::fill(surface, &vec![false; 3 * label.len()], &all, &mut label, context)?;
    // A mesh of crumbs alone.
    label.iter_mut().filter(|l| **l == NONE).for_each(|l| *l = next);
    Ok(label)
}
