//! Request and answer bodies that contain scenarios.

use revprio_api::wire::string_or_map::{self, StringOrMap};
use revprio_api::wire::{Interactive, Method, Solver, object};
use serde::de::{Error, MapAccess, value::MapAccessDeserializer};
use serde::{Deserialize, Deserializer, Serialize};
use utoipa::ToSchema;

use super::scenario::{BUILT_IN_SCENARIOS, Scenario, ScenarioError};

/// A simulation to run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SimulationRequest {
    /// Name of a scenario from `GET /v1/scenarios`, or a whole scenario.
    pub scenario: NamedScenario,
    /// Method, instead of the method of the scenario. Set it to compare.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub method: Option<Method>,
    /// Solver, instead of the solver of the scenario. Set it to compare.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub solver: Option<Solver>,
    /// Interactive run: paced by the clock, shown live, and controlled by `POST /v1/simulations/{id}/control`. If left out, the
    /// simulation runs as fast as possible.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub interactive: Option<Interactive>,
}

/// A scenario, by name or in full.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
#[serde(untagged)]
pub enum NamedScenario {
    /// Name of a scenario that ships with the service.
    BuiltIn(String),
    /// A whole scenario.
    Own(Box<Scenario>),
}

impl<'de> Deserialize<'de> for NamedScenario {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        string_or_map::deserialize(deserializer)
    }
}

impl StringOrMap for NamedScenario {
    const EXPECTED: &'static str = "the name of a scenario, or a scenario";

    fn from_string<E: Error>(text: &str) -> Result<Self, E> {
        Ok(Self::BuiltIn(text.to_owned()))
    }

    fn from_map<'de, A: MapAccess<'de>>(map: A) -> Result<Self, A::Error> {
        Scenario::deserialize(MapAccessDeserializer::new(map)).map(|scenario| Self::Own(Box::new(scenario)))
    }
}

/// Answer to `GET /v1/scenarios`.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct ScenarioList {
    /// The scenarios that ship with the service.
    pub scenarios: Vec<ScenarioEntry>,
}

/// One scenario of the list.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct ScenarioEntry {
    /// Name.
    pub name: String,
    /// Description in one line.
    pub description: String,
    /// Name of its robot.
    pub robot: String,
    /// The whole scenario.
    pub scenario: Scenario,
}

impl ScenarioList {
    /// Returns the scenarios that ship with the crate.
    pub fn built_in() -> Result<Self, ScenarioError> {
        let entry = |(name, _)| {
            let scenario = Scenario::find(name)?;
            Ok(ScenarioEntry {
                name: scenario.name.clone(),
                description: scenario.description.clone(),
                robot: scenario.controller.robot.clone(),
                scenario,
            })
        };
        BUILT_IN_SCENARIOS.into_iter().map(entry).collect::<Result<_, _>>().map(|scenarios| Self { scenarios })
    }
}
