//! Robots: `GET /v1/robots`, `POST /v1/robots`.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{CollisionPairs, JointKind, LinkShape, Pose, RobotShapes, ShapeSource, object};

/// Answer to `GET /v1/robots`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct RobotList {
    /// Robots that requests can name.
    pub robots: Vec<Robot>,
}

/// `POST /v1/robots`: registers the chain of a URDF text from one link to another.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct RobotRegistration {
    /// Name for requests: at most 64 letters, digits, `_`, `-` and `.`.
    pub name: String,
    /// URDF text, `<robot …>`.
    pub urdf: String,
    /// Base link; default: the root of the tree.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub base: Option<String>,
    /// Link of the tool frame; default: the end of the only chain or of the only arm, without gripper.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tip: Option<String>,
    /// Tips of a robot with several arms, first the tool; then the robot is all that is below the base. Set it for two arms, a torso or a
    /// mobile base; instead of `tip`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tips: Option<Vec<RegisteredTip>>,
    /// Limits that replace or complete those of the text, by the name of the joint in the text.
    #[serde(default, deserialize_with = "object::optional_map", skip_serializing_if = "Option::is_none")]
    pub limits: Option<BTreeMap<String, StatedLimits>>,
    /// New names, by the name of the joint in the text.
    #[serde(default, deserialize_with = "object::optional_texts", skip_serializing_if = "Option::is_none")]
    pub joint_names: Option<BTreeMap<String, String>>,
    /// Pose of the tool frame in the frame of the tip, m; default: the frame of the tip.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tool_offset: Option<Pose>,
    /// SRDF text, the semantic description that belongs to the URDF text. Its `<disable_collisions>` pairs are not watched. If neither `tip`
    /// nor `tips` is given, the links of its `<end_effector>` elements are the tips: several make a robot with several arms.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(example = "<robot name='arm'><disable_collisions link1='base' link2='tool' reason='Never'/></robot>")]
    pub srdf: Option<String>,
    /// `fit`: capsules that contain the `<collision>` elements of the text cover the links. Links of `shape_list` have those instead.
    /// Default: only `shape_list` counts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shapes: Option<ShapeSource>,
    /// Shapes that cover the links, so that controllers can keep clear; default: none.
    #[serde(default, deserialize_with = "object::optional_list", skip_serializing_if = "Option::is_none")]
    pub shape_list: Option<Vec<LinkShape>>,
    /// Pairs of links of which nothing is watched.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub collision_pairs: Option<CollisionPairs>,
}

/// A frame on a link that tasks can name, such as a tool.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct RegisteredTip {
    /// Name for the `link` and `relative_to` of tasks, unique among the tips.
    pub name: String,
    /// Link of the text that carries it.
    pub link: String,
    /// Pose in the frame of the link, m; default: the frame of the link.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub offset: Option<Pose>,
}

/// Limits of one joint; a limit that is not given is read from the text.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct StatedLimits {
    /// Minimum and maximum position, rad or m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position: Option<[f64; 2]>,
    /// Maximum speed, rad/s or m/s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub velocity: Option<f64>,
    /// Maximum acceleration, rad/s² or m/s².
    #[serde(skip_serializing_if = "Option::is_none")]
    pub acceleration: Option<f64>,
    /// Maximum jerk, rad/s³ or m/s³.
    #[schema(example = 7500.0)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub jerk: Option<f64>,
    /// Maximum speed near the ends of the range.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub velocity_envelope: Option<VelocityEnvelope>,
}

/// Maximum speed towards an end of the position range, which shrinks with the distance d from that end: max(0, √(2 D d) − o).
///
/// Controllers whose limits include positions keep it. The joint comes no nearer to an end than o²/2D. In a URDF text it is the element
/// `<position_based_velocity_limits>` of a joint, with attributes of these names.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct VelocityEnvelope {
    /// D, rad/s² or m/s².
    #[schema(example = 6.0)]
    pub deceleration_limit: f64,
    /// o, rad/s or m/s.
    #[schema(example = 0.3)]
    pub velocity_offset: f64,
}

/// The format that described a robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum RobotSource {
    /// One Denavit-Hartenberg row per joint.
    DenavitHartenberg,
    /// A URDF text.
    Urdf,
}

/// A robot arm.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Robot {
    /// Name for requests.
    pub name: String,
    /// Description, one line of text.
    pub description: String,
    /// Format that described the robot.
    pub source: RobotSource,
    /// Joints, base first; the order of all vectors of joints.
    pub joints: Vec<RobotJoint>,
    /// Tips, first the tool. Tasks name them as `link` and `relative_to`.
    #[serde(default)]
    pub tips: Vec<RobotTip>,
    /// Names of the links, base first. Tasks can name them too.
    #[serde(default)]
    pub links: Vec<String>,
    /// Shapes and watched pairs; absent: the robot has no shapes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shapes: Option<RobotShapes>,
    /// The chain of the URDF text that was taken for the arm; absent for Denavit-Hartenberg rows.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub chain: Option<RobotChain>,
}

/// A frame on a link.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct RobotTip {
    /// Name.
    pub name: String,
    /// Link that carries it.
    pub link: String,
}

/// The chain of a URDF text that is the arm.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct RobotChain {
    /// Link of the base frame.
    pub base: String,
    /// Link of the tool frame.
    pub tip: String,
    /// Why the chain ends there.
    pub reason: TipReason,
    /// Joints from base to tip, under the names that requests use.
    pub joints: Vec<String>,
    /// Moving joints of the text that are no part of the chain, at most the first 100.
    pub left_out: Vec<LeftOutJoint>,
}

/// Why a chain ends at its tip.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum TipReason {
    /// The request named the tip.
    Request,
    /// The chain has no other end.
    OnlyEnd,
    /// Behind the last joint of the arm, this link has the best name of a tool frame.
    ToolName,
    /// It is the last link before the gripper.
    BeforeGripper,
    /// It is the last link that the arm moves.
    LastLink,
}

/// A moving joint that is no part of the chain.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct LeftOutJoint {
    /// Name of the joint in the text.
    pub joint: String,
    /// Why it is left out.
    pub reason: LeftOutReason,
}

/// Why a joint is no part of the chain.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum LeftOutReason {
    /// It closes a gripper or bends a finger.
    Gripper,
    /// It turns a head.
    Head,
    /// It moves a leg or a wheel.
    LegOrWheel,
    /// It moves a sensor.
    Sensor,
    /// Its type cannot be a joint of an arm.
    Unsupported,
    /// It moves only what is behind the tip.
    BeyondTip,
    /// It is on another branch, for example of another arm.
    OtherBranch,
    /// It is not below the base.
    NotBelowBase,
}

/// A joint and its limits; a limit is `null` if there is none.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct RobotJoint {
    /// Name of the joint.
    pub name: String,
    /// Kind of motion.
    pub kind: JointKind,
    /// Unit of the position, `rad` or `m`; velocity, acceleration and jerk are per s, s² and s³.
    pub unit: String,
    /// Minimum and maximum position, rad or m.
    pub position_limit: Option<[f64; 2]>,
    /// Maximum speed, rad/s or m/s.
    pub velocity_limit: Option<f64>,
    /// Maximum acceleration, rad/s² or m/s².
    pub acceleration_limit: Option<f64>,
    /// Maximum jerk, rad/s³ or m/s³; omitted if there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(example = 7500.0)]
    pub jerk_limit: Option<f64>,
    /// Maximum speed near the ends of the range; omitted if it does not shrink there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub velocity_envelope: Option<VelocityEnvelope>,
    /// Position range in a publication, if it differs; for information only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub published_range: Option<[f64; 2]>,
    /// Standard Denavit-Hartenberg row, if the robot was described by one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub denavit_hartenberg: Option<DenavitHartenberg>,
}

/// A Denavit-Hartenberg row, Rot_z(θ) Trans_z(d) Trans_x(a) Rot_x(α); the joint position adds to θ (revolute) or d
/// (prismatic).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct DenavitHartenberg {
    /// Offset d along z, m.
    pub d_m: f64,
    /// Length a along x, m.
    pub a_m: f64,
    /// Twist α about x, rad.
    pub alpha_rad: f64,
    /// Angle θ at joint position zero, rad.
    pub theta_rad: f64,
}
