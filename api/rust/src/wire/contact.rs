//! Contacts of the law `contact`: their reports and their memory.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// The state of a contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum ContactState {
    /// The tool approaches a surface.
    Approach,
    /// The tool presses.
    Contact,
    /// The tool has lost the surface and goes back to it.
    Loss,
    /// The tool has retreated and rests. Replace the controller, or start another one, to press again.
    Fault,
}

/// Why a contact is given up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum ContactFault {
    /// The surface pulls. Check the sign of the wrench (`wrench_convention`), and tare the sensor.
    Pull,
    /// The force stays while the tool retreats by 0.1 m or 1 rad. Check sign, axes and bias of the wrench.
    StaysInRetreat,
    /// The force exceeds `max_force`.
    ForceLimit,
    /// The reading has stayed the same while the tool moved: away from the target for 0.1 s and 1 mm or 10 mrad, near it for 1 s and 10 mm
    /// or 0.1 rad; or, if it has shown noise before, for 0.1 s and a way that would have changed it. The sensor sticks or is saturated. Check its connection and its range.
    Stuck,
}

/// How the tasks in a frame follow the normal of a surface. It is learnt while the tool slides, from its motion and its force together.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SurfaceFollowing {
    /// Largest angle between the normal and the stated axis, rad, up to 1.4; default π/4. Beyond it the axes stay there, and the answer
    /// says so.
    #[schema(example = 0.6)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_tilt_rad: Option<f64>,
}

/// The normal of a surface that a task follows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct SurfaceReport {
    /// Direction in which the task presses, a unit vector along the axes of the base.
    #[schema(example = json!([0.34, 0.0, -0.94]))]
    pub normal: [f64; 3],
    /// Estimated coefficient of friction; absent until the tool has slid 1 mm.
    #[schema(example = 0.31)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction: Option<f64>,
    /// Rms angle between the normal and single measurements of it over the last 5 mm, rad. It begins with the largest tilt; absent until
    /// the tool has slid 1 mm.
    #[schema(example = 0.01)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub uncertainty_rad: Option<f64>,
    /// Whether the surface is tilted by more than `max_tilt_rad`. The force then has an error.
    #[schema(example = false)]
    pub is_limited: bool,
    /// Largest speed of the other tasks along the surface, m/s, until its normal is known; absent from then on, and without contact.
    #[schema(example = 0.018)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_speed: Option<f64>,
}

/// The contact of one row, along its pressing direction. Forces are N or N·m, positions m or rad.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ContactReport {
    /// State of the contact.
    pub state: ContactState,
    /// Why the contact is given up; only in the state `fault`.
    #[schema(example = "force_limit")]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fault: Option<ContactFault>,
    /// The state that began in this period; absent in all others. Count these to count contacts and losses.
    #[schema(example = "contact")]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub event: Option<ContactState>,
    /// Measured force along the pressing direction, N or N·m.
    #[schema(example = 29.7)]
    #[serde(default)]
    pub force: f64,
    /// Target force along the pressing direction, N or N·m.
    #[schema(example = 30.0)]
    #[serde(default)]
    pub target_force: f64,
    /// Upper bound of the stiffness with which the law computes, N/m or N·m/rad. It starts at the stiffest contact.
    #[schema(example = 15_300.0)]
    pub stiffness_bound: f64,
    /// Estimated stiffness, N/m or N·m/rad; absent until it is known.
    #[schema(example = 12_000.0)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stiffness: Option<f64>,
    /// Uncertainty of the estimated stiffness, rms, N/m or N·m/rad; absent until it is known.
    #[schema(example = 130.0)]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stiffness_uncertainty: Option<f64>,
    /// Predicted force if all later commands are zero, N or N·m; 0 without contact.
    #[schema(example = 29.9)]
    pub predicted_force: f64,
    /// Estimated velocity of a surface that moves, along the pressing direction, m/s or rad/s.
    #[schema(example = 0.0)]
    pub surface_velocity: f64,
    /// Energy that the law may still give to the surface, J.
    #[schema(example = 2.16)]
    pub energy_j: f64,
    /// Approach speed of this period, m/s or rad/s.
    #[schema(example = 0.012)]
    pub approach_speed: f64,
    /// Peak force that no controller can avoid that brakes with the acceleration of this law, at this approach speed in the stiffest
    /// contact, N or N·m.
    #[schema(example = 32.7)]
    pub unavoidable_peak: f64,
    /// Normal of the surface; absent for a law without `surface`.
    #[schema(example = json!({"normal": [0.34, 0.0, -0.94], "friction": 0.31, "uncertainty_rad": 0.01, "is_limited": false}))]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surface: Option<SurfaceReport>,
}

/// What the law `contact` remembers of the normal of a surface. Vectors are along the axes of the base.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct NormalMemory {
    /// Direction in which the task presses, a unit vector.
    #[schema(example = json!([0.6, 0.0, -0.8]))]
    pub normal: [f64; 3],
    /// Mean of the measured normals; zeros before the first one.
    #[schema(example = json!([0.59, 0.0, -0.79]))]
    pub mean: [f64; 3],
    /// Coefficient of friction.
    #[schema(example = 0.31)]
    pub friction: f64,
    /// Mean of the squared angle between the mean and the measured normals, rad².
    #[schema(example = 1e-4)]
    pub variance: f64,
    /// Number of measured normals since the touch, up to 5.
    #[schema(example = 5.0)]
    pub chords: f64,
    /// Whether position and force are filtered.
    #[schema(example = true)]
    pub is_sliding: bool,
    /// Filtered position of the tool, m, and where the present chord begins.
    #[schema(example = json!([[0.5, 0.1, 0.2], [0.4995, 0.1, 0.2002]]))]
    pub position: [[f64; 3]; 2],
    /// Filtered force of the tool on the surface, N, and that where the present chord begins.
    #[schema(example = json!([[17.0, 0.0, -12.0], [17.0, 0.0, -12.0]]))]
    pub force: [[f64; 3]; 2],
}

/// What an axis with the law `contact` remembers of the measured positions of the tool. Positions are m or rad, forces N or N·m.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct MeasuredContact {
    /// Measured position of the tool, the same as the force sensor sees it, and as it is followed.
    #[schema(example = json!([0.012, 0.012, 0.012]))]
    pub position: [f64; 3],
    /// Upper bound, slope and uncertainty of the stiffness, N/m or N·m/rad.
    #[schema(example = json!([15_300.0, 12_000.0, 130.0]))]
    pub stiffness: [f64; 3],
    /// Running means of sensed position and force.
    #[schema(example = json!([0.011, 28.0]))]
    pub means: [f64; 2],
    /// Sums of the squared position, position times force, the squared force, and the number of samples.
    #[schema(example = json!([1e-6, 0.012, 144.0, 80.0]))]
    pub sums: [f64; 4],
    /// Means of the velocity of the surface over a short and a long time, and how long it has been seen to move, s.
    #[schema(example = json!([0.0, 0.0, 0.0]))]
    pub surface_motion: [f64; 3],
    /// Position and force as they are followed while the contact is held, their rates, what was not foreseen of them in the last period, and
    /// their noise; absent without a held contact, and in older memories: then a motion of the surface is learnt anew.
    #[schema(example = json!([0.012, 29.9, 0.0, 0.1, 1e-7, 0.1, 1e-7, 0.2]))]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub followed: Option<[f64; 8]>,
}

/// What the law `contact` remembers of one axis, along its pressing direction. Forces are N or N·m, positions m or rad.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ContactMemory {
    /// State of the contact.
    pub state: ContactState,
    /// Why the contact is given up; only in the state `fault`.
    #[schema(example = "force_limit")]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fault: Option<ContactFault>,
    /// Modelled position of the tool since the first step.
    #[schema(example = 0.012)]
    pub position: f64,
    /// The same as the force sensor sees it.
    #[schema(example = 0.012)]
    pub sensed_position: f64,
    /// Force of the last state.
    #[schema(example = 29.9)]
    pub force: f64,
    /// Position of the surface.
    #[schema(example = 0.01)]
    pub surface: f64,
    /// Time in contact since the last touch, of suspicion before it, or of a loss, s.
    #[schema(example = 0.4)]
    pub contact_time_s: f64,
    /// Force that has been missing for a contact, added up over time, N·s or N·m·s; default 0. Above a bound the contact is lost.
    #[schema(example = 0.0)]
    #[serde(default)]
    pub lack: f64,
    /// Time for which the force is near its target, s, up to the time after which the contact is held.
    #[schema(example = 0.3)]
    pub hold_time_s: f64,
    /// Largest speed of the way back to a lost surface, m/s or rad/s.
    #[schema(example = 0.012)]
    pub return_speed: f64,
    /// Energy that the surface got, less what its motion may cost, J.
    #[schema(example = 0.02)]
    pub spent_j: f64,
    /// Sensed position when the tool last moved forward.
    #[schema(example = 0.012)]
    pub before_retreat: f64,
    /// Force when the tool last moved forward, N or N·m; default 0.
    #[schema(example = 30.1)]
    #[serde(default)]
    pub force_before_retreat: f64,
    /// Position at the fault.
    #[schema(example = 0.0)]
    pub fault_position: f64,
    /// Upper bound, slope and uncertainty of the stiffness, N/m or N·m/rad.
    #[schema(example = json!([15_300.0, 12_000.0, 130.0]))]
    pub stiffness: [f64; 3],
    /// Running means of sensed position and force.
    #[schema(example = json!([0.011, 28.0]))]
    pub means: [f64; 2],
    /// Sums of the squared position, position times force, the squared force, and the number of samples.
    #[schema(example = json!([1e-6, 0.012, 144.0, 80.0]))]
    pub sums: [f64; 4],
    /// Position and force as they are followed while the contact is held, their rates, what was not foreseen of them in the last period, and
    /// their noise; absent without a held contact, and in older memories.
    #[schema(example = json!([0.012, 29.9, 0.0, 0.1, 1e-7, 0.1, 1e-7, 0.2]))]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub followed: Option<[f64; 8]>,
    /// Mean of the target force; default 0.
    #[schema(example = 30.0)]
    #[serde(default)]
    pub mean_target_force: f64,
    /// Place of the surface as it is followed, the stiffness of that place, and the velocity of the surface that is fed forward. Only the velocity is
    /// read back.
    #[schema(example = json!([0.01, 12_000.0, 0.0]))]
    pub surface_motion: [f64; 3],
    /// What the measured positions of the tool show; absent before the first period, and in older memories: then a motion of the surface is noticed from the next
    /// touch on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub measured: Option<MeasuredContact>,
    /// Modelled position at the last step, how far the model has moved beyond the measured way lately, how much the force has risen in that time, and
    /// the mean velocities of model and tool, and for how long the model has been too far ahead, s; absent in older memories. After a while the modelled
    /// position goes on with the measured one.
    #[schema(example = json!([0.012, 1e-5, 0.2, 0.001, 0.001, 0.0]))]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub following: Option<[f64; 6]>,
    /// Factor of the upper bound, and the largest difference from the target force since the force last crossed it and before.
    #[schema(example = json!([1.0, 0.2, 0.3]))]
    pub swing: [f64; 3],
    /// Whether the force is above its target.
    #[schema(example = false)]
    pub is_above: bool,
    /// The reading that does not change, the position where it was read first, and the time since then, s; default zeros.
    #[schema(example = json!([29.9, 0.012, 0.0]))]
    #[serde(default)]
    pub unchanged: [f64; 3],
    /// Rms change of the readings before that, N or N·m; default 0: the reading has shown no noise.
    #[schema(example = 0.2)]
    #[serde(default)]
    pub reading_change: f64,
    /// Smallest change of the reading so far, N or N·m; default 0: there was none.
    #[schema(example = 0.01)]
    #[serde(default)]
    pub reading_step: f64,
    /// What is known of the normal of the surface; absent for a law without `surface`, and before the first period.
    #[schema(example = json!({"normal": [0.6, 0.0, -0.8], "mean": [0.59, 0.0, -0.79], "friction": 0.31, "variance": 1e-4, "chords": 5.0,
        "is_sliding": true, "position": [[0.5, 0.1, 0.2], [0.4995, 0.1, 0.2002]], "force": [[17.0, 0.0, -12.0], [17.0, 0.0, -12.0]]}))]
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub normal: Option<NormalMemory>,
}
