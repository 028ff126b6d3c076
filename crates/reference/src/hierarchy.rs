//! A problem with priority levels inside a box, and its solution.

use revprio_problem::{BoundId, LevelReport, Matrix, Multipliers, Side, Vector};

/// Rows of one priority: lower ≤ a·x ≤ upper. A row with equal bounds is an equation.
#[derive(Debug, Clone)]
pub struct Level {
    /// The coefficients, one row of the matrix per row, as many columns as unknowns.
    pub rows: Matrix,
    /// Lower bound of each row, −∞ without one, in the unit of the row: m/s, rad/s.
    pub lower: Vec<f64>,
    /// Upper bound of each row, ∞ without one.
    pub upper: Vec<f64>,
    /// Where each row comes from.
    pub names: Vec<Option<BoundId>>,
}

impl Level {
    /// Returns a level without rows for n unknowns.
    pub fn new(n: usize) -> Self {
        Self { rows: Matrix::zeros(0, n), lower: Vec::new(), upper: Vec::new(), names: Vec::new() }
    }

    /// Adds rows. Missing columns are zero.
    pub fn push(&mut self, rows: &Matrix, lower: &[f64], upper: &[f64], name: impl Fn(usize) -> Option<BoundId>) {
        let (start, count) = (self.rows.nrows(), rows.nrows());
        self.rows.resize_vertically_mut(start + count, 0.0);
        self.rows.view_mut((start, 0), rows.shape()).copy_from(rows);
        self.lower.extend_from_slice(lower);
        self.upper.extend_from_slice(upper);
        self.names.extend((0..count).map(name));
    }

    /// Adds the rows λ x = λ x' of damping.
    pub fn push_damping(&mut self, lambda: f64, near: &Vector) {
        if lambda > 0.0 {
            let mut rows = Matrix::zeros(near.len(), self.rows.ncols());
            rows.fill_diagonal(lambda);
            let targets: Vec<f64> = near.iter().map(|x| lambda * x).collect();
            self.push(&rows, &targets, &targets, |_| None);
        }
    }

    /// Returns whether a row is an equation. A row whose bound is not a number is one, so that the solution fails.
    pub fn is_equation(&self, row: usize) -> bool {
        !(self.lower[row] < self.upper[row])
    }

    /// Returns whether some coefficients are not zero but their squares are, so that nothing is known of the level.
    pub fn underflows(&self) -> bool {
        self.rows.amax() > 0.0 && !self.rows.norm().is_normal()
    }

    /// Returns by how much a value misses the bounds of a row: positive below, negative above, 0 inside.
    pub fn missing(&self, row: usize, value: f64) -> f64 {
        if value < self.lower[row] {
            self.lower[row] - value
        } else if value > self.upper[row] {
            self.upper[row] - value
        } else if value.is_nan() {
            f64::NAN
        } else {
            0.0
        }
    }

    /// Returns a·x of a row.
    pub fn value(&self, row: usize, x: &Vector) -> f64 {
        self.rows.row(row).iter().zip(x.iter()).map(|(a, x)| a * x).sum()
    }
}

/// Levels inside a box, highest first; after the last one, ‖x − ζ‖² is minimised.
#[derive(Debug, Clone)]
pub struct Hierarchy {
    /// Lower bound of each unknown. The first unknowns are the joint velocities, rad/s; the others are speeds of scaled tasks, m/s.
    pub lower: Vec<f64>,
    /// Upper bound of each unknown.
    pub upper: Vec<f64>,
    /// ζ, one entry for each unknown.
    pub reference: Vector,
    /// The levels, each with at least one row.
    pub levels: Vec<Level>,
}

impl Hierarchy {
    /// Returns a problem without bounds and levels.
    pub fn new(reference: Vector) -> Self {
        let n = reference.len();
        Self { lower: vec![f64::NEG_INFINITY; n], upper: vec![f64::INFINITY; n], reference, levels: Vec::new() }
    }

    /// Adds a level, if it has rows.
    pub fn push(&mut self, level: Level) {
        if level.rows.nrows() > 0 {
            self.levels.push(level);
        }
    }

    /// Returns the number of unknowns.
    pub fn unknowns(&self) -> usize {
        self.lower.len()
    }

    /// Returns the speed that the levels and the reference ask for, as far as the box allows it.
    pub fn speed(&self) -> f64 {
        let target = |level: &Level| {
            let missing = (0..level.rows.nrows()).map(|row| level.missing(row, 0.0).abs());
            let size = missing.fold(0.0, f64::max);
            if size > 0.0 { size / level.rows.norm() } else { 0.0 }
        };
        let asked = self.levels.iter().map(target).filter(|speed| speed.is_finite());
        let widest = |(lower, upper): (&f64, &f64)| lower.abs().max(upper.abs());
        let allowed = self.lower.iter().zip(&self.upper).map(widest).fold(0.0, f64::hypot);
        asked.fold(self.reference.norm(), f64::max).min(allowed)
    }

    /// Returns whether the bounds of an unknown coincide.
    pub fn is_pinned(&self, unknown: usize) -> bool {
        self.lower[unknown] >= self.upper[unknown]
    }

    /// Returns a bound of an unknown.
    pub fn bound(&self, unknown: usize, side: Side) -> f64 {
        match side {
            Side::Lower => self.lower[unknown],
            Side::Upper => self.upper[unknown],
        }
    }

    /// Returns the point of the box that is nearest to x.
    pub fn clamp(&self, x: &Vector) -> Vector {
        // Not a number stays one: the answer is then refused.
        Vector::from_fn(x.len(), |j, _| {
            if x[j] < self.lower[j] {
                self.lower[j]
            } else if x[j] > self.upper[j] {
                self.upper[j]
            } else {
                x[j]
            }
        })
    }
}

/// The solution of a hierarchical problem and how sure it is.
#[derive(Debug, Clone)]
pub struct Solution {
    pub x: Vector,
    /// First multiplier that is not zero of the bounds of each unknown: positive at the upper, negative at the lower bound.
    pub multipliers: Vec<f64>,
    /// The same of the rows of each level, 0 for equations.
    pub row_multipliers: Vec<Vec<f64>>,
    /// The active bound of each unknown and of each inequality row.
    pub active: Vec<Option<Side>>,
    pub active_rows: Vec<Vec<Option<Side>>>,
    /// What was done at each level.
    pub reports: Vec<LevelReport>,
    /// Estimate of the error of x.
    pub error: f64,
    /// Levels without an answer.
    pub failures: u32,
    /// Whether some level is not solved surely.
    pub is_unsure: bool,
    /// Whether rounding may have decided a rank.
    pub rank_uncertain: bool,
    /// The multipliers of each level and of the last objective, if they are wanted.
    pub certificate: Vec<Option<Multipliers>>,
}

impl Solution {
    /// Returns a solution without active bounds and multipliers.
    pub fn new(problem: &Hierarchy, x: Vector) -> Self {
        let n = x.len();
        let rows = |level: &Level| level.rows.nrows();
        Self {
            x,
            multipliers: vec![0.0; n],
            row_multipliers: problem.levels.iter().map(|level| vec![0.0; rows(level)]).collect(),
            active: vec![None; n],
            active_rows: problem.levels.iter().map(|level| vec![None; rows(level)]).collect(),
            reports: Vec::new(),
            error: 0.0,
            failures: 0,
            is_unsure: false,
            rank_uncertain: false,
            certificate: Vec::new(),
        }
    }

    /// Returns whether a bound or an inequality row is active.
    pub fn is_bounded(&self) -> bool {
        self.active.iter().chain(self.active_rows.iter().flatten()).any(Option::is_some)
    }
}
