//! Checks that the simplified skeleton still represents the input: every input node must lie inside the mesh.

use super::refine::TubeMesh;
use crate::geometry::search_tree::TriangleTree;
use crate::geometry::winding::WindingTree;
use crate::mesh::{CurveNet, boundary_faces, split_quad};
use rayon::prelude::*;

/// Tubes are taken for this much thinner than they are: cells about them have flat faces.
const SURE: f64 = 0.85;

/// The nodes of a net, of those that have a segment, that are outside of the tubes of another.
pub fn outside(net: &CurveNet, tubes: &CurveNet) -> Vec<u32> {
    let tree = TriangleTree::of_segments(&tubes.points, tubes.edges.iter().copied());
    let around = net.incidence();
    let is_out = |v: &u32| {
        let p = net.points[*v as usize];
        let Some(near) = tree.closest(p) else { return true };
        let [a, b] = tubes.edges[near.triangle as usize].map(|k| k as usize);
        let along = tubes.points[b] - tubes.points[a];
        let t = ((near.point - tubes.points[a]).dot(along) / along.length_squared().max(1e-300)).clamp(0.0, 1.0);
        let radius = tubes.radii[a] + t * (tubes.radii[b] - tubes.radii[a]);
        near.distance() > SURE * radius
    };
    (0..net.points.len() as u32).into_par_iter().filter(|&v| around.valence(v) > 0).filter(is_out).collect()
}

/// Nodes on the boundary count as inside: this share of the net's diagonal.
const ON: f64 = 2e-3;

/// The nodes of a net, of those that have a segment, that are outside of cells.
pub fn outside_cells(net: &CurveNet, cells: &TubeMesh) -> Vec<u32> {
    let quads = boundary_faces(&cells.hexes);
    let triangles: Vec<[u32; 3]> = quads.iter().flat_map(|q| split_quad(&cells.points, q.0)).collect();
    let tree = TriangleTree::new(&cells.points, &triangles);
    let winding = WindingTree::new(&tree);
    let (around, near) = (net.incidence(), ON * net.diagonal());
    let is_out = |&v: &u32| {
        let p = net.points[v as usize];
        around.valence(v) > 0 && !winding.contains(p) && tree.closest_within(p, near).is_none()
    };
    (0..net.points.len() as u32).into_par_iter().filter(is_out).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn a_corner_that_is_cut_off_lies_outside() {
        let points = vec![DVec3::ZERO, DVec3::new(2.0, 2.0, 0.0), DVec3::X * 4.0];
        let bent = CurveNet::new(points.clone(), vec![0.5; 3], vec![[0, 1], [1, 2]]);
        let straight = CurveNet::new(points, vec![0.5; 3], vec![[0, 2]]);
        assert_eq!(outside(&bent, &bent), Vec::<u32>::new());
        assert_eq!(outside(&bent, &straight), [1]);
        assert_eq!(outside(&straight, &bent), Vec::<u32>::new());
        let thick = CurveNet { radii: vec![3.0; 3], ..straight };
        assert_eq!(outside(&bent, &thick), Vec::<u32>::new());
    }
}
