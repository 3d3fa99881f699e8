//! `Net`: a skeleton with radii.

use crate::{raise, run, views};
use carreau::mesh::{CurveNet, NetBuilder};
use carreau::{DVec3, Error, io};
use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::Arc;

/// A graph drawn in space with a radius at every node.
#[pyclass(frozen, module = "carreau._core")]
pub struct Net(pub Arc<CurveNet>);

#[pymethods]
impl Net {
    /// Nodes, radii (NaN: unknown) and segments; checked.
    #[new]
    fn new(
        py: Python<'_>,
        points: PyReadonlyArray2<'_, f64>,
        radii: PyReadonlyArray1<'_, f64>,
        segments: PyReadonlyArray2<'_, i64>,
    ) -> PyResult<Self> {
        let mut builder = NetBuilder::default();
        let (points, radii) = (points.as_array(), radii.as_array());
        let mut nodes = points.rows().into_iter().zip(radii).zip(0..);
        let added = nodes.try_for_each(|((p, &r), id)| {
            builder.node(id, DVec3::new(p[0], p[1], p[2]), (!r.is_nan()).then_some(r), 0)
        });
        segments.as_array().rows().into_iter().for_each(|s| builder.link(s[0], s[1], 0));
        match added.and_then(|()| builder.finish()) {
            Ok(net) => Ok(Net(Arc::new(net))),
            Err(error) => Err(raise::exception(py, &without_line(error))),
        }
    }

    /// Reads a skeleton file.
    #[staticmethod]
    fn read(py: Python<'_>, file: PathBuf) -> PyResult<Self> {
        run::beside(py, None, |_, _| io::read_skeleton(&file)).map(|net| Net(Arc::new(net)))
    }

    /// Writes a skeleton file; returns warnings.
    fn write(&self, py: Python<'_>, file: PathBuf) -> PyResult<Vec<String>> {
        run::beside(py, None, |_, _| io::write_skeleton(&file, &self.0))
    }

    #[getter]
    fn points<'py>(this: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        views::points(this.as_any(), &this.get().0.points)
    }

    #[getter]
    fn radii<'py>(this: &Bound<'py, Self>) -> Bound<'py, PyAny> {
        views::list(this.as_any(), &this.get().0.radii)
    }

    #[getter]
    fn segments<'py>(this: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        views::table(this.as_any(), this.get().0.edges.as_flattened(), 2)
    }

    /// What the reader mended.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.0.notes.clone()
    }

    /// Whether a file is a skeleton by its extension.
    #[staticmethod]
    fn is_skeleton_file(file: PathBuf) -> bool {
        io::is_skeleton_file(&file)
    }
}

/// Arrays have no lines.
fn without_line(error: Error) -> Error {
    match error {
        Error::Input { what, place, remedy } => Error::Input { what, place: place.replace("line 0, ", ""), remedy },
        other => other,
    }
}
