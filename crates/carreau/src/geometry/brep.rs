//! Boundary representation: points, curves and surfaces, and how they bound each other. Knows no file format.
//!
//! ```text
//! solid ── shells (one outer, any number of voids)
//!            └── faces (a surface each)
//!                  └── loops (the first is the outer one)
//!                        └── uses of edges (a curve each, shared by the faces that meet there)
//!                              └── vertices
//! ```
//!
//! A face's normal is that of its surface. Loops run counter-clockwise around the face's material seen from the tip of
//! the normal: the outer loop counter-clockwise, holes clockwise. Normals point out of the solid, on voids too, where
//! "out of the solid" is into the void.

use crate::error::{Error, Result};
use crate::geometry::bspline::{BSplineCurve, BSplineSurface};
use glam::DVec3;

/// A model made of faces. All references are indices into the model's own lists.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Brep {
    /// Positions of the vertices.
    pub vertices: Vec<DVec3>,
    /// The edges.
    pub edges: Vec<Edge>,
    /// The faces.
    pub faces: Vec<Face>,
    /// Sets of faces connected by edges; every face is in one.
    pub shells: Vec<Shell>,
    /// Solids; the shells that no solid has are surfaces.
    pub solids: Vec<Solid>,
}

/// A curve between two vertices.
#[derive(Debug, Clone, PartialEq)]
pub struct Edge {
    /// Where it begins and ends.
    pub ends: [u32; 2],
    /// Its shape.
    pub curve: Curve,
}

/// The shape of an edge.
#[derive(Debug, Clone, PartialEq)]
pub enum Curve {
    /// The straight segment between the ends.
    Line,
    /// A spline from the first end to the second.
    Spline(BSplineCurve),
}

/// A bounded part of a surface.
#[derive(Debug, Clone, PartialEq)]
pub struct Face {
    /// What it lies on.
    pub surface: Surface,
    /// The outer loop, then the holes.
    pub loops: Vec<Vec<EdgeUse>>,
    /// Whether the loops cut off a part of a spline surface; otherwise the outer loop is the border of all of it.
    pub trimmed: bool,
}

/// An edge as a part of a loop.
#[derive(Debug, Clone, PartialEq)]
pub struct EdgeUse {
    /// The edge.
    pub edge: u32,
    /// Whether the loop runs against the edge.
    pub reversed: bool,
    /// The edge in the (u, v) plane of a spline surface, in the sense of the *edge*: two points (then parameters are in
    /// proportion to those of the edge's curve), or one for each control point of an edge of degree 1. Empty on planes.
    pub parameters: Vec<[f64; 2]>,
}

/// What a face lies on.
#[derive(Debug, Clone, PartialEq)]
pub enum Surface {
    /// An unbounded plane.
    Plane {
        /// A point of it.
        origin: DVec3,
        /// Its unit normal.
        normal: DVec3,
        /// A unit vector in it.
        axis: DVec3,
    },
    /// A spline surface.
    Spline(BSplineSurface),
}

/// Faces connected by edges.
#[derive(Debug, Clone, PartialEq)]
pub struct Shell {
    /// The faces.
    pub faces: Vec<u32>,
    /// Whether every edge is used twice, in opposite senses.
    pub closed: bool,
}

/// A volume between shells.
#[derive(Debug, Clone, PartialEq)]
pub struct Solid {
    /// The shell around it.
    pub outer: u32,
    /// The shells around its cavities.
    pub voids: Vec<u32>,
}

impl Brep {
    /// Corners of the bounding box of vertices and control points; zero for an empty model.
    pub fn bounds(&self) -> [DVec3; 2] {
        let mut bounds = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        let mut include = |points: &[DVec3]| {
            bounds = points.iter().fold(bounds, |[low, high], &p| [low.min(p), high.max(p)]);
        };
        include(&self.vertices);
        for face in &self.faces {
            if let Surface::Spline(s) = &face.surface {
                include(s.points());
            }
        }
        if bounds[0].is_finite() { bounds } else { [DVec3::ZERO; 2] }
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

    /// Proves that the model is consistent: references exist, loops close, curves begin and end at their vertices, no
    /// edge is used twice in the same sense, closed shells have no free edge, solids consist of closed shells.
    pub fn check(&self) -> Result<()> {
        self.check_references()?;
        self.check_curves()?;
        self.check_loops()?;
        self.check_shells()
    }

    fn check_references(&self) -> Result<()> {
        let uses = || self.faces.iter().flat_map(|f| f.loops.iter().flatten());
        let solid_shells = self.solids.iter().flat_map(|s| s.voids.iter().chain([&s.outer]).copied());
        if below(self.edges.iter().flat_map(|e| e.ends), self.vertices.len())
            && below(uses().map(|u| u.edge), self.edges.len())
            && below(self.shells.iter().flat_map(|s| s.faces.iter().copied()), self.faces.len())
            && below(solid_shells, self.shells.len())
        {
            return Ok(());
        }
        defect("an index is out of range", 0)
    }

    fn check_curves(&self) -> Result<()> {
        for (k, edge) in self.edges.iter().enumerate() {
            if let Curve::Spline(c) = &edge.curve
                && c.ends() != edge.ends.map(|v| self.vertices[v as usize])
            {
                return defect("the curve does not end at the vertices of edge", k);
            }
        }
        Ok(())
    }

    fn check_loops(&self) -> Result<()> {
        for (k, face) in self.faces.iter().enumerate() {
            if face.loops.is_empty() {
                return defect("there is no loop on face", k);
            }
            for uses in &face.loops {
                let next = uses.iter().cycle().skip(1);
                if uses.is_empty() || uses.iter().zip(next).any(|(a, b)| self.end(a) != self.start(b)) {
                    return defect("a loop is not closed on face", k);
                }
            }
        }
        Ok(())
    }

    fn check_shells(&self) -> Result<()> {
        let mut shell_of = vec![u32::MAX; self.faces.len()];
        // Per edge: the shell that uses it, and how often in either sense.
        let mut used = vec![(u32::MAX, [0u32; 2]); self.edges.len()];
        for (s, shell) in self.shells.iter().enumerate() {
            for &f in &shell.faces {
                if std::mem::replace(&mut shell_of[f as usize], s as u32) != u32::MAX {
                    return defect("two shells have face", f as usize);
                }
                for of in self.faces[f as usize].loops.iter().flatten() {
                    let (owner, count) = &mut used[of.edge as usize];
                    count[usize::from(of.reversed)] += 1;
                    if *owner != u32::MAX && *owner != s as u32 || count[usize::from(of.reversed)] > 1 {
                        return defect("two shells, or two loops in the same sense, have edge", of.edge as usize);
                    }
                    *owner = s as u32;
                }
            }
        }
        if let Some(f) = shell_of.iter().position(|&s| s == u32::MAX) {
            return defect("no shell has face", f);
        }
        let open = |owner: u32| self.shells.get(owner as usize).is_none_or(|s| !s.closed);
        if let Some(e) = used.iter().position(|&(owner, count)| count != [1, 1] && !open(owner)) {
            return defect("a closed shell is open at edge", e);
        }
        let mut solid_shells = self.solids.iter().flat_map(|s| s.voids.iter().chain([&s.outer]));
        if solid_shells.any(|&s| !self.shells[s as usize].closed) {
            return defect("an open shell bounds a solid", 0);
        }
        Ok(())
    }
}

fn below(mut ids: impl Iterator<Item = u32>, limit: usize) -> bool {
    ids.all(|k| (k as usize) < limit)
}

fn defect(what: &str, id: usize) -> Result<()> {
    Err(Error::Bug(format!("boundary representation: {what} {id}")))
}
