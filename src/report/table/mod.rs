//! The results table: one definition of its columns for the terminal and for the page.

use crate::simulator::recording::Recording;
use crate::wire::{Method, Path, Solver};

use super::metrics::{Metrics, Overshoot, largest_difference};
use super::number::significant;

/// The solver that the others are compared with.
const REFERENCE_SOLVER: Solver = Solver::ClosedForm;
/// Stands where a quantity does not exist.
const NOTHING: &str = "–";

/// One run in the table.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Scenario, as named on the command line.
    pub scenario: String,
    /// Method, as in the recording.
    pub method: Method,
    /// Solver, as in the recording.
    pub solver: Solver,
    /// Measures of the run.
    pub metrics: Metrics,
    /// Largest difference of the commands (rad/s) from the closed form of the same scenario and
    /// method; `None` for the closed form itself and where it was not run.
    pub largest_difference: Option<f64>,
}

/// A column of the table.
#[derive(Debug, Clone, Copy)]
pub struct Column {
    /// Heading; `F_x` sets an index.
    pub heading: &'static str,
    /// Unit, empty without one.
    pub unit: &'static str,
    /// What the column means, for the page; empty where the heading says it.
    pub meaning: &'static str,
    /// Whether cells are set flush right.
    pub is_number: bool,
    /// Content of the cell in a row.
    pub cell: fn(&Row) -> String,
}

/// The columns, from left to right; the first one names what the rows are grouped by.
pub static COLUMNS: [Column; 11] = [
    name("scenario", |row| row.scenario.clone()),
    name("method", |row| row.method.to_string().replace('_', " ")),
    name("solver", |row| row.solver.to_string().replace('_', " ")),
    number("RMSE F_x", "N", RMSE, |row| optional(row.metrics.rmse_fx, 3)),
    number("RMSE F_y", "N", "", |row| optional(row.metrics.rmse_fy, 3)),
    number("overshoot F_x", "N (%)", OVERSHOOT, |row| overshoot(row.metrics.overshoot)),
    number("settling", "s", SETTLING, |row| optional(row.metrics.settling_time_s, 3)),
    number("final F_x", "N", FINAL, |row| optional(row.metrics.final_force, 5)),
    number("vs closed form", "rad/s", DIFFERENCE, |row| optional(row.largest_difference, 2)),
    number("solved by", "periods", PATHS, |row| paths(&row.metrics)),
    number("calls", "1/s", CALLS, |row| optional(row.metrics.calls_per_second, 3)),
];

const RMSE: &str = "root mean square of the force minus its target, from 5 s on in a run longer than 10 s, \
     otherwise from the first contact on";
const OVERSHOOT: &str = "largest excess of the force over the target of the same instant, from the first contact on";
const SETTLING: &str = "simulated time from which the force stays within 5 % of its target until the end, and for 0.1 s \
     at least";
const FINAL: &str = "force of the last sample";
const DIFFERENCE: &str = "largest difference of any joint's commanded velocity, over all samples, from the closed form of \
     the same scenario and method";
const PATHS: &str = "how many control periods each path served: the closed form inside the limits, a known set of active \
     limits that proved right, or a solver at every level (`qp`)";
const CALLS: &str = "control periods per second of real time, simulation and transport included";

const fn name(heading: &'static str, cell: fn(&Row) -> String) -> Column {
    Column { heading, unit: "", meaning: "", is_number: false, cell }
}

const fn number(heading: &'static str, unit: &'static str, meaning: &'static str, cell: fn(&Row) -> String) -> Column {
    Column { heading, unit, meaning, is_number: true, cell }
}

/// A row per recording, in the order of the recordings.
#[must_use]
pub fn rows(recordings: &[Recording]) -> Vec<Row> {
    let row = |run: &Recording| Row {
        scenario: run.scenario.clone(),
        method: run.method,
        solver: run.solver,
        metrics: Metrics::of(run),
        largest_difference: reference(run, recordings).map(|other| largest_difference(run, other)),
    };
    recordings.iter().map(row).collect()
}

/// The table as aligned text, a line per row and two for the headings.
#[must_use]
pub fn text(rows: &[Row]) -> String {
    let columns = COLUMNS.each_ref().map(|column| Aligned::new(column, rows));
    let line = |i: usize| columns.iter().map(|c| c.cells[i].as_str()).collect::<Vec<_>>().join("  ");
    (0..rows.len() + 2).map(|i| line(i).trim_end().to_owned() + "\n").collect()
}

/// Heading, unit and cells of a column, padded to one width.
struct Aligned {
    cells: Vec<String>,
}

impl Aligned {
    fn new(column: &Column, rows: &[Row]) -> Self {
        let heads = [column.heading.to_owned(), column.unit.to_owned()];
        let cells: Vec<_> = heads.into_iter().chain(rows.iter().map(column.cell)).collect();
        let width = cells.iter().map(|cell| cell.chars().count()).max().unwrap_or(0);
        let pad = |cell: String| {
            if column.is_number { format!("{cell:>width$}") } else { format!("{cell:<width$}") }
        };
        Self { cells: cells.into_iter().map(pad).collect() }
    }
}

/// The closed-form run to compare a run of another solver with.
fn reference<'a>(run: &Recording, recordings: &'a [Recording]) -> Option<&'a Recording> {
    let same = |other: &&Recording| {
        other.scenario == run.scenario
            && other.method == run.method
            && other.solver == REFERENCE_SOLVER
            && run.solver != REFERENCE_SOLVER
    };
    recordings.iter().find(same)
}

fn optional(value: Option<f64>, digits: usize) -> String {
    value.map_or_else(|| NOTHING.to_owned(), |v| significant(v, digits))
}

fn paths(metrics: &Metrics) -> String {
    let served = |(path, periods): (&Path, &usize)| format!("{} {periods}", path.to_string().replace('_', " "));
    metrics.paths.iter().map(served).collect::<Vec<_>>().join(", ")
}

fn overshoot(value: Option<Overshoot>) -> String {
    value
        .map_or_else(|| NOTHING.to_owned(), |o| format!("{} ({})", significant(o.newton, 3), significant(o.percent, 3)))
}

#[cfg(test)]
mod tests;
