//! Light: a key light from the upper left, a headlight, and a sky that is brighter than the ground.
//!
//! Faces are lit from both sides; those seen from behind are darker and paler, so that holes and turned faces show.

use super::camera::Seen;
use super::color::{Linear, mix};
use super::raster::{Depth, NOTHING};
use super::scene::{Normals, Paint, Scene};
use glam::Vec3;

/// Direction of the key light in camera axes.
const KEY: Vec3 = Vec3::new(-0.40, 0.62, 0.675);
/// Light from all around.
const AMBIENT: f32 = 0.27;
/// Light from the key light.
const KEY_LIGHT: f32 = 0.46;
/// Light from the headlight.
const HEADLIGHT: f32 = 0.25;
/// Light that the sky has more than the ground.
const SKY: f32 = 0.14;

/// The colour of every sample of a band, without its apron.
pub(super) fn shade(scene: &Scene, depth: &Depth, background: Linear) -> Vec<Linear> {
    let mut out = Vec::with_capacity(depth.rows.count * depth.width);
    for row in depth.rows.first..depth.rows.first + depth.rows.count {
        let mut last = (NOTHING, None);
        for (x, &triangle) in depth.triangles(row).iter().enumerate() {
            if triangle != last.0 {
                last = (triangle, (triangle != NOTHING).then(|| Surface::new(scene, triangle as usize)));
            }
            out.push(match &last.1 {
                Some(surface) => surface.color(x as f64 + 0.5, row as f64 + 0.5),
                None => background,
            });
        }
    }
    out
}

/// One triangle as it is lit.
struct Surface<'a> {
    scene: &'a Scene,
    triangle: usize,
    /// Corners 1 and 2 relative to corner 0 in the image, over twice the area: barycentric coordinates.
    origin: Seen,
    weights: [[f64; 2]; 2],
    nearness: [f64; 3],
    front: bool,
}

impl<'a> Surface<'a> {
    fn new(scene: &'a Scene, triangle: usize) -> Self {
        let [a, b, c] = scene.corners(triangle);
        let (ux, uy, vx, vy) = (b.x - a.x, b.y - a.y, c.x - a.x, c.y - a.y);
        let area = ux * vy - uy * vx;
        Surface {
            scene,
            triangle,
            origin: a,
            weights: [[vy / area, -vx / area], [-uy / area, ux / area]],
            nearness: [a.nearness, b.nearness, c.nearness],
            // Rows run downwards, so counter-clockwise is negative.
            front: area < 0.0,
        }
    }

    fn color(&self, x: f64, y: f64) -> Linear {
        let w = self.corner_weights(x, y);
        let normal = match &self.scene.normals {
            Normals::Flat(normals) => normals[self.triangle],
            Normals::Smooth(normals) => {
                let [a, b, c] = normals[self.triangle];
                (a * w[0] + b * w[1] + c * w[2]).normalize_or_zero()
            }
        };
        let base = match &self.scene.paint {
            Paint::Uniform(color) => *color,
            Paint::Triangles(colors) => colors[self.triangle],
            Paint::Ramp(places, ramp) => {
                let t = self.scene.triangles[self.triangle].map(|v| places[v as usize]);
                ramp.at(t[0] * w[0] + t[1] * w[1] + t[2] * w[2])
            }
        };
        if self.front { lit(base, normal) } else { lit(behind(base), -normal) }
    }

    /// Weights of the corners at a sample, within the triangle.
    ///
    /// Under perspective a value that is linear on the triangle is linear in the image when multiplied by nearness.
    fn corner_weights(&self, x: f64, y: f64) -> [f32; 3] {
        let (dx, dy) = (x - self.origin.x, y - self.origin.y);
        let along = self.weights.map(|g| (g[0] * dx + g[1] * dy).clamp(0.0, 1.0));
        let image = [(1.0 - along[0] - along[1]).max(0.0), along[0], along[1]];
        let nearness = |k: usize| if self.scene.parallel { 1.0 } else { self.nearness[k] };
        let corrected = [0, 1, 2].map(|k| image[k] * nearness(k));
        let sum: f64 = corrected.iter().sum();
        corrected.map(|w| (w / sum) as f32)
    }
}

/// The colour of the back of a face.
fn behind(base: Linear) -> Linear {
    let grey = (base[0] + base[1] + base[2]) / 3.0;
    mix(base, [grey; 3], 0.6).map(|c| 0.42 * c)
}

/// A colour under the lights; the normal points towards the eye.
fn lit(base: Linear, normal: Vec3) -> Linear {
    let key = normal.dot(KEY).max(0.0);
    let head = normal.z.max(0.0);
    let sky = 0.5 + 0.5 * normal.y;
    let light = AMBIENT + KEY_LIGHT * key + HEADLIGHT * head + SKY * sky;
    base.map(|c| c * light)
}

#[cfg(test)]
mod tests {
    use super::super::camera::Camera;
    use super::super::{Picture, View};
    use super::*;
    use crate::mesh::Polygons;
    use glam::DVec3;
    use proptest::prelude::*;

    fn point() -> impl Strategy<Value = DVec3> {
        [-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64].prop_map(DVec3::from)
    }

    proptest! {
        /// The weights at the image of a point of the triangle are those that mix the point from the corners.
        #[test]
        fn weights_follow_perspective(corners in [point(), point(), point()], eye in point(), mix in [0.01..1.0f64, 0.01..1.0f64, 0.01..1.0f64], wide in 0.0..100.0f64) {
            let total: f64 = mix.iter().sum();
            let mix = mix.map(|m| m / total);
            let faces = Polygons::from_triangles(&[[0, 1, 2]]);
            let view = View::From { eye, up: DVec3::Z };
            let picture = Picture { view, field_of_view: if wide < 20.0 { 0.0 } else { wide }, ..Picture::new(&corners, &faces) };
            let camera = Camera::new(&picture, [1200, 900]);
            let scene = Scene::new(&picture, &camera);
            let surface = Surface::new(&scene, 0);
            prop_assume!(surface.weights.as_flattened().iter().all(|w| w.abs() < 1.0));
            let seen = camera.see(corners[0] * mix[0] + corners[1] * mix[1] + corners[2] * mix[2]);
            for (weight, expected) in surface.corner_weights(seen.x, seen.y).into_iter().zip(mix) {
                prop_assert!((f64::from(weight) - expected).abs() < 1e-4, "{weight} {expected}");
            }
        }
    }
}
