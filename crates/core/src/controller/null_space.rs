//! Joint motion in the null space of the tasks.

use revprio_robot::RobotModel;
use revprio_robot::kinematics::{half_range, joint_limit_slopes};

use super::capability::Capability;
use super::progress::Progress;
use super::target_streams::{self, ActiveStream};
use super::task::ArmState;
use super::task_target::TaskTarget;
use super::{Controller, Memory, TaskConfig};
use crate::law::Law;
use crate::limits::Drive;
use crate::linalg::{Damping, DampingFactor as _, Vector};
use crate::resolution::Problem;
use crate::task::TaskStack;

/// The null-space velocity ζ̇: a joint velocity that the answer follows as far as the tasks permit.
#[derive(Debug, Clone, PartialEq)]
pub enum NullSpaceMotion {
    /// A constant velocity, n, rad/s or m/s.
    Constant(Vector),
    /// −k ∇H, towards the middle of the joints' ranges. Paper: Eq. (8).
    JointLimits {
        /// k, rad²/s or m²/s.
        gain: f64,
    },
    /// f K (q_d − p), towards a posture; p is the position of rest behind the drive, and f ≤ 1 brakes what of the
    /// motion is in the null space, as the laws `pose` and `posture` brake.
    Posture {
        /// q_d, n, rad or m.
        joint_position: Vec<f64>,
        /// K, 1/s.
        gain: f64,
    },
    /// f N K (q_0 − p), towards the posture of the first step in the null space of all tasks (projector N), with a norm of
    /// at most [`HOLDING_SPEED`]: on repeated paths the arm returns to the same postures. p and f are as for `Posture`. The
    /// motion fades out near singularities of the tasks, where N turns quickly with the posture.
    InitialPosture {
        /// K, 1/s.
        gain: f64,
    },
}

/// Maximum norm of [`NullSpaceMotion::InitialPosture`], rad/s and m/s. Postures drift along a circle of 10 cm in 5 s with
/// 0.03 rad/s. With the default gain joints need no more than 1 rad/s² to stop from it.
pub const HOLDING_SPEED: f64 = 0.5;

/// K of [`NullSpaceMotion::default_for`], 1/s, for drives that are fast enough.
const HOLDING_GAIN: f64 = 2.0;

/// K of [`NullSpaceMotion::default_for`] times the delay of the loop, for slow drives. A loop with a dead time does not
/// oscillate below 1/e.
const HOLDING_MARGIN: f64 = 1.0 / 3.0;

/// K of the motion that leaves a posture, 1/s.
const LEAVING_GAIN: f64 = 2.0;

/// Share of the speed limits that the motion uses which leaves a posture.
const LEAVING_SPEED: f64 = 0.3;

/// Speed limit of this motion for joints that have none, rad/s or m/s.
const DEFAULT_SPEED: f64 = 1.0;

/// Why a null-space motion is refused.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum NullSpaceError {
    /// The motion does not have one finite number per joint.
    #[error("the null-space motion needs {expected} finite entries, one per joint")]
    Size {
        /// Joints of the robot.
        expected: usize,
    },
    /// The gain is negative or not finite.
    #[error("{0} is out of range; a gain must not be negative")]
    Gain(f64),
    /// With this gain and period the motion oscillates without decay.
    #[error("a gain of {gain} makes the motion unstable at this period; it must be below {bound}")]
    Unstable {
        /// The gain.
        gain: f64,
        /// The smallest unstable gain.
        bound: f64,
    },
}

impl NullSpaceMotion {
    /// Returns the motion of a controller that states none; `period_s`: T, s.
    ///
    /// A redundant arm whose tasks all follow positions returns to its initial posture; bounds may be among the tasks.
    /// Otherwise the arm rests in the null space (`None`).
    pub fn default_for(robot: &RobotModel, tasks: &[TaskConfig], drive: Drive, period_s: f64) -> Option<Self> {
        let mut equations = tasks.iter().filter(|task| task.law.bounds().is_none()).peekable();
        let follow = equations.peek().is_some() && equations.all(|task| matches!(task.law, Law::Position(_)));
        let delay = drive.time_to_rest(period_s) + period_s;
        let gain = HOLDING_GAIN.min(HOLDING_MARGIN / delay);
        (follow && is_redundant(robot, tasks)).then_some(Self::InitialPosture { gain })
    }

    /// Returns ζ̇ of the first step, at its posture (`joint_position`: q, n), n, rad/s or m/s.
    pub fn velocity(&self, robot: &RobotModel, joint_position: &[f64]) -> Vector {
        let mut velocity = Vector::zeros(robot.joint_count());
        self.write(robot, joint_position, joint_position, &mut velocity);
        velocity
    }

    /// Returns K of the motions that brake before a posture, 1/s.
    pub(super) fn braking_gain(&self) -> Option<f64> {
        match self {
            Self::Posture { gain, .. } | Self::InitialPosture { gain } => Some(*gain),
            Self::Constant(_) | Self::JointLimits { .. } => None,
        }
    }

    /// Overwrites `velocity` with ζ̇ of an arm that stops at once in a posture (`joint_position`: q; `initial`: q_0), n
    /// each, rad/s or m/s. It does not brake, and that of [`Self::InitialPosture`] is neither projected nor limited.
    pub(super) fn write(&self, robot: &RobotModel, joint_position: &[f64], initial: &[f64], velocity: &mut Vector) {
        match self {
            Self::Constant(constant) => velocity.copy_from(constant),
            Self::JointLimits { gain } => {
                let slopes = joint_limit_slopes(robot, joint_position);
                velocity.iter_mut().zip(slopes).for_each(|(speed, slope)| *speed = slope * -gain);
            }
            Self::Posture { joint_position: target, gain } => {
                for (speed, (target, q)) in velocity.iter_mut().zip(target.iter().zip(joint_position)) {
                    *speed = (target - q) * gain;
                }
            }
            Self::InitialPosture { gain } => {
                for (speed, (target, q)) in velocity.iter_mut().zip(initial.iter().zip(joint_position)) {
                    *speed = (target - q) * gain;
                }
            }
        }
    }

    /// Checks that the motion fits the robot and is stable at this period (s).
    pub(super) fn check(&self, robot: &RobotModel, period: f64) -> Result<(), NullSpaceError> {
        let expected = robot.joint_count();
        let fits = |values: &[f64]| values.len() == expected && values.iter().all(|value| value.is_finite());
        let (gain, rate) = match self {
            Self::Constant(velocity) if fits(velocity.as_slice()) => return Ok(()),
            Self::Posture { joint_position, gain } if fits(joint_position) => (*gain, 1.0),
            Self::InitialPosture { gain } => (*gain, 1.0),
            Self::Constant(_) | Self::Posture { .. } => return Err(NullSpaceError::Size { expected }),
            Self::JointLimits { gain } => (*gain, (0..expected).map(|i| mid_range_rate(robot, i)).fold(0.0, f64::max)),
        };
        if !(gain.is_finite() && gain >= 0.0) {
            return Err(NullSpaceError::Gain(gain));
        }
        let bound = 2.0 / (rate * period);
        if gain < bound { Ok(()) } else { Err(NullSpaceError::Unstable { gain, bound }) }
    }
}

impl Controller {
    /// Sets the null-space velocity, if the problem has one. It is zero while a streamed target is missing: an operator who
    /// lost the link expects an arm that rests.
    pub(super) fn update_null_space(
        &self,
        problem: &mut Problem,
        targets: &mut [TaskTarget],
        capability: &mut Capability,
        streams: &[ActiveStream],
        previous: &Memory,
        arm: &ArmState,
    ) {
        let Some(velocity) = &mut problem.null_space_velocity else { return };
        if target_streams::have_dropped_out(streams) {
            velocity.fill(0.0);
        } else {
            self.move_null_space(velocity, targets, capability, &problem.tasks, previous, arm);
        }
    }

    /// Sets the null-space velocity, and the targets of tasks that leave a posture.
    fn move_null_space(
        &self,
        velocity: &mut Vector,
        targets: &mut [TaskTarget],
        capability: &mut Capability,
        tasks: &TaskStack,
        previous: &Memory,
        arm: &ArmState,
    ) {
        let (config, position) = (self.config(), arm.rest.joint_position());
        let leaves = |progress: &Progress| progress.is_leaving(arm.time_s);
        if !previous.progress.iter().any(leaves) {
            let Some(motion) = &config.null_space else { return velocity.fill(0.0) };
            let initial =
                previous.initial_position.as_ref().map_or(arm.configuration.joint_position(), Vector::as_slice);
            motion.write(&config.robot, position, initial, velocity);
            let Some(gain) = motion.braking_gain() else { return };
            let row_space = capability.row_space(tasks);
            if let NullSpaceMotion::InitialPosture { .. } = motion {
                row_space.remove_from(velocity);
                limit_holding(velocity);
                // Near a singularity the null space turns quickly with the posture, and the motion would follow it.
                *velocity *= config.damping.unwrap_or(Damping::ARM).keeps(row_space.smallest());
            }
            *velocity *= capability.null_space_factor(velocity, gain);
            return;
        }
        write_leaving(&config.robot, position, velocity);
        for (k, (target, progress)) in targets.iter_mut().zip(&previous.progress).enumerate() {
            if leaves(progress) {
                let motion = capability.null_space_part(&tasks.tasks()[..k], velocity);
                target.velocity.gemv(1.0, &tasks.tasks()[k].jacobian, motion, 0.0);
                target.velocity.iter_mut().enumerate().for_each(|(row, speed)| *speed /= config.weight(k, row));
            }
        }
    }
}

/// Limits the norm of ζ̇ (n) to [`HOLDING_SPEED`].
fn limit_holding(velocity: &mut Vector) {
    let norm = velocity.norm();
    if norm > HOLDING_SPEED {
        *velocity *= HOLDING_SPEED / norm;
    }
}

/// Returns whether an arm has more joints than its tasks have rows, and no task moves single joints.
pub(super) fn is_redundant(robot: &RobotModel, tasks: &[TaskConfig]) -> bool {
    let equality = tasks.iter().filter(|task| task.law.bounds().is_none());
    let rows: usize = equality.map(|task| task.rows.len()).sum();
    rows < robot.joint_count() && tasks.iter().all(|task| task.rows.joints().is_empty())
}

/// Overwrites `velocity` with the motion towards the middle of the joints' ranges that leaves a posture, n, rad/s or m/s.
/// Joints without a range rest.
fn write_leaving(robot: &RobotModel, joint_position: &[f64], velocity: &mut Vector) {
    for (speed, (joint, q)) in velocity.iter_mut().zip(robot.joints().iter().zip(joint_position)) {
        let limits = &joint.limits;
        let bound = LEAVING_SPEED * if limits.velocity.is_finite() { limits.velocity } else { DEFAULT_SPEED };
        let towards = |_| LEAVING_GAIN * (f64::midpoint(limits.lower, limits.upper) - q);
        *speed = half_range(limits).map_or(0.0, towards).clamp(-bound, bound);
    }
}

/// Returns ∂²H/∂q_i², 1/rad² or 1/m²: the rate, per unit of gain, at which −k ∇H
/// moves a joint to the middle of its range.
pub(super) fn mid_range_rate(robot: &RobotModel, joint: usize) -> f64 {
    let half = half_range(&robot.joints()[joint].limits);
    half.map_or(0.0, |half| 1.0 / (robot.joint_count() as f64 * half * half))
}
