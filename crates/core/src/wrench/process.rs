//! From a reading to the wrench on the environment.

use nalgebra::Vector3;
use revprio_robot::kinematics::{Configuration, LinkPoint};
use revprio_robot::{RobotModel, Tip};

use super::{Wrench, WrenchSensor, WrenchTerms};

/// What a sensor remembers from period to period.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SensorState {
    /// The wrench of the environment on the tool behind the low-pass, axes and origin of the sensor; `None`: the next reading sets it.
    pub filtered: Option<Wrench>,
    /// Velocity of the centre of mass of the load, base axes, m/s; `None`: the load does not accelerate in the next period.
    pub velocity: Option<Vector3<f64>>,
}

/// An arm when its sensor is read.
#[derive(Debug, Clone, Copy)]
pub struct ArmReading<'a> {
    /// The arm.
    pub robot: &'a RobotModel,
    /// The measured posture.
    pub configuration: &'a Configuration,
    /// Velocity of the modelled joints, n, rad/s or m/s.
    pub joint_velocity: &'a [f64],
    /// Time since the last reading, s.
    pub elapsed: f64,
}

impl SensorState {
    /// Returns F_e on the environment, at the tip, base axes, N and N·m, from a reading of the sensor; updates what it remembers.
    ///
    /// It does not allocate.
    pub fn process(
        &mut self,
        sensor: &WrenchSensor,
        terms: WrenchTerms,
        reading: &[f64; 6],
        arm: ArmReading,
    ) -> [f64; 6] {
        let tip = &arm.robot.tips()[sensor.tip];
        let tip_pose = arm.configuration.tip_pose(tip);
        let pose = tip_pose * sensor.pose;
        let acceleration = self.acceleration(sensor, tip, arm);
        let specific_force = pose.rotation.inverse() * (sensor.gravity - acceleration);
        let measured = terms.along_sensor(reading, &pose.rotation);
        let without_bias = Wrench::combined(1.0, &measured, -1.0, &sensor.bias);
        let load = sensor.load.wrench(&specific_force);
        let on_tool = Wrench::combined(-terms.convention.sign(), &without_bias, -1.0, &load);
        let filtered = self.low_pass(sensor, &on_tool, arm.elapsed);
        let lever = pose.translation.vector - tip_pose.translation.vector;
        let at_tip = outside_deadband(&filtered, sensor.deadband).rotated(&pose.rotation).about(&lever);
        Wrench::combined(-1.0, &at_tip, 0.0, &Wrench::default()).into()
    }

    /// Returns a, the mean acceleration of the centre of mass since the last reading, base axes, m/s².
    fn acceleration(&mut self, sensor: &WrenchSensor, tip: &Tip, arm: ArmReading) -> Vector3<f64> {
        if !sensor.compensates_inertia || arm.elapsed <= 0.0 {
            return Vector3::zeros();
        }
        let center = sensor.pose * nalgebra::Point3::from(sensor.load.center_of_mass);
        let point = LinkPoint::new(tip.link, (tip.offset * center).coords);
        let [vx, vy, vz, ..] = arm.configuration.point_twist(&point, arm.joint_velocity);
        let velocity = Vector3::new(vx, vy, vz);
        let before = self.velocity.replace(velocity).unwrap_or(velocity);
        (velocity - before) / arm.elapsed
    }

    /// Returns the wrench behind the low-pass: y ← y + (1 − e^(−Δt/τ)) (x − y), exact for a reading that stays for Δt.
    fn low_pass(&mut self, sensor: &WrenchSensor, wrench: &Wrench, elapsed: f64) -> Wrench {
        if sensor.filter_time <= 0.0 {
            return *wrench;
        }
        let before = self.filtered.unwrap_or(*wrench);
        let share = -(-elapsed / sensor.filter_time).exp_m1();
        let filtered = Wrench::combined(share, wrench, 1.0 - share, &before);
        self.filtered = Some(filtered);
        filtered
    }

    /// Returns whether all numbers are finite.
    pub(crate) fn is_valid(&self) -> bool {
        let finite = |vector: &Vector3<f64>| vector.iter().all(|entry| entry.is_finite());
        self.filtered.is_none_or(|wrench| finite(&wrench.force) && finite(&wrench.torque))
            && self.velocity.as_ref().is_none_or(finite)
    }
}

/// Returns the wrench without a force or a torque that is shorter than its deadband (N, N·m).
fn outside_deadband(wrench: &Wrench, [force, torque]: [f64; 2]) -> Wrench {
    let kept = |vector: Vector3<f64>, deadband: f64| if vector.norm() < deadband { Vector3::zeros() } else { vector };
    Wrench { force: kept(wrench.force, force), torque: kept(wrench.torque, torque) }
}
