//! The model of a robot: a tree of links, independent of the format that described it.

use std::sync::Arc;

use nalgebra::IsometryMatrix3;

use super::assembly::assemble;
use super::shape::CollisionModel;
use super::tree::{Tree, has_usable_numbers};
use super::{ChainSelection, Joint, Link, LinkId, ModelError, MovingJoint, Tip, TreeDescription};

/// A robot: a tree of links that joints connect. A serial arm is a tree without branches.
///
/// The joints with a coordinate are in depth-first order, which is the order of all vectors of joints. For a serial arm,
/// this is the order from base to tool.
#[derive(Debug, Clone, PartialEq)]
pub struct RobotModel {
    name: String,
    description: String,
    joints: Vec<Joint>,
    tree: Arc<Tree>,
    selection: Option<Arc<ChainSelection>>,
    collision: Option<Arc<CollisionModel>>,
    origin: Origin,
}

/// The robot that another one is with another tool. It is used as long as that one is, and makes no difference between robots.
#[derive(Debug, Clone)]
struct Origin(#[expect(dead_code, reason = "it is held, not read")] Option<Arc<RobotModel>>);

impl PartialEq for Origin {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl RobotModel {
    /// Builds and checks a serial arm from its joints and the pose of the tool frame in the frame that the last joint moves.
    ///
    /// Its links are `base` and, with the name of the joint, what each joint moves, in the joint's frame. Its tip is `tool`.
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
            if !(has_usable_numbers(&joint.placement) && has_usable_numbers(after)) {
                return Err(ModelError::NotFinite { joint: joint.name.clone() });
            }
            if joints[..i].iter().any(|earlier| earlier.name == joint.name) {
                return Err(ModelError::DuplicateJoint { name: joint.name.clone() });
            }
        }
        let tree = Tree::serial(&joints, &tool);
        Ok(Self::of(name.into(), description.into(), (joints, tree)))
    }

    /// Builds and checks a robot from the description of its tree.
    pub fn from_tree(
        name: impl Into<String>,
        description: impl Into<String>,
        tree: &TreeDescription,
    ) -> Result<Self, ModelError> {
        Ok(Self::of(name.into(), description.into(), assemble(tree)?))
    }

    /// Builds a robot without shapes from what was checked.
    fn of(name: String, description: String, (joints, tree): (Vec<Joint>, Tree)) -> Self {
        Self { name, description, joints, tree: Arc::new(tree), selection: None, collision: None, origin: Origin(None) }
    }

    /// Returns the same robot with a note about the chain that it was read from.
    pub(crate) fn with_selection(self, selection: ChainSelection) -> Self {
        Self { selection: Some(Arc::new(selection)), ..self }
    }

    /// Returns which chain of the description the robot is; `None` if it is all of the description.
    pub fn selection(&self) -> Option<&ChainSelection> {
        self.selection.as_deref()
    }

    /// Returns the same robot with shapes that were built for it.
    #[must_use]
    pub(crate) fn with_collision(self, collision: CollisionModel) -> Self {
        Self { collision: Some(Arc::new(collision)), ..self }
    }

    /// Returns the shapes of the robot; `None`: none are known.
    pub fn collision(&self) -> Option<&Arc<CollisionModel>> {
        self.collision.as_ref()
    }

    /// Returns the same robot under another name.
    #[must_use]
    pub fn renamed(self, name: impl Into<String>) -> Self {
        Self { name: name.into(), ..self }
    }

    /// Returns the same robot with its tool frame moved by `offset`, a pose in the present tool frame, m. The result holds a
    /// reference to this robot, so that a registry sees that it is used.
    pub fn with_tool_offset(self: &Arc<Self>, offset: &IsometryMatrix3<f64>) -> Result<Self, ModelError> {
        let tool = self.tool() * offset;
        if !has_usable_numbers(&tool) {
            let joint = self.tree.moving()[self.tree.tool_joint()].name.clone();
            return Err(ModelError::NotFinite { joint });
        }
        let tree = Arc::new(self.tree.with_tool(self.tips()[0].offset * offset, tool));
        Ok(Self { tree, origin: Origin(Some(Arc::clone(self))), ..Self::clone(self) })
    }

    /// Returns the name of the robot.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the description, one line of text.
    pub fn description(&self) -> &str {
        &self.description
    }

    /// Returns n, the number of joints with a coordinate.
    pub fn joint_count(&self) -> usize {
        self.joints.len()
    }

    /// Returns the joints with a coordinate, n, each behind the joint that it hangs on.
    pub fn joints(&self) -> &[Joint] {
        &self.joints
    }

    /// Returns the joints that move, mimic joints included, each behind the joint that it hangs on.
    pub fn moving_joints(&self) -> &[MovingJoint] {
        self.tree.moving()
    }

    /// Returns the links, base first, each behind the link above it.
    pub fn links(&self) -> &[Link] {
        self.tree.links()
    }

    /// Returns the first link with a name.
    pub fn link(&self, name: &str) -> Option<LinkId> {
        self.links().iter().position(|link| link.name == name).map(LinkId)
    }

    /// Returns the tips; the first one is the tool.
    pub fn tips(&self) -> &[Tip] {
        self.tree.tips()
    }

    /// Returns the tip with a name.
    pub fn tip(&self, name: &str) -> Option<&Tip> {
        self.tips().iter().find(|tip| tip.name == name)
    }

    /// Returns the length of the stretched chain from the first joint to the tool, m: no point of the chain is farther away,
    /// apart from prismatic motion.
    pub fn reach(&self) -> f64 {
        let mut path: Vec<usize> = self.tree.path_up(Some(self.tree.tool_joint())).collect();
        path.reverse();
        let links = path.iter().skip(1).map(|&joint| &self.moving_joints()[joint].placement).chain([self.tool()]);
        links.map(|placement| placement.translation.vector.norm()).sum()
    }

    /// Returns how far sliding joints can carry the tool from where it is with all of them at zero, m; infinite if one has no limits.
    pub fn travel(&self) -> f64 {
        let path = self.tree.path_up(Some(self.tree.tool_joint())).map(|joint| &self.moving_joints()[joint]);
        let farthest = |joint: &MovingJoint| {
            let limits = self.joints()[joint.coordinate].limits;
            [limits.lower, limits.upper]
                .map(|q| (q * joint.multiplier + joint.offset).abs())
                .into_iter()
                .fold(0.0, f64::max)
        };
        path.filter(|joint| joint.kind.is_translation()).map(farthest).sum()
    }

    /// Returns the pose of the tool frame in the frame that its joint moves, m. For a serial arm, this is the last joint.
    pub fn tool(&self) -> &IsometryMatrix3<f64> {
        self.tree.tool()
    }

    /// Returns links, tips and the constants of the kinematics.
    pub(crate) fn tree(&self) -> &Arc<Tree> {
        &self.tree
    }
}
