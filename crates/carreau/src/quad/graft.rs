//! Regions that the motorcycle graph cannot do take the quads of rung 3. What is beside them meets these at the features between:
//! the numbers along them, and the vertices, are those of rung 3.
//!
//! ```text
//!   ──┬───┬───┃╲  ╱┃
//!     │   │   ┃ ╲╱ ┃      ━ feature with the vertices of rung 3
//!   ──┼───┼───┃╌╱╲╌┃
//!     │   │   ┃╱  ╲┃
//!   ──┴───┴───┃    ┃
//!   graph        rung 3
//! ```

use super::layout::{Kind, Layout};
use super::sheet::Sheet;
use super::source::Source;
use super::work::{Place, Work};
use crate::mesh::NONE;
use glam::DVec3;
use rustc_hash::{FxHashMap, FxHashSet};
use std::collections::{BTreeMap, BTreeSet};

/// Shares of the way around at which the sense of curves that close is told.
const ABOUT: [f64; 3] = [0.2, 0.35, 0.45];

/// The quads of rung 3, ready to be taken from.
pub struct Donor<'a> {
    work: &'a Work,
    /// The vertices along every curve, one after the other; the first one is the last, too, where it closes.
    chains: BTreeMap<u32, Vec<u32>>,
    /// Numbers of quads in every region.
    quads: Vec<usize>,
}

/// The arcs along a curve beside a region that takes quads, one after the other.
#[derive(Debug, Clone, Default)]
pub struct Strand {
    /// Arcs, and whether the strand runs along them from their end.
    pub arcs: Vec<(u32, bool)>,
    /// A patch that takes quads.
    pub patch: usize,
    /// As many quads along them as there are.
    pub total: i64,
    /// The vertices of the donor.
    vertices: Vec<u32>,
}

impl<'a> Donor<'a> {
    pub fn new(work: &'a Work, source: &Source) -> Self {
        let mut quads = vec![0; source.regions];
        work.region.iter().for_each(|&r| quads[r as usize] += 1);
        let mut edges: BTreeMap<u32, Vec<[u32; 2]>> = BTreeMap::new();
        work.features.iter().for_each(|&(ends, curve)| edges.entry(curve).or_default().push(ends));
        let chains = edges.into_iter().filter_map(|(curve, edges)| Some((curve, Path::of(&edges)?.vertices))).collect();
        Donor { work, chains, quads }
    }

    /// Number of quads.
    pub fn count(&self) -> usize {
        self.work.faces.len()
    }

    /// Gives patches of triangles that are taken the donor's quads, and the arcs around them its numbers. The error are the
    /// curves around that are others there.
    pub fn graft(&self, sheet: &Sheet, layout: &mut Layout, is_taken: impl Fn(u32) -> bool) -> Result<(), Vec<u32>> {
        // The arcs of every curve beside them.
        let mut curves: BTreeMap<u32, (usize, BTreeSet<u32>)> = BTreeMap::new();
        let (mut regions, mut others) = (FxHashSet::default(), FxHashSet::default());
        for (p, patch) in layout.patches.iter_mut().enumerate() {
            let arcs = patch.loops.iter().flatten().map(|side| side.arc);
            let on_curves = arcs.filter_map(|a| Some((layout.arcs[a as usize].curve?, a)));
            if !is_taken(patch.triangles[0]) {
                others.extend(on_curves.map(|(curve, _)| curve));
                continue;
            }
            for (curve, arc) in on_curves {
                curves.entry(curve).or_insert((p, BTreeSet::new())).1.insert(arc);
            }
            let region = sheet.region[patch.triangles[0] as usize];
            patch.kind = Kind::Grafted;
            // Coarse triangles may be in parts that the region is not.
            layout.grafted += if regions.insert(region) { self.quads[region as usize] } else { 0 };
        }
        // Between two of them there is nothing to be matched.
        curves.retain(|curve, _| others.contains(curve));
        let mut missing = Vec::new();
        for (curve, (patch, arcs)) in curves {
            let chain = self.chains.get(&curve);
            let Some(strand) = chain.and_then(|chain| self.strand(sheet, layout, chain, patch, &arcs)) else {
                missing.push(curve);
                continue;
            };
            let length: f64 = strand.arcs.iter().map(|a| layout.arcs[a.0 as usize].length).sum();
            for &(a, _) in &strand.arcs {
                let arc = &mut layout.arcs[a as usize];
                (arc.given, arc.least) = (Some(strand.total as f64 * arc.length / length), 1);
            }
            layout.strands.push(strand);
        }
        if missing.is_empty() { Ok(()) } else { Err(missing) }
    }

    /// The arcs of a curve in order, with the donor's vertices from the same end on, the same way round.
    fn strand(
        &self,
        sheet: &Sheet,
        layout: &Layout,
        chain: &[u32],
        patch: usize,
        arcs: &BTreeSet<u32>,
    ) -> Option<Strand> {
        let list: Vec<u32> = arcs.iter().copied().collect();
        let vertices_of = |a: u32| &layout.arcs[a as usize].vertices;
        let ends: Vec<[u32; 2]> = list.iter().map(|&a| vertices_of(a)).map(|v| [v[0], v[v.len() - 1]]).collect();
        let Path { vertices: mut nodes, mut steps } = Path::of(&ends)?;
        let mut chain = chain.to_vec();
        let there = |v: u32| sheet.points[v as usize];
        let here = |v: u32| self.work.points[v as usize];
        match (closes(&nodes), closes(&chain)) {
            (true, true) => {
                // From where the two are nearest to each other: a corner, if there is one.
                let pairs = (0..steps.len()).flat_map(|k| (0..chain.len() - 1).map(move |j| (k, j)));
                let off = |&(k, j): &(usize, usize)| there(nodes[k]).distance_squared(here(chain[j]));
                let (k, j) = pairs.min_by(|a, b| off(a).total_cmp(&off(b)))?;
                steps.rotate_left(k);
                rotate(&mut nodes, k);
                rotate(&mut chain, j);
            }
            (false, false) => {}
            _ => return None,
        }
        let mut places = vec![there(nodes[0])];
        for &(k, is_back) in &steps {
            let along = vertices_of(list[k]);
            let vertices: Vec<u32> = if is_back { along.iter().rev().copied().collect() } else { along.clone() };
            places.extend(vertices[1..].iter().map(|&v| there(v)));
        }
        let off = |chain: &[u32]| {
            let own: Vec<DVec3> = chain.iter().map(|&v| here(v)).collect();
            ABOUT.iter().map(|&share| at_share(&places, share).distance(at_share(&own, share))).sum::<f64>()
        };
        let back: Vec<u32> = chain.iter().rev().copied().collect();
        let vertices = if off(&back) < off(&chain) { back } else { chain };
        let arcs = steps.iter().map(|&(k, is_back)| (list[k], is_back)).collect();
        Some(Strand { arcs, patch, total: vertices.len() as i64 - 1, vertices })
    }

    /// Sets the donor's vertices along arcs into a mesh: `node` tells the ids of those of the sheet that are nodes. The error
    /// are patches whose numbers do not add up.
    pub fn plant(&self, layout: &Layout, work: &mut Work, node: &mut [u32]) -> Result<Planted, Vec<usize>> {
        let mut planted = Planted { id: vec![NONE; self.work.points.len()], ..Planted::default() };
        let mut wrong = FxHashSet::default();
        for strand in &layout.strands {
            let mut at = 0;
            for &(a, is_back) in &strand.arcs {
                let arc = &layout.arcs[a as usize];
                let next = at + arc.count.max(0) as usize;
                let part = strand.vertices.get(at..=next).unwrap_or_default();
                let mut ids: Vec<u32> = part.iter().map(|&v| planted.id(self.work, v, work)).collect();
                if is_back {
                    ids.reverse();
                }
                for (v, id) in
                    arc.vertices.first().zip(ids.first()).into_iter().chain(arc.vertices.last().zip(ids.last()))
                {
                    let node = &mut node[*v as usize];
                    if *node != NONE && *node != *id {
                        wrong.insert(a);
                    }
                    *node = *id;
                }
                planted.along.insert(a, ids);
                at = next;
            }
            if at as i64 != strand.total {
                wrong.extend(strand.arcs.iter().map(|a| a.0));
            }
        }
        if wrong.is_empty() {
            return Ok(planted);
        }
        let is_beside = |p: &usize| {
            let patch = &layout.patches[*p];
            patch.kind != Kind::Grafted && patch.loops.iter().flatten().any(|side| wrong.contains(&side.arc))
        };
        Err((0..layout.patches.len()).filter(is_beside).collect())
    }

    /// The quads of a region, once.
    pub fn fill(&self, region: u32, planted: &mut Planted, work: &mut Work) {
        if !planted.regions.insert(region) {
            return;
        }
        for (q, face) in self.work.faces.iter().enumerate().filter(|(q, _)| self.work.region[*q] == region) {
            let ids: Vec<u32> = face.iter().map(|&v| planted.id(self.work, v, work)).collect();
            work.faces.push(&ids);
            work.region.push(self.work.region[q]);
        }
    }

    /// The features between regions that have the donor's quads.
    pub fn inner_features(&self, planted: &Planted, work: &mut Work) {
        let known: FxHashSet<[u32; 2]> = work.features.iter().map(|f| sorted(f.0)).collect();
        let has_both = |f: &&([u32; 2], u32)| f.0.iter().all(|&v| planted.id[v as usize] != NONE);
        for (ends, curve) in self.work.features.iter().filter(has_both) {
            let ends = ends.map(|v| planted.id[v as usize]);
            if !known.contains(&sorted(ends)) {
                work.features.push((ends, *curve));
            }
        }
    }
}

/// Where the donor's vertices are in another mesh.
#[derive(Default)]
pub struct Planted {
    id: Vec<u32>,
    /// Regions that have their quads.
    regions: FxHashSet<u32>,
    /// Vertices along arcs, from node to node.
    pub along: FxHashMap<u32, Vec<u32>>,
}

impl Planted {
    fn id(&mut self, from: &Work, v: u32, work: &mut Work) -> u32 {
        if self.id[v as usize] == NONE {
            self.id[v as usize] = work.points.len() as u32;
            work.points.push(from.points[v as usize]);
            // Its quads have been found good where they are.
            work.place.push(Place::Fixed);
        }
        self.id[v as usize]
    }
}

/// Edges that are one path.
struct Path {
    /// In order; the first one again at the end where it closes.
    vertices: Vec<u32>,
    /// The edges in order, and whether it runs along them from their second end.
    steps: Vec<(usize, bool)>,
}

impl Path {
    /// `None` where they are more than one, or branch.
    fn of(edges: &[[u32; 2]]) -> Option<Self> {
        let mut at: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        for (k, ends) in edges.iter().enumerate() {
            ends.iter().for_each(|&v| at.entry(v).or_default().push(k));
        }
        let end = at.iter().find(|(_, edges)| edges.len() == 1).map(|(&v, _)| v);
        let mut v = end.or_else(|| edges.first().map(|e| e[0]))?;
        let mut path = Path { vertices: vec![v], steps: Vec::new() };
        let mut is_used = vec![false; edges.len()];
        while let Some(&k) = at[&v].iter().find(|&&k| !is_used[k]) {
            is_used[k] = true;
            let is_back = edges[k][0] != v;
            v = edges[k][usize::from(!is_back)];
            path.steps.push((k, is_back));
            path.vertices.push(v);
        }
        let is_one = path.steps.len() == edges.len() && at.values().all(|edges| edges.len() <= 2);
        is_one.then_some(path)
    }
}

fn sorted([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// Whether a path comes back to where it begins.
fn closes(path: &[u32]) -> bool {
    path.first() == path.last()
}

/// The same closed path from another vertex on.
fn rotate(path: &mut Vec<u32>, first: usize) {
    path.pop();
    path.rotate_left(first);
    path.extend(path.first().copied());
}

/// The place at a share of the length of a polyline.
fn at_share(places: &[DVec3], share: f64) -> DVec3 {
    let length: f64 = places.windows(2).map(|w| w[0].distance(w[1])).sum();
    let mut left = share * length;
    for w in places.windows(2) {
        let step = w[0].distance(w[1]);
        if left <= step {
            return w[0].lerp(w[1], if step > 0.0 { left / step } else { 0.0 });
        }
        left -= step;
    }
    places[places.len() - 1]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_in_any_order_and_sense_are_a_path() {
        let path = Path::of(&[[4, 7], [2, 9], [7, 2]]).unwrap();
        assert_eq!((path.vertices, path.steps), (vec![4, 7, 2, 9], vec![(0, false), (2, false), (1, false)]));
        let closed = Path::of(&[[1, 2], [1, 3], [3, 2]]).unwrap();
        assert!(closes(&closed.vertices) && closed.steps == [(0, false), (2, true), (1, true)]);
        assert!(Path::of(&[[5, 5]]).is_some_and(|loop_| loop_.vertices == [5, 5]));
        // A branch, two paths, nothing.
        for edges in [&[[0, 1], [1, 2], [1, 3]][..], &[[0, 1], [2, 3]], &[]] {
            assert!(Path::of(edges).is_none());
        }
    }

    #[test]
    fn closed_paths_begin_anywhere_and_shares_of_length_are_places() {
        let mut path = vec![3, 4, 5, 3];
        rotate(&mut path, 2);
        assert_eq!(path, [5, 3, 4, 5]);
        let places = [DVec3::ZERO, DVec3::X, DVec3::X + 3.0 * DVec3::Y];
        assert_eq!(at_share(&places, 0.25), DVec3::X);
        assert_eq!(at_share(&places, 0.5), DVec3::X + DVec3::Y);
        assert_eq!(at_share(&places, 1.0), places[2]);
    }
}
