//! The table of a sweep: one row per cell, one column per varied quantity and measure.

use revprio_api::wire;
use serde_json::Value as Json;

use super::plan::Cell;
use super::values::Variation;
use crate::metrics::Metrics;
use crate::simulator::recording::{Kind, Recording, Value};

/// A measure: name of its column, and its value for a run.
type Measure = (&'static str, fn(&Metrics, &Recording) -> Option<f64>);

/// All measures of a finished run.
pub const MEASURES: [Measure; 17] = [
    ("rmse_force_x_n", |metrics, _| metrics.rmse_fx),
    ("rmse_force_y_n", |metrics, _| metrics.rmse_fy),
    ("overshoot_n", |metrics, _| metrics.overshoot.map(|overshoot| overshoot.newton)),
    ("overshoot_percent", |metrics, _| metrics.overshoot.map(|overshoot| overshoot.percent)),
    ("settling_time_s", |metrics, _| metrics.settling_time_s),
    ("final_force_x_n", |metrics, _| metrics.final_force),
    ("peak_force_x_n", |metrics, _| Some(metrics.peak_force)),
    ("first_contact_s", |metrics, _| metrics.first_contact_s),
    ("contacts", |metrics, _| Some(metrics.contacts as f64)),
    ("largest_joint_speed_rad_s", |metrics, _| Some(metrics.max_joint_speed)),
    ("least_distance_m", |metrics, _| metrics.least_distance_m),
    ("periods", |_, recording| Some(recording.samples.len() as f64)),
    ("periods_closed_form", |metrics, _| Some(periods(metrics, wire::Path::ClosedForm))),
    ("periods_active_set", |metrics, _| Some(periods(metrics, wire::Path::ActiveSet))),
    ("periods_qp", |metrics, _| Some(periods(metrics, wire::Path::Qp))),
    ("periods_not_optimal", |_, recording| {
        Some(recording.samples.iter().filter(|sample| sample.status != wire::Status::Optimal).count() as f64)
    }),
    ("energy_dissipated_j", |_, recording| Some(recording.energy.dissipated_j)),
];

fn periods(metrics: &Metrics, path: wire::Path) -> f64 {
    metrics.paths.get(&path).copied().unwrap_or(0) as f64
}

/// Outcome of a cell.
pub enum Outcome {
    /// The run finished.
    Finished(Box<Recording>),
    /// The scenario was refused or the run ended early: a word and the reason.
    Failed(&'static str, String),
}

/// Columns between the varied quantities and the measures.
const STATE: [(&str, Kind); 3] = [("outcome", Kind::Word), ("error", Kind::Word), ("warnings", Kind::Word)];

/// Returns all columns.
pub fn columns(variations: &[Variation]) -> Vec<(String, Kind)> {
    let varied = variations.iter().map(|variation| (variation.path.clone(), kind(variation)));
    let state = STATE.map(|(name, kind)| (name.to_owned(), kind));
    let measures = MEASURES.map(|(name, _)| (name.to_owned(), Kind::OptionalNumber));
    std::iter::once(("cell".to_owned(), Kind::Count)).chain(varied).chain(state).chain(measures).collect()
}

fn kind(variation: &Variation) -> Kind {
    let all = |is: fn(&Json) -> bool| variation.values.iter().all(is);
    if all(Json::is_u64) {
        Kind::Count
    } else if all(Json::is_number) {
        Kind::Number
    } else if all(Json::is_boolean) {
        Kind::Flag
    } else {
        Kind::Word
    }
}

/// Returns the row of a cell.
pub fn row(variations: &[Variation], cell: &Cell, warnings: &[String], outcome: &Outcome) -> Vec<Value> {
    let varied = variations.iter().zip(&cell.values).map(|(variation, value)| varied(kind(variation), value));
    // A row must be one line of the partial file.
    let line = |text: &str| Value::Word(text.replace(['\n', '\r'], " "));
    let (word, error) = match outcome {
        Outcome::Finished(_) => ("finished", ""),
        Outcome::Failed(word, error) => (*word, error.as_str()),
    };
    let state = [line(word), line(error), line(&warnings.join("; "))];
    let measures = match outcome {
        Outcome::Finished(recording) => {
            let metrics = Metrics::of(recording);
            MEASURES.map(|(_, of)| of(&metrics, recording).map_or(Value::Missing, Value::Number))
        }
        Outcome::Failed(..) => MEASURES.map(|_| Value::Missing),
    };
    std::iter::once(Value::Count(cell.index as u64)).chain(varied).chain(state).chain(measures).collect()
}

fn varied(kind: Kind, value: &Json) -> Value {
    match (kind, value) {
        (Kind::Count, value) => Value::Count(value.as_u64().unwrap_or(0)),
        (Kind::Number, value) => Value::Number(value.as_f64().unwrap_or(f64::NAN)),
        (Kind::Flag, value) => Value::Flag(value.as_bool().unwrap_or(false)),
        (_, Json::String(word)) => Value::Word(word.clone()),
        (_, value) => Value::Word(value.to_string()),
    }
}
