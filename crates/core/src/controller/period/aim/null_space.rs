//! Joint motion in the null space of the tasks.

use revprio_robot::RobotModel;
use revprio_robot::kinematics::half_range;

use super::braking::RequestBounds;
use crate::arm_state::ArmState;
use crate::controller::config::{ControllerConfig, HOLDING_SPEED, NullSpaceMotion};
use crate::controller::state::{Memory, Progress, TaskTarget};
use crate::linalg::{DampingFactor as _, Vector};
use crate::task::TaskStack;

/// K of the motion that leaves a posture, 1/s, as of the motion that holds one.
const LEAVING_GAIN: f64 = 2.0;

/// Share of the speed limits that the motion uses which leaves a posture. Nobody expects it, so it is slow.
const LEAVING_SPEED: f64 = 0.3;

/// Speed limit of this motion for joints that have none, rad/s or m/s: lower than that of any built-in arm.
const DEFAULT_SPEED: f64 = 1.0;

/// Overwrites the null-space velocity (n), and the targets of tasks that leave a posture. `tasks`: with the Jacobians of this
/// period; `moved`: whether a joint moves each row at some posture.
pub(super) fn write(
    velocity: &mut Vector,
    targets: &mut [TaskTarget],
    bounds: &mut RequestBounds,
    (config, arm, previous): (&ControllerConfig, &ArmState, &Memory),
    (tasks, moved): (&TaskStack, &[Vec<bool>]),
) {
    let leaves = |progress: &Progress| progress.is_leaving(arm.time_s);
    if previous.progress.iter().any(leaves) {
        write_leaving(&config.robot, arm.at_rest().configuration.joint_position(), velocity);
        for (k, (target, progress)) in targets.iter_mut().zip(&previous.progress).enumerate() {
            if leaves(progress) {
                let motion = bounds.null_space_part(&tasks.tasks()[..k], velocity);
                target.velocity.gemv(1.0, &tasks.tasks()[k].jacobian, motion, 0.0);
                target.velocity.iter_mut().enumerate().for_each(|(row, speed)| *speed /= config.weight(k, row));
            }
        }
    } else if let Some(motion) = &config.null_space {
        let measured = arm.measured().configuration.joint_position();
        let initial = previous.initial_position.as_ref().map_or(measured, Vector::as_slice);
        motion.write(&config.robot, arm.at_rest().configuration.joint_position(), initial, velocity);
        brake(velocity, motion, bounds, (config, arm), (tasks, moved));
    } else {
        velocity.fill(0.0);
    }
}

/// Limits a motion to a posture, and brakes it before its target.
fn brake(
    velocity: &mut Vector,
    motion: &NullSpaceMotion,
    bounds: &mut RequestBounds,
    (config, arm): (&ControllerConfig, &ArmState),
    (tasks, moved): (&TaskStack, &[Vec<bool>]),
) {
    let Some(gain) = motion.braking_gain() else { return };
    let row_space = bounds.row_space(tasks, moved);
    if let NullSpaceMotion::InitialPosture { .. } = motion {
        row_space.remove_from(velocity);
        limit_holding(velocity);
        // Near a singularity the null space turns quickly with the posture, and the motion would follow it.
        *velocity *= config.near_singular().keeps(row_space.smallest());
    }
    *velocity *= bounds.null_space_factor(&arm.capability, velocity, gain);
}

/// Limits the norm of ζ̇ (n) to [`HOLDING_SPEED`].
fn limit_holding(velocity: &mut Vector) {
    let norm = velocity.norm();
    if norm > HOLDING_SPEED {
        *velocity *= HOLDING_SPEED / norm;
    }
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
