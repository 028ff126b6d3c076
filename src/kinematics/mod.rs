//! Where the tool is and how it moves: forward kinematics, Jacobian, Cartesian axes and frames; how near the joints are
//! to the ends of their ranges.

mod axes;
mod configuration;
mod joint_limit_index;
mod link_frames;
mod pose;
mod task_frame;
mod turning;

pub use axes::{Axis, AxisSelection, AxisSelectionError};
pub use configuration::{Configuration, ConfigurationError, Jacobian, orientation_error};
pub use joint_limit_index::{half_range, joint_limit_gradient, joint_limit_index};
pub use link_frames::link_frames;
pub use pose::{NotUnitLength, UNIT_LENGTH, pose};
pub use task_frame::{Frame, PlacedFrame, TaskFrame};
pub use turning::Turning;
