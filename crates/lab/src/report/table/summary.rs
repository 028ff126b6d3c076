//! The result in short: one row per scenario and method, how much its solvers differ, and the HTTP requests of all its
//! solvers. It fits into 100 columns.

use super::{MISSING, Row, optional, padded, request_count, rows};
use crate::report::number::significant;
use crate::report::requests::Requests;
use crate::report::run::Run;

const COLUMNS: usize = 9;

const HEADS: [[&str; COLUMNS]; 2] = [
    ["scenario, method", "RMSE F_x", "peak F", "settling", "final F", "solvers differ", "requests", "median", "p99"],
    ["", "N", "N", "s", "N", "rad/s", "", "µs", "µs"],
];

/// Formats the table as aligned text: two lines of headings and units, then a line per scenario, followed by a row for each
/// of its methods. `runs`: grouped by scenario and method.
#[must_use]
pub fn text(runs: &[Run]) -> String {
    let head = HEADS.map(|head| head.map(str::to_owned));
    let scenarios = runs.chunk_by(|a, b| a.recording.scenario == b.recording.scenario);
    let lines: Vec<[String; COLUMNS]> = head.into_iter().chain(scenarios.flat_map(scenario)).collect();
    let column = |i: usize| padded(lines.iter().map(|line| line[i].clone()).collect(), i > 0);
    let columns: Vec<Vec<String>> = (0..COLUMNS).map(column).collect();
    let line = |i: usize| columns.iter().map(|column| column[i].as_str()).collect::<Vec<_>>().join("  ");
    (0..lines.len()).map(|i| line(i).trim_end().to_owned() + "\n").collect()
}

/// Returns the lines of one scenario.
fn scenario(runs: &[Run]) -> Vec<[String; COLUMNS]> {
    let mut name: [String; COLUMNS] = Default::default();
    name[0].clone_from(&runs[0].recording.scenario);
    let methods = runs.chunk_by(|a, b| a.recording.method == b.recording.method);
    [name].into_iter().chain(methods.map(method)).collect()
}

/// Returns the cells of the runs of one scenario and method with several solvers.
fn method(runs: &[Run]) -> [String; COLUMNS] {
    let all: Vec<Row> = rows(runs);
    let row = &all[0];
    let difference = all.iter().filter_map(|run| run.largest_difference).reduce(f64::max);
    let requests = requests(runs);
    let time = |of: fn(Requests) -> f64| requests.map_or_else(|| MISSING.to_owned(), |it| format!("{:.0}", of(it)));
    [
        format!("  {}", row.method_name()),
        optional(row.metrics.rmse_fx, 3),
        significant(row.metrics.peak_force, 4),
        optional(row.metrics.settling_time_s, 3),
        optional(row.metrics.final_force, 5),
        difference.map_or_else(|| MISSING.to_owned(), |difference| significant(difference, 2)),
        request_count(requests),
        time(|requests| requests.median_us),
        time(|requests| requests.p99_us),
    ]
}

/// Returns the requests of several runs together; `None` if a run had none.
fn requests(runs: &[Run]) -> Option<Requests> {
    let counts: Option<Vec<u64>> = runs.iter().map(|run| run.requests.map(|requests| requests.count)).collect();
    Some(Requests::new(counts?.iter().sum(), runs.iter().flat_map(|run| &run.recording.timings)))
}
