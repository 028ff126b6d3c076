//! The calls with JSON bodies, and a server in the process.

use std::sync::{Mutex, PoisonError};

use numpy::PyArray1;
use pyo3::exceptions::PyOSError;
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use revprio::service::{AppState, LocalService, Robots, RunningServer, router};
use revprio_api::wire;

use crate::controller::Controller;
use crate::outcome::{json, refused};

/// The service as function calls.
#[pyclass(frozen)]
pub struct Service(LocalService);

#[pymethods]
impl Service {
    #[new]
    fn new() -> Self {
        Self(LocalService::new(Robots::built_in()))
    }

    /// Answers a request to a route with a JSON body. Returns the JSON body of the answer.
    fn call<'py>(&self, py: Python<'py>, method: &str, path: &str, body: &[u8]) -> PyResult<Bound<'py, PyBytes>> {
        let answer = py.detach(|| self.0.call(method, path, body)).map_err(|error| refused(py, error))?;
        Ok(PyBytes::new(py, &answer))
    }

    /// Resolves a problem. Returns the field `joint_velocity` of the answer, and the answer as `_answer`.
    fn resolve<'py>(&self, py: Python<'py>, body: &[u8]) -> PyResult<Bound<'py, PyDict>> {
        let answer = py.detach(|| self.0.resolve(body)).map_err(|error| refused(py, error))?;
        let fields = PyDict::new(py);
        fields.set_item(intern!(py, "joint_velocity"), PyArray1::from_slice(py, &answer.joint_velocity))?;
        fields.set_item(intern!(py, "_answer"), ResolveAnswer(answer))?;
        Ok(fields)
    }

    /// Opens a controller.
    fn controller(&self, py: Python<'_>, body: &[u8]) -> PyResult<Controller> {
        py.detach(|| self.0.controller(body)).map(Controller::new).map_err(|error| refused(py, error))
    }

    /// Replaces a controller.
    fn replace(&self, py: Python<'_>, controller: &Controller, body: &[u8]) -> PyResult<()> {
        py.detach(|| controller.replace(&self.0, body))?.map_err(|error| refused(py, error))
    }
}

/// The answer of `Service.resolve`, of which Python has read the joint velocities.
#[pyclass(frozen)]
pub struct ResolveAnswer(wire::ResolveAnswer);

#[pymethods]
impl ResolveAnswer {
    /// Returns the whole answer as JSON.
    fn json<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        json(py, &self.0)
    }
}

/// A server on a free loopback port.
#[pyclass(frozen)]
pub struct Server {
    #[pyo3(get)]
    url: String,
    running: Mutex<Option<RunningServer>>,
}

#[pymethods]
impl Server {
    #[new]
    fn new(py: Python<'_>) -> PyResult<Self> {
        let start = || RunningServer::start(router(AppState::new(Robots::built_in())));
        let running = py.detach(start).map_err(|error| PyOSError::new_err(error.to_string()))?;
        Ok(Self { url: running.url(), running: Mutex::new(Some(running)) })
    }

    /// Ends the server. Does nothing if it has ended.
    fn close(&self, py: Python<'_>) {
        let running = self.running.lock().unwrap_or_else(PoisonError::into_inner).take();
        py.detach(|| drop(running));
    }
}
