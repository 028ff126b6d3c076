//! Recording the problems on the way to an answer, for its certificate.

use revprio_problem::{BoundId, Certificate, CertifiedLevel, CertifiedProblem, Multipliers, Part};

use super::level::Hierarchy;
use super::solver::SizedSolver;

/// The problems that were solved, and what the answer consists of.
#[derive(Default)]
pub struct Record {
    problems: Vec<CertifiedProblem>,
    answer: Vec<Part>,
}

impl Record {
    /// Adds the problem that `solver` has solved. The answer is its solution `x`, until [`Self::set_answer`] is called.
    pub fn push(&mut self, problem: &Hierarchy, origins: &[Option<BoundId>], x: &[f64], solver: &mut dyn SizedSolver) {
        let count = problem.level_ends.len();
        let levels = (0..count).map(|level| certified_level(problem, origins, level)).collect();
        let multipliers = (0..=count).map(|level| multipliers(problem, level, x, solver)).collect();
        self.problems.push(CertifiedProblem {
            lower: problem.lower.clone(),
            upper: problem.upper.clone(),
            reference: problem.reference.clone(),
            levels,
            solution: x.to_vec(),
            multipliers,
        });
        self.answer = vec![Part { problem: self.problems.len() - 1, weight: 1.0 }];
    }

    /// Returns the index of the problem that was added last.
    pub fn last(&self) -> usize {
        self.problems.len().saturating_sub(1)
    }

    /// Sets the parts of the answer.
    pub fn set_answer(&mut self, parts: Vec<Part>) {
        self.answer = parts;
    }

    /// Returns the certificate.
    pub fn into_certificate(self) -> Certificate {
        Certificate { problems: self.problems, answer: self.answer }
    }
}

fn certified_level(problem: &Hierarchy, origins: &[Option<BoundId>], level: usize) -> CertifiedLevel {
    let rows = problem.level_start(level)..problem.level_ends[level];
    CertifiedLevel {
        rows: rows.clone().map(|row| problem.row(row).to_vec()).collect(),
        lower: problem.row_lower[rows.clone()].to_vec(),
        upper: problem.row_upper[rows.clone()].to_vec(),
        names: rows.map(|row| origins.get(row).copied().flatten()).collect(),
    }
}

/// Returns the multipliers of a level, or of the last objective; `None` where it leaves no residual.
fn multipliers(problem: &Hierarchy, level: usize, x: &[f64], solver: &mut dyn SizedSolver) -> Option<Multipliers> {
    let (mut rows, mut unknowns) = (Vec::new(), Vec::new());
    let count = problem.level_ends.len();
    if level == count && x == problem.reference {
        return None;
    }
    solver.write_level_multipliers(level, &mut rows, &mut unknowns);
    rows.truncate(if level == count { problem.row_count() } else { problem.level_ends[level] });
    let leaves_residual = level == count || rows[problem.level_start(level)..].iter().any(|w| *w != 0.0);
    leaves_residual.then_some(Multipliers { rows, unknowns })
}
