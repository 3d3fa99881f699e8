//! Read-only arrays on memory that Rust owns: nothing is copied, and the array keeps its owner alive.

use carreau::DVec3;
use carreau::mesh::{Column, Columns};
use numpy::ndarray::{ArrayView1, ArrayView2};
use numpy::{Element, PyArray1, PyArray2, PyArrayMethods};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// An object whose memory neither moves nor changes while it lives: a frozen class, of which arrays are views.
pub type Owner<'a, 'py> = &'a Bound<'py, PyAny>;

/// One value per element.
///
/// `owner` must own `values`, and must not change them.
pub fn list<'py, T: Element>(owner: Owner<'_, 'py>, values: &[T]) -> Bound<'py, PyAny> {
    let view = ArrayView1::from(values);
    // SAFETY: every caller passes values that a frozen class holds, and that class as their owner. They live as long as
    // it, and nothing changes them.
    let array = unsafe { PyArray1::borrow_from_array(&view, owner.clone()) };
    array.readwrite().make_nonwriteable();
    array.into_any()
}

/// As many values per element as `width` says.
///
/// # Errors
/// Where the values do not fill their rows, which would be a bug.
pub fn table<'py, T: Element>(owner: Owner<'_, 'py>, values: &[T], width: usize) -> PyResult<Bound<'py, PyAny>> {
    let rows = values.len() / width.max(1);
    let view = ArrayView2::from_shape((rows, width), values).map_err(|e| PyRuntimeError::new_err(e.to_string()))?;
    // SAFETY: as in `list`.
    let array = unsafe { PyArray2::borrow_from_array(&view, owner.clone()) };
    array.readwrite().make_nonwriteable();
    Ok(array.into_any())
}

/// Points, three numbers each.
pub fn points<'py>(owner: Owner<'_, 'py>, points: &[DVec3]) -> PyResult<Bound<'py, PyAny>> {
    const { assert!(size_of::<DVec3>() == 3 * size_of::<f64>() && align_of::<DVec3>() == align_of::<f64>()) };
    // SAFETY: a DVec3 is three f64 without padding (`repr(C)`, and the assertion above).
    let numbers = unsafe { std::slice::from_raw_parts(points.as_ptr().cast::<f64>(), 3 * points.len()) };
    table(owner, numbers, 3)
}

/// The values of a column: one dimension for numbers and labels, two for vectors and colours.
fn column<'py>(owner: Owner<'_, 'py>, column: &Column) -> PyResult<Option<Bound<'py, PyAny>>> {
    Ok(Some(match column {
        Column::Scalar(v) => list(owner, v),
        Column::Label(v) => list(owner, v),
        Column::Vector2(v) => table(owner, v.as_flattened(), 2)?,
        Column::Vector3(v) => table(owner, v.as_flattened(), 3)?,
        Column::Color(v) => table(owner, v.as_flattened(), 4)?,
        _ => return Ok(None),
    }))
}

/// All columns by name.
pub fn columns<'py>(owner: Owner<'_, 'py>, columns: &Columns) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(owner.py());
    for (name, values) in columns {
        if let Some(array) = column(owner, values)? {
            all.set_item(name, array)?;
        }
    }
    Ok(all)
}

/// Values that belong to nothing else; the array of them is their owner's only user.
#[pyclass(frozen)]
struct Values {
    numbers: Vec<u32>,
}

/// A list made for the occasion; see [`table`].
pub fn owned_table(py: Python<'_>, numbers: Vec<u32>, width: usize) -> PyResult<Bound<'_, PyAny>> {
    let owner = Bound::new(py, Values { numbers })?;
    table(owner.as_any(), &owner.get().numbers, width)
}

/// A list made for the occasion; see [`list`].
pub fn owned_list(py: Python<'_>, numbers: Vec<u32>) -> PyResult<Bound<'_, PyAny>> {
    let owner = Bound::new(py, Values { numbers })?;
    Ok(list(owner.as_any(), &owner.get().numbers))
}
