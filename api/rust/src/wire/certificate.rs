//! The certificate of an answer: what anyone needs to check that it is optimal.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// The problems that were solved on the way to an answer, with their solutions and multipliers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Certificate {
    /// The problems in the order of their solution.
    pub problems: Vec<CertifiedProblem>,
    /// The parts of the joint velocity: Σ weight · solution, moved to the nearest point of the box.
    pub answer: Vec<CertificatePart>,
}

/// A part of an answer.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct CertificatePart {
    /// Index of the problem, from 0.
    pub problem: usize,
    /// Weight of its solution; all weights add up to one.
    pub weight: f64,
}

/// A problem with priority levels inside a box, and its solution x.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct CertifiedProblem {
    /// Lower bounds of the unknowns: the joint velocities, then the speed of each scaled task; `null`: no bound.
    pub lower: Vec<Option<f64>>,
    /// Upper bounds of the unknowns.
    pub upper: Vec<Option<f64>>,
    /// Reference ζ: after the last level, ‖x − ζ‖² is as small as possible.
    pub reference: Vec<f64>,
    /// Levels, highest first.
    pub levels: Vec<CertifiedLevel>,
    /// Solution x.
    pub solution: Vec<f64>,
    /// Multipliers of each level, and of the last objective at the end; `null` where a level leaves no residual.
    pub multipliers: Vec<Option<LevelMultipliers>>,
}

/// The rows of a level: each asks lower ≤ a·x ≤ upper.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct CertifiedLevel {
    /// Coefficients a of each row, one per unknown.
    pub rows: Vec<Vec<f64>>,
    /// Lower bounds of the rows; `null`: no bound. A row with equal bounds is an equation.
    pub lower: Vec<Option<f64>>,
    /// Upper bounds of the rows.
    pub upper: Vec<Option<f64>>,
    /// What each row stands for.
    pub names: Vec<RowName>,
}

/// What a row stands for: a row of a task, an inequality, or, without fields, damping or a part of a scaled task.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct RowName {
    /// Name of the task.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub task: Option<String>,
    /// Index of the row in its task, from 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub row: Option<usize>,
    /// Name of the inequality. Its row has length one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub inequality: Option<String>,
}

/// The multipliers of one level.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct LevelMultipliers {
    /// Weights w of the rows of this level and all higher ones, highest level first; the residuals on the level's own rows.
    pub rows: Vec<f64>,
    /// Multipliers h of the bounds of the unknowns, Σ w a over the rows; for the last objective plus ζ − x.
    pub unknowns: Vec<f64>,
}
