//! One arm in one period: everything that laws, rows, constraints and limits read about it.

mod capability;
mod motion;

use std::sync::Arc;

use nalgebra::{IsometryMatrix3, Rotation3, Vector3};
use revprio_robot::RobotModel;
use revprio_robot::kinematics::{Configuration, ConfigurationError, TaskFrame};
use revprio_robot::profile::Profile;

use crate::surface::{FollowedSurface, KnownContact};
use crate::wrench::SensorState;
pub(crate) use capability::JointCapability;
pub use motion::{Ahead, JointBraking, JointMotion};

/// The arm of one period: its measured state, and the postures that it will have.
///
/// # The posture of rest
///
/// Where a command depends on the posture, it must be the posture that the arm will have: p, where the arm comes to rest behind
/// its drive if all later commands are zero. The Jacobian of a stretched arm changes so steeply with the posture that lag and dead
/// time would make the arm swing. A controller that needs no such posture acts on the measured one; then both are the same.
#[derive(Debug)]
pub(crate) struct ArmState {
    pub robot: Arc<RobotModel>,
    /// What the joints can give.
    pub capability: JointCapability,
    /// t, s, on the clock of the caller.
    pub time_s: f64,
    /// The time from which profiles count, s.
    pub profiles_start_s: f64,
    /// q̇, measured joint velocity, n, rad/s or m/s; the last command if it is not measured.
    pub joint_velocity: Vec<f64>,
    /// Ẋ = J q̇, base axes, at the tool point, m/s and rad/s.
    pub twist: [f64; 6],
    /// F_e of each tip on the environment, base axes, at the tip, N and N·m; the first one is that of the tool.
    pub wrenches: Vec<[f64; 6]>,
    /// What the sensors of the wrenches remember, in their order.
    pub sensors: Vec<SensorState>,
    /// The surfaces whose normals task frames follow.
    pub surfaces: Vec<FollowedSurface>,
    /// Tool pose at the first step, base frame, m.
    pub initial_pose: IsometryMatrix3<f64>,
    /// L + D T, the time for which the arm goes to rest at a constant velocity, s.
    pub time_to_rest: f64,
    /// p − q, n, rad or m.
    pub distance_to_rest: Vec<f64>,
    /// How far the joints were measured to move since the last state, n, rad or m; zero at the first one.
    pub moved: Vec<f64>,
    /// How far the modelled joints moved while states were missing, n, rad or m, and for how long, s; zero if none was.
    pub missed_way: Vec<f64>,
    /// See [`Self::missed_way`].
    pub missed_time: f64,
    /// q̇⁻, the last command, n, rad/s or m/s.
    pub last_command: Vec<f64>,
    /// a⁻, acceleration of the last command, n, rad/s² or m/s²; empty: jerk limits do not apply.
    pub last_acceleration: Vec<f64>,
    /// q.
    measured: Configuration,
    /// p; `None`: the controller acts at q.
    rest: Option<Configuration>,
    /// The posture at the first step; `None`: no task needs it.
    initial: Option<Configuration>,
    /// m = p + ½ T q̇⁻; `None`: no constraint needs it.
    half_way: Option<Configuration>,
    /// Memory for a joint position, n.
    position: Vec<f64>,
}

/// What a controller reads of the arm besides the measured state.
#[derive(Debug, Clone, Copy, Default)]
#[expect(clippy::struct_excessive_bools, reason = "independent of each other")]
pub(crate) struct Needs {
    /// The posture of rest.
    pub rest: bool,
    /// The posture at the first step.
    pub initial: bool,
    /// The posture half-way.
    pub half_way: bool,
    /// The acceleration of the last command.
    pub acceleration: bool,
}

/// The arm at a posture and a time.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ArmAt<'a> {
    pub arm: &'a ArmState,
    pub configuration: &'a Configuration,
    /// Time at which the targets are read, s.
    pub time_s: f64,
}

impl ArmState {
    /// Returns an arm at rest in the posture zero, with memory for what a controller needs; `time_to_rest`: L + D T, s.
    pub fn new(
        robot: &Arc<RobotModel>,
        capability: JointCapability,
        needs: Needs,
        time_to_rest: f64,
    ) -> Result<Self, ConfigurationError> {
        let zeros = vec![0.0; robot.joint_count()];
        let measured = Configuration::new(robot, &zeros)?;
        Ok(Self {
            robot: Arc::clone(robot),
            capability,
            time_s: 0.0,
            profiles_start_s: 0.0,
            joint_velocity: zeros.clone(),
            twist: [0.0; 6],
            wrenches: vec![[0.0; 6]; robot.tips().len()],
            sensors: Vec::new(),
            surfaces: Vec::new(),
            initial_pose: *measured.tool_pose(),
            time_to_rest,
            distance_to_rest: zeros.clone(),
            moved: zeros.clone(),
            missed_way: zeros.clone(),
            missed_time: 0.0,
            last_command: zeros.clone(),
            last_acceleration: if needs.acceleration { zeros.clone() } else { Vec::new() },
            rest: needs.rest.then(|| measured.clone()),
            initial: needs.initial.then(|| measured.clone()),
            half_way: needs.half_way.then(|| measured.clone()),
            measured,
            position: zeros,
        })
    }

    /// Updates the measured posture (q, n) and the velocity (q̇, n).
    pub fn move_to(&mut self, joint_position: &[f64], joint_velocity: &[f64]) -> Result<(), ConfigurationError> {
        self.measured.update(&self.robot, joint_position)?;
        self.joint_velocity.copy_from_slice(joint_velocity);
        self.twist = self.measured.twist(joint_velocity);
        Ok(())
    }

    /// Updates how far the joints have moved from the posture of the last state (q, n) to the measured one.
    pub fn move_from(&mut self, last: Option<&[f64]>) {
        let position = self.measured.joint_position();
        for (joint, moved) in self.moved.iter_mut().enumerate() {
            *moved = last.map_or(0.0, |last| position[joint] - last[joint]);
        }
    }

    /// Updates the measured posture (q, n) of an arm that does not move.
    pub fn stand_at(&mut self, joint_position: &[f64]) -> Result<(), ConfigurationError> {
        self.measured.update(&self.robot, joint_position)?;
        self.joint_velocity.fill(0.0);
        self.twist = self.measured.twist(&self.joint_velocity);
        Ok(())
    }

    /// Updates the posture at the first step (n), if a task needs it and it is not known yet.
    pub fn start_at(&mut self, joint_position: &[f64]) -> Result<(), ConfigurationError> {
        match &mut self.initial {
            Some(initial) if initial.joint_position() != joint_position => initial.update(&self.robot, joint_position),
            Some(_) | None => Ok(()),
        }
    }

    /// Continues the surfaces; `known`: what is known of the contact of an index among all axes with the contact law.
    pub fn recall_surfaces(&mut self, known: impl Fn(usize) -> KnownContact) {
        for surface in &mut self.surfaces {
            surface.recall(known(surface.contact), &self.measured);
        }
    }

    /// Updates the normals of the surfaces by the wrenches; `time`: since the last state, s. Returns whether all are finite.
    pub fn update_surfaces(&mut self, time: f64) -> bool {
        for surface in &mut self.surfaces {
            let [x, y, z, ..] = self.wrenches[surface.tip];
            surface.update(&self.measured, (Vector3::new(x, y, z), time));
        }
        self.surfaces.iter().all(|surface| surface.estimate.is_valid())
    }

    /// Returns the force of a tip on its environment, base axes, N.
    pub fn force(&self, tip: usize) -> Vector3<f64> {
        let [x, y, z, ..] = self.wrenches[tip];
        Vector3::new(x, y, z)
    }

    /// Returns the rotation from the stated axes of a task frame to those of the surface that it follows; `None`: it follows none.
    pub fn turn_of(&self, frame: &TaskFrame) -> Option<&Rotation3<f64>> {
        self.surfaces.iter().find(|surface| surface.turns(frame)).map(|surface| &surface.turn)
    }

    /// Returns the arm's posture at the first step; the measured one if no task needs it.
    pub fn initial(&self) -> &Configuration {
        self.initial.as_ref().unwrap_or(&self.measured)
    }

    /// Updates the posture of rest and that half-way from the measured posture, the distance to rest and the last command;
    /// `period`: T, s.
    pub fn look_ahead(&mut self, period: f64) -> Result<(), ConfigurationError> {
        let Self { robot, measured, rest, half_way, position, distance_to_rest, last_command, .. } = self;
        if let Some(rest) = rest {
            write_sum(position, measured.joint_position(), 1.0, distance_to_rest);
            rest.update(robot, position)?;
        }
        if let Some(half_way) = half_way {
            let rest = rest.as_ref().unwrap_or(measured);
            write_sum(position, rest.joint_position(), 0.5 * period, last_command);
            half_way.update(robot, position)?;
        }
        Ok(())
    }

    /// Returns a time of the caller on the clock of the profiles, s.
    pub fn profile_time(&self, time_s: f64) -> f64 {
        time_s - self.profiles_start_s
    }

    /// Returns the time at which a profile is read in place of a later one, s: a law that looks ahead does not leave a target before it jumps.
    pub fn known_time(&self, profile: &Profile, time_s: f64) -> f64 {
        if profile.jumps() { self.time_s } else { time_s }
    }

    /// Returns the arm at the measured posture q.
    pub fn measured(&self) -> ArmAt<'_> {
        ArmAt { arm: self, configuration: &self.measured, time_s: self.time_s }
    }

    /// Returns the arm at the posture of rest p.
    pub fn at_rest(&self) -> ArmAt<'_> {
        ArmAt { arm: self, configuration: self.rest.as_ref().unwrap_or(&self.measured), time_s: self.time_s }
    }

    /// Returns the arm at a posture that it may have when it comes to rest `after` seconds from now.
    pub fn later<'a>(&'a self, configuration: &'a Configuration, after: f64) -> ArmAt<'a> {
        ArmAt { arm: self, configuration, time_s: self.time_s + self.time_to_rest + after }
    }

    /// Returns where the next command moves the arm; `None` unless a constraint needs it.
    pub fn ahead(&self) -> Option<Ahead<'_>> {
        let half_way = self.half_way.as_ref()?;
        Some(Ahead { rest: self.at_rest().configuration, half_way, last_command: &self.last_command })
    }

    /// Returns the motion of the joints before the next command.
    pub fn motion(&self) -> JointMotion<'_> {
        JointMotion {
            position: self.measured.joint_position(),
            distance_to_rest: &self.distance_to_rest,
            last_command: &self.last_command,
            last_acceleration: &self.last_acceleration,
        }
    }
}

/// Overwrites `sum` with `a + factor b`, n each.
fn write_sum(sum: &mut [f64], a: &[f64], factor: f64, b: &[f64]) {
    for (sum, (a, b)) in sum.iter_mut().zip(a.iter().zip(b)) {
        *sum = a + factor * b;
    }
}
