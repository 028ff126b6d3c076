//! Forward kinematics, Jacobian, Cartesian axes and frames, and the joint-limit index.
//!
//! ```
//! use revprio_robot::built_in;
//! use revprio_robot::kinematics::Configuration;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let planar = built_in().iter().find(|robot| robot.name() == "planar_3r").ok_or("no such robot")?;
//! let stretched = Configuration::new(planar, &[0.0, 0.0, 0.0])?;
//! assert!((stretched.tool_pose().translation.x - 1.2).abs() < 1e-12); // 0.5 + 0.4 + 0.3 m
//! // If the first joint turns at 1 rad/s, the tool moves along y at 1.2 m/s and turns about z at 1 rad/s.
//! let column = stretched.jacobian().column(0);
//! assert!((column[1] - 1.2).abs() < 1e-12 && (column[5] - 1.0).abs() < 1e-12);
//! # Ok(())
//! # }
//! ```

mod angle;
mod axes;
mod chain;
mod configuration;
mod factors;
mod joint_limit_index;
mod joint_rotations;
mod moving_frame;
mod pose;
mod rotation_motion;
mod sin_cos;
mod task_frame;

pub(crate) use chain::Chain;

pub use axes::{Axis, AxisSelection, AxisSelectionError};
pub use configuration::{Configuration, ConfigurationError, Jacobian, link_frames, orientation_error};
pub use joint_limit_index::{half_range, joint_limit_gradient, joint_limit_index, joint_limit_slopes};
pub use pose::{NotUnitLength, UNIT_LENGTH_TOLERANCE, pose};
pub use rotation_motion::RotationMotion;
pub use task_frame::{Frame, PlacedFrame, TaskFrame};
