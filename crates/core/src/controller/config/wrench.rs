//! What a measured wrench means.

use nalgebra::{Rotation3, Vector3};

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
    /// The axes of the tool, or of the tip at which it is measured, as of a wrist sensor.
    Tool,
}

/// Returns F_e on the environment, base axes, from a wrench measured at a tip, N and N·m; `tip`: the orientation of the tip.
pub(in crate::controller) fn on_environment(
    measured: &[f64; 6],
    (convention, frame): (WrenchConvention, WrenchFrame),
    tip: &Rotation3<f64>,
) -> [f64; 6] {
    let [fx, fy, fz, tx, ty, tz] = measured.map(|entry| convention.sign() * entry);
    match frame {
        WrenchFrame::Base => [fx, fy, fz, tx, ty, tz],
        WrenchFrame::Tool => {
            let (force, torque) = (tip * Vector3::new(fx, fy, fz), tip * Vector3::new(tx, ty, tz));
            [force.x, force.y, force.z, torque.x, torque.y, torque.z]
        }
    }
}
