//! The reading of the wrist sensor of a scenario.
//!
//! The simulated sensor has exactly the bias, the payload and the place that `wrench_sensor` of the controller states. The inertia of the
//! payload is not simulated.

use nalgebra::{IsometryMatrix3, Quaternion, Translation3, UnitQuaternion, Vector3};
use revprio_api::wire;

/// What turns the wrench of the tool on the environment into a reading.
#[derive(Debug, Clone)]
pub struct WristSensor {
    convention: wire::WrenchConvention,
    frame: wire::WrenchFrame,
    stated: Option<wire::WrenchSensor>,
    /// Pose of the sensor in the frame of the tool point, m.
    pose: IsometryMatrix3<f64>,
}

impl WristSensor {
    /// Returns the sensor of a controller.
    pub fn new(controller: &wire::Controller) -> Self {
        let stated = controller.wrench_sensor;
        let offset = controller.tool_offset.as_ref().map(isometry).unwrap_or_default();
        let placed = stated.and_then(|stated| stated.pose);
        Self {
            convention: controller.wrench_convention,
            frame: controller.wrench_frame,
            stated,
            pose: placed.map_or_else(IsometryMatrix3::identity, |placed| offset.inv_mul(&isometry(&placed))),
        }
    }

    /// Returns whether a reading is the wrench itself, along the axes of the base.
    pub fn is_plain(&self) -> bool {
        self.stated.is_none()
            && self.convention == wire::WrenchConvention::OnEnvironment
            && self.frame == wire::WrenchFrame::Base
    }

    /// Returns force and torque of a reading, N and N·m, for those on the environment at the tool point, base axes; `tool`: the pose of
    /// the tool point, m.
    pub fn read(&self, force: [f64; 3], torque: [f64; 3], tool: &IsometryMatrix3<f64>) -> [[f64; 3]; 2] {
        let sign = match self.convention {
            wire::WrenchConvention::OnEnvironment => 1.0,
            wire::WrenchConvention::OnTool => -1.0,
        };
        let Some(stated) = &self.stated else {
            let turned = |vector: [f64; 3]| match self.frame {
                wire::WrenchFrame::Base => vector.map(|entry| sign * entry),
                wire::WrenchFrame::Tool => {
                    tool.rotation.inverse_transform_vector(&Vector3::from(vector.map(|entry| sign * entry))).into()
                }
            };
            return [turned(force), turned(torque)];
        };
        let sensor = tool * self.pose;
        let lever = tool.translation.vector - sensor.translation.vector;
        let weight = stated.payload.mass_kg * Vector3::from(stated.gravity);
        let center = sensor.rotation * Vector3::from(stated.payload.center_of_mass);
        let force = Vector3::from(force);
        let torque = Vector3::from(torque) + lever.cross(&force) - center.cross(&weight);
        let along = |vector: Vector3<f64>, bias: [f64; 3]| {
            let reading = sign * sensor.rotation.inverse_transform_vector(&vector) + Vector3::from(bias);
            match self.frame {
                wire::WrenchFrame::Base => (sensor.rotation * reading).into(),
                wire::WrenchFrame::Tool => reading.into(),
            }
        };
        [along(force - weight, stated.bias.force), along(torque, stated.bias.torque)]
    }
}

/// Returns a pose that the service has accepted.
fn isometry(pose: &wire::Pose) -> IsometryMatrix3<f64> {
    let wire::Orientation { w, x, y, z } = pose.orientation;
    let rotation = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z)).to_rotation_matrix();
    IsometryMatrix3::from_parts(Translation3::from(pose.position), rotation)
}
