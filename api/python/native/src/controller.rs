//! One controller with its memory.

use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};

use numpy::{PyArray1, PyArrayMethods};
use pyo3::exceptions::PyRuntimeError;
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use revprio::service::{ApiError, ComputedStep, LocalController, LocalService};
use revprio_api::wire;

use crate::arguments;
use crate::lock::without_lock;
use crate::outcome::{json, refused};

/// A controller in the process. Calls of several threads run one after the other.
#[pyclass(frozen)]
pub struct Controller {
    control: Mutex<LocalController>,
    /// The process that created it.
    process: u32,
    /// Deceleration of the joints, n, which no step changes; NaN: stop at once.
    deceleration: std::sync::OnceLock<Py<PyArray1<f64>>>,
}

/// The answer to a state, of which Python has read the numbers of the command.
#[pyclass(frozen)]
pub struct StepAnswer(ComputedStep);

#[pymethods]
impl StepAnswer {
    /// Returns the whole answer as JSON.
    fn json<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        json(py, &self.0.answer())
    }
}

/// Another thread used the controller when the process forked.
#[derive(Debug)]
pub struct Forked;

impl From<Forked> for PyErr {
    fn from(_: Forked) -> Self {
        PyRuntimeError::new_err(
            "a thread computed a step of this controller while the process forked; create another controller in the child, \
             from its `config`",
        )
    }
}

impl Controller {
    pub fn new(control: LocalController) -> Self {
        Self { control: Mutex::new(control), process: std::process::id(), deceleration: std::sync::OnceLock::new() }
    }

    /// Replaces the controller by that of a JSON body.
    pub fn replace(&self, service: &LocalService, body: &[u8]) -> Result<Result<(), ApiError>, Forked> {
        Ok(service.replace(&mut *self.lock()?, body))
    }

    /// Waits until no other thread uses the controller. After a fork, a thread of the parent can hold it for ever.
    fn lock(&self) -> Result<MutexGuard<'_, LocalController>, Forked> {
        match self.control.try_lock() {
            Ok(control) => Ok(control),
            Err(TryLockError::Poisoned(poisoned)) => Ok(poisoned.into_inner()),
            Err(TryLockError::WouldBlock) if std::process::id() != self.process => Err(Forked),
            Err(TryLockError::WouldBlock) => Ok(self.control.lock().unwrap_or_else(PoisonError::into_inner)),
        }
    }

    /// Returns the deceleration of all answers.
    fn deceleration<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        if let Some(known) = self.deceleration.get() {
            return Ok(known.bind(py).clone());
        }
        let values = self.lock()?.braking_deceleration();
        let array = PyArray1::from_iter(py, values.iter().map(|&v| if v.is_finite() { v } else { f64::NAN }));
        array.readwrite().make_nonwriteable();
        Ok(self.deceleration.get_or_init(|| array.unbind()).bind(py).clone())
    }
}

/// A part of a state in JSON, if there is one.
type Json<'py> = Option<Bound<'py, PyBytes>>;

/// What arrived with a state: targets, obstacles, wrenches and channels.
type Arrived<'py> = (Json<'py>, Json<'py>, Json<'py>, Json<'py>);

#[pymethods]
impl Controller {
    /// Names of the joints, in order.
    #[getter]
    fn joints(&self) -> PyResult<Vec<String>> {
        Ok(self.lock()?.joints().map(str::to_owned).collect())
    }

    /// Warnings about the controller, such as unstable loops.
    #[getter]
    fn warnings(&self) -> PyResult<Vec<String>> {
        Ok(self.lock()?.warnings().to_vec())
    }

    /// Runs one control period. `arrived`: new targets by task name, where obstacles are, the wrenches of other tips than the tool, and channels by name, in JSON. Returns the fields of the answer that a control loop needs, and the answer as `_answer`.
    #[pyo3(signature = (sequence, time_s, joint_position, joint_velocity, wrench, arrived, /))]
    fn step<'py>(
        &self,
        sequence: u64,
        time_s: &Bound<'py, PyAny>,
        joint_position: &Bound<'py, PyAny>,
        joint_velocity: Option<&Bound<'py, PyAny>>,
        wrench: Option<&Bound<'py, PyAny>>,
        arrived: Arrived<'py>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let py = joint_position.py();
        let velocity = |value| arguments::joint_vector(value, "/joint_velocity");
        let (targets, obstacles, wrenches, channels) = arrived;
        let state = wire::State {
            sequence,
            time_s: arguments::time(time_s)?,
            joint_position: arguments::joint_vector(joint_position, "/joint_position")?,
            joint_velocity: joint_velocity.map(velocity).transpose()?,
            wrench: wrench.map(arguments::wrench).transpose()?,
            targets: targets.map(|json| arguments::targets(py, json.as_bytes())).transpose()?.unwrap_or_default(),
            obstacles: obstacles.map(|json| arguments::obstacles(py, json.as_bytes())).transpose()?.unwrap_or_default(),
            channels: channels.map(|json| arguments::channels(py, json.as_bytes())).transpose()?.unwrap_or_default(),
            wrenches: wrenches.map(|json| arguments::wrenches(py, json.as_bytes())).transpose()?.unwrap_or_default(),
        };
        let answer = without_lock(py, || Ok::<_, Forked>(self.lock()?.step(&state)))?;
        let answer = answer.map_err(|error| refused(py, error))?;
        let fields = PyDict::new(py);
        fields.set_item(intern!(py, "joint_velocity"), PyArray1::from_slice(py, answer.joint_velocity()))?;
        fields.set_item(intern!(py, "sequence"), sequence)?;
        fields.set_item(intern!(py, "valid_for_ms"), answer.valid_for_ms())?;
        fields.set_item(intern!(py, "stop_time_s"), answer.stop_time_s())?;
        fields.set_item(intern!(py, "braking_deceleration"), self.deceleration(py)?)?;
        fields.set_item(intern!(py, "_answer"), StepAnswer(answer))?;
        Ok(fields)
    }
}
