//! A serial chain, independent of the convention that described it.

use nalgebra::IsometryMatrix3;

use super::{DenavitHartenberg, JointLimits};

/// How a joint moves: about or along the z axis of its own frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JointKind {
    /// Rotation about z; position in rad.
    Revolute,
    /// Translation along z; position in m.
    Prismatic,
}

/// One joint of the chain.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Name, unique in the robot.
    pub name: String,
    /// How it moves.
    pub kind: JointKind,
    /// Pose of this joint's frame at position zero, in the frame that the joint before it moves (the base for the first).
    pub placement: IsometryMatrix3<f64>,
    /// What the real arm may do.
    pub limits: JointLimits,
    /// Position range (lower, upper) that a publication prints, where it differs from the real one; informative only.
    pub published_range: Option<[f64; 2]>,
    /// The row that described it, where one did; informative only: `placement` and the tool pose contain it.
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
    /// Limits that no motion can meet.
    #[error("joint `{joint}`: the position range must not be empty, velocity and acceleration limits must be positive")]
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

/// A robot arm: joints from base to tool, in this order everywhere.
#[derive(Debug, Clone, PartialEq)]
pub struct RobotModel {
    name: String,
    description: String,
    joints: Vec<Joint>,
    tool: IsometryMatrix3<f64>,
}

impl RobotModel {
    /// Builds a model from its joints and the pose of the tool frame in the frame that the last joint moves.
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
            joint.limits.validated(&joint.name)?;
            // What follows a joint is described with it: the next placement, at the end the tool.
            let after = joints.get(i + 1).map_or(&tool, |next| &next.placement);
            if !(is_finite(&joint.placement) && is_finite(after)) {
                return Err(ModelError::NotFinite { joint: joint.name.clone() });
            }
            if joints[..i].iter().any(|earlier| earlier.name == joint.name) {
                return Err(ModelError::DuplicateJoint { name: joint.name.clone() });
            }
        }
        Ok(Self { name: name.into(), description: description.into(), joints, tool })
    }

    /// The same robot under another name.
    #[must_use]
    pub fn renamed(self, name: impl Into<String>) -> Self {
        Self { name: name.into(), ..self }
    }

    /// The same arm with its tool frame moved by `offset`, a pose in the present tool frame, m.
    pub fn with_tool_offset(&self, offset: &IsometryMatrix3<f64>) -> Result<Self, ModelError> {
        let tool = self.tool * offset;
        match self.joints.last() {
            Some(last) if !is_finite(&tool) => Err(ModelError::NotFinite { joint: last.name.clone() }),
            _ => Ok(Self { tool, ..self.clone() }),
        }
    }

    /// Name by which requests call it.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// One line for people.
    pub fn description(&self) -> &str {
        &self.description
    }

    /// n, the number of joints.
    pub fn joint_count(&self) -> usize {
        self.joints.len()
    }

    /// The joints, base first.
    pub fn joints(&self) -> &[Joint] {
        &self.joints
    }

    /// Pose of the tool frame in the frame that the last joint moves.
    pub fn tool(&self) -> &IsometryMatrix3<f64> {
        &self.tool
    }
}
