//! The check of one controller's commands, with its memory.

use std::sync::Arc;

use nalgebra::Vector3;
use revprio_problem::{Inequality, VelocityBox};
use revprio_robot::RobotModel;
use revprio_robot::collision::{CollisionModel, PlacedBody};
use revprio_robot::kinematics::{Configuration, ConfigurationError};

use super::avoidance::{CollisionAvoidance, MAX_STOP_PERIODS, ROWS};
use super::clearance::{ClearanceCheck, Deficit, Scene, UNAVOIDABLE};
use super::obstacle::ObstacleState;
use super::pair::{Pair, World, pairs};
use super::report::{CollisionReport, MAX_REPORTED, PairReport};
use super::rows::{Nominal, Rows};
use super::stop::{Braking, Start, StopPath, longest_stop};
use crate::arm_state::ArmState;
use crate::limits::{Drive, DriveState, full_braking, reaction_time, spare_time};

/// Longest time, s, for which a command that moves the arm may be held. The check of a longer hold would take long.
const LONGEST_HOLD: f64 = 0.25;

/// Part of a period that rounding may add.
const ROUNDING: f64 = 1e-9;

/// How many samples of a stop are one sample of a hold, except for the shortest one. A uniform motion needs few.
const COARSE: usize = 4;

/// The state of a period.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Moment<'a> {
    pub arm: &'a ArmState,
    pub drive_state: &'a DriveState,
}

/// The shapes of the robot and of the world.
#[derive(Debug)]
struct Surroundings {
    avoidance: CollisionAvoidance,
    robot: Arc<RobotModel>,
    model: Arc<CollisionModel>,
    pairs: Vec<Pair>,
    /// Shift of each obstacle since the controller was made, m.
    shifts: Vec<Vector3<f64>>,
    /// Velocity of each obstacle, m/s.
    velocities: Vec<Vector3<f64>>,
}

impl Surroundings {
    fn scene(&self) -> Scene<'_> {
        Scene {
            robot: &self.robot,
            model: &self.model,
            pairs: &self.pairs,
            world: World { obstacles: &self.avoidance.obstacles, shifts: &self.shifts, velocities: &self.velocities },
            min_distance: self.avoidance.min_distance_m,
        }
    }

    /// Moves the obstacles that a state names.
    fn place(&mut self, obstacles: &[ObstacleState]) {
        for (k, obstacle) in self.avoidance.obstacles.iter().enumerate().filter(|(_, obstacle)| obstacle.moves) {
            if let Some(state) = obstacles.iter().find(|state| state.name == obstacle.name) {
                self.shifts[k] = state.position - obstacle.shape.middle();
                self.velocities[k] = state.velocity;
            }
        }
    }
}

/// The memory of a controller that keeps clear.
#[derive(Debug)]
pub(crate) struct CollisionGuard {
    surroundings: Surroundings,
    drive: Drive,
    period: f64,
    keeps_jerk: bool,
    now: PlacedBody,
    /// Distances at the measured posture.
    distances: Vec<f64>,
    path: StopPath,
    check: ClearanceCheck,
    deficits: Vec<Deficit>,
    /// Those of full braking.
    of_braking: Vec<Deficit>,
    /// Whether those of full braking are known in this period.
    knows_braking: bool,
    /// u_b, n.
    braking: Vec<f64>,
    acceleration: Vec<f64>,
    rows: Rows,
    report: CollisionReport,
}

impl CollisionGuard {
    /// Allocates the memory for a checked configuration; `None`: the robot has no shapes.
    pub fn new(
        avoidance: &CollisionAvoidance,
        robot: &Arc<RobotModel>,
        (drive, period): (Drive, f64),
        keeps_jerk: bool,
    ) -> Result<Option<Self>, ConfigurationError> {
        let Some(model) = robot.collision() else { return Ok(None) };
        let n = robot.joint_count();
        let configuration = Configuration::new(robot, &vec![0.0; n])?;
        let pairs = pairs(robot, model, avoidance);
        let now = PlacedBody::new(model, &configuration);
        let rows = Rows::new(model, &configuration, ROWS);
        Ok(Some(Self {
            drive,
            period,
            keeps_jerk,
            now,
            distances: vec![0.0; pairs.len()],
            path: StopPath::new(n, longest_path(robot, period), period),
            check: ClearanceCheck::new(model, configuration, &pairs),
            deficits: vec![Deficit::default(); pairs.len()],
            of_braking: vec![Deficit::default(); pairs.len()],
            knows_braking: false,
            braking: vec![0.0; n],
            acceleration: vec![0.0; n],
            rows,
            report: CollisionReport {
                pairs: Vec::with_capacity(MAX_REPORTED),
                row_names: Vec::with_capacity(ROWS),
                ..CollisionReport::default()
            },
            surroundings: Surroundings {
                robot: Arc::clone(robot),
                model: Arc::clone(model),
                pairs,
                shifts: vec![Vector3::zeros(); avoidance.obstacles.len()],
                velocities: vec![Vector3::zeros(); avoidance.obstacles.len()],
                avoidance: avoidance.clone(),
            },
        }))
    }

    /// Returns the same check for joints that may jump to another velocity.
    pub fn for_joints_that_jump(mut self) -> Self {
        self.path.let_joints_jump();
        self
    }

    /// Begins a period: places the shapes and writes the rows; `limits`: the box of the period.
    pub fn begin(
        &mut self,
        moment: Moment,
        obstacles: &[ObstacleState],
        limits: &VelocityBox,
        rows: &mut [Inequality],
    ) {
        self.surroundings.place(obstacles);
        self.now.update(&self.surroundings.model, moment.arm.measured().configuration);
        let scene = self.surroundings.scene();
        for (pair, distance) in scene.pairs.iter().zip(&mut self.distances) {
            *distance = pair.separation(&self.now, scene.world, 0.0).distance;
        }
        self.set_braking(moment.arm, limits);
        self.write_rows(moment, limits, rows);
        self.report.share = 1.0;
        self.report.held_by = None;
        self.knows_braking = false;
    }

    fn write_rows(&mut self, moment: Moment, limits: &VelocityBox, rows: &mut [Inequality]) {
        let held = (reaction_time(self.period) / self.period).ceil();
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most 1 + 10 ms/T")]
        let periods = held as usize;
        let scene = self.surroundings.scene();
        self.acceleration.fill(0.0);
        let braking = Braking {
            robot: scene.robot,
            command: &self.braking,
            held: periods,
            acceleration: self.keeps_jerk.then_some(self.acceleration.as_slice()),
        };
        self.path.follow(start(moment, self.drive, self.period), braking);
        let nominal = Nominal {
            path: &self.path,
            command: &self.braking,
            held_s: held * self.period,
            limits,
            drive: self.drive,
            period: self.period,
            rate: self.surroundings.avoidance.rate_per_s,
            keeps_jerk: self.keeps_jerk,
        };
        let found = self.rows.write(scene, nominal, &self.distances, rows);
        self.report.rows = [found, found.min(rows.len())];
        self.report.row_names.clear();
        self.report.row_names.extend(rows.iter().map(Inequality::shared_name));
    }

    /// Updates u_b.
    fn set_braking(&mut self, arm: &ArmState, limits: &VelocityBox) {
        for (joint, description) in self.surroundings.robot.joints().iter().enumerate() {
            let last = arm.last_command[joint];
            let acceleration = arm.last_acceleration.get(joint).copied().filter(|_| self.keeps_jerk);
            let braking = full_braking(&description.limits, (last, acceleration), self.period);
            self.braking[joint] = braking.clamp(limits.lower()[joint], limits.upper()[joint]);
        }
    }

    /// Returns u_b, the command of full braking, n.
    pub fn braking(&self) -> &[f64] {
        &self.braking
    }

    /// Returns whether a command (n) may be sent: its stop is free, or no nearer than necessary.
    pub fn allows(&mut self, moment: Moment, command: &[f64]) -> bool {
        if self.knows_braking && self.of_braking.iter().all(|deficit| deficit.bound >= 0.0) {
            return self.is_free(moment, command);
        }
        self.check_stop(moment, command);
        self.report.stop_s = self.path.duration();
        if self.deficits.iter().all(|deficit| deficit.bound >= 0.0) {
            self.report.is_violated = false;
            return true;
        }
        self.report.is_violated = true;
        if !self.knows_braking {
            self.knows_braking = true;
            std::mem::swap(&mut self.deficits, &mut self.of_braking);
            let braking = std::mem::take(&mut self.braking);
            self.check_stop(moment, &braking);
            self.braking = braking;
            std::mem::swap(&mut self.deficits, &mut self.of_braking);
        }
        let min_distance = self.surroundings.avoidance.min_distance_m;
        let scene = self.surroundings.scene();
        let found = self.deficits.iter().zip(&self.of_braking).zip(self.distances.iter().zip(scene.pairs));
        let refused = found.into_iter().find(|((deficit, of_braking), (distance, pair))| {
            let now = (*distance - min_distance).min(0.0);
            // An obstacle that reaches the arm although it brakes is no reason to brake: the rows lead the arm away from it.
            let is_pursued = pair.obstacle_speed(scene.world) > 0.0 && of_braking.bound < now - UNAVOIDABLE;
            let is_no_worse = of_braking.sampled < now - UNAVOIDABLE && deficit.bound >= of_braking.bound;
            !(deficit.comes_no_nearer(now) || is_pursued || is_no_worse)
        });
        let Some((_, (_, pair))) = refused else { return true };
        if self.report.held_by.is_none() {
            self.report.held_by = Some(pair.names.clone());
        }
        false
    }

    /// Returns whether the stop of a command (n) is free, where that of full braking is. The first pair that is too near ends the check.
    fn is_free(&mut self, moment: Moment, command: &[f64]) -> bool {
        self.follow_stop(moment, command);
        self.report.stop_s = self.path.duration();
        let is_free = command == self.braking || {
            let stride = self.path.stride();
            let now = (&self.now, self.distances.as_slice());
            self.check.first_refused(self.surroundings.scene(), (&self.path, stride), now).is_none()
        };
        self.report.is_violated = !is_free;
        is_free
    }

    /// Says in which share of the box around full braking the command lies.
    pub fn set_share(&mut self, share: f64) {
        self.report.share = share;
    }

    /// Says that the stop of a watchdog comes too near.
    pub fn set_violated(&mut self) {
        self.report.is_violated = true;
    }

    /// Checks the stop after a command that acts for one period.
    fn check_stop(&mut self, moment: Moment, command: &[f64]) {
        self.follow_stop(moment, command);
        let scene = self.surroundings.scene();
        self.check.check(scene, &self.path, (&self.now, &self.distances), &mut self.deficits);
    }

    /// Moves the path along the stop after a command that acts for one period.
    fn follow_stop(&mut self, moment: Moment, command: &[f64]) {
        for (joint, acceleration) in self.acceleration.iter_mut().enumerate() {
            *acceleration = (command[joint] - moment.arm.last_command[joint]) / self.period;
        }
        self.follow(moment, (command, 1), self.keeps_jerk);
    }

    /// Moves the path along if a command is held for some periods and braking follows, with jerk limits or without.
    fn follow(&mut self, moment: Moment, (command, held): (&[f64], usize), keeps_jerk: bool) {
        let scene = self.surroundings.scene();
        let acceleration = keeps_jerk.then_some(self.acceleration.as_slice());
        let braking = Braking { robot: scene.robot, command, held, acceleration };
        self.path.follow(start(moment, self.drive, self.period), braking);
    }

    /// Returns for how long a command can be held, at most `longest` (s), before a watchdog brakes, and whether its stop is free then. A
    /// command lasts its own period in any case.
    pub fn hold(&mut self, moment: Moment, command: &[f64], longest: f64) -> (bool, f64) {
        let time = self.hold_time(moment, command, longest);
        (time.is_some(), time.unwrap_or(self.period))
    }

    /// Returns a time, at most `longest` (s), after which a watchdog can brake so that the stop is free: `longest`, or else S, 2 S, 4 S …
    /// as long as that holds, or else T.
    fn hold_time(&mut self, moment: Moment, command: &[f64], longest: f64) -> Option<f64> {
        if self.report.stop_s == 0.0 {
            return Some(longest);
        }
        let shortest = spare_time(self.period);
        let longest = longest.min(shortest.max(LONGEST_HOLD)).min(MAX_STOP_PERIODS as f64 * self.period);
        let Some(refused) = self.refused_after(moment, command, longest) else { return Some(longest) };
        // A hold that lasts until then has the same way until then.
        let longest = longest.min(refused - self.drive.delay_periods as f64 * self.period);
        let (mut held, mut time) = (None, shortest);
        while time < longest && self.refused_after(moment, command, time).is_none() {
            held = Some(time);
            time *= 2.0;
        }
        held.or_else(|| self.may_act_for_a_period(moment, command).then_some(self.period))
    }

    /// Returns whether a watchdog may brake after one period.
    fn may_act_for_a_period(&mut self, moment: Moment, command: &[f64]) -> bool {
        // The command was allowed for one period, and a watchdog brakes as its stop does if that keeps no jerk limits.
        self.report.is_violated || !self.keeps_jerk || self.refused_after(moment, command, self.period).is_none()
    }

    /// Returns when the arm comes too near if a command is held for a time and a watchdog then brakes, all in s; `None`: never.
    ///
    /// A time that ends within a period lies between two that end with one.
    fn refused_after(&mut self, moment: Moment, command: &[f64], time: f64) -> Option<f64> {
        let periods = time / self.period;
        let [least, most] = [(periods + ROUNDING).floor().max(1.0), (periods - ROUNDING).ceil().max(1.0)];
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most LONGEST_HOLD/T")]
        let [least, most] = [least, most].map(|periods| periods as usize);
        let refused = self.refused_after_periods(moment, command, (most, time));
        if least == most {
            refused
        } else {
            refused.or_else(|| self.refused_after_periods(moment, command, (least, time)))
        }
    }

    fn refused_after_periods(&mut self, moment: Moment, command: &[f64], (held, time): (usize, f64)) -> Option<f64> {
        self.follow(moment, (command, held), false);
        let stride = if time > spare_time(self.period) { COARSE } else { 1 } * self.path.stride();
        self.check.first_refused(self.surroundings.scene(), (&self.path, stride), (&self.now, &self.distances))
    }

    /// Returns what the period found, with the nearest pairs.
    pub fn report(&mut self) -> &CollisionReport {
        let scene = self.surroundings.scene();
        let nearest = self.distances.iter().copied().fold(f64::INFINITY, f64::min);
        self.report.least_distance_m = nearest;
        self.report.pairs.clear();
        for (pair, &distance) in scene.pairs.iter().zip(&self.distances) {
            let place = self.report.pairs.partition_point(|known| known.distance_m <= distance);
            if place == MAX_REPORTED {
                continue;
            }
            let found = pair.separation(&self.now, scene.world, 0.0);
            self.report.pairs.truncate(MAX_REPORTED - 1);
            let [link, other] = pair.names.clone();
            let report = PairReport { link, other, distance_m: distance, points: pair.surface_points(&found) };
            self.report.pairs.insert(place, report);
        }
        &self.report
    }
}

fn start(Moment { arm, drive_state }: Moment, drive: Drive, period: f64) -> Start {
    Start { position: arm.measured().configuration.joint_position(), drive_state, drive, period }
}

/// Returns the largest number of commands of a path.
fn longest_path(robot: &RobotModel, period: f64) -> usize {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "positive; more saturates")]
    let held = (LONGEST_HOLD / period).ceil() as usize;
    held.min(MAX_STOP_PERIODS) + 2 * longest_stop(robot, period)
}
