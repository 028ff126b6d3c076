//! The arm: a serial chain of joints with limits, immutable once built.

mod denavit_hartenberg;
mod fixture;
mod limits;
mod model;

pub use denavit_hartenberg::DenavitHartenberg;
pub use fixture::{FixtureError, built_in, from_json, from_toml};
pub use limits::JointLimits;
pub use model::{Joint, JointKind, ModelError, RobotModel};
