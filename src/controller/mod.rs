//! The controller: one call per control period, measurement in, command out.

mod config;
mod joint_rows;
mod memory;
mod null_space;
mod stability;
mod step;
mod task;
mod tool_rows;

pub use config::{ConfigError, ControllerConfig, Limits, WrenchConvention, WrenchFrame};
pub use joint_rows::{JointRows, JointTarget};
pub use memory::{Memory, MemoryError};
pub use null_space::{NullSpaceError, NullSpaceMotion};
pub use stability::{ContactLoop, LONGEST_DELAY, Margin};
pub use step::{Command, Controller, Measurement, StepError, TaskTarget};
pub use task::{TaskConfig, TaskConfigError, TaskRows};
pub use tool_rows::{TargetPose, ToolRows};
