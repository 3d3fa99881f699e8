//! Small models made of grids, for the tests of the export: points at equal positions are one vertex.

use crate::mesh::{FaceId, SurfaceMesh, VertexId};
use crate::patch::Patch;
use glam::DVec3;
use rustc_hash::FxHashMap;
use std::f64::consts::TAU;

/// Grids and single triangles under construction.
#[derive(Default, Clone)]
pub struct Model {
    pub points: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
    pub patches: Vec<Patch>,
    pub leftover: Vec<FaceId>,
    ids: FxHashMap<[u64; 3], u32>,
}

impl Model {
    pub fn vertex(&mut self, p: DVec3) -> u32 {
        let p = p + DVec3::ZERO; // no negative zeros
        *self.ids.entry(p.to_array().map(f64::to_bits)).or_insert_with(|| {
            self.points.push(p);
            self.points.len() as u32 - 1
        })
    }

    /// A patch with its node (r, c) at `at(r, c)`.
    pub fn grid(&mut self, rows: u32, cols: u32, at: impl Fn(u32, u32) -> DVec3) {
        let nodes = (0..=rows).flat_map(|r| (0..=cols).map(move |c| (r, c)));
        let vertices: Vec<VertexId> = nodes.map(|(r, c)| VertexId(self.vertex(at(r, c)))).collect();
        let mut patch = Patch { rows, cols, vertices, triangles: Vec::new() };
        let cells: Vec<[VertexId; 4]> = patch.cell_corners().collect();
        for [a, b, c, d] in cells {
            patch.triangles.push(self.push([a.0, b.0, c.0]));
            patch.triangles.push(self.push([a.0, c.0, d.0]));
        }
        self.patches.push(patch);
    }

    fn push(&mut self, triangle: [u32; 3]) -> FaceId {
        self.triangles.push(triangle);
        FaceId::new(self.triangles.len() - 1)
    }

    /// A leftover triangle.
    pub fn triangle(&mut self, corners: [DVec3; 3]) {
        let corners = corners.map(|p| self.vertex(p));
        let t = self.push(corners);
        self.leftover.push(t);
    }

    /// A cube of six n × n grids; `inwards` turns the faces.
    pub fn cube(&mut self, n: u32, origin: DVec3, size: f64, inwards: bool) {
        for axis in 0..3 {
            for high in [false, true] {
                // Outwards when rows and columns follow the axis in cyclic order on the high side.
                let turn = high == inwards;
                self.grid(n, n, |r, c| {
                    let (a, b) = if turn { (r, c) } else { (c, r) };
                    let mut p = [0.0; 3];
                    p[axis] = if high { 1.0 } else { 0.0 };
                    p[(axis + 1) % 3] = f64::from(a) / f64::from(n);
                    p[(axis + 2) % 3] = f64::from(b) / f64::from(n);
                    origin + size * DVec3::from_array(p)
                });
            }
        }
    }

    /// One patch that closes on itself both ways.
    pub fn torus(&mut self, around: u32, across: u32, radii: [f64; 2]) {
        self.grid(across, around, |r, c| {
            let angle = |k: u32, n: u32| TAU * f64::from(k % n) / f64::from(n);
            let (a, b) = (angle(c, around), angle(r, across));
            let ring = radii[0] + radii[1] * b.cos();
            DVec3::new(ring * a.cos(), ring * a.sin(), radii[1] * b.sin())
        });
    }

    /// A closed strip of quads and two caps: strips across (`around` must be even), or fans of triangles.
    pub fn cylinder(&mut self, around: u32, rows: u32, fans: bool) {
        let at = |k: u32, r: u32| {
            let a = TAU * f64::from(k % around) / f64::from(around);
            DVec3::new(a.cos(), a.sin(), 3.0 * f64::from(r) / f64::from(rows))
        };
        self.grid(rows, around, |r, c| at(c, r));
        for top in [false, true] {
            let (r, z) = if top { (rows, 3.0) } else { (0, 0.0) };
            if fans {
                for k in 0..around {
                    let (a, b) = if top { (at(k, r), at(k + 1, r)) } else { (at(k + 1, r), at(k, r)) };
                    self.triangle([a, b, DVec3::new(0.0, 0.0, z)]);
                }
            } else {
                // Row 0 is one half of the circle, row 1 the other, opposite.
                self.grid(1, around / 2 - 1, |row, c| at(if (row == 0) == top { c } else { around - 1 - c }, r));
            }
        }
    }

    pub fn mesh(&self) -> SurfaceMesh {
        SurfaceMesh::from_triangles(self.points.clone(), &self.triangles).unwrap()
    }

    /// Every leftover triangle moves; patches keep their ids.
    pub fn moved(mut self, f: impl Fn(DVec3) -> DVec3) -> Self {
        self.points.iter_mut().for_each(|p| *p = f(*p));
        self
    }
}

/// A tetrahedron with a vertex in the middle of an edge, or `height` beside it, which one of the two faces there does not
/// have: a triangle without area, or a sliver, closes the gap.
pub fn flat_triangle(height: f64) -> Model {
    let mut m = Model::default();
    let [a, b, c, d] = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    let middle = DVec3::new(0.5, -height, 0.0);
    for t in [[a, c, b], [a, b, middle], [a, middle, d], [middle, b, d], [b, c, d], [a, d, c]] {
        m.triangle(t);
    }
    m
}

/// A tetrahedron with a very short edge; where its length is zero, the two triangles there have no area.
pub fn short_edge(length: f64) -> Model {
    let mut m = Model::default();
    let [a, b, c, d] = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    let twin = DVec3::NAN;
    for t in [[a, c, b], [a, b, twin], [twin, b, d], [b, c, d], [twin, d, c], [a, twin, c]] {
        m.triangle(t);
    }
    m.moved(|p| if p.is_nan() { DVec3::new(0.0, 0.0, length) } else { p })
}

/// A model by name: the ones that the tests go through.
pub fn all() -> Vec<(&'static str, Model)> {
    let build = |f: &dyn Fn(&mut Model)| {
        let mut m = Model::default();
        f(&mut m);
        m
    };
    vec![
        ("cube", build(&|m| m.cube(4, DVec3::ZERO, 1.0, false))),
        ("torus", build(&|m| m.torus(16, 8, [2.0, 0.5]))),
        ("cylinder", build(&|m| m.cylinder(16, 5, false))),
        ("fanned", build(&|m| m.cylinder(16, 5, true))),
        (
            "hollow",
            build(&|m| {
                m.cube(3, DVec3::ZERO, 1.0, false);
                m.cube(2, DVec3::splat(0.25), 0.5, true);
                m.cube(2, DVec3::splat(0.375), 0.25, false);
            }),
        ),
        (
            "two",
            build(&|m| {
                m.cube(3, DVec3::ZERO, 1.0, false);
                m.cube(2, DVec3::splat(2.0), 1.0, false);
            }),
        ),
        ("open", build(&|m| m.grid(3, 4, |r, c| DVec3::new(c.into(), r.into(), f64::from(r * c) * 0.1)))),
        ("inside_out", build(&|m| m.cube(2, DVec3::ZERO, 1.0, true))),
        (
            "touching",
            build(&|m| {
                m.cube(2, DVec3::ZERO, 1.0, false);
                m.cube(2, DVec3::new(1.0, 1.0, 1.0), 1.0, false);
            }),
        ),
        (
            "edge",
            build(&|m| {
                m.cube(2, DVec3::ZERO, 1.0, false);
                m.cube(2, DVec3::new(1.0, 1.0, 0.0), 1.0, false);
            }),
        ),
        (
            "moebius",
            build(&|m| {
                m.grid(2, 12, |r, c| {
                    let a = TAU * f64::from(c % 12) / 12.0;
                    let s = 0.2 * (f64::from(r) - 1.0) * if c < 12 { 1.0 } else { -1.0 };
                    let ring = 1.0 + s * (a / 2.0).cos();
                    DVec3::new(ring * a.cos(), ring * a.sin(), s * (a / 2.0).sin())
                });
            }),
        ),
    ]
}
