//! Fewer surfaces: two neighbours become one where a single surface explains both, at a price that is below that of a second
//! surface and the boundary.

use super::expand::Energy;
use super::model::{Fitter, Model};
use crate::context::Context;
use crate::error::Result;
use crate::geometry::primitive::Kind;
use crate::mesh::NONE;
use crate::segment::regions::Groups;
use rustc_hash::{FxHashMap, FxHashSet};

/// Mean price of the triangles of each piece of a merged surface at most: that of triangles on their own surface,
/// because a surface may be a wave away from a piece.
pub const WAVE_PRICE: f64 = 1.0;

/// Merges neighbours while that pays; returns whether any were. Labels without triangles stay behind, without harm. The first
/// `held` models stay what they are.
pub fn merge(
    energy: &mut Energy<'_>,
    fitter: &mut Fitter<'_>,
    label: &mut [u32],
    held: u32,
    context: &Context,
) -> Result<bool> {
    let mut any = false;
    // Pairs that were found not to pay.
    let mut settled: FxHashSet<(u32, u32)> = FxHashSet::default();
    loop {
        let groups = Groups::new(label, energy.models.len());
        let own: Vec<f64> = (0..groups.len() as u32)
            .map(|l| {
                price(energy, groups.of(l), &energy.models[l as usize]) + energy.models[l as usize].cost(energy.noise)
            })
            .collect();
        let mut gains: Vec<(f64, u32, u32, Model)> = Vec::new();
        for ((a, b), boundary) in neighbours(energy, label) {
            context.check()?;
            if settled.contains(&(a, b)) || a.max(b) < held {
                continue;
            }
            let both: Vec<u32> = groups.of(a).iter().chain(groups.of(b)).copied().collect();
            let before = own[a as usize] + own[b as usize] + boundary;
            match best(energy, fitter, [a, b], held, &both) {
                Some((model, after))
                    if after < before + alike(energy, [groups.of(a), groups.of(b)], [a, b], &model) =>
                {
                    gains.push((before - after, a, b, model));
                }
                _ => {
                    settled.insert((a, b));
                }
            }
        }
        gains.sort_by(|x, y| y.0.total_cmp(&x.0).then((x.1, x.2).cmp(&(y.1, y.2))));
        let mut used = vec![false; energy.models.len()];
        let mut into: Vec<u32> = (0..energy.models.len() as u32).collect();
        for (_, a, b, model) in gains {
            if !used[a as usize] && !used[b as usize] {
                (used[a as usize], used[b as usize]) = (true, true);
                energy.models[a as usize] = model;
                into[b as usize] = a;
            }
        }
        if !used.contains(&true) {
            return Ok(any);
        }
        any = true;
        settled.retain(|&(a, b)| !used[a as usize] && !used[b as usize]);
        label.iter_mut().filter(|l| **l != NONE).for_each(|l| *l = into[*l as usize]);
    }
}

/// What a pair saves beyond what independent samples say, where waves may be all that the pieces differ by.
fn alike(energy: &Energy<'_>, pieces: [&[u32]; 2], pair: [u32; 2], model: &Model) -> f64 {
    let noise = energy.noise;
    let more = noise.triangles_a_wave / noise.triangles_a_sample - 1.0;
    if !noise.has_waves() || pieces.iter().any(|p| price(energy, p, model) > WAVE_PRICE * p.len() as f64) {
        return 0.0;
    }
    let cost = |l: u32| energy.models[l as usize].cost(noise);
    more * (cost(pair[0]) + cost(pair[1]) - model.cost(noise))
}

fn price(energy: &Energy<'_>, triangles: &[u32], model: &Model) -> f64 {
    triangles.iter().map(|&k| model.price(energy.surface, energy.noise, k)).sum()
}

/// The best surface for the triangles of two labels: one of theirs, or one fitted to both.
fn best(energy: &Energy<'_>, fitter: &mut Fitter<'_>, pair: [u32; 2], held: u32, both: &[u32]) -> Option<(Model, f64)> {
    let mut best: Option<(Model, f64)> = None;
    let mut offer = |model: Model| {
        let total = price(energy, both, &model) + model.cost(energy.noise);
        if best.as_ref().is_none_or(|b| total < b.1) {
            best = Some((model, total));
        }
    };
    if let Some(&l) = pair.iter().find(|&&l| l < held) {
        offer(energy.models[l as usize]);
        return best;
    }
    pair.iter().for_each(|&l| offer(energy.models[l as usize]));
    for kind in Kind::ALL {
        if let Some(fit) = fitter.fit(kind, both, None) {
            offer(Model::of(fit.primitive, energy.surface, both));
        }
    }
    best
}

/// Pairs of labels with the price of their common boundary, in order.
fn neighbours(energy: &Energy<'_>, label: &[u32]) -> Vec<((u32, u32), f64)> {
    let t = energy.surface.triangles;
    let mut common: FxHashMap<(u32, u32), f64> = FxHashMap::default();
    for c in 0..3 * label.len() as u32 {
        let o = t.opposite(c);
        if o == NONE || energy.noise.crease[c as usize] {
            continue;
        }
        let (a, b) = (label[c as usize / 3], label[o as usize / 3]);
        if a < b && b != NONE {
            *common.entry((a, b)).or_default() += energy.boundary(c);
        }
    }
    let mut all: Vec<_> = common.into_iter().collect();
    all.sort_by_key(|x| x.0);
    all
}
