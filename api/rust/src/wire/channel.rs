//! Channels besides the joints, such as a gripper.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{Profile, object};

/// A channel besides the joints, such as a gripper: one number that passes through the controller with its timing, within a range and a
/// rate. It never moves the arm.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Channel {
    /// Name, unique in the controller. States, actions and answers use it.
    #[schema(example = "gripper")]
    pub name: String,
    /// What the number is.
    pub kind: ChannelKind,
    /// Smallest command: m or rad for a position, N or N·m for a force.
    #[schema(example = 0.0)]
    pub lower: f64,
    /// Largest command.
    #[schema(example = 0.08)]
    pub upper: f64,
    /// Largest change of the command, per second. A `PUT` with a range that does not hold the command moves it into the range at once.
    #[schema(example = 0.2)]
    pub max_rate: f64,
    /// Target over time until a state brings another one, one row; default: the channel has no command before its first target.
    /// A `PUT` that changes it replaces the targets of states.
    #[schema(example = json!({"kind": "constant", "value": 0.04}))]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub target: Option<Profile>,
}

/// What the number of a channel is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum ChannelKind {
    /// A position, such as the opening of a gripper, m or rad.
    Position,
    /// A force, such as that of a grip, N or N·m.
    Force,
}

/// What a state brings for a channel.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ChannelInput {
    /// Target from now on, in place of all that came before; default: as before.
    #[schema(example = 0.02)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub target: Option<f64>,
    /// Measured number, from which the first command starts; default: the first command is the first target.
    #[schema(example = 0.08)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub measured: Option<f64>,
}

/// A channel in the memory.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ChannelMemory {
    /// Name of the channel.
    #[schema(example = "gripper")]
    pub channel: String,
    /// Last command; default: none was given.
    #[schema(example = 0.031)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub command: Option<f64>,
    /// Targets that still count; default: none.
    #[serde(default, deserialize_with = "object::list", skip_serializing_if = "Vec::is_empty")]
    pub targets: Vec<ChannelTarget>,
}

/// A target of a channel in the memory.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ChannelTarget {
    /// Time at which it is due, s.
    #[schema(example = 1.2)]
    pub time_s: f64,
    /// The number.
    #[schema(example = 0.02)]
    pub value: f64,
}
