//! One level through Clarabel, an interior-point solver.
#![allow(non_snake_case)]

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolution, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus};

use super::active_set::{ActiveSet, Side};
use super::level::Level;

/// Far above the 5-15 iterations that levels take; a cap, because a failing problem would run on.
const MAX_ITERATIONS: u32 = 40;

/// Clarabel reaches this on every level in reduced form; the exact answer comes from polishing.
const TOLERANCE: f64 = 1e-10;

/// Solvers by the size of their problem, (unknowns, constraints), kept and overwritten.
///
/// Their structure depends on sizes alone, and nothing of one problem is left for the next: without equilibration, which
/// remembers, the answers are those of fresh solvers, to the last bit.
#[derive(Default)]
pub struct ClarabelLevels {
    solvers: Vec<((usize, usize), DefaultSolver<f64>)>,
    numbers: Numbers,
}

/// Sizes whose solvers are kept; levels of one problem have a handful.
const MOST_KEPT: usize = 16;

impl ClarabelLevels {
    /// min ‖C z − d‖² s.t. the level's bounds, as ½ zᵀP z + qᵀz s.t. A z + s = b, s ≥ 0: the limits that are active, `None`
    /// if the solver fails, and the iterations taken.
    ///
    /// Its z is not worth taking: off by some 1e-7, and arbitrarily large where the objective leaves a direction open.
    pub fn solve(&mut self, level: &Level) -> (Option<ActiveSet>, u32) {
        self.numbers.of(level);
        let size = (level.unknowns(), self.numbers.constraints.len());
        let place = match self.solvers.iter().position(|(known, _)| *known == size) {
            Some(place) if self.numbers.update(&mut self.solvers[place].1) => place,
            Some(place) => match self.numbers.solver(size.0) {
                Some(solver) => {
                    self.solvers[place].1 = solver;
                    place
                }
                None => return (None, 0),
            },
            None => {
                let Some(solver) = self.numbers.solver(size.0) else { return (None, 0) };
                if self.solvers.len() >= MOST_KEPT {
                    self.solvers.clear();
                }
                self.solvers.push((size, solver));
                self.solvers.len() - 1
            }
        };
        let solver = &mut self.solvers[place].1;
        solver.solve();
        #[cfg(test)]
        fault::strike(&mut solver.solution);
        let answer = (pressed(&solver.solution, &self.numbers.constraints), solver.solution.iterations);
        if answer.0.is_none() {
            // After numerical trouble a solver may never recover.
            self.solvers.swap_remove(place);
        }
        answer
    }
}

/// The numbers of a problem in the solver's order: columns of full matrices, of P the upper triangle.
#[derive(Default)]
struct Numbers {
    constraints: Vec<(usize, Side, f64)>,
    P: Vec<f64>,
    q: Vec<f64>,
    A: Vec<f64>,
    b: Vec<f64>,
}

impl Numbers {
    fn of(&mut self, level: &Level) {
        let scale = Scale::of(level);
        let (C, p) = (&level.C, level.unknowns());
        refill(&mut self.constraints, level.constraints());
        let gram = |i: usize, j: usize| (0..C.nrows()).map(|row| C[row][i] * C[row][j]).sum::<f64>();
        refill(
            &mut self.P,
            (0..p).flat_map(|j| (0..=j).map(move |i| (i, j))).map(|(i, j)| gram(i, j) * scale.objective),
        );
        let linear = C.transposed_times(&level.d);
        refill(&mut self.q, linear.iter().map(|entry| entry * (-scale.objective / scale.unknowns)));
        let Self { constraints, A, b, .. } = self;
        let signed = |j: usize, &(row, side, _): &(usize, Side, f64)| match side {
            Side::Lower => -level.G[row][j],
            Side::Upper => level.G[row][j],
        };
        refill(A, (0..p).flat_map(|j| constraints.iter().map(move |limit| signed(j, limit))));
        refill(b, constraints.iter().map(|(_, _, bound)| bound.abs() / scale.unknowns));
    }

    /// Overwrites the numbers of a solver of this size; whether it took them.
    fn update(&self, solver: &mut DefaultSolver<f64>) -> bool {
        solver.update_data(&self.P, &self.q, &self.A, &self.b).is_ok()
    }

    /// A solver for `unknowns`; `None` for numbers that it refuses.
    fn solver(&self, unknowns: usize) -> Option<DefaultSolver<f64>> {
        let m = self.b.len();
        let P = CscMatrix::new(
            unknowns,
            unknowns,
            (0..=unknowns).map(|j| j * (j + 1) / 2).collect(),
            (0..unknowns).flat_map(|j| 0..=j).collect(),
            self.P.clone(),
        );
        let A = CscMatrix::new(
            m,
            unknowns,
            (0..=unknowns).map(|j| j * m).collect(),
            (0..unknowns).flat_map(|_| 0..m).collect(),
            self.A.clone(),
        );
        let cones = if m == 0 { vec![] } else { vec![NonnegativeConeT(m)] };
        DefaultSolver::new(&P, &self.q, &A, &self.b, &cones, settings()).ok()
    }
}

fn refill<T>(list: &mut Vec<T>, entries: impl Iterator<Item = T>) {
    list.clear();
    list.extend(entries);
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

/// Kept, overwritten, and without equilibration and refinement, a solver takes 0.63 of the time of a new one with the
/// defaults, or 0.56 at a tolerance of 1e-8; at 1e-6 it finds the wrong limits in 1.5 % of the levels
/// (`tools/bench/benches/clarabel.rs`).
fn settings() -> DefaultSettings<f64> {
    DefaultSettings {
        verbose: false,
        presolve_enable: false,
        equilibrate_enable: false,
        iterative_refinement_enable: false,
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

    pub fn strikes() -> bool {
        FAULT.get().is_some()
    }

    pub fn strikes_search() -> bool {
        FAULT.get().is_some_and(|fault| fault.search)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::{TaskMatrix, TaskVector};

    #[test]
    fn a_joint_between_bounds_that_nearly_coincide_is_active_at_one_of_them() {
        for width in [0.0, 1e-16, 1e-12, 1e-8] {
            let level = Level {
                C: TaskMatrix::from_fn(1, 2, |_, j| [1.0, 0.5][j]),
                d: TaskVector::from_slice(&[2.0]),
                G: TaskMatrix::identity(2),
                lower: TaskVector::from_slice(&[-width, -1.0]),
                upper: TaskVector::from_slice(&[width, 1.0]),
                bounded: vec![true; 2],
                speed: 1.0,
                scale: 1.0,
                base_size: 1.0,
            };
            assert_eq!(
                ClarabelLevels::default().solve(&level).0.unwrap().as_slice(),
                [(0, Side::Upper), (1, Side::Upper)],
                "width {width:e}"
            );
        }
    }
}
