//! The results as text, JSON, Markdown and figures.

use std::fmt::Write as _;
use std::path::Path;

use revprio_lab::report::logarithmic::svg;
use serde::Serialize;

use super::error::BenchError;
use super::pacing::{self, Paced};
use super::plan::{Group, Plan};
use super::row::{self, Row};
use super::series::Growth;
use super::{core, document, growth, http, plot};

/// Prefixes of the rows in the summary of the README.
const SUMMARY: [&str; 6] = [
    "kinematics",
    "pseudo-inverse",
    "cycle, auto, nothing limited",
    "cycle, auto, limits",
    "POST /v1/controllers/{id}/step, one core",
    "session steps, 64",
];

/// The results of a plan.
#[derive(Debug, Default, Serialize)]
pub struct Report {
    /// Number of available cores.
    pub cores: usize,
    /// The mathematics.
    pub core: Vec<Row>,
    /// The service.
    pub http: Vec<Row>,
    /// Control loops.
    pub pacing: Vec<Paced>,
    /// Growth curves.
    pub growth: Vec<Growth>,
}

impl Report {
    /// Runs the measurements; `begun` is called before each part.
    pub fn measured(plan: &Plan, mut begun: impl FnMut(Group)) -> Result<Self, BenchError> {
        let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
        let mut report = Self { cores, ..Self::default() };
        for group in Group::ALL.into_iter().filter(|group| plan.groups.contains(group)) {
            begun(group);
            match group {
                Group::Core => report.core = core::rows(plan.rows())?,
                Group::Http => {
                    report.http = http::rows(plan.rows())?;
                    report.http.push(growth::simulations::row(plan)?);
                }
                Group::Pacing => report.pacing = pacing::run(plan.pacing_s)?,
                Group::Growth => report.growth = growth::curves(plan)?,
            }
        }
        Ok(report)
    }

    /// Formats the results as text.
    pub fn text(&self) -> String {
        let mut text = String::new();
        for (_, rows) in self.tables() {
            text += &row::text(&rows);
            text.push('\n');
        }
        for growth in &self.growth {
            // Writing into a string cannot fail.
            let _ = writeln!(text, "{}: {}", growth.size, growth.value);
            for series in &growth.series {
                let points = series.points.iter().map(|(size, value)| format!("{size}: {}", short(*value)));
                let points = points.collect::<Vec<_>>().join("  ");
                let _ = writeln!(text, "  {} (slope {:.2})  {points}", series.name, series.slope);
            }
        }
        text
    }

    /// Returns the tables with rows, by name.
    fn tables(&self) -> Vec<(&'static str, Vec<Row>)> {
        let pacing = self.pacing.iter().map(Paced::row).collect();
        let tables = [("core", self.core.clone()), ("http", self.http.clone()), ("pacing", pacing)];
        tables.into_iter().filter(|(_, rows)| !rows.is_empty()).collect()
    }

    /// Writes a figure for each group of curves.
    pub fn write_figures(&self, directory: &Path) -> Result<(), BenchError> {
        let latency = Some(&self.pacing).filter(|paced| !paced.is_empty()).map(|paced| plot::latency(paced));
        document::make_directory(directory)?;
        for figure in self.growth.iter().map(plot::growth).chain(latency) {
            document::write(&directory.join(format!("{}.svg", figure.name)), &svg(&figure)?)?;
        }
        Ok(())
    }

    /// Replaces the marked tables of a Markdown document. Tables that were not measured stay.
    pub fn fill(&self, document: &Path) -> Result<(), BenchError> {
        let mut text = document::read(document)?;
        for (name, rows) in self.tables() {
            text = document::filled(&text, name, &row::markdown(&rows));
        }
        if !self.core.is_empty() && !self.http.is_empty() {
            text = document::filled(&text, "summary", &row::markdown(&self.summary()));
        }
        if !self.growth.is_empty() {
            text = document::filled(&text, "growth", &self.slopes());
        }
        for (name, title) in self.figures() {
            text = document::filled(&text, name, &format!("![{title}](performance/{name}.svg)\n"));
        }
        document::write(document, &text)
    }

    /// Returns names and titles of the figures.
    fn figures(&self) -> Vec<(&'static str, &'static str)> {
        let latency = (!self.pacing.is_empty()).then_some(("latency", "Round trips of a control loop"));
        self.growth.iter().map(|growth| (growth.name, growth.title)).chain(latency).collect()
    }

    /// Returns the rows of the summary, each with its first peer.
    fn summary(&self) -> Vec<Row> {
        let rows = || self.core.iter().chain(&self.http);
        let first = |begin: &&str| rows().find(|row| row.ours.name.starts_with(begin)).cloned();
        SUMMARY.iter().filter_map(first).collect()
    }

    /// Formats the slopes as a table in Markdown.
    fn slopes(&self) -> String {
        let mut table = "| over | what | slope | smallest | largest |\n| --- | --- | ---: | ---: | ---: |\n".to_owned();
        for growth in &self.growth {
            for series in &growth.series {
                let [first, last] = [series.points.first(), series.points.last()]
                    .map(|point| point.map_or_else(String::new, |(size, value)| format!("{size}: {}", short(*value))));
                let (size, name, slope) = (growth.size, &series.name, series.slope);
                let _ = writeln!(table, "| {size} | {name} | {slope:.2} | {first} | {last} |");
            }
        }
        table
    }
}

fn short(value: f64) -> String {
    format!("{value:.2e}")
}
