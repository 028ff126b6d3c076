//! The names of bounds: one for joint limits, inequality constraints and rows of tasks.

use smallvec::SmallVec;

/// What a bound belongs to. Ascending order: joints, then constraints, then tasks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum BoundId {
    /// The velocity limit of a joint, index from 0.
    Joint(usize),
    /// A row of a hard inequality constraint.
    Constraint {
        /// Index of the constraint, from 0.
        index: usize,
        /// Index of the row within the constraint, from 0.
        row: usize,
    },
    /// A row of a task.
    Task {
        /// Index of the task, from 0, highest priority first.
        index: usize,
        /// Index of the row within the task, from 0.
        row: usize,
    },
}

impl BoundId {
    /// Returns the index of the joint, for the limit of one.
    pub fn joint(self) -> Option<usize> {
        if let Self::Joint(joint) = self { Some(joint) } else { None }
    }

    /// Returns the index of the constraint, for a row of one.
    pub fn constraint(self) -> Option<usize> {
        if let Self::Constraint { index, .. } = self { Some(index) } else { None }
    }
}

/// Lower or upper bound of a joint or of a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Side {
    /// The lower bound.
    Lower,
    /// The upper bound.
    Upper,
}

impl Side {
    /// Returns −1 for the lower and 1 for the upper bound.
    #[inline]
    pub fn sign(self) -> f64 {
        match self {
            Self::Lower => -1.0,
            Self::Upper => 1.0,
        }
    }

    /// Returns the side on which a multiplier with this sign pulls back: below zero the lower one.
    #[inline]
    pub fn of_multiplier(multiplier: f64) -> Self {
        if multiplier < 0.0 { Self::Lower } else { Self::Upper }
    }
}

/// One side of a joint limit, of a constraint or of a row of a task.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Bound {
    /// What it belongs to.
    pub id: BoundId,
    /// Which side.
    pub side: Side,
}

impl Bound {
    /// Returns the upper bound.
    pub fn upper(id: BoundId) -> Self {
        Self { id, side: Side::Upper }
    }

    /// Returns the lower bound.
    pub fn lower(id: BoundId) -> Self {
        Self { id, side: Side::Lower }
    }
}

/// The active bounds of one problem, in ascending order.
pub type ActiveSet = SmallVec<[Bound; 8]>;

/// A bound that holds the answer back.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ActiveBound {
    /// Which bound.
    pub bound: Bound,
    /// Its value: rad/s for a joint (m/s if it is prismatic), b for a constraint, m/s or rad/s for a row of a task.
    pub value: f64,
    /// Multiplier ≥ 0 at the highest level that the bound holds back: how much ½‖J_k q̇ − ẋ_k‖² of that level would fall per
    /// unit of a wider bound; 0 for a joint whose bounds coincide and that holds no level back, which is listed all the same.
    pub multiplier: f64,
}

/// A bound that the answer breaks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BrokenBound {
    /// Which bound.
    pub bound: Bound,
    /// Its value: rad/s for a joint (m/s if it is prismatic), b for a constraint.
    pub limit: f64,
    /// The velocity of the joint, or a·q̇ of the constraint, in the same unit.
    pub value: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joints_come_before_constraints_and_these_before_tasks() {
        let joints = [BoundId::Joint(0), BoundId::Joint(6)];
        let constraints = [(0, 1), (1, 0)].map(|(index, row)| BoundId::Constraint { index, row });
        let tasks = [(0, 2), (1, 0)].map(|(index, row)| BoundId::Task { index, row });
        let ids: Vec<BoundId> = [joints, constraints, tasks].concat();
        assert!(ids.is_sorted(), "{ids:?}");
    }
}
