//! A trace in CSV, as far as the report needs it: the columns that it does not name stay empty.

use std::collections::BTreeMap;
use std::path::Path;

use serde::de::DeserializeOwned;

use crate::report::Error;
use crate::simulator::Scenario;
use crate::simulator::recording::{AtLimit, Energy, Recording, Sample};
use crate::wire;

/// The recording that a run of this scenario and arm left.
///
/// # Errors
///
/// [`Error::Trace`] for a file that is no such trace; it says the column or the line.
pub fn read(path: &Path, scenario: &Scenario, robot: &wire::Robot, wall_time_s: f64) -> Result<Recording, Error> {
    let joint_names: Vec<String> = robot.joints.iter().map(|joint| joint.name.clone()).collect();
    let refuse = |problem: String| Error::Trace { path: path.to_owned(), problem };
    let mut reader = csv::Reader::from_path(path).map_err(|error| refuse(error.to_string()))?;
    let heads = reader.headers().map_err(|error| refuse(error.to_string()))?.clone();
    let columns: BTreeMap<&str, usize> = heads.iter().enumerate().map(|(i, head)| (head, i)).collect();
    let mut samples = Vec::new();
    for (i, record) in reader.records().enumerate() {
        let record = record.map_err(|error| refuse(error.to_string()))?;
        let row = Row { columns: &columns, record: &record };
        let sample = row.sample(&joint_names).map_err(|column| {
            refuse(format!("line {}: column `{column}` is missing or is not what it should be", i + 2))
        })?;
        samples.push(sample);
    }
    Ok(Recording {
        scenario: scenario.name.clone(),
        method: scenario.controller.method,
        solver: scenario.controller.solver,
        period_s: scenario.period_s(),
        wall_time_s,
        joint_names,
        energy: samples.last().map_or_else(Energy::default, |sample: &Sample| sample.energy),
        samples,
        timings: Vec::new(),
    })
}

/// One period. What it does not find it names.
struct Row<'a> {
    columns: &'a BTreeMap<&'a str, usize>,
    record: &'a csv::StringRecord,
}

const AXES: [&str; 3] = ["x", "y", "z"];

impl Row<'_> {
    fn sample(&self, joints: &[String]) -> Result<Sample, String> {
        let of_joints = |quantity: &str, unit: &str| {
            joints.iter().map(|name| self.number(&format!("{quantity}_{name}_{unit}"))).collect::<Result<Vec<_>, _>>()
        };
        let tasks =
            (1..).map(|k| format!("residual_task_{k}")).take_while(|name| self.columns.contains_key(name.as_str()));
        Ok(Sample {
            time_s: self.number("time_s")?,
            joint_position: of_joints("position", "rad")?,
            joint_velocity: of_joints("velocity", "rad_s")?,
            actual_velocity: of_joints("actual_velocity", "rad_s")?,
            position: self.axes("tool", "m")?,
            orientation: [1.0, 0.0, 0.0, 0.0],
            position_error: self.axes("displacement", "m")?,
            force: self.axes("force", "n")?,
            torque: [0.0; 3],
            external_force: [0.0; 3],
            sensed: None,
            target_force: self.targets()?,
            wall_distance: self.optional("wall_distance_m")?,
            path: self.word("path")?,
            status: self.word("status")?,
            kkt_residual: self.optional("kkt_residual")?,
            smallest_singular_value: self.number("smallest_singular_value")?,
            manipulability: self.number("manipulability")?,
            residual_norms: tasks.map(|name| self.number(&name)).collect::<Result<_, _>>()?,
            limits: joints.iter().map(|name| self.limit(&format!("limit_{name}"))).collect::<Result<_, _>>()?,
            energy: Energy::default(),
            answered: self.text("answered")? == "true",
            answer_age: 0,
        })
    }

    fn text(&self, column: &str) -> Result<&str, String> {
        let place = self.columns.get(column).copied();
        place.and_then(|place| self.record.get(place)).ok_or_else(|| column.to_owned())
    }

    fn number(&self, column: &str) -> Result<f64, String> {
        self.text(column)?.parse().map_err(|_| column.to_owned())
    }

    fn optional(&self, column: &str) -> Result<Option<f64>, String> {
        if self.text(column)?.is_empty() { Ok(None) } else { self.number(column).map(Some) }
    }

    fn word<T: DeserializeOwned>(&self, column: &str) -> Result<T, String> {
        serde_json::from_value(self.text(column)?.into()).map_err(|_| column.to_owned())
    }

    fn limit(&self, column: &str) -> Result<AtLimit, String> {
        let known = [AtLimit::Free, AtLimit::Lower, AtLimit::Upper, AtLimit::Below, AtLimit::Above];
        let text = self.text(column)?;
        known.into_iter().find(|limit| limit.to_string() == text).ok_or_else(|| column.to_owned())
    }

    fn axes(&self, quantity: &str, unit: &str) -> Result<[f64; 3], String> {
        let mut values = [0.0; 3];
        for (value, axis) in values.iter_mut().zip(AXES) {
            *value = self.number(&format!("{quantity}_{axis}_{unit}"))?;
        }
        Ok(values)
    }

    fn targets(&self) -> Result<[Option<f64>; 3], String> {
        let mut values = [None; 3];
        for (value, axis) in values.iter_mut().zip(AXES) {
            *value = self.optional(&format!("target_force_{axis}_n"))?;
        }
        Ok(values)
    }
}
