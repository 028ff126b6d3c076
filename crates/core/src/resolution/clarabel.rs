//! The last resort of the hierarchical solver: a working set from Clarabel, an interior-point solver, level by level.
//!
//! A level minimises its squared slack over what the levels before left open, x + Z z, with all bounds as inequalities. Then
//! its rows are kept: Z loses the directions that change them, and bounds with a multiplier become fixed. An interior-point
//! solver is accurate to some 1e-7, so its answer is worth its working set. The hierarchical solver evaluates that set, and
//! corrects it where the optimality conditions say that it is wrong.
#![allow(non_snake_case)]

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus};

use revprio_problem::Side;

use super::level::{Hierarchy, Solution, WorkingSet, refill};
use super::solver::HierarchicalSolver;

/// A cap far above the 5 to 15 iterations that levels take: a failing problem would go on.
const MAX_ITERATIONS: u32 = 40;

/// Clarabel reaches this tolerance on every level in reduced form.
const TOLERANCE: f64 = 1e-10;

/// Problem sizes whose solvers are kept; the levels of one problem have a handful.
const MAX_KEPT_SOLVERS: usize = 16;

/// Multipliers and slacks below this are the solver's inaccuracy. Problems are scaled to size one.
const SIGNIFICANT: f64 = 1e-7;

/// A level that moves by less than this fraction is decided by the levels above.
const DECIDED: f64 = 1e-10;

/// The levels of a problem through a quadratic-programming solver.
#[derive(Default)]
pub struct ClarabelLevels<S = Clarabel> {
    solver: S,
    program: QuadraticProgram,
    answer: QpAnswer,
    /// The rows that solved levels keep, with fixed unknowns as pinned ones.
    kept: Hierarchy,
    set: WorkingSet,
    x: Vec<f64>,
    /// Z, column by column.
    null_space: Vec<f64>,
    /// The bound that each constraint of the program stands for.
    bounds: Vec<Bound>,
}

/// The bound that a constraint of the program stands for.
#[derive(Debug, Clone, Copy)]
enum Bound {
    Unknown(usize, Side),
    Row(usize, Side),
}

impl<S: QpSolver> ClarabelLevels<S> {
    /// Solves a problem level by level, then evaluates the working set that was found with `exact`.
    pub fn solve(&mut self, problem: &Hierarchy, exact: &mut HierarchicalSolver, solution: &mut Solution) {
        self.set.clear(problem.unknowns, problem.row_count());
        if has_bounds(problem) {
            self.find_working_set(problem, exact);
        }
        exact.solve(problem, Some(&self.set), solution);
    }

    fn find_working_set(&mut self, problem: &Hierarchy, exact: &mut HierarchicalSolver) {
        self.start(problem);
        for level in 0..=problem.level_ends.len() {
            let kept = exact.of_width(problem.unknowns);
            kept.solve_pinned(&self.kept);
            kept.write_null_space(&mut self.null_space);
            if self.null_space.is_empty() {
                break;
            }
            self.program.write(problem, level, &self.x, &self.null_space, &self.set, &mut self.bounds);
            if !self.program.is_decided {
                self.solver.solve(&self.program, &mut self.answer);
                if !self.answer.is_usable() {
                    return;
                }
                self.move_and_activate(problem);
            }
            if level < problem.level_ends.len() {
                self.keep(problem, level);
            }
        }
    }

    /// Starts at the slowest point of the box with nothing kept but what is pinned.
    fn start(&mut self, problem: &Hierarchy) {
        let Self { kept, x, .. } = self;
        let bounds = || problem.lower.iter().zip(&problem.upper);
        refill(x, bounds().map(|(&lower, &upper)| 0.0_f64.max(lower).min(upper)));
        kept.clear(x);
        for (j, (&lower, &upper)) in bounds().enumerate().filter(|(_, (lower, upper))| lower >= upper) {
            (kept.lower[j], kept.upper[j]) = (lower, upper);
        }
    }

    /// Moves to the answer; bounds whose multipliers exceed their slacks become active.
    fn move_and_activate(&mut self, problem: &Hierarchy) {
        let Self { x, set, kept, .. } = self;
        let n = problem.unknowns;
        for (z, column) in self.answer.x.iter().zip(self.null_space.chunks_exact(n)) {
            let z = z * self.program.size;
            x.iter_mut().zip(column).for_each(|(x, entry)| *x += z * entry);
        }
        for (j, x) in x.iter_mut().enumerate() {
            *x = x.max(problem.lower[j]).min(problem.upper[j]);
        }
        let mut strongest = 0.0;
        for (i, bound) in self.bounds.iter().enumerate() {
            let (multiplier, slack) = (self.answer.multipliers[i], self.answer.slacks[i]);
            // Two bounds nearer to each other than the solver's accuracy are both active: the stronger one counts.
            let is_second = i > 0 && bound.is_other_side_of(self.bounds[i - 1]);
            let beats = !is_second || multiplier > strongest;
            strongest = multiplier;
            if multiplier > slack && multiplier > SIGNIFICANT && beats {
                match *bound {
                    Bound::Unknown(j, side) => {
                        set.unknowns[j] = Some(side);
                        x[j] = if side == Side::Lower { problem.lower[j] } else { problem.upper[j] };
                        (kept.lower[j], kept.upper[j]) = (x[j], x[j]);
                    }
                    Bound::Row(row, side) => set.rows[row] = Some(side),
                }
            }
        }
    }

    /// Keeps the rows that a solved level decides: equations, and inequality rows that are active.
    fn keep(&mut self, problem: &Hierarchy, level: usize) {
        let Self { kept, x, set, .. } = self;
        kept.level_ends.clear();
        kept.rows.clear();
        kept.row_lower.clear();
        kept.row_upper.clear();
        kept.reference.clone_from(x);
        for level in 0..=level {
            for row in problem.level_start(level)..problem.level_ends[level] {
                if problem.is_equation(row) || set.rows[row].is_some() {
                    let value = problem.row(row).iter().zip(x.iter()).map(|(a, x)| a * x).sum();
                    kept.push_row(problem.row(row).iter().copied(), value, value);
                }
            }
            kept.end_level();
        }
    }
}

impl Bound {
    fn is_other_side_of(self, other: Self) -> bool {
        match (self, other) {
            (Self::Unknown(a, _), Self::Unknown(b, _)) | (Self::Row(a, _), Self::Row(b, _)) => a == b,
            _ => false,
        }
    }
}

/// Returns whether a problem has bounds that can become active.
fn has_bounds(problem: &Hierarchy) -> bool {
    let mut bounds = problem.lower.iter().zip(&problem.upper);
    bounds.any(|(lower, upper)| lower < upper && (lower.is_finite() || upper.is_finite()))
        || (0..problem.row_count()).any(|row| !problem.is_equation(row))
}

/// ½ vᵀP v + qᵀv subject to A v + s = b, s ≥ 0 with v = (z, slacks of the level's own inequality rows).
#[derive(Debug, Default)]
pub struct QuadraticProgram {
    unknowns: usize,
    /// Upper triangle, column by column.
    P: Vec<f64>,
    q: Vec<f64>,
    /// Column by column.
    A: Vec<f64>,
    b: Vec<f64>,
    /// Size of z in the units of x.
    size: f64,
    /// Whether nothing that is open changes the level.
    is_decided: bool,
    /// The level's equations over z: C z = d.
    C: Vec<f64>,
    d: Vec<f64>,
    /// The constraints G v ≤ b, row by row.
    G: Vec<f64>,
}

impl QuadraticProgram {
    /// Writes level `level` of the problem over x + Z z; the last objective min ‖x − ζ‖² follows the last level.
    fn write(
        &mut self,
        problem: &Hierarchy,
        level: usize,
        x: &[f64],
        null_space: &[f64],
        set: &WorkingSet,
        bounds: &mut Vec<Bound>,
    ) {
        let n = problem.unknowns;
        let open = null_space.len() / n;
        let is_last = level == problem.level_ends.len();
        let rows = if is_last { 0..0 } else { problem.level_start(level)..problem.level_ends[level] };
        let own = || rows.clone().filter(|&row| !problem.is_equation(row));
        self.unknowns = open + own().count();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        self.C.clear();
        self.d.clear();
        let mut norm_square = 0.0;
        for row in rows.clone() {
            let a = problem.row(row);
            norm_square += dot(a, a);
            if problem.is_equation(row) {
                self.C.extend(null_space.chunks_exact(n).map(|column| dot(a, column)));
                self.d.push(problem.row_lower[row] - dot(a, x));
            }
        }
        if is_last {
            norm_square = 1.0;
            for j in 0..n {
                self.C.extend(null_space.chunks_exact(n).map(|column| column[j]));
                self.d.push(problem.reference[j] - x[j]);
            }
        }
        let norm = norm_square.sqrt();
        let c_square = dot(&self.C, &self.C);
        self.is_decided = own().next().is_none() && c_square <= (DECIDED * norm).powi(2);
        let speed = dot(&self.d, &self.d).sqrt() / norm;
        let own_speed = own().map(|row| missing(problem, row, dot(problem.row(row), x))).fold(0.0, f64::max) / norm;
        let size = speed.max(own_speed);
        self.size = if size.is_normal() { size } else { 1.0 };
        self.write_constraints(problem, level, x, null_space, set, bounds);
        self.write_objective(open, norm);
    }

    /// Writes the bounds of unknowns that move, of the rows of higher levels, and of the level's own rows with their slacks.
    fn write_constraints(
        &mut self,
        problem: &Hierarchy,
        level: usize,
        x: &[f64],
        null_space: &[f64],
        set: &WorkingSet,
        bounds: &mut Vec<Bound>,
    ) {
        let Self { G, b, size, unknowns, .. } = self;
        let (n, unknowns) = (problem.unknowns, *unknowns);
        G.clear();
        b.clear();
        bounds.clear();
        let mut push = |bound: Bound, side: Side, slack: Option<usize>, room: f64, a: &dyn Fn(&[f64]) -> f64| {
            if room.is_finite() {
                let start = G.len();
                G.extend(null_space.chunks_exact(n).map(|column| side.sign() * a(column)));
                G.resize(start + unknowns, 0.0);
                if let Some(slack) = slack {
                    G[start + slack] = -1.0;
                }
                b.push(if slack.is_some() { room } else { room.max(0.0) } / *size);
                bounds.push(bound);
            }
        };
        for j in (0..n).filter(|&j| set.unknowns[j].is_none() && problem.lower[j] < problem.upper[j]) {
            push(Bound::Unknown(j, Side::Lower), Side::Lower, None, x[j] - problem.lower[j], &|column| column[j]);
            push(Bound::Unknown(j, Side::Upper), Side::Upper, None, problem.upper[j] - x[j], &|column| column[j]);
        }
        let first_own =
            if level == problem.level_ends.len() { problem.row_count() } else { problem.level_start(level) };
        let end = problem.level_ends.get(level).copied().unwrap_or(problem.row_count());
        let mut slack = null_space.len() / n;
        for row in (0..end).filter(|&row| !problem.is_equation(row) && set.rows[row].is_none()) {
            let a = |column: &[f64]| problem.row(row).iter().zip(column).map(|(a, z)| a * z).sum::<f64>();
            let value = a(x);
            let own = (row >= first_own).then_some(slack);
            push(Bound::Row(row, Side::Lower), Side::Lower, own, value - problem.row_lower[row], &a);
            push(Bound::Row(row, Side::Upper), Side::Upper, own, problem.row_upper[row] - value, &a);
            slack += usize::from(own.is_some());
        }
    }

    /// Writes ½ ‖C z − d‖² + ½ ‖slacks‖² in units in which C has size one, and the constraints column by column.
    fn write_objective(&mut self, open: usize, norm: f64) {
        let Self { unknowns, P, q, A, C, d, G, b, size, .. } = self;
        let unit = 1.0 / norm;
        let scale = if unit.is_normal() { unit } else { 1.0 };
        P.clear();
        q.clear();
        for j in 0..*unknowns {
            for i in 0..=j {
                let product = |row: &[f64]| (row[i] * scale) * (row[j] * scale);
                let slack = if i == j { scale * scale } else { 0.0 };
                P.push(if j < open { C.chunks_exact(open).map(product).sum() } else { slack });
            }
            let linear = |(row, d): (&[f64], &f64)| (row[j] * scale) * (d * scale / *size);
            q.push(if j < open { -C.chunks_exact(open).zip(&*d).map(linear).sum::<f64>() } else { 0.0 });
        }
        let (unknowns, G) = (*unknowns, &*G);
        refill(A, (0..unknowns).flat_map(|j| (0..b.len()).map(move |i| G[i * unknowns + j])));
    }
}

/// Returns by how much a value misses the bounds of a row.
fn missing(problem: &Hierarchy, row: usize, value: f64) -> f64 {
    (problem.row_lower[row] - value).max(value - problem.row_upper[row]).max(0.0)
}

/// The answer to a quadratic program.
#[derive(Debug, Default)]
pub struct QpAnswer {
    /// Whether the solver says that it is solved.
    pub is_solved: bool,
    /// v.
    pub x: Vec<f64>,
    /// Multipliers of the constraints, ≥ 0.
    pub multipliers: Vec<f64>,
    /// Slacks of the constraints, ≥ 0.
    pub slacks: Vec<f64>,
    /// Iterations.
    pub iterations: u32,
}

impl QpAnswer {
    /// Returns whether the answer can be used.
    fn is_usable(&self) -> bool {
        self.is_solved && self.x.iter().chain(&self.multipliers).chain(&self.slacks).all(|entry| entry.is_finite())
    }
}

/// A solver of quadratic programs.
pub trait QpSolver {
    /// Solves a program.
    fn solve(&mut self, program: &QuadraticProgram, answer: &mut QpAnswer);
}

/// Clarabel with solvers that are kept by the size of their problem (unknowns, constraints) and overwritten.
///
/// Their structure depends on sizes alone, and nothing of one problem is left for the next: without equilibration, which
/// remembers, the answers are those of fresh solvers, to the last bit.
#[derive(Default)]
pub struct Clarabel {
    solvers: Vec<((usize, usize), DefaultSolver<f64>)>,
}

impl QpSolver for Clarabel {
    fn solve(&mut self, program: &QuadraticProgram, answer: &mut QpAnswer) {
        answer.is_solved = false;
        answer.iterations = 0;
        let Some(place) = self.prepare(program) else { return };
        let solver = &mut self.solvers[place].1;
        solver.solve();
        let solution = &solver.solution;
        answer.is_solved = matches!(solution.status, SolverStatus::Solved | SolverStatus::AlmostSolved);
        answer.iterations = solution.iterations;
        answer.x.clone_from(&solution.x);
        answer.multipliers.clone_from(&solution.z);
        answer.slacks.clone_from(&solution.s);
        if !answer.is_usable() {
            // After numerical trouble a solver may never recover.
            self.solvers.swap_remove(place);
        }
    }
}

impl Clarabel {
    /// Returns the place of a solver that holds the program; `None` for numbers that Clarabel refuses.
    fn prepare(&mut self, program: &QuadraticProgram) -> Option<usize> {
        let size = (program.unknowns, program.b.len());
        if let Some(place) = self.solvers.iter().position(|(known, _)| *known == size) {
            if self.solvers[place].1.update_data(&program.P, &program.q, &program.A, &program.b).is_ok() {
                return Some(place);
            }
            self.solvers.swap_remove(place);
        }
        let solver = new_solver(program)?;
        if self.solvers.len() >= MAX_KEPT_SOLVERS {
            self.solvers.clear();
        }
        self.solvers.push((size, solver));
        Some(self.solvers.len() - 1)
    }
}

fn new_solver(program: &QuadraticProgram) -> Option<DefaultSolver<f64>> {
    let (n, m) = (program.unknowns, program.b.len());
    let triangle = (0..=n).map(|j| j * (j + 1) / 2).collect();
    let P = CscMatrix::new(n, n, triangle, (0..n).flat_map(|j| 0..=j).collect(), program.P.clone());
    let columns = (0..=n).map(|j| j * m).collect();
    let A = CscMatrix::new(m, n, columns, (0..n).flat_map(|_| 0..m).collect(), program.A.clone());
    let cones = if m == 0 { vec![] } else { vec![NonnegativeConeT(m)] };
    DefaultSolver::new(&P, &program.q, &A, &program.b, &cones, settings()).ok()
}

/// `docs/performance.md` has the times of other settings.
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
