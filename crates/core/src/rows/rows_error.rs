//! Why rows are refused.

/// Why rows are refused.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum RowsError {
    /// Law, target and rows differ in number.
    #[error("{given} values for {expected} rows; give one per row")]
    Rows {
        /// Rows of the task.
        expected: usize,
        /// Rows of the law or the target.
        given: usize,
    },
    /// A law that reads the wrench is set on joints.
    #[error("joints can have the laws velocity and position, or bounds, only")]
    JointLaw,
    /// A law that reads positions or the wrench is set on constant rows.
    #[error("constant rows can have the law velocity, or bounds, only")]
    RawLaw,
    /// A law that reads the wrench is set on a line of sight.
    #[error("a line of sight can have the laws velocity and position, or bounds, only")]
    GazeLaw,
    /// The direction that looks has length zero.
    #[error("the direction that looks has length zero")]
    Direction,
    /// The robot has no such link.
    #[error("the robot has no such link")]
    Link,
    /// A law that reads the wrench is set on a body that is no tip.
    #[error(
        "wrenches are measured at tips; a task of another link, or one that is seen from a link, can have the laws `pose`, \
         `velocity` and `look_at`, or bounds, only"
    )]
    LinkLaw,
    /// Constant rows do not fit the robot or are not finite.
    #[error("a Jacobian needs at least one row of {expected} finite numbers, one per joint")]
    Jacobian {
        /// Joints of the robot.
        expected: usize,
    },
    /// A joint does not exist, is listed twice, or has no range although the target is the middle of it.
    #[error("joints must exist and be listed once; the target mid-range needs joints with a range")]
    Joints,
}

impl RowsError {
    /// Checks that a law or a target has as many rows as the task.
    pub(crate) fn unless_equal(expected: usize, given: usize) -> Result<(), Self> {
        if given == expected { Ok(()) } else { Err(Self::Rows { expected, given }) }
    }
}
