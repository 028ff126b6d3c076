//! `revprio scenarios`: the scenarios that ship with the program.

use revprio_lab::simulator::{BUILT_IN_SCENARIOS, ScenarioList};

use super::error::CliError;
use super::known::known_scenario;
use super::output::print_text;
use super::text::{WIDTH, wrapped};

#[derive(Debug, clap::Args)]
pub struct Options {
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Debug, clap::Subcommand)]
enum Command {
    /// List the scenarios (default)
    List,
    /// Print the file of a scenario, to change it and run it: `revprio scenarios show press > mine.toml`
    Show {
        /// Name of a built-in scenario
        #[arg(value_parser = known_scenario())]
        scenario: String,
    },
}

pub fn run(options: &Options) -> Result<(), CliError> {
    match &options.command {
        None | Some(Command::List) => list(),
        Some(Command::Show { scenario }) => show(scenario),
    }
}

fn list() -> Result<(), CliError> {
    let scenarios = ScenarioList::built_in()?.scenarios;
    for scenario in scenarios {
        let description = wrapped(&scenario.description, WIDTH - 4).join("\n    ");
        print_text(format_args!("{} ({})\n    {description}\n", scenario.name, scenario.robot))?;
    }
    Ok(())
}

fn show(name: &str) -> Result<(), CliError> {
    let text = BUILT_IN_SCENARIOS.iter().find_map(|(known, text)| (*known == name).then_some(*text));
    Ok(print_text(text.unwrap_or_default())?)
}
