//! Cells of second order: nodes in the middle of edges and faces, those of the boundary on the surface.
//!
//! ```text
//!   a ───────── b          a ──╮   ╭── b
//!   │           │             │  ╰─m─╯  │      m goes to the surface, or where there is none to the curve that meets
//!   │           │     →       │         │      the normals of the wall at a and b; layers beneath bend with it
//!   c ───────── d             c ─────── d
//! ```
//!
//! A cell with a curved side may fold although the straight one does not: each is certified with its 27 nodes, and as the cell of
//! 20 nodes with the same edges, by the Bernstein coefficients of its Jacobian. Edges of a cell that would fold are made straight.

use super::HexResult;
use super::boundary::SWELL;
use super::layers::{planes, within};
use super::middle_nodes::{MiddleOf, StraightEdges};
use super::target::{Part, Target};
use crate::context::Context;
use crate::error::Result;
use crate::geometry::hexes::uncertified;
use crate::geometry::second_order::{Nodes as Cell, is_certified, serendipity};
use crate::mesh::{HexMesh, MiddleNodes, SecondOrder};
use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

/// An edge that would bend by more than this share of its length stays straight: no smooth wall does, meshed as it should be.
const MOST_BENT: f64 = 0.3;
/// Rounds in which edges are made straight; then all edges of what is left are.
const STRAIGHTENING_ROUNDS: usize = 12;
/// Rounds in which corners that had left the surface go back to it.
const RETURNS: usize = 6;
/// Cells between two looks at the clock.
const CELLS_PER_CHECK: usize = 256;

/// Gives a mesh nodes of second order.
pub fn raise(result: &mut HexResult, target: Option<&Target>, context: &Context) -> Result<()> {
    let _stage = context.stage("second order");
    if let Some(target) = target {
        return_to(target, result, context)?;
    }
    let (nodes, middles) = SecondOrder::of(&result.mesh)?;
    let wall = Wall::of(&result.mesh, &result.bases, target);
    let mut curved = Curved::new(&result.mesh, &nodes, &middles, &wall);
    let straight = curved.certify(context)?;
    let places = curved.places();
    let middle = |&edge: &u32| {
        let [a, b] = middles.edges[edge as usize].map(|v| result.mesh.points[v as usize]);
        (0.5 * (a + b)).to_array()
    };
    let at = straight.first().map(middle);
    result.figures.straight_edges = Some(StraightEdges { count: straight.len(), at });
    result.second_order = Some(MiddleOf { nodes, places });
    Ok(())
}

/// Corners that have left the surface, for the sake of straight faces between them, go back, as far as cells stay certified.
fn return_to(target: &Target, result: &mut HexResult, context: &Context) -> Result<()> {
    let mesh = &mut result.mesh;
    let near = 2.0 * SWELL * target.surface().diagonal();
    let mut parts = vec![0; mesh.points.len()];
    for (q, &tag) in mesh.quads.iter().zip(&mesh.tags) {
        q.iter().for_each(|&v| parts[v as usize] = parts[v as usize].max(tag));
    }
    let own = |v: usize| parts[v] == 1 && result.bases[v] as usize == v;
    let start = mesh.points.clone();
    let place = |v: usize| {
        let to = own(v).then(|| target.closest_wall(start[v])).flatten();
        to.map(|(to, _)| to).filter(|to| to.distance(start[v]) <= near).unwrap_or(start[v])
    };
    mesh.points = (0..start.len()).into_par_iter().map(place).collect();
    for _ in 0..RETURNS {
        context.check()?;
        let bad = uncertified(&mesh.points, &mesh.hexes);
        if bad.is_empty() {
            return Ok(());
        }
        bad.iter().flat_map(|&h| mesh.hexes[h as usize]).for_each(|v| mesh.points[v as usize] = start[v as usize]);
    }
    mesh.points = start;
    Ok(())
}

/// The wall of a mesh as a smooth surface.
struct Wall<'a> {
    mesh: &'a HexMesh,
    /// The vertex of the wall that each vertex lies under, or that it was drawn from.
    bases: &'a [u32],
    target: Option<&'a Target<'a>>,
    /// Unit normals at the vertices.
    normals: Vec<DVec3>,
    /// The edges of the wall, with the tag of the end that some border on.
    edges: FxHashMap<[u32; 2], i32>,
    /// Its faces, by their corners, ascending.
    faces: FxHashMap<[u32; 4], usize>,
    planes: FxHashMap<u32, Vec<DVec3>>,
}

impl<'a> Wall<'a> {
    fn of(mesh: &'a HexMesh, bases: &'a [u32], target: Option<&'a Target<'a>>) -> Self {
        let mut normals = vec![DVec3::ZERO; mesh.points.len()];
        let (mut edges, mut faces) = (FxHashMap::default(), FxHashMap::default());
        let of = |wanted: fn(i32) -> bool| (0..mesh.quads.len()).filter(move |&f| wanted(mesh.tags[f]));
        for f in of(|tag| tag == 1) {
            let q = mesh.quads[f];
            let p = q.map(|v| mesh.points[v as usize]);
            for k in 0..4 {
                let (next, last) = ((k + 1) % 4, (k + 3) % 4);
                normals[q[k] as usize] += (p[next] - p[k]).cross(p[last] - p[k]).normalize_or_zero();
                edges.insert(pair(q[k], q[next]), 1);
            }
            faces.insert(sorted(q), f);
        }
        for f in of(|tag| tag > 1) {
            let q = mesh.quads[f];
            for k in 0..4 {
                if let Some(tag) = edges.get_mut(&pair(q[k], q[(k + 1) % 4])) {
                    *tag = mesh.tags[f];
                }
            }
        }
        normals.iter_mut().for_each(|n| *n = n.normalize_or_zero());
        Wall { mesh, bases, target, normals, edges, faces, planes: planes(mesh) }
    }

    fn at(&self, v: u32) -> DVec3 {
        self.mesh.points[v as usize]
    }

    /// How far the node of an edge is from its middle.
    fn bend(&self, edge: [u32; 2]) -> DVec3 {
        let [a, b] = edge.map(|v| self.bases[v as usize]);
        let Some(&tag) = self.edges.get(&pair(a, b)) else { return DVec3::ZERO };
        let (along, middle) = (self.at(b) - self.at(a), 0.5 * (self.at(a) + self.at(b)));
        let bend = match self.target {
            Some(target) => {
                self.on_surface(target, [a, b], tag, middle, along.length()).map_or(DVec3::ZERO, |p| p - middle)
            }
            // The middle of the cubic curve that is square to the normals at both ends.
            None => {
                let [na, nb] = [a, b].map(|v| {
                    let in_end = self.planes.get(&v).filter(|_| tag > 1);
                    within(in_end, self.normals[v as usize]).normalize_or_zero()
                });
                0.125 * (nb * along.dot(nb) - na * along.dot(na))
            }
        };
        if bend.length() <= MOST_BENT * along.length() { bend } else { DVec3::ZERO }
    }

    fn on_surface(&self, target: &Target, edge: [u32; 2], tag: i32, middle: DVec3, reach: f64) -> Option<DVec3> {
        let lid = (tag - 2) as u32;
        if tag > 1 && (lid as usize) < target.lids().len() {
            return Some(target.place(Part::Rim(lid), middle, DVec3::ZERO, reach).0);
        }
        let facing = edge.map(|v| self.normals[v as usize]);
        target.along_wall(middle, facing, reach).map(|found| found.0)
    }

    /// How far the node of a face is from where its edges have it; `middle` is that place.
    fn bulge(&self, face: [u32; 4], middle: impl Fn(&HexMesh, [u32; 4]) -> DVec3) -> DVec3 {
        let based = face.map(|v| self.bases[v as usize]);
        let (Some(&f), Some(target)) = (self.faces.get(&sorted(based)), self.target) else { return DVec3::ZERO };
        let q = self.mesh.quads[f];
        let (from, reach) = (middle(self.mesh, q), self.at(q[0]).distance(self.at(q[2])));
        let facing = [0, 2].map(|k| self.normals[q[k] as usize]);
        let to = target.along_wall(from, facing, reach).map_or(from, |found| found.0);
        if to.distance(from) <= MOST_BENT * reach { to - from } else { DVec3::ZERO }
    }
}

/// A mesh with curved edges.
struct Curved<'a> {
    mesh: &'a HexMesh,
    nodes: &'a SecondOrder,
    middles: &'a MiddleNodes,
    /// How far the nodes of edges and faces are from where straight edges, and the edges of the face, have them.
    bends: Vec<DVec3>,
    bulges: Vec<DVec3>,
    /// For every face a cell that has it, and which of that cell's it is.
    cell_of_face: Vec<(u32, usize)>,
}

impl<'a> Curved<'a> {
    fn new(mesh: &'a HexMesh, nodes: &'a SecondOrder, middles: &'a MiddleNodes, wall: &Wall) -> Self {
        let bends: Vec<DVec3> = middles.edges.par_iter().map(|e| wall.bend(*e)).collect();
        let first_face = middles.first + middles.edges.len() as u32;
        let mut cell_of_face = vec![(u32::MAX, 0); middles.faces.len()];
        for (h, nodes) in (0..).zip(&nodes.hexes) {
            for n in 12..18 {
                let of_face = &mut cell_of_face[(nodes[n] - first_face) as usize];
                if of_face.0 == u32::MAX {
                    *of_face = (h, n);
                }
            }
        }
        let mut curved = Curved { mesh, nodes, middles, bends, bulges: Vec::new(), cell_of_face };
        let middle = |mesh: &HexMesh, q: [u32; 4]| {
            let corners = q.map(|v| mesh.points[v as usize]);
            let side = |k: usize| curved.edge_place(q[k], q[(k + 1) % 4]);
            0.5 * (side(0) + side(1) + side(2) + side(3)) - 0.25 * corners.iter().sum::<DVec3>()
        };
        let bulges = middles.faces.par_iter().map(|f| wall.bulge(*f, middle)).collect();
        curved.bulges = bulges;
        curved
    }

    fn edge_place(&self, a: u32, b: u32) -> DVec3 {
        let middle = 0.5 * (self.mesh.points[a as usize] + self.mesh.points[b as usize]);
        let bend = self.middles.edges.binary_search(&pair(a, b)).map_or(DVec3::ZERO, |e| self.bends[e]);
        middle + bend
    }

    fn edge(&self, node: u32) -> usize {
        (node - self.middles.first) as usize
    }

    fn face(&self, node: u32) -> usize {
        (node - self.middles.first) as usize - self.bends.len()
    }

    /// Where all nodes are.
    fn places(&self) -> Vec<DVec3> {
        let at = |v: u32| self.mesh.points[v as usize];
        let edge = |(&[a, b], bend): (&[u32; 2], &DVec3)| 0.5 * (at(a) + at(b)) + *bend;
        let mut places: Vec<DVec3> = self.middles.edges.par_iter().zip(&self.bends).map(edge).collect();
        // Faces by their corners and edges, cells by these and the faces.
        let face = |(&(h, n), bulge): (&(u32, usize), &DVec3)| serendipity(&self.edges_of(h, &places))[8 + n] + *bulge;
        let faces: Vec<DVec3> = self.cell_of_face.par_iter().zip(&self.bulges).map(face).collect();
        places.extend(faces);
        let cell = |h: usize| {
            let p = self.edges_of(h as u32, &places);
            let [corners, edges] = [&p[..8], &p[8..20]].map(|list| list.iter().sum::<DVec3>());
            let of_faces = self.nodes.hexes[h][12..18].iter().map(|&n| places[self.edge(n)]).sum::<DVec3>();
            0.5 * of_faces - 0.25 * edges + 0.125 * corners
        };
        let cells: Vec<DVec3> = (0..self.mesh.hexes.len()).into_par_iter().map(cell).collect();
        places.extend(cells);
        places
    }

    /// The corners and the nodes of the edges of a cell.
    fn edges_of(&self, h: u32, places: &[DVec3]) -> Cell {
        let (corners, nodes) = (&self.mesh.hexes[h as usize], &self.nodes.hexes[h as usize]);
        std::array::from_fn(|n| match n {
            0..8 => self.mesh.points[corners[n] as usize],
            8..20 => places[self.edge(nodes[n - 8])],
            _ => DVec3::ZERO,
        })
    }

    fn is_certified(&self, h: u32, places: &[DVec3]) -> bool {
        let mut cell = self.edges_of(h, places);
        let nodes = &self.nodes.hexes[h as usize];
        (20..27).for_each(|n| cell[n] = places[self.edge(nodes[n - 8])]);
        is_certified(&cell) && is_certified(&serendipity(&cell))
    }

    fn is_curved(&self, h: u32) -> bool {
        let nodes = &self.nodes.hexes[h as usize];
        nodes[..12].iter().any(|&n| self.bends[self.edge(n)] != DVec3::ZERO)
            || nodes[12..18].iter().any(|&n| self.bulges[self.face(n)] != DVec3::ZERO)
    }

    /// Makes edges straight until every curved cell is certified; says which, ascending.
    fn certify(&mut self, context: &Context) -> Result<Vec<u32>> {
        let mut straight = Vec::new();
        let mut suspects: Vec<u32> = (0..self.mesh.hexes.len() as u32).filter(|&h| self.is_curved(h)).collect();
        for round in 0..=STRAIGHTENING_ROUNDS {
            let places = self.places();
            let of_chunk = |chunk: &[u32]| {
                context.check()?;
                Ok(chunk.iter().copied().filter(|&h| !self.is_certified(h, &places)).collect::<Vec<u32>>())
            };
            let bad: Result<Vec<Vec<u32>>> = suspects.par_chunks(CELLS_PER_CHECK).map(of_chunk).collect();
            let bad = bad?.concat();
            tracing::debug!(round, bad = bad.len(), "curved cells");
            if bad.is_empty() {
                break;
            }
            let all = if round == STRAIGHTENING_ROUNDS { suspects.clone() } else { bad };
            for h in all {
                let nodes = self.nodes.hexes[h as usize];
                for e in nodes[..12].iter().map(|&n| self.edge(n)).collect::<Vec<_>>() {
                    if std::mem::take(&mut self.bends[e]) != DVec3::ZERO {
                        straight.push(e as u32);
                    }
                }
                for f in nodes[12..18].iter().map(|&n| self.face(n)).collect::<Vec<_>>() {
                    self.bulges[f] = DVec3::ZERO;
                }
            }
            suspects.retain(|&h| self.is_curved(h));
        }
        straight.sort_unstable();
        Ok(straight)
    }
}

fn sorted(mut q: [u32; 4]) -> [u32; 4] {
    q.sort_unstable();
    q
}

fn pair(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}
