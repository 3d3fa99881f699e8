//! Repairs triangles only where methods could not rely on them.

use super::flaws::{is_flawed, is_umbrella};
use super::options::RepairOptions;
use super::run::repair;
use crate::context::Context;
use crate::error::Result;
use crate::mesh::SurfaceMesh;

/// Faces with less area, relative to the squared diagonal, count as flat.
const FLAT_AREA: f64 = 1e-14;

/// A triangulated mesh (without attributes, if it had polygons) without flat or repeated faces, consistently oriented, cut
/// into sheets where it is not manifold; and a sentence for everything that was done. A sound mesh is only triangulated.
///
/// # Errors
/// [`crate::Error::Cancelled`], [`crate::Error::Deadline`].
pub fn sound(mesh: &SurfaceMesh, context: &Context) -> Result<(SurfaceMesh, Vec<String>)> {
    let mesh = divided(mesh)?;
    if !needs_repair(&mesh) {
        return Ok((mesh, Vec::new()));
    }
    let repaired = repair(&mesh, &RepairOptions { weld: None, outward: false, ..RepairOptions::default() }, context)?;
    let said = repaired.report.sentences();
    Ok((repaired.mesh.triangulated()?, said))
}

/// The mesh cut into triangles, with its tagged edges; attributes are left behind where it had polygons. These are fans, as
/// others read them, even where one is turned over; but not where that needs a repair that better triangles do not.
pub fn divided(mesh: &SurfaceMesh) -> Result<SurfaceMesh> {
    if mesh.is_triangular() {
        return Ok(mesh.clone());
    }
    let mut bare = SurfaceMesh::new(mesh.points().to_vec(), mesh.faces().clone())?;
    bare.tagged_edges = mesh.tagged_edges.clone();
    let fans = bare.clone().nearly_fanned()?;
    if needs_repair(&fans) { bare.triangulated() } else { Ok(fans) }
}

fn needs_repair(mesh: &SurfaceMesh) -> bool {
    is_flawed(mesh, FLAT_AREA) || !is_umbrella(mesh)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Polygons;
    use crate::mesh::test_models::*;
    use glam::DVec3;

    fn sentences(mesh: &SurfaceMesh) -> (SurfaceMesh, usize) {
        let (mesh, said) = sound(mesh, &Context::new()).unwrap();
        assert!(!needs_repair(&mesh));
        (mesh, said.len())
    }

    #[test]
    fn sound_meshes_stay_as_they_are() {
        for mesh in [grid(4), cube(DVec3::ZERO, 1.0)] {
            let (out, said) = sentences(&mesh);
            assert_eq!((out.points(), said), (mesh.points(), 0));
        }
    }

    #[test]
    fn quads_that_share_three_vertices_are_divided_apart() {
        let p = [DVec3::ZERO, DVec3::X, DVec3::new(1., 1., 0.), DVec3::Y, DVec3::new(0.6, 0.4, 0.0)];
        // Around vertex 1 and its two edges, both with the diagonal 0 2 if fanned from their first corners.
        let mut faces = Polygons::new();
        faces.push(&[0, 4, 2, 3]);
        faces.push(&[0, 1, 2, 4]);
        let mesh = SurfaceMesh::new(p.to_vec(), faces).unwrap();
        let (out, said) = sentences(&mesh);
        assert_eq!((out.face_count(), out.vertex_count(), said), (4, 5, 0));
    }

    /// Two quads that fold about the same diagonal, one up and one down: fans have it twice.
    #[test]
    fn fans_of_folded_quads_get_an_edge_each() {
        let p = [DVec3::ZERO, DVec3::X, DVec3::new(1., 1., 0.), DVec3::new(0., 1., 1.), DVec3::new(0., 1., -1.)];
        let mut faces = Polygons::new();
        faces.push(&[0, 1, 2, 3]);
        faces.push(&[2, 1, 0, 4]);
        let mesh = SurfaceMesh::new(p.to_vec(), faces).unwrap();
        let (out, said) = sentences(&mesh);
        assert_eq!((out.face_count(), out.vertex_count(), said), (6, 6, 0));
        assert_eq!(out.points()[5], DVec3::new(0.5, 0.5, 0.0));
    }

    /// An arrowhead: its second triangle is turned over, as in everybody's reading.
    #[test]
    fn polygons_are_fans_where_these_are_sound() {
        let p = [DVec3::ZERO, DVec3::new(3.0, 1.0, 0.0), DVec3::X, DVec3::new(3.0, -1.0, 0.0)];
        let mut faces = Polygons::new();
        faces.push(&[1, 2, 3, 0]);
        let mesh = SurfaceMesh::new(p.to_vec(), faces).unwrap();
        let (out, said) = sentences(&mesh);
        assert_eq!((out.faces().corners(), said), (&[1, 2, 3, 1, 3, 0][..], 0));
        assert_ne!(mesh.triangulated().unwrap().faces(), out.faces());
    }

    #[test]
    fn what_is_not_manifold_is_cut_and_reported() {
        assert!(sentences(&cubes_sharing_an_edge()).1 > 0);
        // Two triangles that touch in a vertex.
        let p = [DVec3::ZERO, DVec3::X, DVec3::Y, -DVec3::X, -DVec3::Y];
        let (out, said) = sentences(&triangles(&p, &[[0, 1, 2], [0, 3, 4]]));
        assert!(out.vertex_count() == 6 && said > 0);
    }
}
