//! What a run leaves behind.

use std::path::Path;
use std::{fmt, io};

use serde::Serialize;

pub use super::energy::Energy;
use crate::wire;

/// One run of a scenario.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Recording {
    /// Name of the scenario, as in `force_tracking`.
    pub scenario: String,
    /// How priorities were understood.
    pub method: wire::Method,
    /// How each period's problem was solved.
    pub solver: wire::Solver,
    /// T, s.
    pub period_s: f64,
    /// Real time that the run took, s.
    pub wall_time_s: f64,
    /// Joint names, n.
    pub joint_names: Vec<String>,
    /// What the contacts took and kept, from the start to the last sample.
    pub energy: Energy,
    /// One sample per control period.
    #[serde(skip)]
    pub samples: Vec<Sample>,
    /// How long each period's call took: apart from the samples, which are the same in every run.
    #[serde(skip)]
    pub timings: Vec<Timing>,
}

/// How long one call took.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Timing {
    /// From the state to its answer or failure, µs; 0 where no call was made.
    pub round_trip_us: f64,
    /// As the service says of the answer that the arm obeys, µs.
    pub elapsed_us: f64,
}

/// One control period, as measured before the command.
#[derive(Debug, Clone, PartialEq, Serialize)]
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
#[derive(Debug, Clone, PartialEq, Serialize)]
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
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
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

    /// File name of the trace.
    pub fn trace_name(&self) -> String {
        self.label() + ".csv"
    }

    /// Writes one row per control period; units stand in the column names.
    pub fn write_csv(&self, path: &Path) -> Result<(), csv::Error> {
        let mut file = io::BufWriter::new(std::fs::File::create(path)?);
        self.write_csv_header(&mut file)?;
        write_csv_rows(&self.samples, &mut file)?;
        Ok(io::Write::flush(&mut file)?)
    }

    /// Writes the names of the columns.
    pub fn write_csv_header(&self, out: impl io::Write) -> Result<(), csv::Error> {
        let mut table = csv::Writer::from_writer(out);
        table.write_record(self.columns())?;
        Ok(table.flush()?)
    }

    fn columns(&self) -> Vec<String> {
        let joints = |quantity: &str, unit: &str| {
            self.joint_names.iter().map(|name| format!("{quantity}_{name}_{unit}")).collect::<Vec<_>>()
        };
        let axes = |quantity: &str, unit: &str| ["x", "y", "z"].map(|axis| format!("{quantity}_{axis}_{unit}"));
        let tasks = self.samples.first().map_or(0, |sample| sample.residual_norms.len());
        let mut columns = vec!["time_s".to_owned()];
        columns.extend(joints("position", "rad"));
        columns.extend(joints("velocity", "rad_s"));
        columns.extend(axes("tool", "m"));
        columns.extend(axes("displacement", "m"));
        columns.extend(axes("force", "n"));
        columns.extend(axes("target_force", "n"));
        columns.extend(
            ["wall_distance_m", "path", "status", "kkt_residual", "smallest_singular_value"].map(str::to_owned),
        );
        columns.extend((1..=tasks).map(|k| format!("residual_task_{k}")));
        columns.push("answered".to_owned());
        columns.extend(joints("actual_velocity", "rad_s"));
        columns.extend(["w", "x", "y", "z"].map(|part| format!("orientation_{part}")));
        columns.extend(axes("torque", "n_m"));
        columns.extend(axes("external_force", "n"));
        columns.push("manipulability".to_owned());
        columns.extend(self.joint_names.iter().map(|name| format!("limit_{name}")));
        columns.extend(["work_j", "stored_j", "dissipated_j", "answer_age"].map(str::to_owned));
        if self.samples.first().is_some_and(|sample| sample.sensed.is_some()) {
            columns.extend(joints("sensed_position", "rad"));
            columns.extend(joints("sensed_velocity", "rad_s"));
            columns.extend(axes("sensed_force", "n"));
            columns.extend(axes("sensed_torque", "n_m"));
        }
        columns
    }
}

/// Writes one row per sample.
pub fn write_csv_rows(samples: &[Sample], out: impl io::Write) -> Result<(), csv::Error> {
    let mut table = csv::Writer::from_writer(out);
    samples.iter().try_for_each(|sample| table.write_record(cells(sample)))?;
    Ok(table.flush()?)
}

/// Numbers in the shortest form that reads back to the same bits.
fn cells(sample: &Sample) -> Vec<String> {
    let number = |value: &f64| value.to_string();
    let optional = |value: &Option<f64>| value.map(|value| value.to_string()).unwrap_or_default();
    let mut cells = vec![number(&sample.time_s)];
    cells.extend(sample.joint_position.iter().map(number));
    cells.extend(sample.joint_velocity.iter().map(number));
    cells.extend(sample.position.iter().chain(&sample.position_error).chain(&sample.force).map(number));
    cells.extend(sample.target_force.iter().map(optional));
    cells.push(optional(&sample.wall_distance));
    cells.push(sample.path.to_string());
    cells.push(sample.status.to_string());
    cells.push(optional(&sample.kkt_residual));
    cells.push(number(&sample.smallest_singular_value));
    cells.extend(sample.residual_norms.iter().map(number));
    cells.push(sample.answered.to_string());
    cells.extend(sample.actual_velocity.iter().map(number));
    cells.extend(sample.orientation.iter().chain(&sample.torque).chain(&sample.external_force).map(number));
    cells.push(number(&sample.manipulability));
    cells.extend(sample.limits.iter().map(AtLimit::to_string));
    cells.extend([sample.energy.work_j, sample.energy.stored_j, sample.energy.dissipated_j].iter().map(number));
    cells.push(sample.answer_age.to_string());
    if let Some(sensed) = &sample.sensed {
        let joints = sensed.joint_position.iter().chain(&sensed.joint_velocity);
        cells.extend(joints.chain(&sensed.force).chain(&sensed.torque).map(number));
    }
    cells
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
            samples: Vec::new(),
            timings: Vec::new(),
        }
    }
}

#[cfg(test)]
impl Sample {
    /// An arm without joints that touches nothing, for tests to fill in.
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
