//! Refuses surfaces with a wall: a pipe that is not filled, but has an inner and an outer side, is a sheet, and no
//! curve is its skeleton.
//!
//! Through a filled tube of area A and volume V it is 4 V / A across, through a sheet 2 V / A. Only surfaces with handles or cavities
//! are asked: what has neither encloses no room besides its own inside.

use super::SurfaceMesh;
use crate::geometry::normals::face_normals;
use crate::geometry::search_tree::TriangleTree;
use crate::mesh::{Topology, safe_length, triangle_area_vector};
use glam::DVec3;

/// If the way across is less than this many times V / A on half of the area, the surface is a sheet.
const SHEET: f64 = 2.6;
/// Rays that are sent, about.
const WALL_RAYS: usize = 2000;

/// How thick the wall is, where a closed surface is one.
pub fn thickness(surface: &SurfaceMesh, topology: &Topology) -> Option<f64> {
    let volume = topology.volume.filter(|volume| *volume > 0.0)?;
    if topology.genus == Some(0) && topology.components == 1 {
        return None;
    }
    let triangles = surface.faces().fan().0;
    let at = |t: &[u32; 3]| t.map(|v| surface.points()[v as usize]);
    let area = |t: &[u32; 3]| {
        let [a, b, c] = at(t);
        safe_length(triangle_area_vector(a, b, c))
    };
    let all: f64 = triangles.iter().map(area).sum();
    let tree = TriangleTree::new(surface.points(), &triangles);
    let normals = face_normals(surface);
    let mut across: Vec<(f64, f64)> = Vec::new();
    for t in tree.ids().step_by((triangles.len() / WALL_RAYS).max(1)) {
        let own = &triangles[t as usize];
        let from = at(own).into_iter().sum::<DVec3>() / 3.0;
        let mut nearest = f64::INFINITY;
        tree.along_ray(from, -normals[t as usize], f64::INFINITY, |hit| {
            if hit.triangle != t && hit.t > 0.0 {
                nearest = nearest.min(hit.t);
            }
        });
        if nearest.is_finite() {
            across.push((nearest, area(own)));
        }
    }
    across.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let half = 0.5 * across.iter().map(|a| a.1).sum::<f64>();
    let mut sum = 0.0;
    let median = across.iter().find(|a| {
        sum += a.1;
        sum >= half
    })?;
    (median.0 < SHEET * volume / all).then_some(median.0)
}
