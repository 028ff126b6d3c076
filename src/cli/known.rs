//! Words that completions know: built-in scenarios and robots.

use clap::builder::{PossibleValue, PossibleValuesParser, StringValueParser, TypedValueParser};
use clap::{Arg, Command, Error};
use revprio_lab::simulator::BUILT_IN_SCENARIOS;
use revprio_robot::built_in;
use std::ffi::OsStr;

/// Returns a parser of the name of a built-in robot.
pub fn known_robot() -> PossibleValuesParser {
    PossibleValuesParser::new(built_in().iter().map(|robot| robot.name().to_owned()))
}

/// Returns a parser of the name of a built-in scenario.
pub fn known_scenario() -> PossibleValuesParser {
    PossibleValuesParser::new(BUILT_IN_SCENARIOS.map(|(name, _)| name))
}

/// A parser of the name of a built-in scenario, or of any other text: the path of a file.
#[derive(Debug, Clone, Copy)]
pub struct ScenarioName;

impl TypedValueParser for ScenarioName {
    type Value = String;

    fn parse_ref(&self, command: &Command, argument: Option<&Arg>, value: &OsStr) -> Result<String, Error> {
        StringValueParser::new().parse_ref(command, argument, value)
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        Some(Box::new(BUILT_IN_SCENARIOS.into_iter().map(|(name, _)| PossibleValue::new(name))))
    }
}
