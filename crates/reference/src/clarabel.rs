//! Quadratic programs by Clarabel, an interior-point solver.
#![allow(non_snake_case)]

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus, ZeroConeT};

use crate::program::{Effort, QpAnswer, QuadraticProgram, Unsolved};

/// Gap and feasibility that Clarabel reaches on nearly every level in reduced form, whose numbers have size one.
const TOLERANCE: f64 = 1e-10;

/// A cap far above the 5 to 15 iterations that levels take: a failing problem would go on.
const MAX_ITERATIONS: u32 = 50;

/// Gap and feasibility, and what is added to the diagonal for stability, of programs of demands. With those of careful attempts
/// Clarabel gets stuck far from the answer.
const DEMAND_TOLERANCE: f64 = 1e-12;
const DEMAND_REGULARIZATION: f64 = 1e-12;

/// Gap and feasibility of a careful attempt, near rounding.
const CAREFUL_TOLERANCE: f64 = 1e-13;

/// A cap for careful attempts, which need some more iterations.
const MAX_CAREFUL_ITERATIONS: u32 = 60;

/// Sizes of programs whose solvers are kept. The levels of one problem have a handful, and those of a controller whose limits come
/// and go some more.
const MAX_KEPT_SOLVERS: usize = 24;

/// Clarabel, with solvers that are kept by the size of their program and overwritten.
///
/// Nothing of one program is left for the next: without scaling, which remembers, the answers are those of new solvers, to
/// the last bit. Careful solvers are new each time.
#[derive(Default)]
pub struct Clarabel {
    solvers: Vec<((usize, usize), DefaultSolver<f64>)>,
}

impl Clarabel {
    /// Solves a program.
    pub fn solve(&mut self, program: &QuadraticProgram, effort: Effort) -> Result<QpAnswer, Unsolved> {
        let refused = Unsolved { iterations: 0 };
        if effort == Effort::Careful {
            let mut solver = new_solver(program, effort).ok_or(refused)?;
            return run(&mut solver, program.equations);
        }
        let place = self.prepare(program).ok_or(refused)?;
        let answer = run(&mut self.solvers[place].1, program.equations);
        if answer.is_err() {
            // After numerical trouble a solver may never recover.
            self.solvers.swap_remove(place);
        }
        answer
    }

    /// Returns the place of a solver that holds the program; `None` for numbers that Clarabel refuses.
    fn prepare(&mut self, program: &QuadraticProgram) -> Option<usize> {
        let size = (program.unknowns, program.b.len());
        if let Some(place) = self.solvers.iter().position(|(known, _)| *known == size) {
            if self.solvers[place].1.update_data(&program.P, &program.q, &program.A, &program.b).is_ok() {
                return Some(place);
            }
            self.solvers.swap_remove(place);
        }
        let solver = new_solver(program, Effort::Quick)?;
        if self.solvers.len() >= MAX_KEPT_SOLVERS {
            self.solvers.clear();
        }
        self.solvers.push((size, solver));
        Some(self.solvers.len() - 1)
    }
}

/// Returns excess ≥ 0 of each demand a·x ≤ b with the least Σ excess², and the multipliers, which are equal to it. `rows`: the
/// demands, one after the other, n entries each.
pub fn least_excess(rows: &[f64], bounds: &[f64], n: usize) -> Result<Vec<f64>, Unsolved> {
    let m = bounds.len();
    // v = (x, excess); P and A have an entry in each column of the excess alone.
    let P_columns = (0..=n + m).map(|j: usize| j.saturating_sub(n)).collect();
    let P = CscMatrix::new(n + m, n + m, P_columns, (n..n + m).collect(), vec![1.0; m]);
    let A_columns = (0..=n + m).map(|j| if j <= n { j * m } else { n * m + (j - n) }).collect();
    let A_rows = (0..n).flat_map(|_| 0..m).chain(0..m).collect();
    let entries = (0..n).flat_map(|j| (0..m).map(move |i| rows[i * n + j])).chain(std::iter::repeat_n(-1.0, m));
    let A = CscMatrix::new(m, n + m, A_columns, A_rows, entries.collect());
    let q = vec![0.0; n + m];
    let settings = DefaultSettings {
        static_regularization_constant: DEMAND_REGULARIZATION,
        tol_gap_abs: DEMAND_TOLERANCE,
        tol_gap_rel: DEMAND_TOLERANCE,
        tol_feas: DEMAND_TOLERANCE,
        ..settings(Effort::Careful)
    };
    let solver = DefaultSolver::new(&P, &q, &A, bounds, &[NonnegativeConeT(m)], settings);
    let mut solver = solver.map_err(|_| Unsolved { iterations: 0 })?;
    run(&mut solver, 0).map(|answer| answer.multipliers)
}

fn run(solver: &mut DefaultSolver<f64>, equations: usize) -> Result<QpAnswer, Unsolved> {
    solver.solve();
    let found = &solver.solution;
    let is_solved = matches!(
        found.status,
        SolverStatus::Solved
            | SolverStatus::AlmostSolved
            | SolverStatus::InsufficientProgress
            | SolverStatus::MaxIterations
    );
    let is_finite = found.x.iter().chain(&found.z).chain(&found.s).all(|entry| entry.is_finite());
    if !is_solved || !is_finite {
        return Err(Unsolved { iterations: found.iterations });
    }
    Ok(QpAnswer {
        v: found.x.clone(),
        multipliers: found.z[equations..].to_vec(),
        slacks: found.s[equations..].to_vec(),
        iterations: found.iterations,
    })
}

fn new_solver(program: &QuadraticProgram, effort: Effort) -> Option<DefaultSolver<f64>> {
    let (n, m) = (program.unknowns, program.b.len());
    let triangle = (0..=n).map(|j| j * (j + 1) / 2).collect();
    let P = CscMatrix::new(n, n, triangle, (0..n).flat_map(|j| 0..=j).collect(), program.P.clone());
    let columns = (0..=n).map(|j| j * m).collect();
    let A = CscMatrix::new(m, n, columns, (0..n).flat_map(|_| 0..m).collect(), program.A.clone());
    let mut cones = Vec::new();
    if program.equations > 0 {
        cones.push(ZeroConeT(program.equations));
    }
    if m > program.equations {
        cones.push(NonnegativeConeT(m - program.equations));
    }
    DefaultSolver::new(&P, &program.q, &A, &program.b, &cones, settings(effort)).ok()
}

/// `docs/performance.md` has the times of other settings.
fn settings(effort: Effort) -> DefaultSettings<f64> {
    let is_careful = effort == Effort::Careful;
    let tolerance = if is_careful { CAREFUL_TOLERANCE } else { TOLERANCE };
    DefaultSettings {
        verbose: false,
        presolve_enable: false,
        equilibrate_enable: is_careful,
        iterative_refinement_enable: is_careful,
        max_iter: if is_careful { MAX_CAREFUL_ITERATIONS } else { MAX_ITERATIONS },
        tol_gap_abs: tolerance,
        tol_gap_rel: tolerance,
        tol_feas: tolerance,
        ..DefaultSettings::default()
    }
}
