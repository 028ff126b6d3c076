//! What an answer says of a control period.

use revprio_api::wire;

use super::{AtLimit, Contacts, Sample};

impl Sample {
    /// Returns the same sample with the values of an answer: the command and what the answer says of it.
    #[must_use]
    pub fn answered(self, tasks: &[wire::ControllerTask], answer: &wire::StepAnswer, joint_names: &[String]) -> Self {
        Self {
            joint_velocity: answer.joint_velocity.clone(),
            target_force: target_force(tasks, answer),
            path: answer.solver.path,
            status: answer.solver.status,
            kkt_residual: answer.solver.kkt_residual,
            smallest_singular_value: answer.singularity.smallest_singular_value,
            manipulability: answer.singularity.manipulability,
            residual_norms: answer.tasks.iter().map(|task| task.residual_norm).collect(),
            channels: answer.channels.values().copied().map(Some).collect(),
            contacts: Contacts::of(answer, self.answered),
            least_distance: answer.collisions.as_ref().and_then(|report| report.least_distance_m),
            limits: AtLimit::of(answer, joint_names),
            ..self
        }
    }
}

/// Returns F_d on x, y and z from the answers of the tasks that control these axes.
fn target_force(tasks: &[wire::ControllerTask], answer: &wire::StepAnswer) -> [Option<f64>; 3] {
    let mut target = [None; 3];
    for (task, outcome) in tasks.iter().zip(&answer.tasks) {
        // In other frames, and along the normal of a surface, the target force is not along x, y or z of the base.
        let follows_a_surface = matches!(task.law, Some(wire::Law::Contact { surface: Some(_), .. }));
        if task.frame != wire::Frame::Base || follows_a_surface {
            continue;
        }
        for (axis, &force) in task.axes.iter().flatten().zip(outcome.target_force.iter().flatten()) {
            if let Some(slot) = target.get_mut(*axis as usize) {
                *slot = force;
            }
        }
    }
    target
}
