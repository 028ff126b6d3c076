//! A linear combination of the joint velocities within two bounds.

use revprio_problem::Inequality;
use revprio_robot::kinematics::Configuration;

use super::kind::ConstraintKind;
use crate::arm_state::ArmState;

/// −b ≤ a·q̇ ≤ b: two rows, one for each side.
#[derive(Debug, Clone, PartialEq)]
pub struct TwoSided {
    upper: Inequality,
    lower: Inequality,
}

impl TwoSided {
    /// Builds the constraint from the row of its upper bound.
    pub fn new(upper: Inequality) -> Self {
        let mut lower = upper.clone();
        let bound = upper.bound();
        lower.overwrite(|row| {
            row.iter_mut().zip(upper.coefficients()).for_each(|(entry, a)| *entry = -a);
            bound
        });
        Self { upper, lower }
    }
}

impl ConstraintKind for TwoSided {
    fn name(&self) -> &str {
        self.upper.name()
    }

    fn fits(&self, joints: usize) -> bool {
        self.upper.coefficients().len() == joints
    }

    fn row_count(&self) -> usize {
        2
    }

    fn depends_on_posture(&self) -> bool {
        false
    }

    fn push_rows(&self, _: usize, rows: &mut Vec<Inequality>) {
        rows.extend([self.upper.clone(), self.lower.clone()]);
    }

    fn write(&self, _: &ArmState, _: &mut [Inequality]) {}

    fn rows_at(&self, _: Option<&Configuration>) -> Vec<Inequality> {
        vec![self.upper.clone(), self.lower.clone()]
    }
}
