//! The arm: a serial chain of joints with limits, immutable once built.
//!
//! [`built_in`] has some; [`RobotModel::from_urdf`] and [`from_file`] read others.
//!
//! ```
//! use revprio_robot::{JointKind, RobotModel, UrdfOptions};
//!
//! # fn main() -> Result<(), revprio_robot::UrdfError> {
//! let urdf = r#"
//!   <robot name="lift">
//!     <link name="base"/> <link name="carriage"/>
//!     <joint name="rail" type="prismatic">
//!       <parent link="base"/> <child link="carriage"/> <axis xyz="0 0 1"/>
//!       <limit lower="0" upper="1.5" velocity="0.2" effort="500"/>
//!     </joint>
//!   </robot>"#;
//! let lift = RobotModel::from_urdf(urdf, &UrdfOptions::default())?;
//! let rail = &lift.joints()[0];
//! assert_eq!((rail.name.as_str(), rail.kind), ("rail", JointKind::Prismatic));
//! assert_eq!((rail.limits.upper, rail.limits.velocity), (1.5, 0.2)); // m, m/s
//! assert!(rail.limits.acceleration.is_infinite()); // none is given
//! # Ok(())
//! # }
//! ```

mod built_in;
mod denavit_hartenberg;
mod file;
mod fixture;
pub mod kinematics;
mod limits;
mod model;
pub mod profile;
mod urdf;

pub use built_in::built_in;
pub use denavit_hartenberg::DenavitHartenberg;
pub use file::{RobotFileError, from_file};
pub use fixture::{FixtureError, from_json, from_toml};
pub use limits::JointLimits;
pub use model::{Joint, JointKind, ModelError, RobotModel};
pub use urdf::{UrdfError, UrdfOptions};
