//! Hexes and sewing (section 3.1 "Génération des hexaèdres", figures 3 and 4).
//!
//! Vertices are numbered node by node, their number known beforehand: a node of valence n ≥ 2 has its centre, the n + 2
//! corners and 2 n side middles of its connection surface, an extremity its centre, four corners and four middles. Every
//! segment has four hexes about its axis; hex k stands on corner k, middle k and corner k + 1 of the quad at either end:
//!
//! ```text
//!      V₁────M₀            hex k: centre, Vₖ, Mₖ, Vₖ₊₁ at the near node,
//!      │  h₀ │╲            the same at the far one
//!      ·─────V₀
//! ```
//!
//! Two hexes meet at every side of a connection surface because they use the same middle and corners: that is the whole
//! sewing, local to the node. A cubic junction has 27 vertices, and eight hexes that come after those of the segments.

use super::connection::PartitionSearch;
use super::cubic::{self, Cubes};
use super::frames::{Frames, Quad, frames};
use crate::mesh::{Chains, CurveNet, Incidence, NONE};
use glam::DVec3;
use rayon::prelude::*;

/// Nodes whose vertices one task places: enough work to pay for a task.
const NODES: usize = 1024;
/// Branchings whose connection surfaces one task looks for; each takes much longer than placing a node.
const SURFACES_PER_TASK: usize = 64;

/// The coarsest mesh of a net.
#[derive(Debug, Clone)]
pub struct BaseMesh {
    /// Positions, node by node.
    pub points: Vec<DVec3>,
    /// Cells, four per segment, in the order of the segments; their third axis runs along it. Then eight per cubic junction.
    pub hexes: Vec<[u32; 8]>,
    /// First vertex of every node (its centre), and the number of vertices.
    pub first: Vec<u32>,
    /// Near and far node of every segment, in the sense of its cells.
    pub segments: Vec<[u32; 2]>,
    /// Branchings with a connection surface that does not include all directions.
    pub poor: Vec<u32>,
    /// The cubic junctions.
    pub cubes: Cubes,
}

/// Builds the base mesh.
///
/// Everything is numbered beforehand and written to its place; what branchings, branches, nodes and segments need is found
/// in parallel, each from what was found before. `cubic` allows cubic junctions.
pub fn base_mesh(net: &CurveNet, cubic: bool) -> BaseMesh {
    let around = net.incidence();
    let all = Chains::new(net, &around);
    let cubes = if cubic { Cubes::new(net, &around) } else { Cubes::default() };
    let first = offsets(net, &around, &cubes);
    // Touched for the first time by several threads: the system's work of handing out memory is shared too.
    let mut points: Vec<DVec3> = (0..first[net.points.len()]).into_par_iter().map(|_| DVec3::ZERO).collect();
    let surfaces = Surfaces::new(net, &around, &first, &cubes, &mut points);
    let quad = |node: u32, edge: u32| -> Option<Quad> {
        let corners = surfaces.side(&around, node, edge)?;
        let centre = net.points[node as usize];
        Some(std::array::from_fn(|k| points[corners[k] as usize] - centre))
    };
    let frames = frames(net, &all, quad);
    let places = Places::new(net, &all);
    place_rings(net, &first, &frames, &places, &mut points);
    let seam = |e: usize| {
        let at = places.of_edge[e] as usize;
        [all.nodes[at], all.nodes[at + 1]]
    };
    let hexes = (0..net.edges.len()).into_par_iter().map(|e| {
        let [near, far] = seam(e);
        let at = places.of_edge[e] as usize;
        let turn = usize::from(frames.turns[at]);
        let side = |node: u32, forward: bool| -> [u32; 9] {
            surfaces.side(&around, node, e as u32).unwrap_or_else(|| {
                let base = first[node as usize];
                // Seen against the branch the ring runs backwards.
                let order = if forward { [1, 2, 3, 4, 5, 6, 7, 8, 0] } else { [1, 4, 3, 2, 8, 7, 6, 5, 0] };
                order.map(|k| base + k)
            })
        };
        let (a, b) = (side(near, true), side(far, false));
        std::array::from_fn(|k| {
            // Corner k meets corner turn − k of the quad seen from the other side.
            let (after, opposite) = ((turn + 3 - k) % 4, (turn + 4 - k) % 4);
            [a[8], a[k], a[4 + k], a[(k + 1) % 4], b[8], b[opposite], b[4 + after], b[after]]
        })
    });
    let mut hexes = hexes.collect::<Vec<[[u32; 8]; 4]>>().into_flattened();
    for (node, _) in &cubes.list {
        hexes.extend(cubic::hexes().map(|h| h.map(|v| first[*node as usize] + v)));
    }
    let segments = (0..net.edges.len()).into_par_iter().map(seam).collect();
    BaseMesh { points, hexes, first, segments, poor: surfaces.poor, cubes }
}

/// The connection surfaces of all branchings.
struct Surfaces {
    /// First of the sides of every branching.
    first: Vec<u32>,
    /// Towards every segment of every branching: the vertices of its quad, corners first, then the middles of its sides, last
    /// the centre.
    sides: Vec<[u32; 9]>,
    /// The branchings whose surface leaves a direction out.
    poor: Vec<u32>,
}

/// What one task has of the vertices and sides.
struct Share<'a> {
    branchings: &'a [u32],
    points: &'a mut [DVec3],
    sides: &'a mut [[u32; 9]],
}

impl Share<'_> {
    /// Fills in the surfaces; the branchings whose surface is poor.
    fn fill(self, net: &CurveNet, around: &Incidence, vertex: &[u32], cubes: &Cubes) -> Vec<u32> {
        let (mut search, mut directions, mut poor) = (PartitionSearch::default(), Vec::new(), Vec::new());
        let start = vertex[self.branchings[0] as usize];
        let mut sides = self.sides.iter_mut();
        for &v in self.branchings {
            let (centre, radius) = (net.points[v as usize], net.radii[v as usize]);
            let [from, to] = [v, v + 1].map(|v| (vertex[v as usize] - start) as usize);
            let own = &mut self.points[from..to];
            let base = vertex[v as usize];
            if let Some(cube) = cubes.get(v) {
                own.iter_mut().zip(cube.points()).for_each(|(p, q)| *p = centre + radius * q);
                let of = |k: usize| cube.section(k).map(|w| base + w);
                (0..around.valence(v)).zip(sides.by_ref()).for_each(|(k, side)| *side = of(k));
                continue;
            }
            let direction = |s: &[u32; 2]| (net.points[s[1] as usize] - centre).normalize_or(DVec3::X);
            directions.clear();
            directions.extend(around.of(v).iter().map(direction));
            let surface = search.partition(&directions);
            if !(surface.least_determinant(&directions) > 0.0) {
                poor.push(v);
            }
            let corners = surface.vertices.len();
            own[0] = DVec3::ZERO;
            own[1..=corners].copy_from_slice(&surface.vertices);
            surface.side_middles(&directions, &mut own[corners + 1..]);
            own.iter_mut().for_each(|p| *p = centre + radius * *p);
            for ((q, s), side) in surface.quads.iter().zip(&surface.sides).zip(sides.by_ref()) {
                *side = std::array::from_fn(|k| match k {
                    0..4 => base + 1 + q[k],
                    4..8 => base + 1 + corners as u32 + s[k - 4],
                    _ => base,
                });
            }
        }
        poor
    }
}

impl Surfaces {
    /// Finds the surfaces, and puts their vertices on the spheres about the branchings; those of cubes to their places.
    fn new(net: &CurveNet, around: &Incidence, vertex: &[u32], cubes: &Cubes, points: &mut [DVec3]) -> Surfaces {
        let branchings: Vec<u32> = (0..net.points.len() as u32).filter(|&v| around.valence(v) > 2).collect();
        let mut first = vec![NONE; net.points.len()];
        let mut count = 0;
        for &v in &branchings {
            first[v as usize] = count;
            count += around.valence(v) as u32;
        }
        let mut sides = vec![[0; 9]; count as usize];
        let mut shares = Vec::with_capacity(branchings.len().div_ceil(SURFACES_PER_TASK));
        let (mut points_left, mut sides_left) = (points, &mut sides[..]);
        let mut done = 0;
        for branchings in branchings.chunks(SURFACES_PER_TASK) {
            let [from, to] = [branchings[0], branchings[branchings.len() - 1] + 1].map(|v| vertex[v as usize]);
            let count = branchings.iter().map(|&v| around.valence(v)).sum();
            let (points, sides);
            (points, points_left) = points_left.split_at_mut((to - done) as usize);
            (sides, sides_left) = sides_left.split_at_mut(count);
            shares.push(Share { branchings, points: &mut points[(from - done) as usize..], sides });
            done = to;
        }
        let poor =
            shares.into_par_iter().map(|share| share.fill(net, around, vertex, cubes)).collect::<Vec<_>>().concat();
        Surfaces { first, sides, poor }
    }

    /// The vertices of the quad of a branching towards a segment; `None` for other nodes.
    fn side(&self, around: &Incidence, node: u32, edge: u32) -> Option<[u32; 9]> {
        let first = self.first[node as usize];
        let slot = |slots: &[[u32; 2]]| slots.iter().position(|s| s[0] == edge).unwrap_or(0);
        (first != NONE).then(|| self.sides[first as usize + slot(around.of(node))])
    }
}

/// Where nodes and segments stand in the branches.
struct Places {
    /// Of articulations and extremities; branchings are in many.
    of_node: Vec<u32>,
    of_edge: Vec<u32>,
}

impl Places {
    fn new(net: &CurveNet, all: &Chains) -> Places {
        let (mut of_node, mut of_edge) = (vec![NONE; net.points.len()], vec![0; net.edges.len()]);
        // A ring ends where it starts: its frame there is that of the start, which is seen last.
        for (at, (&node, &edge)) in all.nodes.iter().zip(&all.edges).enumerate().rev() {
            of_node[node as usize] = at as u32;
            if edge != NONE {
                of_edge[edge as usize] = at as u32;
            }
        }
        Places { of_node, of_edge }
    }
}

/// First vertex of every node.
fn offsets(net: &CurveNet, around: &Incidence, cubes: &Cubes) -> Vec<u32> {
    let mut first = Vec::with_capacity(net.points.len() + 1);
    let mut next = 0;
    for v in 0..net.points.len() as u32 {
        first.push(next);
        let n = around.valence(v) as u32;
        next += match cubes.get(v) {
            Some(_) => cubic::VERTICES,
            None if n < 2 => 9,
            None => 3 * n + 3,
        };
    }
    first.push(next);
    first
}

/// The rings of articulations and extremities, of the radius of their nodes.
fn place_rings(net: &CurveNet, first: &[u32], frames: &Frames, places: &Places, points: &mut [DVec3]) {
    let nodes = net.points.len();
    let mut shares = Vec::with_capacity(nodes.div_ceil(NODES));
    let mut left = points;
    for from in (0..nodes).step_by(NODES) {
        let to = (from + NODES).min(nodes);
        let own;
        (own, left) = left.split_at_mut((first[to] - first[from]) as usize);
        shares.push((from..to, own));
    }
    shares.into_par_iter().for_each(|(nodes, own)| {
        let start = first[nodes.start];
        for v in nodes {
            let own = &mut own[(first[v] - start) as usize..(first[v + 1] - start) as usize];
            let (p, r) = (net.points[v], net.radii[v]);
            // Branchings have more vertices, and have them already.
            if own.len() == 9 {
                own[0] = p;
                let ring = frames.rings.get(places.of_node[v] as usize).copied().unwrap_or_default();
                own[1..].iter_mut().zip(ring.directions()).for_each(|(q, d)| *q = p + r * d);
            }
        }
    });
}
