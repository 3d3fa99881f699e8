//! How well triangles and quads are shaped.
//!
//! Measures as in Stimpson et al., "The Verdict Geometric Quality Library", Sandia 2007. Those of a single face do not
//! depend on its size; faces without area get the worst value.

use super::normals::{corner_angle, unit};
use super::summary::{Summary, sum};
use crate::mesh::{CornerId, SurfaceMesh, area_vector, safe_length, triangle_area_vector, unit_sized};

pub use crate::mesh::mean_ratio;
use glam::DVec3;
use serde::Serialize;

/// √3, which has no constant function.
const SQRT_3: f64 = 1.732_050_807_568_877_2;

/// Aspect ratio of a triangle, the longest edge over the inscribed circle's radius, divided by 2√3: 1 equilateral,
/// infinite flat.
pub fn aspect_ratio(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    let Some([a, b, c]) = unit_sized([a, b, c]) else { return f64::INFINITY };
    let lengths = [a.distance(b), b.distance(c), c.distance(a)];
    let longest = lengths[0].max(lengths[1]).max(lengths[2]);
    longest * lengths.iter().sum::<f64>() / (4.0 * SQRT_3 * triangle_area_vector(a, b, c).length())
}

/// Scaled Jacobian of a quad: the smallest of the four corners' sines, signed by the normal at the centre (the cross
/// product of the diagonals). 1 rectangle, 0 a straight corner, negative where it is concave or folded.
pub fn scaled_jacobian(quad: [DVec3; 4]) -> f64 {
    let normal = unit(area_vector(&quad, &[0, 1, 2, 3]));
    let sides = [0, 1, 2, 3].map(|k| unit(quad[(k + 1) % 4] - quad[k]));
    let corner = |k: usize| sides[(k + 3) % 4].cross(sides[k]).dot(normal);
    (0..4).map(corner).fold(f64::INFINITY, f64::min)
}

/// Shape of all faces of a mesh. Parts are missing where no face of the kind exists.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SurfaceQuality {
    /// Total area, in the square of the file's unit.
    pub area: f64,
    /// Lengths of the edges, each counted once, in the file's unit.
    pub edge_length: Option<Summary>,
    /// Smallest interior angle of every face, in degrees.
    pub min_angle_deg: Option<Summary>,
    /// Largest interior angle of every face, in degrees; at most 180.
    pub max_angle_deg: Option<Summary>,
    /// Mean ratio of the triangles.
    pub mean_ratio: Option<Summary>,
    /// Aspect ratio of the triangles that have an area.
    pub aspect_ratio: Option<Summary>,
    /// Scaled Jacobian of the quads.
    pub scaled_jacobian: Option<Summary>,
}

impl SurfaceQuality {
    /// Measures all faces of a mesh.
    pub fn of(mesh: &SurfaceMesh) -> Self {
        let points = |f: &[u32]| f.iter().map(|&v| mesh.points()[v as usize]).collect::<Vec<_>>();
        let triangle = |f: &[u32]| <[DVec3; 3]>::try_from(points(f)).ok();
        let triangles: Vec<[DVec3; 3]> = mesh.faces().iter().filter_map(triangle).collect();
        let quads = mesh.faces().iter().filter_map(|f| <[DVec3; 4]>::try_from(points(f)).ok());
        let areas: Vec<f64> = mesh.faces().iter().map(|f| safe_length(area_vector(mesh.points(), f))).collect();
        let (min_angles, max_angles) = extreme_angles(mesh);
        let length = |ends: [u32; 2]| mesh.points()[ends[0] as usize].distance(mesh.points()[ends[1] as usize]);
        let aspects = triangles.iter().map(|&[a, b, c]| aspect_ratio(a, b, c)).filter(|a| a.is_finite());
        SurfaceQuality {
            area: sum(&areas),
            edge_length: Summary::of(mesh.half_edges().groups().map(|edge| length(edge.ends)).collect()),
            min_angle_deg: Summary::of(min_angles),
            max_angle_deg: Summary::of(max_angles),
            mean_ratio: Summary::of(triangles.iter().map(|&[a, b, c]| mean_ratio(a, b, c)).collect()),
            aspect_ratio: Summary::of(aspects.collect()),
            scaled_jacobian: Summary::of(quads.map(scaled_jacobian).collect()),
        }
    }
}

/// Smallest and largest interior angle of every face, in degrees.
fn extreme_angles(mesh: &SurfaceMesh) -> (Vec<f64>, Vec<f64>) {
    let angles: Vec<f64> =
        (0..mesh.corner_count()).map(|c| corner_angle(mesh, CornerId::new(c)).to_degrees()).collect();
    let of_face = |w: &[u32]| {
        let own = &angles[w[0] as usize..w[1] as usize];
        own.iter().fold((f64::INFINITY, 0f64), |(low, high), &a| (low.min(a), high.max(a)))
    };
    mesh.faces().offsets().windows(2).map(of_face).unzip()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::test_models::*;
    use proptest::prelude::*;

    fn corners() -> impl Strategy<Value = [DVec3; 3]> {
        prop::array::uniform3(prop::array::uniform3(-1.0f64..1.0)).prop_map(|p| p.map(DVec3::from_array))
    }

    proptest! {
        #[test]
        fn shape_depends_neither_on_size_nor_place_nor_order(t in corners(), scale in 1e-9f64..1e9) {
            let [a, b, c] = t;
            prop_assume!(triangle_area_vector(a, b, c).length() > 1e-3);
            let q = mean_ratio(a, b, c);
            prop_assert!((0.0..=1.0 + 1e-12).contains(&q));
            prop_assert!((q - mean_ratio(c, a, b)).abs() < 1e-12);
            let turn = glam::DQuat::from_rotation_x(1.0) * glam::DQuat::from_rotation_z(0.3);
            let [x, y, z] = t.map(|p| scale * (turn * p + DVec3::ONE));
            prop_assert!((q - mean_ratio(x, y, z)).abs() < 1e-9);
            prop_assert!((aspect_ratio(a, b, c) / aspect_ratio(x, y, z) - 1.0).abs() < 1e-9);
            prop_assert!(aspect_ratio(a, b, c) >= 1.0 - 1e-12);
        }

        #[test]
        fn the_jacobian_of_a_parallelogram_is_the_sine_of_its_angle(angle in 1f64..179.0, side in 0.1f64..10.0) {
            let v = side * DVec3::new(angle.to_radians().cos(), angle.to_radians().sin(), 0.0);
            let quad = [DVec3::ZERO, DVec3::X, DVec3::X + v, v];
            prop_assert!((scaled_jacobian(quad) - angle.to_radians().sin()).abs() < 1e-12);
        }
    }

    #[test]
    fn the_best_and_the_worst_shapes() {
        let equilateral = [DVec3::X, DVec3::Y, DVec3::Z];
        for scale in [1e-300, 1.0, 1e300] {
            let [a, b, c] = equilateral.map(|p| p * scale);
            assert!((mean_ratio(a, b, c) - 1.0).abs() < 1e-14 && (aspect_ratio(a, b, c) - 1.0).abs() < 1e-14);
        }
        assert_eq!(mean_ratio(DVec3::X, DVec3::X, DVec3::X), 0.0);
        assert_eq!(aspect_ratio(DVec3::ZERO, DVec3::X, DVec3::X * 2.0), f64::INFINITY);
        let dart = [DVec3::ZERO, DVec3::X, DVec3::new(0.2, 0.2, 0.0), DVec3::Y];
        assert!(scaled_jacobian(dart) < 0.0);
        let folded = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::ONE - DVec3::Z];
        assert!(scaled_jacobian(folded) <= 0.0);
    }

    #[test]
    fn a_cube_is_perfect() {
        let q = SurfaceQuality::of(&cube(DVec3::splat(5.0), 2.0));
        assert!((q.area - 24.0).abs() < 1e-12 && q.mean_ratio.is_none());
        let (edges, angles, jacobian) = (q.edge_length.unwrap(), q.min_angle_deg.unwrap(), q.scaled_jacobian.unwrap());
        assert_eq!((edges.count, edges.min, edges.max), (12, 2.0, 2.0));
        assert!((angles.min - 90.0).abs() < 1e-12 && (q.max_angle_deg.unwrap().max - 90.0).abs() < 1e-12);
        assert!((jacobian.min - 1.0).abs() < 1e-12 && jacobian.count == 6);
    }

    #[test]
    fn an_empty_mesh_has_no_quality() {
        let q = SurfaceQuality::of(&triangles(&[], &[]));
        assert!(q.area == 0.0 && q.edge_length.is_none() && q.min_angle_deg.is_none());
    }
}
