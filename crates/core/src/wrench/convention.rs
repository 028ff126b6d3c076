//! What a measured wrench means.

use nalgebra::Rotation3;

use super::Wrench;

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
    /// Returns the factor that converts a measured wrench to the wrench on the environment, 1 or −1.
    pub(crate) fn sign(self) -> f64 {
        match self {
            Self::OnEnvironment => 1.0,
            Self::OnTool => -1.0,
        }
    }
}

/// The axes along which the wrench is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum WrenchFrame {
    /// The axes of the base.
    #[default]
    Base,
    /// The axes of the tool, or of the tip at which it is measured, as of a wrist sensor. With a [`WrenchSensor`](super::WrenchSensor)
    /// the axes of that sensor.
    Tool,
}

/// Convention and axes of all wrenches of a controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct WrenchTerms {
    /// Who exerts the wrench on whom.
    pub convention: WrenchConvention,
    /// Along which axes it is measured.
    pub frame: WrenchFrame,
}

impl WrenchTerms {
    /// Returns F_e on the environment, base axes, from a wrench measured at a tip, N and N·m; `tip`: the orientation of the tip.
    pub(crate) fn on_environment(self, measured: &[f64; 6], tip: &Rotation3<f64>) -> [f64; 6] {
        let entries = measured.map(|entry| self.convention.sign() * entry);
        match self.frame {
            WrenchFrame::Base => entries,
            WrenchFrame::Tool => Wrench::from(entries).rotated(tip).into(),
        }
    }

    /// Returns a reading as the wrench on the tool, along the axes of its sensor, N and N·m; `sensor`: the orientation of the sensor in the
    /// base.
    pub fn on_tool(self, reading: &[f64; 6], sensor: &Rotation3<f64>) -> Wrench {
        let Wrench { force, torque } = self.along_sensor(reading, sensor);
        Wrench { force: -self.convention.sign() * force, torque: -self.convention.sign() * torque }
    }

    /// Returns a reading along the axes of its sensor, N and N·m; `sensor`: the orientation of the sensor in the base.
    pub(super) fn along_sensor(self, reading: &[f64; 6], sensor: &Rotation3<f64>) -> Wrench {
        match self.frame {
            WrenchFrame::Base => Wrench::from(*reading).rotated(&sensor.inverse()),
            WrenchFrame::Tool => Wrench::from(*reading),
        }
    }
}
