//! What is wrong with triangles as methods see them.

use crate::mesh::{CornerId, NONE, Side, SurfaceMesh, Triangles, area_vector, safe_length};

/// Whether a mesh has faces of no more area than this share of the squared diagonal, edges that are not manifold or
/// inconsistently oriented, or two triangles on the same three vertices.
pub fn is_flawed(mesh: &SurfaceMesh, flat: f64) -> bool {
    let flat = flat * mesh.diagonal().powi(2);
    let is_flat = |f: &[u32]| safe_length(area_vector(mesh.points(), f)) <= flat;
    let irregular = |c: usize| matches!(mesh.side(CornerId::new(c)), Side::Inconsistent | Side::NonManifold);
    let pillow = |f: usize| {
        let across = |k: usize| mesh.opposite(CornerId::new(3 * f + k)).map(|o| mesh.face_of(o));
        across(0).is_some() && across(0) == across(1) && across(1) == across(2)
    };
    mesh.faces().iter().any(is_flat)
        || (0..mesh.corner_count()).any(irregular)
        || (mesh.is_triangular() && (0..mesh.face_count()).any(pillow))
}

/// Whether the faces around every vertex are one fan.
pub fn is_umbrella(mesh: &SurfaceMesh) -> bool {
    let Some(t) = Triangles::of(mesh) else { return false };
    let mut fans = vec![0u8; mesh.vertex_count()];
    let mut seen = vec![false; mesh.corner_count()];
    for corner in 0..mesh.corner_count() as u32 {
        if seen[corner as usize] {
            continue;
        }
        let v = t.vertex(corner) as usize;
        fans[v] = fans[v].saturating_add(1);
        // Both ways around, until a border or back.
        for turn in [true, false] {
            let mut c = corner;
            loop {
                seen[c as usize] = true;
                c = match turn {
                    true => t.opposite(t.previous(c)),
                    false => match t.opposite(c) {
                        NONE => NONE,
                        o => t.next(o),
                    },
                };
                if c == NONE || seen[c as usize] {
                    break;
                }
            }
        }
    }
    fans.iter().all(|&n| n < 2)
}
