//! Inequalities that a controller must obey besides the joint limits, such as virtual walls. One file for each kind.
//!
//! A constraint is a block of rows a·q̇ ≤ b, whose number never changes. A controller allocates the blocks of all its constraints
//! once, and each period overwrites the blocks that depend on the posture. The solver treats a row like a joint limit. If rows
//! contradict the box of the joint limits or each other, the box holds, their violation is as small as possible, and the answer
//! names them.

mod distance;
mod fixed;
mod kind;
mod plane;

use std::ops::Range;

pub use revprio_problem::{Inequality, InequalityError};
use revprio_robot::RobotModel;
use revprio_robot::kinematics::Configuration;

use self::kind::ConstraintKind;
pub use self::plane::{APPROACH_RATE, PlanePoint, VirtualPlane, VirtualPlaneError};
use crate::arm_state::ArmState;
pub use crate::arm_state::{Ahead, JointBraking};
use crate::collision::CollisionAvoidance;

/// Maximum number of rows of all constraints of a controller together.
///
/// A period of a 7-joint arm with 512 planes takes 1.3 ms, and up to 6 ms where several of them become active at once.
pub const MAX_CONSTRAINT_ROWS: usize = 512;

/// A constraint of the joint velocities.
#[derive(Debug, Clone, PartialEq)]
pub enum Constraint {
    /// a·q̇ ≤ b, the same at every posture.
    Fixed(Inequality),
    /// A virtual wall, which gives another inequality at each posture.
    Plane(VirtualPlane),
    /// Shapes that keep clear of each other; at most once.
    Distances(CollisionAvoidance),
}

impl Constraint {
    fn kind(&self) -> &dyn ConstraintKind {
        match self {
            Self::Fixed(inequality) => inequality,
            Self::Plane(plane) => plane,
            Self::Distances(avoidance) => avoidance,
        }
    }

    /// Returns what shapes keep clear of, if the constraint is about that.
    pub fn distances(&self) -> Option<&CollisionAvoidance> {
        match self {
            Self::Distances(avoidance) => Some(avoidance),
            Self::Fixed(_) | Self::Plane(_) => None,
        }
    }

    /// Returns the name that answers use.
    pub fn name(&self) -> &str {
        self.kind().name()
    }

    /// Returns whether the constraint is possible for a robot.
    pub fn fits(&self, robot: &RobotModel) -> bool {
        self.kind().fits(robot)
    }

    /// Returns the number of rows.
    pub fn row_count(&self) -> usize {
        self.kind().row_count()
    }

    /// Returns whether the rows depend on the posture.
    pub fn depends_on_posture(&self) -> bool {
        self.kind().depends_on_posture()
    }

    /// Returns the rows at a posture of an arm about whose motion nothing is known; `None` for the posture: the rows that do not
    /// depend on it.
    pub fn rows_at(&self, configuration: Option<&Configuration>) -> Vec<Inequality> {
        self.kind().rows_at(configuration)
    }
}

/// Returns what shapes keep clear of, and the place of its rows among those of all constraints.
pub(crate) fn distances(constraints: &[Constraint]) -> Option<(&CollisionAvoidance, Range<usize>)> {
    let mut start = 0;
    for constraint in constraints {
        let rows = start..start + constraint.row_count();
        if let Some(avoidance) = constraint.distances() {
            return Some((avoidance, rows));
        }
        start = rows.end;
    }
    None
}

/// Allocates the rows of constraints for an arm of n joints, one block after the other.
pub(crate) fn allocate(constraints: &[Constraint], n: usize) -> Vec<Inequality> {
    let mut rows = Vec::with_capacity(constraints.iter().map(Constraint::row_count).sum());
    for constraint in constraints {
        constraint.kind().push_rows(n, &mut rows);
    }
    rows
}

/// Overwrites the rows of [`allocate`] with those of this period, without allocating.
pub(crate) fn write(constraints: &[Constraint], arm: &ArmState, mut rows: &mut [Inequality]) {
    for constraint in constraints {
        let (own, others) = rows.split_at_mut(constraint.row_count());
        constraint.kind().write(arm, own);
        rows = others;
    }
}
