//! Uses of edges, and the Euler characteristic.

use super::{Fault, Finding};
use crate::brep::Brep;
use crate::mesh::SurfaceMesh;

/// Edges of closed shells that are not used twice, in opposite senses.
pub(super) fn edge_uses(brep: &Brep) -> Vec<Finding> {
    let mut out = Vec::new();
    for shell in brep.shells.iter().filter(|s| s.closed) {
        let mut uses: Vec<(u32, bool, u32)> = Vec::new();
        for &f in &shell.faces {
            uses.extend(brep.faces[f as usize].uses().map(|of| (of.edge, of.reversed, f)));
        }
        uses.sort_unstable();
        for of_edge in uses.chunk_by(|a, b| a.0 == b.0) {
            if let [(_, false, _), (_, true, _)] = of_edge {
                continue;
            }
            let edge = of_edge[0].0;
            let at = brep.edges[edge as usize].point_at(0.5);
            let finding = Finding::new(Fault::EdgeUses, of_edge.len() as f64, 2.0, at);
            out.push(finding.of_edge(edge).of_face(of_edge[0].2));
        }
    }
    out
}

/// V − E + Σ (2 − loops of a face): a face is a disk with a hole for every loop after the first, cut open along its seams.
pub(super) fn euler_characteristic(brep: &Brep, mesh: &SurfaceMesh) -> Option<Finding> {
    let mut used = [vec![false; brep.vertices.len()], vec![false; brep.edges.len()]];
    let mut model = 0i64;
    for face in &brep.faces {
        model += 2 - (face.loops.len() + face.poles.len()) as i64;
        face.poles.iter().for_each(|&v| used[0][v as usize] = true);
        for of in face.uses() {
            used[1][of.edge as usize] = true;
            brep.edges[of.edge as usize].ends.iter().for_each(|&v| used[0][v as usize] = true);
        }
    }
    let count = |list: &Vec<bool>| list.iter().filter(|&&x| x).count() as i64;
    model += count(&used[0]) - count(&used[1]);
    let of_mesh = characteristic_of(mesh);
    let at = mesh.points().first().copied().unwrap_or_default();
    (model != of_mesh).then(|| Finding::new(Fault::EulerCharacteristic, model as f64, of_mesh as f64, at))
}

/// V − E + F of the vertices that faces use.
fn characteristic_of(mesh: &SurfaceMesh) -> i64 {
    let mut used = vec![false; mesh.vertex_count()];
    let mut edges: Vec<[u32; 2]> = Vec::with_capacity(mesh.corner_count());
    for face in mesh.faces().iter() {
        for (k, &a) in face.iter().enumerate() {
            let b = face[(k + 1) % face.len()];
            used[a as usize] = true;
            edges.push([a.min(b), a.max(b)]);
        }
    }
    edges.sort_unstable();
    edges.dedup();
    used.iter().filter(|&&x| x).count() as i64 - edges.len() as i64 + mesh.face_count() as i64
}
