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
    start: [1.650_021, 0.847_509, 0.435_028, -0.627_688, 1.119_786, 2.239_028, -1.276_052],
    goal: [2.207_427, 0.377_673, 0.269_002, -1.660_658, -1.004_252, 2.461_649, -2.166_322],
    posture: [-0.369_217, -1.098_17, 2.462_757, -0.359_201, -2.195_657, 2.750_759, 0.774_18],
};

const PANDA_8: Case = Case {
    start: [0.091_897, 1.292_905, -0.740_338, -1.046_881, 1.971_179, 0.405_739, 0.747_863],
    goal: [1.516_396, 1.053_438, 0.423_246, -2.442_917, -0.719_56, 0.311_716, 1.348_864],
    posture: [-0.997_851, -0.979_313, -2.046_851, -2.880_891, -2.067_048, 0.294_787, -1.564_456],
    ..PANDA_7
};

const PANDA_1: Case = Case {
    axes: &[Axis::X, Axis::Y, Axis::Z],
    start: [1.375_179, -1.244_886, 1.206_388, -0.684_664, -1.894_723, 2.462_867, 1.325_323],
    goal: [-0.432_603, -0.354_047, 0.690_838, -1.767_148, 0.334_283, 1.751_462, -2.0827],
    posture: [1.373_83, 0.735_04, 2.446_32, -0.905_086, 0.902_639, 2.206_721, -1.810_568],
    ..PANDA_7
};

const FR3_9: Case = Case {
    robot: "fr3",
    axes: &[Axis::X, Axis::Y, Axis::Z],
    start: [-1.407_205, -0.036_231, -1.964_368, -1.521_372, 1.886_784, 2.510_645, 0.014_254],
    goal: [1.390_568, 0.877_011, -1.329_74, -2.513_511, -1.334_022, 1.935_191, 0.833_92],
    posture: [-1.865_661, 0.883_367, 0.410_813, -1.676_223, 0.060_176, 0.871_34, 0.573_502],
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
