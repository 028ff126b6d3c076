//! The joint-limit index: how near the joints are to their position limits.

use nalgebra::DVector;

use crate::{JointLimits, RobotModel};

/// Half range, rad or m, below which a joint counts as immovable.
const MIN_HALF_RANGE: f64 = 1e-9;

/// Returns the joint-limit index H = 1/(2n) Σ ((q_i − mid_i)/(mid_i − max_i))² at `joint_position` (q, n, rad or m).
///
/// H is 0 if every joint is in the middle of its range, ½ if every joint is at a limit, and larger outside. A joint
/// without a finite range, or with a range of zero, contributes nothing.
///
/// Paper: Eq. (8). Departs: the terms are squared. As printed, H falls without bound towards one limit.
///
/// # Panics
///
/// Panics unless `joint_position` has one entry per joint.
pub fn joint_limit_index(robot: &RobotModel, joint_position: &[f64]) -> f64 {
    let terms = terms(robot, joint_position).flatten();
    terms.map(|(offset, half)| (offset / half).powi(2)).sum::<f64>() / (2.0 * robot.joint_count() as f64)
}

/// Returns ∇H (n, 1/rad or 1/m): ∂H/∂q_i = (q_i − mid_i)/(n (mid_i − max_i)²).
///
/// The velocity q̇ = −k ∇H moves every joint to the middle of its range.
///
/// # Panics
///
/// Panics unless `joint_position` has one entry per joint.
pub fn joint_limit_gradient(robot: &RobotModel, joint_position: &[f64]) -> DVector<f64> {
    DVector::from_iterator(robot.joint_count(), joint_limit_slopes(robot, joint_position))
}

/// Returns the entries of [`joint_limit_gradient`] as an iterator, without allocating.
///
/// # Panics
///
/// Panics unless `joint_position` has one entry per joint.
pub fn joint_limit_slopes(robot: &RobotModel, joint_position: &[f64]) -> impl Iterator<Item = f64> {
    let n = robot.joint_count() as f64;
    terms(robot, joint_position).map(move |term| term.map_or(0.0, |(offset, half)| offset / (n * half * half)))
}

/// Returns half the position range, max − mid, rad or m; `None` if the index leaves the joint out.
pub fn half_range(limits: &JointLimits) -> Option<f64> {
    let half = 0.5 * (limits.upper - limits.lower);
    (half.is_finite() && half > MIN_HALF_RANGE).then_some(half)
}

/// Returns q_i − mid_i and max_i − mid_i of each joint; `None` if the index leaves the joint out.
fn terms(robot: &RobotModel, joint_position: &[f64]) -> impl Iterator<Item = Option<(f64, f64)>> {
    assert_eq!(joint_position.len(), robot.joint_count(), "one position per joint");
    robot.joints().iter().zip(joint_position).map(|(joint, q)| {
        let half = half_range(&joint.limits)?;
        Some((q - f64::midpoint(joint.limits.lower, joint.limits.upper), half))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Joint, built_in};

    const POSTURE: [f64; 7] = [2.9, -0.4, 3.0, 2.1, 3.0, -0.6, 0.2];

    fn with_limits(change: impl Fn(usize, &mut Joint)) -> RobotModel {
        let mut joints = built_in()[0].joints().to_vec();
        joints.iter_mut().enumerate().for_each(|(i, joint)| change(i, joint));
        RobotModel::new("changed", "", joints, *built_in()[0].tool()).unwrap()
    }

    #[test]
    fn the_index_is_zero_in_the_middle_and_one_half_at_the_ends() {
        let robot = &built_in()[0];
        let at = |place: &dyn Fn(&JointLimits) -> f64| -> Vec<f64> {
            robot.joints().iter().map(|joint| place(&joint.limits)).collect()
        };
        assert_eq!(joint_limit_index(robot, &at(&|limits| f64::midpoint(limits.lower, limits.upper))), 0.0);
        assert!((joint_limit_index(robot, &at(&|limits| limits.upper)) - 0.5).abs() < 1e-15);
        assert!((joint_limit_index(robot, &at(&|limits| limits.lower)) - 0.5).abs() < 1e-15);
    }

    #[test]
    fn the_gradient_matches_finite_differences() {
        let robot = &built_in()[0];
        let gradient = joint_limit_gradient(robot, &POSTURE);
        for (i, slope) in gradient.iter().enumerate() {
            let moved = |step: f64| {
                let mut q = POSTURE;
                q[i] += step;
                joint_limit_index(robot, &q)
            };
            // Central differences of a square are exact except for rounding.
            let difference = (moved(1e-4) - moved(-1e-4)) / 2e-4;
            assert!((difference - slope).abs() < 1e-11, "joint {i}: {slope}, not {difference}");
        }
    }

    #[test]
    fn joints_without_a_range_and_joints_that_cannot_move_contribute_nothing() {
        let robot = with_limits(|i, joint| match i {
            0 => joint.limits = JointLimits::NONE,
            1 => joint.limits.upper = f64::INFINITY,
            2 => joint.limits.upper = joint.limits.lower,
            _ => {}
        });
        let gradient = joint_limit_gradient(&robot, &POSTURE);
        assert_eq!(gradient.as_slice()[..3], [0.0; 3]);
        assert_eq!(gradient.as_slice()[3..], joint_limit_gradient(&built_in()[0], &POSTURE).as_slice()[3..]);
        assert!(joint_limit_index(&robot, &POSTURE) < joint_limit_index(&built_in()[0], &POSTURE));
        let free = with_limits(|_, joint| joint.limits = JointLimits::NONE);
        assert_eq!(joint_limit_index(&free, &POSTURE), 0.0);
    }
}
