//! Experiments as files.

use std::path::Path;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::arm::VelocityLoop;
use super::environment::Contact;
use crate::wire::{self, object};

/// An experiment: a controller, where the arm starts, what it touches, for how long.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// Name, as in `force_tracking`.
    pub name: String,
    /// What it is about, one line.
    pub description: String,
    /// Simulated time, s.
    pub duration_s: f64,
    /// q at the start, n, rad or m.
    pub start_joint_position: Vec<f64>,
    /// How the arm follows its commands.
    #[serde(default, deserialize_with = "object::deserialize")]
    pub velocity_loop: VelocityLoop,
    /// What the tool touches.
    #[serde(default, deserialize_with = "object::list")]
    pub contacts: Vec<Contact>,
    /// The controller, as in a request.
    #[serde(deserialize_with = "object::deserialize")]
    pub controller: wire::Controller,
}

/// Why a scenario is refused.
#[derive(Debug, thiserror::Error)]
pub enum ScenarioError {
    /// The file cannot be read.
    #[error("cannot read {path}: {source}")]
    Read {
        /// The file.
        path: String,
        /// What the system says.
        source: std::io::Error,
    },
    /// Not TOML, or not the fields of a scenario; says the line.
    #[error("{path}: {source}")]
    Toml {
        /// The file.
        path: String,
        /// What is wrong.
        source: Box<toml::de::Error>,
    },
    /// Not JSON, or not the fields of a scenario; says the line.
    #[error("{path}: {source}")]
    Json {
        /// The file.
        path: String,
        /// What is wrong.
        source: serde_json::Error,
    },
    /// A quantity makes no sense.
    #[error("{path}: `{field}` {problem}")]
    Field {
        /// The file.
        path: String,
        /// The field.
        field: &'static str,
        /// What is wrong with it.
        problem: &'static str,
    },
    /// Neither a scenario that ships with the crate nor a file.
    #[error("there is no scenario `{name}`; known: {known}; or give a file (.toml or .json)")]
    Unknown {
        /// The name.
        name: String,
        /// All names.
        known: String,
    },
}

macro_rules! built_in {
    ($($name:literal),+) => { [$(($name, include_str!(concat!("../../fixtures/scenarios/", $name, ".toml")))),+] };
}

/// The scenarios that ship with the crate: name and TOML text.
pub const BUILT_IN_SCENARIOS: [(&str, &str); 4] =
    built_in!["force_tracking", "force_tracking_singular", "stiff_wall", "stiff_wall_singular"];

impl Scenario {
    /// A scenario that ships with the crate; never a file.
    pub fn built_in(name: &str) -> Option<Result<Self, ScenarioError>> {
        let (name, text) = BUILT_IN_SCENARIOS.iter().find(|(known, _)| *known == name)?;
        Some(Self::parse(text, name))
    }

    /// Names of the scenarios that ship with the crate.
    pub fn names() -> String {
        BUILT_IN_SCENARIOS.map(|(name, _)| name).join(", ")
    }

    /// A scenario that ships with the crate, by name, or a file, by path.
    pub fn find(name_or_path: &str) -> Result<Self, ScenarioError> {
        if let Some(scenario) = Self::built_in(name_or_path) {
            return scenario;
        }
        let is_file = Path::new(name_or_path).extension().is_some_and(|ending| ending == "toml" || ending == "json");
        if !is_file {
            return Err(ScenarioError::Unknown { name: name_or_path.to_owned(), known: Self::names() });
        }
        let text = std::fs::read_to_string(name_or_path)
            .map_err(|source| ScenarioError::Read { path: name_or_path.to_owned(), source })?;
        Self::parse(&text, name_or_path)
    }

    /// Reads a scenario; JSON if `path` ends so, TOML otherwise.
    pub fn parse(text: &str, path: &str) -> Result<Self, ScenarioError> {
        let scenario: Self = if Path::new(path).extension().is_some_and(|ending| ending == "json") {
            serde_json::from_str(text).map_err(|source| ScenarioError::Json { path: path.to_owned(), source })?
        } else {
            toml::from_str(text)
                .map_err(|source| ScenarioError::Toml { path: path.to_owned(), source: Box::new(source) })?
        };
        match scenario.flaw() {
            None => Ok(scenario),
            Some((field, problem)) => Err(ScenarioError::Field { path: path.to_owned(), field, problem }),
        }
    }

    /// The controller with the scenario's own contacts and velocity loop as its environment, where it states none, so
    /// that the service can warn. Several contacts on an axis add up.
    pub fn controller_in_environment(&self) -> wire::Controller {
        let along = |axis: usize| {
            let contacts = self.contacts.iter().filter(|contact| contact.axis == axis);
            contacts.fold(None, |sum: Option<wire::EnvironmentAxis>, contact| {
                let sum = sum.unwrap_or(wire::EnvironmentAxis { stiffness: 0.0, damping: 0.0, inertia: 0.0 });
                Some(wire::EnvironmentAxis {
                    stiffness: sum.stiffness + contact.stiffness,
                    damping: sum.damping + contact.damping,
                    inertia: sum.inertia + contact.inertia,
                })
            })
        };
        let environment = wire::Environment {
            x: along(0),
            y: along(1),
            z: along(2),
            rx: None,
            ry: None,
            rz: None,
            lag_s: self.velocity_loop.lag_s,
            delay_periods: self.velocity_loop.delay_periods,
            velocity_measured: true,
        };
        let stated = self.controller.environment.or(Some(environment));
        wire::Controller { environment: stated, ..self.controller.clone() }
    }

    /// T, s.
    pub fn period_s(&self) -> f64 {
        self.controller.period_s
    }

    /// Control periods of a run.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "checked: 1 to 10^8 periods")]
    pub fn cycles(&self) -> u64 {
        (self.duration_s / self.period_s()).round() as u64
    }

    /// The first field that makes no sense, and why; numbers of the controller itself are the service's to judge.
    pub fn flaw(&self) -> Option<(&'static str, &'static str)> {
        let finite = |v: f64| v.is_finite();
        let not_negative = |v: f64| v.is_finite() && v >= 0.0;
        let sound = |c: &Contact| {
            finite(c.offset_m) && not_negative(c.stiffness) && not_negative(c.damping) && not_negative(c.inertia)
        };
        let periods = self.duration_s / self.period_s();
        if !(self.period_s() > 0.0 && self.period_s().is_finite()) {
            return Some(("controller.period_s", "must be a positive number"));
        }
        if !(0.5..=1e8).contains(&periods) {
            return Some(("duration_s", "must be positive and at most 10^8 periods"));
        }
        if !self.start_joint_position.iter().copied().all(finite) {
            return Some(("start_joint_position", "must be finite numbers"));
        }
        if !not_negative(self.velocity_loop.lag_s) {
            return Some(("velocity_loop.lag_s", "must not be negative"));
        }
        if self.velocity_loop.delay_periods > 10_000 {
            return Some(("velocity_loop.delay_periods", "is out of range; at most 10000"));
        }
        (!self.contacts.iter().all(sound))
            .then_some(("contacts", "need a finite offset, and stiffness, damping and inertia that are not negative"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_built_in_scenarios_are_read_and_named_after_their_files() {
        for (name, _) in BUILT_IN_SCENARIOS {
            assert_eq!(Scenario::find(name).unwrap().name, name);
        }
    }

    #[test]
    fn errors_say_the_line_or_the_field() {
        let (_, text) = BUILT_IN_SCENARIOS[0];
        let refusal = |from: &str, to: &str| {
            assert!(text.contains(from));
            Scenario::parse(&text.replacen(from, to, 1), "mine.toml").unwrap_err().to_string()
        };
        assert!(refusal("duration_s", "durations").contains("line "));
        assert!(refusal("duration_s = 20.0", "duration_s = -1.0").contains("`duration_s`"));
        assert!(refusal("stiffness = 1000.0", "stiffness = -1.0").contains("`contacts`"));
        assert!(Scenario::find("force_trackin").unwrap_err().to_string().contains("known: force_tracking,"));
        assert!(Scenario::find("no_such.toml").unwrap_err().to_string().contains("cannot read no_such.toml"));
    }

    #[test]
    fn a_scenario_in_json_is_the_same() {
        let scenario = Scenario::find("stiff_wall").unwrap();
        let json = serde_json::to_string(&scenario).unwrap();
        assert_eq!(Scenario::parse(&json, "mine.json").unwrap(), scenario);
    }
}
