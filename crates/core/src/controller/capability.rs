//! What the joints can give, and the tasks' requests bounded by it.
//!
//! # How an integrator is bounded
//!
//! The velocity of row r can at most be Σ_j |J_rj| V_j. Force, impedance and hybrid laws ask for no more, unless
//! [`AntiWindup::ExceptDamping`] keeps them as published.

use nalgebra::{Cholesky, Dyn};

use super::row_space::RowSpace;
use super::{AntiWindup, ControllerConfig, Limits, TaskConfig, TaskRows};
use crate::law::{Braking, Law, PositionLaw, TaskState, braking_factor, linear_share};
use crate::limits::{JointBraking, braking_deceleration, reaction_time};
use crate::linalg::{Matrix, TaskVector, Vector};
use crate::resolution::Solver;
use crate::task::TaskStack;

/// η, the share of a joint's deceleration that one position law uses to brake.
///
/// # How a position law brakes
///
/// [`PositionLaw`](crate::law::PositionLaw) needs the ratio ρ of the deceleration that the joints can give to the one
/// that its feedback v demands. On joints both are known: ρ = η a_j / (K |v_j|), row by row.
///
/// On rows of the tool let J be all rows of the tool that tasks control, and w the joint velocity of the feedback of this
/// task alone,
///
/// w = (JᵀJ + λ² I)⁻¹ J_kᵀ v,
///
/// which for λ → 0 is the motion with J_k w = v that leaves the other tasks at rest. While J stays the same, v decays
/// along a straight line, w with it, and a decay at the rate K demands the deceleration K |w_j| of joint j. So
/// ρ = min_j η a_j / (K |w_j|), with the largest K of the rows. Rows have the weights of [`ControllerConfig::characteristic_length_m`]. One factor slows all rows of the task, so the tool keeps
/// its direction, and no joint decelerates by more than η a_j. λ keeps w bounded near singularities, by |v|/2λ; it
/// shortens w by the factor σ²/(σ² + λ²) in a direction with the singular value σ: 2 % at σ = 0.15, where the
/// default damping begins.
///
/// η = 0.4 is the share of one task. The rest is for what the estimate leaves out: the change of J
/// along the way, drives that are slower than stated, and a second task that brakes at the same time. Two tasks together demand at
/// most 0.8 a_j.
///
/// The factor also keeps |f w_j| ≤ V_j: no position law asks for more speed than the joints have.
pub const BRAKING_SHARE: f64 = 0.4;

/// λ, singular value of the weighed rows of the tool below which the estimate of joint velocities gives way.
///
/// Less than half of the default threshold of damping, so that the estimate is right wherever tasks are not damped.
const REGULARISATION: f64 = 0.02;

/// The speed and the deceleration of each joint that the limits of a controller permit.
#[derive(Debug)]
pub(super) struct Capability {
    /// V_j, n, rad/s or m/s; infinite without a limit.
    speed: Vec<f64>,
    /// a_j, n, rad/s² or m/s²; infinite without a limit.
    deceleration: Vec<f64>,
    /// τ, the time for which an arm moves on before it brakes, s.
    reaction: f64,
    /// The tasks whose rows make up J, by index.
    stacked: Vec<usize>,
    /// JᵀJ + λ² I, n × n, or the storage of it.
    gram: Matrix,
    /// Its factors, if they are known in this period.
    factors: Option<Cholesky<f64, Dyn>>,
    /// w, n.
    joint_velocity: Vector,
    /// The joint velocities that move tasks, if a null-space motion needs them.
    row_space: RowSpace,
}

impl Capability {
    /// Derives the capability from a checked configuration.
    pub fn new(config: &ControllerConfig) -> Self {
        let n = config.robot.joint_count();
        let (speed, deceleration) = (0..n).map(|joint| joint_capability(config, joint)).unzip();
        let is_pose =
            |task: &TaskConfig| task.rows.joint(&config.robot, 0).is_none() && matches!(task.law, Law::Position(_));
        let first_pose = config.tasks.iter().position(is_pose).unwrap_or(0);
        // A posture below moves in the null space of the pose and does not change its motion.
        let is_stacked = |(k, task): &(usize, &TaskConfig)| {
            task.law.bounds().is_none() && (*k < first_pose || task.rows.joint(&config.robot, 0).is_none())
        };
        let stacked = config.tasks.iter().enumerate().filter(is_stacked).map(|(k, _)| k).collect();
        let (gram, joint_velocity) = (Matrix::zeros(n, n), Vector::zeros(n));
        let reaction = reaction_time(config.period_s);
        Self {
            speed,
            deceleration,
            reaction,
            stacked,
            gram,
            factors: None,
            joint_velocity,
            row_space: RowSpace::default(),
        }
    }

    /// Returns how the joints brake before planes.
    pub fn joint_braking(&self) -> JointBraking<'_> {
        JointBraking { deceleration: &self.deceleration, reaction_s: self.reaction }
    }

    /// Starts a period: the Jacobians have changed.
    pub fn start_period(&mut self) {
        if let Some(factors) = self.factors.take() {
            self.gram = factors.unpack_dirty();
        }
    }

    /// Returns the velocity that task `k` requests, from that of its law: braked, or bounded. `tasks`: with the Jacobians
    /// of this period.
    pub fn bounded(
        &mut self,
        k: usize,
        config: &ControllerConfig,
        tasks: &TaskStack,
        state: &TaskState,
        velocity: TaskVector,
    ) -> TaskVector {
        let task = &config.tasks[k];
        match &task.law {
            Law::Position(law) if *law.braking() != Braking::None => {
                let feedback = law.feedback(state);
                let factor = if task.rows.joint(&config.robot, 0).is_some() {
                    self.joint_factors(law, &task.rows, config, &feedback)
                } else {
                    let factor = self.tool_factor(k, law, config, tasks, &feedback);
                    TaskVector::from_fn(feedback.len(), |_| factor)
                };
                let braked = |row: usize| match factor[row] {
                    1.0 => velocity[row],
                    factor => state.target_velocity[row] + factor * feedback[row],
                };
                TaskVector::from_fn(velocity.len(), braked)
            }
            law if law.integrates() && config.anti_windup == AntiWindup::Always => {
                let jacobian = &tasks.tasks()[k].jacobian;
                TaskVector::from_fn(velocity.len(), |row| {
                    let largest = self.largest_speed(jacobian, row) / config.weight(k, row);
                    velocity[row].clamp(-largest, largest)
                })
            }
            _ => velocity,
        }
    }

    /// Returns Σ_j |J_rj| V_j of a row r, with its weight.
    fn largest_speed(&self, jacobian: &Matrix, row: usize) -> f64 {
        let reach = |(joint, speed): (usize, &f64)| match jacobian[(row, joint)] {
            // Not NaN for a joint without limit that does not move the row.
            0.0 => 0.0,
            entry => entry.abs() * speed,
        };
        self.speed.iter().enumerate().map(reach).sum()
    }

    /// Returns f of each row of a task of joints.
    fn joint_factors(
        &self,
        law: &PositionLaw,
        rows: &TaskRows,
        config: &ControllerConfig,
        feedback: &[f64],
    ) -> TaskVector {
        TaskVector::from_fn(feedback.len(), |row| {
            // A task of joints has a joint in each row.
            let Some((joint, rate)) = rows.joint(&config.robot, row) else { return 1.0 };
            let (gain, speed) = (law.gain()[row] * rate, feedback[row].abs());
            let available = (BRAKING_SHARE * self.deceleration[joint]).min(max_acceleration(law, row));
            let linear = linear_share(gain, self.reaction);
            factor(available / (gain * speed), linear, self.speed[joint] / speed)
        })
    }

    /// Computes the joint velocities that move `tasks`, with the Jacobians of this period, and returns them.
    pub fn row_space(&mut self, tasks: &TaskStack) -> &RowSpace {
        self.row_space.update(tasks.tasks().iter().filter(|task| task.is_equation()));
        &self.row_space
    }

    /// Returns f of a motion to a posture (v, n) of which the null space of the tasks is left; `gain`: K, 1/s. Needs
    /// [`Self::row_space`] of this period.
    pub fn null_space_factor(&mut self, feedback: &Vector, gain: f64) -> f64 {
        self.joint_velocity.copy_from(feedback);
        self.row_space.remove_from(&mut self.joint_velocity);
        let (ratio, speed_ratio) = self.ratios(self.joint_velocity.as_slice(), gain);
        factor(ratio, linear_share(gain, self.reaction), speed_ratio)
    }

    /// Returns the smallest ratio of the deceleration that a joint can give to the one that joint velocities (n) demand,
    /// and that of speeds; `gain`: K, 1/s.
    fn ratios(&self, velocity: &[f64], gain: f64) -> (f64, f64) {
        let joints = velocity.iter().zip(self.speed.iter().zip(&self.deceleration));
        joints.fold((f64::INFINITY, f64::INFINITY), |(ratio, speed_ratio), (w, (speed, a))| {
            let w = w.abs();
            (ratio.min(BRAKING_SHARE * a / (gain * w)), speed_ratio.min(speed / w))
        })
    }

    /// Returns f of task `k` of rows of the tool.
    fn tool_factor(
        &mut self,
        k: usize,
        law: &PositionLaw,
        config: &ControllerConfig,
        tasks: &TaskStack,
        feedback: &[f64],
    ) -> f64 {
        let own = |row: usize| max_acceleration(law, row) / (law.gain()[row] * feedback[row].abs());
        let ratio = (0..feedback.len()).map(own).fold(f64::INFINITY, f64::min);
        let gain = law.gain().max();
        let linear = linear_share(gain, self.reaction);
        // |w_j| ≤ |w| ≤ |v| / 2λ: near the target this settles it without the factors.
        let feedback = config.weighed(k, feedback);
        let bound = norm(&feedback) / (2.0 * REGULARISATION);
        let smallest = |values: &[f64]| values.iter().copied().fold(f64::INFINITY, f64::min);
        if gain * bound <= linear * BRAKING_SHARE * smallest(&self.deceleration) && bound <= smallest(&self.speed) {
            return factor(ratio, linear, f64::INFINITY);
        }
        self.update_joint_velocity(k, tasks, &feedback);
        let (joint_ratio, speed_ratio) = self.ratios(self.joint_velocity.as_slice(), gain);
        factor(ratio.min(joint_ratio), linear, speed_ratio)
    }

    /// Updates w of task `k`; `feedback`: v with the weights of the Jacobians.
    fn update_joint_velocity(&mut self, k: usize, tasks: &TaskStack, feedback: &[f64]) {
        if self.factors.is_none() {
            self.gram.fill(0.0);
            self.gram.fill_diagonal(REGULARISATION * REGULARISATION);
            for &task in &self.stacked {
                let jacobian = &tasks.tasks()[task].jacobian;
                self.gram.gemm_tr(1.0, jacobian, jacobian, 1.0);
            }
            self.factors = Cholesky::new(std::mem::take(&mut self.gram));
        }
        let jacobian = &tasks.tasks()[k].jacobian;
        for (entry, column) in self.joint_velocity.iter_mut().zip(jacobian.column_iter()) {
            *entry = column.iter().zip(feedback).map(|(a, v)| a * v).sum();
        }
        if let Some(factors) = &self.factors {
            factors.solve_mut(&mut self.joint_velocity);
        } else {
            // Only numbers that overflow have no factors. Then nothing is known, and the task does not move.
            self.gram = Matrix::zeros(self.speed.len(), self.speed.len());
            self.joint_velocity.fill(f64::INFINITY);
        }
    }
}

/// Returns the factor for the ratio of decelerations, φ, and the ratio of speeds; NaN, from 0/0, stands for no demand.
fn factor(ratio: f64, linear: f64, speed_ratio: f64) -> f64 {
    let ratio = if ratio.is_nan() { f64::INFINITY } else { ratio };
    let speed_ratio = if speed_ratio.is_nan() { 1.0 } else { speed_ratio };
    braking_factor(ratio, linear).min(speed_ratio)
}

fn norm(entries: &[f64]) -> f64 {
    entries.iter().map(|entry| entry * entry).sum::<f64>().sqrt()
}

/// Returns the acceleration that the law itself permits on a row.
fn max_acceleration(law: &PositionLaw, row: usize) -> f64 {
    match law.braking() {
        Braking::AtMost(accelerations) => accelerations[row],
        Braking::Joints | Braking::None => f64::INFINITY,
    }
}

/// Returns V and a of a joint as far as the limits of the controller know them.
fn joint_capability(config: &ControllerConfig, joint: usize) -> (f64, f64) {
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
