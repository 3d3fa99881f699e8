//! Hypotheses: surfaces through patches of several sizes, grown as far as they reach.

use super::level::Noise;
use super::model::{DEAREST_PRICE, FREE_PRICE, Fitter, Model, is_wrong};
use crate::context::Context;
use crate::error::Result;
use crate::geometry::primitive::Kind;
use crate::mesh::NONE;
use crate::segment::surface::{Surface, quantile};
use rustc_hash::FxHashSet;

/// Counts: triangles of a patch, from sure to small, because a large patch says more and a small one fits into more
/// faces.
const PATCH_SIZES: [usize; 4] = [160, 64, 26, 10];
/// A count: most seeds that are asked, because parts have tens to hundreds of faces.
const MOST_SEEDS: usize = 3000;
/// A count: a triangle that was in so many patches without a surface is no seed any more, because its own patch would
/// be nearly the same.
const PATCH_FAILURES: u32 = 3;
/// A price: a triangle this cheap on a surface that was proposed is no seed any more, because it would propose the same
/// one.
const EXPLAINED_PRICE: f64 = 2.0;
/// A share of its border: a surface that ends at creases with this much of it needs no rival, because it fills a face.
const BOUNDED_BORDER: f64 = 0.9;
/// A share of the score for each parameter, because of equally good surfaces the simplest is to win.
const PARAMETER_MALUS: f64 = 0.01;
/// A count: fewest triangles of a proposal, because fewer lie on some surface by chance.
const LEAST_PROPOSED: usize = 5;

/// A count: seeds of a probe, few because a share of them is sure enough and a large scan is to be told in a fraction
/// of a second.
const PROBE_SEEDS: usize = 48;
/// A count: rounds in which those are asked, because the answer is often clear after one.
const PROBE_ROUNDS: usize = 8;
/// A count: triangles that the surface of a seed grows over at most, because time grows with them.
const PROBE_TRIANGLES: usize = 1000;
/// A count: vertices by which a surface has a say at most, because a large one is not to outweigh all others.
const PROBE_VERTICES: usize = 100;
/// A count: a surface of so many triangles is large, because waves end surfaces before.
const LARGE_TRIANGLES: usize = 200;
/// Standard deviation of a normal distribution over its median absolute value: a constant of the distribution, because
/// outliers would spoil the deviation itself.
const NORMAL_OVER_MEDIAN: f64 = 1.4826;

/// A hypothesis with its triangles.
pub struct Proposal {
    pub model: Model,
    pub triangles: Vec<u32>,
}

/// Surfaces proposed from all over the mesh.
pub fn propose(
    surface: &Surface<'_>,
    noise: &Noise,
    order: &[u32],
    fixed: &[bool],
    context: &Context,
) -> Result<Vec<Proposal>> {
    let mut fitter = Fitter::new(surface, noise, fixed);
    let mut explained = fixed.to_vec();
    let mut failures = vec![0u32; surface.len()];
    let mut all = Vec::new();
    let mut asked = 0;
    for seed in seeds(surface, noise, order) {
        if explained[seed as usize] || failures[seed as usize] >= PATCH_FAILURES {
            continue;
        }
        context.check()?;
        asked += 1;
        if asked > MOST_SEEDS {
            break;
        }
        // Whatever comes of it: its neighbours would find the same.
        explained[seed as usize] = true;
        if let Some(found) = best_from(&mut fitter, seed) {
            for &k in &found.triangles {
                explained[k as usize] |= found.model.price(surface, noise, k) <= EXPLAINED_PRICE;
            }
            all.push(found);
        } else {
            // The last patch was the smallest; its triangles see nearly the same.
            fitter.patches.triangles.iter().for_each(|&k| failures[k as usize] += 1);
        }
    }
    Ok(all)
}

/// What a few hypotheses, evenly spread over the mesh, tell about its noise.
pub struct Probe {
    /// Share of the seeds whose surface is large, or ends at creases.
    pub large: f64,
    /// Share of the seeds that lie on a surface which noise alone keeps them from.
    pub share: f64,
    /// The deviation of the vertices from the surfaces that were found, whatever keeps them from these.
    pub sigma: f64,
}

/// Asks a few seeds; no more than those of a round once the answer is hopeless.
pub fn probe(
    surface: &Surface<'_>,
    noise: &Noise,
    order: &[u32],
    hopeless: impl Fn(&Probe) -> bool,
    context: &Context,
) -> Result<Probe> {
    let fixed = vec![false; surface.len()];
    let mut fitter = Fitter::new(surface, noise, &fixed);
    fitter.most = PROBE_TRIANGLES;
    let step = (order.len() / PROBE_SEEDS).max(1);
    let seeds: Vec<u32> = order.iter().copied().skip(order.len() / PROBE_SEEDS / 2).step_by(step).collect();
    let (mut asked, mut hits, mut large) = (0.0, 0.0, 0.0);
    let mut distances = Vec::new();
    let mut answer = Probe { large: 0.0, share: 0.0, sigma: noise.sigma };
    for round in 0..PROBE_ROUNDS {
        for &seed in seeds.iter().skip(round).step_by(PROBE_ROUNDS) {
            context.check()?;
            asked += 1.0;
            let Some(found) = best_from(&mut fitter, seed) else { continue };
            if found.triangles.len() >= LARGE_TRIANGLES || found.bounded(surface, noise) >= BOUNDED_BORDER {
                large += 1.0;
            }
            if !is_wrong(found.model.wrongness(surface, noise, &found.triangles)) {
                hits += 1.0;
            }
            fitter.patches.gather_of(&found.triangles);
            fitter.patches.thin(PROBE_VERTICES);
            distances.extend(fitter.patches.points.iter().map(|&p| found.model.primitive.distance(p).abs()));
        }
        let median = quantile(&mut distances, 0.5, f64::total_cmp);
        answer.share = hits / f64::max(asked, 1.0);
        answer.large = large / f64::max(asked, 1.0);
        answer.sigma = median.map_or(noise.sigma, |median| NORMAL_OVER_MEDIAN * median);
        if hopeless(&answer) {
            break;
        }
    }
    Ok(answer)
}

/// All triangles, those farthest from creases first.
fn seeds(surface: &Surface<'_>, noise: &Noise, order: &[u32]) -> Vec<u32> {
    let t = surface.triangles;
    let mut depth = vec![NONE; surface.len()];
    let mut queue: Vec<u32> =
        order.iter().copied().filter(|&k| (3 * k..3 * k + 3).any(|c| noise.crease[c as usize])).collect();
    queue.iter().for_each(|&k| depth[k as usize] = 0);
    let mut next = 0;
    while next < queue.len() {
        let k = queue[next];
        next += 1;
        for o in (3 * k..3 * k + 3).map(|c| t.opposite(c)).filter(|&o| o != NONE) {
            if depth[o as usize / 3] == NONE {
                depth[o as usize / 3] = depth[k as usize] + 1;
                queue.push(o / 3);
            }
        }
    }
    let mut seeds = order.to_vec();
    seeds.sort_by_key(|&k| std::cmp::Reverse(depth[k as usize]));
    seeds
}

/// The best surface through a seed: of the largest patch that lies on one.
fn best_from(fitter: &mut Fitter<'_>, seed: u32) -> Option<Proposal> {
    let noise = fitter.noise;
    let mut last = usize::MAX;
    for size in PATCH_SIZES {
        let fixed = fitter.fixed;
        let triangles = fitter.surface.triangles;
        let outside = |c: u32| triangles.opposite(c) != NONE && fixed[triangles.opposite(c) as usize / 3];
        fitter.patches.around(seed, size, &|c| noise.crease[c as usize] || outside(c));
        let (count, points) = (fitter.patches.triangles.len(), fitter.patches.points.len());
        if count >= last || points < Kind::Plane.parameters() + 1 {
            continue;
        }
        last = count;
        let best = best_through(fitter, seed);
        if best.is_some() {
            return best;
        }
    }
    None
}

fn best_through(fitter: &mut Fitter<'_>, seed: u32) -> Option<Proposal> {
    let (surface, noise) = (fitter.surface, fitter.noise);
    let patch = fitter.patches.triangles.clone();
    let mut best: Option<(f64, Proposal)> = None;
    for kind in Kind::ALL {
        fitter.patches.gather_of(&patch);
        let Some(start) = fitter.through(kind) else { continue };
        let start = Model::of(start.primitive, surface, &patch);
        let Some((model, triangles)) = fitter.grow(start, seed) else { continue };
        if triangles.len() < LEAST_PROPOSED {
            continue;
        }
        let proposal = Proposal { model, triangles };
        let score = proposal.score(surface, noise) * (1.0 - PARAMETER_MALUS * kind.parameters() as f64);
        let bounded = proposal.bounded(surface, noise) >= BOUNDED_BORDER;
        if best.as_ref().is_none_or(|b| score > b.0) {
            best = Some((score, proposal));
        }
        if bounded {
            break;
        }
    }
    best.map(|b| b.1)
}

impl Proposal {
    /// Area of the triangles, less where they are dear.
    fn score(&self, surface: &Surface<'_>, noise: &Noise) -> f64 {
        let worth = |&k: &u32| surface.areas[k as usize] * (1.0 - self.model.price(surface, noise, k) / DEAREST_PRICE);
        self.triangles.iter().map(worth).sum()
    }

    /// Share of the border that is at creases.
    fn bounded(&self, surface: &Surface<'_>, noise: &Noise) -> f64 {
        let inside: FxHashSet<u32> = self.triangles.iter().copied().collect();
        let (mut hard, mut all) = (0.0, 0.0);
        for c in self.triangles.iter().flat_map(|&k| 3 * k..3 * k + 3) {
            let o = surface.triangles.opposite(c);
            if o == NONE || !inside.contains(&(o / 3)) {
                let length = surface.edge_length(c);
                all += length;
                hard += if noise.crease[c as usize] { length } else { 0.0 };
            }
        }
        if all > 0.0 { hard / all } else { 1.0 }
    }
}

/// Picks proposals greedily by what they save, where a triangle without a surface costs [`FREE_PRICE`] and a surface
/// its own price.
/// Adds the models, and labels the triangles that no model had.
pub fn choose(
    surface: &Surface<'_>,
    noise: &Noise,
    proposals: &[Proposal],
    models: &mut Vec<Model>,
    label: &mut [u32],
) {
    let prices: Vec<Vec<f32>> = proposals
        .iter()
        .map(|p| p.triangles.iter().map(|&k| p.model.price(surface, noise, k) as f32).collect())
        .collect();
    let mut current: Vec<f32> = label.iter().map(|&l| if l == NONE { FREE_PRICE as f32 } else { 0.0 }).collect();
    let saving = |p: usize, current: &[f32]| -> f64 {
        let each = proposals[p].triangles.iter().zip(&prices[p]).map(|(&k, &x)| f64::from(current[k as usize] - x));
        each.filter(|&x| x > 0.0).sum::<f64>() - proposals[p].model.cost(noise)
    };
    // What a proposal saves only falls: the first in the queue whose value is up to date is the best.
    let mut queue: Vec<(f64, usize)> = (0..proposals.len()).map(|p| (saving(p, &current), p)).collect();
    loop {
        queue.retain(|q| q.0 > 0.0);
        queue.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
        let Some((_, p)) = queue.pop() else { break };
        let fresh = saving(p, &current);
        if queue.last().is_some_and(|second| fresh < second.0) {
            queue.push((fresh, p));
            continue;
        }
        if fresh > 0.0 {
            for (&k, &x) in proposals[p].triangles.iter().zip(&prices[p]) {
                if x < current[k as usize] {
                    label[k as usize] = models.len() as u32;
                    current[k as usize] = x;
                }
            }
            models.push(proposals[p].model);
        }
    }
}
