//! Models of robots: trees of links that joints connect, their kinematics, and set-points over time.
//!
//! A serial arm is a tree without branches.
//!
//! | to | see |
//! |---|---|
//! | use a robot that ships with the crate | [`built_in`] |
//! | read a serial arm from URDF | [`RobotModel::from_urdf`] |
//! | read a whole tree, for example two arms, from URDF | [`RobotModel::from_urdf_tree`] |
//! | describe a tree in code | [`TreeDescription`] |
//! | read a robot from a file (`.urdf`, `.toml`, `.json`) | [`from_file`] |
//! | compute tool pose and Jacobian at a posture | [`kinematics::Configuration`] |
//! | compute pose, Jacobian and twist of a point of any link | [`kinematics::LinkPoint`] |
//! | cover links by capsules and measure their distances | [`collision`] |
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

mod assembly;
mod built_in_shapes;
pub mod collision;
mod denavit_hartenberg;
mod description;
mod file;
mod forward;
mod joint;
mod joint_kind;
pub mod kinematics;
mod link;
mod model;
mod model_error;
mod moving_joint;
mod overrides;
pub mod profile;
mod selection;
mod shape;
mod srdf;
mod tree;
mod tree_description;
mod urdf;
mod velocity_envelope;

pub use denavit_hartenberg::DenavitHartenberg;
pub use description::{DescriptionError, from_json, from_toml};
pub use file::{RobotFileError, built_in, from_file, tree_from_file};
pub use joint::{Joint, JointLimits};
pub use joint_kind::JointKind;
pub use link::{Link, LinkId, Tip};
pub use model::RobotModel;
pub use model_error::ModelError;
pub use moving_joint::MovingJoint;
pub use overrides::{LimitOverride, Overrides};
pub use selection::{ChainSelection, LeftOut, LeftOutReason, TipReason};
pub use srdf::{DisabledPair, EndEffector, Srdf};
pub use tree_description::{JointMotion, Mimic, TreeDescription, TreeJoint, TreeTip};
pub use urdf::{BodyForm, LinkBodies, LinkBody, UrdfError, UrdfOptions, UrdfTip, UrdfTreeOptions};
pub use velocity_envelope::VelocityEnvelope;
