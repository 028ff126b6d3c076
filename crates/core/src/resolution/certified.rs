//! Recording the problems on the way to an answer, for its certificate.

use revprio_problem::{Certificate, CertifiedLevel, CertifiedProblem, Multipliers, Part};

use super::hierarchy::Hierarchy;
use super::solver::SizedSolver;

/// The problems that were solved, and what the answer consists of.
#[derive(Default)]
pub struct Record {
    problems: Vec<CertifiedProblem>,
    answer: Vec<Part>,
}

impl Record {
    /// Adds the problem that `solver` has solved. The answer is its solution `x`, until [`Self::set_answer`] is called.
    pub fn push(&mut self, problem: &Hierarchy, x: &[f64], solver: &mut dyn SizedSolver) {
        let count = problem.levels.len();
        let levels = (0..count).map(|level| certified_level(problem, level)).collect();
        let multipliers = (0..=count).map(|level| multipliers(problem, level, x, solver)).collect();
        self.problems.push(CertifiedProblem {
            lower: problem.lower[..problem.unknowns].to_vec(),
            upper: problem.upper[..problem.unknowns].to_vec(),
            reference: problem.reference[..problem.unknowns].to_vec(),
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

fn certified_level(problem: &Hierarchy, level: usize) -> CertifiedLevel {
    let level = problem.levels[level].rows();
    let rows = &problem.rows[level.clone()];
    CertifiedLevel {
        rows: level.map(|row| problem.row(row).to_vec()).collect(),
        lower: rows.iter().map(|row| row.lower).collect(),
        upper: rows.iter().map(|row| row.upper).collect(),
        names: rows.iter().map(|row| row.origin).collect(),
    }
}

/// Returns the multipliers of a level, or of the last objective; `None` where it leaves no residual.
fn multipliers(problem: &Hierarchy, level: usize, x: &[f64], solver: &mut dyn SizedSolver) -> Option<Multipliers> {
    let (mut rows, mut unknowns) = (Vec::new(), Vec::new());
    let count = problem.levels.len();
    if level == count && x == &problem.reference[..problem.unknowns] {
        return None;
    }
    solver.write_level_multipliers(problem, level, &mut rows, &mut unknowns);
    rows.truncate(if level == count { problem.rows.len() } else { problem.levels[level].end });
    let leaves_residual = level == count || rows[problem.levels[level].start..].iter().any(|w| *w != 0.0);
    leaves_residual.then_some(Multipliers { rows, unknowns })
}
