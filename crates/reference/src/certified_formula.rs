//! The certificate of the solver `closed_form`: each stage of a formula as the problem that it solves, without limits.

use revprio_problem::{Certificate, Problem, Vector};

use crate::certified::{Known, Record, level_multipliers};
use crate::hierarchy::{Hierarchy, Solution};
use crate::plan::{Aim, Step, pose};

/// A stage of a formula.
#[derive(Debug, Clone)]
pub struct Stage {
    /// q̇ after the stage.
    pub joint_velocity: Vector,
    /// λ of the damping rows: of the one level, or of the lower tasks of a stage.
    pub lambda: f64,
}

/// Returns the certificate of the stages of a formula, in the order of evaluation. With damping, a task aims at what its stage
/// achieved: damping lowers the velocity of the task.
pub fn certificate(problem: &Problem, stages: &[Stage]) -> Certificate {
    let mut record = Record::default();
    let mut aim = Aim::new(problem);
    let has_equations = |step: &Step| match *step {
        Step::Stage { task, .. } => problem.tasks.tasks()[task].is_equation(),
        Step::OneLevel | Step::Levels => true,
    };
    let steps = Step::of(problem.method, problem.tasks.tasks().len()).into_iter().filter(has_equations);
    for (step, Stage { joint_velocity, lambda }) in steps.zip(stages) {
        aim.lambda = *lambda;
        if problem.damping.is_some() && step != Step::OneLevel {
            aim.targets = problem.tasks.tasks().iter().map(|task| &task.jacobian * joint_velocity).collect();
        }
        push(&mut record, &pose(problem, step, &aim, false), joint_velocity);
        aim.before.clone_from(joint_velocity);
    }
    if stages.is_empty() {
        // Without equations, the answer is the null-space velocity.
        push(&mut record, &Hierarchy::new(aim.before.clone()), &aim.before);
    }
    record.into_certificate()
}

/// Records a problem of equations and its solution, with the multipliers of every level.
fn push(record: &mut Record, hierarchy: &Hierarchy, joint_velocity: &Vector) {
    let mut solution = Solution::new(hierarchy, joint_velocity.clone());
    let kept: Vec<Vec<bool>> = hierarchy.levels.iter().map(|level| vec![true; level.rows.nrows()]).collect();
    let n = hierarchy.unknowns();
    let known = Known { unknowns: &vec![0.0; n], rows: &[], fixed: &vec![false; n], kept: &kept };
    let levels = 0..=hierarchy.levels.len();
    solution.certificate = levels.map(|level| level_multipliers(hierarchy, level, joint_velocity, &known)).collect();
    record.push(hierarchy, &solution);
}
