//! `revprio scenarios`

use std::io::{Write as _, stdout};

use revprio_lab::simulator::ScenarioList;

use super::CliError;

pub fn run() -> Result<(), CliError> {
    let scenarios = ScenarioList::built_in()?.scenarios;
    let width = scenarios.iter().map(|scenario| scenario.name.len()).max().unwrap_or(0);
    for scenario in scenarios {
        writeln!(stdout(), "{:width$}  {} ({})", scenario.name, scenario.description, scenario.robot)?;
    }
    Ok(())
}
