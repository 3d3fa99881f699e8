//! Region merging (§4.4): the adjacency graph, reduced by its cheapest edge until one region is left; the dendrogram
//! keeps every step, so that another threshold or count needs no second run.

use super::classify::{Pair, distance};
use super::growth::Regions;
use super::surface::{Sharp, Surface};
use crate::context::Context;
use crate::error::Result;
use crate::mesh::NONE;
use rustc_hash::FxHashMap;
use serde::{Deserialize, Serialize};
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// A merge of two regions.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Merge {
    /// The region that goes on.
    pub kept: u32,
    /// The region that disappears.
    pub gone: u32,
    /// Their distance D, equation 1.
    pub distance: f64,
}

/// All merges from the grown regions to one region per component.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Dendrogram {
    /// Number of regions before the first merge.
    pub regions: u32,
    /// The merges in order.
    pub merges: Vec<Merge>,
}

impl Dendrogram {
    /// Number of merges to do for a threshold on D: up to the first that costs more.
    pub fn until_threshold(&self, threshold: f64) -> usize {
        self.merges.iter().position(|m| m.distance > threshold).unwrap_or(self.merges.len())
    }

    /// Number of merges to do for a number of regions.
    pub fn until_count(&self, regions: usize) -> usize {
        (self.regions as usize).saturating_sub(regions).min(self.merges.len())
    }

    /// The threshold in the widest gap of log D between 1 and 25; the paper's 5 where D grows
    /// without a gap.
    pub fn automatic_threshold(&self) -> f64 {
        let mut top = LEAST_THRESHOLD;
        let mut best = (LEAST_GAP, DEFAULT_THRESHOLD);
        for d in self.merges.iter().map(|m| m.distance).chain([LARGEST_THRESHOLD]) {
            let d = d.clamp(LEAST_THRESHOLD, LARGEST_THRESHOLD);
            if d > top {
                let gap = (d / top).ln();
                if gap > best.0 {
                    best = (gap, (d * top).sqrt());
                }
                top = d;
            }
        }
        best.1
    }

    /// The region that every grown region belongs to after the first `merges` merges, numbered from 0 in order.
    pub fn cut(&self, merges: usize) -> Vec<u32> {
        let mut parent: Vec<u32> = (0..self.regions).collect();
        // The last merges first: what a region is merged into has its own parent by then.
        self.merges[..merges].iter().rev().for_each(|m| parent[m.gone as usize] = parent[m.kept as usize]);
        let mut number = vec![NONE; parent.len()];
        let mut next = 0;
        for &root in &parent {
            if number[root as usize] == NONE {
                number[root as usize] = next;
                next += 1;
            }
        }
        parent.into_iter().map(|root| number[root as usize]).collect()
    }
}

/// Distance D, which has no unit: least automatic threshold, because regions below it hardly differ.
const LEAST_THRESHOLD: f64 = 1.0;
/// Distance D: largest automatic threshold, because regions above it differ much more than the paper's 5.
const LARGEST_THRESHOLD: f64 = 25.0;
/// Distance D: threshold where D grows without a gap, because it is the paper's.
const DEFAULT_THRESHOLD: f64 = 5.0;
/// Logarithm of a ratio: least gap of D that a threshold is put into, a factor of 1.5, because smaller ones are chance.
const LEAST_GAP: f64 = 0.4;
/// A factor: e of equation 4, small because small regions are to be merged first.
const SMALL_FACTOR: f64 = 1e-3;

/// What the merging needs to know of curvature: (k_max, |k_min|) times the length scale.
pub struct BoundaryCurvature<'a> {
    /// Smooth curvature of every vertex; [`None`] at sharp ones.
    pub smooth: &'a (dyn Fn(u32) -> Option<Pair> + Sync),
    /// Curvature across creases: the full tensor.
    pub full: &'a (dyn Fn(u32) -> Pair + Sync),
}

/// A_min of equation 4: regions of a smaller area are merged first.
#[derive(Debug, Clone, Copy)]
pub struct SmallArea {
    /// Across a smooth boundary.
    pub smooth: f64,
    /// Across a sharp one. On a part small faces between creases are faces; on a scan they are noise.
    pub across_creases: f64,
}

/// A common boundary of two regions.
#[derive(Clone, Copy, Default)]
struct Border {
    length: f64,
    sharp_length: f64,
    /// Length-weighted sum of c_ij.
    curvature: Pair,
    version: u64,
}

struct Candidate {
    distance: f64,
    pair: (u32, u32),
    version: u64,
}

impl Ord for Candidate {
    /// Reversed: the heap gives the cheapest first.
    fn cmp(&self, other: &Self) -> Ordering {
        other.distance.total_cmp(&self.distance).then(other.pair.cmp(&self.pair)).then(other.version.cmp(&self.version))
    }
}
impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl PartialEq for Candidate {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Candidate {}

struct Node {
    area: f64,
    perimeter: f64,
    curvature: Pair,
    /// Regions that share an edge, and some that are gone or listed twice: the borders decide.
    neighbours: Vec<u32>,
    /// Area and perimeter when the distances to all neighbours were last computed.
    refreshed: [f64; 2],
}

/// A count: nodes with more neighbours compute all distances anew only when they have changed by [`STALE_CHANGE`],
/// because that would take time that grows with the square.
const HUB_NEIGHBOURS: usize = 64;
/// A share of area and perimeter: distances are computed anew after a larger change, because smaller ones hardly move
/// them.
const STALE_CHANGE: f64 = 0.02;

/// The adjacency graph of regions.
struct Graph {
    nodes: Vec<Node>,
    borders: FxHashMap<(u32, u32), Border>,
    small: SmallArea,
    versions: u64,
}

fn key(a: u32, b: u32) -> (u32, u32) {
    (a.min(b), a.max(b))
}

impl Graph {
    fn new(
        surface: &Surface<'_>,
        sharp: &Sharp,
        regions: &Regions,
        vertex: &BoundaryCurvature<'_>,
        small: SmallArea,
    ) -> Self {
        let node =
            |&curvature| Node { area: 0.0, perimeter: 0.0, curvature, neighbours: Vec::new(), refreshed: [0.0; 2] };
        let mut nodes: Vec<Node> = regions.curvature.iter().map(node).collect();
        let mut borders: FxHashMap<(u32, u32), Border> = FxHashMap::default();
        let t = surface.triangles;
        for c in 0..3 * t.len() as u32 {
            let own = regions.label[c as usize / 3];
            if own == NONE {
                continue;
            }
            if c.is_multiple_of(3) {
                nodes[own as usize].area += surface.areas[c as usize / 3];
            }
            let o = t.opposite(c);
            let other = if o == NONE { NONE } else { regions.label[o as usize / 3] };
            if own == other {
                continue;
            }
            let length = surface.edge_length(c);
            nodes[own as usize].perimeter += length;
            if other == NONE || o < c {
                continue;
            }
            let border = borders.entry(key(own, other)).or_insert_with(|| {
                nodes[own as usize].neighbours.push(other);
                nodes[other as usize].neighbours.push(own);
                Border::default()
            });
            let k = edge_curvature(surface, sharp, vertex, c);
            border.length += length;
            border.sharp_length += if sharp.edge[c as usize] { length } else { 0.0 };
            border.curvature = [border.curvature[0] + length * k[0], border.curvature[1] + length * k[1]];
        }
        Graph { nodes, borders, small, versions: 0 }
    }

    /// D of two regions, equations 1 to 4.
    fn distance(&self, (i, j): (u32, u32), border: &Border) -> f64 {
        let (a, b) = (&self.nodes[i as usize], &self.nodes[j as usize]);
        let common = border.length.max(f64::MIN_POSITIVE);
        let c = border.curvature.map(|x| x / common);
        let curvature = distance(a.curvature, c) + distance(b.curvature, c);
        let nesting = a.perimeter.min(b.perimeter) / common;
        let limit =
            if 2.0 * border.sharp_length > border.length { self.small.across_creases } else { self.small.smooth };
        let filter = if a.area < limit || b.area < limit { SMALL_FACTOR } else { 1.0 };
        curvature * nesting * filter
    }

    /// Makes the current distance of a pair its only valid candidate.
    fn push(&mut self, pair: (u32, u32), heap: &mut BinaryHeap<Candidate>) {
        let Some(border) = self.borders.get_mut(&pair) else { return };
        self.versions += 1;
        border.version = self.versions;
        let border = *border;
        heap.push(Candidate { distance: self.distance(pair, &border), pair, version: border.version });
    }

    /// Merges `gone` into `kept`; returns the neighbours whose border is new or longer.
    fn merge(&mut self, kept: u32, gone: u32) -> Vec<u32> {
        let common = self.borders.remove(&key(kept, gone)).unwrap_or_default();
        let node = &mut self.nodes[gone as usize];
        let (area, perimeter, curvature) = (node.area, node.perimeter, node.curvature);
        let moved = std::mem::take(&mut node.neighbours);
        let into = &mut self.nodes[kept as usize];
        let total = (into.area + area).max(f64::MIN_POSITIVE);
        into.curvature = std::array::from_fn(|k| (into.area * into.curvature[k] + area * curvature[k]) / total);
        into.area += area;
        into.perimeter = (into.perimeter + perimeter - 2.0 * common.length).max(0.0);
        let mut touched = Vec::new();
        for n in moved {
            let Some(old) = self.borders.remove(&key(gone, n)) else { continue };
            touched.push(n);
            let border = self.borders.entry(key(kept, n)).or_insert_with(|| {
                self.nodes[n as usize].neighbours.push(kept);
                self.nodes[kept as usize].neighbours.push(n);
                Border::default()
            });
            border.length += old.length;
            border.sharp_length += old.sharp_length;
            border.curvature = std::array::from_fn(|k| border.curvature[k] + old.curvature[k]);
        }
        touched
    }

    /// The neighbours of a region whose distances are to be computed anew after a merge.
    fn outdated(&mut self, kept: u32, touched: Vec<u32>) -> Vec<u32> {
        let node = &mut self.nodes[kept as usize];
        let size = [node.area, node.perimeter];
        let changed = (0..2).any(|k| (size[k] - node.refreshed[k]).abs() > STALE_CHANGE * node.refreshed[k]);
        if node.neighbours.len() > HUB_NEIGHBOURS && !changed {
            return touched;
        }
        node.refreshed = size;
        let mut all = std::mem::take(&mut node.neighbours);
        all.sort_unstable();
        all.dedup();
        all.retain(|&n| self.borders.contains_key(&key(kept, n)));
        self.nodes[kept as usize].neighbours.clone_from(&all);
        all
    }
}

/// c_ij of one edge: across a crease the full tensor of its ends; else the smooth curvature of those ends that have one,
/// or of the opposite vertices.
fn edge_curvature(surface: &Surface<'_>, sharp: &Sharp, vertex: &BoundaryCurvature<'_>, c: u32) -> Pair {
    let t = surface.triangles;
    let ends = [t.vertex(c), t.vertex(t.next(c))];
    let mean = |values: &[Pair]| {
        let n = values.len() as f64;
        (n > 0.0).then(|| std::array::from_fn(|k| values.iter().map(|v| v[k]).sum::<f64>() / n))
    };
    let full = || ends.map(vertex.full);
    if sharp.edge[c as usize] {
        return mean(&full()).unwrap_or_default();
    }
    let smooth = |vs: [u32; 2]| mean(&vs.into_iter().filter_map(vertex.smooth).collect::<Vec<Pair>>());
    let apexes = [t.apex(c), t.apex(t.opposite(c))];
    smooth(ends).or_else(|| smooth(apexes)).or_else(|| mean(&full())).unwrap_or_default()
}

/// Merges regions all the way.
pub fn merge(
    surface: &Surface<'_>,
    sharp: &Sharp,
    regions: &Regions,
    vertex: &BoundaryCurvature<'_>,
    small: SmallArea,
    context: &Context,
) -> Result<Dendrogram> {
    let mut graph = Graph::new(surface, sharp, regions, vertex, small);
    let mut pairs: Vec<(u32, u32)> = graph.borders.keys().copied().collect();
    pairs.sort_unstable();
    let mut heap = BinaryHeap::new();
    pairs.into_iter().for_each(|pair| graph.push(pair, &mut heap));
    let mut dendrogram = Dendrogram { regions: regions.curvature.len() as u32, merges: Vec::new() };
    let mut step = 0;
    while let Some(Candidate { distance, pair, version }) = heap.pop() {
        context.check_every(step)?;
        step += 1;
        let Some(border) = graph.borders.get(&pair).filter(|b| b.version == version) else { continue };
        if graph.distance(pair, border) > distance * (1.0 + 1e-9) {
            graph.push(pair, &mut heap);
            continue;
        }
        // The one with fewer neighbours moves.
        let neighbours = |k: u32| graph.nodes[k as usize].neighbours.len();
        let (kept, gone) = if neighbours(pair.0) >= neighbours(pair.1) { pair } else { (pair.1, pair.0) };
        dendrogram.merges.push(Merge { kept, gone, distance });
        let touched = graph.merge(kept, gone);
        for n in graph.outdated(kept, touched) {
            graph.push(key(kept, n), &mut heap);
        }
    }
    Ok(dendrogram)
}
