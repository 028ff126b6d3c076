//! Sensors of the arm with noise, bias, resolution and filter.

use revprio_api::wire::{PerAxis, object};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::field_error::{FieldError, not_negative, number, per_row};
use super::random::{Purpose, RandomSource};

/// Sensors of the arm. The default is ideal sensors.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Sensors {
    /// Joint positions q, rad or m; per joint.
    #[serde(deserialize_with = "object::deserialize", skip_serializing_if = "Sensor::is_perfect")]
    pub joint_position: Sensor,
    /// Joint velocities q̇, rad/s or m/s; per joint.
    #[serde(deserialize_with = "object::deserialize", skip_serializing_if = "Sensor::is_perfect")]
    pub joint_velocity: Sensor,
    /// Force along x, y and z of the sensor, N.
    #[serde(deserialize_with = "object::deserialize", skip_serializing_if = "Sensor::is_perfect")]
    pub force: Sensor,
    /// Torque about x, y and z of the sensor, N·m.
    #[serde(deserialize_with = "object::deserialize", skip_serializing_if = "Sensor::is_perfect")]
    pub torque: Sensor,
    /// Time constant τ of a first-order low-pass filter for force and torque, s; no filter if 0.
    pub wrench_filter_s: f64,
}

/// Errors of a sensor: it measures quantum · round((value + bias + noise)/quantum). Each field is one number for all values,
/// or one per value.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Sensor {
    /// Standard deviation of the normally distributed noise in each period.
    pub noise: PerAxis<f64>,
    /// Constant offset.
    pub bias: PerAxis<f64>,
    /// Resolution; unlimited if 0.
    pub quantum: PerAxis<f64>,
}

impl Default for Sensor {
    fn default() -> Self {
        Self { noise: PerAxis::All(0.0), bias: PerAxis::All(0.0), quantum: PerAxis::All(0.0) }
    }
}

impl Sensor {
    fn is_perfect(&self) -> bool {
        *self == Self::default()
    }
}

/// The state that the controller received.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Sensed {
    /// Joint positions q, n, rad or m.
    pub joint_position: Vec<f64>,
    /// Joint velocities q̇, n, rad/s or m/s.
    pub joint_velocity: Vec<f64>,
    /// Force in the controller's convention of sign and axes, N.
    pub force: [f64; 3],
    /// Torque in the same convention, N·m.
    pub torque: [f64; 3],
}

/// The state of all sensors.
#[derive(Debug, Clone)]
pub struct Sensing {
    joint_position: Channel,
    joint_velocity: Channel,
    force: Channel,
    torque: Channel,
    is_perfect: bool,
    random: RandomSource,
}

impl Sensing {
    /// Returns the sensors of an arm with `joints` joints; they measure once per period (s).
    pub fn new(sensors: &Sensors, joints: usize, period_s: f64, seed: u64) -> Result<Self, FieldError> {
        let tau = not_negative(sensors.wrench_filter_s, "/sensors/wrench_filter_s")?;
        let gain = if tau > 0.0 { -(-period_s / tau).exp_m1() } else { 1.0 };
        let channel = |sensor, rows, name, gain| Channel::new(sensor, rows, &format!("/sensors/{name}"), gain);
        Ok(Self {
            joint_position: channel(&sensors.joint_position, joints, "joint_position", 1.0)?,
            joint_velocity: channel(&sensors.joint_velocity, joints, "joint_velocity", 1.0)?,
            force: channel(&sensors.force, 3, "force", gain)?,
            torque: channel(&sensors.torque, 3, "torque", gain)?,
            is_perfect: *sensors == Sensors::default(),
            random: RandomSource::new(seed, Purpose::Sensors),
        })
    }

    /// Returns whether all sensors are ideal.
    pub fn is_perfect(&self) -> bool {
        self.is_perfect
    }

    /// Replaces the true state by the measured state. Call it once per period.
    pub fn sense(&mut self, state: &mut Sensed) {
        self.joint_position.sense(&mut state.joint_position, &mut self.random);
        self.joint_velocity.sense(&mut state.joint_velocity, &mut self.random);
        self.force.sense(&mut state.force, &mut self.random);
        self.torque.sense(&mut state.torque, &mut self.random);
    }
}

/// One sensor of several values.
#[derive(Debug, Clone)]
struct Channel {
    noise: Vec<f64>,
    bias: Vec<f64>,
    quantum: Vec<f64>,
    /// Share of the difference to the new value that passes the filter in one period.
    gain: f64,
    filtered: Option<Vec<f64>>,
}

impl Channel {
    fn new(sensor: &Sensor, rows: usize, pointer: &str, gain: f64) -> Result<Self, FieldError> {
        let at = |field: &str| format!("{pointer}/{field}");
        Ok(Self {
            noise: per_row(&sensor.noise, rows, &at("noise"), not_negative)?,
            bias: per_row(&sensor.bias, rows, &at("bias"), number)?,
            quantum: per_row(&sensor.quantum, rows, &at("quantum"), not_negative)?,
            gain,
            filtered: None,
        })
    }

    fn sense(&mut self, values: &mut [f64], random: &mut RandomSource) {
        for (i, value) in values.iter_mut().enumerate() {
            *value += self.bias[i];
            if self.noise[i] > 0.0 {
                *value += self.noise[i] * random.normal();
            }
        }
        if self.gain < 1.0 {
            let filtered = self.filtered.get_or_insert_with(|| values.to_vec());
            for (kept, value) in filtered.iter_mut().zip(values.iter_mut()) {
                *kept += self.gain * (*value - *kept);
                *value = *kept;
            }
        }
        for (value, &quantum) in values.iter_mut().zip(&self.quantum) {
            if quantum > 0.0 {
                *value = (*value / quantum).round() * quantum;
            }
        }
    }
}
