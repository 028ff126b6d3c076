//! Control laws.

#![expect(
    clippy::large_stack_arrays,
    reason = "the derived schema lists all kinds at once, when a document is written"
)]

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::string_or_map::string_or_object;
use super::{PerAxis, Profile, SurfaceFollowing, TargetPose};
use super::{defaults, object};

/// The law that computes the velocity of a task.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Law {
    /// A given velocity ẋ.
    Velocity {
        /// Task velocity ẋ, m/s and rad/s.
        #[serde(deserialize_with = "object::deserialize")]
        target_velocity: Profile,
    },
    /// Motion to a pose: ẋ = ẋ_d + f K (x_d − x). f is 1 near the target, and smaller where the joints could not brake.
    Pose {
        /// Gain K, 1/s: within 1/K seconds the distance to the target decreases to 37 %. 1 to 5 suits most arms.
        gain: PerAxis<f64>,
        /// Maximum acceleration with which the law brakes, m/s² and rad/s², in addition to the limits of the joints.
        /// Set it for a gentler stop; default: those limits alone.
        #[serde(skip_serializing_if = "Option::is_none")]
        max_acceleration: Option<PerAxis<f64>>,
        /// Whether the law brakes before its target; `false`: the bare gain, which may pass the target; default `true`.
        #[serde(default = "defaults::yes", skip_serializing_if = "defaults::is_yes")]
        braking: bool,
        /// Path on which the law looks ahead, for targets that move fast or jump far; default: the law does not look ahead.
        #[serde(skip_serializing_if = "Option::is_none")]
        path: Option<MotionPath>,
        /// Target pose X_d. Set it to move the tool there; default `initial`, which holds the pose of the first step.
        #[serde(default)]
        target_pose: TargetPose,
        /// Displacement added to X_d over time, m and rad (rotation vector), along the axes of the task's frame. Set it
        /// for a path that is known in advance; default: none.
        #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
        target_displacement: Option<Profile>,
    },
    /// Motion of joints to positions, q̇ = q̇_d + f K (q_d − q), or to the middle of their ranges, q̇ = −f K ∇H. f is 1 near
    /// the target, and smaller where the joint could not brake.
    Posture {
        /// Names of the joints that the task moves; default: all joints, for `mid_range` all joints with a range.
        #[serde(skip_serializing_if = "Option::is_none")]
        joints: Option<Vec<String>>,
        /// Gain K, one for all joints or one per joint, 1/s: within 1/K seconds the distance decreases to 37 %. For
        /// `mid_range` rad²/s or m²/s.
        gain: PerAxis<f64>,
        /// Maximum acceleration with which the law brakes, rad/s² or m/s², in addition to the limits of the joints. Set
        /// it for a gentler stop; default: those limits alone.
        #[serde(skip_serializing_if = "Option::is_none")]
        max_acceleration: Option<PerAxis<f64>>,
        /// Whether the law brakes before its target; `false`: the bare gain, which may pass the target; default `true`.
        #[serde(default = "defaults::yes", skip_serializing_if = "defaults::is_yes")]
        braking: bool,
        /// Path on which the law looks ahead, for targets that move fast or jump far; default: the law does not look ahead.
        #[serde(skip_serializing_if = "Option::is_none")]
        path: Option<MotionPath>,
        /// Target positions q_d, rad or m, or `mid_range`.
        target_position: PostureTarget,
    },
    /// Turning a direction of the tool, or of a link, towards a point, as a camera looks at a part: two rows, which reduce the angle at the
    /// rate f K. The task has no `axes`; its `link` looks from its `reference_point`.
    LookAt {
        /// Gain K, 1/s: within 1/K seconds the angle decreases to 37 %. 1 to 5 suits most arms.
        gain: f64,
        /// The point p over time, m, in the base frame or in that of `relative_to`.
        #[serde(deserialize_with = "object::deserialize")]
        target_point: Profile,
        /// The direction that looks, in the frame of the tool or of the link, of any length but zero; default: z.
        #[serde(default = "z_axis")]
        direction: [f64; 3],
        /// Maximum acceleration with which the law brakes, rad/s², in addition to the limits of the joints; default: those limits alone.
        #[serde(skip_serializing_if = "Option::is_none")]
        max_acceleration: Option<f64>,
        /// Whether the law brakes before its target; `false`: the bare gain, which may pass the target; default `true`.
        #[serde(default = "defaults::yes", skip_serializing_if = "defaults::is_yes")]
        braking: bool,
    },
    /// Pressing on a surface of unknown stiffness. The tool approaches the surface, presses with the target force and follows the
    /// surface. It needs no gains: the recommended law for contacts. Each axis of the task presses by itself.
    Contact {
        /// Target force F_d, N and N·m, along the axes of the task. Its sign is the direction in which the tool presses. A target below
        /// five times the noise is raised to it.
        #[serde(deserialize_with = "object::deserialize")]
        target_force: Profile,
        /// Speed at which the tool approaches the surface, and largest speed at which it presses, m/s and rad/s. A faster approach costs
        /// the peak force that the answer names; default: the largest that keeps the peak below 1.2 times the target force in the
        /// stiffest contact.
        #[serde(skip_serializing_if = "Option::is_none")]
        approach_speed: Option<PerAxis<f64>>,
        /// Stiffness of the stiffest contact that may come, N/m and N·m/rad, of tool, sensor, arm and surface in a row. Set it to
        /// approach faster; a contact that is stiffer may bounce; default 1e6 N/m and 1e4 N·m/rad.
        #[serde(skip_serializing_if = "Option::is_none")]
        stiffest: Option<PerAxis<f64>>,
        /// Noise of the measured force, rms, N and N·m; at most 10 N and 1 N·m; default 0.2 N and 0.02 N·m.
        #[serde(skip_serializing_if = "Option::is_none")]
        noise: Option<PerAxis<f64>>,
        /// Largest error of the measured force that stays, such as a bias after taring, N and N·m. Forces up to this error are no
        /// contact; at most 100 N and 10 N·m; default 0.
        #[serde(skip_serializing_if = "Option::is_none")]
        bias: Option<PerAxis<f64>>,
        /// Time constant of the filter of the force sensor, s; at most 1; default 0.002.
        #[serde(skip_serializing_if = "Option::is_none")]
        sensor_lag_s: Option<f64>,
        /// Force above which the tool retreats and stays away, N and N·m. The retreat comes before all other tasks, and after the limits
        /// of the joints. In an approach, the force that no axis of a contact presses counts too. Default: none.
        #[serde(skip_serializing_if = "Option::is_none")]
        max_force: Option<PerAxis<f64>>,
        /// Largest speed at which the tool retreats, m/s and rad/s; default 0.25 m/s and 2.5 rad/s.
        #[serde(skip_serializing_if = "Option::is_none")]
        retreat_speed: Option<PerAxis<f64>>,
        /// Largest acceleration along the axis, m/s² and rad/s². The joints may permit less; default 5 m/s² and 50 rad/s².
        #[serde(skip_serializing_if = "Option::is_none")]
        max_acceleration: Option<PerAxis<f64>>,
        /// Follows the normal of a surface whose direction is not known: all tasks in the `frame` of this one move along and across the
        /// surface instead of along the stated axes. The task has one axis, x, y or z; default: the axes stay as they are stated.
        #[schema(example = json!({"max_tilt_rad": 0.6}))]
        #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
        surface: Option<SurfaceFollowing>,
    },
    /// Force control: M_d Ẍ + B_d Ẋ = F_d − F_e.
    Force {
        /// Inertia M_d, kg and kg·m². The velocity follows a change of force within some M_d/B_d seconds; a larger one
        /// is more stable.
        inertia: PerAxis<f64>,
        /// Damping B_d, N·s/m and N·m·s/rad. A larger one is slower and more stable; a free axis moves at F_d/B_d.
        /// `POST /v1/stability` computes the minimum.
        damping: PerAxis<f64>,
        /// Target force F_d, N and N·m, along the axes of the task; positive presses against a surface in the positive
        /// direction.
        #[serde(deserialize_with = "object::deserialize")]
        target_force: Profile,
    },
    /// Mass, damper and spring about a pose: M_d ΔẌ + B_d ΔẊ + K_d ΔX = −F_e.
    Impedance {
        /// Inertia M_d, kg and kg·m². The velocity follows a change of force within some M_d/B_d seconds; a larger one
        /// is more stable.
        inertia: PerAxis<f64>,
        /// Damping B_d, N·s/m and N·m·s/rad. A larger one is slower and more stable; a free axis moves at F_d/B_d.
        /// `POST /v1/stability` computes the minimum.
        damping: PerAxis<f64>,
        /// Stiffness K_d, N/m and N·m/rad: a force F moves the tool by F/K_d. Set a small one where contact is
        /// expected.
        stiffness: PerAxis<f64>,
        /// Target pose X_d. Set it to move the tool there; default `initial`, which holds the pose of the first step.
        #[serde(default)]
        target_pose: TargetPose,
        /// Displacement added to X_d over time, m and rad (rotation vector), along the axes of the task's frame. Set it
        /// for a path that is known in advance; default: none.
        #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
        target_displacement: Option<Profile>,
    },
    /// Force control on some axes, impedance on the others.
    Hybrid {
        /// Inertia M_d, kg and kg·m². The velocity follows a change of force within some M_d/B_d seconds; a larger one
        /// is more stable.
        inertia: PerAxis<f64>,
        /// Damping B_d, N·s/m and N·m·s/rad. A larger one is slower and more stable; a free axis moves at F_d/B_d.
        /// `POST /v1/stability` computes the minimum.
        damping: PerAxis<f64>,
        /// Stiffness K_d of the position-controlled axes, N/m and N·m/rad; ignored on the others.
        stiffness: PerAxis<f64>,
        /// Selection S per axis: `true` position-controlled, `false` force-controlled.
        position_controlled: PerAxis<bool>,
        /// Target force F_d of the force-controlled axes, N and N·m; ignored on the others.
        #[serde(deserialize_with = "object::deserialize")]
        target_force: Profile,
        /// Target pose X_d. Set it to move the tool there; default `initial`, which holds the pose of the first step.
        #[serde(default)]
        target_pose: TargetPose,
        /// Displacement added to X_d over time, m and rad (rotation vector), along the axes of the task's frame. Set it
        /// for a path that is known in advance; default: none.
        #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
        target_displacement: Option<Profile>,
    },
}

fn z_axis() -> [f64; 3] {
    [0.0, 0.0, 1.0]
}

/// What a law follows, besides forces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LawTarget<'a> {
    /// A velocity of the rows.
    Velocity(&'a Profile),
    /// A pose of the reference point.
    Pose {
        /// The pose.
        pose: &'a TargetPose,
        /// What is added to it over time.
        displacement: Option<&'a Profile>,
    },
    /// Positions of joints.
    Joints {
        /// Their names; `None`: all joints.
        names: Option<&'a [String]>,
        /// Their positions.
        position: &'a Profile,
    },
    /// A point to look at.
    Point(&'a Profile),
    /// Neither a pose nor a velocity, or the middle of ranges.
    None,
}

impl Law {
    /// Returns what the law follows, besides forces.
    pub fn target(&self) -> LawTarget<'_> {
        match self {
            Self::Velocity { target_velocity } => LawTarget::Velocity(target_velocity),
            Self::Pose { target_pose, target_displacement, .. }
            | Self::Impedance { target_pose, target_displacement, .. }
            | Self::Hybrid { target_pose, target_displacement, .. } => {
                LawTarget::Pose { pose: target_pose, displacement: target_displacement.as_ref() }
            }
            Self::Posture { joints, target_position: PostureTarget::Profile(position), .. } => {
                LawTarget::Joints { names: joints.as_deref(), position }
            }
            Self::LookAt { target_point, .. } => LawTarget::Point(target_point),
            Self::Posture { .. } | Self::Contact { .. } | Self::Force { .. } => LawTarget::None,
        }
    }

    /// Returns whether the law reads the measured wrench.
    pub fn reads_wrench(&self) -> bool {
        matches!(self, Self::Contact { .. } | Self::Force { .. } | Self::Impedance { .. } | Self::Hybrid { .. })
    }

    /// Returns inertia, damping and stiffness of one row (index from 0), as a contact feels them. `None` for laws that do
    /// not react to a contact, and for rows that the law does not have.
    pub fn contact_gains(&self, row: usize) -> Option<[f64; 3]> {
        let (inertia, damping, stiffness) = match self {
            Self::Velocity { .. }
            | Self::Pose { .. }
            | Self::Posture { .. }
            | Self::LookAt { .. }
            | Self::Contact { .. } => return None,
            Self::Force { inertia, damping, .. } => (inertia, damping, 0.0),
            Self::Impedance { inertia, damping, stiffness, .. } => (inertia, damping, stiffness.at(row)?),
            Self::Hybrid { inertia, damping, stiffness, position_controlled, .. } => {
                (inertia, damping, if position_controlled.at(row)? { stiffness.at(row)? } else { 0.0 })
            }
        };
        Some([inertia.at(row)?, damping.at(row)?, stiffness])
    }
}

/// The path on which the arm moves to a target that jumps, for a law that looks ahead. All tasks of a controller, except bounds, have the
/// same path. Each joint then moves as fast as its limits of velocity and acceleration permit, whatever `gain` is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum MotionPath {
    /// The fastest motion of each joint. The tool leaves the straight line, by up to a quarter of its length.
    Joint,
    /// The straight line of the tool, as fast as the joints can follow it.
    Straight,
}

/// The target of the joints of a posture.
#[derive(Debug, Clone, PartialEq)]
pub enum PostureTarget {
    /// `"mid_range"`: the middle of their ranges.
    MidRange,
    /// Positions over time, one per joint, rad or m.
    Profile(Profile),
}

string_or_object! {
    PostureTarget { MidRange = "mid_range" } or Profile(Profile),
    expected "`mid_range` or a profile of joint positions",
    "Target of the joints of a posture: `mid_range` (the middle of their ranges), or positions over time, one per \
     joint, rad or m."
}
