//! The one entry: a problem in, joint velocities and their explanation out.

use revprio_problem::{ActiveSet, Problem, ProblemError, Resolution, Solve};

use super::answer::write_answer;
use super::engine::Engine;
use super::plan_run::PlanRun;
use super::singularity::Singularities;
use super::solver::Rungs;

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
    run: PlanRun,
}

impl Resolver {
    /// Returns how often each way to a working set was needed, over all problems of this workspace.
    pub fn rungs(&self) -> Rungs {
        self.engine.rungs()
    }

    /// Solves the problem as [`resolve`] does and overwrites `answer`.
    pub fn resolve(
        &mut self,
        problem: &Problem,
        guess: &[ActiveSet],
        answer: &mut Resolution,
    ) -> Result<(), ProblemError> {
        problem.check()?;
        let Self { singularities, engine, run } = self;
        let has_guess = guess.iter().any(|set| !set.is_empty());
        engine.start(problem.wants_certificate);
        let is_known = has_guess && singularities.remain_regular(&problem.tasks, problem.damping);
        if is_known {
            run.begin(problem);
            run.solve(problem, guess, singularities, false, engine);
        }
        if !is_known || !run.solution.is_held_back() {
            engine.start(problem.wants_certificate);
            run.begin(problem);
            let solver = engine.factorize(&run.levels);
            singularities.examine(problem, run.levels.equation_norm(), solver, run.has_only_equations, has_guess);
            run.solve(problem, guess, singularities, true, engine);
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
