//! The results: one definition of every quantity for the terminal, for markdown and for the page.
//!
//! [`text`] sets the most important ones with a row per run; [`side_by_side`] sets all of them with a column per run of
//! one scenario.

pub mod side_by_side;

use std::collections::BTreeMap;
use std::fmt::Display;

use revprio_api::wire::{Method, Solver};
use serde::Serialize;

use super::experiment::Run;
use super::metrics::limits::LimitUse;
use super::metrics::{Metrics, Overshoot, Residual, largest_difference, main_axis};
use super::number::significant;
use crate::simulator::recording::Recording;

/// The solver that the others are compared with.
const REFERENCE_SOLVER: Solver = Solver::ClosedForm;
/// Stands where a quantity does not exist.
pub const NOTHING: &str = "–";

/// One run in the table.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// Scenario, as named on the command line.
    pub scenario: String,
    /// Method, as in the recording.
    pub method: Method,
    /// Solver, as in the recording.
    pub solver: Solver,
    /// The axis that the forces in `metrics` are along, 0 = x.
    pub axis: usize,
    /// Measures of the run.
    pub metrics: Metrics,
    /// What it made of its limits.
    pub limits: LimitUse,
    /// Largest difference of the commands (rad/s) from the closed form of the same scenario and
    /// method; `None` for the closed form itself and where it was not run.
    pub largest_difference: Option<f64>,
}

impl Row {
    /// The method for people.
    #[must_use]
    pub fn method_name(&self) -> String {
        words(self.method)
    }

    /// The solver for people.
    #[must_use]
    pub fn solver_name(&self) -> String {
        words(self.solver)
    }
}

/// A quantity of the table.
#[derive(Debug, Clone, Copy)]
pub struct Quantity {
    /// Heading; `F_x` sets an index, and `F` alone is the force along the axis of the row.
    pub heading: &'static str,
    /// Unit, empty without one.
    pub unit: &'static str,
    /// What it means, for the page; empty where the heading says it.
    pub meaning: &'static str,
    /// Whether cells are set flush right.
    pub is_number: bool,
    /// Where it stands.
    pub place: Place,
    /// Content of the cell in a row.
    pub cell: fn(&Row) -> String,
}

/// Where a quantity stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// Names a run: in every table, as its head.
    Head,
    /// In every table.
    Everywhere,
    /// Only side by side.
    SideBySide,
    /// Time of the machine: in every table but those of documents, which are the same wherever they are made.
    Machine,
}

/// All quantities; the first one names what the rows are grouped by.
pub static QUANTITIES: [Quantity; 24] = [
    head("scenario", |row| row.scenario.clone()),
    head("method", Row::method_name),
    head("solver", Row::solver_name),
    more("first contact", "s", "", |row| optional(row.metrics.first_contact_s, 3)),
    more("contacts", "", CONTACTS, |row| row.metrics.contacts.to_string()),
    more("peak F", "N", "", |row| significant(row.metrics.peak_force, 4)),
    main("RMSE F_x", "N", RMSE, |row| optional(row.metrics.rmse_fx, 3)),
    main("RMSE F_y", "N", "", |row| optional(row.metrics.rmse_fy, 3)),
    more("RMSE F_z", "N", "", |row| optional(row.metrics.rmse_fz, 3)),
    main("overshoot F", "N (%)", OVERSHOOT, |row| overshoot(row.metrics.overshoot)),
    main("settling", "s", SETTLING, |row| optional(row.metrics.settling_time_s, 3)),
    more("steady error F", "N", STEADY, |row| optional(row.metrics.steady_error, 2)),
    main("final F", "N", FINAL, |row| optional(row.metrics.final_force, 5)),
    more("residual of each task, RMS", RESIDUAL_UNIT, RESIDUAL, |row| residuals(row, |residual| residual.rms)),
    more("residual of each task, largest", RESIDUAL_UNIT, "", |row| residuals(row, |residual| residual.largest)),
    more("largest joint speed", "rad/s", "", |row| significant(row.metrics.max_joint_speed, 3)),
    more("of what that joint may do", "%", SPEED_USE, |row| percent(row.limits.speed_use)),
    more("time at limits", "s", AT_LIMITS, |row| significant(row.limits.at_limits_s, 3)),
    main("limits broken by", "", BROKEN, |row| broken(&row.limits)),
    main("solved by", "periods", PATHS, |row| counted(&row.metrics.paths)),
    more("status", "periods", STATUS, |row| counted(&row.metrics.statuses)),
    more("largest KKT residual", "", KKT, |row| optional(row.metrics.largest_kkt_residual, 2)),
    main("vs closed form", "rad/s", DIFFERENCE, |row| optional(row.largest_difference, 2)),
    Quantity { place: Place::Machine, ..more("calls", "1/s", CALLS, |row| optional(row.metrics.calls_per_second, 3)) },
];

const CONTACTS: &str = "separate intervals in contact: at a wall or, without one, under a force";
const RMSE: &str = "root mean square of the force minus its target, from 5 s on in a run longer than 10 s, \
     otherwise from the first contact on";
const OVERSHOOT: &str = "largest excess of the force over the target of the same instant, from the first contact on; F is the \
     force along the first axis that has a target";
const SETTLING: &str = "simulated time from which the force stays within 5 % of its target until the end, and for 0.1 s \
     at least";
const STEADY: &str = "mean of the force minus its target over the last tenth of the run";
const FINAL: &str = "force of the last sample";
const RESIDUAL_UNIT: &str = "m/s, rad/s";
const RESIDUAL: &str = "‖J_k q̇ − ẋ_k‖, what the command lacks of each task's velocity, highest priority first";
const SPEED_USE: &str = "largest |q̇_i| as a part of that joint's limit";
const AT_LIMITS: &str =
    "simulated time in which a limit holds at least one joint back, or is broken, as the answers say";
const BROKEN: &str = "largest excess over the limits that the controller is told to keep, read off the trace: position, \
     commanded speed, commanded acceleration; – if all held; the solver `closed_form` does not know of limits";
const DIFFERENCE: &str = "largest difference of any joint's commanded velocity, over all samples, from the closed form of \
     the same scenario and method";
const PATHS: &str = "how many control periods each path served: the closed form inside the limits, a known set of active \
     limits that proved right, or a solver at every level (`qp`)";
const STATUS: &str = "how sure the answers are: `optimal` is certified by the optimality conditions";
const KKT: &str = "largest relative residual of the optimality conditions of any answer";
const CALLS: &str = "control periods per second of real time, simulation and transport included";

const fn head(heading: &'static str, cell: fn(&Row) -> String) -> Quantity {
    Quantity { heading, unit: "", meaning: "", is_number: false, place: Place::Head, cell }
}

type Cell = fn(&Row) -> String;

const fn main(heading: &'static str, unit: &'static str, meaning: &'static str, cell: Cell) -> Quantity {
    Quantity { heading, unit, meaning, is_number: true, place: Place::Everywhere, cell }
}

const fn more(heading: &'static str, unit: &'static str, meaning: &'static str, cell: Cell) -> Quantity {
    Quantity { place: Place::SideBySide, ..main(heading, unit, meaning, cell) }
}

/// The columns of the table with a row per run, from left to right.
pub fn columns() -> impl Iterator<Item = &'static Quantity> {
    QUANTITIES.iter().filter(|quantity| quantity.place != Place::SideBySide)
}

/// A row per run, in their order.
#[must_use]
pub fn rows(runs: &[Run]) -> Vec<Row> {
    let row = |run: &Run| {
        let recording = &run.recording;
        let axis = main_axis(recording);
        Row {
            scenario: recording.scenario.clone(),
            method: recording.method,
            solver: recording.solver,
            axis,
            metrics: Metrics::along(recording, axis),
            limits: LimitUse::of(recording, &run.robot.joints, &run.scenario.controller.limits),
            largest_difference: reference(recording, runs).map(|other| largest_difference(recording, other)),
        }
    };
    runs.iter().map(row).collect()
}

/// The table with a row per run as aligned text, two lines for the headings.
#[must_use]
pub fn text(rows: &[Row]) -> String {
    let columns: Vec<_> = columns().map(|column| Aligned::new(column, rows)).collect();
    let line = |i: usize| columns.iter().map(|c| c.cells[i].as_str()).collect::<Vec<_>>().join("  ");
    (0..rows.len() + 2).map(|i| line(i).trim_end().to_owned() + "\n").collect()
}

/// Heading, unit and cells of a column, padded to one width.
struct Aligned {
    cells: Vec<String>,
}

impl Aligned {
    fn new(column: &Quantity, rows: &[Row]) -> Self {
        let heads = [column.heading.to_owned(), column.unit.to_owned()];
        let cells: Vec<_> = heads.into_iter().chain(rows.iter().map(column.cell)).collect();
        Self { cells: padded(cells, column.is_number) }
    }
}

/// Cells of one width, numbers flush right.
fn padded(cells: Vec<String>, is_number: bool) -> Vec<String> {
    let width = cells.iter().map(|cell| cell.chars().count()).max().unwrap_or(0);
    let pad = |cell: String| if is_number { format!("{cell:>width$}") } else { format!("{cell:<width$}") };
    cells.into_iter().map(pad).collect()
}

/// The closed-form run to compare a run of another solver with.
fn reference<'a>(run: &Recording, runs: &'a [Run]) -> Option<&'a Recording> {
    let same = |other: &&Recording| {
        other.scenario == run.scenario
            && other.method == run.method
            && other.solver == REFERENCE_SOLVER
            && run.solver != REFERENCE_SOLVER
    };
    runs.iter().map(|run| &run.recording).find(same)
}

fn words(word: impl Display) -> String {
    word.to_string().replace('_', " ")
}

fn optional(value: Option<f64>, digits: usize) -> String {
    value.map_or_else(|| NOTHING.to_owned(), |v| significant(v, digits))
}

fn percent(fraction: f64) -> String {
    if fraction > 0.0 { significant(100.0 * fraction, 3) } else { NOTHING.to_owned() }
}

fn counted<T: Display>(counts: &BTreeMap<T, usize>) -> String {
    let served = |(word, periods): (&T, &usize)| format!("{} {periods}", words(word));
    counts.iter().map(served).collect::<Vec<_>>().join(", ")
}

fn residuals(row: &Row, of: fn(&Residual) -> f64) -> String {
    row.metrics.residuals.iter().map(|residual| significant(of(residual), 2)).collect::<Vec<_>>().join(" / ")
}

fn broken(limits: &LimitUse) -> String {
    let excesses =
        [(limits.position_excess, "rad"), (limits.velocity_excess, "rad/s"), (limits.acceleration_excess, "rad/s²")];
    let excess = |(value, unit): &(f64, &str)| format!("{} {unit}", significant(*value, 3));
    let broken: Vec<_> = excesses.iter().filter(|(value, _)| *value > 0.0).map(excess).collect();
    if broken.is_empty() { NOTHING.to_owned() } else { broken.join(", ") }
}

fn overshoot(value: Option<Overshoot>) -> String {
    value
        .map_or_else(|| NOTHING.to_owned(), |o| format!("{} ({})", significant(o.newton, 3), significant(o.percent, 3)))
}

#[cfg(test)]
mod tests;
