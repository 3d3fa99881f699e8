//! `Mesh`: what a mesh file holds, as arrays.

use crate::{raise, run, views};
use carreau::geometry::quality::SurfaceQuality;
use carreau::io::{self, WriteOptions};
use carreau::mesh::{Attributes, Cells, Column, Columns, Polygons, RawMesh, Topology};
use carreau::report::figure;
use carreau::report::page::{Page, Scene};
use carreau::sample::{SAMPLES, make};
use carreau::{Context, DVec3, Error};
use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::path::PathBuf;
use std::sync::Arc;

/// Points, faces, marked edges, volume cells and attributes.
#[pyclass(frozen, module = "carreau._core")]
pub struct Mesh(pub Arc<RawMesh>);

impl Mesh {
    /// A mesh with all indices checked.
    fn checked(py: Python<'_>, mesh: RawMesh) -> PyResult<Self> {
        match mesh.check() {
            Ok(()) => Ok(Mesh(Arc::new(mesh))),
            Err(error) => Err(raise::exception(py, &error)),
        }
    }
}

#[pymethods]
impl Mesh {
    /// Points, corners of all faces and the size of each face, edges with tags, hexahedra, attributes.
    #[allow(clippy::too_many_arguments)] // the arrays of a mesh
    #[new]
    fn new(
        py: Python<'_>,
        points: PyReadonlyArray2<'_, f64>,
        corners: PyReadonlyArray1<'_, u32>,
        sizes: PyReadonlyArray1<'_, u32>,
        edges: PyReadonlyArray2<'_, u32>,
        edge_tags: PyReadonlyArray1<'_, i32>,
        hexes: PyReadonlyArray2<'_, u32>,
        vertex: &Bound<'_, PyDict>,
        face: &Bound<'_, PyDict>,
    ) -> PyResult<Self> {
        let hexes: Vec<[u32; 8]> = hexes.as_array().rows().into_iter().map(|h| std::array::from_fn(|k| h[k])).collect();
        let mesh = RawMesh {
            points: points.as_array().rows().into_iter().map(|p| DVec3::new(p[0], p[1], p[2])).collect(),
            faces: polygons(corners.as_array().iter().copied(), sizes.as_array().iter().copied()),
            edges: edges.as_array().rows().into_iter().map(|e| [e[0], e[1]]).collect(),
            edge_tags: edge_tags.as_array().to_vec(),
            cells: Cells { tags: vec![0; hexes.len()], hexes, ..Cells::default() },
            attributes: Attributes { vertex: columns(vertex)?, face: columns(face)?, ..Attributes::default() },
            ..RawMesh::default()
        };
        Self::checked(py, mesh)
    }

    /// Reads a mesh file.
    #[staticmethod]
    fn read(py: Python<'_>, file: PathBuf) -> PyResult<Self> {
        run::beside(py, None, |_, _| io::read(&file)).map(|mesh| Mesh(Arc::new(mesh)))
    }

    /// Writes a mesh file; returns warnings.
    fn write(&self, py: Python<'_>, file: PathBuf, ascii: bool) -> PyResult<Vec<String>> {
        run::beside(py, None, |_, _| io::write(&file, &self.0, &WriteOptions { ascii }))
    }

    #[getter]
    fn points<'py>(this: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        views::points(this.as_any(), &this.get().0.points)
    }

    /// The vertices of all faces, one after the other.
    #[getter]
    fn corners<'py>(this: &Bound<'py, Self>) -> Bound<'py, PyAny> {
        views::list(this.as_any(), this.get().0.faces.corners())
    }

    /// Where each face begins in `corners`, and where the last ends.
    #[getter]
    fn offsets<'py>(this: &Bound<'py, Self>) -> Bound<'py, PyAny> {
        views::list(this.as_any(), this.get().0.faces.offsets())
    }

    /// The faces as a table, where all have as many corners.
    #[getter]
    fn faces<'py>(this: &Bound<'py, Self>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let faces = &this.get().0.faces;
        let width = faces.iter().next().map_or(3, <[u32]>::len);
        if faces.iter().any(|f| f.len() != width) {
            return Ok(None);
        }
        views::table(this.as_any(), faces.corners(), width).map(Some)
    }

    #[getter]
    fn edges<'py>(this: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        views::table(this.as_any(), this.get().0.edges.as_flattened(), 2)
    }

    #[getter]
    fn edge_tags<'py>(this: &Bound<'py, Self>) -> Bound<'py, PyAny> {
        views::list(this.as_any(), &this.get().0.edge_tags)
    }

    #[getter]
    fn tets<'py>(this: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        views::table(this.as_any(), this.get().0.cells.tets.as_flattened(), 4)
    }

    #[getter]
    fn hexes<'py>(this: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        views::table(this.as_any(), this.get().0.cells.hexes.as_flattened(), 8)
    }

    #[getter]
    fn wedges<'py>(this: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        views::table(this.as_any(), this.get().0.cells.wedges.as_flattened(), 6)
    }

    #[getter]
    fn pyramids<'py>(this: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        views::table(this.as_any(), this.get().0.cells.pyramids.as_flattened(), 5)
    }

    #[getter]
    fn vertex<'py>(this: &Bound<'py, Self>) -> PyResult<Bound<'py, PyDict>> {
        views::columns(this.as_any(), &this.get().0.attributes.vertex)
    }

    #[getter]
    fn face<'py>(this: &Bound<'py, Self>) -> PyResult<Bound<'py, PyDict>> {
        views::columns(this.as_any(), &this.get().0.attributes.face)
    }

    /// Words for the values of label columns.
    #[getter]
    fn names(&self) -> Vec<((String, i32), String)> {
        self.0.attributes.names.iter().map(|(key, word)| (key.clone(), word.clone())).collect()
    }

    /// What the reader repaired or left out.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.0.notes.clone()
    }

    /// The same mesh with other attributes in addition.
    fn with_attributes(&self, py: Python<'_>, vertex: &Bound<'_, PyDict>, face: &Bound<'_, PyDict>) -> PyResult<Self> {
        let mut mesh = RawMesh::clone(&self.0);
        mesh.attributes.vertex.extend(columns(vertex)?);
        mesh.attributes.face.extend(columns(face)?);
        Self::checked(py, mesh)
    }

    /// The surface with every polygon cut into triangles.
    fn triangulated(&self, py: Python<'_>) -> PyResult<Self> {
        let mesh = RawMesh::clone(&self.0);
        run::beside(py, None, |_, _| mesh.into_surface()?.triangulated()).map(|m| Mesh(Arc::new(m.into())))
    }

    /// The boundary of a volume mesh.
    fn boundary(&self, py: Python<'_>) -> PyResult<Self> {
        run::beside(py, None, |_, _| self.0.boundary()).map(|mesh| Mesh(Arc::new(mesh)))
    }

    /// Counts and defects, and measures of quality (JSON, both).
    fn describe(&self, py: Python<'_>) -> PyResult<(String, String)> {
        let mesh = RawMesh::clone(&self.0);
        run::beside(py, None, |_, _| {
            let surface = if mesh.cells.is_empty() { mesh } else { mesh.boundary()? }.into_surface()?;
            Ok((json(&Topology::of(&surface))?, json(&SurfaceQuality::of(&surface))?))
        })
    }

    /// A page (HTML) that shows it.
    fn page(&self, py: Python<'_>, title: &str) -> PyResult<String> {
        run::beside(py, None, |_, _| Page::new(title).scene(Scene::of_mesh(title, &self.0)?).html())
    }

    /// The usual picture (PNG).
    fn picture<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let png = run::beside(py, None, |_, _| figure(&self.0).to_png())?;
        Ok(PyBytes::new(py, &png))
    }
}

fn json(value: &impl serde::Serialize) -> Result<String, Error> {
    serde_json::to_string(value).map_err(|e| Error::Bug(e.to_string()))
}

/// Faces of these sizes; corners that are missing make a face short, which the mesh's check tells.
fn polygons(mut corners: impl Iterator<Item = u32>, sizes: impl Iterator<Item = u32>) -> Polygons {
    let mut faces = Polygons::new();
    sizes.for_each(|n| faces.push_iter(corners.by_ref().take(n as usize)));
    faces
}

/// Attributes from arrays of these kinds, which the Python half converts to: float64 of one to three columns, int32,
/// and uint8 of four columns.
fn columns(arrays: &Bound<'_, PyDict>) -> PyResult<Columns> {
    arrays.iter().map(|(name, values)| Ok((name.extract()?, column(&values)?))).collect()
}

fn column(values: &Bound<'_, PyAny>) -> PyResult<Column> {
    if let Ok(v) = values.extract::<PyReadonlyArray1<'_, f64>>() {
        return Ok(Column::Scalar(v.as_array().to_vec()));
    }
    if let Ok(v) = values.extract::<PyReadonlyArray1<'_, i32>>() {
        return Ok(Column::Label(v.as_array().to_vec()));
    }
    if let Ok(v) = values.extract::<PyReadonlyArray2<'_, f64>>() {
        let v = v.as_array();
        match v.ncols() {
            2 => return Ok(Column::Vector2(v.rows().into_iter().map(|r| [r[0], r[1]]).collect())),
            3 => return Ok(Column::Vector3(v.rows().into_iter().map(|r| [r[0], r[1], r[2]]).collect())),
            _ => {}
        }
    }
    if let Ok(v) = values.extract::<PyReadonlyArray2<'_, u8>>()
        && v.as_array().ncols() == 4
    {
        return Ok(Column::Color(v.as_array().rows().into_iter().map(|r| [r[0], r[1], r[2], r[3]]).collect()));
    }
    Err(PyTypeError::new_err("an attribute is float64 of 1 to 3 columns, int32, or uint8 of 4 columns"))
}

/// A built-in model.
#[pyfunction]
pub fn sample(py: Python<'_>, name: &str, resolution: Option<u32>, seed: u64) -> PyResult<Mesh> {
    let made = run::beside(py, None, |cancel, _| {
        let mut context = Context::new().with_cancel(cancel);
        context.seed = seed;
        make(name, resolution, &context)
    })?;
    Ok(Mesh(Arc::new(made.into())))
}

/// Name and summary of every built-in model.
#[pyfunction]
pub fn samples() -> Vec<(&'static str, &'static str)> {
    SAMPLES.iter().map(|s| (s.name, s.summary)).collect()
}
