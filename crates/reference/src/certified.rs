//! The multipliers of levels, and the record of the problems that were solved.

use revprio_problem::{Certificate, CertifiedLevel, CertifiedProblem, Matrix, Multipliers, Part, Vector};

use crate::hierarchy::{Hierarchy, Solution};
use crate::svd::{RANK_TOLERANCE, Svd};

/// What is known of the multipliers of a level before those of the equations above it.
pub struct Known<'a> {
    /// Multipliers of the bounds of unknowns.
    pub unknowns: &'a [f64],
    /// Multipliers of the rows of each level: positive at the upper bound.
    pub rows: &'a [Vec<f64>],
    /// Unknowns that are held at a bound: their multipliers are not known.
    pub fixed: &'a [bool],
    /// Rows of each level that are kept at their value: the same.
    pub kept: &'a [Vec<bool>],
}

/// Returns the multipliers of level k at x, from the residuals of its rows, from the known ones, and by least squares from the
/// rows of higher levels that are kept; `None` where the level leaves no residual.
///
/// h = A_kᵀ r_k + Σ w_i a_i is the known multiplier at unknowns that are not fixed.
pub fn level_multipliers(problem: &Hierarchy, k: usize, x: &Vector, known: &Known) -> Option<Multipliers> {
    let n = problem.unknowns();
    let mut weights: Vec<f64> = Vec::new();
    let mut gradient = Vector::zeros(n);
    let mut higher: Vec<(usize, Vector)> = Vec::new();
    for (index, level) in problem.levels.iter().enumerate().take(k + 1) {
        for row in 0..level.rows.nrows() {
            let a = level.rows.row(row).transpose();
            let place = weights.len();
            if index < k && known.kept[index][row] {
                weights.push(0.0);
                higher.push((place, a));
            } else {
                let residual = || level.missing(row, level.value(row, x));
                weights.push(if index == k { residual() } else { -known.rows[index][row] });
                gradient.axpy(weights[place], &a, 1.0);
            }
        }
    }
    if k == problem.levels.len() {
        gradient += &problem.reference - x;
    }
    if gradient.amax() == 0.0 && weights.iter().all(|w| *w == 0.0) {
        return None;
    }
    let free: Vec<usize> = (0..n).filter(|&j| !known.fixed[j]).collect();
    // Rows of length one: those of different levels have different units.
    let norms: Vec<f64> =
        higher.iter().map(|(_, a)| Some(a.norm()).filter(|norm| *norm > 0.0).unwrap_or(1.0)).collect();
    let rows = Matrix::from_fn(free.len(), higher.len(), |i, j| higher[j].1[free[i]] / norms[j]);
    let missing = Vector::from_iterator(free.len(), free.iter().map(|&j| known.unknowns[j] - gradient[j]));
    let svd = Svd::new(&rows);
    let found = svd.solve(svd.rank(RANK_TOLERANCE * rows.norm()), 0.0, &missing);
    for (((place, a), w), norm) in higher.iter().zip(found.iter()).zip(norms) {
        weights[*place] = w / norm;
        gradient.axpy(weights[*place], a, 1.0);
    }
    Some(Multipliers { rows: weights, unknowns: gradient.as_slice().to_vec() })
}

/// The problems that were solved, and what the answer consists of.
#[derive(Default)]
pub struct Record {
    problems: Vec<CertifiedProblem>,
    answer: Vec<Part>,
}

impl Record {
    /// Adds a problem with its solution, which is the answer until [`Self::set_answer`] is called.
    pub fn push(&mut self, problem: &Hierarchy, solution: &Solution) {
        let levels = problem.levels.iter().map(|level| CertifiedLevel {
            rows: level.rows.row_iter().map(|row| row.iter().copied().collect()).collect(),
            lower: level.lower.clone(),
            upper: level.upper.clone(),
            names: level.names.clone(),
        });
        self.problems.push(CertifiedProblem {
            lower: problem.lower.clone(),
            upper: problem.upper.clone(),
            reference: problem.reference.as_slice().to_vec(),
            levels: levels.collect(),
            solution: solution.x.as_slice().to_vec(),
            multipliers: solution.certificate.clone(),
        });
        self.answer = vec![Part { problem: self.last(), weight: 1.0 }];
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
