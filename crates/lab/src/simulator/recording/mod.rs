//! Recordings of runs, and their files.
//!
//! ```text
//! Recording ─→ columns (one line per quantity) ─→ CSV, Parquet ─┐
//!           └→ samples as JSON ────────────→ JSON lines, MCAP ──┴→ read: the same Recording, to the last bit
//! ```

mod answered;
#[cfg(feature = "files")]
mod cell;
mod clarabel_levels;
#[cfg(feature = "files")]
mod columns;
mod contact;
#[cfg(feature = "files")]
mod csv_table;
#[cfg(feature = "files")]
mod description;
#[cfg(feature = "files")]
mod error;
#[cfg(feature = "files")]
mod format;
#[cfg(feature = "files")]
mod json_lines;
#[cfg(feature = "files")]
mod mcap_log;
#[cfg(feature = "files")]
pub mod parquet_file;
#[cfg(feature = "files")]
mod parquet_table;
#[cfg(feature = "files")]
mod quantity;
#[cfg(feature = "files")]
mod writer;

use std::fmt;

use revprio_api::wire;
use serde::{Deserialize, Serialize};

pub use super::energy::Energy;
use super::scenario::Scenario;
pub use super::sensors::Sensed;

#[cfg(feature = "files")]
pub use cell::Value;
pub use clarabel_levels::{ClarabelLevels, PRECISE};
#[cfg(feature = "files")]
pub use columns::{Column, TableLayout};
pub use contact::{ContactEvent, ContactWord, Contacts, Surfaces};
#[cfg(feature = "files")]
pub use csv_table::{cell_text, cell_value};
#[cfg(feature = "files")]
pub use description::to_json as recording_description;
#[cfg(feature = "files")]
pub use error::{ReadError, WriteError};
#[cfg(feature = "files")]
pub use format::{Format, read};
#[cfg(feature = "files")]
pub use json_lines::write_object;
#[cfg(feature = "files")]
pub use quantity::{Kind, Per, Presence, QUANTITIES, Quantity};
#[cfg(feature = "files")]
pub use writer::Writer;

/// The recording of one run of a scenario.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Recording {
    /// Name of the scenario, as in `force_tracking`.
    pub scenario: String,
    /// The resolution method.
    pub method: wire::Method,
    /// The solver.
    pub solver: wire::Solver,
    /// Control period T, s.
    pub period_s: f64,
    /// Real time of the run, s; 0 if a file does not contain it.
    #[serde(default)]
    pub wall_time_s: f64,
    /// Joint names, n.
    pub joint_names: Vec<String>,
    /// Energy of the contacts from the start to the last sample.
    pub energy: Energy,
    /// The whole scenario with its controller, as it was run.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub setup: Option<Box<Scenario>>,
    /// What Clarabel did; `None` if no answer had a level that it solved, or if a file does not contain it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clarabel: Option<ClarabelLevels>,
    /// One sample per control period.
    #[serde(skip)]
    pub samples: Vec<Sample>,
    /// Real times of each period, separate from the samples, which are the same in every run. Empty if a file does not
    /// contain them.
    #[serde(skip)]
    pub timings: Vec<Timing>,
}

/// Real times of one call.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Timing {
    /// Time from sending the state to its answer or error, µs; 0 if there was no call.
    pub round_trip_us: f64,
    /// Time to compute the answer that the arm executes, as reported by the service, µs.
    pub elapsed_us: f64,
}

/// One control period, before the command acts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// Simulated time, s.
    pub time_s: f64,
    /// Joint positions q, n, rad or m.
    pub joint_position: Vec<f64>,
    /// Commanded joint velocities q̇, n, rad/s or m/s.
    pub joint_velocity: Vec<f64>,
    /// Actual joint velocities q̇, n, rad/s or m/s.
    pub actual_velocity: Vec<f64>,
    /// Tool position in the base frame, m.
    pub position: [f64; 3],
    /// Orientation of the tool in the base frame, a unit quaternion w, x, y, z.
    pub orientation: [f64; 4],
    /// Tool position minus start position, m.
    pub position_error: [f64; 3],
    /// Force F_e of the tool on contacts and on external pushes, base axes, N.
    pub force: [f64; 3],
    /// Torque of F_e at the tool point, N·m.
    pub torque: [f64; 3],
    /// External push on the tool, a part of −F_e, N.
    pub external_force: [f64; 3],
    /// The state that the controller received; `None` if it is q, q̇ and F_e as above.
    pub sensed: Option<Box<Sensed>>,
    /// Target force F_d, N; `None` if the axis is not force-controlled.
    pub target_force: [Option<f64>; 3],
    /// Distance to the wall, m, positive without contact; `None` without a wall.
    #[serde(rename = "wall_distance_m")]
    pub wall_distance: Option<f64>,
    /// Solution path of the command.
    pub path: wire::Path,
    /// Status of the command.
    pub status: wire::Status,
    /// Residual of the optimality conditions.
    pub kkt_residual: Option<f64>,
    /// Smallest singular value σ_min of all task rows.
    pub smallest_singular_value: f64,
    /// Product of the singular values of all task rows.
    pub manipulability: f64,
    /// Residual ‖J_k q̇ − ẋ_k‖ of each task, highest priority first.
    pub residual_norms: Vec<f64>,
    /// Commands of the channels, in the order of their names.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub channels: Vec<Option<f64>>,
    /// Contacts of the tasks with the law `contact`.
    #[serde(default, skip_serializing_if = "Contacts::is_empty")]
    pub contacts: Contacts,
    /// Least distance of the watched pairs of shapes, m; `None` without them.
    #[serde(rename = "least_distance_m", default, skip_serializing_if = "Option::is_none")]
    pub least_distance: Option<f64>,
    /// Relation of each joint velocity to its limits, n.
    pub limits: Vec<AtLimit>,
    /// Energy of the contacts so far.
    pub energy: Energy,
    /// Whether an answer arrived in this period; if not, the values of the answer are those of the last one.
    pub answered: bool,
    /// Age of the answer: periods since the measurement of its state; 0 for the state of this period.
    pub answer_age: u64,
}

/// Relation of a commanded joint velocity to its bounds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AtLimit {
    /// No bound is active.
    Free,
    /// The lower bound is active.
    Lower,
    /// The upper bound is active.
    Upper,
    /// Below the lower bound.
    Below,
    /// Above the upper bound.
    Above,
}

impl fmt::Display for AtLimit {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        self.serialize(formatter)
    }
}

impl AtLimit {
    /// Returns the relation for each joint, n, from an answer.
    pub fn of(answer: &wire::StepAnswer, joint_names: &[String]) -> Vec<Self> {
        let side = |side, lower, upper| if side == wire::Side::Lower { lower } else { upper };
        let of = |name: &String| {
            let violated = answer.violated_limits.iter().find(|limit| limit.joint == *name);
            let active = || answer.active_limits.iter().find(|limit| limit.joint == *name);
            match violated {
                Some(limit) => side(limit.side, Self::Below, Self::Above),
                None => active().map_or(Self::Free, |limit| side(limit.side, Self::Lower, Self::Upper)),
            }
        };
        joint_names.iter().map(of).collect()
    }
}

impl Recording {
    /// Returns scenario, method and solver as one word for file names.
    pub fn label(&self) -> String {
        format!("{}-{}-{}", self.scenario, self.method, self.solver)
    }

    /// Returns the file name of the recording in a format.
    #[cfg(feature = "files")]
    pub fn trace_name(&self, format: Format) -> String {
        format!("{}.{}", self.label(), format.ending())
    }

    /// Returns whether the controller watches distances.
    #[cfg(feature = "files")]
    fn watches_distances(&self) -> bool {
        let is_stated = self.setup.as_ref().is_some_and(|setup| setup.controller.collisions.is_some());
        is_stated || self.samples.first().is_some_and(|sample| sample.least_distance.is_some())
    }

    #[cfg(feature = "files")]
    fn push(&mut self, sample: Sample, timing: Timing, timed: bool) {
        self.samples.push(sample);
        if timed {
            self.timings.push(timing);
        }
    }
}

#[cfg(test)]
impl Recording {
    /// Returns a recording without samples, for tests.
    pub fn empty() -> Self {
        Self {
            scenario: "stiff_wall".to_owned(),
            method: wire::Method::ReversePriority,
            solver: wire::Solver::ClosedForm,
            period_s: 1e-3,
            wall_time_s: 0.5,
            joint_names: Vec::new(),
            energy: Energy::default(),
            setup: None,
            clarabel: None,
            samples: Vec::new(),
            timings: Vec::new(),
        }
    }
}

impl Sample {
    /// Returns whether the first axis with the law `contact` is in contact.
    #[must_use]
    pub fn presses(&self) -> bool {
        self.contacts.state.first() == Some(&ContactWord::Contact)
    }

    /// Returns whether a limit of at least one joint is active or exceeded.
    #[must_use]
    pub fn is_at_limit(&self) -> bool {
        self.limits.iter().any(|limit| *limit != AtLimit::Free)
    }

    /// Returns a sample of zeros for the given number of joints, tasks, channels, axes in contact, and surfaces.
    #[cfg(feature = "files")]
    fn zeros(joints: usize, [tasks, channels, contacts, surfaces]: [usize; 4], sensed: bool) -> Self {
        let row = vec![0.0; joints];
        let zero =
            || Sensed { joint_position: row.clone(), joint_velocity: row.clone(), force: [0.0; 3], torque: [0.0; 3] };
        Self {
            sensed: sensed.then(|| Box::new(zero())),
            joint_position: row.clone(),
            joint_velocity: row.clone(),
            actual_velocity: row.clone(),
            residual_norms: vec![0.0; tasks],
            channels: vec![None; channels],
            contacts: Contacts::approaching(contacts, surfaces),
            limits: vec![AtLimit::Free; joints],
            ..Self::at_rest()
        }
    }

    /// Returns a sample of an arm without joints and without contact.
    pub fn at_rest() -> Self {
        Self {
            time_s: 0.0,
            joint_position: Vec::new(),
            joint_velocity: Vec::new(),
            actual_velocity: Vec::new(),
            position: [0.0; 3],
            orientation: [1.0, 0.0, 0.0, 0.0],
            position_error: [0.0; 3],
            force: [0.0; 3],
            torque: [0.0; 3],
            external_force: [0.0; 3],
            sensed: None,
            target_force: [None; 3],
            wall_distance: None,
            path: wire::Path::ClosedForm,
            status: wire::Status::Optimal,
            kkt_residual: Some(0.0),
            smallest_singular_value: 0.2,
            manipulability: 0.1,
            residual_norms: Vec::new(),
            channels: Vec::new(),
            contacts: Contacts::default(),
            least_distance: None,
            limits: Vec::new(),
            energy: Energy::default(),
            answered: true,
            answer_age: 0,
        }
    }
}
