//! Links and tips of the tree.

use nalgebra::IsometryMatrix3;

/// A link of one robot, by its place in [`RobotModel::links`](super::RobotModel::links).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LinkId(pub(crate) usize);

impl LinkId {
    /// The base link.
    pub const BASE: Self = Self(0);

    /// Returns the place of the link in [`RobotModel::links`](super::RobotModel::links).
    pub fn index(self) -> usize {
        self.0
    }
}

/// A rigid body with a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Link {
    /// Name.
    pub name: String,
    /// The link above it; `None` for the base.
    pub parent: Option<LinkId>,
    /// Index of the moving joint that carries it, in [`RobotModel::moving_joints`](super::RobotModel::moving_joints);
    /// `None` if it is fixed to the base.
    pub joint: Option<usize>,
    /// Pose of the link's frame in the frame that this joint moves, or in the base, m.
    pub placement: IsometryMatrix3<f64>,
}

/// A named frame on a link, for example a tool.
#[derive(Debug, Clone, PartialEq)]
pub struct Tip {
    /// Name, unique among the tips of the robot.
    pub name: String,
    /// The link that carries it.
    pub link: LinkId,
    /// Pose of the tip in the frame of the link, m.
    pub offset: IsometryMatrix3<f64>,
}
