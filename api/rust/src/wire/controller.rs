//! Controllers and sessions. A controller is the same object in a file, in a request and in a scenario.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{
    AntiWindup, Axis, Channel, Collisions, Damping, Environment, Frame, Inequality, JointDrive, Law, LimitKind, Limits,
    Method, NullSpaceVelocity, Pose, Solver, StateChecks, Streaming, WrenchConvention, WrenchFrame, WrenchSensor,
};
use super::{bounds, defaults, integer, object};

/// A controller: robot, tasks with their laws, method, solver, limits and control period.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Controller {
    /// Name of the robot, from `GET /v1/robots`.
    pub robot: String,
    /// Control period T, s: the time from one state to the next, as your loop keeps it.
    pub period_s: f64,
    /// Resolution method, the meaning of priorities. Set another one only to compare; default
    /// `strict_reverse_priority`.
    #[serde(default)]
    pub method: Method,
    /// Solver of each period's problem. Keep the default on an arm: `qp` is a second, slower solver to compare with, and
    /// `closed_form` ignores limits. Default `auto`.
    #[serde(default)]
    pub solver: Solver,
    /// Limits of the joint velocities. Keep the default on an arm; give `lower` and `upper` to move it more slowly.
    /// Default `position_velocity_acceleration`.
    #[serde(default = "default_limits")]
    pub limits: Limits,
    /// How the joints follow a command. Set it if you have measured your arm, so that it brakes in time; default: a lag
    /// of 0.03 s and a delay of 2 periods.
    #[serde(default, deserialize_with = "object::deserialize", skip_serializing_if = "defaults::is_default")]
    pub drive: JointDrive,
    /// Sign of the wrench in the states: who exerts it on whom. Set `on_tool` for a wrist sensor that measures the
    /// force on the tool; a wrong sign makes contacts unstable. Default `on_environment`.
    #[serde(default)]
    pub wrench_convention: WrenchConvention,
    /// Inequalities on the joint velocities besides the limits: set them to keep the arm behind planes, or to couple
    /// joints; default: none.
    #[serde(default, deserialize_with = "object::list", skip_serializing_if = "Vec::is_empty")]
    pub inequalities: Vec<Inequality>,
    /// Shapes that the links keep clear of. It needs a robot with shapes; default: none.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub collisions: Option<Collisions>,
    /// Axes of the wrench in the states. Set `tool` for a sensor that turns with the tool; default `base`.
    #[serde(default)]
    pub wrench_frame: WrenchFrame,
    /// Sensor of the wrench, and what is corrected in its readings: bias, payload, place, noise. Set it for a wrist sensor; default: the
    /// wrench of a state is that at the tool point, without the weight of the tool.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub wrench_sensor: Option<WrenchSensor>,
    /// Sensors of tips other than the tool, by the name of the tip; default: none.
    #[serde(default, deserialize_with = "object::map", skip_serializing_if = "BTreeMap::is_empty")]
    #[schema(example = json!({"right_hand": {"payload": {"mass_kg": 0.4}}}))]
    pub wrench_sensors: BTreeMap<String, WrenchSensor>,
    /// Pose of the tool point and axes in the robot's own tool frame, m. Set it to the point that works, such as the
    /// tip of a gripper; default: that frame itself.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub tool_offset: Option<Pose>,
    /// Null-space velocity ζ̇, which the answer follows as far as the tasks permit. Set it to choose the posture of a
    /// redundant arm; default: `initial_posture` with the gain 2 (less for slow drives) if the arm has more joints than its
    /// tasks have rows, all tasks have the law `pose` or bounds, and none moves single joints; otherwise `rest`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub null_space_velocity: Option<NullSpaceVelocity>,
    /// Whether the arm leaves a posture in which the end of a joint's range holds a `pose` task back: the joints move towards
    /// the middle of their ranges for 4 s, up to three times. Tasks above it are not disturbed. Only if the arm has more
    /// joints than its tasks have rows, no task moves single joints, and no task has the law `force`, `impedance` or
    /// `hybrid`; default `true`.
    #[serde(default = "defaults::yes", skip_serializing_if = "defaults::is_yes")]
    pub leave_local_minima: bool,
    /// Damping near singularities, which trades accuracy for lower joint speeds; `null`: no damping, for simulations.
    /// Default: threshold 0.15, max_factor 0.15.
    #[serde(default = "default_damping", deserialize_with = "object::optional")]
    pub damping: Option<Damping>,
    /// Characteristic length L, m: 1 m/s of the tool counts as 1/L rad/s in singular values, in damping, and where the rows of
    /// a task are weighed against each other. Set it to the reach of an arm that is much smaller or larger than 1 m; default
    /// 1.
    #[schema(example = 1.2)]
    #[serde(default = "defaults::one", skip_serializing_if = "is_default_length")]
    pub characteristic_length_m: f64,
    /// Environment that the tool touches, as far as known. Set it before a first contact: `POST /v1/controllers` then
    /// warns of unstable axes. Default: unknown.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub environment: Option<Environment>,
    /// Maximum validity of an answer, ms. Set it to a few periods of your loop: your watchdog brakes after it, and before the next
    /// answer comes if it is shorter than a period. Default 100.
    #[serde(
        default = "default_valid_for_ms",
        deserialize_with = "integer::deserialize",
        skip_serializing_if = "is_default_valid_for_ms"
    )]
    pub valid_for_ms: u64,
    /// Bounds of a plausible state, beyond which it is refused. Set the largest force and torque that your task needs;
    /// default: those of `StateChecks`.
    #[serde(default, deserialize_with = "object::deserialize", skip_serializing_if = "defaults::is_default")]
    pub state_checks: StateChecks,
    /// When integrators of laws follow the achieved velocity. Set another value only to reproduce the paper; default
    /// `always`.
    #[serde(default, skip_serializing_if = "defaults::is_default")]
    pub anti_windup: AntiWindup,
    /// Whether every answer has `why`, sentences that say what restricts it. Set it while you tune or look for a fault; it
    /// makes answers longer. Default `false`.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    #[schema(example = true)]
    pub why: bool,
    /// The tasks, highest priority first: put first what must not give way, such as contact or safety.
    #[serde(deserialize_with = "object::list")]
    pub tasks: Vec<ControllerTask>,
    /// Channels besides the joints, such as a gripper, at most 16; default: none.
    #[serde(default, deserialize_with = "object::list", skip_serializing_if = "Vec::is_empty")]
    pub channels: Vec<Channel>,
}

#[expect(clippy::float_cmp, reason = "the default is written as it is")]
#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde hands over a reference")]
fn is_default_length(length: &f64) -> bool {
    *length == defaults::one()
}

/// Covers a few periods of a slow loop.
fn default_valid_for_ms() -> u64 {
    100
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde hands over a reference")]
fn is_default_valid_for_ms(value: &u64) -> bool {
    *value == default_valid_for_ms()
}

fn default_limits() -> Limits {
    Limits::Robot(LimitKind::PositionVelocityAcceleration)
}

#[expect(clippy::unnecessary_wraps, reason = "`null` and a missing field mean different things")]
fn default_damping() -> Option<Damping> {
    Some(Damping::ARM)
}

/// One task of a controller: its rows, and their law or bounds of their velocity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ControllerTask {
    /// Name, unique in the controller. Answers and targets name the task by it.
    pub name: String,
    /// Axes of the tool that the task moves, one per row; list only those that matter, so that lower tasks keep the
    /// others. Required by every law except `posture` if there is no `jacobian`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub axes: Option<Vec<Axis>>,
    /// Axes along which rows, displacements and wrench are measured. Set `tool` for motions relative to the tool, or a
    /// pose for a surface; default `base`.
    #[serde(default)]
    pub frame: Frame,
    /// Reference point of rows, pose and wrench: x, y, z in the tool frame, m. Set it if this task moves another point
    /// than the others; default: the tool point.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference_point: Option<[f64; 3]>,
    /// Tip or link that the axes belong to, by its name, in place of the tool. Set it for a second arm, an elbow or a camera; only with
    /// `axes`; default: the first tip, which is the tool.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(example = "right")]
    pub link: Option<String>,
    /// Tip or link from which the motion is seen, by its name, in place of the base: poses, velocities and the frame `base` are then those of
    /// its frame. Set it for two hands that hold one part; only with `axes`; default: the base.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(example = "left")]
    pub relative_to: Option<String>,
    /// Constant task Jacobian J_k, m × n, row by row, in joint order. Set it for rows that no axis gives, such as a sum
    /// of joints; instead of `axes`, with the law `velocity` or bounds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub jacobian: Option<Vec<Vec<f64>>>,
    /// Law that computes the velocity of the task: motion to a target, or contact with a force. Instead of `lower` and
    /// `upper`.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub law: Option<Law>,
    /// Lower bounds of the task velocity J_k q̇, one entry per row, m/s and rad/s. Set bounds instead of `law` if the
    /// task only limits a motion; `null`: no bound; default: none.
    #[serde(default, deserialize_with = "bounds::lower", skip_serializing_if = "Option::is_none")]
    pub lower: Option<Vec<Option<f64>>>,
    /// Upper bounds of the task velocity J_k q̇, as `lower`.
    #[serde(default, deserialize_with = "bounds::upper", skip_serializing_if = "Option::is_none")]
    pub upper: Option<Vec<Option<f64>>>,
    /// Whether limits slow the task down in its direction, J_k q̇ = s ẋ_k with the largest s ≤ 1. Set it for paths that
    /// must keep their shape; only with `law`; default `false`.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub scale: bool,
    /// How the task follows the `targets` of the states. Set it for a source of targets that is slower than 30 Hz,
    /// noisy or late; default: the defaults of its fields.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub streaming: Option<Streaming>,
}

/// Answer to `POST /v1/controllers`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct CreatedController {
    /// Identifier of the session, part of its address.
    pub id: String,
    /// Names of the joints, in the order of all vectors of joints.
    pub joints: Vec<String>,
    /// Time without a new state after which the session ends, s; `GET` requests do not extend it.
    pub idle_timeout_s: u64,
    /// Warnings: axes whose loop with the given environment is unstable, and tasks whose law is unstable without contact,
    /// behind the drive of the controller, with what would make them stable; tasks whose gain
    /// is above the ratio of the acceleration and speed limits of a joint.
    #[serde(default)]
    pub warnings: Vec<String>,
}

/// Answer to `GET /v1/controllers/{id}`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SessionStatus {
    /// Identifier of the session.
    pub id: String,
    /// Configuration of the controller. Fields that equal their default may be left out.
    pub controller: Controller,
    /// Sequence number of the last state; `null` before the first.
    pub last_sequence: Option<u64>,
    /// Number of states answered by a step.
    pub steps: u64,
    /// Number of repeated states, which got the same answer again.
    pub retries: u64,
    /// Number of steps that came more than 1.5 periods after the previous step.
    #[serde(default)]
    pub missed_periods: u64,
}

/// Answer to `GET /v1/controllers`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SessionList {
    /// Open sessions, the one with the most recent step first.
    pub controllers: Vec<SessionEntry>,
}

/// One session in a list of sessions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SessionEntry {
    /// Identifier of the session.
    pub id: String,
    /// Name of the robot, from `GET /v1/robots`.
    pub robot: String,
    /// Resolution method.
    pub method: Method,
    /// Solver.
    pub solver: Solver,
    /// Control period T, s: the time from one state to the next, as your loop keeps it.
    pub period_s: f64,
    /// Number of states answered by a step.
    pub steps: u64,
    /// Time since the last state, or since the session was opened, s.
    pub idle_s: f64,
}
