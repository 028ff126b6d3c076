//! The extension module of the Python package `revprio`: `_native`.
//!
//! | module | content |
//! |---|---|
//! | [`controller`] | one controller with its memory, stepped with NumPy arrays |
//! | [`service`] | the other calls, with JSON bodies, and a server in the process |
//! | [`arguments`] | Python objects to the bodies of the interface |
//! | [`outcome`] | answers as bytes, refusals as exceptions |
//! | [`lock`] | short computations without the lock of the interpreter |
//!
//! The computation runs without the lock of the interpreter.
#![cfg(feature = "python")]

mod arguments;
mod controller;
mod lock;
mod outcome;
mod service;

use pyo3::prelude::*;

use self::outcome::RefusedError;

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
