//! Arms of any number of joints.

use std::f64::consts::FRAC_PI_2;
use std::fmt::Write as _;
use std::sync::Arc;

use revprio::service::Robots;
use revprio_robot::{RobotModel, from_toml};

use crate::error::BenchError;

/// Name of the arms.
pub const NAME: &str = "arm";

/// Returns the built-in robots and an arm of revolute joints, each at a right angle to the one before, 1.2 m long.
pub fn with_joints(joints: usize) -> Result<Robots, BenchError> {
    let length = 1.2 / joints as f64;
    let mut text = format!("name = \"{NAME}\"\n");
    for joint in 0..joints {
        let alpha = if joint % 2 == 0 { FRAC_PI_2 } else { -FRAC_PI_2 };
        // Writing into a string cannot fail.
        let _ = write!(
            text,
            "[[joints]]\nname = \"j{joint}\"\nkind = \"revolute\"\ndh = {{ d = {length}, a = {length}, alpha = {alpha} }}\n"
        );
    }
    let robot: RobotModel = from_toml(&text).map_err(BenchError::defect)?;
    Robots::built_in().with(Arc::new(robot)).map_err(BenchError::defect)
}

/// Returns a posture that is not near a singularity.
pub fn posture(joints: usize) -> Vec<f64> {
    (0..joints).map(|joint| 0.5 + 0.4 * (1.3 * joint as f64).sin()).collect()
}
