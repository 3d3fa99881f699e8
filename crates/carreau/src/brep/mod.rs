//! Boundary representation: points, curves and surfaces, and how they bound each other. Knows no file format.
//!
//! ```text
//! solid ── shells (one outer, any number of voids)
//!            └── faces (a bounded part of a surface; several faces may share one)
//!                  └── loops (the first is the outer one where there is one), and points that are loops: poles
//!                        └── uses of edges (a curve each, shared by the faces that meet there)
//!                              └── vertices
//! ```
//!
//! **Orientation.** A face's normal is that of its surface, ∂S/∂u × ∂S/∂v, or its opposite where `same_sense` is false.
//! Normals point out of the solid, on voids too, where "out of the solid" is into the void. Loops run counter-clockwise
//! around the face's material seen from the tip of the face's normal: the outer loop counter-clockwise, holes clockwise. An
//! edge runs along its curve, from the first parameter of its range to the last; a use says whether the loop runs the other
//! way.
//!
//! ```text
//!         ┌────────◄────────┐
//!         │    ┌───►───┐    │       the normal points to the reader
//!         ▼    ▲ hole  ▼    ▲
//!         │    └───◄───┘    │
//!         └────────►────────┘
//! ```
//!
//! **Seams.** A face that goes all the way round a periodic surface has an edge that its loop runs along twice, in opposite
//! senses: a line on cylinders and cones, a circle on spheres and tori. So a tube between two rings has one loop of four uses:
//!
//! ```text
//!     ●────◄────●  ring b, reversed
//!     │         │
//!     ▼ seam    ▲ seam          the same edge on the left and on the right: u and u + 2π
//!     │         │
//!     ●────►────●  ring a
//! ```
//!
//! A ring is an edge with one vertex at both ends and a range of one period. A seam that runs into the apex of a cone or the
//! pole of a sphere ends in a vertex there, and the loop turns round at it. A torus without a border has two seams that cross
//! at one vertex. A whole sphere has no edge: its one loop is the vertex in `poles`.
//!
//! | file | holds |
//! |---|---|
//! | `frame` | local coordinate systems and motions |
//! | `curve` | lines, conics, splines |
//! | `surface` | planes, cylinders, cones, spheres, tori, swept surfaces, splines |
//! | `check` | proof that references, loops and ends fit together |
//! | `boundary` | loops of a face in the parameter plane, unrolled |
//! | `tessellate/` | triangles, watertight |
//! | `mass` | area, volume, centroid |
//! | `row` | a line of a spline surface, for integrals along it |
//! | `validate/` | everything that may be wrong with a model, and its distance from a mesh |

mod boundary;
mod check;
pub mod curve;
pub mod frame;
mod mass;
#[cfg(test)]
pub(crate) mod models;
mod row;
pub mod surface;
pub mod tessellate;
#[cfg(test)]
mod tests;
pub mod validate;

pub use curve::{Curve, CurveKind};
pub use frame::{Frame, Motion};
use glam::DVec3;
pub use mass::Mass;
pub use surface::{Surface, SurfaceKind};
use tessellate::Fineness;

/// A model made of faces. All references are indices into the model's own lists.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Brep {
    /// The vertices.
    pub vertices: Vec<Vertex>,
    /// The edges.
    pub edges: Vec<Edge>,
    /// The surfaces under the faces.
    pub surfaces: Vec<Surface>,
    /// The faces.
    pub faces: Vec<Face>,
    /// Sets of faces connected by edges; every face is in one.
    pub shells: Vec<Shell>,
    /// Solids; the shells that no solid has are surfaces.
    pub solids: Vec<Solid>,
}

/// A point where edges end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Vertex {
    /// Its position.
    pub point: DVec3,
    /// Largest distance from the ends of its edges' curves; 0 where they meet exactly.
    pub tolerance: f64,
}

impl Vertex {
    /// A vertex that is exactly where its edges end.
    pub fn exact(point: DVec3) -> Self {
        Vertex { point, tolerance: 0.0 }
    }
}

/// A bounded part of a curve.
#[derive(Debug, Clone, PartialEq)]
pub struct Edge {
    /// Its shape.
    pub curve: Curve,
    /// Parameters of the curve where the edge begins and ends; increasing, at most one period apart.
    pub range: [f64; 2],
    /// The vertices there; the same one for a closed edge.
    pub ends: [u32; 2],
    /// Largest distance from the surfaces of its faces; 0 where it lies on them exactly.
    pub tolerance: f64,
}

impl Edge {
    /// The point at a share of the parameter range.
    pub fn point_at(&self, share: f64) -> DVec3 {
        self.curve.point(self.parameter_at(share))
    }

    /// The parameter at a share of the range.
    pub fn parameter_at(&self, share: f64) -> f64 {
        let [a, b] = self.range;
        if share >= 1.0 { b } else { a + share * (b - a) }
    }

    /// Whether it begins where it ends.
    pub fn is_closed(&self) -> bool {
        self.ends[0] == self.ends[1]
    }
}

/// A bounded part of a surface.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Face {
    /// What it lies on.
    pub surface: u32,
    /// Whether its normal is that of the surface, not the opposite.
    pub same_sense: bool,
    /// The outer loop, then the holes. On a periodic surface no loop need be the outer one.
    pub loops: Vec<Vec<EdgeUse>>,
    /// Vertices that are loops: a pole of a sphere without any edge, an apex that no edge runs into.
    pub poles: Vec<u32>,
    /// Whether the loops cut off a part of a spline surface; otherwise the outer loop is the border of all of it.
    pub trimmed: bool,
    /// What the face is called in files, such as `cylinder_12`; may be empty.
    pub name: String,
    /// Red, green and blue.
    pub color: Option<[u8; 3]>,
    /// The region of the mesh that the face stands for.
    pub region: Option<u32>,
}

impl Face {
    /// A face with the normal of its surface, without name or colour.
    pub fn new(surface: u32, loops: Vec<Vec<EdgeUse>>) -> Self {
        Face { surface, same_sense: true, loops, ..Default::default() }
    }

    /// Every use of an edge.
    pub fn uses(&self) -> impl Iterator<Item = &EdgeUse> {
        self.loops.iter().flatten()
    }
}

/// An edge as a part of a loop.
#[derive(Debug, Clone, PartialEq)]
pub struct EdgeUse {
    /// The edge.
    pub edge: u32,
    /// Whether the loop runs against the edge.
    pub reversed: bool,
    /// The edge in the (u, v) plane of a spline surface, in the sense of the *edge*: two points (then parameters are in
    /// proportion to those of the edge's curve), or one for each knot of the edge's spline. Empty where readers
    /// are to find it by projection, as they do well on everything but splines.
    pub parameters: Vec<[f64; 2]>,
}

impl EdgeUse {
    /// A use without parameters.
    pub fn new(edge: u32, reversed: bool) -> Self {
        EdgeUse { edge, reversed, parameters: Vec::new() }
    }

    /// The parameters at a share of the edge, where the use has them in proportion.
    pub fn at_share(&self, share: f64) -> Option<[f64; 2]> {
        let &[a, b] = self.parameters.as_slice() else { return None };
        Some([0, 1].map(|k| a[k] + share * (b[k] - a[k])))
    }
}

/// Faces connected by edges.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Shell {
    /// The faces.
    pub faces: Vec<u32>,
    /// Whether every edge is used twice, in opposite senses.
    pub closed: bool,
    /// What a surface that bounds no solid is called in files; may be empty.
    pub name: String,
}

/// A volume between shells: a body.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Solid {
    /// The shell around it.
    pub outer: u32,
    /// The shells around its cavities.
    pub voids: Vec<u32>,
    /// What the body is called in files; may be empty.
    pub name: String,
}

impl Brep {
    /// Corners of the bounding box of vertices, control points of splines and samples of edges; zero for an empty model.
    pub fn bounds(&self) -> [DVec3; 2] {
        let mut bounds = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        let mut include = |p: DVec3| bounds = [bounds[0].min(p), bounds[1].max(p)];
        self.vertices.iter().for_each(|v| include(v.point));
        for edge in self.edges.iter().filter(|e| e.curve.kind() != CurveKind::Line) {
            match &edge.curve {
                Curve::Spline(s) => s.points().iter().for_each(|&p| include(p)),
                _ => (1..16).for_each(|k| include(edge.point_at(f64::from(k) / 16.0))),
            }
        }
        for face in &self.faces {
            match &self.surfaces[face.surface as usize] {
                Surface::Spline(s) => s.points().iter().for_each(|&p| include(p)),
                // No edge tells of the extent of a whole sphere.
                Surface::Sphere { frame, radius } if face.loops.is_empty() => {
                    [-*radius, *radius].map(DVec3::splat).into_iter().for_each(|d| include(frame.origin + d));
                }
                _ => {}
            }
        }
        if bounds[0].is_finite() { bounds } else { [DVec3::ZERO; 2] }
    }

    /// The surface of a face.
    pub fn surface(&self, face: &Face) -> &Surface {
        &self.surfaces[face.surface as usize]
    }

    /// The position of a vertex.
    pub fn point(&self, vertex: u32) -> DVec3 {
        self.vertices[vertex as usize].point
    }

    /// The vertex at which a use of an edge begins.
    pub fn start(&self, of: &EdgeUse) -> u32 {
        self.edges[of.edge as usize].ends[usize::from(of.reversed)]
    }

    /// The vertex at which a use of an edge ends.
    pub fn end(&self, of: &EdgeUse) -> u32 {
        self.edges[of.edge as usize].ends[usize::from(!of.reversed)]
    }

    /// The shells that belong to no solid.
    pub fn free_shells(&self) -> Vec<u32> {
        let mut free = vec![true; self.shells.len()];
        for solid in &self.solids {
            solid.voids.iter().chain([&solid.outer]).for_each(|&s| free[s as usize] = false);
        }
        (0..self.shells.len() as u32).filter(|&s| free[s as usize]).collect()
    }

    /// The ranges of u and v that each face covers, in one piece across the joints of periodic surfaces; on planes and
    /// splines, whose parameters need no end, those of the surface.
    pub fn extents(&self) -> Vec<[[f64; 2]; 2]> {
        let samples = tessellate::sample_edges(self, &Fineness { chord: f64::INFINITY, angle: 0.2 });
        let of_face = |face: &Face| {
            let surface = self.surface(face);
            if face.loops.is_empty() || matches!(surface, Surface::Plane { .. } | Surface::Spline(_)) {
                return surface.domain();
            }
            let rings = boundary::unroll(self, face, &samples);
            let uvs = rings.iter().flat_map(|r| r.samples.iter().map(|s| s.uv));
            uvs.fold([[f64::INFINITY, f64::NEG_INFINITY]; 2], |[u, v], p| {
                [[u[0].min(p.x), u[1].max(p.x)], [v[0].min(p.y), v[1].max(p.y)]]
            })
        };
        self.faces.iter().map(of_face).collect()
    }

    /// The largest tolerance of a vertex or an edge.
    pub fn tolerance(&self) -> f64 {
        let vertices = self.vertices.iter().map(|v| v.tolerance);
        vertices.chain(self.edges.iter().map(|e| e.tolerance)).fold(0.0, f64::max)
    }

    /// The model after a motion. Parameters of uses on spline surfaces stay.
    pub fn moved(&self, by: &Motion) -> Self {
        let mut out = self.clone();
        for vertex in &mut out.vertices {
            *vertex = Vertex { point: by.point(vertex.point), tolerance: by.scale * vertex.tolerance };
        }
        for edge in &mut out.edges {
            if matches!(edge.curve, Curve::Line { .. }) {
                edge.range = edge.range.map(|t| by.scale * t);
            }
            edge.curve = edge.curve.moved(by);
            edge.tolerance *= by.scale;
        }
        out.surfaces.iter_mut().for_each(|s| *s = s.moved(by));
        out
    }
}
