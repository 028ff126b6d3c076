//! The common parts of all answers with joint velocities.

use crate::clock::Instant;
use revprio_api::wire;
use revprio_core::resolution::{
    ActiveBound, Bound, BoundId, BrokenBound, Certificate, CertifiedLevel, CertifiedProblem, LevelReport, Multipliers,
    Part, Resolution, Side,
};
use revprio_robot::{Joint, RobotModel};

use super::terms;
use crate::constraint_names::ConstraintNames;

/// Converts a resolution to the parts of an answer.
pub struct Outcome<'a> {
    /// The resolution.
    pub resolution: &'a Resolution,
    /// Names of the joints, in order.
    pub joints: Vec<&'a str>,
    /// Names of the tasks, highest priority first.
    pub tasks: Vec<&'a str>,
    /// Names of the inequalities, in order.
    pub inequalities: ConstraintNames<'a>,
    /// The robot, if the limits of the problem are not the robot's.
    pub faster_than: Option<&'a RobotModel>,
}

/// Relative excess of a speed limit that counts as rounding.
const SPEED_TOLERANCE: f64 = 1e-9;

impl Outcome<'_> {
    /// Joint velocities, n.
    pub fn joint_velocity(&self) -> Vec<f64> {
        self.resolution.joint_velocity.as_slice().to_vec()
    }

    /// Outcomes of the tasks. `describe` returns requested velocity and target force of a task.
    pub fn tasks(&self, describe: impl Fn(usize) -> (Vec<f64>, Option<Vec<Option<f64>>>)) -> Vec<wire::TaskOutcome> {
        let outcome = |(k, outcome): (usize, &revprio_core::resolution::TaskOutcome)| {
            let (requested, target_force) = describe(k);
            let achieved: Vec<f64> = outcome.achieved.iter().copied().map(finite).collect();
            let active_row = |(row, active): (usize, &ActiveBound)| wire::ActiveRow {
                row,
                side: terms::side_answer(active.bound.side),
                multiplier: active.multiplier,
            };
            wire::TaskOutcome {
                name: self.tasks[k].to_owned(),
                residual_norm: finite(outcome.residual_norm),
                rank: outcome.rank,
                algorithmic: outcome.algorithmic,
                scale: outcome.scale.filter(|&scale| keeps_direction(scale, &requested, &achieved)),
                requested,
                achieved,
                target_force,
                contact: Vec::new(),
                target_state: None,
                target_age_s: None,
                chunk: None,
                active_rows: self.resolution.active_rows(k).map(active_row).collect(),
            }
        };
        self.resolution.tasks.iter().enumerate().map(outcome).collect()
    }

    /// Active joint limits.
    pub fn active_limits(&self) -> Vec<wire::ActiveLimit> {
        let limit = |(joint, active): (usize, &ActiveBound)| wire::ActiveLimit {
            joint: self.joints[joint].to_owned(),
            side: terms::side_answer(active.bound.side),
            value: active.value,
            multiplier: active.multiplier,
        };
        self.resolution.active_limits().map(limit).collect()
    }

    /// Violated joint limits. Limits that are not the robot's may allow more than its speed limits; a joint that exceeds
    /// them is listed too.
    pub fn violated_limits(&self) -> Vec<wire::ViolatedLimit> {
        let violation = |joint: usize, side: Side, limit: f64, value: f64| wire::ViolatedLimit {
            joint: self.joints[joint].to_owned(),
            side: terms::side_answer(side),
            limit,
            value,
        };
        let broken = self.resolution.broken_limits();
        let broken = broken.map(|(joint, broken)| violation(joint, broken.bound.side, broken.limit, broken.value));
        let is_listed = |joint: usize| self.resolution.broken_limits().any(|(listed, _)| listed == joint);
        let too_fast = self.too_fast().filter(|(joint, ..)| !is_listed(*joint));
        broken.chain(too_fast.map(|(joint, side, limit, value)| violation(joint, side, limit, value))).collect()
    }

    /// Returns the joints that exceed the speed limits of the robot, with side, limit and value.
    fn too_fast(&self) -> impl Iterator<Item = (usize, Side, f64, f64)> {
        let joints = self.faster_than.map_or(&[][..], |robot| robot.joints());
        let found = |(joint, (limits, &value)): (usize, (&Joint, &f64))| {
            let (side, limit) = if value > 0.0 { (Side::Upper, 1.0) } else { (Side::Lower, -1.0) };
            let limit = limit * limits.limits.velocity;
            (value.abs() > limit.abs() * (1.0 + SPEED_TOLERANCE)).then_some((joint, side, limit, value))
        };
        joints.iter().zip(&self.resolution.joint_velocity).enumerate().filter_map(found)
    }

    /// Active inequalities.
    pub fn active_inequalities(&self) -> Vec<wire::ActiveInequality> {
        let active = |(_, active): (usize, &ActiveBound)| wire::ActiveInequality {
            name: self.inequality(active.bound.id),
            bound: active.value,
            multiplier: active.multiplier,
        };
        self.resolution.active_constraints().map(active).collect()
    }

    /// Violated inequalities.
    pub fn violated_inequalities(&self) -> Vec<wire::ViolatedInequality> {
        let violation = |(_, broken): (usize, &BrokenBound)| wire::ViolatedInequality {
            name: self.inequality(broken.bound.id),
            bound: broken.limit,
            value: broken.value,
        };
        self.resolution.broken_constraints().map(violation).collect()
    }

    /// Returns the name of a row of a constraint.
    fn inequality(&self, id: BoundId) -> String {
        self.inequalities.get(id).unwrap_or_default().to_owned()
    }

    /// Contradictions.
    pub fn contradictions(&self) -> Vec<wire::Contradiction> {
        let member = |member: &Bound| {
            let wire::RowName { task, row, inequality } = self.row_name(Some(member.id));
            let joint = member.id.joint().map(|joint| self.joints[joint].to_owned());
            wire::ContradictionMember { task, row, joint, inequality, side: terms::side_answer(member.side) }
        };
        let contradiction = |contradiction: &revprio_core::resolution::Contradiction| wire::Contradiction {
            task: contradiction.task.map(|task| self.tasks[task].to_owned()),
            members: contradiction.members.iter().map(member).collect(),
        };
        self.resolution.contradictions.iter().map(contradiction).collect()
    }

    /// Names of joints.
    pub fn names(&self, joints: &[usize]) -> Vec<String> {
        joints.iter().map(|&joint| self.joints[joint].to_owned()).collect()
    }

    /// Report of the solver.
    pub fn solver(&self) -> wire::SolverReport {
        let report = &self.resolution.solver;
        wire::SolverReport {
            path: terms::path_answer(report.path),
            status: terms::status_answer(report.status),
            iterations: report.iterations,
            failures: report.failures,
            kkt_residual: report.kkt_residual,
            rank_uncertain: report.rank_uncertain,
            working_sets: report.working_sets,
            last_resorts: report.last_resorts,
            levels: self.resolution.levels.iter().map(level_answer).collect(),
        }
    }

    /// Certificate, by name.
    pub fn certificate(&self, certificate: &Certificate) -> wire::Certificate {
        let part = |part: &Part| wire::CertificatePart { problem: part.problem, weight: part.weight };
        wire::Certificate {
            problems: certificate.problems.iter().map(|problem| self.certified_problem(problem)).collect(),
            answer: certificate.answer.iter().map(part).collect(),
        }
    }

    fn certified_problem(&self, problem: &CertifiedProblem) -> wire::CertifiedProblem {
        let level = |level: &CertifiedLevel| wire::CertifiedLevel {
            rows: level.rows.clone(),
            lower: bounds_answer(&level.lower),
            upper: bounds_answer(&level.upper),
            names: level.names.iter().map(|name| self.row_name(*name)).collect(),
        };
        let multipliers = |found: &Multipliers| wire::LevelMultipliers {
            rows: found.rows.iter().copied().map(finite).collect(),
            unknowns: found.unknowns.iter().copied().map(finite).collect(),
        };
        wire::CertifiedProblem {
            lower: bounds_answer(&problem.lower),
            upper: bounds_answer(&problem.upper),
            reference: problem.reference.iter().copied().map(finite).collect(),
            levels: problem.levels.iter().map(level).collect(),
            solution: problem.solution.iter().copied().map(finite).collect(),
            multipliers: problem.multipliers.iter().map(|found| found.as_ref().map(multipliers)).collect(),
        }
    }

    fn row_name(&self, name: Option<BoundId>) -> wire::RowName {
        let (task, row, inequality) = match name {
            Some(BoundId::Task { index, row }) => (Some(self.tasks[index].to_owned()), Some(row), None),
            Some(id @ BoundId::Constraint { .. }) => (None, None, Some(self.inequality(id))),
            Some(BoundId::Joint(_)) | None => (None, None, None),
        };
        wire::RowName { task, row, inequality }
    }

    /// Measures of the distance to singularities.
    pub fn singularity(&self) -> wire::Singularity {
        let singularity = &self.resolution.singularity;
        let (smallest_singular_value, manipulability) = singularity.values();
        wire::Singularity { smallest_singular_value, manipulability, algorithmic: singularity.algorithmic }
    }
}

fn level_answer(level: &LevelReport) -> wire::SolverLevel {
    let residual = |residual: f64| Some(residual).filter(|residual| residual.is_finite());
    wire::SolverLevel {
        iterations: level.iterations,
        clarabel_residual: residual(level.clarabel_residual),
        residual: residual(level.residual),
    }
}

/// Returns bounds with `None` for infinite ones.
fn bounds_answer(bounds: &[f64]) -> Vec<Option<f64>> {
    bounds.iter().map(|bound| Some(*bound).filter(|bound| bound.is_finite())).collect()
}

/// Maximum distance from the requested direction, relative to the larger of both velocities, at which it counts as kept.
const DIRECTION_TOLERANCE: f64 = 1e-6;

/// Velocity that counts as zero, m/s or rad/s.
const NEGLIGIBLE_VELOCITY: f64 = 1e-12;

/// Returns whether J_k q̇ = s ẋ_k.
fn keeps_direction(scale: f64, requested: &[f64], achieved: &[f64]) -> bool {
    let norm = |values: &[f64]| values.iter().fold(0.0_f64, |norm, value| norm.hypot(*value));
    let pairs = requested.iter().zip(achieved);
    let difference = pairs.fold(0.0_f64, |norm, (requested, achieved)| norm.hypot(achieved - scale * requested));
    difference <= DIRECTION_TOLERANCE * norm(requested).max(norm(achieved)) + NEGLIGIBLE_VELOCITY
}

/// Returns the nearest finite number; JSON has no other. A sum of squares overflows from 1e154 on.
fn finite(value: f64) -> f64 {
    if value.is_nan() { f64::MAX } else { value.clamp(-f64::MAX, f64::MAX) }
}

/// Time since `start`, µs.
pub fn elapsed_us(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1e6
}

#[cfg(test)]
mod tests {
    use revprio_core::resolution::{Contradiction, TaskOutcome};

    use super::*;

    #[test]
    fn a_scale_is_reported_only_where_the_direction_is_kept() {
        for (achieved, kept) in
            [([0.1, 0.2], true), ([0.1, 0.2 + 1e-9], true), ([0.1, 0.21], false), ([0.0, 0.0], false)]
        {
            assert_eq!(keeps_direction(0.1, &[1.0, 2.0], &achieved), kept, "{achieved:?}");
        }
        assert!(keeps_direction(1.0, &[0.0, 0.0], &[0.0, 0.0]));
        assert!(!keeps_direction(1.0, &[0.0, 0.0], &[1e-3, 0.0]));
    }

    #[test]
    fn numbers_beyond_the_doubles_are_written_as_the_nearest_one() {
        let large = TaskOutcome {
            achieved: vec![f64::INFINITY, f64::NEG_INFINITY, 1.0].into(),
            residual_norm: f64::INFINITY,
            ..TaskOutcome::default()
        };
        let resolution = Resolution { tasks: vec![large], ..Resolution::default() };
        let outcome = Outcome {
            resolution: &resolution,
            joints: vec![],
            tasks: vec!["t"],
            inequalities: ConstraintNames::default(),
            faster_than: None,
        };
        let task = &outcome.tasks(|_| (vec![0.0; 3], None))[0];
        assert_eq!((task.residual_norm, task.achieved.as_slice()), (f64::MAX, &[f64::MAX, -f64::MAX, 1.0][..]));
    }

    #[test]
    fn contradictions_and_active_rows_are_written_by_name() {
        let members = vec![
            Bound::lower(BoundId::Task { index: 0, row: 2 }),
            Bound::upper(BoundId::Joint(1)),
            Bound::upper(BoundId::Constraint { index: 0, row: 0 }),
        ];
        let resolution = Resolution {
            tasks: vec![TaskOutcome::default()],
            active_bounds: vec![ActiveBound {
                bound: Bound::lower(BoundId::Task { index: 0, row: 1 }),
                value: 0.0,
                multiplier: 0.5,
            }],
            contradictions: vec![
                Contradiction { task: Some(0), members },
                Contradiction { task: None, members: Vec::new() },
            ],
            ..Resolution::default()
        };
        let outcome = Outcome {
            resolution: &resolution,
            joints: vec!["j1", "j2"],
            tasks: vec!["slow"],
            inequalities: vec!["wall"].into(),
            faster_than: None,
        };
        let contradictions = serde_json::to_value(outcome.contradictions()).unwrap();
        let expected = serde_json::json!([
            {"task": "slow", "members": [
                {"task": "slow", "row": 2, "side": "lower"},
                {"joint": "j2", "side": "upper"},
                {"inequality": "wall", "side": "upper"}
            ]},
            {"task": null, "members": []}
        ]);
        assert_eq!(contradictions, expected);
        let tasks = outcome.tasks(|_| (Vec::new(), None));
        let rows = serde_json::to_value(&tasks[0].active_rows).unwrap();
        assert_eq!(rows, serde_json::json!([{"row": 1, "side": "lower", "multiplier": 0.5}]));
    }
}
