//! `POST /v1/payload`.

use nalgebra::Vector3;
use revprio_api::wire;
use revprio_core::payload::{self, Payload, PayloadError};
use revprio_core::wrench::{Wrench, WrenchTerms};
use revprio_robot::RobotModel;
use revprio_robot::kinematics::Configuration;

use super::checks::{Inside, Refused, Result, check, each};
use super::numbers::{check_numbers, joint_vector, number};
use super::pose::pose;
use super::resolve::known_robot;
use super::terms;
use super::wrench_sensor::{check_count, tip_index, wrench_answer};
use super::wrenches::six;
use crate::error::ApiError;
use crate::robots::Robots;
use crate::state_rules::check_positions;

/// Identifies bias and payload.
pub fn identify(request: &wire::PayloadRequest, robots: &Robots) -> Result<wire::PayloadAnswer> {
    check_count(request.readings.len())?;
    let noise =
        [number(request.force_noise_n, "/force_noise_n")?, number(request.torque_noise_nm, "/torque_noise_nm")?];
    let readings: Vec<_> = Sensor::read(request, robots)?.readings(&request.readings)?;
    let found = payload::identify(&readings, noise).map_err(|error| refused(&error, request))?;
    let sign = if request.wrench_convention == wire::WrenchConvention::OnTool { 1.0 } else { -1.0 };
    Ok(answer(&found, sign, readings.len()))
}

/// A sensor whose readings are in a request.
struct Sensor<'a> {
    robot: Option<std::sync::Arc<RobotModel>>,
    tip: usize,
    pose: nalgebra::IsometryMatrix3<f64>,
    request: &'a wire::PayloadRequest,
}

impl<'a> Sensor<'a> {
    fn read(request: &'a wire::PayloadRequest, robots: &Robots) -> Result<Self> {
        check_numbers(&request.gravity, "/gravity")?;
        let robot = request.robot.as_ref().map(|name| known_robot(name, robots)).transpose()?;
        let tip = match (&robot, &request.tip) {
            (Some(robot), Some(name)) => tip_index(robot, name).inside("/tip")?,
            (None, Some(_)) => return Err(ApiError::invalid("/robot", "`tip` needs the name of a robot")),
            (_, None) => 0,
        };
        let pose = request.pose.as_ref().map(pose).transpose().inside("/pose")?.unwrap_or_default();
        Ok(Self { robot, tip, pose, request })
    }

    fn readings(&self, readings: &[wire::PayloadReading]) -> Result<Vec<payload::PayloadReading>> {
        each("/readings", readings, |_, reading| self.reading(reading))
    }

    /// Reads one reading, as a sensor of the forces on the tool would give it.
    fn reading(&self, reading: &wire::PayloadReading) -> Result<payload::PayloadReading> {
        let entries = six(&reading.wrench).inside("/wrench")?;
        let convention = terms::wrench_convention(self.request.wrench_convention);
        let frame = terms::wrench_frame(self.request.wrench_frame);
        let is_base = self.request.wrench_frame == wire::WrenchFrame::Base;
        let (gravity, on_tool) = match (&reading.joint_position, &reading.gravity) {
            (Some(position), None) => {
                let robot = self.robot.as_deref();
                let robot =
                    robot.ok_or_else(|| ApiError::invalid("", "`joint_position` needs the name of a `robot`"))?;
                let position: Vec<f64> = joint_vector(position, robot, "/joint_position")?;
                // A posture is that of an arm somewhere, perhaps with other ranges. Degrees are far outside.
                check_positions(robot, &position, std::f64::consts::TAU)
                    .map_err(|detail| ApiError::invalid("/joint_position", detail.trim_end_matches('.')))?;
                let configuration = Configuration::new(robot, &position).at("/joint_position")?;
                let rotation = (configuration.tip_pose(&robot.tips()[self.tip]) * self.pose).rotation;
                let terms = WrenchTerms { convention, frame };
                (rotation.inverse() * Vector3::from(self.request.gravity), terms.on_tool(&entries, &rotation))
            }
            (None, Some(gravity)) => {
                check(!is_base, "", "readings along the axes of the base need `joint_position`")?;
                check_numbers(gravity, "/gravity")?;
                let terms = WrenchTerms { convention, frame };
                (Vector3::from(*gravity), terms.on_tool(&entries, &nalgebra::Rotation3::identity()))
            }
            _ => return Err(ApiError::invalid("", "give either `joint_position` or `gravity`")),
        };
        let Wrench { force, torque } = on_tool;
        Ok(payload::PayloadReading { gravity, force, torque })
    }
}

fn refused(error: &PayloadError, request: &wire::PayloadRequest) -> ApiError {
    let pointer = match error {
        PayloadError::Noise if request.force_noise_n > 0.0 => "/torque_noise_nm".to_owned(),
        PayloadError::Noise => "/force_noise_n".to_owned(),
        // The numbers of the request are finite, so this is gravity.
        PayloadError::NotFinite { reading } if request.readings[*reading].gravity.is_none() => "/gravity".to_owned(),
        PayloadError::NotFinite { reading } => format!("/readings/{reading}/gravity"),
        PayloadError::Few(_)
        | PayloadError::Similar { .. }
        | PayloadError::Axes(_)
        | PayloadError::Residual { .. }
        | PayloadError::TorqueResidual { .. }
        | PayloadError::FarCenter { .. } => "/readings".to_owned(),
    };
    ApiError::invalid(pointer, error)
}

/// Returns the body of the answer; `sign`: that of the readings, 1 on the tool. The bias is in the sign of the readings.
fn answer(found: &Payload, sign: f64, readings: usize) -> wire::PayloadAnswer {
    wire::PayloadAnswer {
        bias: wrench_answer(Wrench { force: sign * found.force_bias, torque: sign * found.torque_bias }),
        payload: wire::Payload { mass_kg: found.mass, center_of_mass: found.center_of_mass.into() },
        mass_uncertainty_kg: found.mass_uncertainty,
        center_of_mass_uncertainty_m: Some(found.center_uncertainty).filter(|uncertainty| uncertainty.is_finite()),
        force_residual_n: found.force_residual,
        torque_residual_nm: found.torque_residual,
        condition: found.condition,
        axes_verified: found.axes_verified,
        readings,
    }
}
