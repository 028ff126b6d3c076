//! The solver `qp`: the method as a cascade of quadratic programs, every level by Clarabel.

use revprio_problem::{ActiveSet, Part, Path, Problem, ProblemError, Resolution, Solve, Status, Vector};

use crate::blend::blend;
use crate::cascade::Cascade;
use crate::certified::Record;
use crate::contradiction::contradictions;
use crate::hierarchy::{Hierarchy, Solution};
use crate::plan::{Aim, Step, pose};
use crate::report::{status, write_bounds, write_velocity};
use crate::scaled::ScaledTask;
use crate::singularity::Singularities;
use crate::targets::damp;

/// Clarabel's answer at every level, bounded or not, damped or not.
///
/// Each level is polished by at most one linear solve on Clarabel's own active set; the better of both answers counts, and
/// [`Resolution::levels`] says how accurate each was. The guess of active limits is ignored.
#[derive(Default)]
pub struct Qp {
    cascade: Cascade,
}

impl Solve for Qp {
    fn solve(
        &mut self,
        problem: &Problem,
        _guess: &[ActiveSet],
        answer: &mut Resolution,
    ) -> Result<(), ProblemError> {
        problem.check()?;
        let known = Singularities::new(problem.tasks.tasks(), problem.damping);
        let mut run = Run::new(problem, &mut self.cascade);
        let (hierarchy, solution) = run.solve(&known);
        run.write(&known, &hierarchy, &solution, answer);
        Ok(())
    }

    fn keeps_limits(&self) -> bool {
        true
    }
}

/// The cascade with a record of what it solves.
pub struct Recorder<'a> {
    cascade: &'a mut Cascade,
    record: Option<Record>,
}

impl Recorder<'_> {
    /// Solves a problem and records it.
    pub fn solve(&mut self, hierarchy: &Hierarchy) -> Solution {
        let solution = self.cascade.solve(hierarchy, self.record.is_some());
        if let Some(record) = &mut self.record {
            record.push(hierarchy, &solution);
        }
        solution
    }

    /// Returns the index of the problem that was recorded last.
    pub fn last(&self) -> usize {
        self.record.as_ref().map_or(0, Record::last)
    }

    /// Sets the parts of the answer.
    pub fn set_answer(&mut self, parts: Vec<Part>) {
        if let Some(record) = &mut self.record {
            record.set_answer(parts);
        }
    }
}

/// The run of a plan.
struct Run<'a> {
    problem: &'a Problem,
    recorder: Recorder<'a>,
    aim: Aim,
    /// Scale of each task; `None` without one.
    scales: Vec<Option<f64>>,
    /// What was doubtful so far; its other fields are not used.
    doubts: Option<Solution>,
}

impl<'a> Run<'a> {
    fn new(problem: &'a Problem, cascade: &'a mut Cascade) -> Self {
        let record = problem.wants_certificate.then(Record::default);
        let scales = problem.tasks.tasks().iter().map(|_| None).collect();
        Self { problem, recorder: Recorder { cascade, record }, aim: Aim::new(problem), scales, doubts: None }
    }

    /// Solves the plan; returns its last problem and the answer.
    fn solve(&mut self, known: &Singularities) -> (Hierarchy, Solution) {
        let steps = Step::of(self.problem.method, self.problem.tasks.tasks().len());
        let mut last = None;
        for step in steps {
            self.damp(step, known);
            let hierarchy = pose(self.problem, step, &self.aim, true);
            let solution = self.solve_posed(&hierarchy);
            let (hierarchy, mut solution) = self.scale(step, hierarchy, solution);
            // A scaled task keeps its direction exactly.
            if let Some(damping) = self.problem.damping.filter(|_| self.scales.iter().all(Option::is_none)) {
                let exact = solution.clone();
                blend(&hierarchy, damping, &mut self.recorder, &mut solution);
                self.note(&solution, exact.reports.len());
            }
            self.aim.before = solution.x.rows(0, self.problem.tasks.joint_count()).into_owned();
            last = Some((hierarchy, solution));
        }
        last.unwrap_or_else(|| {
            let hierarchy = pose(self.problem, Step::Levels, &self.aim, true);
            let solution = self.solve_posed(&hierarchy);
            (hierarchy, solution)
        })
    }
}
