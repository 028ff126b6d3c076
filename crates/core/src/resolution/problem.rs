//! The input of the resolution.

use crate::limits::{Inequality, VelocityBox};
use crate::linalg::{Damping, TaskVector, Vector};
use crate::task::TaskStack;

/// The resolution method.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// All tasks as one stack, q̇ = J⁺ẋ + (I − J⁺J) ζ̇. Never damped. Paper: Eq. (5).
    Pseudoinverse,
    /// All tasks as one stack with the variable damping factor: the paper's "classical" control. Paper: Eqs. (14)-(19).
    DampedLeastSquares,
    /// Classical task priority with the projector of all higher tasks. Paper: Eq. (11), for any number of tasks.
    ///
    /// In exact arithmetic, and here in code, the same as [`Method::StrictReversePriority`]: both are the lexicographic
    /// least-squares solution.
    TaskPriority,
    /// Lower tasks first, each higher one then corrects in its own row space alone, q̇ = J_1⁺ẋ_1 + (I − J_1⁺J_1) J_2⁺ẋ_2.
    /// Free of algorithmic singularities; lower tasks are not exact even where they could be. Paper: Eq. (13).
    SingularityRobust,
    /// Tasks added from the lowest to the highest. Paper: Eqs. (22), (29), (32).
    ReversePriority,
    /// The lexicographic hierarchy that reverse priority promises, for any number of tasks.
    StrictReversePriority,
}

/// How a method combines the tasks. All that the resolution knows about a method.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Scheme {
    /// All tasks are one level.
    OneLevel {
        /// Whether the level is damped near singularities.
        damped: bool,
    },
    /// Stages from the lowest task to the highest, Eq. (29).
    LowestFirst {
        /// Whether a stage ignores the lower tasks when it corrects them, Eq. (13).
        ignores_lower_tasks: bool,
    },
    /// Levels from the highest task to the lowest; each keeps the optimum of the levels before it.
    HighestFirst,
}

impl Method {
    /// Returns how the method combines the tasks.
    pub(super) fn scheme(self) -> Scheme {
        match self {
            Self::Pseudoinverse => Scheme::OneLevel { damped: false },
            Self::DampedLeastSquares => Scheme::OneLevel { damped: true },
            Self::SingularityRobust => Scheme::LowestFirst { ignores_lower_tasks: true },
            Self::ReversePriority => Scheme::LowestFirst { ignores_lower_tasks: false },
            Self::TaskPriority | Self::StrictReversePriority => Scheme::HighestFirst,
        }
    }
}

/// How the problem is solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Solver {
    /// Pseudo-inverses, limits ignored and violations reported: the reference.
    ClosedForm,
    /// Every level through Clarabel.
    Qp,
    /// The answer of `Qp` by the fastest certified way.
    #[default]
    Auto,
}

/// Prioritised tasks, the velocities that limits allow, and how to resolve them.
#[derive(Debug, Clone, PartialEq)]
pub struct Problem {
    /// The tasks, highest priority first.
    pub tasks: TaskStack,
    /// lo ≤ q̇ ≤ hi, n joints, rad/s.
    pub limits: VelocityBox,
    /// a·q̇ ≤ b beside the box; where the box contradicts them, they are broken as little as possible and reported.
    pub inequalities: Vec<Inequality>,
    /// The resolution method.
    pub method: Method,
    /// How the problem is solved.
    pub solver: Solver,
    /// Damping near singularities; `None` is exact.
    pub damping: Option<Damping>,
    /// ζ̇, the joint velocity (n, rad/s) that the tasks leave untouched as far as they can; `None` is zero.
    pub null_space_velocity: Option<Vector>,
}

/// Why a problem is refused.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ProblemError {
    /// The limits are about another number of joints than the tasks.
    #[error("limits for {given} joints, tasks for {expected}")]
    Limits {
        /// Joints of the tasks.
        expected: usize,
        /// Joints of the limits.
        given: usize,
    },
    /// An inequality is about another number of joints than the tasks.
    #[error("inequality `{name}` has {given} coefficients, the tasks have {expected} joints")]
    Inequality {
        /// Its name.
        name: String,
        /// Place in the list, from 0.
        index: usize,
        /// Joints of the tasks.
        expected: usize,
        /// Its coefficients.
        given: usize,
    },
    /// ζ̇ has the wrong size or is not finite.
    #[error("the null-space velocity needs {expected} finite entries")]
    NullSpaceVelocity {
        /// Joints of the tasks.
        expected: usize,
    },
}

impl Problem {
    /// The tasks by reverse priority, exact, without limits.
    pub fn new(tasks: TaskStack) -> Self {
        Self {
            limits: VelocityBox::unbounded(tasks.joint_count()),
            tasks,
            inequalities: Vec::new(),
            method: Method::ReversePriority,
            solver: Solver::Auto,
            damping: None,
            null_space_velocity: None,
        }
    }

    /// Checks that the parts are about the same joints.
    pub(super) fn check(&self) -> Result<(), ProblemError> {
        let expected = self.tasks.joint_count();
        if self.limits.joint_count() != expected {
            return Err(ProblemError::Limits { expected, given: self.limits.joint_count() });
        }
        for (index, inequality) in self.inequalities.iter().enumerate() {
            let given = inequality.coefficients().len();
            if given != expected {
                return Err(ProblemError::Inequality { name: inequality.name().to_owned(), index, expected, given });
            }
        }
        let fits = |zeta: &Vector| zeta.len() == expected && zeta.iter().all(|entry| entry.is_finite());
        match &self.null_space_velocity {
            Some(zeta) if !fits(zeta) => Err(ProblemError::NullSpaceVelocity { expected }),
            _ => Ok(()),
        }
    }

    /// Whether a velocity (n, rad/s) keeps every limit and inequality.
    pub(super) fn allows(&self, qdot: &TaskVector) -> bool {
        self.limits.allows(qdot)
            && (self.inequalities.is_empty() || {
                let qdot = qdot.to_vector();
                self.inequalities.iter().all(|limit| limit.violation(&qdot) == 0.0)
            })
    }

    /// ζ̇, n.
    pub(super) fn start(&self) -> TaskVector {
        let zero = || TaskVector::zeros(self.tasks.joint_count());
        self.null_space_velocity.as_ref().map_or_else(zero, TaskVector::from)
    }
}
