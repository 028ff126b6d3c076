//! Joints with a jerk limit keep the order of the tasks: what a lower task wants does not move what a higher one holds.

use std::sync::Arc;

use revprio_core::controller::{Controller, ControllerConfig, Stepper, TaskConfig};
use revprio_core::law::{ContactLaw, ContactSettings, Law, PositionLaw};
use revprio_core::limits::Drive;
use revprio_core::rows::TaskRows;
use revprio_core::streaming::Streaming;
use revprio_robot::kinematics::{Axis, Configuration};
use revprio_robot::{RobotModel, built_in};

use super::arms::{constant, joint_rows, position, tool_rows, with_jerk};
use super::drives::LaggingArm;

const SLOW: Drive = Drive { lag_s: 0.03, delay_periods: 2 };

/// Built-in arms with a posture: those that state jerk limits, and others with the time in which the acceleration may rise.
const ARMS: [(&str, Option<f64>, &[f64]); 5] = [
    ("panda", None, &[0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]),
    ("fr3", None, &[0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]),
    ("xarm7", Some(0.02), &[0.0, -0.3, 0.0, 0.8, 0.0, 1.1, 0.0]),
    ("ur5e", Some(0.05), &[0.0, -1.2, 1.6, -2.0, -1.57, 0.0]),
    ("sawyer", Some(0.05), &[0.0, -0.6, 0.2, 1.4, 0.1, 0.9, 0.0]),
];

fn robot(name: &str, rise: Option<f64>) -> Arc<RobotModel> {
    let robot = built_in().iter().find(|robot| robot.name() == name).unwrap();
    Arc::new(rise.map_or_else(|| robot.as_ref().clone(), |rise| with_jerk(robot, rise)))
}

fn task(name: &str, rows: TaskRows, law: Law) -> TaskConfig {
    TaskConfig { name: name.to_owned(), rows, law, scaled: false, streaming: Streaming::default() }
}

/// A task that moves axes of the tool by a displacement.
fn displaced(axes: &[Axis], displacement: &[f64]) -> TaskConfig {
    let mut rows = tool_rows(axes);
    rows.target_displacement = Some(constant(displacement));
    task("move", TaskRows::Tool(rows), Law::Position(PositionLaw::new(vec![3.0; axes.len()]).unwrap()))
}

fn posture_at(position_of_joints: &[f64]) -> TaskConfig {
    let law = position(position_of_joints.len(), 2.0);
    task("posture", joint_rows(position_of_joints), law)
}

fn hold(axes: &[Axis]) -> TaskConfig {
    task("hold", TaskRows::Tool(tool_rows(axes)), position(axes.len(), 3.0))
}

/// How far axes of the tool that a task holds are moved at most, m and rad, and the largest command at the end, rad/s.
fn run(robot: &Arc<RobotModel>, start: &[f64], tasks: Vec<TaskConfig>, (drive, period): (Drive, f64)) -> [f64; 3] {
    let config = ControllerConfig { drive, ..ControllerConfig::new(Arc::clone(robot), period, tasks) };
    let mut stepper = Stepper::new(Controller::new(config).unwrap()).unwrap();
    let pose = |q: &[f64]| *Configuration::new(robot, q).unwrap().tool_pose();
    let first = pose(start);
    let plant = if drive.lag_s > 0.0 { drive } else { Drive { lag_s: 1e-9, ..drive } };
    let (mut arm, mut memory, mut found) = (LaggingArm::at_rest(start, plant, 0.0, 1), None, [0.0_f64; 3]);
    let mut time_s = 0.0;
    while time_s < 4.0 {
        let command = stepper.step(&mut memory, &arm.measure(time_s)).unwrap();
        let u = command.resolution.joint_velocity.as_slice();
        arm.follow(u, period);
        let now = pose(&arm.q);
        let turned = (now.rotation * first.rotation.inverse()).angle();
        found[0] = found[0].max((now.translation.z - first.translation.z).abs());
        found[1] = found[1].max(turned);
        found[2] = u.iter().fold(0.0, |largest, u| largest.max(u.abs()));
        time_s += period;
    }
    found
}

#[test]
fn a_lower_task_does_not_move_what_a_higher_one_holds() {
    for (name, rise, start) in ARMS {
        let robot = robot(name, rise);
        let mut end = start.to_vec();
        end[0] += 0.5;
        end[1] += 0.3;
        for drive in [SLOW, Drive { lag_s: 0.0, delay_periods: 0 }] {
            for period in [0.001, 0.002, 0.008] {
                let case = |found| format!("{name} {drive:?} {period}: {found:?}");
                for step in [[-0.1, 0.0], [0.03, 0.08]] {
                    let tasks = vec![hold(&[Axis::Z]), displaced(&[Axis::X, Axis::Y], &step)];
                    let found = run(&robot, start, tasks, (drive, period));
                    println!("step {}", case(found));
                    assert!(found[0] < 2e-4 && found[2] < 0.02, "{}", case(found));
                }
                // The middle one of three tasks may lose more for the sake of the highest one.
                let tasks = vec![hold(&[Axis::Z]), displaced(&[Axis::X, Axis::Y], &[-0.1, 0.0]), posture_at(start)];
                let found = run(&robot, start, tasks, (drive, period));
                println!("three tasks {}", case(found));
                assert!(found[0] < 2e-4, "{}", case(found));
                if robot.joint_count() > 6 {
                    let posture = task("posture", joint_rows(&end), position(end.len(), 2.0));
                    let tasks = vec![hold(&Axis::ALL), posture];
                    let found = run(&robot, start, tasks, (drive, period));
                    println!("posture {}", case(found));
                    assert!(found[0] < 2e-4 && found[1] < 1e-3, "{}", case(found));
                }
            }
        }
    }
}

/// The law follows the velocity that it has achieved. If a lower task moved the tool, it would press harder in each period.
#[test]
fn a_lower_task_does_not_press() {
    for (name, rise, start) in ARMS {
        let robot = robot(name, rise);
        let law = ContactLaw::new(constant(&[-15.0]), vec![ContactSettings::default()]).unwrap();
        let press = task("press", TaskRows::Tool(tool_rows(&[Axis::Z])), Law::Contact(law));
        let rows = || tool_rows(&[Axis::Rx, Axis::Ry, Axis::Rz]);
        let swing = |speed: f64| {
            task("turn", TaskRows::Tool(rows()), Law::Velocity(constant(&[speed, -0.8 * speed, 0.5 * speed])))
        };
        for lower in [displaced(&[Axis::X, Axis::Y], &[-0.1, 0.0]), swing(0.4), swing(-0.4)] {
            for (period, has_posture) in [(0.001, false), (0.002, false), (0.002, true), (0.008, false)] {
                let mut tasks = vec![press.clone(), lower.clone()];
                tasks.extend(has_posture.then(|| posture_at(start)));
                let config =
                    ControllerConfig { drive: SLOW, ..ControllerConfig::new(Arc::clone(&robot), period, tasks) };
                let mut stepper = Stepper::new(Controller::new(config).unwrap()).unwrap();
                let height = |q: &[f64]| Configuration::new(&robot, q).unwrap().tool_pose().translation.z;
                let (wall, mut arm, mut memory) =
                    (height(start) - 5e-4, LaggingArm::at_rest(start, SLOW, 0.0, 1), None);
                let (mut peak, mut highest, mut time_s) = (0.0_f64, 0.0_f64, 0.0);
                while time_s < 2.0 {
                    let force = 1e4 * (wall - height(&arm.q)).max(0.0);
                    (peak, highest) = (peak.max(force), highest.max(height(&arm.q) - wall));
                    let mut measured = arm.measure(time_s);
                    measured.wrench[2] = -force;
                    let command = stepper.step(&mut memory, &measured).unwrap();
                    arm.follow(command.resolution.joint_velocity.as_slice(), period);
                    time_s += period;
                }
                println!("{name} {period} {has_posture} {}: {peak:.1} N, {:.2} mm up", lower.name, 1e3 * highest);
                let context = format!("{name} {period} {has_posture} {}: {peak} {highest}", lower.name);
                assert!(peak < 20.0 && highest < 1e-2, "{context}");
            }
        }
    }
}
