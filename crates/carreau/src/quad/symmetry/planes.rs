//! Planes of symmetry: across an axis, at the place where the mirror image of the surface is nearest to it.

use super::{MirrorPlane, Symmetry};
use crate::context::Context;
use crate::error::{Error, Result};
use crate::geometry::search_tree::TriangleTree;
use crate::mesh::{SurfaceMesh, divided, triangle_area_vector};
use crate::numeric::eigen3::{Eigen3, outer};
use glam::{DMat3, DVec3};

/// A count: places of the surface whose mirror images are looked at, enough for what is as large as a quad of the usual number.
const PLACES: usize = 6000;
/// A share of the quads' edges: a surface that is farther from its mirror image is not symmetric by itself, because quads of one
/// half would be visibly off the other.
const SYMMETRIC_WITHIN: f64 = 0.3;
/// A count of the quads' edges: a plane that is asked for is refused where the surface is farther from its mirror image, because a
/// part of it has nothing on the other side.
const MOST_ASYMMETRY: f64 = 3.0;

/// What was found.
pub enum Found {
    /// At right angles to each other.
    Planes(Vec<MirrorPlane>),
    /// Why there are none.
    None(String),
}

/// The planes that are asked for. `edge`: length of the quads.
pub fn planes(mesh: &SurfaceMesh, symmetry: Symmetry, edge: f64, context: &Context) -> Result<Found> {
    let surface = Surface::new(&divided(mesh)?);
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    let axis = match symmetry {
        Symmetry::Off => return Ok(Found::None("none was asked for".into())),
        Symmetry::X => axes[0],
        Symmetry::Y => axes[1],
        Symmetry::Z => axes[2],
        Symmetry::Auto => return auto(&surface, axes, edge, context),
    };
    context.check()?;
    let plane = surface.best(axis);
    if plane.asymmetry > MOST_ASYMMETRY * edge {
        return Err(Error::Numeric(format!(
            "the surface is not symmetric across {}: its mirror image is up to {:.4} off, {:.1} edges of the quads; ask for no symmetry, or for auto",
            ["x", "y", "z"][axes.iter().position(|&a| a == axis).unwrap_or(0)],
            plane.asymmetry,
            plane.asymmetry / edge
        )));
    }
    Ok(Found::Planes(vec![plane]))
}

fn auto(surface: &Surface, axes: [DVec3; 3], edge: f64, context: &Context) -> Result<Found> {
    let mut nearest = f64::INFINITY;
    for axes in [axes, surface.principal_axes()] {
        context.check()?;
        let planes = axes.map(|axis| surface.best(axis));
        nearest = planes.iter().map(|p| p.asymmetry).fold(nearest, f64::min);
        let found: Vec<_> = planes.into_iter().filter(|p| p.asymmetry <= SYMMETRIC_WITHIN * edge).collect();
        if !found.is_empty() {
            return Ok(Found::Planes(found));
        }
    }
    Ok(Found::None(format!(
        "the surface has no plane of symmetry: its nearest mirror image is {nearest:.4} off, and .3 edges of the quads are allowed"
    )))
}

/// A surface that mirror images are compared with.
struct Surface {
    tree: TriangleTree,
    /// Places on it, spread evenly over its vertices and triangles.
    places: Vec<DVec3>,
    /// The middle of its area, and of its box.
    middles: [DVec3; 2],
    /// Second moments of its area about that middle.
    moments: DMat3,
}

impl Surface {
    fn new(mesh: &SurfaceMesh) -> Self {
        let triangles = mesh.faces().fan().0;
        let middle = |t: &[u32; 3]| t.iter().map(|&v| mesh.points()[v as usize]).sum::<DVec3>() / 3.0;
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| mesh.points()[v as usize]);
            triangle_area_vector(a, b, c).length()
        };
        let sum: f64 = triangles.iter().map(area).sum();
        let centre = triangles.iter().map(|t| middle(t) * area(t)).sum::<DVec3>() / sum.max(f64::MIN_POSITIVE);
        // Of each triangle those of three masses in the middles of its edges, which is exact.
        let of = |t: &[u32; 3]| {
            let p = t.map(|v| mesh.points()[v as usize] - centre);
            let at = |k: usize| outer((p[k] + p[(k + 1) % 3]) / 2.0);
            (at(0) + at(1) + at(2)) * (area(t) / 3.0)
        };
        let moments = triangles.iter().map(of).fold(DMat3::ZERO, |a, b| a + b);
        let (low, high) = mesh.bounds();
        let spread = |count: usize| (0..count).step_by(count.div_ceil(PLACES / 2).max(1));
        let corners = mesh.faces().corners();
        let vertices = spread(corners.len()).map(|c| mesh.points()[corners[c] as usize]);
        let places = vertices.chain(spread(triangles.len()).map(|t| middle(&triangles[t]))).collect();
        let tree = TriangleTree::new(mesh.points(), &triangles);
        Surface { tree, places, middles: [centre, (low + high) / 2.0], moments }
    }

    /// The plane across an axis through the middle that suits better.
    fn best(&self, normal: DVec3) -> MirrorPlane {
        let of = |middle: DVec3| {
            let mut plane = MirrorPlane { normal, offset: normal.dot(middle), asymmetry: 0.0 };
            plane.asymmetry = self.places.iter().map(|&p| self.tree.distance(plane.image(p))).fold(0.0, f64::max);
            plane
        };
        let [a, b] = self.middles.map(of);
        if b.asymmetry < a.asymmetry { b } else { a }
    }

    fn principal_axes(&self) -> [DVec3; 3] {
        Eigen3::new(self.moments).vectors.map(|v| v.normalize_or(DVec3::X))
    }
}
