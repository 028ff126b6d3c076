//! One level through Clarabel, an interior-point solver.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolution, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus};

use super::active_set::{ActiveSet, Side};
use super::level::Level;
use crate::linalg::Matrix;

/// Far above the 5-15 iterations that levels take; a cap, because a failing problem would run on.
const MAX_ITERATIONS: u32 = 40;

/// Clarabel reaches this on every level in reduced form; the exact answer comes from polishing.
const TOLERANCE: f64 = 1e-10;

/// min ‖C z − d‖² s.t. the level's bounds, as ½ zᵀP z + qᵀz s.t. A z + s = b, s ≥ 0: the limits that are active, `None` if
/// the solver fails, and the iterations taken.
///
/// Its z is not worth taking: off by some 1e-7, and arbitrarily large where the objective leaves a direction open.
pub fn solve(level: &Level) -> (Option<ActiveSet>, u32) {
    let constraints: Vec<(usize, Side, f64)> = level.constraints().collect();
    let scale = Scale::of(level);
    let p = upper_triangle(&(level.C.transpose() * &level.C * scale.objective));
    let q = level.C.transpose() * &level.d * (-scale.objective / scale.unknowns);
    let signed = |&(row, side, _): &(usize, Side, f64)| match side {
        Side::Lower => -level.G.row(row),
        Side::Upper => level.G.row(row).into_owned(),
    };
    let rows: Vec<_> = constraints.iter().map(signed).collect();
    let a = dense(constraints.len(), level.unknowns(), |i, j| rows[i][j]);
    let b: Vec<f64> = constraints.iter().map(|(_, _, bound)| bound.abs() / scale.unknowns).collect();
    let cones = if b.is_empty() { vec![] } else { vec![NonnegativeConeT(b.len())] };
    match DefaultSolver::new(&p, q.as_slice(), &a, &b, &cones, settings()) {
        Ok(mut solver) => {
            solver.solve();
            #[cfg(test)]
            fault::strike(&mut solver.solution);
            (pressed(&solver.solution, &constraints), solver.solution.iterations)
        }
        Err(_) => (None, 0),
    }
}

/// Units in which the problem is of size one, so that the solver's tolerances mean the same for every task.
struct Scale {
    /// Factor of the objective.
    objective: f64,
    /// Size of z.
    unknowns: f64,
}

impl Scale {
    fn of(level: &Level) -> Self {
        let (c, d) = (level.C.norm(), level.d.norm());
        let positive = |value: f64| if value.is_normal() { value } else { 1.0 };
        Self { objective: positive(1.0 / (c * c)), unknowns: positive(d / c) }
    }
}

fn settings() -> DefaultSettings<f64> {
    DefaultSettings {
        verbose: false,
        presolve_enable: false,
        max_iter: MAX_ITERATIONS,
        tol_gap_abs: TOLERANCE,
        tol_gap_rel: TOLERANCE,
        tol_feas: TOLERANCE,
        ..DefaultSettings::default()
    }
}

/// Limits whose multiplier exceeds their slack.
fn pressed(solution: &DefaultSolution<f64>, constraints: &[(usize, Side, f64)]) -> Option<ActiveSet> {
    let usable = matches!(solution.status, SolverStatus::Solved | SolverStatus::AlmostSolved)
        && solution.x.iter().all(|x| x.is_finite());
    if !usable {
        return None;
    }
    let mut pressed: Vec<(usize, Side, f64)> = Vec::new();
    for (&(row, side, _), (&multiplier, &slack)) in constraints.iter().zip(solution.z.iter().zip(&solution.s)) {
        if multiplier <= slack {
            continue;
        }
        // Bounds nearer to each other than the solver's tolerance are both pressed; the set takes one per joint.
        match pressed.last_mut() {
            Some(other) if other.0 == row => {
                if multiplier > other.2 {
                    *other = (row, side, multiplier);
                }
            }
            _ => pressed.push((row, side, multiplier)),
        }
    }
    Some(pressed.into_iter().map(|(row, side, _)| (row, side)).collect())
}

/// A full pattern, zeros included: the solver's structure then depends on sizes alone.
fn dense(rows: usize, columns: usize, entry: impl Fn(usize, usize) -> f64) -> CscMatrix<f64> {
    CscMatrix::new(
        rows,
        columns,
        (0..=columns).map(|j| j * rows).collect(),
        (0..columns).flat_map(|_| 0..rows).collect(),
        (0..columns).flat_map(|j| (0..rows).map(move |i| (i, j))).map(|(i, j)| entry(i, j)).collect(),
    )
}

fn upper_triangle(symmetric: &Matrix) -> CscMatrix<f64> {
    let n = symmetric.ncols();
    CscMatrix::new(
        n,
        n,
        (0..=n).map(|j| j * (j + 1) / 2).collect(),
        (0..n).flat_map(|j| 0..=j).collect(),
        (0..n).flat_map(|j| (0..=j).map(move |i| symmetric[(i, j)])).collect(),
    )
}

/// Faults that tests inject: what a solver returns when it fails, and a search that finds nothing.
#[cfg(test)]
pub mod fault {
    use std::cell::Cell;

    use clarabel::solver::DefaultSolution;
    pub use clarabel::solver::SolverStatus;

    /// What goes wrong.
    #[derive(Debug, Clone, Copy)]
    pub struct Fault {
        /// Every solve ends with this status …
        pub status: SolverStatus,
        /// … and this value in all entries of x.
        pub entry: f64,
        /// Whether the active-set iteration finds nothing either.
        pub search: bool,
    }

    thread_local! {
        static FAULT: Cell<Option<Fault>> = const { Cell::new(None) };
    }

    /// Runs `f` with the fault on this thread.
    pub fn with<T>(fault: Fault, f: impl FnOnce() -> T) -> T {
        FAULT.set(Some(fault));
        let result = f();
        FAULT.set(None);
        result
    }

    pub(super) fn strike(solution: &mut DefaultSolution<f64>) {
        if let Some(Fault { status, entry, .. }) = FAULT.get() {
            solution.status = status;
            solution.x.fill(entry);
        }
    }

    pub fn strikes_search() -> bool {
        FAULT.get().is_some_and(|fault| fault.search)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::Vector;

    #[test]
    fn a_joint_between_bounds_that_nearly_coincide_is_active_at_one_of_them() {
        for width in [0.0, 1e-16, 1e-12, 1e-8] {
            let level = Level {
                C: Matrix::from_row_slice(1, 2, &[1.0, 0.5]),
                d: Vector::from_vec(vec![2.0]),
                G: Matrix::identity(2, 2),
                lower: Vector::from_vec(vec![-width, -1.0]),
                upper: Vector::from_vec(vec![width, 1.0]),
                bounded: vec![true; 2],
                speed: 1.0,
                scale: 1.0,
                base_size: 1.0,
            };
            assert_eq!(solve(&level).0.unwrap(), [(0, Side::Upper), (1, Side::Upper)], "width {width:e}");
        }
    }
}
