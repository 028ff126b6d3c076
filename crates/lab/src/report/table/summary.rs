//! The result in short: one row per scenario and method, how much its solvers differ, and the HTTP requests of all its
//! solvers. It fits into 100 columns.
//!
//! The name of a scenario in which limits act is followed by the share of the control periods with an active limit.

use revprio_api::wire::Method;

use super::{MISSING, Row, optional, padded, request_count, rows};
use crate::metrics::{larger, largest_difference};
use crate::number::significant;
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
    let groups: Vec<&[Run]> = runs.chunk_by(|a, b| group(a) == group(b)).collect();
    let head = HEADS.map(|head| head.map(str::to_owned));
    let lines: Vec<[String; COLUMNS]> = head.into_iter().chain(groups.iter().map(|runs| method(runs))).collect();
    let column = |i: usize| padded(lines.iter().map(|line| line[i].clone()).collect(), i > 0);
    let columns: Vec<Vec<String>> = (0..COLUMNS).map(column).collect();
    let line = |i: usize| columns.iter().map(|column| column[i].as_str()).collect::<Vec<_>>().join("  ");
    let mut text = String::new();
    let mut scenario = "";
    for i in 0..lines.len() {
        let next = i.checked_sub(HEADS.len()).map_or("", |i| group(&groups[i][0]).0);
        if next != scenario {
            text += &scenario_line(next, runs);
            scenario = next;
        }
        text += line(i).trim_end();
        text.push('\n');
    }
    text
}

/// Returns the name of a scenario, and in how many of its periods a limit acts; of several runs, the one with the fewest.
fn scenario_line(name: &str, runs: &[Run]) -> String {
    let share = |run: &Run| {
        let at_limits = run.recording.samples.iter().filter(|sample| sample.is_at_limit()).count();
        at_limits as f64 / run.recording.samples.len().max(1) as f64
    };
    let of_scenario = runs.iter().filter(|run| run.recording.scenario == name);
    match of_scenario.map(share).fold(1.0, f64::min) {
        0.0 => format!("{name}\n"),
        share => format!("{name}: a limit acts in {} % of the periods\n", significant(100.0 * share, 2)),
    }
}

fn group(run: &Run) -> (&str, Method) {
    (&run.recording.scenario, run.recording.method)
}

/// Returns the cells of the runs of one scenario and method with several solvers.
fn method(runs: &[Run]) -> [String; COLUMNS] {
    let all: Vec<Row> = rows(runs);
    let row = &all[0];
    let pairs = runs.iter().enumerate().flat_map(|(i, one)| runs[i + 1..].iter().map(move |other| (one, other)));
    let differences = pairs.map(|(one, other)| largest_difference(&one.recording, &other.recording));
    let difference = differences.reduce(larger);
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
