//! A box with rounded edges and corners.

use super::builder::Builder;
use super::limits::{affordable_edge, divisions, positive, within};
use super::model::Model;
use super::shape::{Measure, Shape};
use crate::error::Result;
use glam::DVec3;
use rustc_hash::FxHashMap;
use std::f64::consts::{FRAC_PI_4, PI};

/// A box of this size around the origin, its edges rounded with a radius of less than half the shortest side.
///
/// The surface is the image of a box of grid cells: on every face of it, the middle cells are the planar face, the cells
/// along the rim half of an edge's cylinder or a third of a corner's sphere:
///
/// ```text
///  s │ c  c │ s       p plane, c cylinder, s sphere
///  ──┼──────┼──
///  c │ p  p │ c       the rim is at least one cell wide
///  ──┼──────┼──
///  s │ c  c │ s
/// ```
///
/// Labels: 6 planes, 12 cylinders, 8 spheres, in the order of the signs (x, y, z) of their outward direction.
///
/// # Errors
/// [`Error::Options`](crate::Error::Options) for sizes that make no such model, or one of too many triangles.
pub fn rounded_box(size: [f64; 3], radius: f64, edge: f64) -> Result<Model> {
    size.iter().try_for_each(|&s| positive("size", s))?;
    positive("radius", radius)?;
    let shortest = size.iter().copied().fold(f64::INFINITY, f64::min);
    within("radius", radius, 0.0, 0.499 * shortest)?;
    let measure = measure(DVec3::from(size) - 2.0 * radius, radius);
    affordable_edge(edge, measure.map_or(0.0, |m| m.area))?;
    let mut cells = BoxGrid::new(size, radius, edge);
    for axis in 0..3 {
        cells.side(axis, false);
        cells.side(axis, true);
    }
    cells.builder.finish(measure)
}

/// Measures of the box whose core has the sides `c`.
fn measure(c: DVec3, r: f64) -> Option<Measure> {
    let (faces, sides) = (c.x * c.y + c.y * c.z + c.z * c.x, c.element_sum());
    let area = 2.0 * faces + 2.0 * PI * r * sides + 4.0 * PI * r * r;
    let volume = c.element_product() + 2.0 * r * faces + PI * r * r * sides + 4.0 / 3.0 * PI * r.powi(3);
    Measure::closed(area, volume)
}

/// The grid of the box under construction.
struct BoxGrid {
    core: DVec3,
    radius: f64,
    /// Number of cells along each axis, both rims included.
    cells: [u32; 3],
    /// Number of cells across a rim: an eighth of a circle.
    rim: u32,
    builder: Builder,
    ids: FxHashMap<[u32; 3], u32>,
    /// Labels by sign triple in base three.
    labels: [i32; 27],
}

impl BoxGrid {
    fn new(size: [f64; 3], radius: f64, edge: f64) -> Self {
        let core = DVec3::from(size) / 2.0 - radius;
        let rim = divisions(radius * FRAC_PI_4, edge, 1);
        let cells = core.to_array().map(|half| divisions(2.0 * half, edge, 1) + 2 * rim);
        let mut builder = Builder::default();
        let mut labels = [0; 27];
        for nonzero in 1..=3 {
            for (code, label) in labels.iter_mut().enumerate() {
                let signs = [code / 9, code / 3 % 3, code % 3].map(|d| f64::from(d as u8) - 1.0);
                if signs.iter().filter(|&&s| s != 0.0).count() == nonzero {
                    let (name, shape) = shape(DVec3::from(signs), core, radius);
                    *label = builder.shape(format!("{name} {}", sign_name(signs)), shape);
                }
            }
        }
        BoxGrid { core, radius, cells, rim, builder, ids: FxHashMap::default(), labels }
    }

    /// Adds the cells of one side of the box.
    fn side(&mut self, axis: usize, high: bool) {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let level = if high { self.cells[axis] } else { 0 };
        for j in 0..self.cells[v] {
            for i in 0..self.cells[u] {
                let mut node = |i: u32, j: u32| {
                    let mut at = [level; 3];
                    (at[u], at[v]) = (i, j);
                    self.vertex(at)
                };
                let [a, b, c, d] = [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)];
                let mut code = [0; 3];
                code[axis] = if high { 2 } else { 0 };
                (code[u], code[v]) = (self.zone(u, i), self.zone(v, j));
                let label = self.labels[9 * code[0] + 3 * code[1] + code[2]];
                self.builder.quad(label, if high { [a, b, c, d] } else { [a, d, c, b] });
            }
        }
    }

    /// 0, 1 or 2: whether a cell lies on the lower rim, in the middle, or on the upper rim of an axis.
    fn zone(&self, axis: usize, cell: u32) -> usize {
        usize::from(cell >= self.rim) + usize::from(cell >= self.cells[axis] - self.rim)
    }

    /// The vertex at a node of the box's surface, made on first use.
    fn vertex(&mut self, at: [u32; 3]) -> u32 {
        if let Some(&v) = self.ids.get(&at) {
            return v;
        }
        let axes = [0, 1, 2].map(|axis| self.coordinate(axis, at[axis]));
        let centre = DVec3::from(axes.map(|a| a.0));
        let direction = DVec3::from(axes.map(|a| a.1)).normalize();
        let v = self.builder.point(centre + direction * self.radius);
        self.ids.insert(at, v);
        v
    }

    /// Along one axis: the coordinate of the core's nearest point, and the outward direction, which has ±1 at the ends
    /// of the axis and equal angles in between.
    fn coordinate(&self, axis: usize, i: u32) -> (f64, f64) {
        let half = self.core[axis];
        let middle = self.cells[axis] - 2 * self.rim;
        let lean = |steps: u32| (FRAC_PI_4 * f64::from(steps) / f64::from(self.rim)).tan();
        if i < self.rim {
            (-half, -lean(self.rim - i))
        } else if i > self.rim + middle {
            (half, lean(i - self.rim - middle))
        } else {
            (half * (2.0 * f64::from(i - self.rim) / f64::from(middle) - 1.0), 0.0)
        }
    }
}

/// The surface that faces in the direction of these signs.
fn shape(signs: DVec3, core: DVec3, radius: f64) -> (&'static str, Shape) {
    let center = core * signs;
    match signs.to_array().iter().filter(|&&s| s != 0.0).count() {
        1 => ("plane", Shape::Plane { origin: center + signs * radius, normal: signs }),
        2 => ("cylinder", Shape::Cylinder { origin: center, axis: DVec3::ONE - signs.abs(), radius }),
        _ => ("sphere", Shape::Sphere { center, radius }),
    }
}

/// `+x`, `-x+y`, …
fn sign_name(signs: [f64; 3]) -> String {
    let part = |(s, axis): (f64, char)| match s {
        1.0 => format!("+{axis}"),
        -1.0 => format!("-{axis}"),
        _ => String::new(),
    };
    signs.into_iter().zip(['x', 'y', 'z']).map(part).collect()
}
