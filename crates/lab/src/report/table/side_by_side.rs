//! All quantities of one scenario, one column per run.

use crate::metrics::Direction;

use super::{LIMIT_EXCESS_HEADING, MISSING, Place, QUANTITIES, Quantity, Row, padded};

/// Largest number of runs in one table in the terminal; further runs follow in another table.
const MAX_COLUMNS: usize = 5;

/// Returns the quantities that at least one run of a scenario has. `portable` omits those that depend on the machine.
fn quantities(runs: &[Row], portable: bool) -> impl Iterator<Item = Line> {
    let included =
        move |quantity: &&Quantity| quantity.place != Place::Head && !(portable && quantity.place == Place::Machine);
    let lines = QUANTITIES.iter().filter(included).map(|quantity| Line::new(quantity, runs));
    lines.filter(|line| line.always || line.cells.iter().any(|cell| cell != MISSING))
}

/// One quantity of all runs of a scenario.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Line {
    /// Heading, with the axis of the force, or n for the normal.
    pub heading: String,
    /// Unit, or empty.
    pub unit: &'static str,
    /// One cell per run.
    pub cells: Vec<String>,
    /// Whether the line is shown even if no run has the quantity.
    always: bool,
}

impl Line {
    fn new(quantity: &Quantity, runs: &[Row]) -> Self {
        let axis = match runs.first().map_or(Direction::Base(0), |row| row.direction) {
            Direction::Base(axis) => ["x", "y", "z"][axis.min(2)],
            Direction::Contact => "n",
        };
        let heading = quantity.heading.strip_suffix(" F");
        Self {
            heading: heading.map_or_else(|| quantity.heading.to_owned(), |name| format!("{name} F_{axis}")),
            unit: quantity.unit,
            cells: runs.iter().map(quantity.cell).collect(),
            always: quantity.heading == LIMIT_EXCESS_HEADING,
        }
    }
}

/// Returns the lines of the table on the page.
#[must_use]
pub fn lines(runs: &[Row]) -> Vec<Line> {
    quantities(runs, false).collect()
}

/// Formats one table per scenario as aligned text.
#[must_use]
pub fn text(rows: &[Row]) -> String {
    let scenarios = rows.chunk_by(|a, b| a.scenario == b.scenario);
    let tables = scenarios
        .flat_map(|runs| runs.chunks(MAX_COLUMNS))
        .map(|runs| format!("{}\n{}", runs[0].scenario, aligned(runs)));
    tables.collect::<Vec<_>>().join("\n")
}

fn aligned(runs: &[Row]) -> String {
    let lines: Vec<Line> = quantities(runs, false).collect();
    let names = |blank: [&str; 2], of: &dyn Fn(&Line) -> String| -> Vec<String> {
        blank.into_iter().map(str::to_owned).chain(lines.iter().map(of)).collect()
    };
    let mut columns = vec![
        padded(names(["  method", "  solver"], &|line| format!("  {}", line.heading)), false),
        padded(names(["", ""], &|line| line.unit.to_owned()), false),
    ];
    columns.extend(runs.iter().enumerate().map(|(i, run)| {
        let (method, solver) = (run.method_name(), run.solver_name());
        padded(names([&method, &solver], &|line| line.cells[i].clone()), true)
    }));
    let line = |i: usize| columns.iter().map(|column| column[i].as_str()).collect::<Vec<_>>().join("  ");
    (0..lines.len() + 2).map(|i| line(i).trim_end().to_owned() + "\n").collect()
}

/// Formats the table of one scenario in Markdown, without values that depend on the machine.
#[must_use]
pub fn markdown(runs: &[Row]) -> String {
    let names = runs.iter().map(|run| format!("{}, {}", run.method_name(), run.solver_name()));
    let row = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
    let mut table = row([String::new()].into_iter().chain(names).collect());
    table.push_str(&row([":--".to_owned()].into_iter().chain(runs.iter().map(|_| "--:".to_owned())).collect()));
    for line in quantities(runs, true) {
        let unit = if line.unit.is_empty() { String::new() } else { format!(" ({})", line.unit) };
        let cells = [format!("{}{unit}", line.heading)].into_iter().chain(line.cells);
        table.push_str(&row(cells.collect()));
    }
    table
}
