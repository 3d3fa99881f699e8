//! Normals of faces, vertices and corners.
//!
//! Vertex normals weight each face by its angle at the vertex (Thürmer, Wüthrich, "Computing Vertex Normals from
//! Polygonal Facets", Journal of Graphics Tools 1998): unlike area weights, they do not change when a face is cut.

use crate::mesh::{CornerId, SurfaceMesh, area_vector};
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::PI;

/// The vector with length one; zero for a zero vector. No scale is too small or too large.
#[inline]
pub fn unit(v: DVec3) -> DVec3 {
    let scale = v.abs().max_element();
    if scale > 0.0 && scale.is_finite() { (v / scale).normalize() } else { DVec3::ZERO }
}

/// Angle between two vectors in radians, 0 to π; exact where they are nearly parallel (atan2 of cross and dot product,
/// not the arc cosine). Zero where one of them is.
#[inline]
pub fn angle_between(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b))
}

/// A limit for the angle between unit vectors. In doubt the angle decides, but most are so far below the limit that the
/// cosine tells without it.
#[derive(Debug, Clone, Copy)]
pub struct AngleLimit {
    angle: f64,
    /// Of an angle that rounding cannot bring above the limit.
    cosine_below: f64,
}

impl AngleLimit {
    /// A limit in radians.
    pub fn new(angle: f64) -> Self {
        AngleLimit { angle, cosine_below: if angle >= PI { f64::NEG_INFINITY } else { angle.cos() + 1e-9 } }
    }

    /// Whether the angle between two vectors of length one or zero is larger; [`angle_between`] says the same.
    #[inline]
    pub fn is_exceeded(&self, a: DVec3, b: DVec3) -> bool {
        !(a.dot(b) > self.cosine_below) && angle_between(a, b) > self.angle
    }
}

/// Unit normal of every face; zero where a face has no area.
pub fn face_normals(mesh: &SurfaceMesh) -> Vec<DVec3> {
    (0..mesh.face_count()).into_par_iter().with_min_len(1024).map(face_normal(mesh)).collect()
}

/// The unit normal of a face by its number, as [`face_normals`] has it.
pub fn face_normal(mesh: &SurfaceMesh) -> impl Fn(usize) -> DVec3 + Send + Sync {
    let (low, high) = mesh.bounds();
    let extent = (high - low).max_element();
    // Products of lengths stay in the range of a double between these bounds.
    let scaled: Option<Vec<DVec3>> =
        (!(1e-100..1e100).contains(&extent)).then(|| mesh.points().iter().map(|&p| (p - low) / extent).collect());
    move |f| unit(area_vector(scaled.as_deref().unwrap_or(mesh.points()), mesh.faces().face(f)))
}

/// Interior angle of a face at a corner, in radians; reflex angles of concave polygons count as their complement.
pub fn corner_angle(mesh: &SurfaceMesh, c: CornerId) -> f64 {
    let p = |c| mesh.point(mesh.vertex(c));
    let here = p(c);
    angle_between(unit(p(mesh.next(c)) - here), unit(p(mesh.previous(c)) - here))
}

/// Unit normal of every vertex; zero where it has no face with area, or where the faces cancel out.
pub fn vertex_normals(mesh: &SurfaceMesh, face_normals: &[DVec3]) -> Vec<DVec3> {
    let mut sum = vec![DVec3::ZERO; mesh.vertex_count()];
    for c in (0..mesh.corner_count()).map(CornerId::new) {
        sum[mesh.vertex(c).index()] += corner_angle(mesh, c) * face_normals[mesh.face_of(c).index()];
    }
    sum.into_iter().map(unit).collect()
}

/// Unit normal of every corner: the mean over the faces that are reached around the vertex without crossing a feature,
/// a border or an irregular edge. A vertex on a ridge thus has one normal per side.
///
/// `feature[c]` tells whether the half-edge that leaves corner `c` is one; see [`super::features`].
pub fn corner_normals(mesh: &SurfaceMesh, face_normals: &[DVec3], feature: &[bool]) -> Vec<DVec3> {
    let mut normal = vec![DVec3::ZERO; mesh.corner_count()];
    let mut done = vec![false; mesh.corner_count()];
    let mut fan = Vec::new();
    for c in (0..mesh.corner_count()).map(CornerId::new) {
        if done[c.index()] {
            continue;
        }
        collect_fan(mesh, feature, c, &mut fan);
        let sum: DVec3 = fan.iter().map(|&k| corner_angle(mesh, k) * face_normals[mesh.face_of(k).index()]).sum();
        for k in &fan {
            normal[k.index()] = unit(sum);
            done[k.index()] = true;
        }
    }
    normal
}

/// The corners around the vertex of `c` between two features, clockwise from one of them; all if there is none.
///
/// ```text
///    b   a         the next corner clockwise from a is b, the one after the opposite of the
///    │ ╱ ╲         half-edge that leaves a;
/// ───•─────        counter-clockwise it is the opposite of the half-edge that enters a
/// ```
fn collect_fan(mesh: &SurfaceMesh, feature: &[bool], c: CornerId, fan: &mut Vec<CornerId>) {
    let open = |k: CornerId| if feature[k.index()] { None } else { mesh.opposite(k) };
    let clockwise = |k: CornerId| open(k).map(|o| mesh.next(o));
    let counter_clockwise = |k: CornerId| open(mesh.previous(k));
    let mut start = c;
    while let Some(k) = counter_clockwise(start).filter(|&k| k != c) {
        start = k;
    }
    fan.clear();
    fan.push(start);
    while let Some(k) = clockwise(fan[fan.len() - 1]).filter(|&k| k != start) {
        fan.push(k);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::test_models::*;

    #[test]
    fn many_faces_of_any_size_have_normals() {
        // Where products of lengths leave the range of a double: with the bounds looked up for every point this never ended.
        for size in [1e-150, 1.0, 1e150] {
            let mesh = moved(&grid(300), |p| size * p);
            assert!(face_normals(&mesh).into_iter().all(|n| n == DVec3::Z), "{size}");
        }
    }

    #[test]
    fn an_angle_limit_says_the_same_as_the_angle() {
        let at = |angle: f64| DVec3::new(angle.cos(), angle.sin(), 0.0);
        let angles: Vec<f64> = (0..=36).map(|k| f64::from(k) * PI / 36.0).collect();
        for &limit in &angles {
            for near in &angles {
                for shift in [-1e-6, -1e-9, -1e-12, 0.0, 1e-15, 1e-12, 1e-9, 1e-6] {
                    let (a, b) = (at(0.3), at(0.3 + near + shift));
                    assert_eq!(AngleLimit::new(limit).is_exceeded(a, b), angle_between(a, b) > limit);
                }
            }
            assert!(!AngleLimit::new(limit).is_exceeded(DVec3::ZERO, DVec3::X));
        }
    }

    #[test]
    fn normals_do_not_depend_on_scale() {
        let mesh = torus(20, 12);
        let normals = face_normals(&mesh);
        assert!(normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-15));
        for scale in [1e-300, 1e-160, 1e-20, 1e20, 1e160, 1e300] {
            let scaled = face_normals(&moved(&mesh, |p| p * scale));
            assert!(normals.iter().zip(&scaled).all(|(a, b)| a.distance(*b) < 1e-13), "{scale}");
        }
    }

    #[test]
    fn slivers_keep_their_normal() {
        for height in [1e-3, 1e-6, 1e-9, 1e-12] {
            let sliver = [DVec3::ZERO, DVec3::X * 3.0, DVec3::new(1.0, height, 0.0)].map(|p| p + DVec3::Z);
            for rotation in [[0, 1, 2], [1, 2, 0], [2, 0, 1]] {
                assert_eq!(face_normals(&triangles(&sliver, &[rotation])), [DVec3::Z]);
            }
        }
        let flat = triangles(&[DVec3::ZERO, DVec3::X, DVec3::X * 2.0], &[[0, 1, 2]]);
        assert_eq!(face_normals(&flat), [DVec3::ZERO]);
        assert_eq!(vertex_normals(&flat, &face_normals(&flat)), [DVec3::ZERO; 3]);
    }

    #[test]
    fn vertex_normals_of_a_sphere_point_away_from_its_centre() {
        let mesh = sphere(3);
        let normals = vertex_normals(&mesh, &face_normals(&mesh));
        assert!(mesh.points().iter().zip(normals).all(|(p, n)| angle_between(*p, n) < 0.01));
    }

    #[test]
    fn vertex_normals_of_a_cube_do_not_depend_on_its_diagonals() {
        let quads = cube(-DVec3::ONE, 2.0);
        let fans = quads.clone().triangulated().unwrap();
        for mesh in [quads, fans] {
            let normals = vertex_normals(&mesh, &face_normals(&mesh));
            assert!(mesh.points().iter().zip(normals).all(|(p, n)| unit(*p).distance(n) < 1e-12));
        }
    }

    #[test]
    fn corner_normals_are_split_at_features_only() {
        let mesh = cube(-DVec3::ONE, 2.0).triangulated().unwrap();
        let faces = face_normals(&mesh);
        let sharp: Vec<bool> = (0..mesh.corner_count())
            .map(|c| mesh.opposite(CornerId::new(c)).unwrap())
            .enumerate()
            .map(|(c, o)| faces[c / 3].distance(faces[o.index() / 3]) > 0.1)
            .collect();
        let split = corner_normals(&mesh, &faces, &sharp);
        assert!(split.iter().enumerate().all(|(c, n)| n.distance(faces[c / 3]) < 1e-12));
        let smooth = corner_normals(&mesh, &faces, &vec![false; mesh.corner_count()]);
        let per_vertex = vertex_normals(&mesh, &faces);
        assert!(
            (0..mesh.corner_count())
                .all(|c| { smooth[c].distance(per_vertex[mesh.vertex(CornerId::new(c)).index()]) < 1e-12 })
        );
    }
}
