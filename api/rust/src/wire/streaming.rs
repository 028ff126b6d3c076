//! Streamed targets: targets that come with the states, as in teleoperation.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::object;
use super::{JointVector, Orientation, PerAxis, Pose};

/// How a task follows streamed targets. The defaults suit 30 to 90 targets per second.
///
/// The age of a target is the time of the state minus `time_s` of the target minus `delay_s`.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Streaming {
    /// Age of the newest target up to which it is extrapolated, s; after it the target is held; default 0.05.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hold_after_s: Option<f64>,
    /// Age of the newest target from which the task brakes to rest, s; at least `hold_after_s`; default 0.2.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub brake_after_s: Option<f64>,
    /// Delay with which targets are followed, s; default 0. A delay of one interval between targets makes the task
    /// interpolate instead of extrapolate.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub delay_s: Option<f64>,
    /// Time constant with which the task follows noise and jumps of the targets, s; default 0.03; 0: no smoothing. A
    /// uniform motion is followed without lag.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub smoothing_s: Option<f64>,
    /// Time in which the offset between a new chunk of actions and the motion before it fades, s; default 0.3; longer if it would need more
    /// than half of `max_acceleration`. 0: the task follows the new chunk as fast as `max_velocity` and `max_acceleration` allow.
    #[schema(example = 0.3)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fade_s: Option<f64>,
    /// Maximum velocity of the target per row, m/s and rad/s; default: 1 m/s and 3 rad/s, for joints their velocity
    /// limits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_velocity: Option<PerAxis<f64>>,
    /// Maximum acceleration of the target per row, m/s² and rad/s²; default: 5 m/s² and 10 rad/s², for joints their
    /// acceleration limits. The task brakes with it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_acceleration: Option<PerAxis<f64>>,
}

/// One target of a task. The law of the task decides which fields it has.
///
/// The laws `pose` and `impedance` accept `pose`, `posture` accepts `joint_position`, `velocity` accepts `velocity`,
/// `force` and `contact` accept `force`, and `hybrid` accepts `pose`, `force` or both. A `pose` or a `joint_position` can have its
/// `velocity`.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields, default)]
pub struct StreamedTarget {
    /// Time of the target on the clock of the states, s; default: the time of the state; at most 1 s after it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time_s: Option<f64>,
    /// Target pose. It replaces `target_pose` and `target_displacement` of the law.
    #[serde(deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub pose: Option<StreamedPose>,
    /// Target positions of the joints of the task, in their order or by name, rad or m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub joint_position: Option<JointVector>,
    /// Target velocity per row, m/s and rad/s; of a `pose`: along the axes of the task's frame, for the frame `tool` those
    /// of the target. Default for a `pose` or a `joint_position`: estimated from the last targets.
    #[schema(example = json!([0.1, 0.0, -0.05]))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub velocity: Option<Vec<f64>>,
    /// Target force F_d per row, N and N·m.
    #[schema(example = json!([15.0]))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub force: Option<Vec<f64>>,
    /// Where a `pose` or a `joint_position` will be in the next seconds, in the order of time; default: unknown. Laws with `path` use it.
    #[serde(deserialize_with = "object::list", skip_serializing_if = "Vec::is_empty")]
    pub ahead: Vec<TargetAhead>,
    /// Actions of the next seconds, as a policy computes them at once, in place of the other fields: 1 to 256 of one kind, in the order of
    /// their times. The task follows a smooth curve through them. A chunk replaces the actions of earlier ones from its first time on;
    /// the offset to the motion before it fades in `fade_s`.
    #[schema(example = json!([{"time_s": 1.0, "position": [0.6, 0.1, 0.4]}, {"time_s": 1.033, "position": [0.6, 0.11, 0.4]}]))]
    #[serde(deserialize_with = "object::optional_list", skip_serializing_if = "Option::is_none")]
    pub chunk: Option<Vec<ChunkAction>>,
    /// Which actions of a `chunk` that comes late are past; default `time`.
    #[schema(example = "progress")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub align: Option<ChunkAlign>,
}

/// An action of a chunk: a target with the time at which it is due. Position and orientation are those of a `pose`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ChunkAction {
    /// Time on the clock of the states, s; later than that of the action before it by at least 1 µs, and at most 10 s after the state.
    #[schema(example = 1.033)]
    pub time_s: f64,
    /// Target pose, in place of `position` and `orientation`.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub pose: Option<StreamedPose>,
    /// Target position x, y, z, m; required if the task has a linear axis.
    #[schema(example = json!([0.6, 0.1, 0.4]))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position: Option<[f64; 3]>,
    /// Target orientation, unit quaternion; required if the task has an angular axis.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub orientation: Option<Orientation>,
    /// Target positions of the joints of the task, in their order or by name, rad or m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub joint_position: Option<JointVector>,
    /// Target velocity of a task with the law `velocity`, per row, m/s and rad/s.
    #[schema(example = json!([0.1, 0.0, -0.05]))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub velocity: Option<Vec<f64>>,
    /// Target force F_d per row, N and N·m.
    #[schema(example = json!([15.0]))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub force: Option<Vec<f64>>,
    /// Target of the channel `gripper` of the controller, due with the action.
    #[schema(example = 0.02)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gripper: Option<f64>,
    /// Targets of channels of the controller by name, due with the action; default: none.
    #[schema(example = json!({"suction": 1.0}))]
    #[serde(default, deserialize_with = "object::numbers", skip_serializing_if = "BTreeMap::is_empty")]
    pub channels: BTreeMap<String, f64>,
}

/// Which actions of a chunk that comes late are past.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum ChunkAlign {
    /// Those before the time of the state.
    #[default]
    Time,
    /// Those before the place that the arm has reached, of the places that are due until now. The rest of the chunk is moved in time to
    /// begin there. For forces and velocities: as `time`.
    Progress,
}

/// The chunk that a task follows.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ChunkStatus {
    /// Number of actions to come.
    #[schema(example = 38)]
    pub actions_left: usize,
    /// Time until the last action, s; negative after it.
    #[schema(example = 1.25)]
    pub ends_in_s: f64,
    /// Number of actions of a chunk of this state that were past; absent if none came or it was ignored.
    #[schema(example = 12)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dropped: Option<usize>,
    /// Time by which the actions of a chunk of this state were moved, s; absent if none came or it was ignored.
    #[schema(example = 0.0)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shift_s: Option<f64>,
}

/// A target of a later time. It has the same fields as the target with which it comes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct TargetAhead {
    /// Time after `time_s` of the target, s; at least 1 µs after the one before it, at most 2.
    #[schema(example = 0.1)]
    pub after_s: f64,
    /// Target pose at that time.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub pose: Option<StreamedPose>,
    /// Target positions of the joints of the task at that time, in their order or by name, rad or m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub joint_position: Option<JointVector>,
}

/// A target pose of the reference point, in the task's frame if that is a pose, otherwise in the base frame.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields, default)]
pub struct StreamedPose {
    /// Position x, y, z, m; required if the task has a linear axis.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(example = json!([0.6, 0.1, 0.5]))]
    pub position: Option<[f64; 3]>,
    /// Orientation, unit quaternion; required if the task has an angular axis.
    #[serde(deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub orientation: Option<Orientation>,
}

/// Where the streamed target of a period comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum TargetState {
    /// The newest target is not in the past: the task follows the line between the last two targets.
    Following,
    /// The newest target is extrapolated.
    Extrapolating,
    /// The newest target is too old to be extrapolated: the task holds it.
    Holding,
    /// No target came for too long: the task brakes to rest, and stays there.
    Braking,
}

/// What the targets of a stream are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum StreamedQuantity {
    /// The pose of the reference point.
    Pose,
    /// The positions of the joints of the task.
    JointPosition,
    /// The velocity of the task.
    Velocity,
    /// The force of the task.
    Force,
}

/// The last targets of a task, as a part of the memory.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct TargetStream {
    /// Name of the task.
    pub task: String,
    /// What the targets are.
    pub quantity: StreamedQuantity,
    /// The newest target.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub newest: Option<TargetSample>,
    /// The target before it.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub previous: Option<TargetSample>,
    /// Targets of later times that came with the newest one; default: none.
    #[serde(default, deserialize_with = "object::list", skip_serializing_if = "Vec::is_empty")]
    pub ahead: Vec<LaterTarget>,
    /// The chunks that the task follows; default: none came.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub chunk: Option<ChunkMemory>,
    /// The target that the law followed in the last period, with its velocity.
    #[serde(deserialize_with = "object::deserialize")]
    pub reference: TargetReference,
    /// State of the last period.
    pub state: TargetState,
}

/// The chunks that a task follows, in the memory.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ChunkMemory {
    /// Time of the first action of the newest chunk, as it was sent, s.
    #[schema(example = 0.9)]
    pub first_s: f64,
    /// Time of the state with which it came, s.
    #[schema(example = 1.4)]
    pub merged_s: f64,
    /// The actions that still count, at the times at which they are due; default: none.
    #[serde(default, deserialize_with = "object::list", skip_serializing_if = "Vec::is_empty")]
    pub actions: Vec<LaterTarget>,
    /// What is left of the motion before the newest chunk; default: nothing.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub fade: Option<Fade>,
}

/// An offset that fades, in the memory: of a pose linear and angular in base axes, otherwise per row.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Fade {
    /// Time at which it began, s.
    #[schema(example = 1.4)]
    pub start_s: f64,
    /// Time that it takes, s.
    #[schema(example = 0.3)]
    pub duration_s: f64,
    /// Offset at the start.
    #[schema(example = json!([0.02, 0.0, 0.0, 0.0, 0.0, 0.0]))]
    pub offset: Vec<f64>,
    /// Rate of the offset at the start, per second.
    #[schema(example = json!([0.1, 0.0, 0.0, 0.0, 0.0, 0.0]))]
    pub rate: Vec<f64>,
    /// Second derivative of the offset at the start, per second².
    #[schema(example = json!([0.0, 0.0, 0.0, 0.0, 0.0, 0.0]))]
    pub acceleration: Vec<f64>,
}

/// A target of a later time in the memory.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct LaterTarget {
    /// Time of the target, s.
    pub time_s: f64,
    /// Pose in the base frame, m.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub pose: Option<Pose>,
    /// Values per row, if the target is not a pose.
    #[schema(example = json!([0.3, -0.4]))]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub values: Option<Vec<f64>>,
}

/// A target in the memory.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct TargetSample {
    /// Time of the target, s.
    pub time_s: f64,
    /// Pose in the base frame, m.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub pose: Option<Pose>,
    /// Values per row, if the target is not a pose.
    #[schema(example = json!([15.0]))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub values: Option<Vec<f64>>,
    /// Given or estimated velocity: of a pose linear and angular in base axes, otherwise per row.
    #[schema(example = json!([0.1, 0.0, -0.05, 0.0, 0.0, 0.0]))]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub velocity: Option<Vec<f64>>,
}

/// The target that a law followed, in the memory.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct TargetReference {
    /// Pose in the base frame, m.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub pose: Option<Pose>,
    /// Values per row, if the target is not a pose.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(example = json!([15.0]))]
    pub values: Option<Vec<f64>>,
    /// Velocity: of a pose linear and angular in base axes, otherwise per row.
    pub velocity: Vec<f64>,
}

#[cfg(test)]
mod tests {
    use crate::wire::State;

    fn state(targets: &str) -> Result<State, String> {
        let text = format!(r#"{{"sequence": 0, "time_s": 0, "joint_position": [], "targets": {targets}}}"#);
        serde_json::from_str(&text).map_err(|error| error.to_string())
    }

    #[test]
    fn targets_are_read_by_task_name_and_written_back() {
        let text = r#"{"a":{"velocity":[0.5]},"b":{"time_s":1.5,"pose":{"position":[1.0,2.0,3.0]}}}"#;
        let read = state(text).unwrap();
        assert_eq!(serde_json::to_string(&read.targets).unwrap(), text);
        let none = state("{}").unwrap();
        assert!(!serde_json::to_string(&none).unwrap().contains("targets"));
    }

    #[test]
    fn a_repeated_task_and_other_types_are_refused() {
        assert!(state(r#"{"a": {"force": [1]}, "a": {"force": [2]}}"#).unwrap_err().contains("given twice"));
        assert!(state(r#"{"a": [1]}"#).is_err());
        assert!(state("[]").unwrap_err().contains("an object"));
    }
}
