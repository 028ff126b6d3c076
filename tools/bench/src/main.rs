//! Measures the speed of revprio next to other programs.
//!
//! ```text
//! core, http, pacing ─→ rows ────┐
//! growth ────────────→ series ───┴→ Report ─→ text, JSON, Markdown in documents, figures
//! ```
//!
//! Absolute times depend on the machine, its load and its clock, so each time is compared with a peer in the same run. Peers
//! in Rust (nalgebra, faer, Clarabel, a bare axum route, a bare TCP connection) run here, peers in C++ and Python in
//! `tools/bench/peers`. No result passes or fails.

mod core;
mod document;
mod error;
mod growth;
mod hierarchies;
mod http;
mod load;
mod options;
mod pacing;
mod plan;
mod plot;
mod problems;
mod repeat;
mod report;
mod row;
mod series;
mod timing;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

use self::error::BenchError;

/// Benchmarks and load test of revprio.
#[derive(Debug, Parser)]
#[command(version, arg_required_else_help = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Measure speed next to other programs.
    Bench(options::Options),
    /// Test a server under 1, 2 and 10 times its capacity, and with slow clients.
    Load(load::Options),
    /// The server under load: `revprio serve` with these arguments.
    #[command(hide = true)]
    Serve {
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        arguments: Vec<String>,
    },
}

fn main() -> ExitCode {
    let ended = match Cli::parse().command {
        Command::Bench(options) => options::run(&options),
        Command::Load(options) => load::run(&options),
        Command::Serve { arguments } => serve(arguments),
    };
    match ended {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn serve(arguments: Vec<String>) -> Result<(), BenchError> {
    let command = ["revprio", "serve"].map(str::to_owned).into_iter().chain(arguments);
    Ok(revprio::cli::Cli::parse_from(command).run()?)
}
