//! `revprio scenarios`

use revprio_lab::simulator::ScenarioList;

use super::error::CliError;
use super::output::print_text;
use super::text::{WIDTH, wrapped};

pub fn run() -> Result<(), CliError> {
    let scenarios = ScenarioList::built_in()?.scenarios;
    for scenario in scenarios {
        let description = wrapped(&scenario.description, WIDTH - 4).join("\n    ");
        print_text(format_args!("{} ({})\n    {description}\n", scenario.name, scenario.robot))?;
    }
    Ok(())
}
