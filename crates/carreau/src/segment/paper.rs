//! Regions of near-constant curvature: classification, growth and merging in a row (§4.2 to §4.4).

use super::classify::{Pair, classify};
use super::growth::{Regions, grow};
use super::merge::{BoundaryCurvature, Dendrogram, SmallArea, merge};
use super::surface::{Sharp, Surface};
use crate::context::Context;
use crate::error::Result;
use crate::geometry::curvature::Curvature;
use crate::mesh::NONE;
use rayon::prelude::*;

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

/// Finds the regions; curvatures are multiplied by the length `scale`.
#[expect(clippy::too_many_arguments, reason = "the inputs of four stages")]
pub fn curvature_regions(
    surface: &Surface<'_>,
    sharp: &Sharp,
    curvature: &Curvature,
    full: &[Pair],
    scale: f64,
    order: &[u32],
    demand: &Demand,
    context: &Context,
) -> Result<CurvatureRegions> {
    let magnitudes = |v: usize| {
        let (a, b) = (curvature.kmin[v].abs() * scale, curvature.kmax[v].abs() * scale);
        [a.max(b), a.min(b)]
    };
    let mut pairs: Vec<Pair> = (0..sharp.vertex.len()).map(magnitudes).collect();
    if demand.smoothing > 0 {
        let stars = Stars::new(surface, sharp);
        for _ in 0..demand.smoothing {
            context.check()?;
            pairs = stars.averaged(&pairs);
        }
    }
    let pair = |v: u32| pairs[v as usize];
    let mut used = vec![false; sharp.vertex.len()];
    for t in 0..surface.len() as u32 {
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
        grow(surface, sharp, &cluster, &clusters.centers, order, context)?
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

/// The vertices at the other ends of the smooth edges of every vertex.
struct Stars {
    /// Those of vertex `v`: `ends[start[v]..start[v + 1]]`.
    ends: Vec<u32>,
    start: Vec<u32>,
}

impl Stars {
    /// Each inner edge is met from both sides and listed at the vertex that its half-edge leaves.
    fn new(surface: &Surface<'_>, sharp: &Sharp) -> Self {
        let t = surface.triangles;
        let smooth = || (0..3 * t.len() as u32).filter(|&c| !sharp.edge[c as usize]);
        let mut start = vec![0u32; sharp.vertex.len() + 1];
        smooth().for_each(|c| start[t.vertex(c) as usize + 1] += 1);
        (1..start.len()).for_each(|k| start[k] += start[k - 1]);
        let (mut fill, mut ends) = (start.clone(), vec![0; start[sharp.vertex.len()] as usize]);
        for c in smooth() {
            let at = &mut fill[t.vertex(c) as usize];
            ends[*at as usize] = t.vertex(t.next(c));
            *at += 1;
        }
        Stars { ends, start }
    }

    /// Every value averaged with those at the ends.
    fn averaged(&self, values: &[Pair]) -> Vec<Pair> {
        let mean = |(v, own): (usize, &Pair)| {
            let ends = &self.ends[self.start[v] as usize..self.start[v + 1] as usize];
            let [mut x, mut y] = *own;
            for &end in ends {
                let [a, b] = values[end as usize];
                (x, y) = (x + a, y + b);
            }
            let n = ends.len() as f64 + 1.0;
            [x / n, y / n]
        };
        values.par_iter().enumerate().with_min_len(4096).map(mean).collect()
    }
}
