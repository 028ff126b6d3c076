//! A joint of the tree that moves.

use nalgebra::IsometryMatrix3;

use super::JointKind;

/// A joint that moves, with a coordinate of its own or as a mimic joint. It moves about or along the z axis of its frame.
///
/// Its position is `multiplier` · q\[`coordinate`\] + `offset`.
#[derive(Debug, Clone, PartialEq)]
pub struct MovingJoint {
    /// Name, unique among the joints that move.
    pub name: String,
    /// Kind of motion.
    pub kind: JointKind,
    /// Index of the moving joint before it in the tree, smaller than its own; `None` if it hangs on the base.
    pub parent: Option<usize>,
    /// Pose of the joint's frame at position zero, m, in the frame that `parent` moves or in the base.
    pub placement: IsometryMatrix3<f64>,
    /// Index of the entry of the joint position q that moves it.
    pub coordinate: usize,
    /// Whether it follows another joint.
    pub is_mimic: bool,
    /// Position per position of the joint that it follows; 1 for a joint with its own coordinate.
    pub multiplier: f64,
    /// Position if the joint that it follows is at zero, rad or m; 0 for a joint with its own coordinate.
    pub offset: f64,
}

impl MovingJoint {
    /// Returns the position of this joint, rad or m, for the joint position q of the robot (n).
    pub fn position(&self, joint_position: &[f64]) -> f64 {
        joint_position[self.coordinate] * self.multiplier + self.offset
    }
}
