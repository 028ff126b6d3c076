//! The solver `qp`: the method as a cascade of quadratic programs, every level by Clarabel.

use revprio_problem::{ActiveSet, Path, Problem, ProblemError, Resolution, Solve, Status};

use crate::blend::blend;
use crate::cascade::Cascade;
use crate::contradiction::contradictions;
use crate::hierarchy::{Hierarchy, Solution};
use crate::plan::{Aim, pose};
use crate::recorder::Recorder;
use crate::report::{status, write_bounds, write_velocity};
use crate::scaled::ScaledTask;
use crate::singularity::Singularities;
use crate::step::Step;
use crate::targets::damp;

/// Clarabel's answer at every level, bounded or not, damped or not.
///
/// Each answer of Clarabel is polished by at most one linear solve on its own active set; the better of both counts, and
/// [`Resolution::levels`] says how accurate they were. Where neither is sure, Clarabel is called again with more effort. The guess
/// of active limits is ignored.
#[derive(Default)]
pub struct Qp {
    cascade: Cascade,
}

impl Qp {
    /// Returns a solver that gives up as soon as `stop` returns true, before Clarabel's next call; its answer is not certified then.
    /// Hundreds of rows in tens of levels take minutes.
    pub fn until(stop: impl Fn() -> bool + Send + 'static) -> Self {
        Self { cascade: Cascade::until(stop) }
    }
}

impl Solve for Qp {
    fn solve(&mut self, problem: &Problem, _guess: &[ActiveSet], answer: &mut Resolution) -> Result<(), ProblemError> {
        problem.check()?;
        let known = Singularities::new(problem.tasks.tasks(), problem.damping);
        let mut run = PlanRun::new(problem, &mut self.cascade);
        if let Some((hierarchy, solution)) = run.solve(&known) {
            run.write(&known, &hierarchy, &solution, answer);
        }
        Ok(())
    }

    fn keeps_limits(&self) -> bool {
        true
    }
}

/// The run of a plan.
struct PlanRun<'a> {
    problem: &'a Problem,
    recorder: Recorder<'a>,
    aim: Aim,
    /// Scale of each task; `None` without one.
    scales: Vec<Option<f64>>,
}

impl<'a> PlanRun<'a> {
    fn new(problem: &'a Problem, cascade: &'a mut Cascade) -> Self {
        let recorder = Recorder::new(cascade, problem.wants_certificate);
        let scales = problem.tasks.tasks().iter().map(|_| None).collect();
        Self { problem, recorder, aim: Aim::new(problem), scales }
    }

    /// Solves the plan; returns its last problem and the answer.
    fn solve(&mut self, known: &Singularities) -> Option<(Hierarchy, Solution)> {
        let mut last = None;
        for step in Step::of(self.problem.method, self.problem.tasks.tasks().len()) {
            if self.recorder.is_stopped() && !step.is_last() {
                continue;
            }
            let recorder = &mut self.recorder;
            let lambda = damp(self.problem, step, known, &mut self.aim, &mut |problem| recorder.solve(problem).x);
            self.aim.lambda = lambda;
            let (hierarchy, mut solution) = self.solve_step(step);
            // A scaled task keeps its direction exactly.
            if let Some(damping) = self.problem.damping.filter(|_| self.scales.iter().all(Option::is_none)) {
                blend(&hierarchy, damping, &mut self.recorder, &mut solution);
            }
            self.aim.before = solution.x.rows(0, self.problem.tasks.joint_count()).into_owned();
            last = Some((hierarchy, solution));
        }
        last
    }

    fn solve_posed(&mut self, step: Step) -> (Hierarchy, Solution) {
        let hierarchy = pose(self.problem, step, &self.aim, true);
        let solution = self.recorder.solve(&hierarchy);
        (hierarchy, solution)
    }

    /// Solves a step. In the last one, scaled tasks that the limits bend are slowed down, from the highest to the lowest.
    fn solve_step(&mut self, step: Step) -> (Hierarchy, Solution) {
        let mut solved = self.solve_posed(step);
        let tasks = self.problem.tasks.tasks();
        let reaches = |k: usize| !matches!(step, Step::Stage { task, .. } if task != k);
        for k in (0..tasks.len()).filter(|&k| step.is_last() && tasks[k].scaled && reaches(k)) {
            let scaled = ScaledTask::new(self.problem, step, k, &self.aim.targets);
            if scaled.keeps_direction(&solved.1.x, 1.0) {
                self.set_scale(step, k, 1.0);
            } else if scaled.speed > 0.0 {
                self.aim.scaled[k] = Some(scaled.clone());
                solved = self.solve_posed(step);
                let unknown = self.problem.tasks.joint_count() + self.aim.scaled[..k].iter().flatten().count();
                let scale = solved.1.x[unknown] * (scaled.unit / scaled.speed);
                if scaled.keeps_direction(&solved.1.x, scale) {
                    self.set_scale(step, k, scale);
                } else {
                    // No scale keeps the direction.
                    self.aim.scaled[k] = None;
                    solved = self.solve_posed(step);
                }
            }
            if step == Step::OneLevel {
                break;
            }
        }
        solved
    }

    /// Sets the scale of a task, or of all scaled tasks of one level.
    fn set_scale(&mut self, step: Step, k: usize, scale: f64) {
        for (other, task) in self.problem.tasks.tasks().iter().enumerate() {
            if other == k || (step == Step::OneLevel && task.scaled) {
                self.scales[other] = Some(scale);
            }
        }
    }

    fn write(self, known: &Singularities, hierarchy: &Hierarchy, solution: &Solution, answer: &mut Resolution) {
        write_velocity(self.problem, known, &solution.x, answer);
        for (task, (scale, stated)) in answer.tasks.iter_mut().zip(self.scales.iter().zip(self.problem.tasks.tasks())) {
            task.scale = scale.filter(|_| stated.scaled);
        }
        let residual = self.recorder.residual();
        let report = &mut answer.solver;
        report.path = Path::Qp;
        report.iterations = self.recorder.levels.iter().map(|level| level.iterations).sum();
        report.failures = self.recorder.failures;
        if report.status != Status::Failed {
            report.status = if self.recorder.is_unsure { Status::NotCertified } else { status(residual) };
            report.kkt_residual = Some(residual).filter(|residual| residual.is_finite());
            report.rank_uncertain = known.rank_uncertain || self.recorder.rank_uncertain;
            write_bounds(self.problem, hierarchy, solution, answer);
            if answer.solver.status == Status::Optimal {
                let (joints, is_stopped) = (self.problem.tasks.joint_count(), || self.recorder.is_stopped());
                answer.contradictions = contradictions(hierarchy, solution, joints, &is_stopped);
            }
        }
        answer.levels.clone_from(&self.recorder.levels);
        answer.certificate = self.recorder.into_certificate();
    }
}
