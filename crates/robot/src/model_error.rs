//! Why joints are not a robot.

/// Why a robot description is refused.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ModelError {
    /// A robot without joints cannot move.
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
        "joint `{joint}`: the position range must not be empty, velocity, acceleration and jerk limits must be positive; a velocity \
         envelope must have a positive deceleration and an offset that is not negative, and its margins offset²/(2 deceleration) must leave a range"
    )]
    Limits {
        /// The joint.
        joint: String,
    },
    /// A length, an angle, or the multiplier or offset of a mimic joint is NaN or infinite, or a length exceeds 1e100 m.
    #[error("joint `{joint}`: lengths and angles must be finite numbers, lengths at most 1e100 m")]
    NotFinite {
        /// The joint.
        joint: String,
    },
    /// The axis of a joint has length zero.
    #[error("joint `{joint}`: the axis has length zero; give its direction")]
    Axis {
        /// The joint.
        joint: String,
    },
    /// A link is the child of two joints.
    #[error("link `{link}` is the child of the joints `{first}` and `{second}`; the links must form a tree")]
    TwoParents {
        /// The link.
        link: String,
        /// The first joint.
        first: String,
        /// The second joint.
        second: String,
    },
    /// The links form a cycle.
    #[error("the links form a cycle through `{link}`; the links must form a tree")]
    Cycle {
        /// A link of the cycle.
        link: String,
    },
    /// The parent link of a joint is not the base, and no joint has it as its child.
    #[error("the parent of joint `{joint}` is link `{link}`, which is not connected to the base")]
    Unconnected {
        /// The joint.
        joint: String,
        /// Its parent link.
        link: String,
    },
    /// The tree has no tip.
    #[error("a robot needs at least one tip; the first one is the tool")]
    NoTip,
    /// Two tips share a name.
    #[error("two tips are named `{tip}`; give each its own name")]
    DuplicateTip {
        /// The repeated name.
        tip: String,
    },
    /// The link of a tip does not exist.
    #[error("tip `{tip}`: there is no link `{link}`")]
    UnknownTip {
        /// The tip.
        tip: String,
        /// The link.
        link: String,
    },
    /// No joint moves the link of a tip.
    #[error("tip `{tip}`: no joint moves link `{link}`")]
    FixedTip {
        /// The tip.
        tip: String,
        /// The link.
        link: String,
    },
    /// The offset of a tip is not finite, or exceeds 1e100 m.
    #[error("tip `{tip}`: lengths and angles must be finite numbers, lengths at most 1e100 m")]
    TipNotFinite {
        /// The tip.
        tip: String,
    },
    /// A mimic joint follows a joint that does not exist.
    #[error("joint `{joint}` follows joint `{leader}`, which does not exist")]
    UnknownLeader {
        /// The mimic joint.
        joint: String,
        /// The joint that it follows.
        leader: String,
    },
    /// A mimic joint follows a fixed joint.
    #[error("joint `{joint}` follows joint `{leader}`, which is fixed; follow a joint that moves")]
    FixedLeader {
        /// The mimic joint.
        joint: String,
        /// The joint that it follows.
        leader: String,
    },
    /// A mimic joint follows a mimic joint, perhaps itself.
    #[error("joint `{joint}` follows joint `{leader}`, which is a mimic joint; follow a joint with its own position")]
    MimicChain {
        /// The mimic joint.
        joint: String,
        /// The joint that it follows.
        leader: String,
    },
    /// No position keeps the ranges of a mimic joint and of the joint that it follows.
    #[error("joint `{joint}` follows joint `{leader}`, but no position is within the ranges of both")]
    MimicRange {
        /// The mimic joint.
        joint: String,
        /// The joint that it follows.
        leader: String,
    },
}
