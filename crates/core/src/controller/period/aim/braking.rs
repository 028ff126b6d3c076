//! The requests of the tasks, bounded by what the joints can give.
//!
//! # How an integrator is bounded
//!
//! The velocity of row r can at most be Σ_j |J_rj| V_j. Force, impedance and hybrid laws ask for no more, unless
//! [`AntiWindup::ExceptDamping`] keeps them as published.

use nalgebra::{Cholesky, Dyn};

use crate::arm_state::JointCapability;
use crate::controller::config::{AntiWindup, ControllerConfig, TaskConfig};
use crate::controller::period::row_space::RowSpace;
use crate::law::{Braking, Law, PositionLaw, TaskState, TaskVector, braking_factor, linear_share};
use crate::linalg::{Matrix, Vector};
use crate::rows::TaskRows;
use crate::task::{Task, TaskStack};

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
///
/// # Joints with a jerk limit
///
/// Let joint j have the jerk limit J_j. It brakes with a_j' = min(η a_j, 0.6 J_j/K) instead of η a_j, and the reaction time τ
/// becomes θ = τ + max_j 3 a_j'/2J_j, because its acceleration must change first. The profile of
/// [`PositionLaw`](crate::law::PositionLaw) then demands at most J_j/6:
///
/// - On the first part the jerk is at most K² s_0 = φ a' K. With φ = 1 − K θ this is at most a'/4θ ≤ J/6; with φ = 0.1 it is
///   at most 0.06 J.
/// - On the second part it is t a'³ s/(s + t a')³ with t = (1 − φ)/K, at most 4 a'/27 t. Both t = θ and t = 0.9/K give at
///   most J/10.
///
/// A stiff gain and a small jerk limit thus brake early. A joint with J ≥ K η a_j/0.6 loses no deceleration.
pub const BRAKING_SHARE: f64 = 0.4;

/// a_j' K/J_j at most.
const JERK_SHARE: f64 = 0.6;

/// Part of the reaction time per time a_j'/J_j. Its product with [`JERK_SHARE`] is the largest K θ that the linear range bears.
const DELAY_PER_CHANGE: f64 = 1.5;

/// λ, singular value of the weighed rows of the tool below which the estimate of joint velocities gives way.
///
/// Less than half of the default threshold of damping, so that the estimate is right wherever tasks are not damped.
const REGULARISATION: f64 = 0.02;

/// The memory in which requests are bounded, and the factors of one period.
#[derive(Debug)]
pub(super) struct RequestBounds {
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

impl RequestBounds {
    /// Allocates the memory for a checked configuration.
    pub fn new(config: &ControllerConfig) -> Self {
        let n = config.robot.joint_count();
        let is_pose =
            |task: &TaskConfig| task.rows.joint(&config.robot, 0).is_none() && matches!(task.law, Law::Position(_));
        let first_pose = config.tasks.iter().position(is_pose).unwrap_or(0);
        // A posture below moves in the null space of the pose and does not change its motion.
        let is_stacked = |(k, task): &(usize, &TaskConfig)| {
            task.law.bounds().is_none() && (*k < first_pose || task.rows.joint(&config.robot, 0).is_none())
        };
        let stacked = config.tasks.iter().enumerate().filter(is_stacked).map(|(k, _)| k).collect();
        let (gram, joint_velocity) = (Matrix::zeros(n, n), Vector::zeros(n));
        Self { stacked, gram, factors: None, joint_velocity, row_space: RowSpace::default() }
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
        (config, joints): (&ControllerConfig, &JointCapability),
        tasks: &TaskStack,
        state: &TaskState,
        velocity: TaskVector,
    ) -> TaskVector {
        let task = &config.tasks[k];
        match &task.law {
            Law::Position(law) if *law.braking() != Braking::None => {
                let feedback = law.feedback(state);
                let factor = if task.rows.joint(&config.robot, 0).is_some() {
                    joint_factors(law, &task.rows, (config, joints), &feedback)
                } else {
                    let factor = self.tool_factor(k, law, (config, joints), tasks, &feedback);
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
                    let largest = largest_speed(joints, jacobian, row) / config.weight(k, row);
                    velocity[row].clamp(-largest, largest)
                })
            }
            _ => velocity,
        }
    }

    /// Returns the acceleration that the joints can give row `row` of task `k` while the other tasks keep their velocities, m/s²
    /// or rad/s²; infinite without limits.
    pub fn row_acceleration(
        &mut self,
        (k, row): (usize, usize),
        (config, joints): (&ControllerConfig, &JointCapability),
        tasks: &TaskStack,
    ) -> f64 {
        let jacobian = &tasks.tasks()[k].jacobian;
        let unit =
            TaskVector::from_fn(jacobian.nrows(), |other| if other == row { config.weight(k, row) } else { 0.0 });
        self.update_joint_velocity(k, tasks, &unit);
        let ratios = joints.deceleration.iter().zip(&self.joint_velocity).map(|(a, w)| a / w.abs());
        // Near a singularity w moves the row less than asked.
        let moved: f64 = jacobian.row(row).iter().zip(&self.joint_velocity).map(|(entry, w)| entry * w).sum();
        ratios.fold(f64::INFINITY, f64::min) * (moved / config.weight(k, row)).abs()
    }

    /// Computes the joint velocities that move `tasks`, with the Jacobians of this period, and returns them. A row that no joint
    /// moves at any posture, `moved`, is not near singular: it is left out.
    pub fn row_space(&mut self, tasks: &TaskStack, moved: &[Vec<bool>]) -> &RowSpace {
        let equations = tasks.tasks().iter().zip(moved).filter(|(task, _)| task.is_equation());
        let rows = equations.flat_map(|(task, moved)| task.jacobian.row_iter().zip(moved));
        self.row_space.update(rows.filter(|(_, moved)| **moved).map(|(row, _)| row));
        &self.row_space
    }

    /// Returns the part of a joint velocity (n) in the null space of tasks. It replaces what [`Self::row_space`] has computed.
    pub fn null_space_part(&mut self, tasks: &[Task], velocity: &Vector) -> &Vector {
        self.joint_velocity.copy_from(velocity);
        self.row_space.update(tasks.iter().flat_map(|task| task.jacobian.row_iter()));
        self.row_space.remove_from(&mut self.joint_velocity);
        &self.joint_velocity
    }

    /// Returns f of a motion to a posture (v, n) of which the null space of the tasks is left; `gain`: K, 1/s. Needs
    /// [`Self::row_space`] of this period.
    pub fn null_space_factor(&mut self, joints: &JointCapability, feedback: &Vector, gain: f64) -> f64 {
        self.joint_velocity.copy_from(feedback);
        self.row_space.remove_from(&mut self.joint_velocity);
        let (ratio, speed_ratio) = self.ratios(joints, gain);
        factor(ratio, linear_share_of_all(joints, gain), speed_ratio)
    }

    /// Returns the smallest ratio of the deceleration that a joint can give to the one that w demands, and that of speeds;
    /// `gain`: K, 1/s.
    fn ratios(&self, joints: &JointCapability, gain: f64) -> (f64, f64) {
        (0..joints.speed.len()).fold((f64::INFINITY, f64::INFINITY), |(ratio, speed_ratio), joint| {
            let w = self.joint_velocity[joint].abs();
            (ratio.min(braking(joints, joint, gain) / (gain * w)), speed_ratio.min(joints.speed[joint] / w))
        })
    }

    /// Returns f of task `k` of rows of the tool.
    fn tool_factor(
        &mut self,
        k: usize,
        law: &PositionLaw,
        (config, joints): (&ControllerConfig, &JointCapability),
        tasks: &TaskStack,
        feedback: &[f64],
    ) -> f64 {
        let own = |row: usize| max_acceleration(law, row) / (law.gain()[row] * feedback[row].abs());
        let ratio = (0..feedback.len()).map(own).fold(f64::INFINITY, f64::min);
        let gain = law.gain().max();
        let linear = linear_share_of_all(joints, gain);
        // |w_j| ≤ |w| ≤ |v| / 2λ: near the target this settles it without the factors.
        let feedback = config.weighed(k, feedback);
        let bound = norm(&feedback) / (2.0 * REGULARISATION);
        let weakest = (0..joints.speed.len()).map(|joint| braking(joints, joint, gain)).fold(f64::INFINITY, f64::min);
        let slowest = joints.speed.iter().copied().fold(f64::INFINITY, f64::min);
        if gain * bound <= linear * weakest && bound <= slowest {
            return factor(ratio, linear, f64::INFINITY);
        }
        self.update_joint_velocity(k, tasks, &feedback);
        let (joint_ratio, speed_ratio) = self.ratios(joints, gain);
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
            let n = self.joint_velocity.len();
            self.gram = Matrix::zeros(n, n);
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

/// Returns Σ_j |J_rj| V_j of a row r, with its weight.
fn largest_speed(joints: &JointCapability, jacobian: &Matrix, row: usize) -> f64 {
    let reach = |(joint, speed): (usize, &f64)| match jacobian[(row, joint)] {
        // Not NaN for a joint without limit that does not move the row.
        0.0 => 0.0,
        entry => entry.abs() * speed,
    };
    joints.speed.iter().enumerate().map(reach).sum()
}

/// Returns f of each row of a task of joints.
fn joint_factors(
    law: &PositionLaw,
    rows: &TaskRows,
    (config, joints): (&ControllerConfig, &JointCapability),
    feedback: &[f64],
) -> TaskVector {
    TaskVector::from_fn(feedback.len(), |row| {
        // A task of joints has a joint in each row.
        let Some((joint, rate)) = rows.joint(&config.robot, row) else { return 1.0 };
        let (gain, speed) = (law.gain()[row] * rate, feedback[row].abs());
        let braking = braking(joints, joint, gain);
        let available = braking.min(max_acceleration(law, row));
        let linear = linear_share(gain, joints.reaction + delay(joints, joint, braking));
        factor(available / (gain * speed), linear, joints.speed[joint] / speed)
    })
}

/// Returns φ of a motion of all joints; `gain`: K, 1/s.
fn linear_share_of_all(joints: &JointCapability, gain: f64) -> f64 {
    let delays = (0..joints.speed.len()).map(|joint| delay(joints, joint, braking(joints, joint, gain)));
    linear_share(gain, joints.reaction + delays.fold(0.0, f64::max))
}

/// Returns a_j', the deceleration with which a law brakes a joint; `gain`: K, 1/s.
fn braking(joints: &JointCapability, joint: usize, gain: f64) -> f64 {
    (BRAKING_SHARE * joints.deceleration[joint]).min(JERK_SHARE * joints.jerk[joint] / gain)
}

/// Returns 3 a_j'/2J_j, the part of the reaction time in which the acceleration of a joint changes, s.
fn delay(joints: &JointCapability, joint: usize, braking: f64) -> f64 {
    if joints.jerk[joint].is_finite() { DELAY_PER_CHANGE * braking / joints.jerk[joint] } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The profile of a joint that brakes from 3 rad before its target.
    #[test]
    fn the_profile_demands_at_most_a_sixth_of_the_jerk_limit() {
        let (period, deceleration, jerk) = (1e-4, 10.0, 100.0);
        for (gain, reaction) in [2.0, 5.0, 20.0, 50.0, 500.0].into_iter().flat_map(|gain| [(gain, 0.0), (gain, 0.03)]) {
            let joints = JointCapability::new(vec![f64::INFINITY], vec![deceleration], vec![jerk], reaction);
            let available = braking(&joints, 0, gain);
            let linear = linear_share(gain, reaction + delay(&joints, 0, available));
            let speed = |distance: f64| {
                let bare = gain * distance;
                bare * factor(available / (gain * bare), linear, f64::INFINITY)
            };
            let (mut distance, mut speeds) = (3.0, Vec::new());
            while distance > 1e-6 && speeds.len() < 400_000 {
                // The midpoint rule: its error is far below the bound.
                let middle = distance - 0.5 * period * speed(distance);
                speeds.push(speed(distance));
                distance -= period * speed(middle);
            }
            let largest = |differences: Vec<f64>| differences.into_iter().map(f64::abs).fold(0.0, f64::max);
            let found = largest(speeds.windows(3).map(|v| (v[0] - 2.0 * v[1] + v[2]) / period / period).collect());
            let demanded = largest(speeds.windows(2).map(|v| (v[1] - v[0]) / period).collect());
            assert!(
                found <= 1.02 * jerk / 6.0 && demanded <= BRAKING_SHARE * deceleration,
                "{gain}: {found} {demanded}"
            );
            assert!(found > 0.01 * jerk, "{gain}: {found}");
        }
    }
}
