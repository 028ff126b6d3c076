//! What a run leaves behind.

use std::io;
use std::path::Path;

use serde::Serialize;

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
    /// One sample per control period.
    #[serde(skip)]
    pub samples: Vec<Sample>,
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
    /// Tool position in the base frame, m.
    pub position: [f64; 3],
    /// Tool position minus start position, m.
    pub position_error: [f64; 3],
    /// F_e on the environment, N.
    pub force: [f64; 3],
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
    /// ‖J_k q̇ − ẋ_k‖ per task, highest priority first.
    pub residual_norms: Vec<f64>,
    /// Whether the service answered in this period; if not, what is said of the answer is that of the last one.
    pub answered: bool,
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
    cells
}
