//! The controller: one call per control period, measurement in, command out.

mod config;
mod memory;
mod stability;
mod step;

pub use config::{ConfigError, ControllerConfig, Limits, TargetPose, TaskConfig, WrenchConvention};
pub use memory::{Memory, MemoryError};
pub use stability::{ContactLoop, LONGEST_DELAY, Margin};
pub use step::{Command, Controller, Measurement, StepError, TaskTarget};
