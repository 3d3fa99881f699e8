//! One of the models of a page, with everything that can be shown on it.

use super::irregular::{irregular_edges, irregular_vertices};
use super::layer::{Layer, Lines, Markers, Net, On, Path, Range, Style};
use crate::context::Context;
use crate::error::{Error, Result};
use crate::field::Field;
use crate::geometry::curvature::{CurvatureOptions, curvature};
use crate::geometry::features::{FeatureOptions, feature_edges};
use crate::geometry::hexes;
use crate::geometry::quality::{mean_ratio, scaled_jacobian};
use crate::mesh::{Cells, Column, Columns, CurveNet, HexMesh, Polygons, RawMesh, SurfaceMesh, Triangles};
use crate::quad::MotorcycleGraph;
use crate::quad::graph::{CUT, TRACK};
use crate::report::field::{arms, usual};
use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

/// What a scene is in its page: those before and after stand side by side.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Role {
    /// What a run was given.
    Before,
    /// What it made.
    After,
    /// Neither.
    #[default]
    Other,
}

/// Columns of signed numbers, also where all have one sign.
const SIGNED: &[&str] = &["kmin", "kmax"];
/// The lines of motorcycle graphs.
const GRAPH: &str = "motorcycle graph";
/// Crosses of a field along the diagonal.
const PAGE_CROSSES: f64 = 48.0;
/// Edges sharper than this are features where curvature is measured, in degrees.
const CURVATURE_CREASE: f64 = 25.0;

/// A model and its layers.
#[derive(Debug, Clone)]
pub struct Scene {
    pub(super) name: String,
    pub(super) role: Role,
    pub(super) points: Vec<DVec3>,
    pub(super) faces: Polygons,
    pub(super) cells: Polygons,
    pub(super) layers: Vec<Layer>,
    pub(super) lines: Vec<Lines>,
    pub(super) nets: Vec<Net>,
    pub(super) markers: Vec<Markers>,
    pub(super) show: Option<String>,
}

impl Scene {
    fn empty(name: impl Into<String>) -> Self {
        Scene {
            name: name.into(),
            role: Role::Other,
            points: Vec::new(),
            faces: Polygons::new(),
            cells: Polygons::new(),
            layers: Vec::new(),
            lines: Vec::new(),
            nets: Vec::new(),
            markers: Vec::new(),
            show: None,
        }
    }

    /// What a mesh file holds: faces, cells, tagged edges and every column; quality and irregular places are added.
    ///
    /// # Errors
    /// As [`RawMesh::check`].
    pub fn of_mesh(name: impl Into<String>, mesh: &RawMesh) -> Result<Self> {
        mesh.check()?;
        let mut scene = Scene::empty(name);
        scene.points.clone_from(&mesh.points);
        scene.faces.clone_from(&mesh.faces);
        scene.cells = polygons_of(&mesh.cells);
        let words = |column: &str| {
            let named = mesh.attributes.names.iter().filter(|((of, _), _)| of == column);
            named.map(|((_, label), word)| (*label, word.clone())).collect()
        };
        let of = |columns: &Columns, on: On, count: usize| -> Vec<Layer> {
            let fitting = columns.iter().filter(|(_, column)| column.len() == count);
            let layer = |(name, column): (&String, &Column)| {
                let mut layer = Layer { words: words(name), ..Layer::new(name, on, column.clone()) };
                if SIGNED.contains(&name.as_str()) {
                    layer.range = Range::Diverging;
                }
                layer
            };
            fitting.map(layer).collect()
        };
        scene.layers = of(&mesh.attributes.face, On::Face, mesh.faces.len());
        scene.layers.extend(of(&mesh.attributes.vertex, On::Vertex, mesh.points.len()));
        let tags = &mesh.cells.tags;
        if tags.len() == mesh.cells.len() && tags.iter().any(|t| *t != 0) {
            scene.layers.push(Layer::new("tag", On::Cell, Column::Label(tags.clone())));
        }
        scene.add_quality(&mesh.cells.hexes, mesh.cells.tets.len());
        scene.add_irregular(&mesh.cells.hexes);
        if mesh.faces.is_empty() && mesh.cells.is_empty() && !mesh.edges.is_empty() {
            return Ok(scene.lines("lines", Style::Feature, Path::Edges(mesh.edges.clone())));
        }
        let tags = mesh.edge_tags.iter().chain(std::iter::repeat(&0));
        let is_graph = mesh.attributes.face.contains_key("patch");
        let (tracks, others): (Vec<_>, Vec<_>) =
            mesh.edges.iter().zip(tags).partition(|(_, tag)| is_graph && matches!(**tag, TRACK | CUT));
        for (name, style, edges) in [("tagged edges", Style::Feature, others), (GRAPH, Style::Track, tracks)] {
            if !edges.is_empty() {
                scene = scene.lines(name, style, Path::Edges(edges.into_iter().map(|(e, _)| *e).collect()));
            }
        }
        Ok(scene)
    }

    /// A surface with its columns.
    ///
    /// # Errors
    /// As [`Scene::of_mesh`].
    pub fn of_surface(name: impl Into<String>, mesh: &SurfaceMesh) -> Result<Self> {
        Self::of_mesh(name, &RawMesh::from(mesh.clone()))
    }

    /// Hexahedra with their tagged boundary.
    ///
    /// # Errors
    /// As [`Scene::of_mesh`].
    pub fn of_hexes(name: impl Into<String>, mesh: &HexMesh) -> Result<Self> {
        Self::of_mesh(name, &RawMesh::from(mesh.clone()))
    }

    /// A skeleton alone.
    pub fn of_net(name: impl Into<String>, net: &CurveNet) -> Self {
        Scene::empty(name).net("skeleton", net)
    }

    /// A frame field on its mesh: short lines along the frames, features, marks where the number of quads is unusual.
    ///
    /// # Errors
    /// As [`Scene::of_mesh`].
    pub fn of_field(name: impl Into<String>, field: &Field) -> Result<Self> {
        let mut scene = Self::of_surface(name, &field.mesh)?;
        // The features stand for the tagged edges.
        scene.lines.clear();
        let unusual: Vec<_> = field.corners.iter().filter(|c| c.quads != usual(c)).collect();
        scene.markers = vec![Markers {
            name: "singularities".into(),
            vertices: unusual.iter().map(|c| c.vertex).collect(),
            values: unusual.iter().map(|c| c.quads).collect(),
            usual: unusual.iter().map(|c| usual(c)).collect(),
        }];
        scene.markers.retain(|m| !m.vertices.is_empty());
        for (name, directions) in [("u", &field.u), ("v", &field.v)] {
            let column = Column::Vector3(directions.iter().map(DVec3::to_array).collect());
            scene.layers.push(Layer::new(name, On::Face, column));
        }
        let frames = arms(field, PAGE_CROSSES).unwrap_or_default();
        Ok(scene
            .lines("frame field", Style::Field, Path::Segments(frames))
            .lines("features", Style::Feature, Path::Edges(field.features.clone()))
            .show("plain"))
    }

    /// A motorcycle graph on its mesh: patches, features, tracks, marks where these start off the features.
    ///
    /// # Errors
    /// As [`Scene::of_mesh`].
    pub fn of_graph(name: impl Into<String>, graph: &MotorcycleGraph) -> Result<Self> {
        let mut scene = Self::of_surface(name, &graph.mesh)?;
        for lines in scene.lines.iter_mut().filter(|l| l.style == Style::Feature) {
            lines.name = "features".into();
        }
        scene.layers.retain(|l| l.name != "singularity");
        let inner: Vec<_> = graph.starts.iter().filter(|s| s.inner).collect();
        if !inner.is_empty() {
            scene.markers = vec![Markers {
                name: "singularities".into(),
                vertices: inner.iter().map(|s| s.vertex).collect(),
                values: inner.iter().map(|s| s.quads as i32).collect(),
                usual: vec![4; inner.len()],
            }];
        }
        Ok(scene.show("patch"))
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What it is in its page.
    pub fn as_role(&self) -> Role {
        self.role
    }

    /// The scene under another name.
    pub fn named(mut self, name: impl Into<String>) -> Self {
        self.name = name.into();
        self
    }

    /// The scene with a place in its page.
    pub fn role(mut self, role: Role) -> Self {
        self.role = role;
        self
    }

    /// Adds a column.
    pub fn layer(mut self, layer: Layer) -> Self {
        self.layers.push(layer);
        self
    }

    /// Adds lines; edges between vertices that do not exist are left out.
    pub fn lines(mut self, name: impl Into<String>, style: Style, mut path: Path) -> Self {
        if let Path::Edges(edges) = &mut path {
            edges.retain(|e| e.iter().all(|&v| (v as usize) < self.points.len()));
        }
        self.lines.push(Lines { name: name.into(), style, path });
        self
    }

    /// Adds a skeleton.
    pub fn net(mut self, name: impl Into<String>, net: &CurveNet) -> Self {
        let mut net = net.clone();
        net.edges.retain(|e| e.iter().all(|&v| (v as usize) < net.points.len()));
        net.radii.resize(net.points.len(), f64::NAN);
        self.nets.push(Net { name: name.into(), net });
        self
    }

    /// The layer that gives the colours at first: a column's name, or `plain`.
    pub fn show(mut self, layer: impl Into<String>) -> Self {
        self.show = Some(layer.into());
        self
    }

    /// Adds principal curvatures per vertex (`kmin`, `kmax`), where all faces are triangles and has none yet.
    ///
    /// # Errors
    /// [`Error::Cancelled`], [`Error::Deadline`], [`Error::Input`].
    pub fn with_curvature(mut self, context: &Context) -> Result<Self> {
        let is_there = self.layers.iter().any(|l| l.name == "kmax");
        if is_there || self.faces.is_empty() || !self.faces.all_triangles() || !self.cells.is_empty() {
            return Ok(self);
        }
        let mesh = SurfaceMesh::new(self.points.clone(), self.faces.clone())?;
        let limits = FeatureOptions { angle_deg: Some(CURVATURE_CREASE), ..FeatureOptions::default() };
        let features = feature_edges(&mesh, &limits)?;
        let triangles = Triangles::of(&mesh).ok_or_else(|| Error::Bug("a triangle is no triangle".into()))?;
        let found = curvature(triangles, &features.corners, &CurvatureOptions::default(), context)?;
        for (name, values) in [("kmax", found.kmax), ("kmin", found.kmin)] {
            let layer = Layer::new(name, On::Vertex, Column::Scalar(values));
            self.layers.push(Layer { range: Range::Diverging, ..layer });
        }
        Ok(self)
    }

    /// Quality of cells, or of faces where there are no cells: mean ratio of triangles, scaled Jacobian of quads and hexes.
    fn add_quality(&mut self, hexes: &[[u32; 8]], before: usize) {
        let p = |v: &u32| self.points[*v as usize];
        let (on, values): (On, Vec<f64>) = if hexes.is_empty() {
            let of = |f: &[u32]| match *f {
                [a, b, c] => mean_ratio(p(&a), p(&b), p(&c)),
                [a, b, c, d] => scaled_jacobian([p(&a), p(&b), p(&c), p(&d)]),
                _ => f64::NAN,
            };
            (On::Face, (0..self.faces.len()).into_par_iter().map(|f| of(self.faces.face(f))).collect())
        } else {
            let mut all = vec![f64::NAN; self.cells.len()];
            let measured = hexes.par_iter().map(|h| hexes::scaled_jacobian(&h.map(|v| p(&v))));
            let places = all.iter_mut().skip(before);
            places.zip(measured.collect::<Vec<f64>>()).for_each(|(place, value)| *place = value);
            (On::Cell, all)
        };
        // Other cells have no measure here.
        if !values.is_empty() && (on == On::Cell || self.cells.is_empty()) && values.iter().any(|q| q.is_finite()) {
            let layer = Layer::new("quality", on, Column::Scalar(values));
            self.layers.push(Layer { range: Range::Quality, ..layer });
        }
    }

    fn add_irregular(&mut self, hexes: &[[u32; 8]]) {
        if !hexes.is_empty() {
            let edges = irregular_edges(hexes);
            if !edges.is_empty() {
                self.lines.push(Lines {
                    name: "irregular edges".into(),
                    style: Style::Singular,
                    path: Path::Edges(edges),
                });
            }
            return;
        }
        let found = irregular_vertices(&self.faces, self.points.len());
        if !found.is_empty() {
            self.markers.push(Markers {
                name: "irregular vertices".into(),
                vertices: found.iter().map(|f| f.0).collect(),
                values: found.iter().map(|f| f.1).collect(),
                usual: vec![4; found.len()],
            });
        }
    }
}

/// All cells in the order of their tags; the number of corners tells the kind.
fn polygons_of(cells: &Cells) -> Polygons {
    let mut all = Polygons::new();
    cells.tets.iter().for_each(|c| all.push(c));
    cells.hexes.iter().for_each(|c| all.push(c));
    cells.wedges.iter().for_each(|c| all.push(c));
    cells.pyramids.iter().for_each(|c| all.push(c));
    all
}
