//! The mesh itself: corners that know their neighbours.

use crate::mesh::id::CornerId;
use crate::mesh::surface::{Side, SurfaceMesh};
use crate::mesh::triangles::NONE;
use glam::DVec3;

/// Everything about a corner and the half-edge that leaves it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Corner {
    /// The vertex; [`NONE`] in a removed triangle.
    pub vertex: u32,
    /// The half-edge on the other side, or [`NONE`].
    pub opposite: u32,
    /// The curve that the edge lies on, or [`NONE`]; both half-edges agree.
    pub curve: u32,
    /// What the corner shares with its neighbours around the vertex, up to the next curves.
    pub wedge: u32,
}

/// A corner of a removed triangle.
pub const REMOVED: Corner = Corner { vertex: NONE, opposite: NONE, curve: NONE, wedge: NONE };

/// A triangle mesh that can be changed; see the module's head.
#[derive(Debug, Clone)]
pub struct EditMesh {
    /// Positions; those of removed vertices are left.
    pub points: Vec<DVec3>,
    /// The vertex of the source mesh, or [`NONE`] for a new one.
    pub origin: Vec<u32>,
    /// The triangle of the source mesh that each triangle took the place of; descendants inherit it.
    pub source: Vec<u32>,
    pub(super) corners: Vec<Corner>,
    /// Whether a vertex of the source is one of several copies; empty where none is.
    pub(super) copied: Vec<bool>,
    /// A half-edge that leaves each vertex, on borders the one without an opposite; [`NONE`] for removed vertices.
    pub(super) start: Vec<u32>,
    pub(super) free: Vec<u32>,
    pub(super) live_triangles: usize,
    pub(super) live_vertices: usize,
}

/// The next half-edge of the same triangle.
#[inline]
pub fn next(h: u32) -> u32 {
    if h % 3 == 2 { h - 2 } else { h + 1 }
}

/// The previous half-edge of the same triangle.
#[inline]
pub fn previous(h: u32) -> u32 {
    if h.is_multiple_of(3) { h + 2 } else { h - 1 }
}

impl EditMesh {
    /// Copies a triangular mesh, cut where it is not manifold; `None` when some face is not a triangle.
    pub fn new(mesh: &SurfaceMesh) -> Option<Self> {
        if !mesh.is_triangular() {
            return None;
        }
        let corner = |(c, &vertex): (usize, &u32)| {
            let opposite = match mesh.side(CornerId::new(c)) {
                Side::Inner(o) => o.0,
                _ => NONE,
            };
            Corner { vertex, opposite, curve: NONE, wedge: NONE }
        };
        let corners: Vec<Corner> = mesh.faces().corners().iter().enumerate().map(corner).collect();
        let triangles = mesh.face_count();
        let mut out = EditMesh {
            points: mesh.points().to_vec(),
            origin: (0..mesh.vertex_count() as u32).collect(),
            source: (0..triangles as u32).collect(),
            corners,
            copied: Vec::new(),
            start: vec![NONE; mesh.vertex_count()],
            free: Vec::new(),
            live_triangles: triangles,
            live_vertices: 0,
        };
        out.find_fans();
        Some(out)
    }

    /// Sets the start of every vertex; each further fan of a vertex becomes a vertex of its own.
    pub(super) fn find_fans(&mut self) {
        let mut seen = vec![false; self.corners.len()];
        for h in 0..self.corners.len() as u32 {
            if seen[h as usize] {
                continue;
            }
            let first = self.first_around(h);
            let mut vertex = self.vertex(h);
            if self.start[vertex as usize] != NONE {
                self.points.push(self.points[vertex as usize]);
                self.origin.push(self.origin[vertex as usize]);
                self.start.push(NONE);
                let copy = self.start.len() as u32 - 1;
                self.copied.resize(self.start.len(), false);
                [vertex, copy].into_iter().for_each(|v| self.copied[v as usize] = true);
                vertex = copy;
            }
            self.start[vertex as usize] = first;
            self.live_vertices += 1;
            let mut at = first;
            loop {
                seen[at as usize] = true;
                self.corners[at as usize].vertex = vertex;
                at = self.opposite(previous(at));
                if at == NONE || at == first {
                    break;
                }
            }
        }
    }

    /// Number of triangles that are left.
    pub fn triangle_count(&self) -> usize {
        self.live_triangles
    }

    /// Number of vertices that are left.
    pub fn vertex_count(&self) -> usize {
        self.live_vertices
    }

    /// Triangle ids are below this; some are removed.
    pub fn triangle_slots(&self) -> u32 {
        self.source.len() as u32
    }

    /// Half-edge ids are below this; some are removed.
    pub fn half_edge_slots(&self) -> u32 {
        self.corners.len() as u32
    }

    /// Vertex ids are below this; some are removed.
    pub fn vertex_slots(&self) -> u32 {
        self.start.len() as u32
    }

    /// Whether the triangle is left.
    #[inline]
    pub fn is_triangle(&self, t: u32) -> bool {
        self.corners[3 * t as usize].vertex != NONE
    }

    /// Whether the half-edge is left.
    #[inline]
    pub fn is_half_edge(&self, h: u32) -> bool {
        self.corners[h as usize].vertex != NONE
    }

    /// Whether the vertex is left.
    #[inline]
    pub fn is_vertex(&self, v: u32) -> bool {
        self.start[v as usize] != NONE
    }

    /// The record of a corner.
    #[inline]
    pub fn corner(&self, h: u32) -> Corner {
        self.corners[h as usize]
    }

    /// The vertex that a half-edge leaves.
    #[inline]
    pub fn vertex(&self, h: u32) -> u32 {
        self.corners[h as usize].vertex
    }

    /// The vertex that a half-edge enters.
    #[inline]
    pub fn head(&self, h: u32) -> u32 {
        self.vertex(next(h))
    }

    /// The vertex of the triangle that is not on the half-edge.
    #[inline]
    pub fn apex(&self, h: u32) -> u32 {
        self.vertex(previous(h))
    }

    /// The half-edge on the other side, or [`NONE`].
    #[inline]
    pub fn opposite(&self, h: u32) -> u32 {
        self.corners[h as usize].opposite
    }

    /// The curve that the edge lies on, or [`NONE`].
    #[inline]
    pub fn curve(&self, h: u32) -> u32 {
        self.corners[h as usize].curve
    }

    /// The wedge of a corner.
    #[inline]
    pub fn wedge(&self, h: u32) -> u32 {
        self.corners[h as usize].wedge
    }

    /// Puts an edge on a curve.
    pub fn set_curve(&mut self, h: u32, curve: u32) {
        self.corners[h as usize].curve = curve;
        let o = self.opposite(h);
        if o != NONE {
            self.corners[o as usize].curve = curve;
        }
    }

    /// Puts a corner into a wedge.
    pub fn set_wedge(&mut self, h: u32, wedge: u32) {
        self.corners[h as usize].wedge = wedge;
    }

    /// The three vertices of a triangle.
    #[inline]
    pub fn triangle(&self, t: u32) -> [u32; 3] {
        let c = 3 * t as usize;
        [self.corners[c].vertex, self.corners[c + 1].vertex, self.corners[c + 2].vertex]
    }

    /// The three positions of a triangle.
    #[inline]
    pub fn positions(&self, t: u32) -> [DVec3; 3] {
        self.triangle(t).map(|v| self.points[v as usize])
    }

    /// Whether the vertex is one of several copies: an edge between two such vertices may exist elsewhere, too.
    #[inline]
    pub fn is_copy(&self, v: u32) -> bool {
        self.copied.get(v as usize).copied().unwrap_or(false)
    }

    /// Whether the vertex lies on a border of the (cut) mesh.
    #[inline]
    pub fn is_border(&self, v: u32) -> bool {
        self.opposite(self.start[v as usize]) == NONE
    }

    /// One half-edge of every edge, in order: the one without an opposite, or the smaller of two.
    pub fn edges(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.half_edge_slots()).filter(|&h| self.is_edge(h))
    }

    /// Whether the half-edge is left and stands for its edge in [`EditMesh::edges`].
    #[inline]
    pub fn is_edge(&self, h: u32) -> bool {
        self.is_half_edge(h) && self.opposite(h) > h
    }

    /// The half-edges that leave a vertex, counter-clockwise; on a border the first has no opposite.
    #[inline]
    pub fn around(&self, v: u32) -> OutgoingHalfEdges<'_> {
        let first = self.start[v as usize];
        OutgoingHalfEdges { mesh: self, first, at: first }
    }

    /// Every neighbour of a vertex, counter-clockwise.
    #[inline]
    pub fn for_neighbours(&self, v: u32, mut visit: impl FnMut(u32)) {
        let mut last = NONE;
        for h in self.around(v) {
            visit(self.head(h));
            last = h;
        }
        if last != NONE && self.opposite(previous(last)) == NONE {
            visit(self.apex(last));
        }
    }

    /// Number of neighbours.
    pub fn valence(&self, v: u32) -> usize {
        let mut count = 0;
        self.for_neighbours(v, |_| count += 1);
        count
    }

    /// The half-edge from `a` to `b`, if a triangle has it.
    pub fn half_edge(&self, a: u32, b: u32) -> Option<u32> {
        self.around(a).find(|&h| self.head(h) == b)
    }

    /// The first half-edge around the vertex of `h`: on a border the one without an opposite, else `h` itself.
    pub(super) fn first_around(&self, h: u32) -> u32 {
        let mut at = h;
        loop {
            let o = self.opposite(at);
            if o == NONE {
                return at;
            }
            at = next(o);
            if at == h {
                return h;
            }
        }
    }

    /// The live part as plain arrays: vertices and triangles keep their order.
    pub fn compact(&self) -> Compact {
        let mut new_id = vec![NONE; self.start.len()];
        let vertices: Vec<u32> = (0..self.vertex_slots()).filter(|&v| self.is_vertex(v)).collect();
        for (k, &v) in vertices.iter().enumerate() {
            new_id[v as usize] = k as u32;
        }
        let triangles: Vec<u32> = (0..self.triangle_slots()).filter(|&t| self.is_triangle(t)).collect();
        let faces = triangles.iter().map(|&t| self.triangle(t).map(|v| new_id[v as usize])).collect();
        Compact { faces, vertices, triangles }
    }

    /// A removed triangle to be filled, or a new one at the end.
    pub(super) fn new_triangle(&mut self) -> u32 {
        self.live_triangles += 1;
        match self.free.pop() {
            Some(t) => t,
            None => {
                self.corners.extend([REMOVED; 3]);
                self.source.push(NONE);
                self.source.len() as u32 - 1
            }
        }
    }

    pub(super) fn remove_triangle(&mut self, t: u32) {
        self.corners[3 * t as usize..3 * t as usize + 3].fill(REMOVED);
        self.free.push(t);
        self.live_triangles -= 1;
    }

    /// Makes two half-edges each other's opposite, on one curve; either may be [`NONE`].
    pub(super) fn link(&mut self, a: u32, b: u32, curve: u32) {
        for (h, o) in [(a, b), (b, a)] {
            if h != NONE {
                self.corners[h as usize].opposite = o;
                self.corners[h as usize].curve = curve;
            }
        }
    }
}

/// What [`EditMesh::compact`] gives.
#[derive(Debug, Clone)]
pub struct Compact {
    /// Triangles over the compacted vertices.
    pub faces: Vec<[u32; 3]>,
    /// The id in the edited mesh of every compacted vertex.
    pub vertices: Vec<u32>,
    /// The id in the edited mesh of every compacted triangle.
    pub triangles: Vec<u32>,
}

/// Half-edges that leave a vertex; see [`EditMesh::around`].
#[derive(Clone)]
pub struct OutgoingHalfEdges<'a> {
    pub(super) mesh: &'a EditMesh,
    pub(super) first: u32,
    pub(super) at: u32,
}

impl Iterator for OutgoingHalfEdges<'_> {
    type Item = u32;

    #[inline]
    fn next(&mut self) -> Option<u32> {
        if self.at == NONE {
            return None;
        }
        let h = self.at;
        let turned = self.mesh.opposite(previous(h));
        self.at = if turned == self.first { NONE } else { turned };
        Some(h)
    }
}
