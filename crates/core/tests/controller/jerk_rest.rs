//! Arms with jerk limits whose tasks want what limits do not permit come to rest.

use std::sync::Arc;

use revprio_core::controller::{Controller, ControllerConfig, Stepper, TaskConfig};
use revprio_core::limits::Drive;
use revprio_core::rows::{TargetPose, TaskRows, ToolRows};
use revprio_robot::kinematics::{Axis, Configuration};
use revprio_robot::{Joint, RobotModel, built_in};

use super::arms::{Random, joint_rows, position, task, tool_rows};
use super::braking::periods;
use super::drives::LaggingArm;

const DRIVE: Drive = Drive { lag_s: 0.03, delay_periods: 2 };

/// A motion to a pose of the hand, and to a posture below it.
struct Case {
    robot: &'static str,
    axes: &'static [Axis],
    start: [f64; 7],
    /// A posture that has the target pose.
    goal: [f64; 7],
    posture: [f64; 7],
}

fn find(name: &str) -> Arc<RobotModel> {
    Arc::clone(built_in().iter().find(|robot| robot.name() == name).unwrap())
}

/// Returns the jitter in the last second of a motion: how much the acceleration of a joint changes in a period, in the mean, rad/s²; of the
/// joint with the largest.
fn jitter(case: &Case, period: f64, duration: f64) -> f64 {
    let robot = find(case.robot);
    let target = *Configuration::new(&robot, &case.goal).unwrap().tool_pose();
    let rows = TaskRows::Tool(ToolRows { target_pose: TargetPose::Fixed(target), ..tool_rows(case.axes) });
    let hand = TaskConfig { rows, ..task(case.axes, position(case.axes.len(), 3.0)) };
    let rows = joint_rows(&case.posture);
    let posture = TaskConfig { name: "posture".to_owned(), rows, ..task(case.axes, position(7, 2.0)) };
    let tasks = vec![hand, posture];
    let config = ControllerConfig { drive: DRIVE, ..ControllerConfig::new(Arc::clone(&robot), period, tasks) };
    let mut stepper = Stepper::new(Controller::new(config).unwrap()).unwrap();
    let mut arm = LaggingArm::at_rest(&case.start, DRIVE, 0.0, 1);
    let (mut memory, mut commands) = (None, Vec::new());
    for k in 0..periods(duration, period) {
        let command = stepper.step(&mut memory, &arm.measure(f64::from(k) * period)).unwrap();
        let velocity = command.resolution.joint_velocity.as_slice().to_vec();
        arm.follow(&velocity, period);
        commands.push(velocity);
    }
    let last = &commands[commands.len() - periods(1.0, period) as usize..];
    let change = |w: &[Vec<f64>], joint: usize| (w[2][joint] - 2.0 * w[1][joint] + w[0][joint]).abs() / period;
    let mean = |joint| last.windows(3).map(|w| change(w, joint)).sum::<f64>() / (last.len() - 2) as f64;
    (0..7).map(mean).fold(0.0, f64::max)
}

const PANDA_7: Case = Case {
    robot: "panda",
    axes: &Axis::ALL,
    start: [1.650021, 0.847509, 0.435028, -0.627688, 1.119786, 2.239028, -1.276052],
    goal: [2.207427, 0.377673, 0.269002, -1.660658, -1.004252, 2.461649, -2.166322],
    posture: [-0.369217, -1.09817, 2.462757, -0.359201, -2.195657, 2.750759, 0.77418],
};

const PANDA_8: Case = Case {
    start: [0.091897, 1.292905, -0.740338, -1.046881, 1.971179, 0.405739, 0.747863],
    goal: [1.516396, 1.053438, 0.423246, -2.442917, -0.71956, 0.311716, 1.348864],
    posture: [-0.997851, -0.979313, -2.046851, -2.880891, -2.067048, 0.294787, -1.564456],
    ..PANDA_7
};

const PANDA_1: Case = Case {
    axes: &[Axis::X, Axis::Y, Axis::Z],
    start: [1.375179, -1.244886, 1.206388, -0.684664, -1.894723, 2.462867, 1.325323],
    goal: [-0.432603, -0.354047, 0.690838, -1.767148, 0.334283, 1.751462, -2.0827],
    posture: [1.37383, 0.73504, 2.44632, -0.905086, 0.902639, 2.206721, -1.810568],
    ..PANDA_7
};

const FR3_9: Case = Case {
    robot: "fr3",
    axes: &[Axis::X, Axis::Y, Axis::Z],
    start: [-1.407205, -0.036231, -1.964368, -1.521372, 1.886784, 2.510645, 0.014254],
    goal: [1.390568, 0.877011, -1.32974, -2.513511, -1.334022, 1.935191, 0.83392],
    posture: [-1.865661, 0.883367, 0.410813, -1.676223, 0.060176, 0.87134, 0.573502],
};

/// Returns a posture in the middle part of the ranges.
fn random_posture(robot: &RobotModel, random: &mut Random) -> [f64; 7] {
    let joint =
        |joint: &Joint| joint.limits.lower + (joint.limits.upper - joint.limits.lower) * (0.1 + 0.8 * random.unit());
    robot.joints().iter().map(joint).collect::<Vec<_>>().try_into().unwrap()
}

fn random_case(seed: u64) -> (Case, f64) {
    let mut random = Random(seed);
    let (name, axes) = random.pick(&[
        ("panda", &Axis::ALL[..]),
        ("panda", &Axis::ALL[..3]),
        ("fr3", &Axis::ALL[..3]),
        ("fr3", &Axis::ALL[..]),
    ]);
    let robot = find(name);
    let [start, goal, posture] = std::array::from_fn(|_| random_posture(&robot, &mut random));
    (Case { robot: name, axes, start, goal, posture }, random.pick(&[0.001, 0.002, 0.003]))
}

/// Returns the jitter at the end of random motions, the smallest first.
fn jitter_of_random_motions(seeds: std::ops::RangeInclusive<u64>, duration: f64) -> Vec<f64> {
    let mut all: Vec<f64> = seeds
        .map(|seed| {
            let (case, period) = random_case(seed);
            jitter(&case, period, duration)
        })
        .collect();
    all.sort_by(f64::total_cmp);
    all
}

/// Joints at their limits differ by rounding from what tasks want. The answer once was another motion towards the targets of the tasks, and
/// these arms swung for ever, at up to 8 rad/s² in the mean.
#[test]
fn an_arm_with_joints_at_their_limits_comes_to_rest() {
    for case in [PANDA_7, PANDA_8, PANDA_1, FR3_9] {
        let jitter = jitter(&case, 0.002, 5.0);
        assert!(jitter < 0.01, "{}: {jitter} rad/s² from {:?}", case.robot, case.start);
    }
}

#[test]
fn random_motions_end_without_jitter() {
    let all = jitter_of_random_motions(1..=30, 8.0);
    assert!(all[29] < 1.0 && all[27] < 0.1, "{all:.3?}");
}

#[test]
#[ignore = "asserts nothing; prints what docs/limits.md says about jitter"]
fn table_of_jitter() {
    for duration in [3.0, 5.0, 8.0] {
        let all = jitter_of_random_motions(1..=400, duration);
        let [slightly, strongly] = [0.1, 1.0].map(|least| all.iter().filter(|jitter| **jitter > least).count());
        println!(
            "after {duration} s: of 400 loops, {slightly} above 0.1 rad/s², {strongly} above 1 rad/s²; most {:.2}",
            all[399]
        );
    }
}
