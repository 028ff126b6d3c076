//! `revprio-bench bench`

use std::io::{Write as _, stderr, stdout};
use std::path::PathBuf;

use crate::error::BenchError;
use crate::plan::{Group, Plan};
use crate::repeat::{Repeated, repeat};
use crate::report::Report;
use crate::{hierarchies, problems};

#[derive(Debug, clap::Args)]
pub struct Options {
    /// Parts to measure, separated by commas; all by default
    #[arg(long, value_delimiter = ',', value_enum)]
    only: Vec<Group>,
    /// Measure as little as possible, to test the benchmark; the numbers are not meaningful
    #[arg(long)]
    quick: bool,
    /// Duration of each control loop, s
    #[arg(long, default_value_t = 60.0, value_parser = seconds)]
    seconds: f64,
    /// Repeat one operation, for a profiler that counts instructions
    #[arg(long, hide = true, value_enum, requires = "times")]
    repeat: Option<Repeated>,
    #[arg(long, hide = true)]
    times: Option<u64>,
    /// File with the problems of `tools/bench/peers` to resolve
    #[arg(long, hide = true, value_name = "FILE")]
    problems: Option<PathBuf>,
    /// File with the trajectory of `tools/bench/peers` to resolve
    #[arg(long, hide = true, value_name = "FILE")]
    trajectory: Option<PathBuf>,
    /// File with the hierarchies of `tools/bench/peers` to resolve
    #[arg(long, hide = true, value_name = "FILE")]
    hierarchies: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
    /// Directory for figures
    #[arg(long, value_name = "DIR")]
    figures: Option<PathBuf>,
    /// Markdown document in which tables marked `<!-- bench:NAME -->` are replaced; may be repeated
    #[arg(long, value_name = "FILE")]
    fill: Vec<PathBuf>,
}

/// Parses a time of up to one hour.
fn seconds(text: &str) -> Result<f64, String> {
    let seconds: f64 = text.parse().map_err(|_| "must be a number".to_owned())?;
    if (0.001..=3600.0).contains(&seconds) { Ok(seconds) } else { Err("must be between 0.001 and 3600".to_owned()) }
}

pub fn run(options: &Options) -> Result<(), BenchError> {
    let groups = if options.only.is_empty() { Group::ALL.to_vec() } else { options.only.clone() };
    let pacing_s = if options.quick { options.seconds.min(0.05) } else { options.seconds };
    let plan = Plan { groups, quick: options.quick, pacing_s };
    if let Some(what) = options.repeat {
        return repeat(what, options.times.unwrap_or(1));
    }
    let files = [&options.problems, &options.trajectory, &options.hierarchies];
    if files.iter().any(|file| file.is_some()) {
        let ways = [problems::lines, problems::trajectory_lines, hierarchies::lines];
        for (file, lines) in files.into_iter().zip(ways) {
            let lines = file.as_ref().map_or(Ok(Vec::new()), |file| lines(file, plan.rows()))?;
            lines.iter().try_for_each(|line| writeln!(stdout(), "{line}"))?;
        }
        return Ok(());
    }
    let report = Report::measured(&plan, |group| drop(writeln!(stderr(), "measuring: {group:?}")))?;
    if let Some(directory) = &options.figures {
        report.write_figures(directory)?;
    }
    options.fill.iter().try_for_each(|document| report.fill(document))?;
    let text =
        if options.json { serde_json::to_string_pretty(&report).unwrap_or_default() + "\n" } else { report.text() };
    Ok(stdout().write_all(text.as_bytes())?)
}
