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
//! sewing, local to the node.

use super::connection::Connection;
use super::frames::{Framed, Ring, frames, quad_of};
use crate::mesh::{Branch, branches};
use crate::mesh::{CurveNet, Incidence};
use glam::DVec3;
use rayon::prelude::*;

/// Nodes whose vertices are placed by one task.
const CHUNK: usize = 2048;

/// The coarsest mesh of a net.
#[derive(Debug, Clone)]
pub struct BaseMesh {
    /// Positions, node by node.
    pub points: Vec<DVec3>,
    /// Cells, four per segment, in the order of the segments; their third axis runs along it.
    pub hexes: Vec<[u32; 8]>,
    /// First vertex of every node (its centre), and the number of vertices.
    pub first: Vec<u32>,
    /// Near and far node of every segment, in the sense of its cells.
    pub segments: Vec<[u32; 2]>,
    /// Branchings with a connection surface that does not include all directions.
    pub poor: Vec<u32>,
}

/// How the hexes of a segment stand on its nodes.
#[derive(Debug, Clone, Copy, Default)]
struct Seam {
    near: u32,
    far: u32,
    turn: u32,
}

/// Builds the base mesh.
pub fn base_mesh(net: &CurveNet) -> BaseMesh {
    let around = net.incidence();
    let all = branches(net, &around);
    let (index, connections, poor) = connections(net, &around);
    let of = |node: u32| connections.get(index[node as usize] as usize);
    let slot = |node: u32, edge: u32| around.of(node).iter().position(|s| s[0] == edge).unwrap_or(0);
    let framed = frames(net, &all, |node, edge| Some(quad_of(&of(node)?.surface, slot(node, edge))));
    let (seams, rings) = lay_out(net, &all, &framed);
    let first = offsets(net, &around);
    let points = place(net, &of, &rings);
    let hexes = (0..net.edges.len())
        .into_par_iter()
        .map(|e| {
            let Seam { near, far, turn } = seams[e];
            let side = |node: u32, forward: bool, k: u32| -> [u32; 2] {
                let (base, k) = (first[node as usize] + 1, k % 4);
                match of(node) {
                    Some(c) => {
                        let s = slot(node, e as u32);
                        let n = c.surface.quads.len() as u32;
                        [base + c.surface.quads[s][k as usize], base + n + 2 + c.surface.sides[s][k as usize]]
                    }
                    // Seen against the branch the ring runs backwards.
                    None if forward => [base + k, base + 4 + k],
                    None => [base + (4 - k) % 4, base + 4 + (3 - k)],
                }
            };
            std::array::from_fn(|k| {
                let k = k as u32;
                let ([v, m], [w, _]) = (side(near, true, k), side(near, true, k + 1));
                let (opposite, after) = (turn + 4 - k, turn + 3 - k);
                let ([v1, _], [w1, m1]) = (side(far, false, opposite), side(far, false, after));
                [first[near as usize], v, m, w, first[far as usize], v1, m1, w1]
            })
        })
        .collect::<Vec<[[u32; 8]; 4]>>()
        .into_flattened();
    BaseMesh { points, hexes, first, segments: seams.iter().map(|s| [s.near, s.far]).collect(), poor }
}

/// A connection surface with the middles of its sides.
struct Placed {
    surface: Connection,
    middles: Vec<DVec3>,
}

/// The connection surfaces of all branchings, the place of every node in their list, and the branchings whose surface
/// leaves a direction out.
fn connections(net: &CurveNet, around: &Incidence) -> (Vec<u32>, Vec<Placed>, Vec<u32>) {
    let branchings: Vec<u32> = (0..net.points.len() as u32).filter(|&v| around.valence(v) > 2).collect();
    let mut index = vec![u32::MAX; net.points.len()];
    branchings.iter().zip(0..).for_each(|(&v, k)| index[v as usize] = k);
    let placed: Vec<(Placed, bool)> = branchings
        .par_iter()
        .map(|&v| {
            let p = net.points[v as usize];
            let directions: Vec<DVec3> =
                around.of(v).iter().map(|s| (net.points[s[1] as usize] - p).normalize_or(DVec3::X)).collect();
            let surface = Connection::new(&directions);
            let good = surface.least_determinant(&directions) > 0.0;
            (Placed { middles: surface.side_middles(&directions), surface }, good)
        })
        .collect();
    let poor = branchings.iter().zip(&placed).filter(|p| !p.1.1).map(|p| *p.0).collect();
    (index, placed.into_iter().map(|p| p.0).collect(), poor)
}

/// Near and far node and turn of every segment; the ring of every articulation and extremity.
fn lay_out(net: &CurveNet, all: &[Branch], framed: &[Framed]) -> (Vec<Seam>, Vec<Ring>) {
    let mut seams = vec![Seam::default(); net.edges.len()];
    let mut rings = vec![Ring::default(); net.points.len()];
    for (branch, f) in all.iter().zip(framed) {
        for (k, &e) in branch.edges.iter().enumerate() {
            let turn = if k + 1 == branch.edges.len() { f.turn } else { 0 };
            seams[e as usize] = Seam { near: branch.nodes[k], far: branch.nodes[k + 1], turn };
        }
        // A ring ends where it starts: the frame there is that of the start.
        let own = if branch.is_ring { branch.nodes.len() - 1 } else { branch.nodes.len() };
        branch.nodes[..own].iter().zip(&f.rings).for_each(|(&v, ring)| rings[v as usize] = *ring);
    }
    (seams, rings)
}

/// First vertex of every node.
fn offsets(net: &CurveNet, around: &Incidence) -> Vec<u32> {
    let mut first = Vec::with_capacity(net.points.len() + 1);
    let mut next = 0;
    for v in 0..net.points.len() as u32 {
        first.push(next);
        let n = around.valence(v) as u32;
        next += if n < 2 { 9 } else { 3 * n + 3 };
    }
    first.push(next);
    first
}

/// Positions of all vertices: rings of the radius on articulations and extremities, spheres at branchings.
fn place<'a>(net: &CurveNet, of: &(impl Fn(u32) -> Option<&'a Placed> + Sync), rings: &[Ring]) -> Vec<DVec3> {
    let nodes = net.points.len();
    let place_chunk = |c: usize| {
        let mut points = Vec::with_capacity(9 * CHUNK);
        for v in c * CHUNK..((c + 1) * CHUNK).min(nodes) {
            let (p, r) = (net.points[v], net.radii[v]);
            points.push(p);
            match of(v as u32) {
                Some(c) => points.extend(c.surface.vertices.iter().chain(&c.middles).map(|d| p + r * *d)),
                None => {
                    let ring = &rings[v];
                    points.extend((0..4).map(|k| p + r * ring.at(ring.corners[k])));
                    points.extend((0..4).map(|k| p + r * ring.at(ring.middle(k))));
                }
            }
        }
        points
    };
    (0..nodes.div_ceil(CHUNK)).into_par_iter().map(place_chunk).collect::<Vec<_>>().concat()
}
