//! A simulated arm and its environment, which call the service over HTTP once per control period.
//!
//! The simulator knows the robot's kinematics and the interface of the service, nothing of control or resolution: what
//! it shows is what any client would get.
//!
//! A [`Scenario`] says all of a run: the controller, the start, contacts (springs, walls and planes that may move and drag),
//! pushes, the velocity loop, sensors with errors, a line with faults. Noise and faults come from its seed, so that a run
//! can be had again to the last bit.

mod arm;
mod caller;
mod chance;
mod contact;
mod drive_limits;
mod energy;
mod environment;
mod faults;
mod field_error;
mod lossy_channel;
mod operator;
mod plant;
mod profile;
pub mod recording;
pub mod replay;
mod request;
mod run;
mod scenario;
mod sensors;
mod stateless;
mod surface;
mod toml_lines;
mod watchdog;

pub use arm::{Arm, VelocityLoop};
pub use contact::{Contact, ContactKind, Friction};
pub use drive_limits::DriveLimits;
pub use environment::Environment;
pub use faults::{Faults, Outage};
pub use field_error::FieldError;
pub use operator::{Cycle, Ending, Influence, Observed, Operator};
pub use request::{NamedScenario, ScenarioEntry, ScenarioList, SimulationRequest};
pub use run::{CallMode, RunError, built_in_robot, run, run_operated, run_robot};
pub use scenario::{BUILT_IN_SCENARIOS, PAPER_SCENARIOS, Scenario, ScenarioError};
pub use sensors::{Sensor, Sensors};
