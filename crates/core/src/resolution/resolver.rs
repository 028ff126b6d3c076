//! The one entry: a problem in, joint velocities and their explanation out.

use super::answer::Resolution;
use super::closed_form::closed_form;
use super::engine::Engine;
use super::level::ActiveSet;
use super::plan_run::PlanRun;
use super::problem::{Problem, ProblemError, Solver};
use super::singularity::Singularities;
use crate::linalg::row_times;
use crate::task::Task;

/// Solves the problem; `guess` are the active limits of the period before (empty: none).
///
/// A numerical failure is not an error but an answer with a status: the control loop needs a safe command either way.
pub fn resolve(problem: &Problem, guess: &[ActiveSet]) -> Result<Resolution, ProblemError> {
    let mut answer = Resolution::default();
    Resolver::default().resolve(problem, guess, &mut answer)?;
    Ok(answer)
}

/// The workspace of [`resolve`], allocated once and overwritten by each problem: the same answers, to the last bit.
#[derive(Default)]
pub struct Resolver {
    singularities: Singularities,
    engine: Engine,
    zeta: Vec<f64>,
    run: PlanRun,
}

impl Resolver {
    /// Solves the problem as [`resolve`] does and overwrites `answer`.
    pub fn resolve(
        &mut self,
        problem: &Problem,
        guess: &[ActiveSet],
        answer: &mut Resolution,
    ) -> Result<(), ProblemError> {
        problem.check()?;
        let Self { singularities, engine, zeta, run } = self;
        zeta.clear();
        match &problem.null_space_velocity {
            Some(velocity) => zeta.extend_from_slice(velocity.as_slice()),
            None => zeta.resize(problem.tasks.joint_count(), 0.0),
        }
        let has_guess = problem.solver == Solver::Auto && guess.iter().any(|set| !set.is_empty());
        engine.choose(problem.solver);
        if has_guess && singularities.remain_regular(&problem.tasks, zeta, problem.damping, engine.exact()) {
            run.solve(problem, guess, zeta, singularities, engine);
            // Where no limit holds the answer back, it is the one without limits.
            if run.solution.is_held_back() {
                answer.report(problem, singularities, run, engine);
                return Ok(());
            }
        }
        singularities.examine(&problem.tasks, zeta, problem.damping, engine.exact(), has_guess);
        if problem.solver == Solver::Auto {
            let solver = engine.exact().last();
            if is_met_without_limits(problem, singularities, solver.x()) {
                let (is_optimal, residual) = solver.certify();
                if is_optimal {
                    answer.report_unlimited(problem, singularities, solver, residual);
                    return Ok(());
                }
            }
        }
        match problem.solver {
            Solver::ClosedForm => answer.report_closed_form(problem, &closed_form(problem), singularities),
            Solver::Auto | Solver::Qp => {
                let guess = if problem.solver == Solver::Auto { guess } else { &[] };
                run.solve(problem, guess, zeta, singularities, engine);
                answer.report(problem, singularities, run, engine);
            }
        }
        Ok(())
    }
}

/// Returns whether the solution without limits solves the problem: all tasks are independent and met, inside all bounds.
fn is_met_without_limits(problem: &Problem, singularities: &Singularities, x: &[f64]) -> bool {
    let within = |value: f64, lower: f64, upper: f64| lower <= value && value <= upper;
    let meets = |task: &Task| {
        (0..task.jacobian.nrows())
            .all(|row| within(row_times(&task.jacobian, row, x), task.lower[row], task.upper[row]))
    };
    let mut limits = problem.limits.lower().as_slice().iter().zip(problem.limits.upper().as_slice()).zip(x);
    singularities.is_regular
        && problem.method.meets_independent_tasks(singularities.has_only_equations)
        && limits.all(|((&lower, &upper), &x)| within(x, lower, upper))
        && problem.inequalities.iter().all(|inequality| {
            let value = inequality.coefficients().as_slice().iter().zip(x).map(|(a, x)| a * x).sum();
            within(value, f64::NEG_INFINITY, inequality.bound())
        })
        && (singularities.has_only_equations
            || problem.tasks.tasks().iter().filter(|task| !task.is_equation()).all(meets))
}
