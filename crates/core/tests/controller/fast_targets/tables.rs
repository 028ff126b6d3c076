//! Prints the tables of docs/fast.md.

use std::sync::Arc;

use nalgebra::{UnitQuaternion, Vector3};
use revprio_core::controller::{Controller, ControllerConfig, Stepper, TaskConfig};
use revprio_core::law::{Law, MotionPath};
use revprio_core::rows::{TargetPose, TaskRows, ToolRows};
use revprio_core::streaming::{StreamedTarget, StreamedValue, Streaming};

use super::{
    AXES, Arm, DRIVE, Figure, Followed, PATHS, PERIOD, STEPS, Source, Step, follow, looking_ahead, missed, step,
};
use crate::arms::{Random, position, task, tool_rows};
use crate::best_line;
use crate::drives::LaggingArm;

/// Prints steps and figures of a law.
fn print(name: &str, law: impl Fn() -> Law) {
    for arm in &Arm::all() {
        let robot = arm.robot.name();
        for way in STEPS {
            let Step { arrived, ratio, overshoot, off_line, shares } = step(arm, way, law());
            println!(
                "{name} {robot} step {:.2} m: {arrived:.3} s, {ratio:.2} x trapezoid, {:.2} x line, overshoot {:.1} mm, off the line {:.0} mm, V {:.2} A {:.2}",
                Vector3::from(way).norm(),
                arrived / best_line::time(&arm.robot, &arm.start, way.into()),
                1e3 * overshoot,
                1e3 * off_line,
                shares[0],
                shares[1]
            );
        }
        for speed in [0.3, 0.5, 0.8, 1.3, 2.5] {
            for seed in 0..3 {
                let figure = Figure::new(speed, seed);
                for source in [Source::Profile, Source::Ahead, Source::Streamed] {
                    let Followed { rms, largest, tilt, shares, .. } = follow(arm, &figure, source, law());
                    println!(
                        "{name} {robot} figure {:.2} m/s seed {seed} {source:?}: RMS {:.1} mm, largest {:.1} mm, tilt {tilt:.3} rad, V {:.2} A {:.2}",
                        figure.largest_speed(),
                        1e3 * rms,
                        1e3 * largest,
                        shares[0],
                        shares[1]
                    );
                }
            }
        }
    }
}

/// Prints the table of docs/fast.md.
#[test]
#[ignore = "asserts nothing; prints the table of docs/fast.md"]
fn fast_targets_table() {
    print("today", || position(6, 10.0));
    print("joint", || looking_ahead(MotionPath::Joint));
    print("straight", || looking_ahead(MotionPath::Straight));
}

/// Prints the time of a period for a resting target, for steps and for figures.
#[test]
#[ignore = "asserts nothing; prints times of docs/fast.md"]
fn period_times() {
    for arm in &Arm::all() {
        let name = arm.robot.name();
        let law = |path: Option<MotionPath>| path.map_or_else(|| position(6, 10.0), looking_ahead);
        for path in [None, Some(PATHS[0]), Some(PATHS[1])] {
            let print = |what: &str, mut times: Vec<f64>| {
                times.sort_by(f64::total_cmp);
                let at = |percent: usize| times[percent * (times.len() - 1) / 100];
                println!("{path:?} {name} {what}: {:.1} us, p99 {:.1} us, largest {:.1} us", at(50), at(99), at(100));
            };
            let start = arm.tool(&arm.start);
            let to = |way: Vector3<f64>| {
                let mut target = start;
                target.translation.vector += way;
                let rows = ToolRows { target_pose: TargetPose::Fixed(target), ..tool_rows(&AXES) };
                TaskConfig { rows: TaskRows::Tool(rows), ..task(&AXES, law(path)) }
            };
            print("rest", arm.run(to(Vector3::zeros()), 8.0, |_| Vec::new()).times);
            let steps = (0..20).flat_map(|_| arm.run(to(Vector3::new(-0.1, 0.3, 0.1)), 0.7, |_| Vec::new()).times);
            print("step", steps.collect());
            for source in [Source::Profile, Source::Ahead, Source::Streamed] {
                for speed in [0.5, 0.8] {
                    let found = follow(arm, &Figure::new(speed, 0), source, law(path));
                    print(&format!("{source:?} {speed}"), found.times);
                }
            }
        }
    }
}

/// Prints the distance and the roughness of the commands for streamed positions with noise of 0.5 mm.
#[test]
#[ignore = "asserts nothing; prints a table of docs/fast.md"]
fn noisy_targets_table() {
    for arm in &Arm::all() {
        for (speed, smoothing_s) in [(0.0, 0.03), (0.3, 0.03), (0.5, 0.03), (0.3, 0.1)] {
            for path in [None, Some(MotionPath::Joint)] {
                let figure = Figure::new(speed, 0);
                let start = arm.tool(&arm.start);
                let law = path.map_or_else(|| position(6, 10.0), looking_ahead);
                let task =
                    TaskConfig { streaming: Streaming { smoothing_s, ..Streaming::default() }, ..task(&AXES, law) };
                let config = ControllerConfig {
                    drive: DRIVE,
                    ..ControllerConfig::new(Arc::clone(&arm.robot), PERIOD, vec![task])
                };
                let mut stepper = Stepper::new(Controller::new(config).unwrap()).unwrap();
                let mut a = LaggingArm::at_rest(&arm.start, DRIVE, 0.0, 1);
                let mut random = Random(1);
                let (mut memory, mut last) = (None, vec![0.0; arm.start.len()]);
                let (mut errors, mut changes, mut count) = (0.0, 0.0, 0.0);
                for i in 0..800 {
                    let t = f64::from(i) * PERIOD;
                    let mut m = a.measure(t);
                    let exact = start.translation.vector + figure.at(t);
                    let noisy = exact + 5e-4 * Vector3::new(random.signed(), random.signed(), random.signed());
                    let value = StreamedValue::Pose {
                        position: Some(noisy),
                        orientation: Some(UnitQuaternion::from_rotation_matrix(&start.rotation)),
                    };
                    m.targets = vec![StreamedTarget { task: 0, time_s: t, value, velocity: None, ahead: Vec::new() }];
                    let tool = arm.tool(&a.q);
                    let u = stepper.step(&mut memory, &m).unwrap().resolution.joint_velocity.as_slice().to_vec();
                    if i > 300 {
                        errors += (tool.translation.vector - exact).norm_squared();
                        changes += u.iter().zip(&last).map(|(a, b)| ((a - b) / PERIOD).powi(2)).fold(0.0, f64::max);
                        count += 1.0;
                    }
                    a.follow(&u, PERIOD);
                    last = u;
                }
                println!(
                    "{} {speed} smoothing {smoothing_s} {path:?}: RMS {:.2} mm, command {:.2} rad/s2",
                    arm.robot.name(),
                    1e3 * f64::sqrt(errors / count),
                    f64::sqrt(changes / count)
                );
            }
        }
    }
}

/// Prints how many of 20 poses are missed at several paces.
#[test]
#[ignore = "asserts nothing; prints a table of docs/fast.md"]
fn pick_and_place_table() {
    for arm in &Arm::all() {
        for pace in [0.3, 0.4, 0.5, 0.6, 0.8, 1.0] {
            let law = |path: Option<MotionPath>| path.map_or_else(|| position(6, 10.0), looking_ahead);
            let of = |path| (0..3).map(|seed| missed(arm, law(path), pace, seed)).collect::<Vec<_>>();
            let [plain, joint, straight] = [None, Some(MotionPath::Joint), Some(MotionPath::Straight)].map(of);
            println!("{} {pace} s: {plain:?} joint {joint:?} straight {straight:?}", arm.robot.name());
        }
    }
}
