//! The result in short: one row per scenario and method, and how much its solvers differ. It fits into 100 columns.

use super::{MISSING, Row, optional, padded};
use crate::report::number::significant;

/// Formats the table as aligned text. The first two lines are headings and units. `rows`: grouped by scenario and method.
#[must_use]
pub fn text(rows: &[Row]) -> String {
    let lines: Vec<[String; 7]> =
        rows.chunk_by(|a, b| (&a.scenario, a.method) == (&b.scenario, b.method)).map(line).collect();
    let heads = [
        ["scenario", "method", "RMSE F_x", "peak F", "settling", "final F", "solvers differ"],
        ["", "", "N", "N", "s", "N", "rad/s"],
    ];
    let heads = heads.map(|head| head.map(str::to_owned));
    let column = |i: usize| padded(heads.iter().chain(&lines).map(|line| line[i].clone()).collect(), i > 1);
    let columns: Vec<Vec<String>> = (0..7).map(column).collect();
    let line = |i: usize| columns.iter().map(|column| column[i].as_str()).collect::<Vec<_>>().join("  ");
    (0..lines.len() + 2).map(|i| line(i).trim_end().to_owned() + "\n").collect()
}

/// Returns the cells of the runs of one scenario and method with several solvers.
fn line(runs: &[Row]) -> [String; 7] {
    let row = &runs[0];
    let difference = runs.iter().filter_map(|run| run.largest_difference).reduce(f64::max);
    [
        row.scenario.clone(),
        row.method_name(),
        optional(row.metrics.rmse_fx, 3),
        significant(row.metrics.peak_force, 4),
        optional(row.metrics.settling_time_s, 3),
        optional(row.metrics.final_force, 5),
        difference.map_or_else(|| MISSING.to_owned(), |difference| significant(difference, 2)),
    ]
}
