//! Scenarios: experiments as files.

use std::path::Path;

use revprio_api::wire::read_error::{in_plain_words, nearest};
use revprio_api::wire::{self, integer, object};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::arm::VelocityLoop;
use super::contact::Contact;
use super::environment::Environment;
use super::faults::Faults;
use super::field_error::{FieldError, between, number, positive};
use super::moving_obstacles::{MovingObstacles, ObstacleMotion};
use super::profile::external_wrench;
use super::scenario_name::check_name;
use super::sensors::{Sensing, Sensors};
use super::shape::share_along;
use super::target_program::{TargetProgram, TargetPrograms};
use super::toml_lines;

/// Largest number of integration steps per period.
const MAX_SUBSTEPS: usize = 1000;

/// Largest seed: the largest integer that every JSON client represents exactly.
const MAX_SEED: u64 = (1 << 53) - 1;

/// An experiment: controller, start posture, contacts and duration.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// Name, as in `force_tracking`.
    pub name: String,
    /// Description in one line.
    pub description: String,
    /// Expected result, in words.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub expectation: String,
    /// Simulated duration, s.
    pub duration_s: f64,
    /// Joint positions q at the start, n, rad or m.
    pub start_joint_position: Vec<f64>,
    /// How the arm follows its commands.
    #[serde(default, deserialize_with = "object::deserialize")]
    pub velocity_loop: VelocityLoop,
    /// Contacts of the tool.
    #[serde(default, deserialize_with = "object::list")]
    pub contacts: Vec<Contact>,
    /// External force and torque on the tool at the tool point, base axes, N and N·m: six values over time.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub external_wrench: Option<wire::Profile>,
    /// How obstacles of the controller move that have `moves: true`; those without a motion stand.
    #[serde(default, deserialize_with = "object::list", skip_serializing_if = "Vec::is_empty")]
    #[schema(example = json!([{"name": "ball", "displacement": {"kind": "constant", "value": [0, 0.1, 0]}}]))]
    pub obstacle_motions: Vec<ObstacleMotion>,
    /// Programs that stream targets of tasks, as an application would.
    #[serde(default, deserialize_with = "object::list", skip_serializing_if = "Vec::is_empty")]
    #[schema(example = json!([{"kind": "spiral_search", "task": "search", "pitch_m": 0.001, "speed": 0.01, "inserted_m": 0.003}]))]
    pub target_programs: Vec<TargetProgram>,
    /// Errors of the sensors.
    #[serde(default, deserialize_with = "object::deserialize", skip_serializing_if = "is_default")]
    pub sensors: Sensors,
    /// Faults of the connection between arm and service.
    #[serde(default, deserialize_with = "object::deserialize", skip_serializing_if = "is_default")]
    pub faults: Faults,
    /// Seed of noise and faults; the same seed gives the same run.
    #[serde(default, deserialize_with = "integer::deserialize", skip_serializing_if = "is_default")]
    pub seed: u64,
    /// Integration steps of arm and contacts per period.
    #[serde(default = "one", deserialize_with = "integer::deserialize", skip_serializing_if = "is_one")]
    pub substeps: usize,
    /// The controller, as in a request.
    #[serde(deserialize_with = "object::deserialize")]
    pub controller: wire::Controller,
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

fn one() -> usize {
    1
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde hands over a reference")]
fn is_one(value: &usize) -> bool {
    *value == 1
}

/// Why a scenario cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum ScenarioError {
    /// The file cannot be read.
    #[error("cannot read {path}: {source}")]
    Read {
        /// The file.
        path: String,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// The file is not valid TOML, or not a scenario. The message names the line.
    #[error("{path}: {}", in_plain_words(&source.to_string()))]
    Toml {
        /// The file.
        path: String,
        /// The error.
        source: Box<toml::de::Error>,
    },
    /// The file is not valid JSON, or not a scenario. The message names the line.
    #[error("{path}: {}", in_plain_words(&source.to_string()))]
    Json {
        /// The file.
        path: String,
        /// The error.
        source: serde_json::Error,
    },
    /// A value is not valid. The message names the line of a TOML file.
    #[error("{path}{}: {error}", line.map(|line| format!(", line {line}")).unwrap_or_default())]
    Field {
        /// The file.
        path: String,
        /// The line, from 1.
        line: Option<usize>,
        /// The error.
        error: FieldError,
    },
    /// Neither the name of a scenario nor of a file.
    #[error(
        "there is no scenario `{name}`; {}known: {}; or give a file (.toml or .json)",
        guess(name),
        Scenario::names()
    )]
    Unknown {
        /// The name.
        name: String,
    },
}

macro_rules! built_in {
    ($($name:literal),+) => { [$(($name, include_str!(concat!("../../scenarios/", $name, ".toml")))),+] };
}

/// The scenarios that ship with the crate, as name and TOML text. The scenarios of the paper come first.
pub const BUILT_IN_SCENARIOS: [(&str, &str); 24] = built_in![
    "force_tracking",
    "force_tracking_singular",
    "stiff_wall",
    "stiff_wall_singular",
    "stiff_wall_limits",
    "stiff_wall_limits_clamped",
    "stiff_wall_lag",
    "stiff_wall_lag_damped",
    "stiff_wall_acceleration",
    "stiff_wall_acceleration_slow",
    "joint_limits",
    "task_conflict",
    "moving_wall",
    "polishing",
    "press",
    "wiping",
    "wiping_curved",
    "door",
    "peg",
    "peg_edge",
    "human_push",
    "ur5e_wall",
    "noisy_sensors",
    "lossy_line"
];

/// Asks for the scenario that was probably meant, if one is near.
fn guess(name: &str) -> String {
    let known = BUILT_IN_SCENARIOS.map(|(known, _)| known);
    nearest(name, &known).map(|known| format!("did you mean `{known}`? ")).unwrap_or_default()
}

/// Names of the scenarios of the paper.
pub const PAPER_SCENARIOS: [&str; 4] =
    ["force_tracking", "force_tracking_singular", "stiff_wall", "stiff_wall_singular"];

impl Scenario {
    /// Returns a scenario that ships with the crate.
    pub fn built_in(name: &str) -> Option<Result<Self, ScenarioError>> {
        let (name, text) = BUILT_IN_SCENARIOS.iter().find(|(known, _)| *known == name)?;
        Some(Self::parse(text, name))
    }

    /// Returns the names of the scenarios that ship with the crate.
    pub fn names() -> String {
        BUILT_IN_SCENARIOS.map(|(name, _)| name).join(", ")
    }

    /// Returns a scenario that ships with the crate, by name, or reads a file, by path.
    pub fn find(name_or_path: &str) -> Result<Self, ScenarioError> {
        if let Some(scenario) = Self::built_in(name_or_path) {
            return scenario;
        }
        let is_file = Path::new(name_or_path).extension().is_some_and(|ending| ending == "toml" || ending == "json");
        if !is_file {
            return Err(ScenarioError::Unknown { name: name_or_path.to_owned() });
        }
        let text = std::fs::read_to_string(name_or_path)
            .map_err(|source| ScenarioError::Read { path: name_or_path.to_owned(), source })?;
        Self::parse(&text, name_or_path)
    }

    /// Parses a scenario: JSON if `path` ends in `.json`, otherwise TOML.
    pub fn parse(text: &str, path: &str) -> Result<Self, ScenarioError> {
        let scenario: Self = if Path::new(path).extension().is_some_and(|ending| ending == "json") {
            serde_json::from_str(text).map_err(|source| ScenarioError::Json { path: path.to_owned(), source })?
        } else {
            toml::from_str(text)
                .map_err(|source| ScenarioError::Toml { path: path.to_owned(), source: Box::new(source) })?
        };
        match scenario.check() {
            Ok(()) => Ok(scenario),
            Err(error) => {
                let line = toml_lines::line_of(text, &error.pointer);
                Err(ScenarioError::Field { path: path.to_owned(), line, error })
            }
        }
    }

    /// Returns where a field of the controller, by its JSON pointer, is in the file of a scenario; `None` for a scenario that ships with the
    /// crate. The file may be JSON, whose lines are not known.
    pub fn place_of_controller_field(name_or_path: &str, pointer: &str) -> Option<String> {
        if Self::built_in(name_or_path).is_some() {
            return None;
        }
        let text = std::fs::read_to_string(name_or_path).ok()?;
        let line = toml_lines::line_of(&text, &format!("/controller{pointer}"));
        Some(format!("{name_or_path}{}", line.map(|line| format!(", line {line}")).unwrap_or_default()))
    }

    /// Returns the controller with an environment, so that the service can warn about instability. If the controller has none,
    /// it is made of the contacts and the velocity loop: contacts on the same axis are added, and an oblique plane
    /// contributes its share to each axis.
    pub fn controller_in_environment(&self) -> wire::Controller {
        let along = |axis: usize| {
            let shares = self.contacts.iter().map(|contact| (contact, share_along(contact, axis)));
            shares.filter(|(_, share)| *share > 0.0).fold(
                None,
                |sum: Option<wire::EnvironmentAxis>, (contact, share)| {
                    let sum = sum.unwrap_or(wire::EnvironmentAxis { stiffness: 0.0, damping: 0.0, inertia: 0.0 });
                    Some(wire::EnvironmentAxis {
                        stiffness: sum.stiffness + share * contact.stiffness,
                        damping: sum.damping + share * contact.damping,
                        inertia: sum.inertia + share * contact.inertia,
                    })
                },
            )
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

    /// Returns the control period T, s.
    pub fn period_s(&self) -> f64 {
        self.controller.period_s
    }

    /// Returns the number of control periods of a run.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "checked: 1 to 10^8 periods")]
    pub fn cycles(&self) -> u64 {
        (self.duration_s / self.period_s()).round() as u64
    }

    /// Checks all values except those of the controller, which the service checks. Returns the first error.
    pub fn check(&self) -> Result<(), FieldError> {
        check_name(&self.name, "/name")?;
        positive(self.period_s(), "/controller/period_s")?;
        if !(0.5..=1e8).contains(&(self.duration_s / self.period_s())) {
            return Err(FieldError::new("/duration_s", "must be positive and at most 10^8 periods long"));
        }
        for (i, q) in self.start_joint_position.iter().enumerate() {
            number(*q, &format!("/start_joint_position/{i}"))?;
        }
        self.velocity_loop.check("/velocity_loop")?;
        Environment::new(&self.contacts, [0.0; 3])?;
        self.external_wrench.as_ref().map(external_wrench).transpose()?;
        MovingObstacles::new(&self.controller, &self.obstacle_motions)?;
        TargetPrograms::new(&self.target_programs, &self.controller)?;
        Sensing::new(&self.sensors, self.start_joint_position.len(), self.period_s(), self.seed)?;
        self.faults.check("/faults")?;
        if self.seed > MAX_SEED {
            return Err(FieldError::new("/seed", "must be at most 2^53 - 1"));
        }
        between(self.substeps, 1, MAX_SUBSTEPS, "/substeps").map(drop)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_built_in_scenarios_are_valid_and_named_after_their_files() {
        for (name, _) in BUILT_IN_SCENARIOS {
            assert_eq!(Scenario::find(name).unwrap().name, name);
        }
    }

    #[test]
    fn errors_name_the_line_or_the_field() {
        let (_, text) = BUILT_IN_SCENARIOS[0];
        let refusal = |from: &str, to: &str| {
            assert!(text.contains(from));
            Scenario::parse(&text.replacen(from, to, 1), "mine.toml").unwrap_err().to_string()
        };
        assert!(refusal("duration_s", "durations").contains("line "));
        assert!(refusal("duration_s = 20.0", "duration_s = -1.0").contains("mine.toml, line 5: `duration_s` must be"));
        let named = refusal("name = \"force_tracking\"", "name = \"../../evil\"");
        assert!(named.contains("mine.toml, line 3: `name` becomes a part of file names: give 1 to 80"), "{named}");
        let stiffness = refusal("stiffness = 1000.0", "stiffness = -1.0");
        assert!(stiffness.contains("line 11: `contacts.0.stiffness` must not be negative"), "{stiffness}");
        assert!(Scenario::find("force_trackin").unwrap_err().to_string().contains("known: force_tracking,"));
        assert!(Scenario::find("no_such.toml").unwrap_err().to_string().contains("cannot read no_such.toml"));
    }

    #[test]
    fn scenario_in_json_is_the_same() {
        let scenario = Scenario::find("stiff_wall").unwrap();
        let json = serde_json::to_string(&scenario).unwrap();
        assert_eq!(Scenario::parse(&json, "mine.json").unwrap(), scenario);
    }
}
