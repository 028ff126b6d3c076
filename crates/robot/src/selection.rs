//! Which chain of a branching description is the arm.

/// The chain of links that a robot was read from, and the joints that are no part of it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ChainSelection {
    /// Link whose frame is the base frame.
    pub base: String,
    /// Link whose frame is the tool frame.
    pub tip: String,
    /// Why the chain ends there.
    pub reason: TipReason,
    /// Moving joints that are no part of the chain, in the order of their links in the text; at most the first
    /// [`MAX_LEFT_OUT`](Self::MAX_LEFT_OUT).
    pub left_out: Vec<LeftOut>,
}

impl ChainSelection {
    /// Maximum number of joints in `left_out`.
    pub const MAX_LEFT_OUT: usize = 100;
}

/// Why a chain ends at its tip.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TipReason {
    /// The caller named the tip.
    Request,
    /// The chain has no other end.
    OnlyEnd,
    /// Behind the last joint of the arm, this link has the best name of a tool frame.
    ToolName,
    /// It is the last link before the gripper.
    BeforeGripper,
    /// It is the last link that the arm moves.
    LastLink,
}

/// A moving joint that is no part of the chain.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LeftOut {
    /// Name of the joint in the text.
    pub joint: String,
    /// Why it is left out.
    pub reason: LeftOutReason,
}

/// Why a joint is no part of the chain.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LeftOutReason {
    /// It closes a gripper or bends a finger.
    Gripper,
    /// It turns a head.
    Head,
    /// It moves a leg or a wheel.
    LegOrWheel,
    /// It moves a sensor.
    Sensor,
    /// Its type cannot be a joint of an arm.
    Unsupported,
    /// It moves only what is behind the tip.
    BeyondTip,
    /// It is on another branch, for example of another arm.
    OtherBranch,
    /// It is not below the base.
    NotBelowBase,
}
