//! Columns of the tables of a recording.

use super::cell::Value;
use super::error::ReadError;
use super::quantity::{Kind, Per, Presence, QUANTITIES, Quantity};
use super::{Recording, Sample, Timing};

/// One column of a table.
pub struct Column {
    /// Name: quantity, then joint, axis or task, then unit, for example `force_x_n`.
    pub name: String,
    /// The quantity.
    pub quantity: &'static Quantity,
    /// Index of the joint, axis or task.
    index: usize,
}

/// The properties of a recording that determine its columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TableLayout<'a> {
    /// Joint names, n.
    pub joints: &'a [String],
    /// Number of tasks.
    pub tasks: usize,
    /// Number of channels.
    pub channels: usize,
    /// Number of axes with the law `contact`.
    pub contacts: usize,
    /// Number of these axes if one of them follows a surface, otherwise 0.
    pub surfaces: usize,
    /// Whether the controller watches distances.
    pub watched: bool,
    /// Whether the controller received other values than the true state.
    pub sensed: bool,
    /// Whether real times are included.
    pub timed: bool,
}

impl<'a> TableLayout<'a> {
    /// Returns the layout of a recording.
    pub fn from_recording(recording: &'a Recording, timed: bool) -> Self {
        let first = recording.samples.first();
        // An operator may change the controller in the middle.
        let most = |count: fn(&Sample) -> usize| recording.samples.iter().map(count).max().unwrap_or(0);
        Self {
            joints: &recording.joint_names,
            tasks: first.map_or(0, |sample| sample.residual_norms.len()),
            channels: most(|sample| sample.channels.len()),
            contacts: most(|sample| sample.contacts.axes()),
            surfaces: most(|sample| sample.contacts.surface.normal.len()),
            watched: recording.watches_distances(),
            sensed: first.is_some_and(|sample| sample.sensed.is_some()),
            timed,
        }
    }

    /// Returns the layout of a table with these column names.
    pub fn from_column_names<'n>(joints: &'a [String], names: &(impl Iterator<Item = &'n str> + Clone)) -> Self {
        let count = |start: &str| names.clone().filter(|name| name.starts_with(start)).count();
        Self {
            joints,
            tasks: count("residual_task_"),
            channels: count("channel_"),
            contacts: count("contact_state_"),
            surfaces: count("contact_friction_"),
            watched: count("least_distance") > 0,
            sensed: count("sensed_") > 0,
            timed: count("round_trip_us") > 0,
        }
    }

    /// Returns an empty sample with this layout.
    pub fn empty_sample(&self) -> (Sample, Timing) {
        let counts = [self.tasks, self.channels, self.contacts, self.surfaces];
        (Sample::zeros(self.joints.len(), counts, self.sensed), Timing::default())
    }

    /// Returns all columns.
    pub fn columns(&self) -> Vec<Column> {
        let shown = |quantity: &&Quantity| match quantity.presence {
            Presence::Always => true,
            Presence::Surface => self.surfaces > 0,
            Presence::Watched => self.watched,
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
            Per::Channel => (1..=self.channels).map(|k| k.to_string()).collect(),
            Per::Contact => (1..=self.contacts).map(|k| k.to_string()).collect(),
            Per::ContactAxis => {
                (1..=self.contacts).flat_map(|k| ["x", "y", "z"].map(|axis| format!("{k}_{axis}"))).collect()
            }
        };
        let column = |(index, label): (usize, String)| {
            let parts = [quantity.name, &label, quantity.unit];
            let name = parts.into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join("_");
            Column { name, quantity, index }
        };
        labels.into_iter().enumerate().map(column).collect()
    }
}

impl Column {
    /// Returns the value of a period; missing if the sample has no such joint or task.
    pub fn value(&self, recording: &Recording, row: usize) -> Value {
        let timing = recording.timings.get(row).copied().unwrap_or_default();
        (self.quantity.get)(&recording.samples[row], &timing, self.index).unwrap_or(Value::Missing)
    }

    /// Sets the value of a period; returns false if it has another kind.
    pub fn set(&self, (sample, timing): (&mut Sample, &mut Timing), value: Value) -> bool {
        (self.quantity.set)(sample, timing, self.index, value)
    }

    /// Returns the error of a value that is not of this column; `row` from 0.
    pub fn refused(&self, row: usize, text: &str) -> ReadError {
        let expected = match self.quantity.kind {
            Kind::Number => "a number",
            Kind::OptionalNumber => "a number or nothing",
            Kind::Count => "a number without sign and fraction",
            Kind::Flag => "true or false",
            Kind::Word => "a word that this column can have",
        };
        ReadError::Value { row: row + 1, column: self.name.clone(), expected, text: text.to_owned() }
    }
}
