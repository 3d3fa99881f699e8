//! What a scene shows besides its shape: columns, lines, nets, marked vertices.

use crate::mesh::{Column, CurveNet};
use glam::DVec3;
use serde::Serialize;

/// The elements that a column has values for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum On {
    /// Vertices.
    Vertex,
    /// Faces.
    Face,
    /// Volume cells.
    Cell,
}

/// How numbers become colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Range {
    /// From the smallest to the largest.
    Sequential,
    /// From −b to b: blue below zero, red-brown above.
    Diverging,
    /// From 0, bad, to 1, perfect; below 0 is invalid.
    Quality,
}

/// A column of values on vertices, faces or cells.
#[derive(Debug, Clone)]
pub struct Layer {
    /// Its name, as in files.
    pub name: String,
    /// What it is on.
    pub on: On,
    /// The values, one per element.
    pub column: Column,
    /// How numbers become colours.
    pub range: Range,
    /// Words for labels.
    pub words: Vec<(i32, String)>,
}

impl Layer {
    /// A column; the range of its colours follows from its values.
    pub fn new(name: impl Into<String>, on: On, column: Column) -> Self {
        let has = |test: fn(&f64) -> bool| matches!(&column, Column::Scalar(v) if v.iter().any(test));
        let signed = has(|v| *v < 0.0) && has(|v| *v > 0.0);
        let range = if signed { Range::Diverging } else { Range::Sequential };
        Layer { name: name.into(), on, column, range, words: Vec::new() }
    }
}

/// What lines are, which decides their colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Style {
    /// Features, tagged edges.
    Feature,
    /// Directions of a field.
    Field,
    /// Tracks of a motorcycle graph.
    Track,
    /// Edges of hexahedral meshes with an unusual number of cells.
    Singular,
}

/// Lines of one kind.
#[derive(Debug, Clone)]
pub struct Lines {
    /// What they are, for the list of layers.
    pub name: String,
    /// How they look.
    pub style: Style,
    /// Where they run.
    pub path: Path,
}

/// Where lines run.
#[derive(Debug, Clone)]
pub enum Path {
    /// Between vertices of the scene.
    Edges(Vec<[u32; 2]>),
    /// Between points.
    Segments(Vec<[DVec3; 2]>),
}

/// A skeleton in a scene.
#[derive(Debug, Clone)]
pub struct Net {
    /// What it is, for the list of layers.
    pub name: String,
    /// The net.
    pub net: CurveNet,
}

/// Vertices with an unusual number of quads.
#[derive(Debug, Clone)]
pub struct Markers {
    /// What they are, for the list of layers.
    pub name: String,
    /// The vertices.
    pub vertices: Vec<u32>,
    /// The number at each.
    pub values: Vec<i32>,
    /// The usual number at each: below and above it the marks differ.
    pub usual: Vec<i32>,
}
