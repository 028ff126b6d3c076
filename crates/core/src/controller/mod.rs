//! The controller: computes a command from a measurement, once per control period.
//!
//! [`Controller::new`] checks a [`ControllerConfig`] once. A [`Stepper`] owns a controller and its workspace.
//! [`Stepper::step`] checks each [`Measurement`] and computes the [`Command`]. The caller keeps the [`Memory`] from
//! period to period.
//!
//! ```
//! use revprio_core::rows::{TaskRows, ToolRows};
//! use revprio_core::controller::{Controller, ControllerConfig, Measurement, Stepper, TaskConfig};
//! use revprio_core::law::{ForceLaw, Gains, Law, Profile};
//! use revprio_core::robot::built_in;
//! use revprio_core::robot::kinematics::{Axis, AxisSelection};
//! use revprio_core::streaming::Streaming;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let gains = Gains::new(1, &[15.0], &[150.0], &[0.0])?; // kg, N·s/m, N/m
//! let law = ForceLaw::new(gains, Profile::constant(vec![30.0])?).ok_or("sizes differ")?; // N
//! let rows = TaskRows::Tool(ToolRows::new(AxisSelection::new(&[Axis::X])?));
//! let streaming = Streaming::default();
//! let push = TaskConfig { name: "push".to_owned(), rows, law: Law::Force(law), scaled: false, streaming };
//! let controller = Controller::new(ControllerConfig::new(built_in()[0].clone(), 0.001, vec![push]))?;
//! let mut stepper = Stepper::new(controller)?;
//!
//! let measured = Measurement { obstacles: Vec::new(), wrenches: Vec::new(),
//!     time_s: 0.0,
//!     joint_position: vec![2.9, -0.4, 3.0, 2.1, 3.0, -0.6, 0.2],
//!     joint_velocity: None,
//!     wrench: [0.0; 6],
//!     targets: Vec::new(),
//!     chunks: Vec::new(),
//!     channels: Vec::new(),
//! };
//! let mut memory = None;
//! let command = stepper.step(&mut memory, &measured)?;
//! // At rest and without contact: ẋ = T F_d / M_d after one period.
//! assert!((command.resolution.tasks[0].achieved[0] - 0.001 * 30.0 / 15.0).abs() < 1e-12);
//! assert!(memory.is_some());
//! # Ok(())
//! # }
//! ```

mod config;
mod period;
mod stability;
mod state;
mod stepper;
mod transition;

pub use crate::wrench::{WrenchConvention, WrenchFrame};
pub use config::{
    AntiWindup, ConfigError, Controller, ControllerConfig, HOLDING_SPEED, Limits, NullSpaceError, NullSpaceMotion,
    SteepGain, TaskConfig, TaskConfigError,
};
pub use period::{BRAKING_SHARE, MAX_ATTEMPTS};
pub use stability::{ContactLoop, EigenvalueError, MAX_DELAY_PERIODS, Margin, StabilityError, StableDamping};
pub use state::{
    AnsweredState, Command, JerkState, JointTurns, LEAVING_TIME, LINE_INTERVALS, Line, Measurement, Memory,
    MemoryError, Obstacle, Progress, RestState, Stall, StalledJoint, StepError, StuckTask, TIMES_AHEAD, TaskGain,
    TaskTarget, TipWrench, UNIX_TIME_S, VirtualArm,
};
pub use stepper::Stepper;
pub use transition::TransitionError;
