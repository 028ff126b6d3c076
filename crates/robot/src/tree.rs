//! The tree of a robot: its moving joints, its links and its tips, with the constants of its kinematics.

use nalgebra::IsometryMatrix3;

use super::forward::ForwardKinematics;
use super::{Joint, Link, LinkId, MovingJoint, Tip};

/// Name of the base link of an arm without named links.
const BASE: &str = "base";
/// Name of the only tip of an arm without named links.
const TOOL: &str = "tool";

/// Largest length, m: squares of it and sums of them are finite.
const MAX_LENGTH: f64 = 1e100;

/// Returns whether no entry of a transform exceeds [`MAX_LENGTH`].
pub fn has_usable_numbers(transform: &IsometryMatrix3<f64>) -> bool {
    transform.to_homogeneous().iter().all(|entry| entry.abs() <= MAX_LENGTH)
}

/// Joints, links and tips of a robot. Parents are before their children.
#[derive(Debug, Clone, PartialEq)]
pub struct Tree {
    moving: Vec<MovingJoint>,
    links: Vec<Link>,
    /// At least one; a joint moves each.
    tips: Vec<Tip>,
    /// Indices of the moving joints with a coordinate of their own, n.
    own: Vec<usize>,
    /// Pose of the first tip in the frame that its joint moves, m.
    tool: IsometryMatrix3<f64>,
    forward: ForwardKinematics,
}

impl Tree {
    /// Builds a tree from checked parts.
    pub fn new(moving: Vec<MovingJoint>, links: Vec<Link>, tips: Vec<Tip>) -> Self {
        let Tip { link, offset, .. } = &tips[0];
        let placement = links[link.index()].placement;
        // A product with the identity could change the signs of zeros.
        let tool = if *offset == IsometryMatrix3::identity() { placement } else { placement * offset };
        Self::with(moving, links, tips, tool)
    }

    /// Builds the tree of a serial arm. Its links are the base and, with the name of the joint, what each joint moves.
    ///
    /// `tool`: pose in the frame that the last joint moves, m.
    pub fn serial(joints: &[Joint], tool: &IsometryMatrix3<f64>) -> Self {
        let moving = |(i, joint): (usize, &Joint)| MovingJoint {
            name: joint.name.clone(),
            kind: joint.kind,
            parent: i.checked_sub(1),
            placement: joint.placement,
            coordinate: i,
            is_mimic: false,
            multiplier: 1.0,
            offset: 0.0,
        };
        let link = |name: &str, i: usize| Link {
            name: name.to_owned(),
            parent: i.checked_sub(1).map(LinkId),
            joint: i.checked_sub(1),
            placement: IsometryMatrix3::identity(),
        };
        let names = [BASE].into_iter().chain(joints.iter().map(|joint| joint.name.as_str()));
        let links = names.zip(0..).map(|(name, i)| link(name, i)).collect();
        let tip = Tip { name: TOOL.to_owned(), link: LinkId(joints.len()), offset: *tool };
        Self::with(joints.iter().enumerate().map(moving).collect(), links, vec![tip], *tool)
    }

    /// Returns the same tree with another pose of the first tip: `offset` in its link, `tool` in the frame of its joint, m.
    pub fn with_tool(&self, offset: IsometryMatrix3<f64>, tool: IsometryMatrix3<f64>) -> Self {
        let mut tips = self.tips.clone();
        tips[0].offset = offset;
        Self::with(self.moving.clone(), self.links.clone(), tips, tool)
    }

    fn with(moving: Vec<MovingJoint>, links: Vec<Link>, tips: Vec<Tip>, tool: IsometryMatrix3<f64>) -> Self {
        let own = (0..moving.len()).filter(|joint| !moving[*joint].is_mimic).collect();
        let tool_joint = links[tips[0].link.index()].joint.unwrap_or_default();
        let forward = ForwardKinematics::new(&moving, tool_joint, &tool);
        Self { moving, links, tips, own, tool, forward }
    }

    /// Returns the moving joints.
    pub fn moving(&self) -> &[MovingJoint] {
        &self.moving
    }

    /// Returns the links, base first.
    pub fn links(&self) -> &[Link] {
        &self.links
    }

    /// Returns the tips; the first one is the tool.
    pub fn tips(&self) -> &[Tip] {
        &self.tips
    }

    /// Returns the index of the moving joint that has a coordinate for its own.
    pub fn moving_joint_of(&self, coordinate: usize) -> usize {
        self.own[coordinate]
    }

    /// Returns the pose of the tool in the frame that its joint moves, m.
    pub fn tool(&self) -> &IsometryMatrix3<f64> {
        &self.tool
    }

    /// Returns the moving joint that carries the tool.
    pub fn tool_joint(&self) -> usize {
        self.forward.tool_joint()
    }

    /// Returns the constants of the forward kinematics.
    pub fn forward(&self) -> &ForwardKinematics {
        &self.forward
    }

    /// Returns the moving joints from a joint up to the base.
    pub fn path_up(&self, joint: Option<usize>) -> impl Iterator<Item = usize> {
        std::iter::successors(joint, |joint| self.moving[*joint].parent)
    }
}
