//! What each kind of constraint does.

use revprio_problem::Inequality;
use revprio_robot::RobotModel;
use revprio_robot::kinematics::Configuration;

use crate::arm_state::ArmState;

/// A kind of constraint: a block of rows a·q̇ ≤ b, whose number never changes.
pub(super) trait ConstraintKind {
    /// Returns the name that answers use.
    fn name(&self) -> &str;

    /// Returns whether the constraint is possible for a robot.
    fn fits(&self, robot: &RobotModel) -> bool;

    /// Returns the number of rows.
    fn row_count(&self) -> usize;

    /// Returns whether the rows depend on the posture.
    fn depends_on_posture(&self) -> bool;

    /// Appends the rows for an arm of n joints that [`Self::write`] overwrites.
    fn push_rows(&self, n: usize, rows: &mut Vec<Inequality>);

    /// Overwrites the rows, which are those of [`Self::push_rows`], with those of this period, without allocating.
    fn write(&self, arm: &ArmState, rows: &mut [Inequality]);

    /// Returns the rows at a posture of an arm about whose motion nothing is known; `None` for the posture: the rows that do not
    /// depend on it.
    fn rows_at(&self, configuration: Option<&Configuration>) -> Vec<Inequality>;
}
