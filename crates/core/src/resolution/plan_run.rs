//! The problems of a plan, solved one after the other.

use revprio_problem::{ActiveSet, Contradiction, Problem, Task};

use super::contradiction::write_contradictions;
use super::damped_targets::DampedTargets;
use super::engine::{Engine, Solved};
use super::hierarchy::Hierarchy;
use super::named_bounds::write_guess;
use super::plan::{Aim, Scaling, Step, damps_one_level, examined_step, scale_unknown, steps, write};
use super::scaling::ScaledTasks;
use super::singularity::Singularities;
use super::smoothing::Smoothing;
use super::solution::{Certainty, Solution, Start, WorkingSet, refill};
use super::strict_targets::{StrictTargets, aim_at};

/// A run of a plan and its result.
#[derive(Default)]
pub struct PlanRun {
    /// The problem that was solved last, with limits.
    pub levels: Hierarchy,
    /// Its solution: q̇, then the speeds of scaled tasks.
    pub solution: Solution,
    /// Scale of each task, `None` without one; empty without scaled tasks.
    pub scales: Vec<Option<f64>>,
    /// Inequalities that cannot be kept together.
    pub contradictions: Vec<Contradiction>,
    /// The step that [`Self::begin`] has written.
    begun: Option<Step>,
    guess: WorkingSet,
    /// Whether no task has inequality rows.
    pub has_only_equations: bool,
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
    /// Writes the problem that holds the rows of all tasks, for equations that are independent. Such equations need no other
    /// problem: each stage below the highest one meets its task.
    pub fn begin(&mut self, problem: &Problem) {
        self.start(problem);
        self.lower_tasks_are_met = true;
        let step = examined_step(problem.method);
        self.write(problem, step, 0.0);
        self.begun = Some(step);
        self.has_only_equations = self.levels.inequalities.len() == problem.constraint_rows().count();
    }

    /// Solves the plan of the problem's method, after [`Self::begin`].
    pub fn solve(
        &mut self,
        problem: &Problem,
        guess: &[ActiveSet],
        singularities: &Singularities,
        is_factorized: bool,
        engine: &mut Engine,
    ) {
        let (tasks, n) = (problem.tasks.tasks(), problem.tasks.joint_count());
        let has_guess = guess.iter().any(|set| !set.is_empty());
        let mut certainty = Certainty::default();
        self.lower_tasks_are_met = self.has_only_equations && singularities.is_regular;
        let skips_stages = self.lower_tasks_are_met;
        for step in steps(problem.method, tasks.len()).filter(|step| !(skips_stages && step.only_keeps_lower_tasks())) {
            let damping = self.damp(problem, step, singularities, engine);
            certainty.add(&self.damped.certainty);
            // Without damping, a problem that aims at the tasks alone is the same.
            let is_same = skips_stages || (problem.damping.is_none() && !matches!(step, Step::Stage { .. }));
            let is_written = is_same && self.begun == Some(step);
            if !is_written {
                self.write(problem, step, damping);
            }
            if has_guess {
                write_guess(&self.levels, guess, &mut self.guess);
            }
            let start = Start { guess: has_guess.then_some(&self.guess), is_factorized: is_written && is_factorized };
            let solved = engine.solve(&self.levels, start, &mut self.solution);
            self.finish(problem, step, (damping, singularities.is_regular), solved);
            self.smooth(problem, engine);
            certainty.add(&self.solution.certainty);
            if !step.is_last() {
                refill(&mut self.before, self.solution.x[..n].iter().copied());
            }
        }
        self.solution.certainty = certainty;
    }

    /// Forgets the run before.
    fn start(&mut self, problem: &Problem) {
        let tasks = problem.tasks.tasks();
        self.before.clear();
        match &problem.null_space_velocity {
            Some(zeta) => self.before.extend_from_slice(zeta.as_slice()),
            None => self.before.resize(problem.tasks.joint_count(), 0.0),
        }
        self.targets.clear();
        for task in tasks {
            self.targets.extend_from_slice(task.lower.as_slice());
        }
        let scaled = if tasks.iter().any(|task| task.scaled) { tasks.len() } else { 0 };
        refill(&mut self.scaling, std::iter::repeat_n(Scaling::Off, scaled));
        refill(&mut self.scales, std::iter::repeat_n(None, scaled));
        self.contradictions.clear();
        self.smoothing.clear();
    }

    /// Keeps the directions of scaled tasks, and names the demands that the last step cannot keep together.
    fn finish(&mut self, problem: &Problem, step: Step, (damping, is_regular): (f64, bool), mut solved: Solved) {
        if !step.is_last() {
            return;
        }
        let has_scaled = !self.scaling.is_empty();
        if has_scaled && is_regular && self.solution.certainty.is_optimal && !self.solution.is_held_back() {
            // Independent equations are met where nothing holds them back.
            let is_met = |k: usize| self.lower_tasks_are_met || step.reaches(k);
            refill(&mut self.scales, (0..problem.tasks.tasks().len()).map(|k| is_met(k).then_some(1.0)));
        } else if has_scaled {
            solved = self.scale(problem, step, damping, solved);
        }
        if self.solution.certainty.is_optimal {
            let joints = problem.tasks.joint_count();
            write_contradictions(&self.levels, joints, &self.solution, &mut solved, &mut self.contradictions);
        }
    }

    /// Makes a damped solution continuous. The velocity of a scaled task has one direction, which a blend would not keep.
    fn smooth(&mut self, problem: &Problem, engine: &mut Engine) {
        let keeps_direction = self.scales.iter().any(Option::is_some);
        if let Some(factors) = problem.damping.filter(|_| !keeps_direction) {
            self.smoothing.apply(&self.levels, factors, engine, &mut self.solution);
        }
    }

    fn write(&mut self, problem: &Problem, step: Step, damping: f64) {
        let Self { targets, before, scaling, lower_tasks_are_met, .. } = self;
        let aim = Aim { targets, before, damping, scaling, lower_tasks_are_met: *lower_tasks_are_met };
        write(&mut self.levels, problem, step, &aim);
    }

    /// Replaces the targets of a step by the velocities that damping leaves of them; returns the factor of its damping rows.
    fn damp(&mut self, problem: &Problem, step: Step, singularities: &Singularities, engine: &mut Engine) -> f64 {
        let (known, tasks) = (&singularities.tasks, problem.tasks.tasks());
        let Self { damped, strict, targets, before, levels, .. } = self;
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
                if !singularities.is_regular {
                    let least = factors.threshold().max(factors.fading_threshold());
                    // Damping leaves inequality tasks out, also their rows that are equations. The factorisation has those rows.
                    let mixes = tasks.iter().any(|task| !task.is_equation() && task.has_equations());
                    match engine.factorized(levels).regular_solution(least).filter(|_| !mixes) {
                        // What a task cannot influence at all counts as damped.
                        Some((x, true)) => aim_at(problem, x, targets),
                        Some(_) => {}
                        None => damped.certainty.kkt_residual = strict.lower(problem, factors, before, targets),
                    }
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
    fn scale<'e>(&mut self, problem: &Problem, step: Step, damping: f64, mut solved: Solved<'e>) -> Solved<'e> {
        for k in 0..problem.tasks.tasks().len() {
            if !problem.tasks.tasks()[k].scaled || !step.reaches(k) {
                continue;
            }
            self.scaled.examine(problem, step, k, &self.targets);
            if self.scaled.keeps_direction(&self.solution.x, 1.0) {
                self.set_scale(problem, step, k, Some(1.0));
            } else if let Scaling::On { rows, speed, unit } = self.scaled.scaling() {
                self.scaling[k] = Scaling::On { rows, speed, unit };
                solved = self.solve_again(problem, step, damping, solved);
                let unknown = scale_unknown(problem.tasks.joint_count(), &self.scaling, k);
                let scale = self.solution.x[unknown] * (unit / speed);
                if self.scaled.keeps_direction(&self.solution.x, scale) {
                    self.set_scale(problem, step, k, Some(scale));
                } else {
                    // No scale keeps the direction.
                    self.scaling[k] = Scaling::Off;
                    solved = self.solve_again(problem, step, damping, solved);
                }
            }
            if step == Step::OneLevel {
                break;
            }
        }
        solved
    }

    fn solve_again<'e>(&mut self, problem: &Problem, step: Step, damping: f64, solved: Solved<'e>) -> Solved<'e> {
        let tried = self.solution.certainty.working_sets;
        self.write(problem, step, damping);
        let solved = solved.again(&self.levels, Start::default(), &mut self.solution);
        self.solution.certainty.working_sets += tried;
        solved
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
