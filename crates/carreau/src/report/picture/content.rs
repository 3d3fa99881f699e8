//! What a picture shows: faces, their colours, and lines.

use super::color::Rgb;
use super::palette::{self, Scale};
use super::view::View;
use crate::mesh::Polygons;
use glam::DVec3;

/// What is drawn, and how. [`Picture::new`] gives the defaults.
///
/// Nothing here can fail: faces and lines that use vertices which do not exist or are not finite are left out, faces
/// without a colour are grey.
#[derive(Debug, Clone)]
pub struct Picture<'a> {
    /// Vertex positions.
    pub points: &'a [DVec3],
    /// Faces; polygons are fanned from their first corner.
    pub faces: &'a Polygons,
    /// Colours of the faces.
    pub colors: Colors<'a>,
    /// Lines, later ones over earlier ones.
    pub lines: Vec<Lines<'a>>,
    /// Width and height in pixels, clamped to 1..=16384 each.
    pub size: [u32; 2],
    /// From where to look.
    pub view: View,
    /// Opening angle of the camera over the shorter side of the image, in degrees, clamped to 0.1..=120; 0 for a parallel
    /// projection.
    pub field_of_view: f64,
    /// Edges with a larger angle (degrees) between the normals of their faces look sharp, others rounded; 0 shows all
    /// faces flat.
    pub crease: f64,
    /// Colour where nothing is drawn.
    pub background: Rgb,
    /// Points that the image has room for besides what is drawn, so that two pictures with the same view lie upon each other.
    pub framed: &'a [DVec3],
}

impl<'a> Picture<'a> {
    /// A picture of faces of one colour without lines: 1200 × 900 pixels, white background.
    pub fn new(points: &'a [DVec3], faces: &'a Polygons) -> Self {
        Picture {
            points,
            faces,
            colors: Colors::Uniform(palette::PLAIN),
            lines: Vec::new(),
            size: [1200, 900],
            view: View::Automatic,
            field_of_view: 25.0,
            crease: 35.0,
            background: [255; 3],
            framed: &[],
        }
    }
}

/// Colours of faces.
#[derive(Debug, Clone, Copy)]
pub enum Colors<'a> {
    /// The same for all.
    Uniform(Rgb),
    /// One label per face. Labels that meet at an edge get clearly different colours; negative ones are grey.
    Labels(&'a [i32]),
    /// One number per face; NaN is grey.
    FaceScalars(&'a [f64], Scale),
    /// One number per vertex, interpolated; NaN is grey.
    VertexScalars(&'a [f64], Scale),
    /// One colour per face.
    Faces(&'a [Rgb]),
}

/// A layer of lines.
#[derive(Debug, Clone)]
pub struct Lines<'a> {
    /// Where they run.
    pub path: Path<'a>,
    /// Their colour.
    pub color: Rgb,
    /// Their width in pixels.
    pub width: f64,
    /// From 0, invisible, to 1, opaque.
    pub opacity: f64,
    /// Whether faces hide the lines behind them.
    pub hidden: bool,
}

impl<'a> Lines<'a> {
    /// Opaque lines that faces can hide.
    pub fn new(path: Path<'a>, color: Rgb, width: f64) -> Self {
        Lines { path, color, width, opacity: 1.0, hidden: true }
    }

    /// Faint lines for the edges of a mesh.
    pub fn fine(path: Path<'a>) -> Self {
        Lines { opacity: 0.5, ..Lines::new(path, [30, 40, 60], 0.7) }
    }

    /// Bold lines for features and borders.
    pub fn bold(path: Path<'a>) -> Self {
        Lines::new(path, [20, 24, 36], 2.2)
    }
}

/// Where the lines of a layer run.
#[derive(Debug, Clone, Copy)]
pub enum Path<'a> {
    /// Pairs of vertices of the picture.
    Edges(&'a [[u32; 2]]),
    /// Pairs of points; two equal points make a dot.
    Segments(&'a [[DVec3; 2]]),
}
