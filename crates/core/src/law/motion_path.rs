//! The path on which a position law looks ahead.

/// The path on which the arm moves to a target that jumps, for a law that looks ahead.
///
/// The arm of such a law follows a *virtual arm*, whose joints have reached the targets at each time ahead. Each joint of the
/// real arm moves as fast as its own limits of velocity and acceleration permit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MotionPath {
    /// The fastest motion of each joint to the posture at the target. The tool leaves the straight line.
    Joint,
    /// The straight line of the tool, as fast as the joints can follow it.
    Straight,
}
