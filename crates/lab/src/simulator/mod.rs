//! A simulated arm with its environment, which calls a service once per control period.
//!
//! The simulator uses the kinematics of the robot and the interface of the service. It does not use the control code, so a
//! simulated arm gets the same commands as any other client.
//!
//! A [`Scenario`] describes a whole run: controller, start posture, contacts (springs, surfaces that may move and have
//! friction, doors), external pushes, targets that an application streams, velocity loop, sensor errors, and faults of the
//! connection. Noise and faults depend on its seed only, so a run is reproducible to the last bit.

mod arm;
mod callee;
mod caller;
mod contact;
mod door;
mod drive_limits;
mod energy;
mod environment;
mod faults;
mod field_error;
mod lossy_channel;
mod moving_obstacles;
mod operator;
mod plant;
mod profile;
mod random;
pub mod recording;
#[cfg(feature = "files")]
pub mod replay;
mod request;
mod run;
mod run_error;
mod scenario;
mod scenario_name;
mod sensors;
mod shape;
mod stateless;
mod surface;
mod target_program;
mod toml_lines;
mod watchdog;
mod wrist_sensor;

pub use arm::{Arm, VelocityLoop};
pub use caller::CallMode;
pub use contact::{Contact, ContactKind, Edge, Friction, Hinge, Hole};
pub use drive_limits::DriveLimits;
pub use environment::Environment;
pub use faults::{Faults, Outage};
pub use field_error::FieldError;
pub use moving_obstacles::ObstacleMotion;
pub use operator::{Ending, Influence, Observed, Operator};
pub use request::{NamedScenario, ScenarioEntry, ScenarioList, SimulationRequest};
pub use run::{SteppedRun, built_in_robot, run, run_operated, run_robot};
pub use run_error::RunError;
pub use scenario::{BUILT_IN_SCENARIOS, PAPER_SCENARIOS, Scenario, ScenarioError};
pub use scenario_name::name_pattern;
pub use sensors::{Sensor, Sensors};
pub use stateless::Cycle;
pub use target_program::TargetProgram;
