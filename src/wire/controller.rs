//! A controller: the same object in a file, in a request and in a scenario.

use serde::{Deserialize, Serialize};

use super::object;
use super::{Axis, Damping, LimitKind, Limits, Method, Solver, TargetPose, WrenchConvention};

/// Robot, tasks with their laws, method, solver, limits, period.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
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
    /// Damping near singularities; 0.05 and 0.1 if left out, exact if `null`.
    #[serde(default = "default_damping", deserialize_with = "object::optional")]
    pub damping: Option<Damping>,
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
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ControllerTask {
    /// Name, unique in the controller.
    pub name: String,
    /// Rows of the tool Jacobian.
    pub axes: Vec<Axis>,
    /// How the task's velocity is made.
    #[serde(deserialize_with = "object::deserialize")]
    pub law: Law,
}

/// How a task's velocity is made; lists have one entry per axis of the task.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Law {
    /// ẋ as given.
    Velocity {
        /// ẋ, m/s and rad/s.
        #[serde(deserialize_with = "object::deserialize")]
        target_velocity: Profile,
    },
    /// Follow a force.
    Force {
        /// M_d, kg and kg·m².
        inertia: Vec<f64>,
        /// B_d, N·s/m and N·m·s/rad.
        damping: Vec<f64>,
        /// F_d, N and N·m.
        #[serde(deserialize_with = "object::deserialize")]
        target_force: Profile,
    },
    /// Behave as mass, damper and spring about a pose.
    Impedance {
        /// M_d, kg and kg·m².
        inertia: Vec<f64>,
        /// B_d, N·s/m and N·m·s/rad.
        damping: Vec<f64>,
        /// K_d, N/m and N·m/rad.
        stiffness: Vec<f64>,
        /// X_d.
        #[serde(default)]
        target_pose: TargetPose,
    },
    /// Some axes follow a force, the others a pose.
    Hybrid {
        /// M_d, kg and kg·m².
        inertia: Vec<f64>,
        /// B_d, N·s/m and N·m·s/rad.
        damping: Vec<f64>,
        /// K_d, N/m and N·m/rad; counts on position-controlled axes.
        stiffness: Vec<f64>,
        /// S: true = position-controlled, false = force-controlled.
        position_controlled: Vec<bool>,
        /// F_d, N and N·m; counts on force-controlled axes.
        #[serde(deserialize_with = "object::deserialize")]
        target_force: Profile,
        /// X_d.
        #[serde(default)]
        target_pose: TargetPose,
    },
}

/// A set-point over time, one entry per axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Profile {
    /// The same for ever.
    Constant {
        /// The value.
        value: Vec<f64>,
    },
    /// offset + amplitude sin(ω t + φ).
    Sine {
        /// Mean value.
        offset: Vec<f64>,
        /// Swing.
        amplitude: Vec<f64>,
        /// ω, rad/s.
        angular_frequency_rad_s: f64,
        /// φ, rad.
        #[serde(default)]
        phase_rad: f64,
    },
}

/// Answer to `POST /v1/controllers`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CreatedController {
    /// Name of the session, part of its address.
    pub id: String,
    /// Joint order of positions and velocities.
    pub joints: Vec<String>,
    /// The session ends when it is not called for this long, s.
    pub idle_timeout_s: u64,
}

/// Answer to `GET /v1/controllers/{id}`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
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
