//! Procedural models for the demo, the documentation and the tests.
//!
//! Every model is manifold and oriented outwards, with one vertex per position and no degenerate triangle; closed models are
//! watertight. A model carries its ground truth: the face column `truth` numbers its CAD faces, `shapes[k]` is the exact
//! surface on which the vertices of label `k` lie, and `exact` holds area and volume of the smooth model.
//!
//! [`SAMPLES`] lists the models by name, with a resolution as their only parameter; the functions of the same names have
//! all parameters.
//!
//! | file | holds |
//! |---|---|
//! | `sphere`, `torus`, `cylinder`, `rounded_box`, `saddle` | structured meshes of the elementary surfaces |
//! | `cube_cylinders` | the test model of Bénière et al. |
//! | `bracket`, `wedge` | parts swept from a profile by `extrude` |
//! | `tube_tree` | a blended union of tubes, polygonised by `surface_nets` |
//! | `builder` | the points, triangles and labels under construction |
//! | `shape` | the ground truth of a model |
//! | `limits`, `random` | the resolutions that are possible; pseudo-random numbers |

mod bracket;
mod builder;
mod cube_cylinders;
mod cylinder;
mod extrude;
mod limits;
mod model;
pub(crate) mod random;
mod rounded_box;
mod saddle;
mod shape;
mod sphere;
mod surface_nets;
#[cfg(test)]
mod tests;
mod torus;
mod tube_tree;
mod wedge;

use crate::context::Context;
use crate::error::{Error, Result};
use crate::mesh::SurfaceMesh;
use limits::divisions;
use std::f64::consts::TAU;

pub use bracket::{Bracket, bracket};
pub use cube_cylinders::{CubeCylinders, cube_cylinders};
pub use cylinder::{cylinder, open_cylinder};
pub use model::Model;
pub use rounded_box::rounded_box;
pub use saddle::saddle;
pub use shape::{Measure, Shape};
pub use sphere::{icosphere, uv_sphere};
pub use torus::{noisy_torus, open_torus, torus};
pub use tube_tree::{Tube, tree, tubes};
pub use wedge::wedge;

/// A model that can be made by name.
#[derive(Debug, Clone, Copy)]
pub struct Sample {
    /// The name.
    pub name: &'static str,
    /// One line on what it is.
    pub summary: &'static str,
    /// Whether it is watertight; else it has a border.
    pub closed: bool,
    /// The resolution used when none is given.
    pub resolution: u32,
    /// Length of the bounding-box diagonal.
    pub diagonal: f64,
    make: fn(f64, &Context) -> Result<Model>,
}

/// The resolutions that [`Sample::make`] accepts. The least makes the coarsest mesh of a model that is still sound; some
/// models refuse resolutions below their own least.
pub const RESOLUTIONS: std::ops::RangeInclusive<u32> = 4..=1500;

impl Sample {
    /// Makes the model with edges of about 1/`resolution` of the bounding-box diagonal; the number of triangles grows
    /// with its square. Noise depends on the context's seed.
    ///
    /// # Errors
    /// [`Error::Options`] for a resolution outside [`RESOLUTIONS`] or too low for the model's thinnest part.
    pub fn make(&self, resolution: Option<u32>, context: &Context) -> Result<Model> {
        let resolution = resolution.unwrap_or(self.resolution);
        if !RESOLUTIONS.contains(&resolution) {
            let (low, high) = RESOLUTIONS.into_inner();
            return Err(Error::Options(format!(
                "the resolution is {resolution}; it must lie between {low} and {high}"
            )));
        }
        (self.make)(self.diagonal / f64::from(resolution), context)
    }
}

/// All models, in alphabetical order.
pub const SAMPLES: &[Sample] = &[
    Sample {
        name: "bracket",
        summary: "an L-bracket of bent plate with three holes: eight planes, five cylinders",
        closed: true,
        resolution: 60,
        diagonal: 91.935,
        make: |edge, context| bracket(&Bracket::default(), edge, context),
    },
    Sample {
        name: "cube-cylinders",
        summary: "a cube with a cylinder on two opposite faces, after Bénière et al. 2011",
        closed: true,
        resolution: 29,
        diagonal: 4.5,
        make: |edge, _| scaled_cube_cylinders(edge),
    },
    Sample {
        name: "cylinder",
        summary: "a closed cylinder",
        closed: true,
        resolution: 60,
        diagonal: 4.123,
        make: |edge, _| cylinder(1.0, 3.0, edge),
    },
    Sample {
        name: "icosphere",
        summary: "a sphere from an icosahedron: almost all vertices have six neighbours",
        closed: true,
        resolution: 50,
        diagonal: 3.464,
        make: |edge, _| icosphere(1.0, divisions(ICOSAHEDRON_SIDE, edge, 1)),
    },
    Sample {
        name: "noisy-torus",
        summary: "a torus whose vertices are moved along the normals by up to a fifth of an edge",
        closed: true,
        resolution: 60,
        diagonal: 4.04,
        make: |edge, context| {
            let (rings, sides) = torus_divisions(1.0, edge);
            noisy_torus(1.0, TUBE, rings, sides, 0.2 * edge.min(TUBE), context.seed)
        },
    },
    Sample {
        name: "open-cylinder",
        summary: "the wall of a cylinder: two borders",
        closed: false,
        resolution: 60,
        diagonal: 4.123,
        make: |edge, _| open_cylinder(1.0, 3.0, divisions(TAU, edge, 6), divisions(3.0, edge, 1)),
    },
    Sample {
        name: "open-torus",
        summary: "three quarters of a torus: two borders",
        closed: false,
        resolution: 60,
        diagonal: 4.04,
        make: |edge, _| {
            let (rings, sides) = torus_divisions(0.75, edge);
            open_torus(1.0, TUBE, 270.0, rings, sides)
        },
    },
    Sample {
        name: "rounded-box",
        summary: "a box with rounded edges and corners: six planes, twelve cylinders, eight spheres",
        closed: true,
        resolution: 60,
        diagonal: 3.868,
        make: |edge, _| rounded_box([3.0, 2.0, 1.4], 0.3, edge),
    },
    Sample {
        name: "saddle",
        summary: "a hyperbolic paraboloid over a square: one border",
        closed: false,
        resolution: 60,
        diagonal: 3.072,
        make: |edge, _| saddle(2.0, 1.2, divisions(2.0, edge, 1)),
    },
    Sample {
        name: "torus",
        summary: "a torus",
        closed: true,
        resolution: 60,
        diagonal: 4.04,
        make: |edge, _| {
            let (rings, sides) = torus_divisions(1.0, edge);
            torus(1.0, TUBE, rings, sides)
        },
    },
    Sample {
        name: "tube-tree",
        summary: "a forked tree of tapered tubes, smoothly blended; no holes",
        closed: true,
        resolution: 100,
        diagonal: 4.74,
        make: |edge, context| tubes(&tree(), 0.18, edge, context),
    },
    Sample {
        name: "uv-sphere",
        summary: "a sphere from circles of latitude, with two poles",
        closed: true,
        resolution: 50,
        diagonal: 3.464,
        make: |edge, _| uv_sphere(1.0, divisions(TAU, edge, 6), divisions(TAU / 2.0, edge, 3)),
    },
    Sample {
        name: "wedge",
        summary: "a prism with an acute edge of 20 degrees: five planes",
        closed: true,
        resolution: 50,
        diagonal: 2.892,
        make: |edge, context| wedge(20.0, 2.0, 2.0, edge, context),
    },
];

/// Radius of the tube of the named tori.
const TUBE: f64 = 0.4;
/// Side of an icosahedron in the unit sphere, as an arc.
const ICOSAHEDRON_SIDE: f64 = 1.107;

/// Rings and sides of a torus of which this share is swept.
fn torus_divisions(share: f64, edge: f64) -> (u32, u32) {
    (divisions(share * TAU, edge, 6), divisions(TAU * TUBE, edge, 5))
}

/// The paper's counts at an edge of 2/13, others in proportion.
fn scaled_cube_cylinders(edge: f64) -> Result<Model> {
    let paper = CubeCylinders::default();
    let scale = 2.0 / f64::from(paper.quads) / edge;
    let scaled = |count: u32, least: u32| divisions(f64::from(count) * scale, 1.0, least);
    cube_cylinders(&CubeCylinders {
        quads: scaled(paper.quads, 2),
        segments: scaled(paper.segments, 6),
        rings: paper.rings.map(|r| scaled(r, 1)),
        ..paper
    })
}

/// Makes a model by name; see [`Sample::make`]. The face column `truth` holds the CAD faces.
///
/// # Errors
/// [`Error::Options`] for an unknown name (the message lists the known ones) or a resolution out of range.
pub fn make(name: &str, resolution: Option<u32>, context: &Context) -> Result<SurfaceMesh> {
    Ok(find(name)?.make(resolution, context)?.mesh)
}

/// The model of this name.
///
/// # Errors
/// [`Error::Options`] for an unknown name; the message lists the known ones.
pub fn find(name: &str) -> Result<&'static Sample> {
    SAMPLES.iter().find(|s| s.name == name).ok_or_else(|| {
        let known: Vec<&str> = SAMPLES.iter().map(|s| s.name).collect();
        Error::Options(format!("there is no sample '{name}'; known are {}", known.join(", ")))
    })
}
