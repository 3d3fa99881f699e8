//! The faces of a picture, ready to be drawn: triangles with colours and normals, seen by the camera.

use super::camera::{Camera, Seen};
use super::color::{Linear, linear};
use super::content::{Colors, Picture};
use super::normals;
use super::palette::{self, Ramp};
use crate::mesh::Polygons;
use glam::{DVec3, Vec3};

/// Triangles as the camera sees them.
pub(super) struct Scene {
    /// The vertices in the image.
    pub(super) seen: Vec<Seen>,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) normals: Normals,
    pub(super) paint: Paint,
    /// Whether the projection is parallel.
    pub(super) parallel: bool,
}

/// Unit normals in camera axes.
pub(super) enum Normals {
    /// One per triangle.
    Flat(Vec<Vec3>),
    /// One per corner.
    Smooth(Vec<[Vec3; 3]>),
}

/// The colours of triangles before light falls on them.
pub(super) enum Paint {
    Uniform(Linear),
    /// One per triangle.
    Triangles(Vec<Linear>),
    /// Places on a colour ramp, one per vertex; NaN for grey.
    Ramp(Vec<f32>, Ramp),
}

impl Scene {
    pub(super) fn new(picture: &Picture<'_>, camera: &Camera) -> Self {
        let (triangles, parents) = drawn_triangles(picture);
        let unit: Vec<DVec3> = picture.points.iter().map(|&p| camera.unit(p)).collect();
        let flat = normals::flat(&unit, &triangles);
        let turned = |n: DVec3| camera.turn(n).as_vec3();
        let normals = if picture.crease > 0.0 {
            let smooth = normals::smooth(&unit, &triangles, &flat, picture.crease);
            Normals::Smooth(smooth.into_iter().map(|n| n.map(turned)).collect())
        } else {
            Normals::Flat(flat.into_iter().map(turned).collect())
        };
        Scene {
            seen: picture.points.iter().map(|&p| camera.see(p)).collect(),
            paint: paint(picture, &triangles, &parents),
            triangles,
            normals,
            parallel: camera.parallel,
        }
    }

    /// The corners of a triangle in the image.
    pub(super) fn corners(&self, triangle: usize) -> [Seen; 3] {
        self.triangles[triangle].map(|v| self.seen[v as usize])
    }
}

/// The triangles of all faces whose vertices exist and are finite, and the face each comes from.
fn drawn_triangles(picture: &Picture<'_>) -> (Vec<[u32; 3]>, Vec<u32>) {
    let fine = |v: &u32| picture.points.get(*v as usize).is_some_and(|p| p.is_finite());
    let (triangles, parents) = picture.faces.fan();
    triangles.into_iter().zip(parents).filter(|(t, _)| t.iter().all(fine)).unzip()
}

fn paint(picture: &Picture<'_>, triangles: &[[u32; 3]], parents: &[u32]) -> Paint {
    let per_face = |colors: &[Linear]| {
        let grey = linear(palette::MISSING);
        Paint::Triangles(parents.iter().map(|&f| colors.get(f as usize).copied().unwrap_or(grey)).collect())
    };
    match picture.colors {
        Colors::Uniform(color) => Paint::Uniform(linear(color)),
        Colors::Faces(colors) => per_face(&colors.iter().map(|&c| linear(c)).collect::<Vec<_>>()),
        Colors::Labels(labels) => {
            let labels: Vec<i32> = parents.iter().map(|&f| labels.get(f as usize).copied().unwrap_or(-1)).collect();
            let colors = palette::label_colors(&Polygons::from_triangles(triangles), &labels);
            Paint::Triangles(colors.into_iter().map(linear).collect())
        }
        Colors::FaceScalars(values, scale) => {
            let ramp = Ramp::new(scale);
            let places = scale.places(values);
            per_face(&places.into_iter().map(|x| ramp.at(x)).collect::<Vec<_>>())
        }
        Colors::VertexScalars(values, scale) => {
            let mut places = scale.places(values);
            places.resize(picture.points.len(), f32::NAN);
            Paint::Ramp(places, Ramp::new(scale))
        }
    }
}
