//! A triangular mesh seen as raw arrays: what inner loops walk on.

use super::marks::FIRST_MARK;
use super::surface::SurfaceMesh;
use glam::DVec3;

/// Marks the absence of an element in arrays of ids.
pub const NONE: u32 = u32::MAX;

/// A borrowed view of a mesh whose faces are all triangles: corner `c` belongs to triangle `c / 3`.
///
/// ```text
///           apex(c) = vertex(previous(c))
///             ╱ ╲
///            ╱   ╲
///  vertex(c)  ──c─→  vertex(next(c))
///            ╲   ╱
///             ╲ ╱     opposite(c) runs the other way in the neighbour; NONE on borders and irregular edges
/// ```
#[derive(Clone, Copy)]
pub struct Triangles<'a> {
    points: &'a [DVec3],
    vertices: &'a [u32],
    opposite: &'a [u32],
}

impl<'a> Triangles<'a> {
    /// Views a mesh; `None` when some face is not a triangle.
    pub fn of(mesh: &'a SurfaceMesh) -> Option<Self> {
        mesh.is_triangular().then(|| Triangles {
            points: mesh.points(),
            vertices: mesh.faces().corners(),
            opposite: mesh.opposite_table(),
        })
    }

    /// The same triangles on other points, one for each of the present ones; unchanged where there are not as many.
    pub fn with_points<'b>(&self, points: &'b [DVec3]) -> Triangles<'b>
    where
        'a: 'b,
    {
        Triangles { points: if points.len() == self.points.len() { points } else { self.points }, ..*self }
    }

    /// Number of triangles.
    pub fn len(&self) -> usize {
        self.vertices.len() / 3
    }

    /// Whether there is no triangle.
    pub fn is_empty(&self) -> bool {
        self.vertices.is_empty()
    }

    /// The next corner of the same triangle.
    #[inline]
    pub fn next(&self, c: u32) -> u32 {
        if c % 3 == 2 { c - 2 } else { c + 1 }
    }

    /// The previous corner of the same triangle.
    #[inline]
    pub fn previous(&self, c: u32) -> u32 {
        if c.is_multiple_of(3) { c + 2 } else { c - 1 }
    }

    /// The half-edge across a regular inner edge, or [`NONE`].
    #[inline]
    pub fn opposite(&self, c: u32) -> u32 {
        let o = self.opposite[c as usize];
        if o < FIRST_MARK { o } else { NONE }
    }

    /// The vertex that half-edge `c` leaves.
    #[inline]
    pub fn vertex(&self, c: u32) -> u32 {
        self.vertices[c as usize]
    }

    /// The vertex of the triangle that is not on half-edge `c`.
    #[inline]
    pub fn apex(&self, c: u32) -> u32 {
        self.vertices[self.previous(c) as usize]
    }

    /// The three vertices of triangle `t`.
    #[inline]
    pub fn triangle(&self, t: u32) -> [u32; 3] {
        let c = 3 * t as usize;
        [self.vertices[c], self.vertices[c + 1], self.vertices[c + 2]]
    }

    /// Position of the vertex that half-edge `c` leaves.
    #[inline]
    pub fn point(&self, c: u32) -> DVec3 {
        self.points[self.vertex(c) as usize]
    }

    /// Positions of all vertices of the mesh.
    pub fn points(&self) -> &'a [DVec3] {
        self.points
    }
}
