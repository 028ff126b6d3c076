//! Answers as bytes, and refusals as exceptions.

use pyo3::create_exception;
use pyo3::exceptions::{PyException, PyOSError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use revprio::service::ApiError;

create_exception!(_native, RefusedError, PyException, "A refused request; the argument is the problem as JSON.");

/// Converts a refusal to an exception with its problem object.
pub fn refused(py: Python<'_>, error: ApiError) -> PyErr {
    let problem = serde_json::to_vec(&error.into_wire()).unwrap_or_default();
    RefusedError::new_err(PyBytes::new(py, &problem).unbind())
}

/// Writes a body.
pub fn json<'py, T: serde::Serialize>(py: Python<'py>, value: &T) -> PyResult<Bound<'py, PyBytes>> {
    let text = serde_json::to_vec(value).map_err(|error| PyOSError::new_err(error.to_string()))?;
    Ok(PyBytes::new(py, &text))
}
