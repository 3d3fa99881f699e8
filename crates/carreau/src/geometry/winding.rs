//! Generalised winding number: how often a surface wraps around a point.
//!
//! Jacobson, Kavan, Sorkine-Hornung, "Robust Inside-Outside Segmentation using Generalized Winding Numbers", SIGGRAPH
//! 2013: the sum of the solid angles of all triangles over 4π is 1 inside a closed surface, 0 outside, and changes
//! smoothly where there are holes, so one half is a sound boundary even for a broken mesh. Far triangles are summed as
//! one dipole per node, as in Barill et al., "Fast Winding Numbers for Soups and Clouds", SIGGRAPH 2018, to first order
//! with β = 3. The tree is a plain binary one over sorted triangles.

use super::search_tree::TriangleTree;
use crate::mesh::triangle_area_vector;
use glam::DVec3;
use std::f64::consts::PI;

/// Nodes are replaced by their dipole from this many radii on (β of the paper).
const FAR: f64 = 3.0;
/// Triangles per leaf.
const TRIANGLES_PER_NODE: usize = 8;

/// A hierarchy of dipoles over the triangles of a surface.
pub struct WindingTree {
    corners: Vec<[DVec3; 3]>,
    nodes: Vec<Dipole>,
}

#[derive(Clone, Copy)]
struct Dipole {
    /// Area-weighted centre.
    centre: DVec3,
    /// No triangle of the node reaches farther from the centre.
    radius: f64,
    /// Sum of the area vectors.
    moment: DVec3,
    /// Triangles of the node.
    first: u32,
    end: u32,
    /// The node to go on with when this one is not entered.
    skip: u32,
}

impl WindingTree {
    /// Builds the hierarchy, in the order of the leaves of a search tree.
    pub fn new(tree: &TriangleTree) -> Self {
        let corners: Vec<_> = tree.in_order().map(|(_, corners)| corners).collect();
        let mut nodes = Vec::with_capacity(corners.len() / TRIANGLES_PER_NODE * 3 + 1);
        if !corners.is_empty() {
            append(&mut nodes, &corners, 0, corners.len());
        }
        WindingTree { corners, nodes }
    }

    /// The winding number of the surface around a point, to a few hundredths.
    pub fn number(&self, p: DVec3) -> f64 {
        let mut solid_angle = 0.0;
        let mut k = 0;
        while let Some(node) = self.nodes.get(k) {
            let r = node.centre - p;
            let distance = r.length();
            if distance > FAR * node.radius {
                solid_angle += node.moment.dot(r) / distance.powi(3);
                k = node.skip as usize;
            } else {
                if node.skip as usize == k + 1 {
                    let own = &self.corners[node.first as usize..node.end as usize];
                    solid_angle += own.iter().map(|t| triangle_solid_angle(t.map(|q| q - p))).sum::<f64>();
                }
                k += 1;
            }
        }
        solid_angle / (4.0 * PI)
    }

    /// Whether the point is inside: the surface wraps around it more than half a time, in either sense.
    pub fn contains(&self, p: DVec3) -> bool {
        self.number(p).abs() > 0.5
    }
}

/// Appends the nodes over a range of triangles, parents first.
fn append(nodes: &mut Vec<Dipole>, corners: &[[DVec3; 3]], first: usize, end: usize) {
    let own = &corners[first..end];
    let area_vectors = || own.iter().map(|t| (triangle_area_vector(t[0], t[1], t[2]), (t[0] + t[1] + t[2]) / 3.0));
    let moment: DVec3 = area_vectors().map(|(a, _)| a).sum();
    let area: f64 = area_vectors().map(|(a, _)| a.length()).sum();
    let centre = match area > 0.0 {
        true => area_vectors().map(|(a, centre)| a.length() * centre).sum::<DVec3>() / area,
        false => own[0][0],
    };
    let radius = own.as_flattened().iter().map(|q| q.distance(centre)).fold(0.0, f64::max);
    let index = nodes.len();
    nodes.push(Dipole { centre, radius, moment, first: first as u32, end: end as u32, skip: 0 });
    if own.len() > TRIANGLES_PER_NODE {
        let middle = first + own.len() / 2;
        append(nodes, corners, first, middle);
        append(nodes, corners, middle, end);
    }
    nodes[index].skip = nodes.len() as u32;
}

/// Solid angle of a triangle seen from the origin, positive from its back (van Oosterom, Strackee, IEEE TBME 1983).
fn triangle_solid_angle([a, b, c]: [DVec3; 3]) -> f64 {
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    let denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    2.0 * a.dot(b.cross(c)).atan2(denominator)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::SurfaceMesh;
    use crate::mesh::test_models::*;
    use proptest::prelude::*;

    fn winding(mesh: &SurfaceMesh) -> WindingTree {
        WindingTree::new(&TriangleTree::new(mesh.points(), &mesh.faces().fan().0))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(16))]
        #[test]
        fn inside_a_torus_is_what_the_formula_says(
            queries in prop::collection::vec(prop::array::uniform3(-3.0f64..3.0), 64),
        ) {
            let tree = winding(&torus(64, 32));
            for p in queries.into_iter().map(|p| DVec3::from_array(p) * DVec3::new(1.0, 1.0, 0.3)) {
                let ring = DVec3::new(p.truncate().length() - 2.0, p.z, 0.0).length();
                if (ring - 0.5).abs() > 0.02 {
                    let number = tree.number(p);
                    prop_assert!((number - f64::from(u8::from(ring < 0.5))).abs() < 0.05, "{} at {}", number, ring);
                    prop_assert_eq!(tree.contains(p), ring < 0.5);
                }
            }
        }
    }

    #[test]
    fn nested_and_inverted_bodies_add_up() {
        let ball = |r: f64| moved(&sphere(2), |p| p * r);
        let number = |parts: &[SurfaceMesh]| winding(&together(parts)).number(DVec3::splat(0.1));
        assert!((number(&[ball(1.0), ball(2.0)]) - 2.0).abs() < 0.04);
        assert!(number(&[turned(&ball(1.0), |_| true), ball(2.0)]).abs() < 0.04);
        assert!((number(&[turned(&ball(1.0), |_| true)]) + 1.0).abs() < 0.04);
    }

    #[test]
    fn a_hole_changes_little() {
        let holed = without(&sphere(3), &[0, 1, 2, 3]);
        assert!(winding(&holed).contains(DVec3::ZERO) && !winding(&holed).contains(DVec3::X * 1.2));
    }

    #[test]
    fn nothing_contains_nothing() {
        assert_eq!(WindingTree::new(&TriangleTree::new(&[], &[])).number(DVec3::ZERO), 0.0);
    }
}
