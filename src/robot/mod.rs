//! The arm: a serial chain of joints with limits, immutable once built.

mod built_in;
mod denavit_hartenberg;
mod file;
mod fixture;
mod limits;
mod model;
mod urdf;

pub use built_in::built_in;
pub use denavit_hartenberg::DenavitHartenberg;
pub use file::{RobotFileError, from_file};
pub use fixture::{FixtureError, from_json, from_toml};
pub use limits::JointLimits;
pub use model::{Joint, JointKind, ModelError, RobotModel};
pub use urdf::{UrdfError, UrdfOptions};
