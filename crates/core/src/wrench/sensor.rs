//! What is known of a force and torque sensor.

use nalgebra::{IsometryMatrix3, Vector3};

use super::{Load, Wrench};

/// Acceleration of gravity along the axes of a base that stands upright, m/s².
pub const GRAVITY: Vector3<f64> = Vector3::new(0.0, 0.0, -9.81);

/// A force and torque sensor before a tip, and what the controller corrects in its readings.
///
/// A reading r, along the axes of the sensor and in the convention of the controller, becomes the wrench of the environment on the tool
///
/// w = s (r − b) − (m (g − a), c × m (g − a)),
///
/// with s = 1 for [`OnTool`](super::WrenchConvention::OnTool) and −1 otherwise. Then a low-pass and a deadband follow, and w is moved to
/// the tip. [`SensorState::process`](super::SensorState::process) does it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WrenchSensor {
    /// Index of the tip in [`RobotModel::tips`](revprio_robot::RobotModel::tips); 0 is the tool.
    pub tip: usize,
    /// Pose of the sensor in the frame of the tip, m.
    pub pose: IsometryMatrix3<f64>,
    /// b, reading without load, along the axes of the sensor, N and N·m.
    pub bias: Wrench,
    /// What the sensor carries.
    pub load: Load,
    /// g, base axes, m/s².
    pub gravity: Vector3<f64>,
    /// Whether the acceleration a of the load counts. It is that of the modelled joints: the commands behind the drive of the controller.
    /// Otherwise a = 0.
    pub compensates_inertia: bool,
    /// τ, time constant of the low-pass, s; 0: none.
    pub filter_time: f64,
    /// Forces and torques that are shorter count as zero, N and N·m.
    pub deadband: [f64; 2],
}

/// Why a sensor is refused.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum WrenchSensorError {
    /// The robot has no such tip, or an earlier sensor is that of the tip.
    #[error("a tip has at most one sensor, and the robot must have the tip")]
    Tip,
    /// A number is out of its range.
    #[error("`{field}` must be {must_be}")]
    Range {
        /// The field of a controller in JSON.
        field: &'static str,
        /// The range in words.
        must_be: &'static str,
    },
}

impl WrenchSensor {
    /// Returns a sensor in the frame of a tip that corrects nothing.
    pub fn at_tip(tip: usize) -> Self {
        Self {
            tip,
            pose: IsometryMatrix3::identity(),
            bias: Wrench::default(),
            load: Load::default(),
            gravity: GRAVITY,
            compensates_inertia: false,
            filter_time: 0.0,
            deadband: [0.0; 2],
        }
    }

    /// Checks the numbers.
    pub(crate) fn check(&self) -> Result<(), WrenchSensorError> {
        let finite = |vector: &Vector3<f64>| vector.iter().all(|entry| entry.is_finite());
        let not_negative = |value: &f64| value.is_finite() && *value >= 0.0;
        let Self { pose, bias, load, gravity, filter_time, deadband, .. } = self;
        let placed = finite(&pose.translation.vector) && pose.rotation.matrix().iter().all(|entry| entry.is_finite());
        let zero_or_more = "zero or positive";
        let checks = [
            ("pose", placed, "finite"),
            ("bias", finite(&bias.force) && finite(&bias.torque), "finite"),
            (
                "payload",
                not_negative(&load.mass) && finite(&load.center_of_mass),
                "a mass of zero or more with a finite centre",
            ),
            ("gravity", finite(gravity), "finite"),
            ("filter_time_s", not_negative(filter_time), zero_or_more),
            ("deadband_n", not_negative(&deadband[0]), zero_or_more),
            ("deadband_nm", not_negative(&deadband[1]), zero_or_more),
        ];
        match checks.into_iter().find(|(_, is_right, _)| !is_right) {
            Some((field, _, must_be)) => Err(WrenchSensorError::Range { field, must_be }),
            None => Ok(()),
        }
    }
}
