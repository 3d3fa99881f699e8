//! The surface mesh that every room takes: triangles and polygons, flat arrays, immutable connectivity.

#[cfg(test)]
mod tests;

use super::attributes::{Attributes, gather_columns};
use super::half_edges::HalfEdges;
use super::id::{CornerId, FaceId, VertexId};
use super::marks::{BORDER, INCONSISTENT, NON_MANIFOLD};
use super::polygons::Polygons;
use super::triangulate::{Cut, fans, nearly_fans, triangulate};
use crate::error::{Error, Result};
use glam::DVec3;

/// What lies across a side of a face.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// Exactly one other face, consistently oriented: its half-edge runs the opposite way.
    Inner(CornerId),
    /// Nothing: an open border.
    Border,
    /// Two faces that orient the edge the same way.
    Inconsistent,
    /// More than two faces, or an edge from a vertex to itself.
    NonManifold,
}

/// Corner ids stay below the marks above.
const MAX_ELEMENTS: usize = (u32::MAX - 3) as usize;

/// An edge marked in the file: a ridge, a required edge, a curve of the CAD model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TaggedEdge {
    /// The end points.
    pub ends: [VertexId; 2],
    /// The file's reference number.
    pub tag: i32,
}

/// Points and polygonal faces, with the half-edge opposite to every corner.
///
/// A corner `c` of a face stands for a vertex in that face and for the half-edge that leaves it, towards the next
/// corner in the sense of the face:
///
/// ```text
///       c+2
///       ╱ ╲        half-edge c runs from vertex(c) to vertex(next(c));
///      ╱   ╲       side(c) tells what lies across it.
///     c ──→ c+1
/// ```
///
/// The constructor is the only way in. It refuses indices out of range, faces with fewer than three corners and
/// coordinates that are not finite; everything else (borders, non-manifold edges, degenerate faces) is accepted and
/// reported by [`super::Topology`].
#[derive(Debug, Clone)]
pub struct SurfaceMesh {
    points: Vec<DVec3>,
    faces: Polygons,
    opposite: Vec<u32>,
    /// Face of every corner; empty when all faces are triangles (then it is `corner / 3`).
    face_of: Vec<u32>,
    /// Named columns.
    pub attributes: Attributes,
    /// Edges marked in the file.
    pub tagged_edges: Vec<TaggedEdge>,
}

impl SurfaceMesh {
    /// Builds a mesh from points and faces; validates both.
    ///
    /// # Errors
    /// [`Error::Input`] for coordinates that are not finite, faces of fewer than three corners,
    /// vertices that do not exist, and too many
    /// vertices or corners.
    pub fn new(points: Vec<DVec3>, faces: Polygons) -> Result<Self> {
        validate(&points, &faces)?;
        let opposite = opposite_corners(&faces, points.len());
        let face_of = if faces.all_triangles() {
            Vec::new()
        } else {
            faces.iter().enumerate().flat_map(|(f, face)| std::iter::repeat_n(f as u32, face.len())).collect()
        };
        Ok(SurfaceMesh {
            points,
            faces,
            opposite,
            face_of,
            attributes: Attributes::default(),
            tagged_edges: Vec::new(),
        })
    }

    /// Builds a mesh of triangles.
    ///
    /// # Errors
    /// As [`SurfaceMesh::new`].
    pub fn from_triangles(points: Vec<DVec3>, triangles: &[[u32; 3]]) -> Result<Self> {
        Self::new(points, Polygons::from_triangles(triangles))
    }

    /// The mesh with a vertex in the middle of the marked triangles, which become three in their places; new vertices follow
    /// after all others. What is not a triangle is left as it is, attributes and tagged edges are left out.
    ///
    /// ```text
    ///        c                c
    ///       ╱ ╲              ╱│╲
    ///      ╱   ╲     →      ╱ m ╲        (a,b,m), (b,c,m), (c,a,m)
    ///     ╱     ╲          ╱╱   ╲╲
    ///    a───────b        a───────b
    /// ```
    ///
    /// # Errors
    /// Where there would be more elements than numbers for them.
    pub fn with_centers(&self, marked: &[bool]) -> Result<Self> {
        if !self.is_triangular() || !marked.contains(&true) {
            let (points, faces) = (self.points.clone(), self.faces.clone());
            let (opposite, face_of) = (self.opposite.clone(), self.face_of.clone());
            let (attributes, tagged_edges) = (Attributes::default(), Vec::new());
            return Ok(SurfaceMesh { points, faces, opposite, face_of, attributes, tagged_edges });
        }
        let mut points = self.points.clone();
        let mut triangles = Vec::with_capacity(self.faces.len());
        // The first of the triangles that each becomes.
        let mut first = Vec::with_capacity(self.faces.len());
        for (corners, f) in self.faces.corners().chunks_exact(3).zip(0..) {
            first.push(triangles.len() as u32);
            let t = [corners[0], corners[1], corners[2]];
            if marked.get(f) == Some(&true) {
                let m = points.len() as u32;
                points.push(t.iter().map(|&v| self.points[v as usize] / 3.0).sum());
                triangles.extend((0..3).map(|k| [t[k], t[(k + 1) % 3], m]));
            } else {
                triangles.push(t);
            }
        }
        let faces = Polygons::from_triangles(&triangles);
        validate(&points, &faces)?;
        // An outer half-edge is the first of its part.
        let moved = |c: u32| {
            let (f, side) = (c as usize / 3, c % 3);
            if marked.get(f) == Some(&true) { 3 * (first[f] + side) } else { 3 * first[f] + side }
        };
        let mut opposite = vec![BORDER; 3 * triangles.len()];
        for (&o, c) in self.opposite.iter().zip(0u32..) {
            opposite[moved(c) as usize] = if o < NON_MANIFOLD { moved(o) } else { o };
        }
        for (&first, _) in first.iter().zip(marked).filter(|(_, marked)| **marked) {
            for k in 0..3 {
                let (out, back) = (3 * (first + k) + 1, 3 * (first + (k + 1) % 3) + 2);
                (opposite[out as usize], opposite[back as usize]) = (back, out);
            }
        }
        let (attributes, tagged_edges) = (Attributes::default(), Vec::new());
        Ok(SurfaceMesh { points, faces, opposite, face_of: Vec::new(), attributes, tagged_edges })
    }

    /// Number of vertices, unreferenced ones included.
    pub fn vertex_count(&self) -> usize {
        self.points.len()
    }

    /// Number of faces.
    pub fn face_count(&self) -> usize {
        self.faces.len()
    }

    /// Number of corners of all faces together.
    pub fn corner_count(&self) -> usize {
        self.faces.corners().len()
    }

    /// Positions of all vertices.
    pub fn points(&self) -> &[DVec3] {
        &self.points
    }

    /// Position of a vertex.
    #[inline]
    pub fn point(&self, v: VertexId) -> DVec3 {
        self.points[v.index()]
    }

    /// The faces as flat arrays.
    pub fn faces(&self) -> &Polygons {
        &self.faces
    }

    /// Vertex indices of a face, in its sense.
    #[inline]
    pub fn face(&self, f: FaceId) -> &[u32] {
        self.faces.face(f.index())
    }

    /// The corners of a face.
    #[inline]
    pub fn corners(&self, f: FaceId) -> impl ExactSizeIterator<Item = CornerId> + use<> {
        let offsets = self.faces.offsets();
        (offsets[f.index()]..offsets[f.index() + 1]).map(CornerId)
    }

    /// The vertex at a corner.
    #[inline]
    pub fn vertex(&self, c: CornerId) -> VertexId {
        VertexId(self.faces.corners()[c.index()])
    }

    /// The face of a corner.
    #[inline]
    pub fn face_of(&self, c: CornerId) -> FaceId {
        FaceId(if self.face_of.is_empty() { c.0 / 3 } else { self.face_of[c.index()] })
    }

    /// The next corner of the same face.
    #[inline]
    pub fn next(&self, c: CornerId) -> CornerId {
        let f = self.face_of(c).index();
        let offsets = self.faces.offsets();
        CornerId(if c.0 + 1 == offsets[f + 1] { offsets[f] } else { c.0 + 1 })
    }

    /// The previous corner of the same face.
    #[inline]
    pub fn previous(&self, c: CornerId) -> CornerId {
        let f = self.face_of(c).index();
        let offsets = self.faces.offsets();
        CornerId(if c.0 == offsets[f] { offsets[f + 1] - 1 } else { c.0 - 1 })
    }

    /// The half-edge on the other side of a regular inner edge; `None` on borders and irregular edges.
    #[inline]
    pub fn opposite(&self, c: CornerId) -> Option<CornerId> {
        let o = self.opposite[c.index()];
        (o < NON_MANIFOLD).then_some(CornerId(o))
    }

    /// Opposite corners as they are stored: values from `marks::FIRST_MARK` up are marks, not corners.
    pub(super) fn opposite_table(&self) -> &[u32] {
        &self.opposite
    }

    /// What lies across the half-edge that leaves this corner.
    #[inline]
    pub fn side(&self, c: CornerId) -> Side {
        match self.opposite[c.index()] {
            BORDER => Side::Border,
            INCONSISTENT => Side::Inconsistent,
            NON_MANIFOLD => Side::NonManifold,
            o => Side::Inner(CornerId(o)),
        }
    }

    /// Whether every face is a triangle.
    pub fn is_triangular(&self) -> bool {
        self.face_of.is_empty()
    }

    /// All half-edges grouped by their edge.
    pub fn half_edges(&self) -> HalfEdges {
        HalfEdges::new(&self.faces, self.points.len())
    }

    /// The mesh with every polygon cut into triangles: none turned, and no diagonal where an edge is already, as far as
    /// the polygon allows. Face attributes follow, corner attributes of cut polygons too. A triangular mesh is returned
    /// as it is.
    ///
    /// # Errors
    /// As [`SurfaceMesh::new`].
    pub fn triangulated(self) -> Result<Self> {
        self.divided(triangulate)
    }

    /// As [`Self::triangulated`], but every polygon is a fan from its first corner, turned triangles or not: for results
    /// that name triangles by their number.
    ///
    /// # Errors
    /// As [`SurfaceMesh::new`].
    pub fn fanned(self) -> Result<Self> {
        self.divided(fans)
    }

    /// As [`Self::fanned`], but where a fan has a flat triangle the polygon is cut as by [`Self::triangulated`], and diagonals
    /// that are edges already are divided in their middle, by vertices that come last. Attributes are left behind.
    ///
    /// # Errors
    /// As [`SurfaceMesh::new`].
    pub fn nearly_fanned(mut self) -> Result<Self> {
        if !self.is_triangular() {
            self.attributes = Attributes::default();
        }
        self.divided(nearly_fans)
    }

    fn divided(self, cut: impl FnOnce(&[DVec3], &Polygons) -> Cut) -> Result<Self> {
        if self.is_triangular() {
            return Ok(self);
        }
        let Cut { triangles, corners, parent, middles } = cut(&self.points, &self.faces);
        let mut points = self.points;
        points
            .extend(middles.iter().map(|m| 0.5 * (points[m[0] as usize] + points[m[1] as usize])).collect::<Vec<_>>());
        let mut out = Self::from_triangles(points, &triangles)?;
        out.attributes = Attributes {
            face: gather_columns(&self.attributes.face, &parent),
            corner: gather_columns(&self.attributes.corner, &corners),
            ..self.attributes
        };
        out.tagged_edges = self.tagged_edges;
        Ok(out)
    }

    /// Smallest and largest coordinates over the vertices that faces use; zero for a mesh without faces.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let used = self.faces.corners().iter().map(|&v| self.points[v as usize]);
        let (low, high) = used.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
        if self.faces.corners().is_empty() { (DVec3::ZERO, DVec3::ZERO) } else { (low, high) }
    }

    /// Length of the bounding-box diagonal of the faces.
    pub fn diagonal(&self) -> f64 {
        let (low, high) = self.bounds();
        let extent = high - low;
        // Scaled, so that neither 1e200 nor 1e-200 is lost in the squares.
        let scale = extent.max_element();
        if scale > 0.0 { scale * (extent / scale).length() } else { 0.0 }
    }

    /// The mesh with its points elsewhere; they must stay finite.
    pub(super) fn with_points_mapped(mut self, to: impl Fn(DVec3) -> DVec3) -> Self {
        self.points.iter_mut().for_each(|p| *p = to(*p));
        self
    }

    /// Points, faces, attributes and tagged edges, taken apart.
    pub fn into_parts(self) -> (Vec<DVec3>, Polygons, Attributes, Vec<TaggedEdge>) {
        (self.points, self.faces, self.attributes, self.tagged_edges)
    }
}

fn validate(points: &[DVec3], faces: &Polygons) -> Result<()> {
    if points.len() > MAX_ELEMENTS || faces.corners().len() > MAX_ELEMENTS {
        return Err(Error::input("the mesh has more than 4,294,967,292 vertices or corners", "", "split it"));
    }
    if let Some(v) = points.iter().position(|p| !p.is_finite()) {
        let p = points[v];
        return Err(Error::input(
            format!("a coordinate is not finite: ({}, {}, {})", p.x, p.y, p.z),
            format!("vertex {v}"),
            "remove the vertex and its faces",
        ));
    }
    for (f, face) in faces.iter().enumerate() {
        if face.len() < 3 {
            return Err(Error::input(format!("a face has {} corners", face.len()), format!("face {f}"), "remove it"));
        }
        if let Some(&v) = face.iter().find(|&&v| v as usize >= points.len()) {
            return Err(Error::input(
                format!("a face uses vertex {v}, there are {} vertices", points.len()),
                format!("face {f}"),
                "ids are 0-based here: check the file's indices",
            ));
        }
    }
    Ok(())
}

/// The opposite of every corner, or a mark that says why there is none.
fn opposite_corners(faces: &Polygons, vertices: usize) -> Vec<u32> {
    let mut opposite = vec![BORDER; faces.corners().len()];
    for edge in HalfEdges::new(faces, vertices).groups() {
        let mut corners = edge.corners();
        match (edge.ends[0] == edge.ends[1], corners.next(), corners.next(), corners.next()) {
            (false, Some(_), None, _) => {}
            (false, Some(a), Some(b), None) => {
                let starts = [a, b].map(|c| faces.corners()[c as usize]);
                let opposed = starts[0] != starts[1];
                opposite[a as usize] = if opposed { b } else { INCONSISTENT };
                opposite[b as usize] = if opposed { a } else { INCONSISTENT };
            }
            _ => edge.corners().for_each(|c| opposite[c as usize] = NON_MANIFOLD),
        }
    }
    opposite
}
