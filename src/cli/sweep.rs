//! `revprio sweep`: a scenario with many values of its parameters.
//!
//! ```text
//! scenario, --vary, --seeds ─→ Plan (cells) ─→ a row per cell, on all cores ─→ one Parquet file ─→ figures
//!                                                └→ partial file, with which an interrupted sweep continues
//! ```
//!
//! Every cell starts its own service on a loopback port, or all call `--server`. Cells are independent, so the table does
//! not depend on the number of threads or on the division into shards.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::str::FromStr;

use indicatif::ProgressBar;
use rayon::prelude::*;
use revprio_lab::report::number::significant;
use revprio_lab::simulator::Scenario;
use revprio_lab::simulator::recording::{Kind, Value};
use revprio_lab::sweep::{self, MEASURES, Partial, Plan, Rows, Seeds, Variation, Written, figures};

use super::error::CliError;
use super::known::ScenarioName;
use super::out_directory::{make_directory, set_aside};
use super::output::{print_remark, print_text};
use super::progress_bar::progress_bar;
use super::service_choice::server_address;
use super::target::Target;
use super::text::{WIDTH, columns};

#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Options {
    /// Name of a built-in scenario, or a file (.toml or .json)
    #[arg(required_unless_present = "merge", value_parser = ScenarioName, hide_possible_values = true)]
    scenario: Option<String>,
    /// A quantity and its values: a path in the scenario, then log:FROM..TO:COUNT, lin:FROM..TO:COUNT, or a list
    #[arg(long, value_name = "PATH=VALUES")]
    vary: Vec<Variation>,
    /// Run each combination with each of these seeds, for example 0..99
    #[arg(long)]
    seeds: Option<Seeds>,
    /// Service to call over HTTP, for example http://127.0.0.1:8080, with the token in the file `REVPRIO_TOKEN_FILE` if that is
    /// set; if left out, each cell starts its own on a free port
    #[arg(long, value_parser = server_address)]
    server: Option<String>,
    /// Number of threads; 0 means one per core
    #[arg(long, default_value_t = 0)]
    threads: usize,
    /// Run only the I-th of N parts, for several machines
    #[arg(long, value_name = "I/N")]
    shard: Option<Shard>,
    /// Merge the files of all shards instead of running anything
    #[arg(long, value_name = "FILE", num_args = 1.., conflicts_with_all = ["scenario", "vary", "seeds", "server", "shard"])]
    merge: Vec<PathBuf>,
    /// Measures to draw
    #[arg(long, value_delimiter = ',', default_value = "rmse_force_x_n,peak_force_x_n,settling_time_s")]
    draw: Vec<String>,
    /// Directory for table and figures. If it has the table of another sweep of this name, that one moves to its subdirectory
    /// `earlier-1`, `earlier-2` and so on
    #[arg(long, default_value = "revprio-out")]
    out: PathBuf,
}

/// Largest number of cells that are printed; the file has all.
const SHOWN_CELLS: usize = 20;

/// Number of causes that are printed why cells have no measures.
const SHOWN_CAUSES: usize = 10;

/// Largest width of a column's head.
const LONGEST_HEAD: usize = 16;

const EXAMPLES: &str = "Examples:
  revprio sweep stiff_wall --vary environment.stiffness=log:1e3..1e6:20 --vary loop.lag_s=0,0.005
  revprio sweep force_tracking_singular --vary method=reverse_priority,damped_least_squares
  revprio sweep my_scenario.toml --vary controller.tasks.0.law.damping=50,150,450 --seeds 0..99
  revprio sweep stiff_wall --vary loop.lag_s=lin:0..0.005:60 --shard 1/4 # on one of four
  revprio sweep --merge shards/*.parquet # afterwards

Paths are those of the scenario file, with `*` for all items of a list. `environment.` stands for `contacts.*.`, \
`loop.` for `velocity_loop.`, and `method`, `solver`, `limits` for the fields of the controller. To continue an \
interrupted sweep, run the same command again.";

/// Part of a sweep.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Shard {
    number: usize,
    of: usize,
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.split_once('/').and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
        let shard = parts.filter(|(number, of)| (1..=*of).contains(number)).map(|(number, of)| Self { number, of });
        shard.ok_or_else(|| format!("`{text}` is not a part; write for example 1/4 for the first of four"))
    }
}

pub fn run(options: &Options) -> Result<(), CliError> {
    let refused = CliError::Sweep;
    if let Some(unknown) = options.draw.iter().find(|name| !MEASURES.iter().any(|(known, _)| known == name)) {
        let known = MEASURES.map(|(name, _)| name).join(", ");
        return Err(refused(format!("there is no measure `{unknown}`; known: {known}")));
    }
    make_directory(&options.out)?;
    let Some(name) = &options.scenario else {
        let whole = sweep::merge(&options.merge).map_err(refused)?;
        let name = whole.identity.scenario["name"].as_str().unwrap_or_default();
        return refuse_none(finish(options, &format!("sweep-{name}"), &whole)?);
    };
    let scenario = Scenario::find(name)?;
    let variations = options.vary.iter().cloned().chain(options.seeds.map(Seeds::variation)).collect();
    let plan = Plan::new(&scenario, variations).map_err(refused)?;
    let columns = sweep::columns(&plan.variations);
    let part = options.shard.map(|shard| format!(".{}-of-{}", shard.number, shard.of)).unwrap_or_default();
    let label = format!("sweep-{}{part}", scenario.name);
    let path = options.out.join(format!("{label}.partial"));
    let opened = Partial::open(&path, &plan.identity(), &columns);
    let (partial, mut rows) = opened.map_err(|error| refused(format!("{}: {error}", path.display())))?;
    let all = (0..plan.cells()).filter(|cell| options.shard.is_none_or(|shard| cell % shard.of == shard.number - 1));
    let cells: Vec<usize> = all.filter(|cell| !rows.contains_key(cell)).collect();
    if !rows.is_empty() {
        print_remark(format_args!("{} cells are already completed", rows.len()));
    }
    rows.extend(run_cells(options, &plan, &cells, &partial, &label)?);
    let identity = plan.identity();
    let are_simulated = finish(options, &label, &Written { identity, rows })?;
    partial.remove().map_err(|error| refused(format!("cannot remove {}: {error}", path.display())))?;
    refuse_none(are_simulated)
}

/// Fails if no cell was simulated.
fn refuse_none(are_simulated: bool) -> Result<(), CliError> {
    if are_simulated { Ok(()) } else { Err(CliError::Sweep("no cell was simulated".to_owned())) }
}

/// Runs the cells on all threads.
fn run_cells(
    options: &Options,
    plan: &Plan,
    cells: &[usize],
    partial: &Partial,
    label: &str,
) -> Result<Rows, CliError> {
    let bar: ProgressBar = progress_bar(cells.len() as u64, label);
    let threads = rayon::ThreadPoolBuilder::new().num_threads(options.threads.min(cells.len().max(1))).build();
    let threads = threads.map_err(|error| CliError::Sweep(error.to_string()))?;
    let rows = threads.install(|| {
        // One cell at a time, because cells take long and their times differ.
        let cells = cells.par_iter().with_max_len(1);
        let rows = cells.map(|&cell| {
            let target = Target::open(options.server.as_deref())?;
            let row = sweep::row(plan, cell, &target.client)?;
            partial.add(&row).map_err(|error| CliError::Sweep(format!("cannot store a row: {error}")))?;
            bar.inc(1);
            Ok((cell, row))
        });
        rows.collect::<Result<Rows, CliError>>()
    })?;
    bar.finish();
    Ok(rows)
}

/// Writes the table and the figures, and prints the outcomes of the cells. Returns whether any cell was simulated.
fn finish(options: &Options, label: &str, whole: &Written) -> Result<bool, CliError> {
    let variations: Vec<Variation> = whole
        .identity
        .vary
        .iter()
        .map(|text| parse_variation(text))
        .collect::<Result<_, _>>()
        .map_err(CliError::Sweep)?;
    let kinds: Vec<(String, Kind)> = sweep::columns(&variations);
    let path = options.out.join(format!("{label}.parquet"));
    if path.exists() && !sweep::is_table_of(&path, &whole.identity) {
        let earlier = set_aside(&options.out, |name| is_file_of(name, label))?;
        print_remark(format_args!("the table of another sweep is now in {}", earlier.display()));
    }
    let written = sweep::write(&path, &whole.identity, &kinds, &whole.rows);
    written.map_err(|error| CliError::Sweep(format!("cannot write {}: {error}", path.display())))?;
    let drawn = figures::write(&options.out, label, &variations, &options.draw, &kinds, &whole.rows)?;
    let place = kinds.iter().position(|(name, _)| name == "outcome").unwrap_or(0);
    let ended = |word: &str| whole.rows.values().filter(|row| row[place] == Value::Word(word.to_owned())).count();
    let are_simulated = ended("finished") + ended("diverged") > 0;
    let outcomes = ["finished", "diverged", "refused", "failed"].map(|word| (ended(word), word));
    let outcomes: Vec<String> =
        outcomes.iter().filter(|(count, _)| *count > 0).map(|(count, word)| format!("{count} {word}")).collect();
    print_text(table(&variations, &options.draw, &kinds, &whole.rows))?;
    print_text(format_args!("{} cells: {}\n", whole.rows.len(), outcomes.join(", ")))?;
    print_text(causes(&kinds, &whole.rows))?;
    print_text(format_args!("table: {}\n", path.display()))?;
    for figure in drawn {
        print_text(format_args!("figure: {}\n", figure.display()))?;
    }
    Ok(are_simulated)
}

/// Returns whether a file is the table or a figure of a sweep.
fn is_file_of(name: &str, label: &str) -> bool {
    let Some((stem, ending)) = name.rsplit_once('.') else { return false };
    let is_figure =
        stem.strip_prefix(label).is_some_and(|rest| rest.starts_with('-')) && ["png", "svg"].contains(&ending);
    is_figure || (stem, ending) == (label, "parquet")
}

/// Formats why cells were refused or failed: each cause once, with the number of its cells.
fn causes(kinds: &[(String, Kind)], rows: &Rows) -> String {
    let place = kinds.iter().position(|(name, _)| name == "error");
    let words = rows.values().filter_map(|row| match row.get(place?)? {
        Value::Word(word) if !word.is_empty() => Some(word.as_str()),
        _ => None,
    });
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    words.for_each(|word| *counts.entry(word).or_default() += 1);
    let line = |(cause, count): (&str, usize)| format!("  {count} of them: {cause}\n");
    let rest = counts.len().saturating_sub(SHOWN_CAUSES);
    let more = if rest > 0 { format!("  … and {rest} more causes\n") } else { String::new() };
    counts.into_iter().take(SHOWN_CAUSES).map(line).collect::<String>() + &more
}

/// Formats the varied quantities, the outcome and the drawn measures of the first cells.
fn table(variations: &[Variation], drawn: &[String], kinds: &[(String, Kind)], rows: &Rows) -> String {
    let varied = variations.iter().map(|variation| variation.path.as_str());
    let names: Vec<&str> = varied.chain(["outcome"]).chain(drawn.iter().map(String::as_str)).collect();
    let mut places: Vec<usize> =
        names.iter().filter_map(|name| kinds.iter().position(|(known, _)| known == name)).collect();
    let cell = |value: &Value| match value {
        Value::Missing => "–".to_owned(),
        Value::Number(number) => significant(*number, 4),
        Value::Count(count) => count.to_string(),
        Value::Flag(flag) => flag.to_string(),
        Value::Word(word) => word.clone(),
    };
    // The last measures are left out of a table that is too wide.
    let table = loop {
        let head = places.iter().map(|&place| short(&kinds[place].0)).collect();
        let line = |row: &Vec<Value>| places.iter().map(|&place| cell(&row[place])).collect();
        let lines: Vec<Vec<String>> = std::iter::once(head).chain(rows.values().take(SHOWN_CELLS).map(line)).collect();
        let table = columns(&lines, |_| true);
        let is_wide = table.lines().any(|line| line.chars().count() > WIDTH);
        if !(is_wide && places.len() > variations.len() + 1) {
            break table;
        }
        places.pop();
    };
    let more = rows.len().saturating_sub(SHOWN_CELLS);
    let rest = if more > 0 { format!("… and {more} more\n") } else { String::new() };
    table + &rest
}

/// Returns the end of a long path, which tells most.
fn short(name: &str) -> String {
    let count = name.chars().count();
    if count <= LONGEST_HEAD {
        name.to_owned()
    } else {
        format!("…{}", name.chars().skip(count + 1 - LONGEST_HEAD).collect::<String>())
    }
}

/// Parses a quantity of a sweep file.
fn parse_variation(text: &str) -> Result<Variation, String> {
    match text.strip_prefix("seed=").map(Seeds::from_str) {
        Some(Ok(seeds)) => Ok(seeds.variation()),
        _ => text.parse(),
    }
}
