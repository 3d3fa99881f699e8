//! Spheres: a subdivided icosahedron, and circles of latitude.

use super::builder::{Builder, circle};
use super::limits::{affordable, at_least, positive};
use super::model::Model;
use super::shape::{Measure, Shape};
use crate::error::Result;
use glam::DVec3;
use rustc_hash::FxHashMap;
use std::f64::consts::PI;

/// A sphere around the origin: every triangle of an icosahedron cut into `frequency²` triangles, then projected.
///
/// Twelve vertices have five neighbours, all others six. Label 0: the sphere.
///
/// # Errors
/// [`Error::Options`](crate::Error::Options) for sizes that make no such model, or one of too many triangles.
pub fn icosphere(radius: f64, frequency: u32) -> Result<Model> {
    positive("radius", radius)?;
    at_least("frequency", frequency, 1)?;
    affordable(20.0 * f64::from(frequency).powi(2))?;
    let mut net = Geodesic { radius, frequency, builder: Builder::default(), ids: FxHashMap::default() };
    let label = net.builder.shape("sphere", Shape::Sphere { center: DVec3::ZERO, radius });
    for triangle in ICOSAHEDRON {
        net.subdivide(label, triangle);
    }
    net.builder.finish(measure(radius))
}

/// A sphere around the origin from circles of latitude, with a pole at either end of the z axis.
///
/// `meridians` ≥ 3 is the number of points on a circle, `parallels` ≥ 2 the number of bands from pole to pole.
/// Label 0: the sphere.
///
/// # Errors
/// [`Error::Options`](crate::Error::Options) for sizes that make no such model, or one of too many triangles.
pub fn uv_sphere(radius: f64, meridians: u32, parallels: u32) -> Result<Model> {
    positive("radius", radius)?;
    at_least("meridians", meridians, 3)?;
    at_least("parallels", parallels, 2)?;
    affordable(2.0 * f64::from(meridians) * f64::from(parallels))?;
    let mut b = Builder::default();
    let label = b.shape("sphere", Shape::Sphere { center: DVec3::ZERO, radius });
    let south = b.point(DVec3::NEG_Z * radius);
    let rings: Vec<Vec<u32>> = (1..parallels)
        .map(|k| {
            let (sin, cos) = (PI * f64::from(k) / f64::from(parallels)).sin_cos();
            b.points(circle(
                DVec3::NEG_Z * (radius * cos),
                DVec3::X * (radius * sin),
                DVec3::Y * (radius * sin),
                meridians,
            ))
        })
        .collect();
    let north = b.point(DVec3::Z * radius);
    b.rings(label, &rings);
    for k in 0..meridians as usize {
        let next = (k + 1) % meridians as usize;
        if let (Some(first), Some(last)) = (rings.first(), rings.last()) {
            b.triangle(label, [south, first[next], first[k]]);
            b.triangle(label, [north, last[k], last[next]]);
        }
    }
    b.finish(measure(radius))
}

fn measure(radius: f64) -> Option<Measure> {
    Measure::closed(4.0 * PI * radius.powi(2), 4.0 / 3.0 * PI * radius.powi(3))
}

/// Half the longer side of the three golden rectangles whose corners are the icosahedron's; the shorter half is 1.
const GOLDEN: f64 = 1.618_033_988_749_895;

/// Corners of an icosahedron.
const CORNERS: [[f64; 3]; 12] = [
    [-1.0, GOLDEN, 0.0],
    [1.0, GOLDEN, 0.0],
    [-1.0, -GOLDEN, 0.0],
    [1.0, -GOLDEN, 0.0],
    [0.0, -1.0, GOLDEN],
    [0.0, 1.0, GOLDEN],
    [0.0, -1.0, -GOLDEN],
    [0.0, 1.0, -GOLDEN],
    [GOLDEN, 0.0, -1.0],
    [GOLDEN, 0.0, 1.0],
    [-GOLDEN, 0.0, -1.0],
    [-GOLDEN, 0.0, 1.0],
];

/// Faces of an icosahedron, counter-clockwise from outside.
const ICOSAHEDRON: [[u32; 3]; 20] = [
    [0, 11, 5],
    [0, 5, 1],
    [0, 1, 7],
    [0, 7, 10],
    [0, 10, 11],
    [1, 5, 9],
    [5, 11, 4],
    [11, 10, 2],
    [10, 7, 6],
    [7, 1, 8],
    [3, 9, 4],
    [3, 4, 2],
    [3, 2, 6],
    [3, 6, 8],
    [3, 8, 9],
    [4, 9, 5],
    [2, 4, 11],
    [6, 2, 10],
    [8, 6, 7],
    [9, 8, 1],
];

/// A subdivided icosahedron under construction.
struct Geodesic {
    radius: f64,
    frequency: u32,
    builder: Builder,
    /// Vertices by their weights at the icosahedron's corners, sorted by corner and without the zeros: the key is the
    /// same from both sides of an edge, and so is the point, which is computed from the key.
    ids: FxHashMap<[(u32, u32); 3], u32>,
}

impl Geodesic {
    /// Cuts one triangle into `frequency` rows.
    ///
    /// ```text
    ///           2
    ///          ╱ ╲        node (i, j): i steps from corner 0
    ///      (0,1)─(1,1)    towards 1, j steps towards 2
    ///      ╱ ╲   ╱ ╲
    ///     0 ─(1,0)─ 1
    /// ```
    fn subdivide(&mut self, label: i32, corners: [u32; 3]) {
        let n = self.frequency;
        for j in 0..n {
            for i in 0..n - j {
                let [a, b, c] = [(i, j), (i + 1, j), (i, j + 1)].map(|(i, j)| self.node(corners, i, j));
                self.builder.triangle(label, [a, b, c]);
                if i + j + 1 < n {
                    let d = self.node(corners, i + 1, j + 1);
                    self.builder.triangle(label, [b, d, c]);
                }
            }
        }
    }

    /// The vertex at a node, made on first use.
    fn node(&mut self, corners: [u32; 3], i: u32, j: u32) -> u32 {
        let weights = [self.frequency - i - j, i, j];
        let mut key = [0, 1, 2].map(|k| if weights[k] == 0 { (u32::MAX, 0) } else { (corners[k], weights[k]) });
        key.sort_unstable();
        if let Some(&v) = self.ids.get(&key) {
            return v;
        }
        let weighted = key.iter().filter(|k| k.1 > 0).map(|k| DVec3::from(CORNERS[k.0 as usize]) * f64::from(k.1));
        let v = self.builder.point(weighted.sum::<DVec3>().normalize() * self.radius);
        self.ids.insert(key, v);
        v
    }
}
