//! Models of robot arms: serial chains of joints with limits, their kinematics, and set-points over time.
//!
//! | to | see |
//! |---|---|
//! | use a robot that ships with the crate | [`built_in`] |
//! | read a robot from URDF | [`RobotModel::from_urdf`] |
//! | read a robot from a file (`.urdf`, `.toml`, `.json`) | [`from_file`] |
//! | compute tool pose and Jacobian at a posture | [`kinematics::Configuration`] |
//! | measure how near the joints are to their position limits | [`kinematics::joint_limit_index`] |
//! | describe a set-point over time | [`profile::Profile`] |
//!
//! A [`RobotModel`] never changes after it is built. Units are SI: rad and m, rad/s and m/s.
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
//! assert!(rail.limits.acceleration.is_infinite()); // the text gives none
//! # Ok(())
//! # }
//! ```

mod description;
mod file;
mod joint_kind;
pub mod kinematics;
mod model;
mod overrides;
pub mod profile;
mod selection;
mod urdf;

pub use description::{DenavitHartenberg, DescriptionError, from_json, from_toml};
pub use file::{RobotFileError, built_in, from_file};
pub use joint_kind::JointKind;
pub use model::{Joint, JointLimits, ModelError, RobotModel};
pub use overrides::{LimitOverride, Overrides};
pub use selection::{ChainSelection, LeftOut, LeftOutReason, TipReason};
pub use urdf::{UrdfError, UrdfOptions};
