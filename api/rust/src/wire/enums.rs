//! Enums that bodies share, with the damping and the limits of the joint velocities.

use std::borrow::Cow;
use std::fmt;

use serde::de::{MapAccess, value::MapAccessDeserializer, value::StrDeserializer};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use utoipa::ToSchema;

use super::string_or_map::{self, StringOrMap};

/// Implements `Display` with the string that stands in JSON.
macro_rules! display_as_in_json {
    ($($name:ty),+) => {$(
        impl fmt::Display for $name {
            fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
                self.serialize(formatter)
            }
        }
    )+};
}

display_as_in_json!(Axis, Method, Solver, Path, Status, Side, LimitKind);

/// Implements `Deserialize` from a string only. For an enum, serde also accepts `{"name": null}` and, in MessagePack,
/// the index of the variant.
macro_rules! read_as_string {
    ($($name:ty),+) => {$(
        impl<'de> Deserialize<'de> for $name {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                let text = Cow::<str>::deserialize(deserializer)?;
                Self::deserialize(StrDeserializer::new(&text))
            }
        }

        impl Serialize for $name {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                Self::serialize(self, serializer)
            }
        }
    )+};
}

read_as_string!(AntiWindup, Axis, Method, Solver, Side, WrenchConvention, WrenchFrame, LimitKind);

/// One axis of a twist or a wrench, in the frame of the task.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case", remote = "Self")]
pub enum Axis {
    /// Along x: velocity in m/s, force in N.
    X,
    /// Along y: velocity in m/s, force in N.
    Y,
    /// Along z: velocity in m/s, force in N.
    Z,
    /// About x: angular velocity in rad/s, torque in N·m.
    Rx,
    /// About y: angular velocity in rad/s, torque in N·m.
    Ry,
    /// About z: angular velocity in rad/s, torque in N·m.
    Rz,
}

impl Axis {
    /// All axes.
    pub const ALL: [Self; 6] = [Self::X, Self::Y, Self::Z, Self::Rx, Self::Ry, Self::Rz];
}

/// The resolution method, the meaning of priorities.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case", remote = "Self")]
pub enum Method {
    /// Pseudo-inverse of all tasks in one stack, without damping and without priorities.
    Pseudoinverse,
    /// Damped least squares over all tasks in one stack, without priorities.
    DampedLeastSquares,
    /// Classical task priority with null-space projectors.
    TaskPriority,
    /// Singularity-robust task priority: lower tasks are projected into the null space of higher tasks.
    SingularityRobust,
    /// Reverse priority of the paper: tasks are added from the lowest to the highest. It keeps the order of two tasks; from
    /// three tasks on, a lower one can disturb a higher one.
    ReversePriority,
    /// Reverse priority, strict for any number of tasks (the lexicographic hierarchy); default.
    #[default]
    StrictReversePriority,
}

impl Method {
    /// All methods.
    pub const ALL: [Self; 6] = [
        Self::Pseudoinverse,
        Self::DampedLeastSquares,
        Self::TaskPriority,
        Self::SingularityRobust,
        Self::ReversePriority,
        Self::StrictReversePriority,
    ];
}

/// The solver of the problem.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case", remote = "Self")]
pub enum Solver {
    /// Pseudo-inverses. Do not use it on a real arm. It ignores limits.
    ClosedForm,
    /// The answer of the quadratic-program solver Clarabel at every level, to compare with.
    Qp,
    /// The hierarchical solver, which knows limits and is the fastest one; default.
    #[default]
    Auto,
}

impl Solver {
    /// All solvers.
    pub const ALL: [Self; 3] = [Self::ClosedForm, Self::Qp, Self::Auto];
}

/// The solver path that found an answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Path {
    /// Pseudo-inverses.
    ClosedForm,
    /// Active sets, starting from the last one, until one is certified.
    ActiveSet,
    /// Clarabel at every level: its answer or its polish, whichever is more accurate.
    Qp,
}

/// The status of an answer: whether it is certified optimal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// The optimality conditions hold. With `closed_form` they are those without limits: see `violated_limits`.
    Optimal,
    /// The command is inside the limits, but may not be optimal.
    NotCertified,
    /// No answer was found. The command is the slowest one inside the limits.
    Failed,
}

/// The side of a bound.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case", remote = "Self")]
pub enum Side {
    /// The lower bound.
    Lower,
    /// The upper bound.
    Upper,
}

/// The kind of motion of a joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum JointKind {
    /// Rotation, position in rad.
    Revolute,
    /// Translation, position in m.
    Prismatic,
}

/// The sign convention of a wrench: who exerts it on whom.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case", remote = "Self")]
pub enum WrenchConvention {
    /// The wrench of the tool on the environment; default. Pressing on a wall at +x gives a positive x force.
    #[default]
    OnEnvironment,
    /// The wrench of the environment on the tool, as most wrist sensors measure it.
    OnTool,
}

/// The axes of the wrench in a state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case", remote = "Self")]
pub enum WrenchFrame {
    /// The axes of the base; default.
    #[default]
    Base,
    /// The axes of the tool, or of the sensor if the controller has a `wrench_sensor`.
    Tool,
}

/// When the integrators of `force`, `impedance` and `hybrid` follow the achieved velocity instead of the requested one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case", remote = "Self")]
pub enum AntiWindup {
    /// On every axis that does not follow its request, whatever holds it back: limits, other tasks or damping; default.
    #[default]
    Always,
    /// As `always`, but not if damping alone holds the axis back, like the laws of the paper. Near a singularity, a damped
    /// task then winds up. Do not use it on a real arm.
    ExceptDamping,
}

/// Damping near singularities: λ² = (1 − (σ_min/δ)²) λ_max² for σ_min < δ, otherwise 0.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Damping {
    /// Threshold δ > 0: damping acts if the smallest singular value is below it. A larger one begins farther from the
    /// singularity.
    pub threshold: f64,
    /// Maximum damping factor λ_max ≥ 0, reached at a singular value of zero. A larger one moves the joints more slowly
    /// there.
    pub max_factor: f64,
}

impl Damping {
    /// The default of a controller, for arms with a reach of about 1 m.
    pub const ARM: Self = Self { threshold: 0.15, max_factor: 0.15 };
}

/// The limits of the robot that apply.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case", remote = "Self")]
pub enum LimitKind {
    /// No limits.
    None,
    /// Speed limits.
    Velocity,
    /// Speed and position limits.
    PositionVelocity,
    /// Speed, position, acceleration and, in controllers, jerk limits: the joint can always stop before its position limit.
    PositionVelocityAcceleration,
}

impl LimitKind {
    /// Returns whether the speed limits apply.
    pub fn includes_velocity(self) -> bool {
        self != Self::None
    }

    /// Returns whether the position limits apply.
    pub fn includes_position(self) -> bool {
        matches!(self, Self::PositionVelocity | Self::PositionVelocityAcceleration)
    }

    /// Returns whether the acceleration limits apply.
    pub fn includes_acceleration(self) -> bool {
        self == Self::PositionVelocityAcceleration
    }
}

/// The limits of the joint velocities: limits of the robot by name, or bounds of the velocities.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
#[serde(untagged)]
pub enum Limits {
    /// Limits of the robot.
    Robot(LimitKind),
    /// Bounds lower ≤ q̇ ≤ upper.
    Box {
        /// Lower bounds, one per joint, rad/s or m/s; usually negative.
        lower: Vec<f64>,
        /// Upper bounds, one per joint, rad/s or m/s.
        upper: Vec<f64>,
    },
}

impl<'de> Deserialize<'de> for Limits {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        string_or_map::deserialize(deserializer)
    }
}

impl StringOrMap for Limits {
    const EXPECTED: &'static str = "the name of a limit set or an object with `lower` and `upper`";

    fn from_string<E: serde::de::Error>(name: &str) -> Result<Self, E> {
        LimitKind::deserialize(StrDeserializer::new(name)).map(Self::Robot)
    }

    fn from_map<'de, A: MapAccess<'de>>(map: A) -> Result<Self, A::Error> {
        #[derive(Deserialize)]
        #[serde(deny_unknown_fields)]
        struct Bounds {
            lower: Vec<f64>,
            upper: Vec<f64>,
        }
        let Bounds { lower, upper } = Bounds::deserialize(MapAccessDeserializer::new(map))?;
        Ok(Self::Box { lower, upper })
    }
}
