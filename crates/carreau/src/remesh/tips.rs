//! Where the surface comes to a point off all curves, as at the apex of a cone.
//!
//! ```text
//!        ╱•╲      The mean of the normals around it is no normal: all faces stand askew to it, however small they
//!      ╱╱ │ ╲╲    are, and constraint (1) would keep every one of them as it is.
//!    ╱─┴──┴──┴─╲
//! ```
//!
//! Such a vertex stays, and no face has to agree with its normal.

use super::curves::{Curves, Rank};
use crate::geometry::normals::{angle_between, unit};
use crate::mesh::EditMesh;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// The angles around a tip add up to less than a full turn by more than this, in degrees.
const POINTED_DEG: f64 = 40.0;
/// Its neighbours are flat beside it: their angles are off by less than this share of that.
const FLAT_BESIDE: f64 = 0.5;

impl Curves {
    /// Makes corners of the tips, and lists them.
    pub fn find_tips(&mut self, mesh: &EditMesh) {
        let is_free = |v: u32| self.rank[v as usize] == Rank::Free;
        let missing = |v: u32| if is_free(v) { missing_angle(mesh, v) } else { 0.0 };
        let is_tip = |v: &u32| {
            let own = missing(*v);
            let mut is_tip = mesh.is_vertex(*v) && own > POINTED_DEG.to_radians();
            if is_tip {
                mesh.for_neighbours(*v, |w| is_tip &= missing(w).abs() < FLAT_BESIDE * own);
            }
            is_tip
        };
        let tips: Vec<u32> = (0..mesh.vertex_slots()).into_par_iter().with_min_len(256).filter(is_tip).collect();
        tips.iter().for_each(|&v| self.rank[v as usize] = Rank::Corner);
        self.tips = tips;
    }
}

/// What the angles around a vertex lack of a full turn, in radians.
fn missing_angle(mesh: &EditMesh, v: u32) -> f64 {
    let way = |w: u32| unit(mesh.points[w as usize] - mesh.points[v as usize]);
    TAU - mesh.around(v).map(|h| angle_between(way(mesh.head(h)), way(mesh.apex(h)))).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::context::Context;
    use crate::mesh::{Polygons, SurfaceMesh};
    use crate::remesh::{RemeshOptions, enrich, simplify};
    use glam::DVec3;

    /// Two cones on one circle: needles from both tips to every edge of the rim.
    fn double_cone(sides: u32) -> SurfaceMesh {
        let mut points = vec![DVec3::Z, -DVec3::Z];
        points.extend((0..sides).map(|k| {
            let (sin, cos) = (TAU * f64::from(k) / f64::from(sides)).sin_cos();
            DVec3::new(cos, sin, 0.0)
        }));
        let mut faces = Polygons::new();
        for (a, b) in (0..sides).map(|k| (2 + k, 2 + (k + 1) % sides)) {
            faces.push(&[0, a, b]);
            faces.push(&[1, b, a]);
        }
        SurfaceMesh::new(points, faces).unwrap()
    }

    #[test]
    fn needles_around_a_tip_give_way() {
        for sides in [100, 600] {
            let mesh = double_cone(sides);
            for run in [simplify, enrich] {
                let out = run(&mesh, &RemeshOptions::default(), &Context::new()).unwrap();
                assert!(out.quality.shape_min > 0.2 && out.quality.shape_mean > 0.75, "{sides}: {:?}", out.quality);
                assert!(out.mesh.face_count() < 800, "{sides}: {}", out.mesh.face_count());
                let has = |p: DVec3| out.mesh.points().contains(&p);
                assert!(has(DVec3::Z) && has(-DVec3::Z), "the tips stay to the bit");
            }
        }
    }

    #[test]
    fn only_what_stands_out_is_a_tip() {
        // All vertices of a coarse ball lack as much of a full turn as their neighbours.
        let context = Context::new();
        let tips = |mesh: &SurfaceMesh| {
            let mut edit = EditMesh::new(mesh).unwrap();
            let marks = vec![None; edit.half_edge_slots() as usize];
            let size = vec![1.0; edit.vertex_slots() as usize];
            let mut curves = Curves::trace(&mut edit, &marks, &size);
            curves.find_tips(&edit);
            curves.tips
        };
        assert_eq!(tips(&double_cone(50)), [0, 1]);
        assert!(tips(&double_cone(4)).is_empty());
        let torus = crate::sample::make("torus", None, &context).unwrap().triangulated().unwrap();
        assert!(tips(&torus).is_empty());
    }
}
