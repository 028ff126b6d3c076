//! The axes with the contact law in one period.

use revprio_robot::kinematics::{Configuration, Jacobian, LinkPoint};
use revprio_robot::{RobotModel, Tip};

use super::braking::RequestBounds;
use crate::arm_state::ArmState;
use crate::controller::config::{ControllerConfig, TaskConfig};
use crate::controller::state::{Memory, TaskTarget};
use crate::law::{
    AxisInput, ContactAxis, ContactLaw, ContactPhase, ContactReport, ContactTiming, FaultCause, TargetForce, TaskState,
    TaskVector,
};
use crate::linalg::row_times;
use crate::resolution::Method;
use crate::surface::{NormalEstimate, NormalReport};
use crate::task::{TaskError, TaskStack};
use crate::tolerances::TOLERANCES;

/// Part of the acceleration of the joints with which the law brakes; the rest is left to the other tasks. A choice.
const CONTACT_SHARE: f64 = 0.9;

/// The axes with the contact law, in the order of the tasks.
#[derive(Debug, Default)]
pub struct Contacts {
    axes: Vec<PressingAxis>,
    /// Per task, whether one of its axes is in a fault by force.
    retreats: Vec<bool>,
    /// Per task, for each joint whether its retreat needs it, see [`own_joints`]; empty for tasks without the law.
    own_joints: Vec<Vec<bool>>,
}

/// One axis.
#[derive(Debug, Clone, Copy)]
pub struct PressingAxis {
    /// Its task.
    pub task: usize,
    /// Its row in the task.
    pub row: usize,
    /// 1 or −1, its pressing direction.
    pub direction: f64,
    /// Its times.
    pub timing: ContactTiming,
    /// F_d of this period along the pressing direction, N or N·m.
    pub target: f64,
    /// What it remembers, after the law of this period and before its command.
    pub memory: ContactAxis,
    /// The normal of the surface in this period; `None`: the axis does not follow it.
    pub normal: Option<NormalReport>,
    /// The tip that presses on the surface whose normal the axis follows.
    pub followed_tip: Option<usize>,
    /// The tip whose force the axis presses with; `None`: it is an axis of rotation.
    pushing_tip: Option<usize>,
}

impl Contacts {
    /// Lists the axes of a checked configuration.
    pub fn new(config: &ControllerConfig) -> Self {
        let capability = config.joint_capability();
        let rises = capability.deceleration.iter().zip(&capability.jerk).map(|(a, jerk)| a / jerk);
        let rise = rises.filter(|rise| rise.is_finite()).fold(0.0, f64::max);
        let laws = config.tasks.iter().enumerate().filter_map(|(task, of)| Some((task, of.law.contact()?)));
        let axis = |(task, law, row): (usize, &ContactLaw, usize)| PressingAxis {
            task,
            row,
            direction: law.direction(row),
            timing: ContactTiming::new(
                config.period_s,
                config.drive,
                law.axes()[row].sensor_lag + config.filter_time(task),
                rise,
            ),
            target: 0.0,
            memory: ContactAxis::START,
            normal: None,
            followed_tip: None,
            pushing_tip: config.tasks[task]
                .rows
                .tip(&config.robot)
                .filter(|_| config.tasks[task].rows.is_angular(row, &config.robot) == Some(false)),
        };
        let rows = laws.flat_map(|(task, law)| (0..law.rows()).map(move |row| (task, law, row)));
        let own = |task: &TaskConfig| task.law.contact().map(|_| own_joints(task, &config.robot)).unwrap_or_default();
        Self {
            axes: rows.map(axis).collect(),
            retreats: vec![false; config.tasks.len()],
            own_joints: config.tasks.iter().map(own).collect(),
        }
    }

    /// Returns the axes.
    pub fn axes(&self) -> &[PressingAxis] {
        &self.axes
    }

    /// Starts a period: the axes continue from the memory, and from what the arm did while states were missing.
    pub(super) fn start_period(
        &mut self,
        config: &ControllerConfig,
        arm: &ArmState,
        previous: &Memory,
        tasks: &TaskStack,
    ) {
        self.retreats.fill(false);
        for (index, axis) in self.axes.iter_mut().enumerate() {
            axis.memory = previous.contacts.get(index).copied().unwrap_or(ContactAxis::START);
            let surface = arm.surfaces.iter().find(|surface| surface.contact == index);
            axis.normal = surface.and_then(|surface| surface.report);
            axis.followed_tip = surface.map(|surface| surface.tip);
            axis.memory.normal = surface.map_or(NormalEstimate::START, |surface| surface.estimate);
            if arm.missed_time > 0.0 {
                let way = axis.along(&arm.missed_way, config, tasks);
                axis.memory.advance(&axis.timing, way, arm.missed_time);
            }
        }
    }

    /// Evaluates the law of task `k`: overwrites the velocity of each row and its report, and raises F_d to what it presses with.
    pub(super) fn press(
        &mut self,
        k: usize,
        (law, state, last_velocity): (&ContactLaw, &TaskState, &[f64]),
        force: &mut TargetForce,
        (config, arm, tasks, bounds): (&ControllerConfig, &ArmState, &TaskStack, &mut RequestBounds),
        (velocity, reports): (&mut TaskVector, &mut Vec<ContactReport>),
    ) {
        reports.clear();
        for index in 0..self.axes.len() {
            if self.axes[index].task != k {
                continue;
            }
            let limit = law.axes()[self.axes[index].row].max_force;
            let beside = if limit < f64::INFINITY { self.force_beside(index, config, arm) } else { 0.0 };
            let axis = &mut self.axes[index];
            let row = axis.row;
            let acceleration = CONTACT_SHARE * bounds.row_acceleration((k, row), (config, &arm.capability), tasks);
            axis.target = law.pressing_force(row, force[row].unwrap_or_default());
            force[row] = Some(axis.direction * axis.target);
            let pressed = axis.direction * state.force[row];
            let input = AxisInput {
                force: pressed,
                limited_force: axis.followed_tip.map_or(pressed.max(0.0).hypot(beside), |tip| arm.force(tip).norm()),
                target: axis.target,
                moved: [axis.along(&arm.moved, config, tasks), config.period_s + arm.missed_time],
                to_rest: axis.along(&arm.distance_to_rest, config, tasks),
                last_velocity: axis.direction * last_velocity[row],
                acceleration: acceleration.min(law.axes()[row].max_acceleration),
            };
            let (pressing, mut report) = law.step(row, &axis.timing, input, &mut axis.memory);
            report.normal = axis.normal;
            velocity[row] = axis.direction * pressing;
            reports.push(report);
            if is_fault_by_force(report.phase) {
                self.retreats[k] = true;
            }
        }
    }

    /// Returns the force that none of these axes presses with, N, for an axis that approaches; 0 for others. A sensor whose axes are swapped
    /// reads the surface there.
    fn force_beside(&self, index: usize, config: &ControllerConfig, arm: &ArmState) -> f64 {
        let axis = &self.axes[index];
        let Some(tip) = axis.pushing_tip.filter(|_| axis.memory.phase == ContactPhase::Approach) else { return 0.0 };
        let pressing = self.axes.iter().filter(|other| other.pushing_tip == Some(tip));
        let pressed =
            pressing.filter_map(|other| Some(config.tasks[other.task].rows.force(arm.measured())?[other.row]));
        (arm.force(tip).norm_squared() - pressed.map(|force| force * force).sum::<f64>()).max(0.0).sqrt()
    }

    /// Slows the tasks down that turn with a surface whose normal is not known yet.
    pub(super) fn slide_slowly(&self, config: &ControllerConfig, targets: &mut [TaskTarget]) {
        for axis in &self.axes {
            let Some(most) = axis.normal.and_then(|normal| normal.most_speed) else { continue };
            let rows = &config.tasks[axis.task].rows;
            let follows = |k: &usize| *k != axis.task && config.tasks[*k].rows.has_axes_of(rows);
            let linear = |k: usize, rows: usize| {
                (0..rows).filter(move |row| config.tasks[k].rows.is_angular(*row, &config.robot) == Some(false))
            };
            let square = |k: usize| {
                linear(k, targets[k].velocity.len()).map(|row| targets[k].velocity[row].powi(2)).sum::<f64>()
            };
            // Two tasks of one frame move the tool together.
            let share = most / (0..targets.len()).filter(&follows).map(square).sum::<f64>().sqrt();
            if share < 1.0 {
                for k in (0..targets.len()).filter(&follows) {
                    let velocity = &mut targets[k].velocity;
                    linear(k, velocity.len()).for_each(|row| velocity[row] *= share);
                }
            }
        }
    }

    /// Lets the tasks above one with a fault by force go: nothing but limits and constraints holds its retreat back, and none brings the tool
    /// back afterwards. The tasks that turn with its surface stop: the tool may have slid into a slope that it does not know.
    ///
    /// A task that moves none of the joints that the retreat needs stays, as one of another arm does, and so do the axes that retreat
    /// themselves. Methods that solve all tasks at once give none of them priority: there, the tasks below go too.
    pub(super) fn give_way_to_a_retreat(
        &self,
        config: &ControllerConfig,
        targets: &mut [TaskTarget],
        tasks: &mut TaskStack,
    ) -> Result<(), TaskError> {
        let is_shared = matches!(config.method, Method::Pseudoinverse | Method::DampedLeastSquares);
        for (k, target) in targets.iter_mut().enumerate() {
            let competes = |r: usize| r > k || (is_shared && r != k);
            let is_in_the_way = |&r: &usize| self.retreats[r] && competes(r) && self.moves_own_joint(tasks, k, r);
            target.released_by = (0..self.retreats.len()).find(is_in_the_way);
            if target.released_by.is_some() || self.slid_into_a_slope(k, config) {
                let velocity = target.velocity.as_mut_slice().iter_mut().enumerate();
                velocity.filter(|(row, _)| !self.has_fault(k, *row)).for_each(|(_, velocity)| *velocity = 0.0);
            }
        }
        if !self.retreats.contains(&true) {
            return Ok(());
        }
        tasks.overwrite_jacobians(|k, jacobian| {
            if targets[k].released_by.is_some() {
                let rows = (0..jacobian.nrows()).filter(|row| !self.has_fault(k, *row));
                rows.for_each(|row| jacobian.row_mut(row).fill(0.0));
            }
        })
    }

    /// Returns whether a row of task `k` is an axis in a fault by force.
    fn has_fault(&self, k: usize, row: usize) -> bool {
        let mut own = self.axes.iter().filter(|axis| axis.task == k && axis.row == row);
        self.retreats[k] && own.any(|axis| is_fault_by_force(axis.memory.phase))
    }

    /// Returns whether task `k` moves a joint that the retreat of task `r` needs, beyond rounding.
    fn moves_own_joint(&self, tasks: &TaskStack, k: usize, r: usize) -> bool {
        let jacobian = &tasks.tasks()[k].jacobian;
        let least = TOLERANCES.rank * jacobian.norm();
        jacobian.column_iter().zip(&self.own_joints[r]).any(|(column, own)| *own && column.norm() > least)
    }

    /// Returns whether another task retreats from a surface with which `k` turns.
    fn slid_into_a_slope(&self, k: usize, config: &ControllerConfig) -> bool {
        config.tasks.iter().enumerate().any(|(r, faulty)| {
            let follows = || faulty.law.contact().is_some_and(|law| law.surface().is_some());
            self.retreats[r] && r != k && follows() && config.tasks[k].rows.has_axes_of(&faulty.rows)
        })
    }
}

/// Returns whether an axis retreats from a force, or rests after that.
fn is_fault_by_force(phase: ContactPhase) -> bool {
    matches!(phase, ContactPhase::Fault(cause) if cause != FaultCause::Pull)
}

/// Returns for each joint whether it moves the tip of a task and no other one: an arm leaves its surface without the waist that it shares with
/// another arm. A tip before or behind it on the same arm shares all joints of one of them. Where no joint is its own, all that move the tip count.
fn own_joints(task: &TaskConfig, robot: &RobotModel) -> Vec<bool> {
    let n = robot.joint_count();
    let (Some(tip), Ok(configuration)) = (task.rows.tip(robot), Configuration::new(robot, &vec![0.0; n])) else {
        return vec![true; n];
    };
    let mut jacobian = Jacobian::zeros(n);
    let mut moves = |tip: &Tip| -> Vec<bool> {
        configuration.write_point_jacobian(&LinkPoint::origin(tip.link), &mut jacobian);
        jacobian.column_iter().map(|column| column.norm() > 0.0).collect()
    };
    let of_tip = moves(&robot.tips()[tip]);
    let mut own = of_tip.clone();
    for (_, other) in robot.tips().iter().enumerate().filter(|(index, _)| *index != tip) {
        let shared = moves(other);
        let is_within = |few: &[bool], many: &[bool]| few.iter().zip(many).all(|(few, many)| *many || !*few);
        if !(is_within(&shared, &of_tip) || is_within(&of_tip, &shared)) {
            own.iter_mut().zip(shared).for_each(|(own, shared)| *own &= !shared);
        }
    }
    if own.contains(&true) { own } else { of_tip }
}

impl PressingAxis {
    /// Returns how far a motion of the joints (n, rad or m) moves the tool along the pressing direction, m or rad.
    pub fn along(&self, joints: &[f64], config: &ControllerConfig, tasks: &TaskStack) -> f64 {
        let moved = row_times(&tasks.tasks()[self.task].jacobian, self.row, joints);
        self.direction * moved / config.weight(self.task, self.row)
    }
}
