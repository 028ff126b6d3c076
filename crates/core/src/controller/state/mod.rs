//! What changes from period to period: measurement in, command out, and the memory between.

mod answered_state;
mod command;
mod jerk_state;
mod line;
mod measurement;
mod memory;
mod progress;
mod rest;
mod stall;
mod step_error;
mod stuck_task;
mod task_target;
mod virtual_arm;

pub use answered_state::AnsweredState;
pub use command::Command;
pub use jerk_state::JerkState;
pub use line::{LINE_INTERVALS, Line};
pub use measurement::{Measurement, TipWrench};
pub(super) use memory::fits_task;
pub use memory::{Memory, MemoryError, UNIX_TIME_S};
pub use progress::{ANGULAR_REACHED, LEAVING_TIME, Progress, REACHED};
pub(super) use rest::{Gained, are_moving, has_jumped};
pub use rest::{JointTurns, RestState, TaskGain};
pub use stall::{Stall, StalledJoint};
pub use step_error::StepError;
pub use stuck_task::{Obstacle, StuckTask};
pub use task_target::TaskTarget;
pub(super) use virtual_arm::FIRST_LATER;
pub use virtual_arm::{TIMES_AHEAD, VirtualArm};
