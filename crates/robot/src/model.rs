//! The model of an arm: a serial chain, independent of the format that described it.

use std::sync::Arc;

use nalgebra::IsometryMatrix3;

use super::{ChainSelection, DenavitHartenberg, JointKind};
use crate::kinematics::Chain;

/// Position, velocity, acceleration and jerk limits of one joint; infinite where there is none.
///
/// Units: rad, rad/s, rad/s², rad/s³ for a revolute joint; m, m/s, m/s², m/s³ for a prismatic one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointLimits {
    /// q_lo, the smallest position.
    pub lower: f64,
    /// q_hi, the largest position.
    pub upper: f64,
    /// V, the largest speed in either direction.
    pub velocity: f64,
    /// A, the largest acceleration in either direction.
    pub acceleration: f64,
    /// J, the largest change of the acceleration in a second, in either direction.
    pub jerk: f64,
}

impl JointLimits {
    /// No limits.
    pub const NONE: Self = Self {
        lower: f64::NEG_INFINITY,
        upper: f64::INFINITY,
        velocity: f64::INFINITY,
        acceleration: f64::INFINITY,
        jerk: f64::INFINITY,
    };

    /// Returns whether the position range is not empty, and speed, acceleration and jerk are positive.
    fn is_valid(&self) -> bool {
        self.lower <= self.upper && self.velocity > 0.0 && self.acceleration > 0.0 && self.jerk > 0.0
    }
}

/// One joint of the chain.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Name, unique in the robot.
    pub name: String,
    /// Kind of motion.
    pub kind: JointKind,
    /// Pose of the joint's frame at position zero, in the frame that the previous joint moves (first joint: the base).
    pub placement: IsometryMatrix3<f64>,
    /// Limits of the real arm.
    pub limits: JointLimits,
    /// Position range (lower, upper) in a publication, if it differs from `limits`. For information only.
    pub published_range: Option<[f64; 2]>,
    /// Denavit-Hartenberg row, if the joint was described by one. For information only: `placement` contains it.
    pub denavit_hartenberg: Option<DenavitHartenberg>,
}

/// Why a robot description is refused.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ModelError {
    /// A chain without joints cannot move.
    #[error("a robot needs at least one joint")]
    NoJoints,
    /// Two joints share a name.
    #[error("two joints are named `{name}`; give each its own name")]
    DuplicateJoint {
        /// The repeated name.
        name: String,
    },
    /// The position range is empty, or a speed, acceleration or jerk is not positive.
    #[error(
        "joint `{joint}`: the position range must not be empty, velocity, acceleration and jerk limits must be positive"
    )]
    Limits {
        /// The joint.
        joint: String,
    },
    /// A length or an angle is NaN or infinite.
    #[error("joint `{joint}`: lengths and angles must be finite numbers")]
    NotFinite {
        /// The joint.
        joint: String,
    },
}

fn is_finite(transform: &IsometryMatrix3<f64>) -> bool {
    transform.to_homogeneous().iter().all(|entry| entry.is_finite())
}

/// A robot arm: its joints from base to tool, which is the order of all vectors of joints.
#[derive(Debug, Clone, PartialEq)]
pub struct RobotModel {
    name: String,
    description: String,
    joints: Vec<Joint>,
    tool: IsometryMatrix3<f64>,
    chain: Chain,
    selection: Option<Arc<ChainSelection>>,
}

impl RobotModel {
    /// Builds and checks a model from its joints and the pose of the tool frame in the frame that the last joint moves.
    pub fn new(
        name: impl Into<String>,
        description: impl Into<String>,
        joints: Vec<Joint>,
        tool: IsometryMatrix3<f64>,
    ) -> Result<Self, ModelError> {
        if joints.is_empty() {
            return Err(ModelError::NoJoints);
        }
        for (i, joint) in joints.iter().enumerate() {
            if !joint.limits.is_valid() {
                return Err(ModelError::Limits { joint: joint.name.clone() });
            }
            // A description gives the transform behind a joint together with that joint, so the error names that joint.
            let after = joints.get(i + 1).map_or(&tool, |next| &next.placement);
            if !(is_finite(&joint.placement) && is_finite(after)) {
                return Err(ModelError::NotFinite { joint: joint.name.clone() });
            }
            if joints[..i].iter().any(|earlier| earlier.name == joint.name) {
                return Err(ModelError::DuplicateJoint { name: joint.name.clone() });
            }
        }
        let chain = Chain::new(&joints, &tool);
        Ok(Self { name: name.into(), description: description.into(), joints, tool, chain, selection: None })
    }

    /// Returns the same robot with a note about the chain that it was read from.
    pub(crate) fn with_selection(self, selection: ChainSelection) -> Self {
        Self { selection: Some(Arc::new(selection)), ..self }
    }

    /// Returns which chain of the description the robot is; `None` if the description has only one.
    pub fn selection(&self) -> Option<&ChainSelection> {
        self.selection.as_deref()
    }

    /// Returns the same robot under another name.
    #[must_use]
    pub fn renamed(self, name: impl Into<String>) -> Self {
        Self { name: name.into(), ..self }
    }

    /// Returns the same arm with its tool frame moved by `offset`, a pose in the present tool frame, m.
    pub fn with_tool_offset(&self, offset: &IsometryMatrix3<f64>) -> Result<Self, ModelError> {
        let tool = self.tool * offset;
        match self.joints.last() {
            Some(last) if !is_finite(&tool) => Err(ModelError::NotFinite { joint: last.name.clone() }),
            _ => Ok(Self { tool, chain: Chain::new(&self.joints, &tool), ..self.clone() }),
        }
    }

    /// Returns the name of the robot.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the description, one line of text.
    pub fn description(&self) -> &str {
        &self.description
    }

    /// Returns n, the number of joints.
    pub fn joint_count(&self) -> usize {
        self.joints.len()
    }

    /// Returns the joints, base first.
    pub fn joints(&self) -> &[Joint] {
        &self.joints
    }

    /// Returns the length of the stretched chain from the first joint to the tool, m: no point of the chain is farther away,
    /// apart from prismatic motion.
    pub fn reach(&self) -> f64 {
        let links = self.joints.iter().skip(1).map(|joint| &joint.placement).chain([&self.tool]);
        links.map(|placement| placement.translation.vector.norm()).sum()
    }

    /// Returns the pose of the tool frame in the frame that the last joint moves.
    pub fn tool(&self) -> &IsometryMatrix3<f64> {
        &self.tool
    }

    /// Returns the fixed transforms, for forward kinematics.
    pub(crate) fn chain(&self) -> &Chain {
        &self.chain
    }
}
