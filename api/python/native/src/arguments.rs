//! Python objects to the bodies of the interface.

use std::collections::BTreeMap;

use numpy::{PyArray1, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyComplex, PyMapping};
use revprio::service::ApiError;
use revprio_api::wire::{ChannelInput, JointVector, ObstacleState, StreamedTarget, Wrench};

use crate::outcome::refused;

/// Reads one number per joint: an array, or anything that NumPy converts to one, or a mapping by joint name.
pub fn joint_vector(value: &Bound<'_, PyAny>, pointer: &str) -> PyResult<JointVector> {
    if let Ok(array) = value.cast_exact::<PyArray1<f64>>() {
        return Ok(JointVector::Ordered(entries(array)));
    }
    let Ok(mapping) = value.cast::<PyMapping>() else { return floats(value, pointer).map(JointVector::Ordered) };
    let named = mapping.items()?.iter().map(|item| item.extract::<(String, f64)>()).collect::<PyResult<_>>();
    named.map(JointVector::Named).map_err(|_| not_numbers(value.py(), pointer))
}

/// Reads a time, s.
pub fn time(value: &Bound<'_, PyAny>) -> PyResult<f64> {
    // NumPy would drop the imaginary part of a complex number.
    let real = if value.is_instance_of::<PyComplex>() { None } else { value.extract().ok() };
    real.ok_or_else(|| refused(value.py(), ApiError::invalid("/time_s", "give a number of seconds")))
}

/// Reads a wrench: a `Wrench`, or six numbers, force then torque.
pub fn wrench(value: &Bound<'_, PyAny>) -> PyResult<Wrench> {
    let py = value.py();
    let six = match value.cast_exact::<PyArray1<f64>>() {
        Ok(array) => entries(array),
        Err(_) => match value.getattr_opt(intern!(py, "force"))? {
            Some(force) => {
                let torque = value.getattr(intern!(py, "torque"))?;
                [floats(&force, "/wrench/force")?, floats(&torque, "/wrench/torque")?].concat()
            }
            None => floats(value, "/wrench")?,
        },
    };
    let &[fx, fy, fz, tx, ty, tz] = six.as_slice() else {
        let detail = format!("{} numbers; give six: force x, y, z in N, then torque x, y, z in N·m", six.len());
        return Err(refused(py, ApiError::invalid("/wrench", detail)));
    };
    Ok(Wrench { force: [fx, fy, fz], torque: [tx, ty, tz] })
}

/// Reads targets by task name in JSON.
pub fn targets(py: Python<'_>, json: &[u8]) -> PyResult<BTreeMap<String, StreamedTarget>> {
    serde_json::from_slice(json).map_err(|error| refused(py, ApiError::invalid("/targets", error)))
}

/// Reads where obstacles are, in JSON.
pub fn obstacles(py: Python<'_>, json: &[u8]) -> PyResult<Vec<ObstacleState>> {
    serde_json::from_slice(json).map_err(|error| refused(py, ApiError::invalid("/obstacles", error)))
}

/// Reads the wrenches of tips in JSON.
pub fn wrenches(py: Python<'_>, json: &[u8]) -> PyResult<BTreeMap<String, Wrench>> {
    serde_json::from_slice(json).map_err(|error| refused(py, ApiError::invalid("/wrenches", error)))
}

/// Reads channels by name in JSON.
pub fn channels(py: Python<'_>, json: &[u8]) -> PyResult<BTreeMap<String, ChannelInput>> {
    serde_json::from_slice(json).map_err(|error| refused(py, ApiError::invalid("/channels", error)))
}

/// Converts with `numpy.asarray`.
fn floats(value: &Bound<'_, PyAny>, pointer: &str) -> PyResult<Vec<f64>> {
    static ASARRAY: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    static MASKED: PyOnceLock<Py<PyAny>> = PyOnceLock::new();
    let py = value.py();
    if value.is_instance(MASKED.import(py, "numpy.ma", "MaskedArray")?)? {
        let detail = "a masked array has no number where it is masked; give an array, such as `masked.filled(0.0)`";
        return Err(refused(py, ApiError::invalid(pointer, detail)));
    }
    let asarray = ASARRAY.import(py, "numpy", "asarray")?;
    let array = asarray.call1((value,)).map_err(|_| not_numbers(py, pointer))?;
    // NumPy would drop the imaginary parts.
    if array.getattr(intern!(py, "dtype"))?.getattr(intern!(py, "kind"))?.eq("c")? {
        return Err(not_numbers(py, pointer));
    }
    let array = asarray.call1((array, intern!(py, "f8"))).map_err(|_| not_numbers(py, pointer))?;
    let array = array.cast::<PyArray1<f64>>().map_err(|_| not_numbers(py, pointer))?;
    Ok(entries(array))
}

/// Copies the entries, without the table of borrowed arrays that a slice of NumPy's memory needs.
fn entries(array: &Bound<'_, PyArray1<f64>>) -> Vec<f64> {
    (0..array.len()).map(|i| array.get_owned(i).unwrap_or(f64::NAN)).collect()
}

fn not_numbers(py: Python<'_>, pointer: &str) -> PyErr {
    refused(py, ApiError::invalid(pointer, "give a list or an array of real numbers"))
}
