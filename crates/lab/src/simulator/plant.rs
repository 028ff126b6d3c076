//! The simulated world: arm, sensors, contacts and external pushes.

use std::collections::BTreeMap;
use std::sync::Arc;

use nalgebra::UnitQuaternion;
use revprio_api::wire;
use revprio_robot::RobotModel;
use revprio_robot::kinematics::Configuration;
use revprio_robot::profile::Profile;

use super::arm::Arm;
use super::drive_limits::DriveLimits;
use super::environment::Environment;
use super::moving_obstacles::MovingObstacles;
use super::profile::external_wrench;
use super::recording::{Energy, Sample};
use super::run_error::RunError;
use super::scenario::Scenario;
use super::sensors::{Sensed, Sensing};
use super::watchdog::HeldCommand;
use super::wrist_sensor::WristSensor;

/// Arm, sensors, contacts and external push.
pub struct Plant {
    robot: Arc<RobotModel>,
    joint_names: Vec<String>,
    arm: Arm,
    environment: Environment,
    sensing: Sensing,
    external_wrench: Option<Profile>,
    obstacles: MovingObstacles,
    start: [f64; 3],
    tool: ToolState,
    period_s: f64,
    substeps: usize,
    wrist_sensor: WristSensor,
}

/// State of the tool, base axes.
struct ToolState {
    configuration: Configuration,
    /// Force F_e of the contacts, N.
    contact_force: [f64; 3],
}

impl Plant {
    /// Returns the world at the start of a scenario.
    pub fn new(scenario: &Scenario, robot: &Arc<RobotModel>) -> Result<Self, RunError> {
        let position = &scenario.start_joint_position;
        let configuration = Configuration::new(robot, position).map_err(RunError::Start)?;
        let start = tool_position(&configuration);
        let period_s = scenario.period_s();
        let drive_limits = || DriveLimits::new(&scenario.controller.limits, robot, period_s);
        let external = scenario.external_wrench.as_ref();
        let mut plant = Self {
            robot: Arc::clone(robot),
            joint_names: robot.joints().iter().map(|joint| joint.name.clone()).collect(),
            arm: Arm::at_rest(
                position.clone(),
                scenario.velocity_loop,
                scenario.velocity_loop.clamp.then(drive_limits),
            ),
            environment: Environment::new(&scenario.contacts, start)?,
            sensing: Sensing::new(&scenario.sensors, position.len(), period_s, scenario.seed)?,
            external_wrench: external.map(external_wrench).transpose()?,
            obstacles: MovingObstacles::new(&scenario.controller, &scenario.obstacle_motions)?,
            start,
            tool: ToolState { configuration, contact_force: [0.0; 3] },
            period_s,
            substeps: scenario.substeps,
            wrist_sensor: WristSensor::new(&scenario.controller),
        };
        plant.update_contacts(0.0, period_s);
        Ok(plant)
    }

    /// Returns the joint names, n.
    pub fn joint_names(&self) -> &[String] {
        &self.joint_names
    }

    /// Returns the position of the tool point, base frame, m.
    pub fn tool_position(&self) -> [f64; 3] {
        tool_position(&self.tool.configuration)
    }

    /// Returns the energy of the contacts so far.
    pub fn energy(&self) -> Energy {
        self.environment.energy()
    }

    /// Advances by one period under a command (n), from a time, s.
    pub fn advance(&mut self, command: &[f64], time_s: f64) -> Result<(), RunError> {
        self.arm.command(command);
        let dt = self.period_s / self.substeps as f64;
        for step in 1..=self.substeps {
            self.arm.advance(dt);
            let time_s = time_s + step as f64 * dt;
            self.tool.configuration = Configuration::new(&self.robot, self.arm.position())
                .map_err(|source| RunError::Diverged { time_s, source })?;
            self.update_contacts(time_s, dt);
        }
        Ok(())
    }

    fn update_contacts(&mut self, time_s: f64, dt: f64) {
        let ToolState { configuration, contact_force } = &mut self.tool;
        let [x, y, z, ..] = configuration.twist(self.arm.velocity());
        *contact_force = self.environment.step(tool_position(configuration), [x, y, z], time_s, dt);
    }

    /// Returns the state and its measurement while an additional force (N, base axes) pushes the tool.
    pub fn measure(&mut self, time_s: f64, pushed: [f64; 3]) -> Measured {
        let external = self.external_wrench.as_ref().map(|wrench| wrench.at(time_s).value);
        let external = |row: usize| external.as_ref().map_or(0.0, |wrench| wrench[row]);
        let contact = self.tool.contact_force;
        // Whoever pushes the tool is part of its environment and receives the opposite force.
        let external_force = [0, 1, 2].map(|i| external(i) + pushed[i]);
        let (force, torque) = ([0, 1, 2].map(|i| contact[i] - external_force[i]), [3, 4, 5].map(|i| 0.0 - external(i)));
        let [read_force, read_torque] = self.wrist_sensor.read(force, torque, self.tool.configuration.tool_pose());
        let mut sensed = Sensed {
            joint_position: self.arm.position().to_vec(),
            joint_velocity: self.arm.velocity().to_vec(),
            force: read_force,
            torque: read_torque,
        };
        self.sensing.sense(&mut sensed);
        Measured { sensed, obstacles: self.obstacles.states(time_s), force, torque, external_force }
    }

    /// Returns whether the controller receives the recorded state without changes.
    fn measurement_is_recorded_state(&self) -> bool {
        self.sensing.is_perfect() && self.wrist_sensor.is_plain()
    }

    /// Returns the sample of a period, before the command acts.
    pub fn sample(
        &self,
        period: u64,
        time_s: f64,
        measured: Measured,
        held: &HeldCommand,
        tasks: &[wire::ControllerTask],
    ) -> Sample {
        let answer = &held.answer;
        let position = tool_position(&self.tool.configuration);
        let orientation = UnitQuaternion::from_rotation_matrix(&self.tool.configuration.tool_pose().rotation);
        Sample {
            time_s,
            joint_position: self.arm.position().to_vec(),
            actual_velocity: self.arm.velocity().to_vec(),
            position,
            orientation: [orientation.w, orientation.i, orientation.j, orientation.k],
            position_error: [0, 1, 2].map(|i| position[i] - self.start[i]),
            force: measured.force,
            torque: measured.torque,
            external_force: measured.external_force,
            sensed: (!self.measurement_is_recorded_state()).then(|| Box::new(measured.sensed)),
            wall_distance: self.environment.wall_distance(),
            energy: self.energy(),
            answered: held.is_new,
            answer_age: period.saturating_sub(answer.sequence),
            ..Sample::at_rest()
        }
        .answered(tasks, answer, &self.joint_names)
    }
}

fn tool_position(configuration: &Configuration) -> [f64; 3] {
    configuration.tool_pose().translation.vector.into()
}

/// The true state and its measurement.
pub struct Measured {
    sensed: Sensed,
    obstacles: Vec<wire::ObstacleState>,
    /// Force F_e on the environment and its torque, base axes.
    force: [f64; 3],
    torque: [f64; 3],
    external_force: [f64; 3],
}

impl Measured {
    /// Returns the measured state for the controller.
    pub fn state(&self, sequence: u64, time_s: f64) -> wire::State {
        wire::State {
            channels: BTreeMap::new(),
            wrenches: BTreeMap::new(),
            obstacles: self.obstacles.clone(),
            sequence,
            time_s,
            joint_position: self.sensed.joint_position.clone().into(),
            joint_velocity: Some(self.sensed.joint_velocity.clone().into()),
            wrench: Some(wire::Wrench { force: self.sensed.force, torque: self.sensed.torque }),
            targets: BTreeMap::new(),
        }
    }
}
