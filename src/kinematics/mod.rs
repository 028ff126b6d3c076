//! Where the tool is and how it moves: forward kinematics, Jacobian, Cartesian axes.

mod axes;
mod configuration;
mod link_frames;

pub use axes::{Axis, AxisSelection, AxisSelectionError};
pub use configuration::{Configuration, ConfigurationError, Jacobian, orientation_error};
pub use link_frames::link_frames;
