//! `revprio scenarios`

use std::io::{Write as _, stdout};

use revprio_lab::simulator::ScenarioList;

use super::CliError;
use super::text::{WIDTH, wrapped};

pub fn run() -> Result<(), CliError> {
    let scenarios = ScenarioList::built_in()?.scenarios;
    for scenario in scenarios {
        writeln!(stdout(), "{} ({})", scenario.name, scenario.robot)?;
        for line in wrapped(&scenario.description, WIDTH - 4) {
            writeln!(stdout(), "    {line}")?;
        }
    }
    Ok(())
}
