//! The independent check of every result.
//!
//! It looks at the mesh and the layout alone, with nothing from the construction: points and faces, no adjacency
//! tables, no candidates. A failure is a defect of carreau and becomes [`Error::Bug`].

use super::grid::Patch;
use crate::error::{Error, Result};
use crate::geometry::normals::unit;
use crate::mesh::{FaceId, SurfaceMesh, VertexId};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI};

/// Slack for the filters: the validator computes angles in its own way.
const TOLERANCE: f64 = 1e-6;

/// What a layout promised to keep.
#[derive(Debug, Clone, Copy)]
pub struct Promises {
    /// Largest Q, in radians.
    pub q_max: f64,
    /// Largest angle between the normals of a pair, in radians; infinite where the limit adapts to the surface.
    pub dihedral: f64,
    /// No corner above 180°.
    pub convex_only: bool,
    /// Smallest number of cells of a patch.
    pub min_cells: usize,
}

fn bug<T>(what: String) -> Result<T> {
    Err(Error::Bug(format!("quad patches: {what}")))
}

/// Checks a layout against its mesh. `is_barrier` tells of an edge that no patch may cross.
///
/// # Errors
/// [`Error::Bug`] with the first promise that is broken.
pub fn validate(
    mesh: &SurfaceMesh,
    patches: &[Patch],
    leftover: &[FaceId],
    promises: &Promises,
    is_barrier: impl Fn(VertexId, VertexId) -> bool,
) -> Result<()> {
    partition(mesh, patches, leftover)?;
    let edges = EdgeUse::of(mesh);
    for (k, patch) in patches.iter().enumerate() {
        if patch.cells() < promises.min_cells {
            return bug(format!("patch {k} has {} cells", patch.cells()));
        }
        for (r, c) in patch.cell_places() {
            let diagonal =
                cell(mesh, patch, r, c, promises).or_else(|what| bug(format!("patch {k}, cell ({r}, {c}): {what}")))?;
            let inner = inner_edges(patch, r, c).chain([diagonal]);
            for [a, b] in inner {
                if edges.count(a, b) != 2 || is_barrier(a, b) {
                    return bug(format!("patch {k}, cell ({r}, {c}): the inner edge {a} {b} may not be crossed"));
                }
            }
        }
    }
    Ok(())
}

/// No triangle twice; patches and leftover together are all triangles; sizes fit.
fn partition(mesh: &SurfaceMesh, patches: &[Patch], leftover: &[FaceId]) -> Result<()> {
    let mut seen = vec![false; mesh.face_count()];
    for (k, patch) in patches.iter().enumerate() {
        let (m, n) = (patch.rows as usize, patch.cols as usize);
        if m * n == 0 || patch.vertices.len() != (m + 1) * (n + 1) || patch.triangles.len() != 2 * m * n {
            return bug(format!("patch {k} of {m} × {n} cells has arrays of another size"));
        }
        if patch.vertices.iter().any(|v| v.index() >= mesh.vertex_count()) {
            return bug(format!("patch {k} has a vertex that does not exist"));
        }
    }
    for t in patches.iter().flat_map(|p| &p.triangles).chain(leftover) {
        match seen.get_mut(t.index()) {
            Some(seen @ false) => *seen = true,
            _ => return bug(format!("triangle {t} is used twice or does not exist")),
        }
    }
    match seen.iter().position(|s| !s) {
        Some(t) => bug(format!("triangle {t} is lost")),
        None => Ok(()),
    }
}

/// The inner grid edges that a cell has on its right and on its top.
fn inner_edges(patch: &Patch, r: u32, c: u32) -> impl Iterator<Item = [VertexId; 2]> + use<> {
    let [_, br, tr, tl] = patch.cell(r, c);
    let right = (c + 1 < patch.cols).then_some([br, tr]);
    let top = (r + 1 < patch.rows).then_some([tl, tr]);
    right.into_iter().chain(top)
}

/// One cell: the union of its triangles, in their sense, within the filters. Returns its diagonal.
fn cell(
    mesh: &SurfaceMesh,
    patch: &Patch,
    r: u32,
    c: u32,
    promises: &Promises,
) -> std::result::Result<[VertexId; 2], String> {
    let corners = patch.cell(r, c);
    let Some(d) = diagonal(mesh, patch, r, c) else {
        let triangles = patch.cell_triangles(r, c).map(|t| mesh.face(t));
        return Err(format!("corners {corners:?} are not the union of triangles {triangles:?}"));
    };
    if (0..4).any(|i| (0..i).any(|j| corners[i] == corners[j])) {
        return Err(format!("corners {corners:?} repeat"));
    }
    let shape = CellShape::new(corners.map(|v| mesh.point(v)), d);
    if !shape.bend.is_finite() {
        return Err("a triangle has no area".into());
    }
    if shape.q() > promises.q_max + TOLERANCE || shape.bend > promises.dihedral + TOLERANCE {
        return Err(format!("Q = {:.6}°, bent by {:.6}°", shape.q().to_degrees(), shape.bend.to_degrees()));
    }
    if promises.convex_only && shape.angles.iter().any(|&a| a > PI + TOLERANCE) {
        return Err("a corner is reflex".into());
    }
    Ok([corners[d], corners[d + 2]])
}

/// The corner (0 or 1) where the diagonal of a cell starts; `None` when the cell is not the union of its triangles.
fn diagonal(mesh: &SurfaceMesh, patch: &Patch, r: u32, c: u32) -> Option<usize> {
    let corners = patch.cell(r, c);
    let triangles = patch.cell_triangles(r, c).map(|t| mesh.face(t));
    let is = |t: &[u32], want: [usize; 3]| {
        let want = want.map(|k| corners[k].0);
        t.len() == 3 && (0..3).any(|k| (0..3).all(|i| t[(k + i) % 3] == want[i]))
    };
    let halves = |a: [usize; 3], b: [usize; 3]| {
        (is(triangles[0], a) && is(triangles[1], b)) || (is(triangles[0], b) && is(triangles[1], a))
    };
    if halves([0, 1, 2], [0, 2, 3]) { Some(0) } else { halves([0, 1, 3], [1, 2, 3]).then_some(1) }
}

/// Angles of a cell, computed from its points.
pub(super) struct CellShape {
    /// Corner angles in radians, sums of triangle angles.
    pub angles: [f64; 4],
    /// Angle between the normals of the two triangles; NaN when one has no area.
    pub bend: f64,
}

impl CellShape {
    /// The shape of a cell of a valid patch.
    pub fn of(mesh: &SurfaceMesh, patch: &Patch, r: u32, c: u32) -> Self {
        let d = diagonal(mesh, patch, r, c).unwrap_or(0);
        Self::new(patch.cell(r, c).map(|v| mesh.point(v)), d)
    }

    /// A quad cut along the diagonal that starts at corner `d`.
    fn new(p: [DVec3; 4], d: usize) -> Self {
        // Counted from the start of the diagonal.
        let at = |k: usize| p[(d + k) % 4];
        let (first, normal) = triangle_shape([at(0), at(1), at(2)]);
        let (second, other) = triangle_shape([at(0), at(2), at(3)]);
        let angles = [first[0] + second[0], first[1], first[2] + second[1], second[2]];
        let flat = [normal, other].contains(&DVec3::ZERO);
        CellShape { angles, bend: if flat { f64::NAN } else { between(unit(normal), unit(other)) } }
    }

    /// Q of equation 1, in radians.
    pub fn q(&self) -> f64 {
        self.angles.iter().map(|a| (FRAC_PI_2 - a).abs()).sum::<f64>() / 4.0
    }
}

/// Angles of a triangle, and a vector along its normal; zero when it has no area.
///
/// Scaled by a power of two, which rounds nothing: differences stay those of the input, even where one corner is out of all
/// proportion to the others, and where the cell's other triangle is. Large extents are scaled before subtracting, which
/// might overflow, small ones after, and in two halves, as the power itself may be out of range.
fn triangle_shape(p: [DVec3; 3]) -> ([f64; 3], DVec3) {
    let extent = p.iter().map(|&q| (q - p[0]).abs().max_element()).fold(0.0, f64::max);
    let exponent = if extent > 0.0 { extent.log2().floor().min(1023.0) as i32 } else { 0 };
    let halves = [-exponent / 2, -exponent - -exponent / 2].map(|e| 2f64.powi(e));
    let scaled = |x: DVec3| x * halves[0] * halves[1];
    let edge = |o: usize, a: usize| if extent < 1.0 { scaled(p[a] - p[o]) } else { scaled(p[a]) - scaled(p[o]) };
    let angle = |o: usize, a: usize, b: usize| between(edge(o, a), edge(o, b));
    // Of the three corners, the one between the shorter edges: at the others the small edge is lost in rounding.
    let length = |o: usize| edge((o + 1) % 3, (o + 2) % 3).length_squared();
    let o = (0..3).fold(0, |o, other| if length(other) > length(o) { other } else { o });
    ([angle(0, 1, 2), angle(1, 2, 0), angle(2, 0, 1)], edge(o, (o + 1) % 3).cross(edge(o, (o + 2) % 3)))
}

/// Angle between two vectors, in 0..=π.
fn between(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b))
}

/// The larger end point of every face side, grouped by the smaller one.
struct EdgeUse {
    start: Vec<u32>,
    larger: Vec<u32>,
}

impl EdgeUse {
    fn of(mesh: &SurfaceMesh) -> Self {
        let sides = || mesh.faces().iter().flat_map(|f| (0..f.len()).map(|k| (f[k], f[(k + 1) % f.len()])));
        let mut start = vec![0u32; mesh.vertex_count() + 1];
        sides().for_each(|(a, b)| start[a.min(b) as usize + 1] += 1);
        (1..start.len()).for_each(|k| start[k] += start[k - 1]);
        let (mut fill, mut larger) = (start.clone(), vec![0u32; mesh.corner_count()]);
        for (a, b) in sides() {
            let at = &mut fill[a.min(b) as usize];
            larger[*at as usize] = a.max(b);
            *at += 1;
        }
        EdgeUse { start, larger }
    }

    /// Number of face sides on an edge.
    fn count(&self, a: VertexId, b: VertexId) -> usize {
        let small = a.min(b).index();
        let ends = &self.larger[self.start[small] as usize..self.start[small + 1] as usize];
        ends.iter().filter(|&&end| end == a.max(b).0).count()
    }
}
