//! Refinement of the base mesh (section 4 "Raffinement" of the paper): padding, and halving across and along.
//!
//! Padding puts a layer of hexes on the wall (`sides`), which is the paper's trisection of every hex across its axis, or on
//! the whole boundary (`all`), ends included:
//!
//! ```text
//!   W───────M            W───────M
//!   │       │            │╲  b  ╱│
//!   │       │     →      │ w───m │        c, v, m, w: the hex of before, shrunk
//!   │       │            │ │   │a│
//!   c───────V            c─┴───v─V
//! ```
//!
//! Halving cuts whole sheets, so that the result conforms: across means both axes of the section, and in the layer on an
//! end its thickness too; along means the axis of the segments.

use super::assemble::BaseMesh;
use super::{Padding, cubic};
use crate::mesh::{CurveNet, NONE};
use glam::DVec3;
use rustc_hash::FxHashMap;

/// Where the old wall goes when a layer is put on it, as a share of the way from the centre: where there is room.
pub const CORE: f64 = 0.6;

/// A hex mesh on a skeleton, with what later stages must know of every vertex.
#[derive(Debug, Clone, Default)]
pub struct TubeMesh {
    /// Positions.
    pub points: Vec<DVec3>,
    /// Cells; the third axis runs along the segment, where there is one.
    pub hexes: Vec<[u32; 8]>,
    /// The segment that the third axis of each cell runs along; [`NONE`] for the layer on an end and the cells of cubic junctions,
    /// which have no such axis.
    pub segments: Vec<u32>,
    /// The point of the skeleton that each vertex belongs to.
    pub centres: Vec<DVec3>,
    /// Distance of wall vertices from their centre; zero off the wall.
    pub radii: Vec<f64>,
    /// Number of the end that each vertex lies on, from 1; zero off the ends.
    pub caps: Vec<u32>,
    /// The ends, in the order of their numbers.
    pub ends: Vec<End>,
    /// The vertex at every node of the skeleton.
    pub nodes: Vec<u32>,
    /// Number of cubic junctions.
    pub cubic_junctions: usize,
}

/// Where a tube ends: a disc about an extremity of the skeleton.
#[derive(Debug, Clone, Copy)]
pub struct End {
    /// The extremity.
    pub centre: DVec3,
    /// Unit normal of the disc, away from the tube.
    pub outward: DVec3,
}

/// Where a cell of a padded mesh stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CellPlace {
    /// The segment whose section it belongs to, that of an end for the layer there; [`NONE`] in cubic junctions.
    pub segment: u32,
    /// The hex of the base mesh that it was cut from or lies on, of the four of its segment.
    pub quarter: u8,
}

/// The places of the cells that [`pad`] makes, in their order.
pub fn places(net: &CurveNet, base: &BaseMesh, padding: Padding) -> Vec<CellPlace> {
    let section = |segment: u32| (0..4).map(move |quarter| CellPlace { segment, quarter });
    let nowhere = CellPlace { segment: NONE, quarter: 0 };
    let segments = 0..base.segments.len() as u32;
    let mut places: Vec<CellPlace> = segments.clone().flat_map(section).collect();
    places.resize(base.hexes.len(), nowhere);
    if padding == Padding::None {
        return places;
    }
    places.extend(segments.clone().flat_map(section).flat_map(|p| [p; 2]));
    let open: usize = base.cubes.list.iter().map(|(_, c)| c.open_faces().count()).sum();
    places.resize(places.len() + 4 * open, nowhere);
    if padding == Padding::All {
        let around = net.incidence();
        for segment in segments {
            for node in base.segments[segment as usize] {
                places.extend(section(segment).filter(|_| around.valence(node) == 1));
            }
        }
    }
    places
}

/// Cells and vertices of the base mesh, with the layer asked for. The old wall goes to `core` of its way from the centre:
/// the nearer to 1, the thinner the layer, and the surer it is valid.
pub fn pad(net: &CurveNet, base: &BaseMesh, padding: Padding, core: f64) -> TubeMesh {
    pad_but(net, base, padding, core, &[])
}

/// [`pad`] with no layer on the ends that are flagged, in their order. The four cells on an end have their corners on its
/// border, which is smooth about a flat end: their angles there would be straight ones.
///
/// ```text
///      ╭──·──╮           ╭──·──╮
///     ·   │   ·         ╱·──┼──·╲
///     │───┼───│         ││──┼──││        a flat end with the layer, and without
///     ·   │   ·         ╲·──┼──·╱
///      ╰──·──╯           ╰──·──╯
/// ```
pub fn pad_but(net: &CurveNet, base: &BaseMesh, padding: Padding, core: f64, flat: &[bool]) -> TubeMesh {
    let count = base.points.len();
    let around = net.incidence();
    let node_of = |v: usize| base.first.partition_point(|&f| f as usize <= v) - 1;
    let nodes: Vec<u32> = (0..count).map(|v| node_of(v) as u32).collect();
    let is_inside = |v: u32| {
        let node = nodes[v as usize];
        let own = v - base.first[node as usize];
        base.cubes.get(node).map_or(own == 0, |c| c.is_inside(own))
    };
    let inside: Vec<bool> = (0..count as u32).map(is_inside).collect();
    let mut mesh = unpadded(net, base, &nodes, &inside);
    if padding == Padding::None {
        return mesh;
    }
    // Outer copies of everything on the wall, in order; then those of the centres of ends.
    let mut copies = vec![NONE; count];
    for v in (0..count).filter(|&v| !inside[v]) {
        copies[v] = mesh.points.len() as u32;
        mesh.copy(v as u32);
    }
    let outer = |v: u32| copies[v as usize];
    let mut outer_centre = vec![u32::MAX; net.points.len()];
    let of_segments = 4 * base.segments.len();
    let is_flat = |end: usize| flat.get(end) == Some(&true);
    let round = around.tips().enumerate().filter(|&(end, _)| padding == Padding::All && !is_flat(end));
    for (_, tip) in round {
        let node = tip as usize;
        outer_centre[node] = mesh.points.len() as u32;
        mesh.nodes[node] = outer_centre[node];
        mesh.copy(base.first[node]);
    }
    move_inward(&mut mesh, net, base, &inside, core);
    mesh.hexes.reserve(2 * base.hexes.len());
    for (h, segment) in base.hexes[..of_segments].iter().zip(mesh.segments.clone()) {
        let [_, v, m, w, _, v1, m1, w1] = *h;
        mesh.hexes.push([v, outer(v), outer(m), m, v1, outer(v1), outer(m1), m1]);
        mesh.hexes.push([m, outer(m), outer(w), w, m1, outer(m1), outer(w1), w1]);
        mesh.segments.extend([segment; 2]);
    }
    for (node, cube) in &base.cubes.list {
        for q in cube.open_faces().flat_map(cubic::quads) {
            let [a, b, c, d] = q.map(|v| base.first[*node as usize] + v);
            mesh.hexes.push([a, b, c, d, outer(a), outer(b), outer(c), outer(d)]);
            mesh.segments.push(NONE);
        }
    }
    if padding == Padding::All {
        cover_ends(net, base, &mut mesh, &outer, &outer_centre, 1.0 - core);
    }
    mesh
}

/// The cells as they are, without a layer; `nodes` are those of the vertices.
fn unpadded(net: &CurveNet, base: &BaseMesh, nodes: &[u32], inside: &[bool]) -> TubeMesh {
    let count = base.points.len();
    let around = net.incidence();
    let mut ends = Vec::new();
    let mut end_of = vec![0; net.points.len()];
    for tip in around.tips() {
        let centre = net.points[tip as usize];
        let before = around.of(tip).first().map_or(centre, |s| net.points[s[1] as usize]);
        ends.push(End { centre, outward: (centre - before).normalize_or(DVec3::X) });
        end_of[tip as usize] = ends.len() as u32;
    }
    let radius = |v: usize| match nodes[v] {
        // Where tubes meet the wall of a cube is farther than the radius.
        node if base.cubes.get(node).is_some() => base.points[v].distance(net.points[node as usize]),
        node => net.radii[node as usize],
    };
    let of_segments = 4 * base.segments.len();
    TubeMesh {
        points: base.points.clone(),
        hexes: base.hexes.clone(),
        segments: (0..base.hexes.len()).map(|h| if h < of_segments { h as u32 / 4 } else { NONE }).collect(),
        centres: nodes.iter().map(|&n| net.points[n as usize]).collect(),
        radii: (0..count).map(|v| if inside[v] { 0.0 } else { radius(v) }).collect(),
        caps: nodes.iter().map(|&n| end_of[n as usize]).collect(),
        ends,
        nodes: base.first[..net.points.len()].to_vec(),
        cubic_junctions: base.cubes.list.len(),
    }
}

/// Makes room for the layer: what is on the wall goes towards the centre, down to a share of its distance.
fn move_inward(mesh: &mut TubeMesh, net: &CurveNet, base: &BaseMesh, inside: &[bool], core: f64) {
    let of_segments = 4 * base.segments.len();
    for h in &base.hexes[..of_segments] {
        // The same from every hex at the face: places on the faces shared by both.
        for face in [&h[..4], &h[4..]] {
            let [c, v, m, w] = [face[0], face[1], face[2], face[3]].map(|k| base.points[k as usize]);
            mesh.points[face[1] as usize] = c.lerp(v, core);
            mesh.points[face[2] as usize] = c.lerp(v, core).lerp(w.lerp(m, core), core);
            mesh.points[face[3] as usize] = c.lerp(w, core);
        }
    }
    for (node, _) in &base.cubes.list {
        let centre = net.points[*node as usize];
        for v in base.first[*node as usize]..base.first[*node as usize + 1] {
            let v = v as usize;
            mesh.points[v] = if inside[v] { base.points[v] } else { centre.lerp(base.points[v], core) };
        }
    }
    (0..inside.len()).filter(|&v| !inside[v]).for_each(|v| mesh.radii[v] = 0.0);
}

/// The layer on the ends: the ring of an end moves inward, its copies stay.
fn cover_ends(
    net: &CurveNet,
    base: &BaseMesh,
    mesh: &mut TubeMesh,
    outer: &impl Fn(u32) -> u32,
    outer_centre: &[u32],
    depth: f64,
) {
    for (e, &[near, far]) in base.segments.iter().enumerate() {
        for (node, other, bottom) in [(near, far, true), (far, near, false)] {
            let centre = outer_centre[node as usize];
            if centre == u32::MAX {
                continue;
            }
            for h in &base.hexes[4 * e..4 * e + 4] {
                let (inner, rest) = h.split_at(4);
                let face = if bottom { inner } else { rest };
                let copy = [centre, outer(face[1]), outer(face[2]), outer(face[3])];
                let [a, b] = if bottom {
                    [copy, [face[0], face[1], face[2], face[3]]]
                } else {
                    [[face[0], face[1], face[2], face[3]], copy]
                };
                mesh.hexes.push([a[0], a[1], a[2], a[3], b[0], b[1], b[2], b[3]]);
                mesh.segments.push(NONE);
            }
            let axis = net.points[other as usize] - net.points[node as usize];
            let depth = depth * net.radii[node as usize].min(0.9 * axis.length());
            let inward = axis.normalize_or_zero() * depth;
            for v in base.first[node as usize]..base.first[node as usize + 1] {
                mesh.points[v as usize] += inward;
                mesh.centres[v as usize] += inward;
                mesh.caps[v as usize] = 0;
            }
        }
    }
}

impl TubeMesh {
    fn copy(&mut self, v: u32) {
        let v = v as usize;
        self.points.push(self.points[v]);
        self.centres.push(self.centres[v]);
        self.radii.push(self.radii[v]);
        self.caps.push(self.caps[v]);
    }

    /// Halves every cell across its axis, and those without one along all three of theirs.
    pub fn refine_across(&mut self) {
        let segments = self.segments.clone();
        self.halve(|h| [true, true, segments[h] == NONE]);
    }

    /// Halves the cells of some segments along these; their neighbours need not follow.
    pub fn refine_along(&mut self, which: impl Fn(u32) -> bool) {
        let segments = self.segments.clone();
        self.halve(|h| [false, false, segments[h] != NONE && which(segments[h])]);
    }

    fn halve(&mut self, axes: impl Fn(usize) -> [bool; 3]) {
        let hexes = std::mem::take(&mut self.hexes);
        let segments = std::mem::take(&mut self.segments);
        let mut middles: FxHashMap<[u32; 4], u32> = FxHashMap::default();
        for (h, corners) in hexes.iter().enumerate() {
            let halved = axes(h);
            let mut grid = [u32::MAX; 27];
            for (n, cell) in grid.iter_mut().enumerate() {
                let at = [n % 3, n / 3 % 3, n / 9];
                if (0..3).all(|a| at[a] != 1 || halved[a]) {
                    *cell = self.grid_vertex(corners, at, &mut middles);
                }
            }
            let parts = halved.map(|x| if x { 2 } else { 1 });
            for k in 0..parts[2] {
                for j in 0..parts[1] {
                    for i in 0..parts[0] {
                        let low = [i, j, k];
                        let corner = |up: [usize; 3]| {
                            let at: [usize; 3] =
                                std::array::from_fn(|a| if halved[a] { low[a] + up[a] } else { 2 * up[a] });
                            grid[at[0] + 3 * at[1] + 9 * at[2]]
                        };
                        self.hexes.push(UNIT.map(corner));
                        self.segments.push(segments[h]);
                    }
                }
            }
        }
    }

    /// The vertex at a place of the 3 × 3 × 3 grid of a cell: a corner, or the middle of an edge, a face or the cell.
    fn grid_vertex(&mut self, corners: &[u32; 8], at: [usize; 3], middles: &mut FxHashMap<[u32; 4], u32>) -> u32 {
        let near = |c: &usize| (0..3).all(|a| at[a] == 1 || at[a] == 2 * UNIT[*c][a]);
        let mut parents = [u32::MAX; 8];
        let mut n = 0;
        for c in (0..8).filter(near) {
            parents[n] = corners[c];
            n += 1;
        }
        if n == 1 {
            return parents[0];
        }
        let mut key = [u32::MAX; 4];
        if n < 8 {
            key[..n].copy_from_slice(&parents[..n]);
            key.sort_unstable();
            if let Some(&v) = middles.get(&key) {
                return v;
            }
        }
        let v = self.middle(&parents[..n]);
        if n < 8 {
            middles.insert(key, v);
        }
        v
    }

    /// A new vertex in the middle of others.
    fn middle(&mut self, parents: &[u32]) -> u32 {
        let share = 1.0 / parents.len() as f64;
        let mean = |list: &[DVec3]| parents.iter().map(|&p| list[p as usize]).sum::<DVec3>() * share;
        let (point, centre) = (mean(&self.points), mean(&self.centres));
        let on_wall = parents.iter().all(|&p| self.radii[p as usize] > 0.0);
        let radius = if on_wall { parents.iter().map(|&p| self.radii[p as usize]).sum::<f64>() * share } else { 0.0 };
        let cap = self.caps[parents[0] as usize];
        let same = parents.iter().all(|&p| self.caps[p as usize] == cap);
        self.points.push(point);
        self.centres.push(centre);
        self.radii.push(radius);
        self.caps.push(if same { cap } else { 0 });
        self.points.len() as u32 - 1
    }
}

/// Corners of the unit cell in VTK order.
const UNIT: [[usize; 3]; 8] = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]];
