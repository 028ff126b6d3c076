//! The columns of a recording's tables.

use super::cell::Value;
use super::error::ReadError;
use super::quantity::{Per, Presence, QUANTITIES, Quantity};
use super::{Recording, Sample, Timing};

/// One column of a table.
pub struct Column {
    /// Quantity, joint or axis or task, unit: `force_x_n`.
    pub name: String,
    /// What stands in it.
    pub quantity: &'static Quantity,
    /// For which joint, axis or task.
    place: usize,
}

/// What decides about the columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Extent<'a> {
    /// n names.
    pub joints: &'a [String],
    /// Number of tasks.
    pub tasks: usize,
    /// Whether the controller was told something else than the true state.
    pub sensed: bool,
    /// Whether the clock on the wall is asked for.
    pub timed: bool,
}

impl<'a> Extent<'a> {
    /// That of a recording.
    pub fn of(recording: &'a Recording, timed: bool) -> Self {
        let first = recording.samples.first();
        Self {
            joints: &recording.joint_names,
            tasks: first.map_or(0, |sample| sample.residual_norms.len()),
            sensed: first.is_some_and(|sample| sample.sensed.is_some()),
            timed,
        }
    }

    /// That of a table, by the names of its columns.
    pub fn of_names<'n>(joints: &'a [String], names: &(impl Iterator<Item = &'n str> + Clone)) -> Self {
        let count = |start: &str| names.clone().filter(|name| name.starts_with(start)).count();
        Self { joints, tasks: count("residual_task_"), sensed: count("sensed_") > 0, timed: count("round_trip_us") > 0 }
    }

    /// A sample of that extent, to be filled.
    pub fn blank(&self) -> (Sample, Timing) {
        (Sample::blank(self.joints.len(), self.tasks, self.sensed), Timing::default())
    }

    /// All columns.
    pub fn columns(&self) -> Vec<Column> {
        let shown = |quantity: &&Quantity| match quantity.presence {
            Presence::Always => true,
            Presence::Sensed => self.sensed,
            Presence::Timed => self.timed,
        };
        QUANTITIES.iter().filter(shown).flat_map(|quantity| self.columns_of(quantity)).collect()
    }

    fn columns_of(&self, quantity: &'static Quantity) -> Vec<Column> {
        let words = |words: &[&str]| words.iter().map(|&word| word.to_owned()).collect();
        let labels: Vec<String> = match quantity.per {
            Per::Period => words(&[""]),
            Per::Joint => self.joints.to_vec(),
            Per::Axis => words(&["x", "y", "z"]),
            Per::QuaternionPart => words(&["w", "x", "y", "z"]),
            Per::Task => (1..=self.tasks).map(|k| k.to_string()).collect(),
        };
        let column = |(place, label): (usize, String)| {
            let parts = [quantity.name, &label, quantity.unit];
            let name = parts.into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join("_");
            Column { name, quantity, place }
        };
        labels.into_iter().enumerate().map(column).collect()
    }
}

impl Column {
    /// The value of a period; missing where the sample has no such joint or task.
    pub fn value(&self, recording: &Recording, row: usize) -> Value {
        let timing = recording.timings.get(row).copied().unwrap_or_default();
        (self.quantity.of)(&recording.samples[row], &timing, self.place).unwrap_or(Value::Missing)
    }

    /// Puts a value, `None` if it cannot be read, into a period of a table: its row, from 0.
    pub fn put(
        &self,
        row: usize,
        (sample, timing): (&mut Sample, &mut Timing),
        value: Option<Value>,
    ) -> Result<(), ReadError> {
        let taken = value.is_some_and(|value| (self.quantity.put)(sample, timing, self.place, value));
        if taken { Ok(()) } else { Err(ReadError::Value { row: row + 1, column: self.name.clone() }) }
    }
}
