//! The model while it is made: edges may still be divided where a seam begins on them.

use super::curves::{Track, part};
use super::topology::Graph;
use super::tuning::{NEAR_VERTEX, SAME_POINT, STATED_FACTOR};
use crate::brep::{Brep, Curve, Edge, EdgeUse, Face, Surface, Vertex};
use glam::DVec3;

/// An edge with the vertices that divide it.
#[derive(Debug, Clone)]
pub struct DraftEdge {
    /// Its shape.
    pub curve: Curve,
    /// Parameters of its ends.
    pub range: [f64; 2],
    /// The vertices at its ends; none for a ring that has not been given one.
    pub ends: Option<[u32; 2]>,
    /// Distance from its surfaces.
    pub gap: f64,
    /// Vertices inside, with their parameters.
    pub splits: Vec<(f64, u32)>,
}

impl DraftEdge {
    /// The part of the edge between two places. Its curve is no more of a spline than that, because on a closed one other programs
    /// would have to guess which part is meant.
    fn between(&self, from: (f64, u32), to: (f64, u32)) -> Edge {
        let range = [from.0, to.0];
        let curve = part(&self.curve, range).unwrap_or_else(|| self.curve.clone());
        Edge { curve, range, ends: [from.1, to.1], tolerance: STATED_FACTOR * self.gap }
    }
}

/// A loop to which a second one, or a point, is joined by a seam.
#[derive(Debug, Clone)]
pub struct Merge {
    /// The loop that begins the joined one, and its vertex on the seam.
    pub first: (usize, u32),
    /// The other loop, or none for an apex or a pole, and its vertex on the seam.
    pub second: (Option<usize>, u32),
    /// The seam, and whether it runs against the way from the first to the second.
    pub seam: (u32, bool),
}

/// A face with loops of edges that may still be divided.
#[derive(Debug, Clone, Default)]
pub struct DraftFace {
    /// The loops around its piece: edges, and whether they are run against.
    pub loops: Vec<Vec<(u32, bool)>>,
    /// A seam.
    pub merge: Option<Merge>,
    /// A vertex that is a loop.
    pub pole: Option<u32>,
    /// Which of the loops is the outer one.
    pub outer: usize,
}

/// Vertices, edges and faces.
#[derive(Debug, Clone, Default)]
pub struct Draft {
    /// The vertices.
    pub vertices: Vec<Vertex>,
    /// The edges: those of the chains of the graph first.
    pub edges: Vec<DraftEdge>,
}

impl Draft {
    /// A new vertex.
    pub fn vertex(&mut self, point: DVec3, tolerance: f64) -> u32 {
        self.vertices.push(Vertex { point, tolerance });
        self.vertices.len() as u32 - 1
    }

    /// A new edge of a seam.
    pub fn seam(&mut self, curve: Curve, range: [f64; 2], ends: [u32; 2]) -> u32 {
        for (v, t) in ends.into_iter().zip(range) {
            let vertex = &mut self.vertices[v as usize];
            vertex.tolerance = vertex.tolerance.max(vertex.point.distance(curve.point(t)));
        }
        self.edges.push(DraftEdge { curve, range, ends: Some(ends), gap: 0.0, splits: Vec::new() });
        self.edges.len() as u32 - 1
    }

    /// The edges of the chains; vertices of the corners come first, in the order of the graph.
    pub fn edges_of(&mut self, tracks: Vec<Track>, graph: &Graph) {
        for (track, chain) in tracks.into_iter().zip(&graph.chains) {
            let corner = |v: u32| graph.corners.binary_search(&v).map_or(0, |k| k as u32);
            let ends =
                (!chain.closed).then(|| [chain.vertices[0], chain.vertices[chain.vertices.len() - 1]].map(corner));
            let Track { curve, range, gap, .. } = track;
            self.edges.push(DraftEdge { curve, range, ends, gap, splits: Vec::new() });
        }
    }

    /// The vertex of an edge at a parameter, made where there is none.
    pub fn vertex_on(&mut self, edge: u32, t: f64, diagonal: f64) -> u32 {
        let e = &self.edges[edge as usize];
        let point = e.curve.point(t);
        if e.ends.is_none() {
            // A closed spline begins where it begins: other programs cannot go past its ends.
            let range = e.range;
            let start = if matches!(e.curve, Curve::Spline(_)) { range[0] } else { t };
            let at = e.curve.point(start);
            let v = self.vertex(at, 0.0);
            let e = &mut self.edges[edge as usize];
            (e.range, e.ends) = ([start, start + (range[1] - range[0])], Some([v, v]));
        }
        let e = &self.edges[edge as usize];
        let ends = e.ends.unwrap_or_default();
        // A parameter of a ring may be a period off.
        let mut t = t;
        if let Some(period) = e.curve.period() {
            t += period * ((e.range[0] - t) / period).ceil();
            if t > e.range[1] && t - period >= e.range[0] - 1e-9 * period {
                t -= period;
            }
        }
        let near = |v: u32| {
            let vertex = &self.vertices[v as usize];
            vertex.point.distance(point) <= (SAME_POINT * diagonal).max(NEAR_VERTEX * vertex.tolerance)
        };
        let inside = e.range[0] < t && t < e.range[1];
        let nearest = ends[usize::from(t - e.range[0] > e.range[1] - t)];
        let known = ends.into_iter().chain(e.splits.iter().map(|s| s.1)).find(|&v| near(v));
        let known = known.or((!inside).then_some(nearest));
        known.unwrap_or_else(|| {
            let v = self.vertex(point, 0.0);
            let splits = &mut self.edges[edge as usize].splits;
            splits.push((t, v));
            splits.sort_by(|a, b| a.0.total_cmp(&b.0));
            v
        })
    }

    /// The model: edges divided, rings given a vertex, loops joined by seams.
    pub fn finish(mut self, surfaces: Vec<Surface>, faces: Vec<(Face, DraftFace)>) -> Brep {
        for e in 0..self.edges.len() {
            if self.edges[e].ends.is_none() {
                let point = self.edges[e].curve.point(self.edges[e].range[0]);
                let v = self.vertex(point, 0.0);
                self.edges[e].ends = Some([v, v]);
            }
        }
        let mut brep = Brep { vertices: self.vertices, surfaces, ..Brep::default() };
        // First of the edges that each becomes, and their number.
        let mut pieces = Vec::with_capacity(self.edges.len());
        for e in self.edges {
            let ends = e.ends.unwrap_or_default();
            let first = brep.edges.len() as u32;
            let mut cuts = vec![(e.range[0], ends[0])];
            cuts.extend(e.splits.iter().copied());
            cuts.push((e.range[1], ends[1]));
            for w in cuts.windows(2) {
                brep.edges.push(e.between(w[0], w[1]));
            }
            pieces.push((first, cuts.len() as u32 - 1));
        }
        for (mut face, draft) in faces {
            let expand = |uses: &Vec<(u32, bool)>| -> Vec<EdgeUse> {
                let all = uses.iter().flat_map(|&(edge, reversed)| {
                    let (first, count) = pieces[edge as usize];
                    (0..count)
                        .map(move |k| EdgeUse::new(if reversed { first + count - 1 - k } else { first + k }, reversed))
                });
                all.collect()
            };
            let mut loops: Vec<Option<Vec<EdgeUse>>> = draft.loops.iter().map(|l| Some(expand(l))).collect();
            if let Some(outer) = loops.get_mut(draft.outer).and_then(Option::take) {
                loops.insert(0, Some(outer));
            }
            // Where the loops went: the outer one to the front.
            let place = |k: usize| if k == draft.outer { 0 } else { k + 1 };
            if let Some(merge) = &draft.merge {
                let from = |uses: Option<Vec<EdgeUse>>, v: u32| -> Vec<EdgeUse> {
                    let mut uses = uses.unwrap_or_default();
                    if let Some(at) = uses.iter().position(|u| brep.start(u) == v) {
                        uses.rotate_left(at);
                    }
                    uses
                };
                let mut joined = from(loops[place(merge.first.0)].take(), merge.first.1);
                let (seam, against) = (pieces[merge.seam.0 as usize].0, merge.seam.1);
                joined.push(EdgeUse::new(seam, against));
                if let Some(second) = merge.second.0 {
                    joined.extend(from(loops[place(second)].take(), merge.second.1));
                }
                joined.push(EdgeUse::new(seam, !against));
                loops.insert(0, Some(joined));
            }
            face.loops = loops.into_iter().flatten().filter(|l| !l.is_empty()).collect();
            face.poles = draft.pole.into_iter().collect();
            brep.faces.push(face);
        }
        brep
    }
}
