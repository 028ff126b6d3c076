//! The extension module of the Python package `revprio`: `_native`.
//!
//! | module | content |
//! |---|---|
//! | [`controller`] | one controller with its memory, stepped with NumPy arrays |
//! | [`service`] | the other calls, with JSON bodies, and a server in the process |
//! | [`arguments`] | Python objects to the bodies of the interface |
//! | [`lock`] | short computations without the lock of the interpreter |
//!
//! The computation runs without the lock of the interpreter.
#![cfg(feature = "python")]

mod arguments;
mod controller;
mod lock;
mod service;

use pyo3::create_exception;
use pyo3::exceptions::{PyException, PyOSError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use revprio::service::ApiError;

create_exception!(_native, RefusedError, PyException, "A refused request; the argument is the problem as JSON.");

/// Converts a refusal to an exception with its problem object.
fn refused(py: Python<'_>, error: ApiError) -> PyErr {
    let problem = serde_json::to_vec(&error.into_wire()).unwrap_or_default();
    RefusedError::new_err(PyBytes::new(py, &problem).unbind())
}

/// Writes a body.
fn json<'py, T: serde::Serialize>(py: Python<'py>, value: &T) -> PyResult<Bound<'py, PyBytes>> {
    let text = serde_json::to_vec(value).map_err(|error| PyOSError::new_err(error.to_string()))?;
    Ok(PyBytes::new(py, &text))
}

/// Runs the program with these arguments, without the name of the program. Returns its exit status.
#[pyfunction]
#[pyo3(name = "main")]
fn run_program(py: Python<'_>, arguments: Vec<std::ffi::OsString>) -> u8 {
    py.detach(|| revprio::cli::main(std::iter::once("revprio".into()).chain(arguments)))
}

/// The module.
#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<service::Service>()?;
    module.add_class::<service::Server>()?;
    module.add_class::<controller::Controller>()?;
    module.add_class::<controller::StepAnswer>()?;
    module.add_class::<service::ResolveAnswer>()?;
    module.add("RefusedError", module.py().get_type::<RefusedError>())?;
    module.add_function(wrap_pyfunction!(run_program, module)?)
}
