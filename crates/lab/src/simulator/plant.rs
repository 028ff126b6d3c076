//! The world of a run: arm, sensors, contacts, and whoever pushes.

use std::sync::Arc;

use nalgebra::{UnitQuaternion, Vector3};
use revprio_api::wire;
use revprio_robot::RobotModel;
use revprio_robot::kinematics::Configuration;
use revprio_robot::profile::Profile;

use super::arm::Arm;
use super::drive_limits::DriveLimits;
use super::environment::Environment;
use super::field_error::FieldError;
use super::profile::profile;
use super::recording::{AtLimit, Energy, Sample, Sensed};
use super::run::RunError;
use super::scenario::Scenario;
use super::sensors::Sensing;
use super::watchdog::HeldCommand;

/// Arm, sensors, contacts and a push.
pub struct Plant {
    robot: Arc<RobotModel>,
    joint_names: Vec<String>,
    arm: Arm,
    environment: Environment,
    sensing: Sensing,
    external_wrench: Option<Profile>,
    start: [f64; 3],
    now: Now,
    period_s: f64,
    substeps: usize,
    wrench_convention: wire::WrenchConvention,
    wrench_frame: wire::WrenchFrame,
}

/// The tool at one time, base axes.
struct Now {
    configuration: Configuration,
    /// F_e of the contacts, N.
    contact_force: [f64; 3],
}

impl Plant {
    /// The world at the start.
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
            external_wrench: external.map(external_profile).transpose()?,
            start,
            now: Now { configuration, contact_force: [0.0; 3] },
            period_s,
            substeps: scenario.substeps,
            wrench_convention: scenario.controller.wrench_convention,
            wrench_frame: scenario.controller.wrench_frame,
        };
        plant.touch(0.0, period_s);
        Ok(plant)
    }

    /// Joint names, n.
    pub fn joint_names(&self) -> &[String] {
        &self.joint_names
    }

    /// What the contacts took and kept so far.
    pub fn energy(&self) -> Energy {
        self.environment.energy()
    }

    /// Lets a period pass under a command (n), beginning at a time, s.
    pub fn advance(&mut self, command: &[f64], time_s: f64) -> Result<(), RunError> {
        self.arm.command(command);
        let dt = self.period_s / self.substeps as f64;
        for step in 1..=self.substeps {
            self.arm.advance(dt);
            let time_s = time_s + step as f64 * dt;
            self.now.configuration = Configuration::new(&self.robot, self.arm.position())
                .map_err(|source| RunError::Diverged { time_s, source })?;
            self.touch(time_s, dt);
        }
        Ok(())
    }

    fn touch(&mut self, time_s: f64, dt: f64) {
        let Now { configuration, contact_force } = &mut self.now;
        let [x, y, z, ..] = configuration.twist(self.arm.velocity());
        *contact_force = self.environment.step(tool_position(configuration), [x, y, z], time_s, dt);
    }

    /// What is the case while a force (N, base axes) pushes the tool besides what the scenario says, and what the sensors
    /// tell of it.
    pub fn measure(&mut self, time_s: f64, pushed: [f64; 3]) -> Measured {
        let external = self.external_wrench.as_ref().map(|wrench| wrench.at(time_s).value);
        let external = |row: usize| external.as_ref().map_or(0.0, |wrench| wrench[row]);
        let contact = self.now.contact_force;
        // The tool pushes back on whoever pushes it: one more part of its environment.
        let external_force = [0, 1, 2].map(|i| external(i) + pushed[i]);
        let (force, torque) = ([0, 1, 2].map(|i| contact[i] - external_force[i]), [3, 4, 5].map(|i| 0.0 - external(i)));
        let mut sensed = Sensed {
            joint_position: self.arm.position().to_vec(),
            joint_velocity: self.arm.velocity().to_vec(),
            force: self.as_expected(force),
            torque: self.as_expected(torque),
        };
        self.sensing.sense(&mut sensed);
        Measured { sensed, force, torque, external_force }
    }

    /// Force or torque on the environment with the sign and along the axes that the controller expects.
    fn as_expected(&self, vector: [f64; 3]) -> [f64; 3] {
        let vector = match self.wrench_convention {
            wire::WrenchConvention::OnEnvironment => vector,
            wire::WrenchConvention::OnTool => vector.map(|entry| -entry),
        };
        match self.wrench_frame {
            wire::WrenchFrame::Base => vector,
            wire::WrenchFrame::Tool => {
                let tool = self.now.configuration.tool_pose().rotation;
                tool.inverse_transform_vector(&Vector3::from(vector)).into()
            }
        }
    }

    /// Whether the controller is told the truth as it is recorded.
    fn is_told_all(&self) -> bool {
        self.sensing.is_perfect()
            && self.wrench_convention == wire::WrenchConvention::OnEnvironment
            && self.wrench_frame == wire::WrenchFrame::Base
    }

    /// The sample of a period, before the command acts.
    pub fn sample(
        &self,
        period: u64,
        time_s: f64,
        measured: Measured,
        obeyed: &HeldCommand,
        tasks: &[wire::ControllerTask],
    ) -> Sample {
        let answer = &obeyed.answer;
        let position = tool_position(&self.now.configuration);
        let orientation = UnitQuaternion::from_rotation_matrix(&self.now.configuration.tool_pose().rotation);
        Sample {
            time_s,
            joint_position: self.arm.position().to_vec(),
            joint_velocity: answer.joint_velocity.clone(),
            actual_velocity: self.arm.velocity().to_vec(),
            position,
            orientation: [orientation.w, orientation.i, orientation.j, orientation.k],
            position_error: [0, 1, 2].map(|i| position[i] - self.start[i]),
            force: measured.force,
            torque: measured.torque,
            external_force: measured.external_force,
            sensed: (!self.is_told_all()).then(|| Box::new(measured.sensed)),
            target_force: target_force(tasks, answer),
            wall_distance: self.environment.wall_distance(),
            path: answer.solver.path,
            status: answer.solver.status,
            kkt_residual: answer.solver.kkt_residual,
            smallest_singular_value: answer.singularity.smallest_singular_value,
            manipulability: answer.singularity.manipulability,
            residual_norms: answer.tasks.iter().map(|task| task.residual_norm).collect(),
            limits: AtLimit::of(answer, &self.joint_names),
            energy: self.energy(),
            answered: obeyed.is_new,
            answer_age: period.saturating_sub(answer.sequence),
        }
    }
}

/// A wrench over time: force and torque.
pub fn external_profile(wrench: &wire::Profile) -> Result<Profile, FieldError> {
    profile(wrench, 6, "/external_wrench")
}

fn tool_position(configuration: &Configuration) -> [f64; 3] {
    configuration.tool_pose().translation.vector.into()
}

/// A state as it is and as it is told.
pub struct Measured {
    sensed: Sensed,
    /// F_e on all that the tool touches, and its torque; base axes.
    force: [f64; 3],
    torque: [f64; 3],
    external_force: [f64; 3],
}

impl Measured {
    /// What the controller is told.
    pub fn state(&self, sequence: u64, time_s: f64) -> wire::State {
        wire::State {
            sequence,
            time_s,
            joint_position: self.sensed.joint_position.clone().into(),
            joint_velocity: Some(self.sensed.joint_velocity.clone().into()),
            wrench: Some(wire::Wrench { force: self.sensed.force, torque: self.sensed.torque }),
        }
    }
}

/// F_d on x, y and z, from the answers of the tasks that the axes belong to.
pub fn target_force(tasks: &[wire::ControllerTask], answer: &wire::StepAnswer) -> [Option<f64>; 3] {
    let mut target = [None; 3];
    for (task, outcome) in tasks.iter().zip(&answer.tasks) {
        // Along other axes there is no force on x, y or z to tell.
        if task.frame != wire::Frame::Base {
            continue;
        }
        for (axis, &force) in task.axes.iter().flatten().zip(outcome.target_force.iter().flatten()) {
            if let Some(slot) = target.get_mut(*axis as usize) {
                *slot = force;
            }
        }
    }
    target
}
