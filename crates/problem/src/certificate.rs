//! What an answer needs so that anyone can check that it is optimal.

use crate::BoundId;

/// The problems that were solved on the way to an answer, their solutions and multipliers.
///
/// A level minimises the squared slack of its rows inside the box, without changing what higher levels achieved. With
/// r the residuals of the rows of level k (0 where they are met), w = r on these rows and any numbers on the rows of
/// higher levels, h = Σ w_i a_i must be zero at unknowns inside their bounds, positive at upper and negative at lower
/// bounds. `docs/certificate.md` in the repository has the conditions for inequality rows and a program that checks them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Certificate {
    /// The problems in the order of their solution.
    pub problems: Vec<CertifiedProblem>,
    /// The parts of the answer: q̇ = Σ weight · solution, moved to the nearest point of the box.
    pub answer: Vec<Part>,
}

/// A part of an answer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Part {
    /// Index of the problem, from 0.
    pub problem: usize,
    /// Its weight; the weights add up to one.
    pub weight: f64,
}

/// A hierarchical problem with its solution.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CertifiedProblem {
    /// Lower bounds of the unknowns: the joints, then the speeds of scaled tasks.
    pub lower: Vec<f64>,
    /// Upper bounds of the unknowns.
    pub upper: Vec<f64>,
    /// ζ: after the last level, ‖x − ζ‖² is as small as possible.
    pub reference: Vec<f64>,
    /// The levels, highest first.
    pub levels: Vec<CertifiedLevel>,
    /// x.
    pub solution: Vec<f64>,
    /// The multipliers of each level, and of the last objective at the end; `None` where the level leaves no residual.
    pub multipliers: Vec<Option<Multipliers>>,
}

/// The rows of a level.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CertifiedLevel {
    /// The coefficients, one list per row.
    pub rows: Vec<Vec<f64>>,
    /// The lower bounds of the rows.
    pub lower: Vec<f64>,
    /// The upper bounds of the rows.
    pub upper: Vec<f64>,
    /// What the rows stand for; `None` for rows of damping and parts of scaled tasks. The rows of constraints have length one.
    pub names: Vec<Option<BoundId>>,
}

/// The multipliers of one level.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Multipliers {
    /// w, of the rows of this level and all higher ones.
    pub rows: Vec<f64>,
    /// h = Σ w_i a_i, plus ζ − x for the last objective.
    pub unknowns: Vec<f64>,
}
