//! Distances of shapes. A controller writes their rows itself, because they depend on its commands on their way.

use std::sync::Arc;

use revprio_problem::Inequality;
use revprio_robot::RobotModel;
use revprio_robot::kinematics::Configuration;

use super::kind::ConstraintKind;
use crate::arm_state::ArmState;
use crate::collision::{CollisionAvoidance, NAME, ROWS};

impl ConstraintKind for CollisionAvoidance {
    fn name(&self) -> &str {
        NAME
    }

    fn fits(&self, robot: &RobotModel) -> bool {
        robot.collision().is_some()
    }

    fn row_count(&self) -> usize {
        ROWS
    }

    fn depends_on_posture(&self) -> bool {
        true
    }

    fn push_rows(&self, n: usize, rows: &mut Vec<Inequality>) {
        let name: Arc<str> = NAME.into();
        rows.extend((0..ROWS).map(|row| Inequality::always_satisfied(Arc::clone(&name), row, n)));
    }

    fn write(&self, _: &ArmState, _: &mut [Inequality]) {}

    fn rows_at(&self, _: Option<&Configuration>) -> Vec<Inequality> {
        Vec::new()
    }
}
