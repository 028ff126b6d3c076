//! Tasks that make no progress, what holds them, and the motion that leaves such postures.
//!
//! # When a task is stuck
//!
//! The share of a task is its speed along the request ẋ_k, (J_k q̇)ᵀẋ_k / ‖ẋ_k‖, relative to ‖ẋ_k‖ or to 0.1 m/s and
//! 0.5 rad/s, whichever is less, and cut to 0 … 1; separately for metres and radians, and the smaller of both counts. A
//! task that requests less than 5 mm/s and 0.02 rad/s is at its target and counts as followed. A low-pass filter of 0.5 s
//! takes out noise. A task is stuck when its filtered share is below 5 %, or if less than 5 % of its request is passed on and the whole
//! request is more than that of a task at its target.
//!
//! # What holds it
//!
//! Let u be what the task lacks, ẋ_k − J_k q̇, as a unit vector. Joint velocities along w = J_kᵀu reduce it fastest.
//!
//! - *Singularity*: |w| is so small that the task gives the direction up (a quarter of the threshold of damping): no joint moves
//!   the task that way.
//! - *Limits*: little of w is left without the joints that w pushes into their limits and without the directions that
//!   active planes forbid.
//! - *Higher tasks*: little of w is left in the null space of the tasks above.
//!
//! If neither of the last two alone takes w away, both are named.
//!
//! # How the arm leaves
//!
//! While the arm leaves, for [`LEAVING_TIME`], the null-space motion is ζ̇, towards the middle of the joints' ranges, and
//! the stuck task asks for what this motion makes of it, ẋ_k = J_k N ζ̇ with the null-space projector N of the tasks above.
//! They keep their priority and do not notice. Then the task asks for its target again, from another posture.

use crate::controller::config::ControllerConfig;
use crate::controller::period::row_space::RowSpace;
use crate::controller::state::{ANGULAR_REACHED, Obstacle, Progress, REACHED, StuckTask, TaskTarget};
use crate::linalg::Vector;
use crate::resolution::{BoundId, Problem, Resolution, Side};
use crate::task::TaskStack;

/// How often the arm leaves, before the task has reached its target once. An arm whose target is out of reach must not move for
/// ever.
pub const MAX_ATTEMPTS: u32 = 3;

/// The speed that always counts as progress, m/s. A distant target without braking may request more than any arm can do.
const FAST: f64 = 0.1;

/// The same, rad/s.
const ANGULAR_FAST: f64 = 0.5;

/// Time constant of the filter of the share, s: longer than the 0.1 s to 0.3 s in which built-in arms start from
/// rest.
const FILTER_TIME: f64 = 0.5;

/// Share below which a task is stuck: from a full stop, the filter needs three of its time constants to get there.
const STUCK_SHARE: f64 = 0.05;

/// Share below which the time counts since which a task makes no progress: the filter is half-way to a full stop.
const SLOW_SHARE: f64 = 0.5;

/// Part of w that is left, relative to w, below which limits or tasks take it away. A tenth of w moves
/// the task at a hundredth of its speed.
const TAKEN_AWAY: f64 = 0.1;

/// Distance from the end of its range at which a joint is there, rad or m: a degree, small compared with the range of a joint.
const RANGE_END: f64 = 0.02;

/// Difference of two distances from the target up to which an arm that left has come back to the same place: m or rad, and relative to
/// the distance. What is less is not worth another way through half of the joints' ranges.
const SAME_PLACE: (f64, f64) = (0.05, 0.1);

/// What a step tells about the progress of its tasks.
pub(super) struct Observation<'a> {
    pub config: &'a ControllerConfig,
    /// The tasks with the Jacobians of this period.
    pub tasks: &'a TaskStack,
    pub problem: &'a Problem,
    pub targets: &'a [TaskTarget],
    pub resolution: &'a Resolution,
    pub joint_position: &'a [f64],
    pub time_s: f64,
    /// s, the share of all requests that remains.
    pub share: f64,
    /// Time since which requests fade, s; `None`: they do not.
    pub fading_since_s: Option<f64>,
    /// Whether a target is another one than before.
    pub has_new_target: bool,
    /// Distance of each task from its target, m and rad together.
    pub distances: &'a [f64],
}

/// The memory in which the obstacles of a task are found.
#[derive(Debug)]
pub(super) struct ObstacleScratch {
    /// w, n.
    pull: Vector,
    /// What limits leave of w, n.
    inside: Vector,
    /// What higher tasks leave of w, n.
    below: Vector,
    /// The joint velocities that move the higher tasks.
    higher: RowSpace,
}

impl ObstacleScratch {
    /// Allocates the memory for n joints.
    pub fn new(n: usize) -> Self {
        let [pull, inside, below] = [(); 3].map(|()| Vector::zeros(n));
        Self { pull, inside, below, higher: RowSpace::default() }
    }
}

impl Observation<'_> {
    /// Updates the progress of all tasks, and lists those that are stuck.
    pub fn update(
        &self,
        progress: &mut Vec<Progress>,
        stuck: &mut Vec<StuckTask>,
        scratch: &mut ObstacleScratch,
    ) -> bool {
        stuck.clear();
        progress.resize(self.config.tasks.len(), Progress::FREE);
        if self.has_new_target {
            for progress in progress.iter_mut() {
                (progress.attempts, progress.left_at) = (0, None);
            }
        }
        let mut attempts: u32 = progress.iter().map(|progress| progress.attempts).sum();
        let (mut above_moves, mut has_left) = (true, false);
        for (k, progress) in progress.iter_mut().enumerate() {
            if self.config.tasks[k].law.bounds().is_some() {
                continue;
            }
            let leaves = progress.is_leaving(self.time_s) && self.targets[k].streamed.is_none();
            if let Some(since_s) = progress.slow_since_s.filter(|_| leaves) {
                stuck.push(StuckTask { task: k, since_s, held_by: &[], leaving: true });
                continue;
            }
            if progress.leaving_since_s.take().is_some() {
                *progress = Progress { attempts: progress.attempts, left_at: progress.left_at, ..Progress::FREE };
            }
            self.filter(k, progress);
            let slow = progress.slow_since_s.filter(|_| progress.share < STUCK_SHARE);
            let faded = self.fading_since_s.filter(|_| self.share < STUCK_SHARE && self.targets[k].is_short);
            let Some(since_s) = slow.or(faded) else { continue };
            let held_by = self.obstacles(k, scratch);
            let leaving = held_by.contains(&Obstacle::Limits)
                && self.is_at_range_end()
                && attempts < MAX_ATTEMPTS
                && self.config.may_leave(k)
                && self.targets[k].streamed.is_none()
                && above_moves
                && progress
                    .left_at
                    .is_none_or(|before| (self.distances[k] - before).abs() > SAME_PLACE.0 + SAME_PLACE.1 * before);
            if leaving {
                progress.leaving_since_s = Some(self.time_s);
                progress.attempts += 1;
                progress.left_at = Some(self.distances[k]);
                attempts += 1;
                has_left = true;
            }
            above_moves &= !held_by.contains(&Obstacle::Singularity);
            stuck.push(StuckTask { task: k, since_s, held_by, leaving });
        }
        has_left
    }

    /// Returns whether a joint that restricts the answer is at an end of its range. A task that planes or speed limits hold
    /// would not be freed by another posture.
    fn is_at_range_end(&self) -> bool {
        self.resolution.active_limits().any(|(joint, limit)| {
            let (q, limits) = (self.joint_position[joint], &self.config.robot.joints()[joint].limits);
            let end = limits.resting_range()[usize::from(limit.bound.side == Side::Upper)];
            (end - q).abs() < RANGE_END
        })
    }

    /// Updates the filtered share of task `k`.
    fn filter(&self, k: usize, progress: &mut Progress) {
        if self.share == 0.0 {
            return;
        }
        let share = self.share(k);
        let gain = (self.config.period_s / FILTER_TIME).min(1.0);
        progress.share += gain * (share.unwrap_or(1.0) - progress.share);
        if progress.share >= SLOW_SHARE {
            progress.slow_since_s = None;
        } else if progress.slow_since_s.is_none() {
            progress.slow_since_s = Some(self.time_s);
        }
    }

    /// Returns the share of the request of task `k` that it achieves; `None` if it requests almost nothing.
    fn share(&self, k: usize) -> Option<f64> {
        let (requested, achieved) = (&self.targets[k].velocity, &self.resolution.tasks[k].achieved);
        let of_unit = |angular: bool| {
            let rows = (0..requested.len()).filter(|row| self.is_angular(k, *row) == angular);
            let (mut along, mut square) = (0.0, 0.0);
            for row in rows {
                along += requested[row] * achieved[row];
                square += requested[row] * requested[row];
            }
            let (reached, fast) = if angular { (ANGULAR_REACHED, ANGULAR_FAST) } else { (REACHED, FAST) };
            // What the task requests if nothing is scaled.
            let request = square.sqrt() / self.share;
            let along = along / (self.share * self.share);
            (request > reached).then(|| (along / (request * request.min(fast))).clamp(0.0, 1.0))
        };
        match (of_unit(false), of_unit(true)) {
            (Some(linear), Some(angular)) => Some(linear.min(angular)),
            (share, None) | (None, share) => share,
        }
    }

    fn is_angular(&self, k: usize, row: usize) -> bool {
        self.config.tasks[k].rows.is_angular(row, &self.config.robot).unwrap_or(true)
    }

    /// Returns what holds task `k`; empty if the task lacks nothing in this period.
    fn obstacles(&self, k: usize, scratch: &mut ObstacleScratch) -> &'static [Obstacle] {
        let ObstacleScratch { pull, inside, below, higher } = scratch;
        if !self.write_pull(k, pull) {
            return &[];
        }
        let size = pull.norm();
        if size < self.config.near_singular().fading_threshold() {
            return &[Obstacle::Singularity];
        }
        inside.copy_from(pull);
        self.keep_inside_limits(inside);
        below.copy_from(pull);
        higher.update(self.tasks.tasks()[..k].iter().flat_map(|task| task.jacobian.row_iter()));
        higher.remove_from(below);
        let is_taken = |left: &Vector| left.norm() < TAKEN_AWAY * size;
        let limited = inside != pull;
        match (is_taken(inside), is_taken(below)) {
            (true, false) => &[Obstacle::Limits],
            (false, true) => &[Obstacle::HigherTasks],
            _ if limited && k > 0 => &[Obstacle::Limits, Obstacle::HigherTasks],
            _ if limited => &[Obstacle::Limits],
            _ if k > 0 => &[Obstacle::HigherTasks],
            _ => &[Obstacle::Singularity],
        }
    }

    /// Overwrites `pull` with w of task `k`; `false` if the task lacks nothing.
    fn write_pull(&self, k: usize, pull: &mut Vector) -> bool {
        let jacobian = &self.tasks.tasks()[k].jacobian;
        let missing = self.targets[k].velocity.iter().zip(self.resolution.tasks[k].achieved.iter());
        let missing = missing.map(|(requested, achieved)| requested - achieved);
        let size = missing.clone().map(|entry| entry * entry).sum::<f64>().sqrt();
        for (entry, column) in pull.iter_mut().zip(jacobian.column_iter()) {
            *entry = column.iter().zip(missing.clone()).map(|(a, missing)| a * missing).sum::<f64>() / size;
        }
        size > 0.0
    }

    /// Removes from w what the active limits forbid.
    fn keep_inside_limits(&self, left: &mut Vector) {
        for (joint, limit) in self.resolution.active_limits() {
            let outwards = match limit.bound.side {
                Side::Upper => left[joint] > 0.0,
                Side::Lower => left[joint] < 0.0,
            };
            if outwards {
                left[joint] = 0.0;
            }
        }
        let active = |id: BoundId| self.resolution.active_constraints().any(|(_, active)| active.bound.id == id);
        for (_, inequality) in self.problem.constraint_rows().filter(|(id, _)| active(*id)) {
            let normal = inequality.coefficients();
            let outwards = normal.dot(left) / normal.norm_squared();
            left.axpy(-outwards.max(0.0), normal, 1.0);
        }
    }
}
