//! Repair: from a surface as found in a file to manifold sheets with a consistent outside.
//!
//! | step | file | what happens | option |
//! |---|---|---|---|
//! | 1 | `super::weld` | vertices at one place become one | `weld` |
//! | 2 | `degenerate` | faces without area go, the surface stays closed | `degenerate` |
//! | 3 | `super::prepare` | of several faces on the same vertices one stays, two between bodies | `duplicates` |
//! | 4 | `super::prepare` | neighbours are turned until they agree | `orient` |
//! | 5 | `super::prepare` | bodies that touch come apart; what is still not manifold is cut into sheets | `split` |
//! | 6 | `orient` | closed components look outward, cavities inward | `outward` |
//! | 7 | `soup` | unreferenced vertices are dropped | `unreferenced` |
//!
//! Steps 2 to 6 are those of the preparation that every verb makes, but for the cuts (Guéziec, Taubin, Lazarus, Horn, "Cutting and
//! Stitching: Converting Sets of Polygons to Manifold Surfaces", IEEE TVCG 2001, global cutting): corners of a vertex stay together
//! only where a chain of edges of two sides links their faces.
//!
//! ```text
//!   ╲ │ ╱            ╲ │ ╱
//!    ╲│╱              ╲│╱
//!     •       →        •        two umbrellas, two vertices at one place
//!    ╱│╲               •
//!   ╱ │ ╲             ╱│╲
//! ```
//!
//! The order matters: welding makes degenerate and duplicate faces, both hide the sense and the umbrellas of their
//! neighbours, and what is outside can only be told once bodies that touched are separate. Holes are not filled. A
//! repaired mesh is left as it is by a second repair with the same options.

pub(super) mod degenerate;
mod orient;
mod sound;
mod soup;

use super::prepare::{Mended, Steps, leaders, mend};
use super::surface::SurfaceMesh;
use super::topology::Topology;
use crate::context::Context;
use crate::error::{Error, Result};
use crate::length::Length;
use serde::{Deserialize, Serialize};

pub(super) use orient::outward;
pub(super) use sound::is_umbrella;
pub use sound::sound;
pub(crate) use sound::{divided, is_flawed};
pub(super) use soup::Soup;

/// Which steps to take. By default all, with vertices welded at exactly equal positions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct RepairOptions {
    /// Weld vertices nearer than this; 0: at exactly equal positions; `None`: not at all.
    pub weld: Option<Length>,
    /// Remove repeated corners, slivers and faces without area.
    pub degenerate: bool,
    /// Drop all but the first of the faces on the same vertices, in whatever sense.
    pub duplicates: bool,
    /// Turn faces so that neighbours agree.
    pub orient: bool,
    /// Cut along non-manifold edges and at non-manifold vertices.
    pub split: bool,
    /// Turn closed components outward, and cavities (components nested in an odd number of others) inward.
    pub outward: bool,
    /// Drop vertices that no face uses.
    pub unreferenced: bool,
}

impl Default for RepairOptions {
    fn default() -> Self {
        RepairOptions {
            weld: Some(Length::Absolute(0.0)),
            degenerate: true,
            duplicates: true,
            orient: true,
            split: true,
            outward: true,
            unreferenced: true,
        }
    }
}

/// What was done, in numbers, and what was found before and after.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RepairReport {
    /// Vertices merged into another one at the same place.
    pub welded_vertices: usize,
    /// Faces that used a vertex twice: shortened, divided or dropped.
    pub collapsed_faces: usize,
    /// Longest edges of flat triangles that were flipped.
    pub flipped_edges: usize,
    /// Vertices merged into the other end of a shortest edge.
    pub merged_vertices: usize,
    /// Faces without area that could only be dropped.
    pub dropped_faces: usize,
    /// Faces on the same vertices as an earlier one: dropped.
    pub dropped_duplicates: usize,
    /// Faces turned to agree with their neighbours.
    pub turned_faces: usize,
    /// New vertices made by cutting.
    pub split_vertices: usize,
    /// Closed components turned as a whole.
    pub turned_components: usize,
    /// Vertices that no face used: dropped.
    pub dropped_vertices: usize,
    /// The mesh as it was.
    pub before: Topology,
    /// The mesh as it is now.
    pub after: Topology,
}

/// The result of [`repair`].
#[derive(Debug, Clone)]
pub struct Repaired {
    /// The repaired mesh; attributes and tagged edges have followed.
    pub mesh: SurfaceMesh,
    /// What was done.
    pub report: RepairReport,
}

/// Repairs a surface; see the module's head for the steps.
///
/// Vertices and faces keep their order; new vertices come last. Face attributes follow their face, corner attributes
/// their corner (also where a face is turned; directions stored as attributes are not negated), vertex attributes are
/// those of the vertex that stays. A tagged edge that is cut is tagged on every side.
///
/// # Errors
/// [`Error::Options`] for a negative tolerance, [`Error::Input`] where welding leaves no face, [`Error::Cancelled`] and
/// [`Error::Deadline`].
pub fn repair(mesh: &SurfaceMesh, options: &RepairOptions, context: &Context) -> Result<Repaired> {
    let before = Topology::of(mesh);
    let stage = context.stage("repair");
    stage.step(0, 3)?;
    let tolerance = options.weld.map(|tolerance| resolved(tolerance, mesh.diagonal())).transpose()?;
    let leader = tolerance.and_then(|tolerance| leaders(mesh, tolerance));
    stage.step(1, 3)?;
    let mut mended = mend(mesh, leader.as_deref(), None, options.steps(), context)?;
    stage.step(2, 3)?;
    let dropped_vertices = if options.unreferenced { mended.soup.drop_unreferenced() } else { 0 };
    let Mended { soup, removed, doubles, turned, inverted, copies, .. } = mended;
    let welded_vertices = welded(leader.as_deref(), &soup);
    let faces = mesh.face_count();
    let mesh = soup.into_mesh(mesh)?;
    if mesh.face_count() == 0 && faces > 0 && tolerance.is_some_and(|tolerance| tolerance > 0.0) {
        return Err(Error::input("no face has any area once vertices are welded", "", "weld less"));
    }
    let after = Topology::of(&mesh);
    stage.step(3, 3)?;
    let report = RepairReport {
        welded_vertices,
        collapsed_faces: removed.collapsed_faces,
        flipped_edges: removed.flipped_edges,
        merged_vertices: removed.merged_vertices,
        dropped_faces: removed.dropped_faces,
        dropped_duplicates: doubles.len(),
        turned_faces: turned.into_iter().filter(|&t| t).count(),
        split_vertices: copies,
        turned_components: inverted.len(),
        dropped_vertices,
        before,
        after,
    };
    Ok(Repaired { mesh, report })
}

/// Vertices that have become one with another: not those whose sheets have got them back.
fn welded(leader: Option<&[u32]>, soup: &Soup) -> usize {
    let Some(leader) = leader else { return 0 };
    let mut stays = vec![false; leader.len()];
    soup.vertex_source.iter().for_each(|&v| stays[v as usize] = true);
    (0u32..).zip(leader).filter(|&(v, &l)| l != v && !stays[v as usize]).count()
}

impl RepairOptions {
    fn steps(&self) -> Steps {
        Steps {
            degenerate: self.degenerate,
            doubles: self.duplicates,
            orient: self.orient,
            sheets: self.split,
            cut: self.split,
            outward: self.outward,
        }
    }

    /// Refuses a tolerance that is no length.
    ///
    /// # Errors
    /// [`Error::Options`].
    pub fn validate(&self) -> Result<()> {
        self.weld.map_or(Ok(()), |tolerance| resolved(tolerance, 1.0).map(drop))
    }
}

fn resolved(tolerance: Length, diagonal: f64) -> Result<f64> {
    let length = tolerance.resolve(diagonal);
    if length >= 0.0 && length.is_finite() {
        return Ok(length);
    }
    Err(Error::Options(format!("weld: {tolerance} is not a length such as 0.01 or 0.001%")))
}

impl RepairReport {
    /// One sentence for everything that was done, and for every defect that is left.
    pub fn sentences(&self) -> Vec<String> {
        let done = [
            (self.welded_vertices, "vertex welded", "vertices welded"),
            (self.collapsed_faces, "face with a repeated vertex shortened", "faces with repeated vertices shortened"),
            (self.flipped_edges, "edge of a flat triangle flipped", "edges of flat triangles flipped"),
            (self.merged_vertices, "sliver edge collapsed", "sliver edges collapsed"),
            (self.dropped_faces, "face without area dropped", "faces without area dropped"),
            (self.dropped_duplicates, "duplicate face dropped", "duplicate faces dropped"),
            (
                self.turned_faces,
                "face turned to agree with its neighbours",
                "faces turned to agree with their neighbours",
            ),
            (self.split_vertices, "vertex duplicated to cut the surface", "vertices duplicated to cut the surface"),
            (self.turned_components, "closed component turned inside out", "closed components turned inside out"),
            (self.dropped_vertices, "unreferenced vertex dropped", "unreferenced vertices dropped"),
        ];
        let left = [
            (self.after.boundary_loops, "boundary loop is left", "boundary loops are left"),
            (self.after.nonmanifold_edges, "non-manifold edge is left", "non-manifold edges are left"),
            (self.after.nonmanifold_vertices, "non-manifold vertex is left", "non-manifold vertices are left"),
            (self.after.degenerate_faces, "degenerate face is left", "degenerate faces are left"),
            (self.after.duplicate_faces, "duplicate face is left", "duplicate faces are left"),
            (self.after.unreferenced_vertices, "unreferenced vertex is left", "unreferenced vertices are left"),
            (self.after.inverted_components, "component is inside out", "components are inside out"),
        ];
        let sentence = |&(n, one, many): &(usize, &str, &str)| format!("{n} {}", if n == 1 { one } else { many });
        let mut out: Vec<String> = done.iter().chain(&left).filter(|s| s.0 > 0).map(sentence).collect();
        if !self.after.orientable {
            out.push(format!(
                "the surface has only one side (as a Möbius strip): {} edges stay inconsistent",
                self.after.inconsistent_edges
            ));
        } else if !self.after.consistently_oriented {
            out.push(format!("{} inconsistent edges are left", self.after.inconsistent_edges));
        }
        out
    }
}

#[cfg(test)]
mod tests;
