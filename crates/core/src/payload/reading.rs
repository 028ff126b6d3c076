//! A reading of a sensor at rest.

use nalgebra::Vector3;

/// One reading at rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PayloadReading {
    /// g, acceleration of gravity along the axes of the sensor, m/s².
    pub gravity: Vector3<f64>,
    /// Force on the tool, N, along the axes of the sensor.
    pub force: Vector3<f64>,
    /// Torque on the tool, N·m, at the sensor.
    pub torque: Vector3<f64>,
}
