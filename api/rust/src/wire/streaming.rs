//! Streamed targets: targets that come with the states, as in teleoperation.

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
/// `force` accepts `force`, and `hybrid` accepts `pose`, `force` or both. A `pose` or a `joint_position` can have its
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
    /// The target that the law followed in the last period, with its velocity.
    #[serde(deserialize_with = "object::deserialize")]
    pub reference: TargetReference,
    /// State of the last period.
    pub state: TargetState,
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
