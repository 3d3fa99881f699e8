//! The net itself: points with radii, and edges between them.

use crate::mesh::disjoint_sets::DisjointSets;
use glam::DVec3;

/// A graph drawn in space with a radius at every node: the skeleton of a tubular shape.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CurveNet {
    /// Positions of the nodes.
    pub points: Vec<DVec3>,
    /// Radii of the nodes; NaN where none is known.
    pub radii: Vec<f64>,
    /// Segments as pairs of nodes: no loop, none twice.
    pub edges: Vec<[u32; 2]>,
    /// Ids of the nodes in the file.
    pub ids: Vec<i64>,
    /// What the reader found and mended, for the record's `warnings`.
    pub notes: Vec<String>,
}

/// The segments at every node, as two flat arrays.
#[derive(Debug, Clone)]
pub struct Incidence {
    pub(super) offsets: Vec<u32>,
    /// Segment and its other node.
    pub(super) ends: Vec<[u32; 2]>,
}

impl Incidence {
    /// The segments at a node, in the order of their ids, each with its other node.
    pub fn of(&self, node: u32) -> &[[u32; 2]] {
        &self.ends[self.slots(node)]
    }

    /// Where the segments of a node stand in the list of all.
    pub fn slots(&self, node: u32) -> std::ops::Range<usize> {
        self.offsets[node as usize] as usize..self.offsets[node as usize + 1] as usize
    }

    /// Number of segments at a node.
    pub fn valence(&self, node: u32) -> usize {
        self.slots(node).len()
    }

    /// The nodes with one segment, in ascending order.
    pub fn tips(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.offsets.len() as u32 - 1).filter(|&v| self.valence(v) == 1)
    }
}

impl CurveNet {
    /// A net of nodes numbered from 0; edges must be valid.
    pub fn new(points: Vec<DVec3>, radii: Vec<f64>, edges: Vec<[u32; 2]>) -> Self {
        let ids = (0..points.len() as i64).collect();
        CurveNet { points, radii, edges, ids, notes: Vec::new() }
    }

    /// The segments at every node.
    pub fn incidence(&self) -> Incidence {
        let mut offsets = vec![0u32; self.points.len() + 1];
        self.edges.as_flattened().iter().for_each(|&v| offsets[v as usize + 1] += 1);
        for v in 0..self.points.len() {
            offsets[v + 1] += offsets[v];
        }
        let mut next = offsets.clone();
        let mut ends = vec![[0; 2]; 2 * self.edges.len()];
        for (&[a, b], e) in self.edges.iter().zip(0..) {
            for (v, other) in [(a, b), (b, a)] {
                ends[next[v as usize] as usize] = [e, other];
                next[v as usize] += 1;
            }
        }
        Incidence { offsets, ends }
    }

    /// Length of a segment.
    pub fn length(&self, edge: usize) -> f64 {
        let [a, b] = self.edges[edge];
        self.points[a as usize].distance(self.points[b as usize])
    }

    /// Component of every node, numbered in order of their first nodes, and how many there are.
    pub fn components(&self) -> (Vec<u32>, usize) {
        let mut sets = DisjointSets::new(self.points.len());
        self.edges.iter().for_each(|&[a, b]| sets.union(a, b));
        sets.labels()
    }

    /// Independent cycles, edges − nodes + 1, of every component that has an edge; ascending.
    pub fn cycles(&self) -> Vec<usize> {
        let (component, count) = self.components();
        let mut nodes = vec![0; count];
        let mut edges = vec![0; count];
        component.iter().for_each(|&c| nodes[c as usize] += 1);
        self.edges.iter().for_each(|e| edges[component[e[0] as usize] as usize] += 1);
        let mut cycles: Vec<usize> =
            nodes.iter().zip(&edges).filter(|&(_, &e)| e > 0).map(|(&n, &e): (&usize, &usize)| e + 1 - n).collect();
        cycles.sort_unstable();
        cycles
    }

    /// Length of the bounding box's diagonal.
    pub fn diagonal(&self) -> f64 {
        let low = self.points.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let high = self.points.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
        if self.points.is_empty() { 0.0 } else { low.distance(high) }
    }

    /// The net without the nodes that are not kept, nor their segments.
    pub fn retain_nodes(&mut self, keep: &[bool]) {
        let mut new_id = vec![u32::MAX; keep.len()];
        let kept_nodes = keep.iter().enumerate().filter(|k| *k.1);
        (0..).zip(kept_nodes).for_each(|(k, (v, _))| new_id[v] = k);
        fn kept<T>(list: &mut Vec<T>, keep: &[bool]) {
            let mut flags = keep.iter();
            list.retain(|_| flags.next().is_none_or(|&k| k));
        }
        kept(&mut self.points, keep);
        kept(&mut self.radii, keep);
        kept(&mut self.ids, keep);
        self.edges.retain(|e| e.iter().all(|&v| keep[v as usize]));
        self.edges.iter_mut().for_each(|e| *e = e.map(|v| new_id[v as usize]));
    }

    /// Drops loops and edges that are there twice; says how many went.
    pub fn drop_multiple_edges(&mut self) -> usize {
        let before = self.edges.len();
        let mut order: Vec<([u32; 2], u32)> =
            self.edges.iter().zip(0..).map(|(&[a, b], k)| ([a.min(b), a.max(b)], k)).collect();
        order.sort_unstable();
        let mut keep = vec![false; before];
        for same in order.chunk_by(|a, b| a.0 == b.0) {
            let ([a, b], first) = same[0];
            keep[first as usize] = a != b;
        }
        let mut flags = keep.iter();
        self.edges.retain(|_| flags.next().is_none_or(|&k| k));
        before - self.edges.len()
    }
}
