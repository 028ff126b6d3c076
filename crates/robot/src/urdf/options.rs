//! Choices that a URDF text leaves open.

use nalgebra::IsometryMatrix3;

use crate::Overrides;

/// Choices that a URDF text leaves open for a serial arm.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct UrdfOptions<'a> {
    /// Name of the robot; if `None`, the name in the text.
    pub name: Option<&'a str>,
    /// Description in one line; if `None`, a summary of the chain.
    pub description: Option<&'a str>,
    /// Link whose frame is the base frame; if `None`, the root of the tree.
    pub base: Option<&'a str>,
    /// Link whose frame is the tool frame; if `None`, the end of the only chain or of the only arm, without gripper.
    pub tip: Option<&'a str>,
    /// Values that replace those of the text.
    pub overrides: Option<&'a Overrides>,
}

/// Choices that a URDF text leaves open for a whole tree.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct UrdfTreeOptions<'a> {
    /// Name of the robot; if `None`, the name in the text.
    pub name: Option<&'a str>,
    /// Description in one line; if `None`, a summary of the tree.
    pub description: Option<&'a str>,
    /// Link whose frame is the base frame; if `None`, the root of the tree. Only what is below it belongs to the robot.
    pub base: Option<&'a str>,
    /// The tips; the first one is the tool. If empty, the end of each arm, without gripper, or the ends of all branches if
    /// none is known as an arm. Such tips have the names of their links.
    pub tips: &'a [UrdfTip<'a>],
    /// Values that replace those of the text. `tool_offset` moves the first tip.
    pub overrides: Option<&'a Overrides>,
}

/// A tip of a tree.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UrdfTip<'a> {
    /// Name of the tip.
    pub name: &'a str,
    /// Name of the link that carries it.
    pub link: &'a str,
    /// Pose of the tip in the frame of the link, m.
    pub offset: IsometryMatrix3<f64>,
}
