//! What a run leaves behind, and the files that keep it.
//!
//! ```text
//! Recording ─→ columns (one line per quantity) ─→ CSV, Parquet ─┐
//!           └→ samples as JSON ────────────→ JSON lines, MCAP ──┴→ read: the same Recording, to the last bit
//! ```

mod cell;
mod columns;
mod csv_table;
mod error;
mod format;
mod head;
mod json_lines;
mod mcap_log;
pub mod parquet_file;
mod parquet_table;
mod quantity;

use std::fmt;

use serde::{Deserialize, Serialize};

pub use super::energy::Energy;
use super::scenario::Scenario;
use revprio_api::wire;

pub use cell::Value;
pub use columns::{Column, Extent};
pub use csv_table::{cell_text, cell_value};
pub use error::{ReadError, WriteError};
pub use format::{Format, Writer, read};
pub use json_lines::write_object;
pub use quantity::{Kind, Per, Presence, QUANTITIES, Quantity};

/// One run of a scenario.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Recording {
    /// Name of the scenario, as in `force_tracking`.
    pub scenario: String,
    /// How priorities were understood.
    pub method: wire::Method,
    /// How each period's problem was solved.
    pub solver: wire::Solver,
    /// T, s.
    pub period_s: f64,
    /// Real time that the run took, s; 0 where a file does not tell.
    #[serde(default)]
    pub wall_time_s: f64,
    /// Joint names, n.
    pub joint_names: Vec<String>,
    /// What the contacts took and kept, from the start to the last sample.
    pub energy: Energy,
    /// All of the scenario, controller included, as it was run.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub setup: Option<Box<Scenario>>,
    /// One sample per control period.
    #[serde(skip)]
    pub samples: Vec<Sample>,
    /// How long each period's call took: apart from the samples, which are the same in every run. Empty where a file does
    /// not tell.
    #[serde(skip)]
    pub timings: Vec<Timing>,
}

/// How long one call took.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Timing {
    /// From the state to its answer or failure, µs; 0 where no call was made.
    pub round_trip_us: f64,
    /// As the service says of the answer that the arm obeys, µs.
    pub elapsed_us: f64,
}

/// One control period, as measured before the command.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// Simulated time, s.
    pub time_s: f64,
    /// q, n, rad or m.
    pub joint_position: Vec<f64>,
    /// q̇ as commanded for this period, n, rad/s or m/s.
    pub joint_velocity: Vec<f64>,
    /// q̇ at which the arm moves, n, rad/s or m/s.
    pub actual_velocity: Vec<f64>,
    /// Tool position in the base frame, m.
    pub position: [f64; 3],
    /// Orientation of the tool in the base frame, a unit quaternion w, x, y, z.
    pub orientation: [f64; 4],
    /// Tool position minus start position, m.
    pub position_error: [f64; 3],
    /// F_e on the environment and on whoever pushes the tool, base axes, N.
    pub force: [f64; 3],
    /// Its torque at the tool point, N·m.
    pub torque: [f64; 3],
    /// Part of −F_e with which somebody pushes the tool, N.
    pub external_force: [f64; 3],
    /// What the controller was told; `None` where that is q, q̇, and F_e as above.
    pub sensed: Option<Box<Sensed>>,
    /// F_d, N, `None` where the axis is not force-controlled.
    pub target_force: [Option<f64>; 3],
    /// Distance to the wall, m, positive when free; `None` without a wall.
    #[serde(rename = "wall_distance_m")]
    pub wall_distance: Option<f64>,
    /// Which way led to the command.
    pub path: wire::Path,
    /// How sure the command is.
    pub status: wire::Status,
    /// Residual of the optimality conditions.
    pub kkt_residual: Option<f64>,
    /// σ_min of all task rows together.
    pub smallest_singular_value: f64,
    /// Product of their singular values.
    pub manipulability: f64,
    /// ‖J_k q̇ − ẋ_k‖ per task, highest priority first.
    pub residual_norms: Vec<f64>,
    /// How each joint stands to its limits, n.
    pub limits: Vec<AtLimit>,
    /// What the contacts took and kept so far.
    pub energy: Energy,
    /// Whether an answer came in this period; if not, what is said of the answer is that of the last one.
    pub answered: bool,
    /// Periods since the state was measured to which the answer belongs; 0 where it is this one's.
    pub answer_age: u64,
}

/// A state as the controller was told it, to the bit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Sensed {
    /// q, n, rad or m.
    pub joint_position: Vec<f64>,
    /// q̇, n, rad/s or m/s.
    pub joint_velocity: Vec<f64>,
    /// Force with the sign and along the axes that the controller expects, N.
    pub force: [f64; 3],
    /// Torque, likewise, N·m.
    pub torque: [f64; 3],
}

/// How a commanded joint velocity stands to its bounds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AtLimit {
    /// Between them, or not held back by them.
    Free,
    /// Held back by the lower one.
    Lower,
    /// Held back by the upper one.
    Upper,
    /// Below the lower one.
    Below,
    /// Above the upper one.
    Above,
}

impl fmt::Display for AtLimit {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        self.serialize(formatter)
    }
}

impl AtLimit {
    /// Of each joint, by what the answer says of them; n.
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
    /// Scenario, method and solver in one word, for file names.
    pub fn label(&self) -> String {
        format!("{}-{}-{}", self.scenario, self.method, self.solver)
    }

    /// File name of the trace in a format.
    pub fn trace_name(&self, format: Format) -> String {
        format!("{}.{}", self.label(), format.ending())
    }

    fn push(&mut self, sample: Sample, timing: Timing, timed: bool) {
        self.samples.push(sample);
        if timed {
            self.timings.push(timing);
        }
    }
}

#[cfg(test)]
impl Recording {
    /// A run of nothing, for tests to fill in.
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
            samples: Vec::new(),
            timings: Vec::new(),
        }
    }
}

impl Sample {
    /// A sample of that many joints and tasks, to be filled in.
    fn blank(joints: usize, tasks: usize, sensed: bool) -> Self {
        let row = vec![0.0; joints];
        let nothing =
            || Sensed { joint_position: row.clone(), joint_velocity: row.clone(), force: [0.0; 3], torque: [0.0; 3] };
        Self {
            sensed: sensed.then(|| Box::new(nothing())),
            joint_position: row.clone(),
            joint_velocity: row.clone(),
            actual_velocity: row.clone(),
            residual_norms: vec![0.0; tasks],
            limits: vec![AtLimit::Free; joints],
            ..Self::at_rest()
        }
    }

    /// An arm without joints that touches nothing, to be filled in.
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
            limits: Vec::new(),
            energy: Energy::default(),
            answered: true,
            answer_age: 0,
        }
    }
}
