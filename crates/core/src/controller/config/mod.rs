//! What is constant over the periods of a controller. It is checked once.

mod config_error;
mod controller;
mod controller_config;
mod derived;
mod null_space;
mod steep_gain;
mod streamed_target;
mod task;
mod velocity_limits;
mod weights;

pub use config_error::ConfigError;
pub use controller::Controller;
pub use controller_config::{AntiWindup, ControllerConfig};
pub use null_space::{HOLDING_SPEED, NullSpaceError, NullSpaceMotion};
pub use steep_gain::SteepGain;
pub use task::{TaskConfig, TaskConfigError};
pub use velocity_limits::Limits;
