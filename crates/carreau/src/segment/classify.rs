//! Classification of vertices by their curvature (§4.2.2): weighted K-means on (k_max, |k_min|), then regularisation.
//!
//! Deterministic and independent of the numbering: the first centre is the point nearest to the weighted mean, every
//! further one the point farthest from those chosen; sums run over fixed chunks.

use super::surface::quantile;
use crate::context::Context;
use crate::error::Result;
use rayon::prelude::*;

/// Curvature of a vertex or region: (k_max, |k_min|) times the length scale.
pub type Pair = [f64; 2];

/// A share of the values of an axis above which they are clamped, because a few extreme curvatures would have clusters
/// of their own.
const CLAMP_QUANTILE: f64 = 0.99;
/// A share of the weight: clusters with less are dissolved, because they are noise.
const SMALL_CLUSTER: f64 = 0.01;
/// A share of the range: centres nearer than this are one, because noise moves them by as much.
const SIMILAR_CENTRES: f64 = 0.01;
/// A count: most rounds of k-means, because it settles in fewer but for the last samples.
const MEANS_ROUNDS: usize = 60;
/// A count: samples that are summed one by one before their sums are added, because the sum must not depend on the
/// number of threads.
const SUM_CHUNK: usize = 4096;
/// A share of the variance: the automatic number of clusters is the least that leaves no more unexplained, because more
/// clusters would follow noise.
const UNEXPLAINED_VARIANCE: f64 = 0.01;
/// Counts: range of the automatic number of clusters, from 2 because one tells nothing apart, to 24 because time grows
/// with it.
const CLUSTER_RANGE: std::ops::RangeInclusive<usize> = 2..=24;

/// Clusters of curvature.
pub struct Clusters {
    /// Cluster of every sample.
    pub of: Vec<u32>,
    /// Curvature of every cluster.
    pub centers: Vec<Pair>,
}

pub fn distance(a: Pair, b: Pair) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

fn squared(a: Pair, b: Pair) -> f64 {
    let (x, y) = (a[0] - b[0], a[1] - b[1]);
    x * x + y * y
}

/// Classifies samples with these weights into at most `count` clusters; chooses the number when there is none.
pub fn classify(samples: &[Pair], weights: &[f64], count: Option<usize>, context: &Context) -> Result<Clusters> {
    if !weights.iter().any(|&w| w > 0.0) {
        // Without area there is nothing to tell apart.
        return Ok(Clusters { of: vec![0; samples.len()], centers: vec![[0.0; 2]; samples.len().min(1)] });
    }
    let limit: Pair = std::array::from_fn(|k| {
        let mut values: Vec<f64> = samples.iter().map(|s| s[k]).collect();
        quantile(&mut values, CLAMP_QUANTILE, f64::total_cmp).unwrap_or_default()
    });
    let clamped: Vec<Pair> = samples.iter().map(|s| [s[0].min(limit[0]), s[1].min(limit[1])]).collect();
    let mut centers = match count {
        Some(count) => means(&clamped, weights, count, context)?.0,
        None => automatic(&clamped, weights, context)?,
    };
    let (mut of, _) = assign(&clamped, weights, &centers);
    regularise(weights, &mut of, &mut centers, limit[0].hypot(limit[1]) * SIMILAR_CENTRES);
    Ok(Clusters { of, centers })
}

/// The fewest clusters that explain the variance, found on a coarse histogram.
fn automatic(samples: &[Pair], weights: &[f64], context: &Context) -> Result<Vec<Pair>> {
    let (bins, mass) = histogram(samples, weights);
    let (_, all) = means(&bins, &mass, 1, context)?;
    for count in CLUSTER_RANGE {
        let (centers, left) = means(&bins, &mass, count, context)?;
        if left <= all * UNEXPLAINED_VARIANCE || count == *CLUSTER_RANGE.end() {
            return Ok(means_from(samples, weights, centers, context)?.0);
        }
    }
    means(samples, weights, 1, context).map(|(centers, _)| centers)
}

/// A 64 × 64 histogram: mean and weight of every bin that is not empty.
fn histogram(samples: &[Pair], weights: &[f64]) -> (Vec<Pair>, Vec<f64>) {
    const N: usize = 64;
    let top = samples.iter().fold([f64::MIN_POSITIVE; 2], |m, s| [m[0].max(s[0]), m[1].max(s[1])]);
    let mut bins = vec![([0.0; 2], 0.0); N * N];
    for (s, &w) in samples.iter().zip(weights) {
        let bin = |k: usize| ((s[k] / top[k] * N as f64) as usize).min(N - 1);
        let entry = &mut bins[bin(0) * N + bin(1)];
        entry.0[0] += w * s[0];
        entry.0[1] += w * s[1];
        entry.1 += w;
    }
    bins.into_iter().filter(|b| b.1 > 0.0).map(|(s, w)| ([s[0] / w, s[1] / w], w)).unzip()
}

/// K-means from farthest-first centres; the centres and the weighted sum of squares.
fn means(samples: &[Pair], weights: &[f64], count: usize, context: &Context) -> Result<(Vec<Pair>, f64)> {
    means_from(samples, weights, farthest_first(samples, weights, count), context)
}

fn means_from(
    samples: &[Pair],
    weights: &[f64],
    mut centers: Vec<Pair>,
    context: &Context,
) -> Result<(Vec<Pair>, f64)> {
    let mut left = f64::INFINITY;
    for _ in 0..MEANS_ROUNDS {
        context.check()?;
        let (of, sum) = assign(samples, weights, &centers);
        // Converged as far as it matters for a classification that is regularised afterwards.
        if sum >= left * (1.0 - 1e-6) {
            break;
        }
        left = sum;
        for (k, center) in averages(samples, weights, &of, centers.len()).into_iter().enumerate() {
            if let Some(center) = center {
                centers[k] = center;
            }
        }
    }
    Ok((centers, left))
}

fn farthest_first(samples: &[Pair], weights: &[f64], count: usize) -> Vec<Pair> {
    let of = vec![0; samples.len()];
    let Some(mean) = averages(samples, weights, &of, 1)[0] else { return vec![samples[0]] };
    // Of equal distances the smaller curvature: values, not numbers, decide.
    let order = |a: &(f64, Pair), b: &(f64, Pair)| {
        a.0.total_cmp(&b.0).then(b.1[0].total_cmp(&a.1[0])).then(b.1[1].total_cmp(&a.1[1]))
    };
    let nearest = samples.iter().map(|&s| (-squared(s, mean), s)).max_by(order).map_or(mean, |x| x.1);
    let mut centers = vec![nearest];
    let mut far: Vec<f64> = samples.iter().map(|&s| squared(s, nearest)).collect();
    while centers.len() < count {
        let Some((distance, next)) = far.iter().copied().zip(samples.iter().copied()).max_by(order) else { break };
        if distance <= 0.0 {
            break;
        }
        centers.push(next);
        far.par_iter_mut().zip(samples).with_min_len(SUM_CHUNK).for_each(|(f, &s)| *f = f.min(squared(s, next)));
    }
    centers
}

/// Nearest centre of every sample (ties: the first) and the weighted sum of squared distances.
fn assign(samples: &[Pair], weights: &[f64], centers: &[Pair]) -> (Vec<u32>, f64) {
    let nearest = |sample: Pair| {
        let (mut best, mut at) = (f64::INFINITY, 0);
        for (c, &center) in (0u32..).zip(centers) {
            // Selected, not branched on: which centre is nearest cannot be predicted.
            let d = squared(sample, center);
            let nearer = d < best;
            best = if nearer { d } else { best };
            at = if nearer { c } else { at };
        }
        (best, at)
    };
    let mut of = vec![0u32; samples.len()];
    let parts: Vec<f64> = of
        .par_chunks_mut(SUM_CHUNK)
        .zip(samples.par_chunks(SUM_CHUNK).zip(weights.par_chunks(SUM_CHUNK)))
        .map(|(of, (samples, weights))| {
            let mut sum = 0.0;
            for ((of, &sample), &weight) in of.iter_mut().zip(samples).zip(weights) {
                let (distance, at) = nearest(sample);
                *of = at;
                sum += weight * distance;
            }
            sum
        })
        .collect();
    (of, parts.iter().sum())
}

/// Weighted mean of every cluster; `None` where it has no weight.
fn averages(samples: &[Pair], weights: &[f64], of: &[u32], count: usize) -> Vec<Option<Pair>> {
    let part = |range: std::ops::Range<usize>| {
        let mut sums = vec![[0.0; 3]; count];
        for k in range {
            let sum = &mut sums[of[k] as usize];
            *sum = [sum[0] + weights[k] * samples[k][0], sum[1] + weights[k] * samples[k][1], sum[2] + weights[k]];
        }
        sums
    };
    let chunks = samples.len().div_ceil(SUM_CHUNK);
    let parts: Vec<_> =
        (0..chunks).into_par_iter().map(|c| part(c * SUM_CHUNK..samples.len().min((c + 1) * SUM_CHUNK))).collect();
    let add = |k: usize| parts.iter().fold([0.0; 3], |s, p| std::array::from_fn(|j| s[j] + p[k][j]));
    (0..count).map(add).map(|s| (s[2] > 0.0).then(|| [s[0] / s[2], s[1] / s[2]])).collect()
}

/// Dissolves clusters that are too small, then joins those that are too similar; drops empty ones.
fn regularise(weights: &[f64], of: &mut [u32], centers: &mut Vec<Pair>, similar: f64) {
    let total: f64 = weights.iter().sum();
    let mut weight = vec![0.0; centers.len()];
    of.iter().zip(weights).for_each(|(&c, &w)| weight[c as usize] += w);
    let mut target: Vec<u32> = (0..centers.len() as u32).collect();
    let mut alive: Vec<bool> = weight.iter().map(|&w| w > 0.0).collect();
    let living = |alive: &[bool]| (0..alive.len()).filter(|&k| alive[k]).collect::<Vec<_>>();
    let join = |from: usize, into: usize, weight: &mut [f64], centers: &mut [Pair]| {
        let w = weight[from] + weight[into];
        centers[into] =
            std::array::from_fn(|k| (weight[from] * centers[from][k] + weight[into] * centers[into][k]) / w);
        weight[into] = w;
    };
    loop {
        let ids = living(&alive);
        let Some(&small) = ids.iter().min_by(|&&a, &&b| weight[a].total_cmp(&weight[b])) else { break };
        let nearest = ids.iter().copied().filter(|&k| k != small);
        let by = |a: &usize, b: &usize| {
            distance(centers[*a], centers[small]).total_cmp(&distance(centers[*b], centers[small]))
        };
        let Some(nearest) = nearest.min_by(by).filter(|_| weight[small] < SMALL_CLUSTER * total) else { break };
        join(small, nearest, &mut weight, centers);
        (alive[small], target[small]) = (false, nearest as u32);
    }
    loop {
        let ids = living(&alive);
        let pairs = ids.iter().flat_map(|&a| ids.iter().filter(move |&&b| b > a).map(move |&b| (a, b)));
        let closest = pairs.map(|(a, b)| (distance(centers[a], centers[b]), a, b)).min_by(|x, y| x.0.total_cmp(&y.0));
        let Some((_, a, b)) = closest.filter(|x| x.0 < similar) else { break };
        join(b, a, &mut weight, centers);
        (alive[b], target[b]) = (false, a as u32);
    }
    let mut number = vec![0u32; centers.len()];
    living(&alive).iter().enumerate().for_each(|(n, &k)| number[k] = n as u32);
    let root = |mut k: usize| {
        while target[k] as usize != k {
            k = target[k] as usize;
        }
        k
    };
    of.iter_mut().for_each(|c| *c = number[root(*c as usize)]);
    let mut kept = alive.iter();
    centers.retain(|_| kept.next().copied().unwrap_or(false));
}
