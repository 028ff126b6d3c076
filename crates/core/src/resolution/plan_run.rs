//! The problems of a plan, solved one after the other.

use revprio_problem::{ActiveSet, Contradiction, Problem, Task};

use super::contradiction::write_contradictions;
use super::damped_targets::DampedTargets;
use super::engine::Engine;
use super::level::{Solution, WorkingSet, refill};
use super::plan::{Aim, PlannedProblem, Scaling, Step, damps_one_level, own_levels, steps};
use super::scaling::ScaledTasks;
use super::singularity::Singularities;
use super::smoothing::Smoothing;
use super::strict_targets::StrictTargets;

/// A run of a plan and its result.
#[derive(Default)]
pub struct PlanRun {
    /// The problem that was solved last, with limits.
    pub planned: PlannedProblem,
    /// Its solution: q̇, then the speeds of scaled tasks.
    pub solution: Solution,
    /// Scale of each task; `None` without one.
    pub scales: Vec<Option<f64>>,
    /// Inequalities that cannot be kept together.
    pub contradictions: Vec<Contradiction>,
    /// Whether the row values of `solution` are J_k q̇ of all tasks, in their order.
    pub has_task_values: bool,
    guess: WorkingSet,
    /// Whether every stage below the highest one meets its task.
    lower_tasks_are_met: bool,
    /// q̇', the answer of the problem before.
    before: Vec<f64>,
    /// The velocities that the equations aim at, all tasks one after the other.
    targets: Vec<f64>,
    scaling: Vec<Scaling>,
    scaled: ScaledTasks,
    smoothing: Smoothing,
    damped: DampedTargets,
    strict: StrictTargets,
}

impl PlanRun {
    /// Solves the plan of the problem's method from ζ̇ = `zeta` on.
    pub fn solve(
        &mut self,
        problem: &Problem,
        guess: &[ActiveSet],
        zeta: &[f64],
        singularities: &Singularities,
        engine: &mut Engine,
    ) {
        let tasks = problem.tasks.tasks();
        self.start(problem, zeta);
        let (mut kkt_residual, mut is_optimal, mut working_sets, mut rank_uncertain) = (0.0_f64, true, 0, false);
        // Independent equations: the stages below the highest one need not be solved.
        self.lower_tasks_are_met = singularities.is_regular && singularities.has_only_equations;
        if self.lower_tasks_are_met && self.solve_independent(problem, guess, engine) {
            return;
        }
        let skips_stages = self.lower_tasks_are_met;
        for step in steps(problem.method, tasks.len()).filter(|step| !(skips_stages && step.only_keeps_lower_tasks())) {
            let damping = self.damp(problem, step, singularities, engine);
            is_optimal &= self.damped.is_optimal;
            kkt_residual = kkt_residual.max(self.damped.kkt_residual);
            self.write(problem, step, damping);
            self.planned.write_guess(guess, &mut self.guess);
            engine.solve(&self.planned.levels, &self.planned.origins, Some(&self.guess), &mut self.solution);
            self.finish(problem, step, damping, engine);
            kkt_residual = kkt_residual.max(self.solution.kkt_residual);
            is_optimal &= self.solution.is_optimal;
            working_sets += self.solution.working_sets;
            rank_uncertain |= self.solution.rank_uncertain;
            refill(&mut self.before, self.solution.x[..zeta.len()].iter().copied());
        }
        let solution = &mut self.solution;
        (solution.kkt_residual, solution.is_optimal) = (kkt_residual, is_optimal);
        (solution.working_sets, solution.rank_uncertain) = (working_sets, rank_uncertain);
    }

    /// Solves the last problem of a plan whose tasks are independent equations that the solver knows; `false` if the plan has
    /// more than these and the box, or without an answer.
    fn solve_independent(&mut self, problem: &Problem, guess: &[ActiveSet], engine: &mut Engine) -> bool {
        let tasks = problem.tasks.tasks();
        let Some(own_levels) = own_levels(problem.method, tasks.len()) else { return false };
        if !problem.inequalities.is_empty() || tasks.iter().any(|task| task.scaled) {
            return false;
        }
        let n = problem.tasks.joint_count();
        self.planned.clear_origins();
        self.guess.clear(n, 0);
        self.guess.hold(guess);
        engine.solve_within(&problem.limits, own_levels, &self.guess, &mut self.solution);
        if !self.solution.is_optimal {
            return false;
        }
        // Where x was moved to its bounds, the values of the rows are not those of the answer.
        self.has_task_values = engine.exact().last().x() == self.solution.x;
        let Some(last) = steps(problem.method, tasks.len()).last() else { return true };
        if problem.damping.is_some() || engine.record.is_some() {
            self.write(problem, last, 0.0);
        }
        self.record_last(engine);
        if let Some(factors) = problem.damping {
            self.smoothing.apply(&self.planned, factors, engine, &mut self.solution);
        }
        true
    }

    /// Records the last problem of a plan, which the solver has solved with other data.
    fn record_last(&mut self, engine: &mut Engine) {
        if let Some(mut record) = engine.record.take() {
            record.push(&self.planned.levels, &self.planned.origins, &self.solution.x, engine.exact().last());
            engine.record = Some(record);
        }
    }

    /// Records the last problem of the plan for independent equations that the solver meets without limits.
    pub fn record_unlimited(&mut self, problem: &Problem, zeta: &[f64], engine: &mut Engine) {
        let Some(last) = steps(problem.method, problem.tasks.tasks().len()).last() else { return };
        if engine.record.is_some() {
            self.start(problem, zeta);
            self.lower_tasks_are_met = true;
            self.write(problem, last, 0.0);
            refill(&mut self.solution.x, engine.exact().last().x().iter().copied());
            self.record_last(engine);
        }
    }

    /// Forgets the run before.
    fn start(&mut self, problem: &Problem, zeta: &[f64]) {
        let tasks = problem.tasks.tasks();
        refill(&mut self.before, zeta.iter().copied());
        self.targets.clear();
        for task in tasks {
            self.targets.extend_from_slice(task.lower.as_slice());
        }
        refill(&mut self.scaling, std::iter::repeat_n(Scaling::Off, tasks.len()));
        refill(&mut self.scales, tasks.iter().map(|_| None));
        self.contradictions.clear();
        self.has_task_values = false;
    }

    /// Scales tasks and explains contradictions after the last problem; makes damped answers continuous.
    fn finish(&mut self, problem: &Problem, step: Step, damping: f64, engine: &mut Engine) {
        if step.is_last() && problem.tasks.tasks().iter().any(|task| task.scaled) {
            self.scale(problem, step, damping, engine);
        }
        if step.is_last() && self.solution.is_optimal {
            write_contradictions(problem, &self.planned, &self.solution, engine.exact(), &mut self.contradictions);
        }
        // A scaled task keeps its direction exactly.
        let keeps_direction = self.scales.iter().any(Option::is_some);
        if let Some(factors) = problem.damping.filter(|_| !keeps_direction) {
            self.smoothing.apply(&self.planned, factors, engine, &mut self.solution);
        }
    }

    fn write(&mut self, problem: &Problem, step: Step, damping: f64) {
        let Self { targets, before, scaling, lower_tasks_are_met, .. } = self;
        let aim = Aim { targets, before, damping, scaling, lower_tasks_are_met: *lower_tasks_are_met };
        self.planned.write(problem, step, &aim);
    }

    /// Replaces the targets of a step by the velocities that damping leaves of them; returns the factor of its damping rows.
    fn damp(&mut self, problem: &Problem, step: Step, singularities: &Singularities, engine: &mut Engine) -> f64 {
        let (known, tasks) = (&singularities.tasks, problem.tasks.tasks());
        let Self { damped, strict, targets, before, .. } = self;
        damped.clear();
        let Some(factors) = problem.damping else { return 0.0 };
        match step {
            Step::OneLevel => {
                let all = tasks.iter().position(Task::is_equation).map_or(0.0, |first| known[first].lambda);
                let factor = if damps_one_level(problem.method) { all } else { 0.0 };
                if factor > 0.0 && tasks.iter().any(|task| task.scaled) {
                    // A scaled stack has one velocity. Damping forms it first.
                    damped.lower(problem, 0..tasks.len(), factor, before, targets, engine);
                    return 0.0;
                }
                factor
            }
            Step::Levels => {
                if known.iter().any(|task| task.strict > 0.0) {
                    damped.kkt_residual = strict.lower(problem, factors, before, targets);
                }
                0.0
            }
            Step::Stage { task, keeps_lower_tasks } => {
                let factor = if keeps_lower_tasks { known[task].lambda } else { 0.0 };
                if known[task].mu > 0.0 {
                    damped.lower(problem, task..task + 1, known[task].mu, before, targets, engine);
                    if keeps_lower_tasks && tasks[task + 1..].iter().any(Task::is_equation) {
                        damped.fade(problem, task, (factors, factor), before, targets, engine);
                    }
                }
                factor
            }
        }
    }

    /// Slows scaled tasks down that the limits bend, from the highest to the lowest.
    fn scale(&mut self, problem: &Problem, step: Step, damping: f64, engine: &mut Engine) {
        for k in 0..problem.tasks.tasks().len() {
            if !problem.tasks.tasks()[k].scaled || !step.reaches(k) {
                continue;
            }
            self.scaled.examine(problem, step, k, &self.targets);
            if self.scaled.keeps_direction(&self.solution.x, 1.0) {
                self.set_scale(problem, step, k, Some(1.0));
            } else if let Scaling::On { rows, speed } = self.scaled.scaling() {
                self.scaling[k] = Scaling::On { rows, speed };
                self.solve_again(problem, step, damping, engine);
                let scale = self.planned.scale_unknowns[k].map_or(0.0, |unknown| self.solution.x[unknown] / speed);
                if self.scaled.keeps_direction(&self.solution.x, scale) {
                    self.set_scale(problem, step, k, Some(scale));
                } else {
                    // No scale keeps the direction.
                    self.scaling[k] = Scaling::Off;
                    self.solve_again(problem, step, damping, engine);
                }
            }
            if step == Step::OneLevel {
                return;
            }
        }
    }

    fn solve_again(&mut self, problem: &Problem, step: Step, damping: f64, engine: &mut Engine) {
        let tried = self.solution.working_sets;
        self.write(problem, step, damping);
        engine.solve(&self.planned.levels, &self.planned.origins, None, &mut self.solution);
        self.solution.working_sets += tried;
    }

    /// Sets the scale of a task, or of all scaled tasks of one level.
    fn set_scale(&mut self, problem: &Problem, step: Step, k: usize, scale: Option<f64>) {
        for (other, task) in problem.tasks.tasks().iter().enumerate() {
            if other == k || (step == Step::OneLevel && task.scaled) {
                self.scales[other] = scale;
            }
        }
    }
}
