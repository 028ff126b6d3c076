//! Rows of the table, and the table itself.

use serde::Serialize;

use super::timing::Times;

/// Unit of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Unit {
    /// Seconds; lower is better.
    Seconds,
    /// Events per second; higher is better.
    PerSecond,
}

/// One measured quantity.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Quantity {
    /// Name.
    pub name: String,
    /// Median, or the single value.
    pub median: f64,
    /// 99th percentile; `None` for a single value.
    pub p99: Option<f64>,
}

/// One line of the table: a quantity of revprio and, if any, of a peer in the same run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// The quantity of revprio.
    pub ours: Quantity,
    /// The quantity of the peer.
    pub peer: Option<Quantity>,
    /// Value of revprio divided by the value of the peer, from adjacent turns.
    pub ratio: Option<f64>,
    /// Unit of all numbers.
    pub unit: Unit,
    /// Remark, or empty.
    pub note: String,
}

impl From<&Times> for Quantity {
    fn from(times: &Times) -> Self {
        Self { name: times.name.clone(), median: times.median(), p99: Some(times.quantile(0.99)) }
    }
}

impl Row {
    /// Returns a row of times, with or without a peer.
    pub fn of_times(ours: &Times, peer: Option<&Times>) -> Self {
        Self {
            ours: ours.into(),
            peer: peer.map(Quantity::from),
            ratio: peer.map(|peer| ours.ratio(peer)),
            unit: Unit::Seconds,
            note: String::new(),
        }
    }

    /// Returns a row per peer; the first of the times belongs to revprio.
    pub fn against_each(times: &[Times]) -> Vec<Self> {
        match times {
            [ours] => vec![Self::of_times(ours, None)],
            [ours, peers @ ..] => peers.iter().map(|peer| Self::of_times(ours, Some(peer))).collect(),
            [] => Vec::new(),
        }
    }

    /// Returns a row of rates, 1/s.
    pub fn of_rates(name: &str, ours: f64, peer: &str, peers: f64) -> Self {
        let rate = |name: &str, median: f64| Quantity { name: name.to_owned(), median, p99: None };
        Self {
            ours: rate(name, ours),
            peer: Some(rate(peer, peers)),
            ratio: Some(ours / peers),
            unit: Unit::PerSecond,
            note: String::new(),
        }
    }

    /// Returns the row with a remark.
    #[must_use]
    pub fn with_note(self, note: impl Into<String>) -> Self {
        Self { note: note.into(), ..self }
    }
}

/// Columns of the table.
const HEADINGS: [&str; 6] = ["quantity", "median", "p99", "compared with", "median", "ratio"];

/// Returns the cells of a row.
pub fn cells(row: &Row) -> [String; HEADINGS.len()] {
    let shown = |value: f64| match row.unit {
        Unit::Seconds => seconds(value),
        Unit::PerSecond => format!("{value:.0}/s"),
    };
    let peer = row.peer.as_ref();
    [
        row.ours.name.clone(),
        shown(row.ours.median),
        row.ours.p99.map_or_else(String::new, shown),
        peer.map_or_else(|| row.note.clone(), |peer| peer.name.clone()),
        peer.map_or_else(String::new, |peer| shown(peer.median)),
        row.ratio.map_or_else(String::new, |ratio| format!("{ratio:.2}")),
    ]
}

/// Formats rows as aligned text; the first line contains the headings.
pub fn text(rows: &[Row]) -> String {
    let lines: Vec<_> = std::iter::once(HEADINGS.map(str::to_owned)).chain(rows.iter().map(cells)).collect();
    let width = |column: usize| lines.iter().map(|line| line[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..HEADINGS.len()).map(width).collect();
    let aligned = |(column, cell): (usize, &String)| {
        let width = widths[column];
        if is_text(column) { format!("{cell:<width$}") } else { format!("{cell:>width$}") }
    };
    let line = |line: &[String; HEADINGS.len()]| {
        line.iter().enumerate().map(aligned).collect::<Vec<_>>().join("  ").trim_end().to_owned() + "\n"
    };
    lines.iter().map(line).collect()
}

/// Formats rows as a table in Markdown.
pub fn markdown(rows: &[Row]) -> String {
    let line = |cells: [String; HEADINGS.len()]| format!("| {} |\n", cells.join(" | "));
    let rule = std::array::from_fn(|column| if is_text(column) { "---" } else { "---:" }.to_owned());
    let head = line(HEADINGS.map(str::to_owned)) + &line(rule);
    rows.iter().map(|row| line(cells(row))).fold(head, |table, line| table + &line)
}

fn is_text(column: usize) -> bool {
    matches!(column, 0 | 3)
}

/// Formats a time with three digits in a suitable unit.
pub fn seconds(value: f64) -> String {
    let (scaled, unit) = match value {
        value if value < 1e-6 => (value * 1e9, "ns"),
        value if value < 1e-3 => (value * 1e6, "µs"),
        value if value < 1.0 => (value * 1e3, "ms"),
        value => (value, "s"),
    };
    let decimals = match scaled {
        scaled if scaled < 9.995 => 2,
        scaled if scaled < 99.95 => 1,
        _ => 0,
    };
    format!("{scaled:.decimals$} {unit}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_have_three_digits_and_a_suitable_unit() {
        let shown = [1.234e-7, 9.996e-6, 2.5e-5, 0.123, 4.0].map(seconds);
        assert_eq!(shown, ["123 ns", "10.0 µs", "25.0 µs", "123 ms", "4.00 s"]);
    }

    #[test]
    fn table_has_one_line_per_row_with_the_ratio() {
        let (ours, peer) = (Times::of("ours", vec![2e-6]), Times::of("theirs", vec![1e-6]));
        let rows = [Row::of_times(&ours, Some(&peer)), Row::of_rates("calls", 100.0, "bare calls", 200.0)];
        assert_eq!(
            text(&rows),
            "quantity   median      p99  compared with   median  ratio\n\
             ours      2.00 µs  2.00 µs  theirs         1.00 µs   2.00\n\
             calls       100/s           bare calls       200/s   0.50\n"
        );
        assert!(markdown(&rows).ends_with("| calls | 100/s |  | bare calls | 200/s | 0.50 |\n"));
    }
}
