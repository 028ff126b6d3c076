//! A simulated arm and its environment, which call the service over HTTP once per control period.
//!
//! The simulator knows the robot's kinematics and the interface of the service, nothing of control or resolution: what
//! it shows is what any client would get.

mod arm;
mod environment;
pub mod recording;
mod request;
mod run;
mod scenario;
mod watchdog;

pub use arm::{Arm, VelocityLoop};
pub use environment::{Contact, ContactKind, Environment};
pub use request::{NamedScenario, ScenarioEntry, ScenarioList, SimulationRequest};
pub use run::{CallMode, RunError, run, run_robot};
pub use scenario::{BUILT_IN_SCENARIOS, Scenario, ScenarioError};
