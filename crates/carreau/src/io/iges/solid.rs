//! The whole boundary representation: 186 solids of 514 shells of 510 faces of 508 loops of 504 edges and 502 vertices.
//!
//! IGES orients a face in its shell, not on its surface: loops run counter-clockwise about the surface's own normal, and the
//! shell says whether the face looks that way.

use super::records::{Entity, Head, Writer};
use super::words::{DEPENDENT, INDEPENDENT};
use crate::brep::{Brep, Edge, EdgeUse, Face};

/// The lists that loops refer to.
struct Lists {
    edges: Entity,
    vertices: Entity,
}

impl Writer {
    /// All solids, and the shells that bound none.
    pub(super) fn solids(&mut self, brep: &Brep) {
        let extents = surface_extents(brep);
        let surfaces: Vec<Entity> =
            brep.surfaces.iter().zip(extents).map(|(surface, extent)| self.surface(surface, extent)).collect();
        let lists = self.lists(brep);
        let faces: Vec<Entity> =
            brep.faces.iter().map(|face| self.face(face, surfaces[face.surface as usize], &lists)).collect();
        let free = brep.free_shells();
        let mut shells = Vec::with_capacity(brep.shells.len());
        for (k, shell) in brep.shells.iter().enumerate() {
            let is_free = free.binary_search(&(k as u32)).is_ok();
            let status = if is_free { INDEPENDENT } else { DEPENDENT };
            let name = self.name(if is_free { &shell.name } else { "" });
            // Form 1 is a closed shell, form 2 an open one.
            let form = if shell.closed { 1 } else { 2 };
            shells.push(self.record(&Head { kind: 514, status, form, ..Head::default() }, |w| {
                w.integer(shell.faces.len() as u32);
                for &f in &shell.faces {
                    w.integers([faces[f as usize], u32::from(brep.faces[f as usize].same_sense)]);
                }
                w.property(name);
            }));
        }
        for solid in &brep.solids {
            let name = self.name(&solid.name);
            self.record(&Head { kind: 186, status: INDEPENDENT, ..Head::default() }, |w| {
                w.integers([shells[solid.outer as usize], 1, solid.voids.len() as u32]);
                for &v in &solid.voids {
                    w.integers([shells[v as usize], 1]);
                }
                w.property(name);
            });
        }
    }

    /// All vertices and all edges.
    fn lists(&mut self, brep: &Brep) -> Lists {
        let curves: Vec<Entity> = brep.edges.iter().map(|edge| self.edge_curve(edge, false, brep)).collect();
        let vertices = self.record(&Head { kind: 502, form: 1, ..Head::default() }, |w| {
            w.integer(brep.vertices.len() as u32);
            brep.vertices.iter().for_each(|v| w.point(v.point));
        });
        let edges = self.record(&Head { kind: 504, form: 1, ..Head::default() }, |w| {
            w.integer(brep.edges.len() as u32);
            for (Edge { ends: [a, b], .. }, &curve) in brep.edges.iter().zip(&curves) {
                w.integers([curve, vertices, a + 1, vertices, b + 1]);
            }
        });
        Lists { edges, vertices }
    }

    /// 510: surface, number of loops, "the first is the outer one", loops.
    fn face(&mut self, face: &Face, surface: Entity, lists: &Lists) -> Entity {
        let mut loops: Vec<Entity> =
            face.loops.iter().map(|uses| self.face_loop(uses, face.same_sense, lists)).collect();
        for &pole in &face.poles {
            loops.push(self.record(&Head { kind: 508, form: 1, ..Head::default() }, |w| {
                w.integers([1, 1, lists.vertices, pole + 1, 1, 0]);
            }));
        }
        let color = self.color(face.color);
        let name = self.name(&face.name);
        self.record(&Head { kind: 510, form: 1, color, ..Head::default() }, |w| {
            w.integers([surface, loops.len() as u32, 1]);
            w.integers(loops);
            w.property(name);
        })
    }

    /// 508: for each edge its list, its number, its sense, and no curve in the parameter plane.
    fn face_loop(&mut self, uses: &[EdgeUse], same_sense: bool, lists: &Lists) -> Entity {
        let mut order: Vec<(u32, bool)> = uses.iter().map(|of| (of.edge, of.reversed == same_sense)).collect();
        if !same_sense {
            order.reverse();
        }
        self.record(&Head { kind: 508, form: 1, ..Head::default() }, |w| {
            w.integer(order.len() as u32);
            for (edge, reversed) in order {
                w.integers([0, lists.edges, edge + 1, u32::from(!reversed), 0]);
            }
        })
    }
}

/// The ranges of u and v of all faces on each surface.
fn surface_extents(brep: &Brep) -> Vec<[[f64; 2]; 2]> {
    let mut out = vec![[[f64::INFINITY, f64::NEG_INFINITY]; 2]; brep.surfaces.len()];
    for (face, extent) in brep.faces.iter().zip(brep.extents()) {
        for (all, one) in out[face.surface as usize].iter_mut().zip(extent) {
            *all = [all[0].min(one[0]), all[1].max(one[1])];
        }
    }
    out
}
