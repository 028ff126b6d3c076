//! The problem that solvers solve.

use crate::{BoundId, Damping, Inequality, LOWEST_CONSTRAINT_LEVEL, TaskStack, Vector, VelocityBox};

/// The largest number of unknowns of a problem: joints, and one for each scaled task.
pub const MAX_UNKNOWNS: usize = 136;

/// The resolution method.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// All tasks as one stack, q̇ = J⁺ẋ + (I − J⁺J) ζ̇. Never damped. Paper: Eq. (5).
    Pseudoinverse,
    /// All tasks as one stack with the variable damping factor: the paper's "classical" control. Paper: Eqs. (14)-(19).
    DampedLeastSquares,
    /// Classical task priority with the projector of all higher tasks. Paper: Eq. (11), for any number of tasks.
    ///
    /// In exact arithmetic the same as [`Method::StrictReversePriority`]: both are the lexicographic least-squares solution.
    TaskPriority,
    /// Lower tasks first, each higher one then corrects in its own row space alone, q̇ = J_1⁺ẋ_1 + (I − J_1⁺J_1) J_2⁺ẋ_2.
    /// Free of algorithmic singularities; lower tasks are not exact even where they could be. Paper: Eq. (13).
    SingularityRobust,
    /// Tasks added from the lowest to the highest. Paper: Eqs. (22), (29), (32).
    ReversePriority,
    /// The lexicographic hierarchy that reverse priority promises, for any number of tasks.
    StrictReversePriority,
}

/// The name of a solver.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Solver {
    /// The printed formulas with pseudo-inverses; limits are ignored and violations reported: `revprio_reference::ClosedForm`.
    ClosedForm,
    /// Clarabel's answer at every level: `revprio_reference::Qp`.
    Qp,
    /// The hierarchical active-set solver: `revprio_core::resolution::Resolver`.
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
    /// a·q̇ ≤ b next to the box; where the box contradicts them, they are broken as little as possible and reported.
    pub inequalities: Vec<Inequality>,
    /// The resolution method.
    pub method: Method,
    /// Damping near singularities; `None` is exact.
    pub damping: Option<Damping>,
    /// ζ̇, the joint velocity (n, rad/s) that the tasks leave untouched as far as they can; `None` is zero.
    pub null_space_velocity: Option<Vector>,
    /// Whether the answer carries a [`crate::Certificate`].
    pub wants_certificate: bool,
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
    /// The problem has more unknowns than the solver takes.
    #[error("{given} unknowns (joints, and one for each scaled task); give at most {limit}")]
    Size {
        /// Unknowns of the problem.
        given: usize,
        /// The largest number of unknowns.
        limit: usize,
    },
    /// ζ̇ has the wrong size or is not finite.
    #[error("the null-space velocity needs {expected} finite entries")]
    NullSpaceVelocity {
        /// Joints of the tasks.
        expected: usize,
    },
}

impl Problem {
    /// The tasks by strict reverse priority, exact, without limits.
    pub fn new(tasks: TaskStack) -> Self {
        Self {
            limits: VelocityBox::unbounded(tasks.joint_count()),
            tasks,
            inequalities: Vec::new(),
            method: Method::StrictReversePriority,
            damping: None,
            null_space_velocity: None,
            wants_certificate: false,
        }
    }

    /// Returns the rows of the constraints with their names, the highest level first. Rows without a bound are left out, because they
    /// always hold.
    pub fn constraint_rows(&self) -> impl Iterator<Item = (BoundId, &Inequality)> {
        (0..=LOWEST_CONSTRAINT_LEVEL).flat_map(|level| {
            self.named_rows().filter(move |(_, row)| row.level() == level && row.bound() < f64::INFINITY)
        })
    }

    /// Returns all rows of the constraints with their names, in the order of `inequalities`: each row 0 begins a constraint.
    fn named_rows(&self) -> impl Iterator<Item = (BoundId, &Inequality)> {
        let mut begun = 0;
        self.inequalities.iter().map(move |inequality| {
            begun += usize::from(inequality.row() == 0);
            (BoundId::Constraint { index: begun.saturating_sub(1), row: inequality.row() }, inequality)
        })
    }

    /// Checks that there are at most [`MAX_UNKNOWNS`] unknowns, that all parts are about the same joints, and that the
    /// null-space velocity is finite.
    pub fn check(&self) -> Result<(), ProblemError> {
        let expected = self.tasks.joint_count();
        let given = expected + self.tasks.tasks().iter().filter(|task| task.scaled).count();
        if given > MAX_UNKNOWNS {
            return Err(ProblemError::Size { given, limit: MAX_UNKNOWNS });
        }
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
}
