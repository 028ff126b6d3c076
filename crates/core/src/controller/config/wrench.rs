//! What a measured wrench means.

use nalgebra::Vector3;
use revprio_robot::kinematics::Configuration;

/// Which body exerts the measured wrench on which. The laws use the wrench on the environment.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum WrenchConvention {
    /// The wrench of the tool on the environment: pressing on a wall at +x gives a positive x force.
    #[default]
    OnEnvironment,
    /// The wrench of the environment on the tool, with the opposite sign. Most wrist sensors measure it.
    OnTool,
}

impl WrenchConvention {
    /// Returns the factor that converts a measured wrench to the wrench on the environment.
    fn sign(self) -> f64 {
        match self {
            Self::OnEnvironment => 1.0,
            Self::OnTool => -1.0,
        }
    }
}

/// The axes along which the wrench is measured, at the tool point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum WrenchFrame {
    /// The axes of the base.
    #[default]
    Base,
    /// The axes of the tool, as of a wrist sensor.
    Tool,
}

/// Returns F_e on the environment, base axes, at the tool point, from a measured wrench, N and N·m.
pub(in crate::controller) fn on_environment(
    measured: &[f64; 6],
    (convention, frame): (WrenchConvention, WrenchFrame),
    configuration: &Configuration,
) -> [f64; 6] {
    let [fx, fy, fz, tx, ty, tz] = measured.map(|entry| convention.sign() * entry);
    match frame {
        WrenchFrame::Base => [fx, fy, fz, tx, ty, tz],
        WrenchFrame::Tool => {
            let rotation = &configuration.tool_pose().rotation;
            let (force, torque) = (rotation * Vector3::new(fx, fy, fz), rotation * Vector3::new(tx, ty, tz));
            [force.x, force.y, force.z, torque.x, torque.y, torque.z]
        }
    }
}
