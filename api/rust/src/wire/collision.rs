//! Shapes of robots and of the room, and how arms keep clear of them.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::{Pose, defaults, object};

/// What an arm keeps clear of. It is no safety function: it trusts the shapes, the drive and the measured positions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Collisions {
    /// Distance that shapes keep, m. Set it to what measurement and shapes may be wrong by; default 0.01.
    #[serde(default = "default_distance")]
    pub min_distance_m: f64,
    /// Maximum rate at which a distance shrinks to `min_distance_m`, 1/s. A smaller one slows the arm earlier; default 10.
    #[serde(default = "default_rate")]
    pub rate_per_s: f64,
    /// Whether the links keep clear of each other; default `true`.
    #[serde(default = "defaults::yes", skip_serializing_if = "defaults::is_yes")]
    pub own_links: bool,
    /// Shapes of the room; default: none.
    #[serde(default, deserialize_with = "object::list", skip_serializing_if = "Vec::is_empty")]
    pub obstacles: Vec<RoomObstacle>,
}

fn default_distance() -> f64 {
    0.01
}

fn default_rate() -> f64 {
    10.0
}

/// A shape of the room: one of `sphere`, `capsule`, `box`, `half_space`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct RoomObstacle {
    /// Name, unique among the obstacles.
    pub name: String,
    /// A sphere.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub sphere: Option<Sphere>,
    /// A capsule.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub capsule: Option<Capsule>,
    /// A box.
    #[serde(rename = "box", default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub cuboid: Option<Cuboid>,
    /// All that is behind a plane, such as the floor.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub half_space: Option<HalfSpace>,
    /// Whether each state says where it is; default `false`: it stands where it is.
    #[serde(default, skip_serializing_if = "defaults::is_no")]
    pub moves: bool,
}

/// All points within a radius of a centre.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Sphere {
    /// Centre, m; of an obstacle in the base frame, of a link in its frame; default: the origin.
    #[serde(default)]
    pub center: [f64; 3],
    /// Radius, m.
    pub radius: f64,
}

/// All points within a radius of a segment.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Capsule {
    /// One end of the segment, m; of an obstacle in the base frame, of a link in its frame.
    pub start: [f64; 3],
    /// The other end, m.
    pub end: [f64; 3],
    /// Radius, m.
    pub radius: f64,
}

/// A box.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Cuboid {
    /// Lengths of its edges along its own axes, m.
    pub size: [f64; 3],
    /// Pose of its middle in the base frame, m.
    #[serde(deserialize_with = "object::deserialize")]
    pub pose: Pose,
}

/// All points x with n·x ≤ offset.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct HalfSpace {
    /// Normal n in the base frame, towards the free side, of any length but zero.
    pub normal: [f64; 3],
    /// Distance of the surface from the base origin along n, m.
    pub offset_m: f64,
}

/// A capsule or a sphere that covers a link, or a part of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct LinkShape {
    /// Link that carries it.
    pub link: String,
    /// Link of the robot's text that it covers, if that is no link of the robot and fixed joints connect it with `link`: a hand beyond the
    /// tip. The SRDF text names it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(example = "panda_hand")]
    pub body: Option<String>,
    /// A capsule; either this or `sphere`.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub capsule: Option<Capsule>,
    /// A sphere; either this or `capsule`.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub sphere: Option<Sphere>,
}

/// From where a robot has its shapes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum ShapeSource {
    /// From the `<collision>` elements of its text. Meshes are files, which a request does not have: `revprio robots fit` reads them.
    Fit,
}

/// Pairs of links of which nothing is watched.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct CollisionPairs {
    /// Pairs of links that may touch, besides neighbours and those that touch in every posture.
    #[schema(example = json!([["panda_link5", "panda_link7"]]))]
    #[serde(default)]
    pub leave_out: Vec<[String; 2]>,
}

/// The shapes of a robot and the pairs that are watched.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct RobotShapes {
    /// Shapes.
    pub shape_list: Vec<LinkShape>,
    /// Number of pairs of shapes that keep clear of each other.
    pub watched_pairs: usize,
    /// Pairs of links that are not watched, with the reasons.
    pub left_out: Vec<LeftOutPair>,
    /// Links of the text that have a form which no shape covers: fingers beyond the tip of an arm, or links without `<collision>`. Nothing
    /// keeps them clear. Known for `shapes` only.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schema(example = json!(["left_finger"]))]
    pub uncovered_links: Vec<String>,
}

/// A pair of links that is not watched.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct LeftOutPair {
    /// The links.
    pub links: [String; 2],
    /// `neighbours`, `always_touch`, `stated`, or the reason in the SRDF text.
    #[schema(example = "neighbours")]
    pub reason: String,
}

/// Where a moving obstacle is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ObstacleState {
    /// Name of the obstacle.
    pub name: String,
    /// Position of its middle in the base frame, m.
    pub position: [f64; 3],
    /// Its velocity, m/s; default: it stands.
    #[schema(example = json!([0.0, 0.1, 0.0]))]
    #[serde(default)]
    pub velocity: [f64; 3],
}

/// Distances of the shapes and how they restrict the joint velocities.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct CollisionReport {
    /// Distance of the nearest pair, m; absent: no pair is watched.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub least_distance_m: Option<f64>,
    /// The nearest pairs, at most eight, the nearest first.
    pub pairs: Vec<PairDistance>,
    /// How many rows could matter to the solver, and how many it got.
    pub rows: CollisionRows,
    /// Share of the allowed joint velocities, around full braking, among which the answer was found: 1 usually; less if the stop after
    /// the first answer would have come too near; 0: the joint velocities are those of full braking.
    pub share: f64,
    /// Time that the arm needs to stop behind its drive, s; 0: it stands.
    pub stop_in_s: f64,
    /// Whether the stop, or that of a watchdog after `valid_for_ms`, comes nearer than `min_distance_m` all the same: the arm was nearer
    /// before, an obstacle comes, the bound between two samples is too rough, or the jerk limits permit nothing else.
    pub violated: bool,
}

/// Distance of one pair.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct PairDistance {
    /// Name of the link.
    pub a: String,
    /// Name of the other link, or of the obstacle.
    pub b: String,
    /// Distance, m; negative: how far the shapes intersect.
    pub distance_m: f64,
    /// The nearest points on both surfaces in the base frame, m.
    pub points: [[f64; 3]; 2],
}

/// Numbers of rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct CollisionRows {
    /// Rows that could matter.
    pub made: usize,
    /// Rows that the solver got.
    pub left: usize,
}
