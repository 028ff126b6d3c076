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

mod axes;
mod configuration;
mod jacobian;
mod joint_limit_index;
mod link_frames;
mod link_point;
mod orientation_error;
mod pose;
mod posture_check;
mod rotation_motion;
mod task_body;
mod task_frame;

pub use axes::{Axis, AxisSelection, AxisSelectionError};
pub use configuration::Configuration;
pub use jacobian::Jacobian;
pub use joint_limit_index::{half_range, joint_limit_gradient, joint_limit_index, joint_limit_slopes};
pub use link_frames::link_frames;
pub use link_point::LinkPoint;
pub use orientation_error::orientation_error;
pub use pose::{NotUnitLength, UNIT_LENGTH_TOLERANCE, pose};
pub use posture_check::ConfigurationError;
pub use rotation_motion::RotationMotion;
pub use task_body::{BodyFrame, TaskBody};
pub use task_frame::{Frame, PlacedFrame, TaskFrame};
