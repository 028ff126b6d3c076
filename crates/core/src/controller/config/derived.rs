//! What follows from the configuration of a controller, without a state.

use revprio_robot::kinematics::{Configuration, ConfigurationError, half_range};
use revprio_robot::{Joint, RobotModel};

use super::controller_config::ControllerConfig;
use super::null_space::is_redundant;
use super::task::TaskConfig;
use super::velocity_limits::Limits;
use crate::arm_state::{ArmState, JointCapability, Needs};
use crate::collision::CollisionGuard;
use crate::constraint::{self, Constraint};
use crate::law::{ContactAxis, ContactContradiction, ContactLaw, Law, MotionPath};
use crate::limits::{JerkLimit, LimitKind, braking_deceleration, may_jump, reaction_time};
use crate::linalg::{Damping, Matrix};
use crate::resolution::Solver;
use crate::rows::TaskRows;
use crate::surface::FollowedSurface;
use crate::wrench::{WrenchSensor, WrenchTerms};

/// Part of the lag and the dead time that may differ from what is stated. A choice: the damping fades over a wider range the larger
/// it is, so more than needed costs accuracy near singularities.
const MISSTATED: f64 = 0.2;

/// Largest K T of loops that come to rest behind every drive, see [`PositionLaw`](crate::law::PositionLaw).
const CALM_GAIN: f64 = 2.0 / 3.0;

/// Number of postures at which a row must be zero to count as one that no joint moves. One is enough unless a row happens to be zero there.
const SAMPLED_POSTURES: usize = 3;

/// Largest offset of these postures, rad or m. Far from zero, rounding hides which rows are zero.
const SAMPLED_RANGE: f64 = 3.0;

impl ControllerConfig {
    /// Returns the limits of the robot that every command keeps; `None` for a fixed box, and for the solver `ClosedForm`,
    /// which ignores limits.
    pub fn kept_limits(&self) -> Option<LimitKind> {
        match self.limits {
            Limits::Robot(kind) if self.solver != Solver::ClosedForm => Some(kind),
            Limits::Robot(_) | Limits::Fixed(_) => None,
        }
    }

    /// Returns whether every command keeps the position limits of the robot.
    pub fn keeps_positions(&self) -> bool {
        self.kept_limits().is_some_and(LimitKind::includes_position)
    }

    /// Returns whether the commands keep the jerk limit of a joint, beyond what its acceleration limit implies.
    pub fn keeps_jerk(&self) -> bool {
        let binds = |joint: &revprio_robot::Joint| JerkLimit::of(&joint.limits, self.period_s).is_some();
        self.kept_limits().is_some_and(LimitKind::includes_acceleration) && self.robot.joints().iter().any(binds)
    }

    /// Returns whether the limits of the controller let some joint change its speed at once.
    pub(in crate::controller) fn limits_let_joints_jump(&self) -> bool {
        !self.limits.include_accelerations() || self.robot.joints().iter().any(|joint| may_jump(&joint.limits))
    }

    /// Returns the damping of this loop, whose reaction time is the period and a part of what the drive adds: the loop acts on
    /// the position of rest, but no drive is exactly as stated.
    pub(in crate::controller) fn fading_damping(&self) -> Option<Damping> {
        let reaction = self.period_s + MISSTATED * self.drive.time_to_rest(self.period_s);
        self.damping.map(|damping| damping.for_reaction(reaction))
    }

    /// Returns the terms of all measured wrenches.
    pub fn wrench_terms(&self) -> WrenchTerms {
        WrenchTerms { convention: self.wrench_convention, frame: self.wrench_frame }
    }

    /// Returns the time constant of the low-pass behind which task `k` reads the wrench, s; 0 without one.
    pub(in crate::controller) fn filter_time(&self, k: usize) -> f64 {
        self.sensor_of(k).map_or(0.0, |sensor| sensor.filter_time)
    }

    /// Returns the sensor whose wrench task `k` reads; `None`: no sensor is stated.
    fn sensor_of(&self, k: usize) -> Option<&WrenchSensor> {
        let tip = self.tasks[k].rows.tip(&self.robot);
        self.wrench_sensors.iter().find(|sensor| Some(sensor.tip) == tip)
    }

    /// Returns the numbers of contact laws that contradict each other, with the indices of their tasks and rows.
    pub fn contact_contradictions(&self) -> impl Iterator<Item = ([usize; 2], ContactContradiction)> {
        let laws = self.tasks.iter().enumerate().filter_map(|(k, task)| Some((k, task.law.contact()?)));
        laws.flat_map(|(k, law)| {
            let deadband = self.sensor_of(k).map_or([0.0; 2], |sensor| sensor.deadband);
            law.contradictions(deadband).map(move |(row, found)| ([k, row], found))
        })
    }

    /// Returns task and row of each axis with the contact law that no joint moves, at any posture.
    pub fn idle_contacts(&self) -> Result<Vec<[usize; 2]>, ConfigurationError> {
        let moved = self.moved_rows(&self.allocate_arm()?)?;
        let presses = |k: usize| self.tasks[k].law.contact().is_some();
        let rows = moved.iter().enumerate().filter(|(k, _)| presses(*k));
        let idle = rows.flat_map(|(k, moved)| (0..moved.len()).filter(|&row| !moved[row]).map(move |row| [k, row]));
        Ok(idle.collect())
    }

    /// Returns the number of axes with the contact law.
    pub(in crate::controller) fn contact_axes(&self) -> usize {
        self.tasks.iter().filter_map(|task| task.law.contact()).map(ContactLaw::rows).sum()
    }

    /// Returns the axes of task `k` among those of all tasks; `None` for other laws, and if there are no axes yet.
    pub(in crate::controller) fn contacts_of<'a>(
        &self,
        k: usize,
        axes: &'a [ContactAxis],
    ) -> Option<&'a [ContactAxis]> {
        let law = self.tasks[k].law.contact()?;
        let before = self.tasks[..k].iter().filter_map(|task| task.law.contact());
        let first: usize = before.map(ContactLaw::rows).sum();
        axes.get(first..first + law.rows())
    }

    /// Returns whether a tool certainly presses on a surface; `axes`: what the contact laws remember.
    pub fn presses_surely(&self, axes: &[ContactAxis]) -> bool {
        let settings = self.tasks.iter().filter_map(|task| task.law.contact()).flat_map(ContactLaw::axes);
        settings.zip(axes).any(|(settings, axis)| axis.presses_surely(settings))
    }

    /// Returns what *near singular* means to this controller: its damping, or that of most arms if it damps nothing.
    ///
    /// Below [`Damping::threshold`] a direction is near singular and damped. Below [`Damping::fading_threshold`] a task gives
    /// the direction up, and it counts as singular.
    pub(in crate::controller) fn near_singular(&self) -> Damping {
        self.damping.unwrap_or(Damping::ARM)
    }

    /// Returns whether the requests fade when nothing is gained: all tasks follow positions or are bounds. A force or a velocity has no
    /// place where the arm could rest, and a loop with a larger gain than [`CALM_GAIN`] turns in most periods.
    pub(in crate::controller) fn comes_to_rest(&self) -> bool {
        let rests = |task: &TaskConfig| match task.largest_gain(&self.robot) {
            Some(gain) => gain * self.period_s <= CALM_GAIN,
            None => task.law.bounds().is_some(),
        };
        self.tasks.iter().all(rests)
    }

    /// Returns the path of the laws that look ahead, which is that of all position laws; `None`: none looks ahead.
    pub fn path(&self) -> Option<MotionPath> {
        self.tasks.iter().find_map(TaskConfig::path)
    }

    /// Returns whether the null-space velocity may differ from zero.
    pub(in crate::controller) fn moves_null_space(&self) -> bool {
        self.null_space.is_some() || self.path().is_some() || (0..self.tasks.len()).any(|k| self.may_leave(k))
    }

    /// Returns whether the arm may leave postures in which task `k` is stuck: the tasks follow positions or velocities,
    /// no force, so the tool is not in contact.
    pub(in crate::controller) fn may_leave(&self, k: usize) -> bool {
        let is_free = |task: &TaskConfig| !task.law.reads_wrench();
        self.leave_local_minima
            && k > 0
            && matches!(self.tasks[k].law, Law::Position(_))
            && is_redundant(&self.robot, &self.tasks)
            && self.tasks.iter().all(is_free)
    }

    /// Allocates the arm that the periods of the controller update.
    ///
    /// The posture of rest differs behind a drive that does not follow at once. Laws that follow no position, without planes, distances and
    /// null-space motions, act on the measured posture: their equations then are those of the literature.
    pub(in crate::controller) fn allocate_arm(&self) -> Result<ArmState, ConfigurationError> {
        let time_to_rest = self.drive.time_to_rest(self.period_s);
        let follows = self.tasks.iter().any(|task| matches!(task.law, Law::Position(_)));
        let half_way = self.constraints.iter().any(Constraint::depends_on_posture);
        let acts_at_rest = follows || self.null_space.is_some() || half_way;
        let needs = Needs {
            rest: time_to_rest > 0.0 && acts_at_rest,
            initial: self.tasks.iter().any(|task| task.rows.has_body()),
            half_way,
            acceleration: self.keeps_jerk(),
        };
        let mut arm = ArmState::new(&self.robot, self.joint_capability(), needs, time_to_rest)?;
        arm.surfaces = self.followed_surfaces();
        Ok(arm)
    }

    /// Returns for each row of each task whether a joint moves it at some posture. The others, such as the height of a planar arm, are zero at every
    /// posture, some of them up to rounding; `arm`: any state of the arm. Rows that turn with a surface count as moved.
    pub(in crate::controller) fn moved_rows(&self, arm: &ArmState) -> Result<Vec<Vec<bool>>, ConfigurationError> {
        let n = self.robot.joint_count();
        let turns = |task: &TaskConfig| task.law.contact().is_some_and(|law| law.surface().is_some());
        let mut moved: Vec<Vec<bool>> = self.tasks.iter().map(|task| vec![turns(task); task.rows.len()]).collect();
        for sample in 0..SAMPLED_POSTURES {
            let configuration = Configuration::new(&self.robot, &sampled_posture(&self.robot, sample))?;
            let mut jacobians: Vec<Matrix> = self.tasks.iter().map(|task| Matrix::zeros(task.rows.len(), n)).collect();
            for (task, jacobian) in self.tasks.iter().zip(&mut jacobians) {
                task.rows.write_jacobian(arm.later(&configuration, 0.0), jacobian);
            }
            for ((task, jacobian), moved) in self.tasks.iter().zip(&jacobians).zip(&mut moved) {
                for ((row, entries), moved) in jacobian.row_iter().enumerate().zip(moved) {
                    // Raw rows are not rounded.
                    let is_angular = task.rows.is_angular(row, &self.robot);
                    *moved |= entries.norm() > is_angular.map_or(0.0, |is_angular| configuration.rounding(is_angular));
                }
            }
        }
        Ok(moved)
    }

    /// Returns the names of the planes whose point no joint moves along the normal, at any posture. They hold nothing back.
    pub fn idle_planes(&self) -> Result<Vec<&str>, ConfigurationError> {
        let postures = (0..SAMPLED_POSTURES).map(|sample| sampled_posture(&self.robot, sample));
        let postures = postures.map(|posture| Configuration::new(&self.robot, &posture));
        let postures = postures.collect::<Result<Vec<_>, _>>()?;
        let is_idle = |constraint: &&Constraint| {
            let rows: Vec<_> = postures.iter().flat_map(|posture| constraint.rows_at(Some(posture))).collect();
            !rows.is_empty() && rows.iter().all(|row| row.coefficients().norm() == 0.0)
        };
        Ok(self.constraints.iter().filter(is_idle).map(Constraint::name).collect())
    }

    /// Returns the surfaces whose normals task frames follow.
    fn followed_surfaces(&self) -> Vec<FollowedSurface> {
        let mut axes = 0;
        let mut surfaces = Vec::new();
        for task in &self.tasks {
            let Some(law) = task.law.contact() else { continue };
            if let (Some(settings), TaskRows::Tool(rows)) = (law.surface(), &task.rows) {
                let tip = rows.frame.tip(&self.robot).unwrap_or_default();
                let axis = (rows.axes.axes()[0], law.direction(0));
                surfaces.push(FollowedSurface::new((axes, tip), &rows.frame, axis, (*settings, law.axes()[0].softest)));
            }
            axes += law.rows();
        }
        surfaces
    }

    /// Allocates the check of distances; `None`: the controller watches none.
    pub(in crate::controller) fn allocate_guard(&self) -> Result<Option<CollisionGuard>, ConfigurationError> {
        let Some((avoidance, _)) = constraint::distances(&self.constraints) else { return Ok(None) };
        let guard = CollisionGuard::new(avoidance, &self.robot, (self.drive, self.period_s), self.keeps_jerk())?;
        Ok(guard.map(|guard| if self.limits_let_joints_jump() { guard.for_joints_that_jump() } else { guard }))
    }

    /// Returns what the limits of the controller permit the joints to give.
    pub(in crate::controller) fn joint_capability(&self) -> JointCapability {
        let joints = 0..self.robot.joint_count();
        let (speed, deceleration) = joints.clone().map(|joint| speed_and_deceleration(self, joint)).unzip();
        let jerk = joints.map(|joint| joint_jerk(self, joint)).collect();
        JointCapability::new(speed, deceleration, jerk, reaction_time(self.period_s))
    }
}

/// Returns a posture in no special place of the joints' ranges, n.
fn sampled_posture(robot: &RobotModel, sample: usize) -> Vec<f64> {
    // Multiples of irrational numbers, less their integral parts, repeat nowhere.
    let share = |joint: usize| (0.618_034 * (sample + 1) as f64 + 0.754_878 * joint as f64).fract();
    let position = |(joint, description): (usize, &Joint)| {
        let half_range = half_range(&description.limits).unwrap_or(1.0).min(SAMPLED_RANGE);
        let middle = f64::midpoint(description.limits.lower, description.limits.upper);
        let middle = if middle.abs() < SAMPLED_RANGE { middle } else { 0.0 };
        middle + half_range * (2.0 * share(joint) - 1.0)
    };
    robot.joints().iter().enumerate().map(position).collect()
}

/// Returns J of a joint, if the limits of the controller keep it and it says more than the acceleration limit.
fn joint_jerk(config: &ControllerConfig, joint: usize) -> f64 {
    let limits = &config.robot.joints()[joint].limits;
    let is_kept = config.kept_limits().is_some_and(LimitKind::includes_acceleration);
    if is_kept && JerkLimit::of(limits, config.period_s).is_some() { limits.jerk } else { f64::INFINITY }
}

/// Returns V and a of a joint as far as the limits of the controller know them.
fn speed_and_deceleration(config: &ControllerConfig, joint: usize) -> (f64, f64) {
    let limits = &config.robot.joints()[joint].limits;
    match &config.limits {
        _ if config.solver == Solver::ClosedForm => (f64::INFINITY, f64::INFINITY),
        Limits::Fixed(allowed) => (allowed.lower()[joint].abs().max(allowed.upper()[joint].abs()), f64::INFINITY),
        Limits::Robot(kind) => (
            if kind.includes_velocity() { limits.velocity } else { f64::INFINITY },
            if kind.includes_position() { braking_deceleration(limits) } else { f64::INFINITY },
        ),
    }
}
