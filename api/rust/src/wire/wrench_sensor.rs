//! Force and torque sensors: what a controller corrects in their readings, taring, and the identification of a payload.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::object;
use super::{JointVector, Pose, Wrench, WrenchConvention, WrenchFrame, defaults};

/// A force and torque sensor, and what the controller corrects in its readings. The wrench of a state then is the raw reading, about the
/// origin of the sensor, along the axes of the sensor (`"wrench_frame": "tool"`) or of the base.
///
/// In this order: the bias is subtracted; the sign becomes that of `wrench_convention`; weight and inertia of the payload are subtracted;
/// low-pass; deadband; the wrench is moved to the tip. Answers have the result in `wrench`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct WrenchSensor {
    /// Pose of the sensor in the robot's own tool frame, as `tool_offset`, or in the frame of the tip, m. Default: the tool point.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub pose: Option<Pose>,
    /// Reading without contact and without payload, along the axes of the sensor, as `POST /v1/controllers/{id}/tare` or `POST /v1/payload`
    /// finds it; default 0.
    #[serde(default, deserialize_with = "object::deserialize", skip_serializing_if = "defaults::is_default")]
    pub bias: Wrench,
    /// What the sensor carries: all that moves with the tool; default: nothing.
    #[serde(default, deserialize_with = "object::deserialize", skip_serializing_if = "defaults::is_default")]
    pub payload: Payload,
    /// Acceleration of gravity along the axes of the base, m/s². Set it for an arm on a wall or a ceiling; default [0, 0, -9.81].
    #[serde(default = "default_gravity", skip_serializing_if = "is_default_gravity")]
    #[schema(example = json!([0.0, 0.0, -9.81]))]
    pub gravity: [f64; 3],
    /// Whether the inertia of the payload is subtracted, with the acceleration of the commands behind `drive`. Set it for heavy tools, whose
    /// acceleration would look like a contact; default `false`.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    #[schema(example = true)]
    pub compensate_inertia: bool,
    /// Time constant of a first-order low-pass, s. The law `contact` counts its lag. Set it only for a noisy sensor: it costs speed.
    /// At most 1; default 0, none.
    #[serde(default, skip_serializing_if = "defaults::is_default")]
    #[schema(example = 0.002)]
    pub filter_time_s: f64,
    /// Forces that are shorter count as zero, N; default 0.
    #[serde(default, skip_serializing_if = "defaults::is_default")]
    #[schema(example = 0.5)]
    pub deadband_n: f64,
    /// Torques that are shorter count as zero, N·m; default 0.
    #[serde(default, skip_serializing_if = "defaults::is_default")]
    #[schema(example = 0.05)]
    pub deadband_nm: f64,
}

fn default_gravity() -> [f64; 3] {
    [0.0, 0.0, -9.81]
}

fn is_default_gravity(gravity: &[f64; 3]) -> bool {
    *gravity == default_gravity()
}

impl Default for WrenchSensor {
    fn default() -> Self {
        Self {
            pose: None,
            bias: Wrench::default(),
            payload: Payload::default(),
            gravity: default_gravity(),
            compensate_inertia: false,
            filter_time_s: 0.0,
            deadband_n: 0.0,
            deadband_nm: 0.0,
        }
    }
}

/// Mass and centre of mass of what a sensor carries.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Payload {
    /// Mass, kg.
    #[schema(example = 0.5)]
    pub mass_kg: f64,
    /// Centre of mass x, y, z from the origin of the sensor, along its axes, m; default: the origin.
    #[serde(default)]
    #[schema(example = json!([0.0, 0.0, 0.06]))]
    pub center_of_mass: [f64; 3],
}

/// What a wrench sensor remembers.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct WrenchSensorMemory {
    /// Wrench behind the low-pass, axes and origin of the sensor; default: the next reading sets it.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub filtered: Option<Wrench>,
    /// Velocity of the centre of mass of the payload, base axes, m/s; default: unknown.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(example = json!([0.01, 0.0, -0.02]))]
    pub velocity: Option<[f64; 3]>,
}

/// `POST /v1/controllers/{id}/tare`: readings at rest, in one posture, without contact.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct TareRequest {
    /// Name of the tip whose sensor is read; default: the tool.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(example = "right_hand")]
    pub tip: Option<String>,
    /// At least 20 readings. More leave less noise in the bias.
    #[serde(deserialize_with = "object::list")]
    pub readings: Vec<RestReading>,
}

/// A reading of an arm at rest.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct RestReading {
    /// Measured joint position, rad or m, in joint order or by name.
    pub joint_position: JointVector,
    /// Measured wrench, as in the states.
    #[serde(deserialize_with = "object::deserialize")]
    pub wrench: Wrench,
}

/// What taring found. The session uses it from the next state on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct TareAnswer {
    /// Bias of the sensor, for `bias` of `wrench_sensor` in later controllers.
    pub bias: Wrench,
    /// Noise of a reading along the noisiest axis, rms, N. The field `noise` of the law `contact` wants it.
    pub force_noise_n: f64,
    /// Noise of a reading along the noisiest axis, rms, N·m.
    pub torque_noise_nm: f64,
    /// Warnings: a weight that is not known.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schema(example = json!(["no payload is stated"]))]
    pub warnings: Vec<String>,
}

/// `POST /v1/payload`: readings at rest in six postures or more, without contact.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct PayloadRequest {
    /// Name of the robot, from `GET /v1/robots`; only for readings with `joint_position`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robot: Option<String>,
    /// Tip before which the sensor is, by its name; default: the tool.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(example = "right_hand")]
    pub tip: Option<String>,
    /// Pose of the sensor in the robot's own tool frame, as in `wrench_sensor`; default: that frame. Readings with their own `gravity` do
    /// not need it.
    #[serde(default, deserialize_with = "object::optional", skip_serializing_if = "Option::is_none")]
    pub pose: Option<Pose>,
    /// Acceleration of gravity along the axes of the base, m/s², for the readings with `joint_position`; default [0, 0, -9.81].
    #[serde(default = "default_gravity", skip_serializing_if = "is_default_gravity")]
    #[schema(example = json!([0.0, 0.0, -9.81]))]
    pub gravity: [f64; 3],
    /// Sign of the readings, as in the controller; default `on_environment`.
    #[serde(default)]
    pub wrench_convention: WrenchConvention,
    /// Axes of the readings: `tool` are those of the sensor. Default `tool`.
    #[serde(default = "sensor_axes")]
    pub wrench_frame: WrenchFrame,
    /// Noise of a reading, rms, N; of a mean, if the readings are means. Default 0.2.
    #[serde(default = "default_force_noise")]
    #[schema(example = 0.2)]
    pub force_noise_n: f64,
    /// Noise of a reading, rms, N·m; default 0.02.
    #[serde(default = "default_torque_noise")]
    #[schema(example = 0.02)]
    pub torque_noise_nm: f64,
    /// At least six readings, in postures that turn the sensor far: gravity along each of its axes in both directions is best.
    #[serde(deserialize_with = "object::list")]
    pub readings: Vec<PayloadReading>,
}

fn sensor_axes() -> WrenchFrame {
    WrenchFrame::Tool
}

fn default_force_noise() -> f64 {
    0.2
}

fn default_torque_noise() -> f64 {
    0.02
}

/// A reading of a sensor at rest. Give either the posture or the direction of gravity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct PayloadReading {
    /// Measured joint position, rad or m, in joint order or by name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joint_position: Option<JointVector>,
    /// Acceleration of gravity along the axes of the sensor, m/s², in place of `joint_position`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(example = json!([0.0, 0.0, 9.81]))]
    pub gravity: Option<[f64; 3]>,
    /// Measured wrench.
    #[serde(deserialize_with = "object::deserialize")]
    pub wrench: Wrench,
}

/// Bias and payload. `bias` and `payload` fit into `wrench_sensor` of a controller as they are.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct PayloadAnswer {
    /// Reading without contact and without payload, along the axes of the sensor.
    pub bias: Wrench,
    /// Mass and centre of mass.
    pub payload: Payload,
    /// Uncertainty of the mass, rms, kg.
    #[schema(example = 0.008)]
    pub mass_uncertainty_kg: f64,
    /// Uncertainty of the centre of mass, rms per axis, m; absent without payload.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(example = 0.0016)]
    pub center_of_mass_uncertainty_m: Option<f64>,
    /// Residual of the forces, rms per axis, N. It is near the noise.
    pub force_residual_n: f64,
    /// Residual of the torques, rms per axis, N·m.
    pub torque_residual_nm: f64,
    /// How similar the postures are: 1 at best; above 8 they are refused.
    pub condition: f64,
    /// Whether the readings rule out every wrong sign and every exchange of axes; if not, the payload is too light for the noise or the
    /// postures are too similar.
    pub axes_verified: bool,
    /// Number of readings.
    pub readings: usize,
}
