//! How joints with a jerk limit approach the velocity that their tasks want.
//!
//! A limit of the jerk alone lets a joint pass the velocity that its tasks want: when it arrives there with the acceleration
//! a, it goes on by a²/2J, returns as fast, and swings for ever. So a period is solved twice. The first solution, without
//! limits of acceleration and jerk, is the velocity that the tasks want. The box of the second one then lets each joint only
//! arrive there with the acceleration of that velocity; see [`LimitedBox::approach`]. When the first solution already lies
//! in this box, it is the answer, and nothing is solved again.
//!
//! The second solution aims at what the first one achieves, moves as it does in the null space, and is not damped again. A damped answer
//! depends on its box: with the velocities of the tasks, the second one would be another motion towards them although the first one lies
//! in its box but for rounding, and an arm at rest would swing between both for ever.
//!
//! Joints that each arrive as fast as they can do not arrive together: on the way they would move what a higher task holds, for the sake of
//! a lower one. So if the second solution achieves less of a task that is not the lowest than the first one did, the period is solved once
//! more, and each joint may also arrive more slowly or go away from its velocity. Where the highest task whose loss differs then loses less,
//! it is the answer: the order of the tasks decides which joints wait. It is not used where an inequality acts.
//!
//! Planes and other inequalities go before such an arrival: if the second solution violates one, the box of all limits is
//! solved as it is.

use crate::arm_state::ArmState;
use crate::controller::config::ControllerConfig;
use crate::controller::state::{Memory, StepError};
use crate::limits::{LimitedBox, Pace, VelocityBox};
use crate::linalg::{Damping, Vector};
use crate::resolution::{Problem, Resolution, Solve};
use crate::task::TaskError;

/// Loss of a task's velocity, or difference of two losses, that counts as rounding, m/s or rad/s.
const LOSS: f64 = 1e-6;

/// Part of a joint's velocity that counts as rounding, rad/s or m/s: other joints need not make up for it.
const ROUNDING: f64 = 1e-9;

/// The memory of a controller that keeps jerk limits.
#[derive(Debug)]
pub(super) struct Approach {
    /// The box of all limits, narrowed.
    narrowed: LimitedBox,
    /// The velocity that the tasks want, n.
    requested: Vector,
    first: First,
}

/// The first solution of a period.
#[derive(Debug, Default)]
struct First {
    /// What each task wants that is an equation; empty for the others.
    wanted: Vec<Vec<f64>>,
    /// The null-space velocity that is wanted, and the damping.
    null_space: Option<Vector>,
    damping: Option<Damping>,
    /// What each task achieves.
    achieved: Vec<Vec<f64>>,
    /// By how much each task misses the velocity at which the second solution aims.
    missed: Vec<f64>,
    /// The scales of scaled tasks.
    scales: Vec<Option<f64>>,
    /// What each task but the lowest loses in the second solution, m/s or rad/s.
    lost: Vec<f64>,
}

impl Approach {
    /// Allocates the memory of a controller; `None` if it keeps no jerk limit.
    pub fn new(config: &ControllerConfig) -> Option<Self> {
        let n = config.robot.joint_count();
        config.keeps_jerk().then(|| Self {
            narrowed: LimitedBox::unbounded(n),
            requested: Vector::zeros(n),
            first: First { null_space: Some(Vector::zeros(n)), ..First::default() },
        })
    }

    /// Solves a period within `limits`, whose box without limits of acceleration and jerk is `without_jerk`. Returns the box in
    /// which the answer lies, and the velocity that the tasks want, n. `period`: T, s.
    pub fn resolve<'a>(
        &'a mut self,
        (arm, previous, limits): (&ArmState, &Memory, &'a LimitedBox),
        without_jerk: &'a LimitedBox,
        (problem, solver, resolution): (&mut Problem, &mut dyn Solve, &mut Resolution),
        period: f64,
    ) -> Result<(&'a LimitedBox, &'a Vector), StepError> {
        let Self { narrowed, requested, first } = self;
        let mut solve = |within: &LimitedBox, problem: &mut Problem, resolution: &mut Resolution| {
            problem.limits.copy_from(&within.velocity_box);
            solver.solve(problem, &previous.active_set, resolution)
        };
        solve(without_jerk, problem, resolution)?;
        requested.copy_from(&resolution.joint_velocity);
        let last = previous.jerk.as_ref().map_or(&previous.last_command, |jerk| &jerk.requested);
        let narrow = |narrowed: &mut LimitedBox, pace| {
            narrowed.copy_from(limits);
            let velocities = (requested.as_slice(), last.as_slice());
            narrowed.approach((&arm.robot, period), arm.motion(), velocities, pace);
        };
        narrow(narrowed, Pace::Fast);
        if round_into(&narrowed.velocity_box, &mut resolution.joint_velocity) {
            return Ok((without_jerk, requested));
        }
        first.replace_wishes(problem, resolution)?;
        solve(narrowed, problem, resolution)?;
        if first.loses(resolution) && resolution.active_constraints().next().is_none() {
            narrow(narrowed, Pace::AtMost);
            solve(narrowed, problem, resolution)?;
            if !first.loses_less(resolution) || resolution.active_constraints().next().is_some() {
                narrow(narrowed, Pace::Fast);
                solve(narrowed, problem, resolution)?;
            }
        }
        first.restore_wishes(problem, resolution)?;
        if resolution.broken_constraints().next().is_none() {
            return Ok((narrowed, requested));
        }
        solve(limits, problem, resolution)?;
        Ok((limits, requested))
    }
}

impl First {
    /// Lets a problem aim at what its first solution achieves, without damping.
    fn replace_wishes(&mut self, problem: &mut Problem, resolution: &Resolution) -> Result<(), TaskError> {
        let Self { wanted, null_space, damping, achieved, missed, scales, .. } = self;
        let outcomes = &resolution.tasks;
        wanted.resize_with(outcomes.len(), Vec::new);
        achieved.resize_with(outcomes.len(), Vec::new);
        for (achieved, outcome) in achieved.iter_mut().zip(outcomes) {
            achieved.clear();
            achieved.extend_from_slice(outcome.achieved.as_slice());
        }
        scales.clear();
        scales.extend(outcomes.iter().map(|outcome| outcome.scale));
        missed.clear();
        for (task, outcome) in problem.tasks.tasks().iter().zip(outcomes) {
            missed.push(if task.is_equation() { 0.0 } else { outcome.residual_norm });
        }
        problem.tasks.overwrite(|k, _, lower, upper| {
            wanted[k].clear();
            if lower == upper {
                wanted[k].extend_from_slice(lower.as_slice());
                lower.as_mut_slice().copy_from_slice(&achieved[k]);
                upper.as_mut_slice().copy_from_slice(&achieved[k]);
            }
        })?;
        if let Some(velocity) = null_space {
            velocity.copy_from(&resolution.joint_velocity);
        }
        std::mem::swap(&mut problem.null_space_velocity, null_space);
        *damping = problem.damping.take();
        Ok(())
    }

    /// Restores what the tasks want, and says how far they are from it.
    fn restore_wishes(&mut self, problem: &mut Problem, resolution: &mut Resolution) -> Result<(), TaskError> {
        let Self { wanted, null_space, damping, scales, .. } = self;
        std::mem::swap(&mut problem.null_space_velocity, null_space);
        problem.damping = *damping;
        for (k, outcome) in resolution.tasks.iter_mut().enumerate().filter(|(k, _)| !wanted[*k].is_empty()) {
            let missing = outcome.achieved.iter().zip(&wanted[k]).map(|(achieved, wanted)| achieved - wanted);
            outcome.residual_norm = missing.map(|missing| missing * missing).sum::<f64>().sqrt();
            outcome.scale = outcome.scale.zip(scales[k]).map(|(second, first)| first * second);
        }
        problem.tasks.overwrite(|k, _, lower, upper| {
            if !wanted[k].is_empty() {
                lower.as_mut_slice().copy_from_slice(&wanted[k]);
                upper.as_mut_slice().copy_from_slice(&wanted[k]);
            }
        })
    }

    /// Keeps what each task but the lowest loses, and returns whether one does.
    fn loses(&mut self, resolution: &Resolution) -> bool {
        let mut lost = std::mem::take(&mut self.lost);
        lost.clear();
        lost.extend(self.losses(resolution));
        self.lost = lost;
        self.lost.iter().any(|lost| *lost > LOSS)
    }

    /// Returns whether the highest task whose loss is another one than that of [`Self::loses`] loses less.
    fn loses_less(&self, resolution: &Resolution) -> bool {
        let mut differences = self.losses(resolution).zip(&self.lost).map(|(now, before)| now - before);
        differences.find(|difference| difference.abs() > LOSS).is_some_and(|difference| difference < 0.0)
    }

    /// Returns what each task but the lowest misses beyond what the first solution misses, m/s or rad/s.
    fn losses(&self, resolution: &Resolution) -> impl Iterator<Item = f64> {
        let upper = resolution.tasks.len().saturating_sub(1);
        resolution.tasks.iter().take(upper).zip(&self.missed).map(|(task, missed)| task.residual_norm - missed)
    }
}

/// Moves a velocity into a box if it lies there up to rounding, and returns whether it does.
fn round_into(limits: &VelocityBox, velocity: &mut Vector) -> bool {
    let clamped = |velocity: &f64, joint: usize| velocity.max(limits.lower()[joint]).min(limits.upper()[joint]);
    let is_inside = velocity.iter().enumerate().all(|(joint, v)| (v - clamped(v, joint)).abs() <= ROUNDING);
    if is_inside {
        velocity.iter_mut().enumerate().for_each(|(joint, v)| *v = clamped(v, joint));
    }
    is_inside
}
