//! The one entry: a problem in, joint velocities and their explanation out.

use revprio_problem::{ActiveSet, Problem, ProblemError, Resolution, Solve, Task};

use super::answer::{write_answer, write_unlimited};
use super::engine::Engine;
use super::plan::meets_independent_tasks;
use super::plan_run::PlanRun;
use super::singularity::Singularities;
use crate::linalg::row_times;

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
        let has_guess = guess.iter().any(|set| !set.is_empty());
        engine.start(problem.wants_certificate);
        let is_known = has_guess && singularities.remain_regular(&problem.tasks, zeta, problem.damping, engine.exact());
        if is_known {
            run.solve(problem, guess, zeta, singularities, engine);
        }
        // Where no limit holds the answer back, it is the one without limits.
        if !is_known || !run.solution.is_held_back() {
            engine.start(problem.wants_certificate);
            singularities.examine(&problem.tasks, zeta, problem.damping, engine.exact(), has_guess);
            if is_met_without_limits(problem, singularities, engine.exact().last().x()) {
                let (is_optimal, residual) = engine.exact().last().certify();
                if is_optimal {
                    run.record_unlimited(problem, zeta, engine);
                    write_unlimited(answer, problem, singularities, engine.exact().last(), residual);
                    write_certificate(engine, answer);
                    return Ok(());
                }
            }
            run.solve(problem, guess, zeta, singularities, engine);
        }
        write_answer(answer, problem, singularities, run, engine);
        write_certificate(engine, answer);
        Ok(())
    }
}

impl Solve for Resolver {
    fn solve(&mut self, problem: &Problem, guess: &[ActiveSet], answer: &mut Resolution) -> Result<(), ProblemError> {
        self.resolve(problem, guess, answer)
    }

    fn keeps_limits(&self) -> bool {
        true
    }
}

fn write_certificate(engine: &mut Engine, answer: &mut Resolution) {
    answer.certificate = engine.record.take().map(|record| Box::new(record.into_certificate()));
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
        && meets_independent_tasks(problem.method, singularities.has_only_equations)
        && limits.all(|((&lower, &upper), &x)| within(x, lower, upper))
        && problem.inequalities.iter().all(|inequality| {
            let value = inequality.coefficients().as_slice().iter().zip(x).map(|(a, x)| a * x).sum();
            within(value, f64::NEG_INFINITY, inequality.bound())
        })
        && (singularities.has_only_equations
            || problem.tasks.tasks().iter().filter(|task| !task.is_equation()).all(meets))
}
