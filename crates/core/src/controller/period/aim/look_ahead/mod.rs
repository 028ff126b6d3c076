//! Looking ahead: a virtual arm that has reached its targets, and joints that follow it within V and A.
//!
//! Two questions are separate here: at which posture all tasks reach their targets at each time ahead ([`newton`]), and how each joint
//! gets there ([`joint_law`]). The velocities of the joints are only wishes. The resolution with its limits has the last word.

mod joint_law;
mod newton;
mod plan;

use revprio_robot::kinematics::Configuration;

use self::joint_law::{Capability, Joint};
use self::newton::{Newton, NullSpaceStep};
use self::plan::Plan;
use super::null_space;
use crate::arm_state::{ArmAt, ArmState};
use crate::controller::config::{ControllerConfig, NullSpaceMotion};
use crate::controller::state::{Memory, TIMES_AHEAD, VirtualArm, has_jumped};
use crate::linalg::{DampingFactor as _, Matrix, Vector};
use crate::rows::TaskRows;
use crate::streaming::{ActiveStream, TaskStreams};

/// Distance from the targets (m and rad together) from which on one step is exact enough: the next error is about its square.
const NEAR: f64 = 1e-3;

/// Distance at which the virtual arm has arrived.
const ARRIVED: f64 = 1e-10;

/// Distance from which on a later time starts from the posture of the time before it: its target has jumped.
const FAR: f64 = 0.1;

/// Steps per time and period, for the first time and for later ones.
const STEPS: [usize; 2] = [8, 4];

/// The virtual arm jumps if a joint moves by more than this many periods at full speed, and a little more, rad or m.
const JUMP: (f64, f64) = (2.0, 1e-3);

/// The virtual arm and the memory in which it is computed.
#[derive(Debug)]
pub(in super::super) struct LookAhead {
    arm: VirtualArm,
    newton: Newton,
    jacobians: Vec<Matrix>,
    /// Tasks that have targets, by index.
    tasks: Vec<usize>,
    /// The ranges of the joints, n.
    ranges: Vec<[f64; 2]>,
    plan: Plan,
    now: Configuration,
    later: Configuration,
    /// The displacement of all rows at the first time.
    first: Vec<f64>,
    null_space: Vector,
    posture: Vec<f64>,
    velocity: Vector,
}

impl LookAhead {
    /// Allocates the virtual arm of a checked configuration; `None`: no law looks ahead.
    pub fn new(config: &ControllerConfig) -> Option<Self> {
        config.path()?;
        let (robot, n) = (&config.robot, config.robot.joint_count());
        let tasks: Vec<usize> = (0..config.tasks.len()).filter(|&k| config.tasks[k].law.bounds().is_none()).collect();
        let heights: Vec<usize> = tasks.iter().map(|&k| config.tasks[k].rows.len()).collect();
        let range = |joint: &revprio_robot::Joint| {
            if config.keeps_positions() {
                [joint.limits.lower, joint.limits.upper]
            } else {
                [f64::NEG_INFINITY, f64::INFINITY]
            }
        };
        let zero = vec![0.0; n];
        let configuration = Configuration::new(robot, &zero).ok()?;
        Some(Self {
            arm: VirtualArm::at(&zero),
            newton: Newton::new(&heights, scales(config)),
            jacobians: heights.iter().map(|&m| Matrix::zeros(m, n)).collect(),
            tasks,
            ranges: robot.joints().iter().map(range).collect(),
            plan: Plan::new(),
            now: configuration.clone(),
            later: configuration,
            first: Vec::with_capacity(heights.iter().sum()),
            null_space: Vector::zeros(n),
            posture: zero,
            velocity: Vector::zeros(n),
        })
    }

    /// Returns the virtual arm of this period.
    pub fn virtual_arm(&self) -> &VirtualArm {
        &self.arm
    }

    /// Moves the virtual arm on to this period, and returns the velocities of the joints that follow it (n); `None` if it jumps.
    pub fn update(
        &mut self,
        config: &ControllerConfig,
        arm: &ArmState,
        previous: &Memory,
        streams: &[ActiveStream],
    ) -> Option<&Vector> {
        self.recall(arm, previous);
        self.posture.copy_from_slice(&self.arm.postures[0]);
        self.solve(0, config, arm, previous, streams);
        self.measure_first(config, arm, streams);
        for k in 1..TIMES_AHEAD.len() {
            if self.target_rests(k, config, arm, streams) {
                let (first, later) = self.arm.postures.split_at_mut(1);
                later[k - 1].copy_from_slice(&first[0]);
            } else {
                self.solve(k, config, arm, previous, streams);
            }
        }
        if self.has_jumped(arm, config.period_s) {
            return None;
        }
        self.follow(arm, streams.is_empty(), config.period_s);
        Some(&self.velocity)
    }

    /// Continues from the virtual arm of the last period, or from the real one.
    fn recall(&mut self, arm: &ArmState, previous: &Memory) {
        let measured = arm.measured().configuration.joint_position();
        let is_elsewhere =
            previous.answered.as_ref().is_some_and(|before| has_jumped(measured, before.joint_position.as_slice()));
        match &previous.virtual_arm {
            Some(known) if !is_elsewhere => self.arm.copy_from(known),
            _ => self.arm.stand_at(arm.at_rest().configuration.joint_position()),
        }
    }

    /// Moves the posture at a time towards the targets.
    fn solve(
        &mut self,
        k: usize,
        config: &ControllerConfig,
        arm: &ArmState,
        previous: &Memory,
        streams: &[ActiveStream],
    ) {
        let mut steps = STEPS[usize::from(k > 0)];
        let mut is_first = true;
        while steps > 0 {
            steps -= 1;
            self.linearise(k, config, arm, streams);
            let mut error = self.newton.error();
            if is_first && k > 0 && error > FAR {
                let (before, after) = self.arm.postures.split_at_mut(k);
                after[0].copy_from_slice(&before[k - 1]);
                self.linearise(k, config, arm, streams);
                error = self.newton.error();
            }
            self.step(k, config, previous, is_first);
            is_first = false;
            if error < NEAR {
                break;
            }
        }
        let _ = ARRIVED;
    }

    /// Computes the Jacobians and the distances from the targets at a time.
    fn linearise(&mut self, k: usize, config: &ControllerConfig, arm: &ArmState, streams: &[ActiveStream]) {
        let configuration = if k == 0 { &mut self.now } else { &mut self.later };
        // Postures in their ranges are finite and fit the robot.
        if configuration.update(&config.robot, &self.arm.postures[k]).is_err() {
            return;
        }
        let at = arm.later(configuration, TIMES_AHEAD[k]);
        for (index, (&task, jacobian)) in self.tasks.iter().zip(&mut self.jacobians).enumerate() {
            let rows = &config.tasks[task].rows;
            rows.write_jacobian(at, jacobian);
            config.weigh_jacobian(task, jacobian);
            let displacement = displacement(rows, at, streams, (task, TIMES_AHEAD[k]));
            let rate = |row: usize| rows.joint(&config.robot, row).map_or(1.0, |(_, rate)| rate);
            self.newton.set(index, jacobian, |row| -displacement[row] * config.weight(task, row) / rate(row));
        }
    }

    /// Makes one step at a time; the first one of a period includes the motion in the null space.
    fn step(&mut self, k: usize, config: &ControllerConfig, previous: &Memory, is_first: bool) {
        let Self { arm, newton, ranges, null_space, .. } = self;
        let posture = &mut arm.postures[k];
        let motion = config.null_space.as_ref().filter(|_| is_first);
        if let Some(motion) = motion {
            let initial = previous.initial_position.as_ref().map_or(posture.as_slice(), Vector::as_slice);
            motion.write(&config.robot, posture, initial, null_space);
            *null_space *= config.period_s;
        }
        let holds = matches!(motion, Some(NullSpaceMotion::InitialPosture { .. }));
        let factor = |motion: f64, smallest: f64| {
            let keeps = config.near_singular().keeps(smallest);
            if holds { keeps * null_space::holding_factor(motion, config.period_s) } else { 1.0 }
        };
        let null_space = motion.map(|_| NullSpaceStep { motion: null_space.as_slice(), factor: &factor });
        let step = newton.step(posture, ranges, null_space.as_ref());
        posture.iter_mut().zip(step).for_each(|(q, step)| *q += step);
        for (q, [lower, upper]) in posture.iter_mut().zip(&*ranges) {
            *q = q.clamp(*lower, *upper);
        }
    }

    /// Remembers the displacements at the first time.
    fn measure_first(&mut self, config: &ControllerConfig, arm: &ArmState, streams: &[ActiveStream]) {
        let at = arm.later(&self.now, TIMES_AHEAD[0]);
        self.first.clear();
        for &task in &self.tasks {
            self.first.extend(displacement(&config.tasks[task].rows, at, streams, (task, TIMES_AHEAD[0])).iter());
        }
    }

    /// Returns whether the targets at a time are those at the first time.
    fn target_rests(&self, k: usize, config: &ControllerConfig, arm: &ArmState, streams: &[ActiveStream]) -> bool {
        let at = arm.later(&self.now, TIMES_AHEAD[k]);
        let mut first = self.first.as_slice();
        self.tasks.iter().all(|&task| {
            let displacement = displacement(&config.tasks[task].rows, at, streams, (task, TIMES_AHEAD[k]));
            let (own, rest) = first.split_at(displacement.len());
            first = rest;
            displacement.iter().zip(own).all(|(a, b)| (a - b).abs() < ARRIVED)
        })
    }

    /// Returns whether the virtual arm moves in a way that joints cannot follow: to another branch, or to a target that has jumped.
    fn has_jumped(&self, arm: &ArmState, period: f64) -> bool {
        let (periods, least) = JUMP;
        let mut speeds = self.arm.postures[0].iter().zip(&self.posture).zip(&arm.capability.speed);
        speeds.any(|((now, before), speed)| (now - before).abs() > periods * period * speed + least)
    }

    /// Computes the velocities of the joints.
    fn follow(&mut self, arm: &ArmState, known: bool, period: f64) {
        let Self { arm: ahead, plan, velocity, .. } = self;
        let can = &arm.capability;
        for (j, (velocity, position)) in
            velocity.iter_mut().zip(arm.at_rest().configuration.joint_position()).enumerate()
        {
            let can = Capability { speed: can.speed[j], acceleration: can.deceleration[j], jerk: can.jerk[j] };
            let first = ahead.postures[0][j];
            // A posture on another branch is no place to plan for.
            let reachable = |k: usize| {
                first + (ahead.postures[k][j] - first).clamp(-can.speed * TIMES_AHEAD[k], can.speed * TIMES_AHEAD[k])
            };
            let joint = Joint { position: *position, last_command: arm.last_command[j], can };
            *velocity = joint.velocity(&std::array::from_fn(reachable), plan, known, period);
        }
    }
}

/// Returns the scale of each joint, n: its acceleration limit relative to the largest one.
fn scales(config: &ControllerConfig) -> Vec<f64> {
    let accelerations = || config.robot.joints().iter().map(|joint| joint.limits.acceleration);
    let largest = accelerations().fold(0.0, f64::max);
    if std::env::var("NOSCALE").is_ok() {
        return accelerations().map(|_| 1.0).collect();
    }
    accelerations().map(|a| if largest.is_finite() && a > 0.0 { a / largest } else { 1.0 }).collect()
}

/// Returns the displacement of a task from its target (m) at a posture and a time ahead, s.
fn displacement(
    rows: &TaskRows,
    at: ArmAt,
    streams: &[ActiveStream],
    (task, after): (usize, f64),
) -> crate::law::TaskVector {
    let moved = TaskStreams::of(streams, task).position.map(|active| active.predicted(at.arm.time_to_rest, after));
    rows.state(at, moved.as_ref()).displacement
}
