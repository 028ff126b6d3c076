//! The posture at which all tasks have reached their targets, by their priority.

use std::ops::RangeInclusive;

use revprio_robot::kinematics::Configuration;

use super::newton::{Newton, NullSpaceStep};
use super::scene::Scene;
use crate::controller::config::{ControllerConfig, NullSpaceMotion};
use crate::linalg::{DampingFactor as _, Matrix, Vector};

/// Distance from the targets (m and rad together) from which on one step is exact enough: the next error is some 10⁻⁵.
pub(super) const NEAR: f64 = 3e-3;

/// Difference of displacements that counts as none, m or rad.
const SAME: f64 = 1e-10;

/// Part of the way to the posture of the null space that a step goes: less than all, because the null space turns with the posture.
const RELAXATION: f64 = 0.5;

/// The targets of all tasks, or places on the lines to them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place<'a> {
    /// Time ahead, s.
    pub after: f64,
    /// Displacement from the targets, one entry per row, m and rad; empty: none.
    pub offset: &'a [f64],
    /// Factor of the offset.
    pub left: f64,
}

impl Place<'_> {
    /// Returns the targets themselves.
    pub fn target(after: f64) -> Self {
        Self { after, offset: &[], left: 0.0 }
    }
}

/// Moves postures towards the targets.
#[derive(Debug)]
pub(super) struct TargetPosture {
    newton: Newton,
    jacobians: Vec<Matrix>,
    /// Tasks that have targets, by index.
    tasks: Vec<usize>,
    /// The ranges of the joints, n.
    ranges: Vec<[f64; 2]>,
    configuration: Configuration,
    null_space: Vector,
    /// The displacements of all rows at [`Self::measure`].
    measured: Vec<f64>,
}

impl TargetPosture {
    /// Allocates the memory of a checked configuration; `None`: the robot has no postures.
    pub fn new(config: &ControllerConfig) -> Option<Self> {
        let (robot, n) = (&config.robot, config.robot.joint_count());
        let tasks: Vec<usize> = (0..config.tasks.len()).filter(|&k| config.tasks[k].law.bounds().is_none()).collect();
        let heights: Vec<usize> = tasks.iter().map(|&k| config.tasks[k].rows.len()).collect();
        let unlimited = [f64::NEG_INFINITY, f64::INFINITY];
        let range = |joint: &revprio_robot::Joint| {
            if config.keeps_positions() { joint.limits.resting_range() } else { unlimited }
        };
        Some(Self {
            newton: Newton::new(&heights, scales(config)),
            jacobians: heights.iter().map(|&m| Matrix::zeros(m, n)).collect(),
            tasks,
            ranges: robot.joints().iter().map(range).collect(),
            configuration: Configuration::new(robot, &vec![0.0; n]).ok()?,
            null_space: Vector::zeros(n),
            measured: Vec::with_capacity(heights.iter().sum()),
        })
    }

    /// Moves a posture (n) to a place by as many steps as it needs; returns the distances before the first and before the last step, m and rad
    /// together. If the first distance is above `far`, the posture starts from `restart` (n) instead.
    pub fn approach(
        &mut self,
        scene: Scene,
        place: Place,
        posture: &mut [f64],
        steps: RangeInclusive<usize>,
        restart: Option<(f64, &[f64])>,
    ) -> [f64; 2] {
        self.linearise(scene, place, posture);
        let first = self.newton.error();
        if let Some((far, other)) = restart
            && first > far
        {
            posture.copy_from_slice(other);
            self.linearise(scene, place, posture);
        }
        let mut last = self.newton.error();
        self.step(scene, posture, true);
        for made in 1..*steps.end() {
            if last < NEAR && made >= *steps.start() {
                break;
            }
            self.linearise(scene, place, posture);
            last = self.newton.error();
            self.step(scene, posture, false);
        }
        [first, last]
    }

    /// Remembers the displacements from a place at a posture (n); returns their weighed norm, m and rad together.
    pub fn measure(&mut self, scene: Scene, place: Place, posture: &[f64]) -> f64 {
        self.linearise(scene, place, posture);
        let Self { configuration, tasks, measured, .. } = self;
        let at = scene.arm.later(configuration, place.after);
        measured.clear();
        for &task in &*tasks {
            measured.extend(scene.displacement(task, at).iter());
        }
        self.newton.error()
    }

    /// Returns the displacements of all rows at [`Self::measure`], m and rad.
    pub fn measured(&self) -> &[f64] {
        &self.measured
    }

    /// Returns whether the targets of two times ahead (s) are the same, as seen from the posture that was computed last.
    pub fn same_targets(&self, scene: Scene, times: [f64; 2]) -> bool {
        let at = times.map(|after| scene.arm.later(&self.configuration, after));
        let moves = |task: &usize| !scene.streams.is_empty() || scene.config.tasks[*task].rows.target_moves();
        self.tasks.iter().copied().filter(moves).all(|task| {
            let [first, second] = at.map(|at| scene.displacement(task, at));
            first.iter().zip(second.iter()).all(|(a, b)| (a - b).abs() < SAME)
        })
    }

    /// Computes the Jacobians and the distances from a place.
    fn linearise(&mut self, scene: Scene, place: Place, posture: &[f64]) {
        let Self { newton, jacobians, tasks, configuration, .. } = self;
        let config = scene.config;
        // A virtual arm has finite postures that fit the robot.
        if configuration.update(&config.robot, posture).is_err() {
            return;
        }
        let at = scene.arm.later(configuration, place.after);
        let mut offset = place.offset;
        for (index, (&task, jacobian)) in tasks.iter().zip(jacobians).enumerate() {
            let rows = &config.tasks[task].rows;
            rows.write_jacobian(at, jacobian);
            config.weigh_jacobian(task, jacobian);
            let displacement = scene.displacement(task, at);
            let (own, rest) = offset.split_at(displacement.len().min(offset.len()));
            offset = rest;
            let rate = |row: usize| rows.joint(&config.robot, row).map_or(1.0, |(_, rate)| rate);
            let left = |row: usize| displacement[row] - place.left * own.get(row).copied().unwrap_or(0.0);
            newton.set(index, jacobian, |row| -left(row) * config.weight(task, row) / rate(row));
        }
    }

    /// Makes one step. The first one of a period includes null-space motions that have no end.
    fn step(&mut self, scene: Scene, posture: &mut [f64], is_first: bool) {
        let Self { newton, ranges, null_space, .. } = self;
        let Scene { config, previous, .. } = scene;
        let motion = config.null_space.as_ref().filter(|motion| is_first || motion.braking_gain().is_some());
        if let Some(motion) = motion {
            let initial = previous.initial_position.as_ref().map_or(&*posture, Vector::as_slice);
            motion.write(&config.robot, posture, initial, null_space);
            // A motion to a posture has no speed here: the virtual arm is where the motion ends.
            let gain = motion.braking_gain().filter(|gain| *gain > 0.0);
            *null_space *= gain.map_or(config.period_s, |gain| RELAXATION / gain);
        }
        let holds = matches!(motion, Some(NullSpaceMotion::InitialPosture { .. }));
        // Near a singularity the null space turns quickly with the posture, and the motion would follow it.
        let factor = |smallest: f64| if holds { config.near_singular().keeps(smallest) } else { 1.0 };
        let null_space = motion.map(|_| NullSpaceStep { motion: null_space.as_slice(), factor: &factor });
        let step = newton.step(posture, ranges, null_space.as_ref());
        for ((q, step), [lower, upper]) in posture.iter_mut().zip(step).zip(&*ranges) {
            // Extreme gains, limits and lengths make steps that no number holds.
            if step.is_finite() {
                *q = (*q + step).clamp(*lower, *upper);
            }
        }
    }
}

/// Returns the scale of each joint, n: its acceleration limit relative to the largest one.
fn scales(config: &ControllerConfig) -> Vec<f64> {
    let accelerations = || config.robot.joints().iter().map(|joint| joint.limits.acceleration);
    let largest = accelerations().fold(0.0, f64::max);
    accelerations().map(|a| if largest.is_finite() && a > 0.0 { a / largest } else { 1.0 }).collect()
}
