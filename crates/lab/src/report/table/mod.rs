//! Tables of results. Each quantity is defined once, for the terminal, for Markdown and for the page.
//!
//! [`text`] prints the most important quantities with one row per run. [`side_by_side`] prints all quantities of a scenario
//! with one column per run. [`summary`] prints one row per scenario and method.

pub mod side_by_side;
pub mod summary;

use std::collections::BTreeMap;
use std::fmt::Display;

use revprio_api::wire::{Method, Path, Solver};
use serde::Serialize;

use super::requests::Requests;
use super::run::Run;
use crate::metrics::limits::LimitUse;
use crate::metrics::{ContactFailures, Direction, Metrics, Overshoot, Residual, largest_difference, main_direction};
use crate::number::significant;
use crate::simulator::recording::Recording;

/// The solver with which the others are compared.
const REFERENCE_SOLVER: Solver = Solver::ClosedForm;
/// Cell of a quantity that a run does not have.
pub const MISSING: &str = "–";

/// One run in the table.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// Name of the scenario.
    pub scenario: String,
    /// Method.
    pub method: Method,
    /// Solver.
    pub solver: Solver,
    /// Direction of the forces in `metrics`.
    pub direction: Direction,
    /// Metrics of the run.
    pub metrics: Metrics,
    /// Use of the limits.
    pub limits: LimitUse,
    /// Largest difference of the commands (rad/s) from the closed form of the same scenario and method; `None` for the
    /// closed form itself and if it was not run.
    pub largest_difference: Option<f64>,
    /// The HTTP requests; `None` if the service was called as a function.
    pub requests: Option<Requests>,
}

impl Row {
    /// Returns the method as words.
    #[must_use]
    pub fn method_name(&self) -> String {
        words(self.method)
    }

    /// Returns the solver as words.
    #[must_use]
    pub fn solver_name(&self) -> String {
        words(self.solver)
    }
}

/// A quantity of the table.
#[derive(Debug, Clone, Copy)]
pub struct Quantity {
    /// Heading. `F_x` prints x as an index. `F` without an index is the force along the axis of the row.
    pub heading: &'static str,
    /// Unit, or empty.
    pub unit: &'static str,
    /// Meaning, for the page; empty if the heading is clear.
    pub meaning: &'static str,
    /// Whether cells are aligned to the right.
    pub is_number: bool,
    /// Tables that contain it.
    pub place: Place,
    /// Returns the text of a cell.
    pub cell: fn(&Row) -> String,
}

/// The tables that contain a quantity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// All tables; it identifies the run.
    Head,
    /// All tables.
    Everywhere,
    /// Tables with one column per run only.
    SideBySide,
    /// All tables except in Markdown, because the value depends on the machine or on the connection to the service.
    Machine,
}

/// All quantities; rows are grouped by the first one.
pub static QUANTITIES: [Quantity; 29] = [
    identifier("scenario", |row| row.scenario.clone()),
    identifier("method", Row::method_name),
    identifier("solver", Row::solver_name),
    detail("first contact", "s", "", |row| optional(row.metrics.first_contact_s, 3)),
    detail("contacts", "", CONTACTS, |row| row.metrics.contacts.to_string()),
    detail("losses / faults", "", FAILURES, |row| contact_failures(row.metrics.contact_failures)),
    detail("peak F", "N", "", |row| significant(row.metrics.peak_force, 4)),
    column("RMSE F_x", "N", RMSE, |row| optional(row.metrics.rmse_fx, 3)),
    column("RMSE F_y", "N", "", |row| optional(row.metrics.rmse_fy, 3)),
    detail("RMSE F_z", "N", "", |row| optional(row.metrics.rmse_fz, 3)),
    detail("RMSE F_n", "N", CONTACT, |row| optional(row.metrics.rmse_contact, 3)),
    column("overshoot F", "N (%)", OVERSHOOT, |row| overshoot(row.metrics.overshoot)),
    column("settling", "s", SETTLING, |row| optional(row.metrics.settling_time_s, 3)),
    detail("steady error F", "N", STEADY, |row| optional(row.metrics.steady_error, 2)),
    column("final F", "N", FINAL, |row| optional(row.metrics.final_force, 5)),
    detail("residual of each task, RMS", RESIDUAL_UNIT, RESIDUAL, |row| residuals(row, |residual| residual.rms)),
    detail("residual of each task, largest", RESIDUAL_UNIT, "", |row| residuals(row, |residual| residual.largest)),
    detail("largest joint speed", "rad/s", "", |row| significant(row.metrics.max_joint_speed, 3)),
    detail("share of speed limit", "%", SPEED_USE, |row| percent(row.limits.speed_use)),
    detail("time at limits", "s", AT_LIMITS, |row| significant(row.limits.at_limits_s, 3)),
    column(LIMIT_EXCESS_HEADING, "", LIMIT_EXCESS, |row| limit_excess(&row.limits)),
    detail("least distance", "m", LEAST_DISTANCE, |row| optional(row.metrics.least_distance_m, 3)),
    column("solved by", "periods", PATHS, solved_by),
    detail("status", "periods", STATUS, |row| counted(&row.metrics.statuses)),
    detail("largest KKT residual", "", KKT, |row| optional(row.metrics.largest_kkt_residual, 2)),
    column("vs closed form", "rad/s", DIFFERENCE, |row| optional(row.largest_difference, 2)),
    Quantity {
        place: Place::Machine,
        ..detail("calls", "1/s", CALLS, |row| optional(row.metrics.calls_per_second, 3))
    },
    Quantity { place: Place::Machine, ..detail("requests", "", REQUESTS, |row| request_count(row.requests)) },
    Quantity { place: Place::Machine, ..detail(ROUND_TRIP_HEADING, "µs", ROUND_TRIP, |row| round_trip(row.requests)) },
];

const ROUND_TRIP_HEADING: &str = "round trip, median / 99th perc.";

/// Heading of the excess over the limits, a quantity that is shown even if no run has it.
const LIMIT_EXCESS_HEADING: &str = "limit excess";

const CONTACTS: &str = "number of separate contact intervals (without a wall: intervals with a force)";
const FAILURES: &str = "how often the law `contact` lost the surface, and gave the contact up, on all its axes";
const RMSE: &str = "root mean square of the force minus its target; after 5 s in a run longer than 10 s, otherwise after the \
     first contact";
const CONTACT: &str =
    "the same for the measured force along the normal that the law `contact` follows; F_n is this force";
const OVERSHOOT: &str = "largest excess of the force over the target at the same time, after the first contact; F is the force \
     along the first axis that has a target";
const SETTLING: &str =
    "simulated time from which the force stays within 5 % of its target until the end, for at least 0.1 s";
const STEADY: &str = "mean of the force minus its target over the last tenth of the run";
const FINAL: &str = "force of the last sample";
const RESIDUAL_UNIT: &str = "m/s, rad/s";
const RESIDUAL: &str =
    "‖J_k q̇ − ẋ_k‖, the part of the task velocity that the command does not achieve; highest priority first";
const SPEED_USE: &str = "largest |q̇_i| as a percentage of the velocity limit of the joint";
const AT_LIMITS: &str =
    "simulated time in which a limit is active or exceeded for at least one joint, according to the answers";
const LIMIT_EXCESS: &str = "largest excess of position, commanded speed and commanded acceleration over the controller's \
     limits in the recorded motion; – if no limit is exceeded; the solver `closed_form` ignores limits";
const LEAST_DISTANCE: &str = "smallest distance of the pairs of shapes that the controller watches, negative where they intersect; compare it with `min_distance_m`";
const DIFFERENCE: &str = "largest difference between the commanded velocity of any joint and the closed form of the same \
     scenario and method";
const PATHS: &str = "number of control periods by the way of the solution: `auto` needs no active limit, or finds the set of \
     active limits; `qp` solves a quadratic program at every level; `closed_form` ignores limits";
const STATUS: &str = "status of the answers: `optimal` is certified by the optimality conditions";
const KKT: &str = "largest relative residual of the optimality conditions in any answer";
const CALLS: &str = "control periods per second of real time, including simulation and transport";

const REQUESTS: &str = "answered HTTP requests: one per control period, and those that open and close the session";
const ROUND_TRIP: &str = "real time from sending a state to its answer over HTTP: median / 99th percentile";

const fn identifier(heading: &'static str, cell: fn(&Row) -> String) -> Quantity {
    Quantity { heading, unit: "", meaning: "", is_number: false, place: Place::Head, cell }
}

type Cell = fn(&Row) -> String;

const fn column(heading: &'static str, unit: &'static str, meaning: &'static str, cell: Cell) -> Quantity {
    Quantity { heading, unit, meaning, is_number: true, place: Place::Everywhere, cell }
}

const fn detail(heading: &'static str, unit: &'static str, meaning: &'static str, cell: Cell) -> Quantity {
    Quantity { place: Place::SideBySide, ..column(heading, unit, meaning, cell) }
}

/// Returns the columns of the table with one row per run, from left to right.
pub fn columns() -> impl Iterator<Item = &'static Quantity> {
    QUANTITIES.iter().filter(|quantity| quantity.place != Place::SideBySide)
}

/// Returns one row per run, in the order of the runs.
#[must_use]
pub fn rows(runs: &[Run]) -> Vec<Row> {
    let row = |run: &Run| {
        let recording = &run.recording;
        let direction = main_direction(recording);
        Row {
            scenario: recording.scenario.clone(),
            method: recording.method,
            solver: recording.solver,
            direction,
            metrics: Metrics::along(recording, direction),
            limits: LimitUse::of(recording, &run.robot.joints, &run.scenario.controller.limits),
            largest_difference: reference(recording, runs).map(|other| largest_difference(recording, other)),
            requests: run.requests,
        }
    };
    runs.iter().map(row).collect()
}

/// Formats the table with one row per run as aligned text. The first two lines are headings and units.
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

/// Pads cells to the same width; numbers are aligned to the right.
fn padded(cells: Vec<String>, is_number: bool) -> Vec<String> {
    let width = cells.iter().map(|cell| cell.chars().count()).max().unwrap_or(0);
    let pad = |cell: String| if is_number { format!("{cell:>width$}") } else { format!("{cell:<width$}") };
    cells.into_iter().map(pad).collect()
}

/// Returns the closed-form run with which a run of another solver is compared.
fn reference<'a>(run: &Recording, runs: &'a [Run]) -> Option<&'a Recording> {
    let same = |other: &&Recording| {
        other.scenario == run.scenario
            && other.method == run.method
            && other.solver == REFERENCE_SOLVER
            && run.solver != REFERENCE_SOLVER
    };
    runs.iter().map(|run| &run.recording).find(same)
}

fn request_count(requests: Option<Requests>) -> String {
    requests.map_or_else(|| MISSING.to_owned(), |requests| requests.count.to_string())
}

fn round_trip(requests: Option<Requests>) -> String {
    let times = |requests: Requests| format!("{:.0} / {:.0}", requests.median_us, requests.p99_us);
    requests.map_or_else(|| MISSING.to_owned(), times)
}

fn words(word: impl Display) -> String {
    word.to_string().replace('_', " ")
}

fn optional(value: Option<f64>, digits: usize) -> String {
    value.map_or_else(|| MISSING.to_owned(), |v| significant(v, digits))
}

fn contact_failures(failures: Option<ContactFailures>) -> String {
    failures.map_or_else(|| MISSING.to_owned(), |count| format!("{} / {}", count.losses, count.faults))
}

fn percent(fraction: f64) -> String {
    if fraction > 0.0 { significant(100.0 * fraction, 3) } else { MISSING.to_owned() }
}

fn counted<T: Display>(counts: &BTreeMap<T, usize>) -> String {
    let served = |(word, periods): (&T, &usize)| format!("{} {periods}", words(word));
    counts.iter().map(served).collect::<Vec<_>>().join(", ")
}

/// Returns the number of periods of each path. Without an active limit, `auto` computes what the solver `closed_form` computes;
/// the name of this path would read as that solver.
fn solved_by(row: &Row) -> String {
    let path = |(path, periods): (&Path, &usize)| match path {
        Path::ClosedForm if row.solver != Solver::ClosedForm => format!("no active limit {periods}"),
        path => format!("{} {periods}", words(path)),
    };
    row.metrics.paths.iter().map(path).collect::<Vec<_>>().join(", ")
}

fn residuals(row: &Row, of: fn(&Residual) -> f64) -> String {
    row.metrics.residuals.iter().map(|residual| significant(of(residual), 2)).collect::<Vec<_>>().join(" / ")
}

fn limit_excess(limits: &LimitUse) -> String {
    let excesses = [
        (limits.position_excess, "rad"),
        (limits.velocity_excess, "rad/s"),
        (limits.acceleration_excess, "rad/s²"),
        (limits.jerk_excess, "rad/s³"),
    ];
    let excess = |(value, unit): &(f64, &str)| format!("{} {unit}", significant(*value, 3));
    let exceeded: Vec<_> = excesses.iter().filter(|(value, _)| *value > 0.0).map(excess).collect();
    if exceeded.is_empty() { MISSING.to_owned() } else { exceeded.join(", ") }
}

fn overshoot(value: Option<Overshoot>) -> String {
    value
        .map_or_else(|| MISSING.to_owned(), |o| format!("{} ({})", significant(o.newton, 3), significant(o.percent, 3)))
}

#[cfg(test)]
mod tests;
