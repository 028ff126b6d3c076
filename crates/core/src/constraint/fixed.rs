//! A linear inequality that is the same at every posture.

use revprio_problem::Inequality;
use revprio_robot::RobotModel;
use revprio_robot::kinematics::Configuration;

use super::kind::ConstraintKind;
use crate::arm_state::ArmState;

impl ConstraintKind for Inequality {
    fn name(&self) -> &str {
        self.name()
    }

    fn fits(&self, robot: &RobotModel) -> bool {
        self.coefficients().len() == robot.joint_count()
    }

    fn row_count(&self) -> usize {
        1
    }

    fn depends_on_posture(&self) -> bool {
        false
    }

    fn push_rows(&self, _: usize, rows: &mut Vec<Inequality>) {
        rows.push(self.clone());
    }

    fn write(&self, _: &ArmState, _: &mut [Inequality]) {}

    fn rows_at(&self, _: Option<&Configuration>) -> Vec<Inequality> {
        vec![self.clone()]
    }
}
