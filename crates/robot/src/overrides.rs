//! Values of the caller that replace those of a description.

use std::collections::BTreeMap;

use nalgebra::IsometryMatrix3;

use super::VelocityEnvelope;

/// Values that replace or complete those of a URDF text. Joints have their names in the text.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Overrides {
    /// Limits by the name of the joint.
    pub limits: BTreeMap<String, LimitOverride>,
    /// New names by the name of the joint.
    pub joint_names: BTreeMap<String, String>,
    /// Pose of the tool frame in the frame of the tip, m.
    pub tool_offset: Option<IsometryMatrix3<f64>>,
}

/// Limits of one joint; what is `None` is read from the text.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LimitOverride {
    /// Smallest and largest position, rad or m.
    pub position: Option<[f64; 2]>,
    /// Largest speed, rad/s or m/s.
    pub velocity: Option<f64>,
    /// Largest acceleration, rad/s² or m/s².
    pub acceleration: Option<f64>,
    /// Largest jerk, rad/s³ or m/s³.
    pub jerk: Option<f64>,
    /// Velocity limits near the ends of the range.
    pub envelope: Option<VelocityEnvelope>,
}
