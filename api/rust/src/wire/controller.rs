//! A controller: the same object in a file, in a request and in a scenario.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::object;
use super::{
    Axis, Damping, Environment, Frame, Inequality, Law, LimitKind, Limits, Method, NullSpaceVelocity, Pose, Solver,
    WrenchConvention, WrenchFrame,
};

/// Robot, tasks with their laws, method, solver, limits, period.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Controller {
    /// Name of a robot.
    pub robot: String,
    /// T, s.
    pub period_s: f64,
    /// How priorities are understood.
    #[serde(default)]
    pub method: Method,
    /// How each period's problem is solved.
    #[serde(default)]
    pub solver: Solver,
    /// Allowed joint velocities.
    #[serde(default = "default_limits")]
    pub limits: Limits,
    /// Whose wrench the states carry.
    #[serde(default)]
    pub wrench_convention: WrenchConvention,
    /// What the velocities must obey beside the limits.
    #[serde(default, deserialize_with = "object::list", skip_serializing_if = "Vec::is_empty")]
    pub inequalities: Vec<Inequality>,
    /// Along which axes they carry it.
    #[serde(default)]
    pub wrench_frame: WrenchFrame,
    /// Where the tool point is, and how the tool's axes lie, in the robot's own tool frame; there if left out.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub tool_offset: Option<Pose>,
    /// ζ̇, what the joints do as far as the tasks allow; rest if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub null_space_velocity: Option<NullSpaceVelocity>,
    /// Damping near singularities; 0.05 and 0.1 if left out, exact if `null`.
    #[serde(default = "default_damping", deserialize_with = "object::optional")]
    pub damping: Option<Damping>,
    /// What the tool touches; `POST /v1/controllers` warns where a loop with it is unstable, a stateless step does not.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub environment: Option<Environment>,
    /// The tasks, highest priority first.
    #[serde(deserialize_with = "object::list")]
    pub tasks: Vec<ControllerTask>,
}

fn default_limits() -> Limits {
    Limits::Robot(LimitKind::PositionVelocity)
}

#[expect(clippy::unnecessary_wraps, reason = "`null` and a missing field mean different things")]
fn default_damping() -> Option<Damping> {
    Some(Damping { threshold: 0.05, max_factor: 0.1 })
}

/// One task with its law.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ControllerTask {
    /// Name, unique in the controller.
    pub name: String,
    /// Rows of the tool Jacobian; every law but `posture` needs them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axes: Option<Vec<Axis>>,
    /// Along which axes rows, displacements and wrench count.
    #[serde(default)]
    pub frame: Frame,
    /// The point at which rows, pose and wrench count: x, y, z in the tool frame, m; the tool point if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference_point: Option<[f64; 3]>,
    /// How the task's velocity is made.
    #[serde(deserialize_with = "object::deserialize")]
    pub law: Law,
    /// Whether limits may slow the task down, but not bend it: J_k q̇ = s ẋ_k with the largest s ≤ 1.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub scale: bool,
}

/// Answer to `POST /v1/controllers`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct CreatedController {
    /// Name of the session, part of its address.
    pub id: String,
    /// Joint order of positions and velocities.
    pub joints: Vec<String>,
    /// The session ends when it gets no state for this long, s; looking at it does not count.
    pub idle_timeout_s: u64,
    /// What is likely to go wrong: axes whose loop with the stated environment is unstable, and what would help.
    #[serde(default)]
    pub warnings: Vec<String>,
}

/// Answer to `GET /v1/controllers/{id}`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SessionStatus {
    /// Name of the session.
    pub id: String,
    /// Its configuration, defaults filled in.
    pub controller: Controller,
    /// Sequence number of the last state; `null` before the first.
    pub last_sequence: Option<u64>,
    /// States answered by a step.
    pub steps: u64,
    /// States answered again, because they were sent again.
    pub retries: u64,
    /// Steps that came more than 1.5 periods after the one before.
    #[serde(default)]
    pub missed_periods: u64,
}

/// Answer to `GET /v1/controllers`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SessionList {
    /// The sessions that are open, the one that stepped last first.
    pub controllers: Vec<SessionEntry>,
}

/// One session of the list.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SessionEntry {
    /// Name of the session.
    pub id: String,
    /// Its robot.
    pub robot: String,
    /// How priorities are understood.
    pub method: Method,
    /// How each period's problem is solved.
    pub solver: Solver,
    /// T, s.
    pub period_s: f64,
    /// States answered by a step.
    pub steps: u64,
    /// Time since its last state came, or since it was opened, s.
    pub idle_s: f64,
}
