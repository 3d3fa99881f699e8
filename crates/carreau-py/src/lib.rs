//! `carreau._core`: the native half of the Python package. It translates, and computes nothing itself.
//!
//! | file | does |
//! |---|---|
//! | `views` | read-only arrays on memory that Rust owns |
//! | `mesh` | `Mesh` |
//! | `net` | `Net`: skeletons |
//! | `found` | what verbs hand back |
//! | `run` | runs work beside Python: interrupts, progress, panics |
//! | `raise` | errors as exceptions |
//!
//! Verbs run through `carreau_cli::host`: their options, defaults and records are those of the command line. The
//! classes that users see are Python's, in `python/carreau`.

mod found;
mod mesh;
mod net;
mod raise;
mod run;
mod views;

use pyo3::prelude::*;

#[pymodule]
mod _core {
    #[pymodule_export]
    use crate::found::{Found, arguments, call, option_names};
    #[pymodule_export]
    use crate::mesh::{Mesh, sample, samples};
    #[pymodule_export]
    use crate::net::Net;
    use pyo3::prelude::*;
    use std::ffi::OsString;

    /// Runs one command line; returns the exit code.
    #[pyfunction]
    fn main(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
        py.detach(|| carreau_cli::run(arguments))
    }

    /// A panic, for the test of what becomes of one; releases do not have it.
    #[cfg(debug_assertions)]
    #[pyfunction]
    fn _panic(py: Python<'_>) -> PyResult<()> {
        crate::run::beside(py, None, |_, _| unreachable!("on purpose"))
    }

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
