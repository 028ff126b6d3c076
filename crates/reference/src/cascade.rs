//! The cascade of quadratic programs: one level after the other by Clarabel.
//!
//! A level minimises its squared slack over what the levels above left open, x + Z z, with all bounds as inequalities. Then
//! its rows are kept: Z loses the directions that change them, and bounds with a multiplier hold their unknowns.

use revprio_problem::{LevelReport, Matrix, Side, Vector};

use crate::certified::{Known, level_multipliers};
use crate::clarabel::Clarabel;
use crate::hierarchy::{Hierarchy, Level, Solution};
use crate::level_program::{Bounded, Decided, LevelProgram};
use crate::polish::{CERTIFIED, LevelPoint};
use crate::program::{Effort, Unsolved};
use crate::svd::{PROJECTION_ERROR, RANK_TOLERANCE, Svd, UNCERTAIN_RANK};

/// Relative residual of a level that is solved to rounding. Clarabel tries harder for others.
const EXACT: f64 = 1e-12;

/// Size of a level's program, relative to what the level misses, where its first answer is not sure.
const CLOSER: f64 = 1e-4;

/// Multipliers above this hold their bound for all lower levels, in units in which the level has size one. Smaller ones are
/// left to the kept rows, which imply the same bound: a bound that is held by mistake would change the answer.
const SIGNIFICANT: f64 = 1e-7;

/// Velocities below this fraction of what a level asks for are rest, if the step of this level leads to them.
const REST: f64 = 1e-15;

/// Multipliers above this are more than rounding.
const NEGLIGIBLE: f64 = 1e-12;

/// Clarabel with its memory.
#[derive(Default)]
pub struct Cascade {
    clarabel: Clarabel,
    stop: Option<Box<dyn Fn() -> bool + Send>>,
}

/// The way through the levels of one problem.
struct LevelRun<'a> {
    problem: &'a Hierarchy,
    solution: Solution,
    basis: Matrix,
    fixed: Vec<bool>,
    kept: Vec<Vec<bool>>,
    /// Smallest relative singular value that is kept.
    weakest: f64,
    wants_multipliers: bool,
    /// A_k x as the program of the level gives it; empty if the level was not solved.
    promised: Vec<f64>,
    /// Index and a·x of the rows that each level keeps, after its solution.
    values: Vec<Vec<(usize, f64)>>,
}

/// The multipliers of one level, at the bounds that hold it back: positive at upper, negative at lower bounds.
struct Forces {
    unknowns: Vec<f64>,
    rows: Vec<Vec<f64>>,
}

impl Forces {
    fn new(problem: &Hierarchy) -> Self {
        let rows = problem.levels.iter().map(|level| vec![0.0; level.rows.nrows()]).collect();
        Self { unknowns: vec![0.0; problem.unknowns()], rows }
    }
}

impl Cascade {
    /// Returns a cascade whose levels fail as soon as `stop` returns true.
    pub fn until(stop: impl Fn() -> bool + Send + 'static) -> Self {
        Self { stop: Some(Box::new(stop)), ..Self::default() }
    }

    /// Returns whether nobody waits for the answer any more.
    pub fn is_stopped(&self) -> bool {
        self.stop.as_ref().is_some_and(|stop| stop())
    }

    /// Solves a problem; `wants_multipliers`: with the multipliers of all levels.
    pub fn solve(&mut self, problem: &Hierarchy, wants_multipliers: bool) -> Solution {
        let mut run = LevelRun::new(problem, wants_multipliers);
        for level in 0..=problem.levels.len() {
            let (fixed, kept) = (run.fixed.clone(), run.kept.clone());
            let mut forces = Forces::new(problem);
            run.promised.clear();
            if run.solution.failures == 0 {
                self.solve_level(&mut run, level, &mut forces);
            }
            let Forces { unknowns, rows } = &forces;
            run.write_multipliers(level, &Known { unknowns, rows, fixed: &fixed, kept: &kept });
            run.keep(level);
        }
        run.note_drift();
        run.solution
    }

    fn solve_level(&mut self, run: &mut LevelRun, level: usize, forces: &mut Forces) {
        let program = run.program(level, 1.0);
        if program.is_decided || run.basis.ncols() == 0 {
            run.list_violated(level);
            let underflows = run.problem.levels.get(level).is_some_and(Level::underflows);
            let residual = if underflows { f64::INFINITY } else { 0.0 };
            run.solution.reports.push(LevelReport { residual, ..LevelReport::default() });
            return;
        }
        match self.solve_program(&program) {
            Ok((point, report)) if point.is_sure() => {
                run.solution.reports.push(report);
                run.advance(level, &program, &point, forces);
            }
            Ok((point, report)) => self.look_closer(run, level, (&program, &point, report), forces),
            Err(report) => {
                run.solution.failures += 1;
                run.solution.is_unsure = true;
                run.solution.reports.push(report);
            }
        }
    }

    /// Poses a level again from the answer that is not sure, in smaller units, so that Clarabel sees small distances from bounds.
    fn look_closer(
        &mut self,
        run: &mut LevelRun,
        level: usize,
        (program, point, report): (&LevelProgram, &LevelPoint, LevelReport),
        forces: &mut Forces,
    ) {
        let start = run.solution.x.clone();
        run.step(program, point);
        let closer = run.program(level, CLOSER);
        let found = self.solve_program(&closer);
        let tried = found.as_ref().map_or_else(|failed| failed.iterations, |(_, report)| report.iterations);
        let report = LevelReport { iterations: report.iterations + tried, ..report };
        match found {
            Ok((better, LevelReport { residual, .. })) if better.residual <= point.residual => {
                run.solution.is_unsure |= !better.is_sure();
                run.solution.reports.push(LevelReport { residual, ..report });
                run.advance(level, &closer, &better, forces);
            }
            _ => {
                run.solution.is_unsure = true;
                run.solution.reports.push(report);
                run.solution.x = start;
                run.advance(level, program, point, forces);
            }
        }
    }

    /// Returns the better one of Clarabel's answer and its polish. Clarabel tries harder where neither is certified.
    fn solve_program(&mut self, program: &LevelProgram) -> Result<(LevelPoint, LevelReport), LevelReport> {
        let mut best: Option<(LevelPoint, LevelReport)> = None;
        let (mut iterations, mut before) = (0, None);
        for effort in [Effort::Quick, Effort::Careful] {
            if self.is_stopped() {
                break;
            }
            let posed = program.posed(effort, before.as_ref());
            match self.clarabel.solve(&program.quadratic_program(effort, &posed), effort) {
                Ok(answer) => {
                    let answer = program.complete(answer, &posed);
                    iterations += answer.iterations;
                    let z = Vector::from_row_slice(&answer.v[..program.C.ncols()]);
                    let clarabel_residual = program.residual(&z, &answer.multipliers);
                    // Where a constraint that was left out is broken, Clarabel has not found the active set.
                    let is_found = answer.slacks.iter().all(|slack| *slack >= 0.0);
                    let polished = is_found.then(|| LevelPoint::polished(program, &answer, before.as_ref()));
                    let own = || LevelPoint::of_clarabel(program, &answer, clarabel_residual);
                    let point = polished.filter(|point| point.residual <= clarabel_residual).unwrap_or_else(own);
                    if best.as_ref().is_none_or(|(other, _)| point.residual < other.residual) {
                        let report = LevelReport { iterations, clarabel_residual, residual: point.residual };
                        best = Some((point, report));
                    }
                    before = Some(answer);
                }
                Err(Unsolved { iterations: tried }) => iterations += tried,
            }
            if best.as_ref().is_some_and(|(point, _)| point.residual <= EXACT) {
                break;
            }
        }
        let failed = LevelReport { iterations, clarabel_residual: f64::INFINITY, residual: f64::INFINITY };
        best.map(|(point, report)| (point, LevelReport { iterations, ..report })).ok_or(failed)
    }
}

impl<'a> LevelRun<'a> {
    /// Starts at the slowest point of the box with nothing kept but what is pinned.
    fn new(problem: &'a Hierarchy, wants_multipliers: bool) -> Self {
        let n = problem.unknowns();
        let rows = |level: &Level| level.rows.nrows();
        let fixed: Vec<bool> = (0..n).map(|j| problem.is_pinned(j)).collect();
        let open: Vec<usize> = (0..n).filter(|&j| !fixed[j]).collect();
        let basis = Matrix::identity(n, n).select_columns(&open);
        let solution = Solution::new(problem, problem.clamp(&Vector::zeros(n)));
        let wants_multipliers = wants_multipliers || open.len() < n;
        let kept = problem.levels.iter().map(|level| vec![false; rows(level)]).collect();
        Self {
            problem,
            solution,
            basis,
            fixed,
            kept,
            weakest: 1.0,
            wants_multipliers,
            promised: Vec::new(),
            values: Vec::new(),
        }
    }

    /// Poses a level from x on.
    fn program(&self, level: usize, zoom: f64) -> LevelProgram {
        let decided = Decided { x: &self.solution.x, basis: &self.basis, fixed: &self.fixed, kept: &self.kept };
        LevelProgram::new(self.problem, level, &decided, zoom)
    }

    /// Moves to the point of a level.
    fn step(&mut self, program: &LevelProgram, point: &LevelPoint) {
        let step = &self.basis * &point.z * program.size;
        let rest = REST * step.norm().max(program.scale * program.size);
        let moved = |x: f64, step: f64| if (x + step).abs() <= rest.min(2.0 * step.abs()) { 0.0 } else { x + step };
        self.solution.x = self.problem.clamp(&self.solution.x.zip_map(&step, moved));
    }

    /// Moves to the point of a level; bounds with multipliers become active.
    fn advance(&mut self, level: usize, program: &LevelProgram, point: &LevelPoint, forces: &mut Forces) {
        if let Some(own) = self.problem.levels.get(level) {
            // As the program promises it: x is rounded, and moved to bounds that it misses by rounding.
            let reached = &self.solution.x + &self.basis * &point.z * program.size;
            let missing = (&program.d - &program.C * &point.z) * (program.size * own.rows.norm());
            let mut equations = missing.iter();
            let mut value = |row: usize| {
                let is_equation = own.is_equation(row);
                if is_equation { own.lower[row] - equations.next().unwrap_or(&0.0) } else { own.value(row, &reached) }
            };
            self.promised = (0..own.rows.nrows()).map(&mut value).collect();
        }
        self.step(program, point);
        self.solution.error += point.error * program.scale * program.size;
        let Solution { x, multipliers, row_multipliers, active, active_rows, .. } = &mut self.solution;
        for (constraint, &multiplier) in program.constraints.iter().zip(&point.multipliers) {
            if multiplier <= NEGLIGIBLE * program.scale {
                continue;
            }
            let (side, signed) = (constraint.side, constraint.side.sign() * multiplier * constraint.unit);
            let holds = multiplier * program.zoom > SIGNIFICANT;
            match constraint.bounded {
                Bounded::Unknown(j) => {
                    forces.unknowns[j] += signed;
                    set_first(&mut multipliers[j], signed);
                    active[j] = Some(side);
                    if holds {
                        self.fixed[j] = true;
                        x[j] = self.problem.bound(j, side);
                    }
                }
                Bounded::Higher { level, row } => {
                    forces.rows[level][row] += signed;
                    set_first(&mut row_multipliers[level][row], signed);
                    active_rows[level][row] = Some(side);
                    self.kept[level][row] |= holds;
                }
                Bounded::Own(row) => {
                    set_first(&mut row_multipliers[level][row], signed);
                    active_rows[level][row] = Some(side);
                }
            }
        }
    }

    /// Adds what lower levels have changed of the rows that a level keeps to the residual of the level, relative to the speed that
    /// the problem asks for.
    fn note_drift(&mut self) {
        let speed = self.problem.speed().max(self.solution.x.norm());
        let Solution { x, reports, is_unsure, .. } = &mut self.solution;
        for ((level, kept), report) in self.problem.levels.iter().zip(&self.values).zip(reports) {
            let change = |&(row, value): &(usize, f64)| (level.value(row, x) - value).abs();
            let change = kept.iter().map(change).fold(0.0, f64::max);
            let drift = change / (level.rows.norm() * speed);
            if change > 0.0 && drift.is_finite() {
                report.residual = report.residual.max(drift);
                *is_unsure |= drift > CERTIFIED;
            }
        }
    }

    /// Lists the inequality rows that a level violates although nothing is left to move.
    fn list_violated(&mut self, level: usize) {
        let Solution { x, row_multipliers, active_rows, .. } = &mut self.solution;
        let Some(own) = self.problem.levels.get(level) else { return };
        for row in (0..own.rows.nrows()).filter(|&row| !own.is_equation(row)) {
            let value = own.value(row, x);
            let missing = own.missing(row, value);
            if missing.abs() > NEGLIGIBLE * (value.abs() + own.rows.row(row).norm() * x.norm()) {
                row_multipliers[level][row] = -missing;
                active_rows[level][row] = Some(if missing > 0.0 { Side::Lower } else { Side::Upper });
            }
        }
    }

    /// Keeps what a solved level decides: its equations, its violated rows, and the bounds that hold it back.
    fn keep(&mut self, level: usize) {
        let n = self.problem.unknowns();
        let held: Vec<usize> = (0..n).filter(|&j| self.fixed[j] && self.basis.row(j).amax() > 0.0).collect();
        self.remove(&self.basis.select_rows(&held), 1.0);
        let Some(own) = self.problem.levels.get(level) else { return };
        for row in 0..own.rows.nrows() {
            let is_violated = || own.missing(row, own.value(row, &self.solution.x)).abs() > 0.0;
            let has_multiplier = self.solution.row_multipliers[level][row] != 0.0;
            self.kept[level][row] |= own.is_equation(row) || (has_multiplier && is_violated());
        }
        let kept = (0..own.rows.nrows()).filter(|&row| self.kept[level][row]);
        self.values.push(
            kept.map(|row| (row, self.promised.get(row).copied().unwrap_or_else(|| own.value(row, &self.solution.x))))
                .collect(),
        );
        for (index, level_rows) in self.problem.levels[..=level].iter().enumerate() {
            let rows = 0..level_rows.rows.nrows();
            // Equations of higher levels are kept already.
            let is_new = |&row: &usize| self.kept[index][row] && (index == level || !level_rows.is_equation(row));
            let rows: Vec<usize> = rows.filter(is_new).collect();
            if !rows.is_empty() {
                let along = level_rows.rows.select_rows(&rows) * &self.basis;
                self.remove(&along, level_rows.rows.norm());
            }
        }
    }

    /// Removes the directions that change rows (over Z) from Z; `norm`: size of the rows.
    fn remove(&mut self, rows: &Matrix, norm: f64) {
        if rows.nrows() == 0 || self.basis.ncols() == 0 {
            return;
        }
        let svd = Svd::new(rows);
        let rank = svd.rank(RANK_TOLERANCE.max(PROJECTION_ERROR / self.weakest) * norm);
        let relative = |sigma: &f64| sigma / norm;
        let open = rows.nrows().min(rows.ncols());
        self.solution.rank_uncertain |=
            svd.singular_values()[..open].iter().map(relative).any(|sigma| UNCERTAIN_RANK.contains(&sigma));
        if rank > 0 {
            self.weakest = self.weakest.min(svd.singular_values()[rank - 1] / norm);
        }
        self.basis = &self.basis * svd.null_space(rank);
    }

    /// Computes the multipliers of a level at x, if they are wanted or hold an unknown at a bound, and those of pinned unknowns.
    fn write_multipliers(&mut self, level: usize, known: &Known) {
        if !self.wants_multipliers && known.unknowns.iter().all(|h| *h == 0.0) {
            return;
        }
        let found = level_multipliers(self.problem, level, &self.solution.x, known);
        if let Some(found) = &found {
            let size: f64 = found.unknowns.iter().map(|h| h.abs()).fold(0.0, f64::max);
            let multipliers = self.solution.multipliers.iter_mut().zip(known.unknowns);
            for (j, ((multiplier, &of_level), &h)) in multipliers.zip(&found.unknowns).enumerate() {
                if self.problem.is_pinned(j) && h.abs() > NEGLIGIBLE * size {
                    set_first(multiplier, h);
                } else if *multiplier == of_level && h * of_level > 0.0 {
                    // That of the program has its rounding.
                    *multiplier = h;
                }
            }
        }
        self.solution.certificate.push(found);
    }
}

fn set_first(multiplier: &mut f64, value: f64) {
    if *multiplier == 0.0 {
        *multiplier = value;
    }
}
