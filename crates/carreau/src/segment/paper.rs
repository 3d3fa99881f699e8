//! Regions of near-constant curvature: classification, growth and merging in a row (§4.2 to §4.4).

use super::classify::{Pair, classify};
use super::growth::{Regions, grow};
use super::merge::{BoundaryCurvature, Dendrogram, SmallArea, merge};
use super::surface::{Sharp, Surface};
use crate::context::Context;
use crate::error::Result;
use crate::geometry::curvature::Curvature;
use crate::mesh::NONE;

/// How many regions are wanted.
#[derive(Debug, Clone, Copy, Default)]
pub struct Demand {
    /// Number of clusters in the space of curvatures.
    pub clusters: Option<usize>,
    /// Largest D of a merge.
    pub threshold: Option<f64>,
    /// Number of regions; wins over the threshold.
    pub regions: Option<usize>,
    /// A_min of equation 4 as a share of the whole area.
    pub min_area: f64,
    /// The same across creases.
    pub min_area_across_creases: f64,
    /// Rounds of averaging of curvature over neighbouring vertices, for surfaces with noise.
    pub smoothing: usize,
}

/// Regions before merging, all merges, and how many of them were done.
pub struct CurvatureRegions {
    /// Region of every triangle after merging; [`NONE`] where it takes no part.
    pub label: Vec<u32>,
    pub dendrogram: Dendrogram,
    pub clusters: usize,
    pub threshold: f64,
}

/// Finds the regions among the triangles of `free`; curvatures are multiplied by the length `scale`.
#[expect(clippy::too_many_arguments, reason = "the inputs of four stages")]
pub fn curvature_regions(
    surface: &Surface<'_>,
    sharp: &Sharp,
    curvature: &Curvature,
    full: &[Pair],
    scale: f64,
    free: &[bool],
    order: &[u32],
    demand: &Demand,
    context: &Context,
) -> Result<CurvatureRegions> {
    let magnitudes = |v: usize| {
        let (a, b) = (curvature.kmin[v].abs() * scale, curvature.kmax[v].abs() * scale);
        [a.max(b), a.min(b)]
    };
    let mut pairs: Vec<Pair> = (0..sharp.vertex.len()).map(magnitudes).collect();
    for _ in 0..demand.smoothing {
        context.check()?;
        pairs = averaged(surface, sharp, &pairs);
    }
    let pair = |v: u32| pairs[v as usize];
    let mut used = vec![false; sharp.vertex.len()];
    for t in (0..surface.len() as u32).filter(|&t| free[t as usize]) {
        surface.triangles.triangle(t).iter().for_each(|&v| used[v as usize] = !sharp.vertex[v as usize]);
    }
    let ids: Vec<u32> = (0..used.len() as u32).filter(|&v| used[v as usize]).collect();
    let (clusters, cluster) = {
        let _stage = context.stage("classification");
        let samples: Vec<Pair> = ids.iter().map(|&v| pair(v)).collect();
        let weights: Vec<f64> = ids.iter().map(|&v| curvature.area[v as usize]).collect();
        let clusters = classify(&samples, &weights, demand.clusters, context)?;
        let mut cluster = vec![NONE; used.len()];
        ids.iter().zip(&clusters.of).for_each(|(&v, &c)| cluster[v as usize] = c);
        (clusters, cluster)
    };
    let Regions { mut label, curvature: of } = {
        let _stage = context.stage("growth");
        grow(surface, sharp, &cluster, &clusters.centers, free, order, context)?
    };
    let _stage = context.stage("merging");
    let smooth = |v: u32| (!sharp.vertex[v as usize]).then(|| pair(v));
    let full = |v: u32| full[v as usize].map(|k| k * scale);
    let vertex = BoundaryCurvature { smooth: &smooth, full: &full };
    let regions = Regions { label: std::mem::take(&mut label), curvature: of };
    let small = SmallArea {
        smooth: demand.min_area * surface.total_area,
        across_creases: demand.min_area_across_creases * surface.total_area,
    };
    let dendrogram = merge(surface, sharp, &regions, &vertex, small, context)?;
    let threshold = demand.threshold.unwrap_or_else(|| dendrogram.automatic_threshold());
    let merges = match demand.regions {
        Some(count) => dendrogram.until_count(count),
        None => dendrogram.until_threshold(threshold),
    };
    let number = dendrogram.cut(merges);
    let label = regions.label.iter().map(|&l| if l == NONE { NONE } else { number[l as usize] }).collect();
    Ok(CurvatureRegions { label, dendrogram, clusters: clusters.centers.len(), threshold })
}

/// Every value averaged with those at the other ends of its smooth edges.
fn averaged(surface: &Surface<'_>, sharp: &Sharp, values: &[Pair]) -> Vec<Pair> {
    let t = surface.triangles;
    let mut sum: Vec<[f64; 3]> = values.iter().map(|v| [v[0], v[1], 1.0]).collect();
    for c in (0..3 * t.len() as u32).filter(|&c| !sharp.edge[c as usize]) {
        // Each inner edge is met from both sides and adds to the vertex that its half-edge leaves.
        let (from, to) = (&mut sum[t.vertex(c) as usize], values[t.vertex(t.next(c)) as usize]);
        *from = [from[0] + to[0], from[1] + to[1], from[2] + 1.0];
    }
    sum.into_iter().map(|s| [s[0] / s[2], s[1] / s[2]]).collect()
}
