//! What is exported: the mesh, its patches and leftover triangles, checked and ready.

use crate::error::{Error, Result};
use crate::mesh::{FaceId, SurfaceMesh};
use crate::patch::Patch;
use glam::DVec3;
use std::borrow::Cow;

/// The input of all stages.
pub struct Scene<'a> {
    /// The triangles.
    pub mesh: &'a SurfaceMesh,
    /// Positions of the vertices: those of the mesh, but for the corners of triangles without area.
    pub points: Cow<'a, [DVec3]>,
    /// The patches.
    pub patches: &'a [Patch],
    /// The leftover triangles with three different corners.
    pub leftover: Vec<FaceId>,
    /// What was adapted.
    pub warnings: Vec<String>,
}

/// Height over longest side below which a triangle has no plane.
const FLAT_TRIANGLE: f64 = 1e-11;
/// How far a corner of such a triangle is moved, as a share of the bounding-box diagonal.
const NUDGE: f64 = 1e-9;

impl<'a> Scene<'a> {
    /// Fails where patches or leftover triangles do not fit the mesh.
    pub fn new(mesh: &'a SurfaceMesh, patches: &'a [Patch], leftover: &[FaceId]) -> Result<Self> {
        check(mesh, patches, leftover)?;
        let distinct = |t: &FaceId| {
            let face = mesh.face(*t);
            face[0] != face[1] && face[1] != face[2] && face[2] != face[0]
        };
        let kept: Vec<FaceId> = leftover.iter().copied().filter(distinct).collect();
        let mut warnings = Vec::new();
        let dropped = leftover.len() - kept.len();
        if dropped > 0 {
            // Both its real sides join the same two vertices, so their neighbours meet without it.
            warnings.push(format!("{dropped} leftover triangle(s) with a repeated vertex have no face"));
        }
        let scene = Scene { mesh, points: Cow::Borrowed(mesh.points()), patches, leftover: kept, warnings };
        Ok(scene)
    }

    /// Position of a vertex.
    pub fn point(&self, v: u32) -> DVec3 {
        self.points[v as usize]
    }

    /// Positions of the corners of a triangle.
    pub fn corners(&self, t: FaceId) -> [DVec3; 3] {
        let face = self.mesh.face(t);
        [0, 1, 2].map(|k| self.point(face[k]))
    }

    /// Moves the apex of every triangle without area among these by a trifle, square to the longest side.
    ///
    /// Such a triangle has no plane, and modellers refuse a face on a line. Without it, however, the model would be open
    /// along its sides. The move is far below the resolution that the file states, yet enough for a plane.
    ///
    /// ```text
    ///                          b'
    ///   a ──── b ──── c   →   a ═══════ c     b' is 1e-9 diagonals beside the line
    /// ```
    pub fn nudge(&mut self, triangles: &[FaceId]) {
        let flat: Vec<FaceId> = triangles.iter().copied().filter(|&t| is_flat(self.corners(t))).collect();
        if flat.is_empty() {
            return;
        }
        let size = NUDGE * self.mesh.diagonal();
        let points = self.points.to_mut();
        let mut moved = Vec::with_capacity(flat.len());
        for &t in &flat {
            let face = self.mesh.face(t);
            let k = longest_side([0, 1, 2].map(|k| self.mesh.points()[face[k] as usize]));
            let [a, b, apex] = [0, 1, 2].map(|j| face[(k + j) % 3]);
            moved.push(apex);
            let line = (self.mesh.points()[b as usize] - self.mesh.points()[a as usize]).normalize_or(DVec3::X);
            let (x, y) = line.any_orthonormal_pair();
            // Every vertex in a direction of its own, so that triangles in a row do not stay flat.
            let angle = f64::from(apex.wrapping_mul(0x9e37_79b9)) / f64::from(u32::MAX) * std::f64::consts::TAU;
            points[apex as usize] = self.mesh.points()[apex as usize] + size * (angle.cos() * x + angle.sin() * y);
        }
        moved.sort_unstable();
        moved.dedup();
        self.warnings.push(format!(
            "{} leftover triangle(s) have no area; so that each has a plane, {} of their vertices are {NUDGE:e} diagonals \
             off in the CAD file",
            flat.len(),
            moved.len()
        ));
    }
}

/// The side (from corner k to the next) that is longest.
pub fn longest_side(corners: [DVec3; 3]) -> usize {
    let length = |k: usize| corners[k].distance_squared(corners[(k + 1) % 3]);
    (1..3).fold(0, |best, k| if length(k) > length(best) { k } else { best })
}

fn is_flat(corners: [DVec3; 3]) -> bool {
    let k = longest_side(corners);
    let [a, b, c] = [0, 1, 2].map(|j| corners[(k + j) % 3]);
    let side = b - a;
    let scale = side.length();
    let Some(axis) = side.try_normalize() else { return true };
    let height = (c - a) - axis * axis.dot(c - a);
    height.length() <= FLAT_TRIANGLE * scale
}

/// Fails where patches or leftover triangles do not fit the mesh; a cell with a repeated corner is refused, too.
fn check(mesh: &SurfaceMesh, patches: &[Patch], leftover: &[FaceId]) -> Result<()> {
    let wrong = |what: &str, k: usize| Err(Error::input(what, format!("patch {k}"), ""));
    for (k, patch) in patches.iter().enumerate() {
        let nodes = (u64::from(patch.rows) + 1) * (u64::from(patch.cols) + 1);
        if patch.rows == 0 || patch.cols == 0 || patch.vertices.len() as u64 != nodes {
            return wrong("the number of vertices does not fit rows and columns", k);
        }
        if patch.vertices.iter().any(|v| v.index() >= mesh.vertex_count()) {
            return wrong("a vertex does not exist", k);
        }
        let repeats = |[a, b, c, d]: [_; 4]| a == b || a == c || a == d || b == c || b == d || c == d;
        if patch.cell_corners().any(repeats) {
            return wrong("two corners of a cell are the same vertex", k);
        }
    }
    match leftover.iter().find(|t| t.index() >= mesh.face_count() || mesh.face(**t).len() != 3) {
        Some(t) => Err(Error::input("a leftover face does not exist or is not a triangle", format!("face {t}"), "")),
        None => Ok(()),
    }
}
