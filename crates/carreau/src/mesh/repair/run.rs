//! The repair of a surface, step by step.

use super::options::{RepairOptions, resolved};
use super::report::RepairReport;
use super::soup::Soup;
use crate::context::Context;
use crate::error::{Error, Result};
use crate::mesh::prepare::{Mended, leaders, mend};
use crate::mesh::surface::SurfaceMesh;
use crate::mesh::topology::Topology;

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
pub fn welded(leader: Option<&[u32]>, soup: &Soup) -> usize {
    let Some(leader) = leader else { return 0 };
    let mut stays = vec![false; leader.len()];
    soup.vertex_source.iter().for_each(|&v| stays[v as usize] = true);
    (0u32..).zip(leader).filter(|&(v, &l)| l != v && !stays[v as usize]).count()
}
