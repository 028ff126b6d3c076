//! The words that requests and answers choose from.

use std::borrow::Cow;
use std::fmt;

use serde::de::{MapAccess, value::MapAccessDeserializer, value::StrDeserializer};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use utoipa::ToSchema;

use super::string_or_map::{self, StringOrMap};

/// Writes a word as it stands in JSON.
macro_rules! display_as_in_json {
    ($($word:ty),+) => {$(
        impl fmt::Display for $word {
            fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
                self.serialize(formatter)
            }
        }
    )+};
}

display_as_in_json!(Axis, Method, Solver, Path, Status, Side, LimitKind);

/// Reads a word from a text alone: for an enum, serde also takes `{"word": null}`, and in MessagePack the word's number.
macro_rules! read_as_text {
    ($($word:ty),+) => {$(
        impl<'de> Deserialize<'de> for $word {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                let text = Cow::<str>::deserialize(deserializer)?;
                Self::deserialize(StrDeserializer::new(&text))
            }
        }

        impl Serialize for $word {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                Self::serialize(self, serializer)
            }
        }
    )+};
}

read_as_text!(Axis, Method, Solver, Side, WrenchConvention, WrenchFrame, LimitKind);

/// One row of a twist, at the point and along the axes of its task.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case", remote = "Self")]
pub enum Axis {
    /// Along x, m/s.
    X,
    /// Along y, m/s.
    Y,
    /// Along z, m/s.
    Z,
    /// About x, rad/s.
    Rx,
    /// About y, rad/s.
    Ry,
    /// About z, rad/s.
    Rz,
}

/// How priorities are understood.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case", remote = "Self")]
pub enum Method {
    /// All tasks as one stack, exact.
    Pseudoinverse,
    /// All tasks as one stack, damped near singularities.
    DampedLeastSquares,
    /// Classical task priority.
    TaskPriority,
    /// Lower tasks first, each higher one corrects in its own row space alone.
    SingularityRobust,
    /// Tasks added from the lowest to the highest.
    #[default]
    ReversePriority,
    /// The lexicographic hierarchy.
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

/// How the problem is solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case", remote = "Self")]
pub enum Solver {
    /// Pseudo-inverses, limits ignored.
    ClosedForm,
    /// Clarabel at every level.
    Qp,
    /// The answer of `qp` by the shortest certified way.
    #[default]
    Auto,
}

impl Solver {
    /// All solvers.
    pub const ALL: [Self; 3] = [Self::ClosedForm, Self::Qp, Self::Auto];
}

/// Which way led to an answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Path {
    /// Pseudo-inverses.
    ClosedForm,
    /// Active sets that start from the last one, until one is confirmed.
    ActiveSet,
    /// Clarabel, polished.
    Qp,
}

/// How sure an answer is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// The optimality conditions hold; those of a problem without limits if the solver is `closed_form`, which may break
    /// them: see `violated_limits`.
    Optimal,
    /// The command is inside the limits, but may not be the best one.
    NotCertified,
    /// Nothing was found; the command is the slowest one inside the limits.
    Failed,
}

/// A bound of a joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case", remote = "Self")]
pub enum Side {
    /// The lower bound.
    Lower,
    /// The upper bound.
    Upper,
}

/// How a joint moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum JointKind {
    /// Rotation, rad.
    Revolute,
    /// Translation, m.
    Prismatic,
}

/// Whose wrench a state carries.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case", remote = "Self")]
pub enum WrenchConvention {
    /// What the tool exerts on the environment.
    #[default]
    OnEnvironment,
    /// What the environment exerts on the tool.
    OnTool,
}

/// Along which axes a state carries its wrench.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case", remote = "Self")]
pub enum WrenchFrame {
    /// The axes of the base.
    #[default]
    Base,
    /// The axes of the tool, as a wrist sensor gives it.
    Tool,
}

/// Damping that sets in near a singularity.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Damping {
    /// δ > 0, the smallest singular value below which damping acts.
    pub threshold: f64,
    /// λ_max ≥ 0, the factor at a singular value of zero.
    pub max_factor: f64,
}

/// Which of the robot's limits count.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case", remote = "Self")]
pub enum LimitKind {
    /// None.
    None,
    /// Speed.
    Velocity,
    /// Speed and remaining way.
    PositionVelocity,
    /// Speed, acceleration and braking distance.
    PositionVelocityAcceleration,
}

/// The robot's own limits by name, or a box of joint velocities.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
#[serde(untagged)]
pub enum Limits {
    /// The robot's own.
    Robot(LimitKind),
    /// lower ≤ q̇ ≤ upper, rad/s or m/s.
    Box {
        /// Lower bounds, n.
        lower: Vec<f64>,
        /// Upper bounds, n.
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
