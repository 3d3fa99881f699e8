//! Errors as the exceptions of `carreau._errors`.

use carreau::Error;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use std::any::Any;

/// The exception for an error.
pub fn exception(py: Python<'_>, error: &Error) -> PyErr {
    let (class, place, remedy) = match error {
        Error::Input { place, remedy, .. } => ("InputError", place.as_str(), remedy.as_str()),
        Error::Options(_) => ("OptionsError", "", ""),
        Error::Read { .. } => ("ReadError", "", ""),
        Error::Write { .. } => ("WriteError", "", ""),
        Error::Numeric(_) => ("NumericError", "", ""),
        Error::Deadline => ("DeadlineError", "", ""),
        Error::Cancelled => ("CancelledError", "", ""),
        _ => ("InternalError", "", ""),
    };
    build(py, class, &error.to_string(), place, remedy)
}

/// A panic is a bug, and an ordinary exception: pyo3's own would slip through `except Exception`.
pub fn panic(py: Python<'_>, payload: &(dyn Any + Send)) -> PyErr {
    let said = payload.downcast_ref::<&str>().map(ToString::to_string);
    let said = said.or_else(|| payload.downcast_ref::<String>().cloned()).unwrap_or_else(|| "a panic".into());
    let error = Error::Bug(said);
    exception(py, &error)
}

fn build(py: Python<'_>, class: &str, message: &str, place: &str, remedy: &str) -> PyErr {
    let made = py.import("carreau._errors").and_then(|m| m.getattr(class)?.call1((message, place, remedy)));
    match made {
        Ok(instance) => PyErr::from_value(instance),
        Err(_) => PyRuntimeError::new_err(message.to_string()),
    }
}
