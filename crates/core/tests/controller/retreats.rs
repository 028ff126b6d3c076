//! The contact law leaves a surface: what gives way to it, and what another controller may not reverse.

use std::sync::Arc;

use nalgebra::{IsometryMatrix3, Vector3};
use revprio_core::controller::{Controller, ControllerConfig, TaskConfig, TransitionError};
use revprio_core::law::{ContactLaw, ContactPhase, ContactSettings, FaultCause, Law, VelocityBounds};
use revprio_core::limits::ramp_deceleration;
use revprio_core::resolution::Method;
use revprio_core::rows::{TaskRows, ToolRows};
use revprio_core::surface::SurfaceSettings;
use revprio_robot::kinematics::{Axis, AxisSelection, BodyFrame, TaskBody, TaskFrame};
use revprio_robot::{RobotModel, UrdfTip, UrdfTreeOptions};

use super::arms::{NOMINAL, constant, contact, controller, position, sawyer, task};
use super::contact::{OTHERS, PERIOD, World, press_down, pressing};

/// A posture of a Panda.
const POSTURE: [f64; 7] = [0.0, -0.4, 0.0, -2.2, 0.0, 1.8, 0.8];

/// A Panda whose tool and wrist are tips.
fn panda_with_a_wrist() -> Arc<RobotModel> {
    let text = include_str!("../../../robot/robots/panda.urdf");
    let tip = |name, link| UrdfTip { name, link, offset: IsometryMatrix3::identity() };
    let tips = [tip("tool", "panda_link8"), tip("wrist", "panda_link6")];
    Arc::new(RobotModel::from_urdf_tree(text, &UrdfTreeOptions { tips: &tips, ..UrdfTreeOptions::default() }).unwrap())
}

fn of_tip(robot: &RobotModel, tip: &str, axes: &[Axis], law: Law) -> TaskConfig {
    let body = Some(TaskBody { body: BodyFrame::from(robot.tip(tip).unwrap()), relative_to: None });
    let frame = TaskFrame { body, ..TaskFrame::default() };
    let rows = ToolRows { frame, ..ToolRows::new(AxisSelection::new(axes).unwrap()) };
    TaskConfig { name: format!("{tip} {axes:?}"), rows: TaskRows::Tool(rows), ..task(axes, law) }
}

fn limited(max_force: f64) -> ContactSettings {
    ContactSettings { approach_speed: Some(0.03), max_force, ..ContactSettings::default() }
}

/// The joints of the wrist are those of the tool, but for the last one: that one alone does not lift the tool.
#[test]
fn a_tip_on_the_same_arm_takes_no_joint_from_a_retreat() {
    let robot = panda_with_a_wrist();
    for (pressing_tip, guided) in [("tool", "wrist"), ("wrist", "tool")] {
        let tasks = vec![
            of_tip(&robot, guided, &Axis::ALL, position(6, 3.0)),
            of_tip(&robot, pressing_tip, &[Axis::Z], contact(&[-20.0], limited(40.0))),
        ];
        let mut world = World::new(&robot, &POSTURE, pressing(&robot, tasks), &[]);
        let mut measured = world.arm.measure(0.0);
        let tip = robot.tips().iter().position(|tip| tip.name == pressing_tip).unwrap();
        measured.wrench[2] = -80.0;
        if tip != 0 {
            let wrench = measured.wrench;
            measured.wrenches = vec![revprio_core::controller::TipWrench { tip, wrench }];
        }
        let command = world.stepper.step(&mut world.memory, &measured).unwrap();
        assert_eq!(command.targets[1].contact[0].phase, ContactPhase::Fault(FaultCause::ForceLimit), "{pressing_tip}");
        assert_eq!(command.targets[0].released_by, Some(1), "{pressing_tip}");
        let (wanted, achieved) = (command.targets[1].velocity[0], command.resolution.tasks[1].achieved[0]);
        assert!(wanted > 0.0 && (achieved - wanted).abs() < 1e-9, "{pressing_tip}: {achieved} of {wanted}");
    }
}

/// The mean of a retreat and of a task that pushes on would press on.
#[test]
fn methods_without_priority_release_the_tasks_below_a_retreat() {
    let robot = sawyer();
    for method in [Method::Pseudoinverse, Method::DampedLeastSquares, Method::StrictReversePriority] {
        let down = TaskConfig { name: "down".to_owned(), ..task(&[Axis::Z], Law::Velocity(constant(&[-0.3]))) };
        let tasks = vec![task(&[Axis::Z], contact(&[-20.0], limited(40.0))), down];
        let config = ControllerConfig { method, ..pressing(&robot, tasks).config().clone() };
        let mut world = World::new(&robot, &NOMINAL, controller(config), &[]);
        let mut fastest = 0.0_f64;
        for _ in 0..50 {
            let mut measured = world.arm.measure(world.time);
            measured.wrench[2] = -80.0;
            let command = world.stepper.step(&mut world.memory, &measured).unwrap();
            let is_shared = method != Method::StrictReversePriority;
            assert_eq!(command.targets[1].released_by, is_shared.then_some(0), "{method:?}");
            fastest = command.resolution.tasks[0].achieved[0];
            let velocity = command.resolution.joint_velocity.as_slice().to_vec();
            world.arm.follow(&velocity, PERIOD);
            world.time += PERIOD;
        }
        assert!(fastest > 0.02, "{method:?}: {fastest} m/s");
    }
}

/// Rows that are zero would break bounds that exclude it.
#[test]
fn a_released_task_with_bounds_asks_for_nothing() {
    let robot = sawyer();
    let bounds = Law::Bounds(VelocityBounds::new(vec![0.05], vec![f64::INFINITY]).unwrap());
    let tasks = vec![task(&[Axis::X], bounds), task(&[Axis::Z], contact(&[-20.0], limited(40.0)))];
    let mut world = World::new(&robot, &NOMINAL, pressing(&robot, tasks), &[]);
    let mut measured = world.arm.measure(0.0);
    measured.wrench[2] = -80.0;
    let command = world.stepper.step(&mut world.memory, &measured).unwrap();
    assert_eq!(command.targets[0].released_by, Some(1));
    assert_eq!(command.targets[0].velocity.as_slice(), [0.0]);
    let outcome = &command.resolution.tasks[0];
    assert!((outcome.residual_norm - outcome.achieved.norm()).abs() < 1e-12, "{outcome:?}");
    assert!(command.resolution.contradictions.is_empty() && command.resolution.broken_bounds.is_empty(), "{command:?}");
}

/// While states are missing, the watchdog brakes a fast approach in a surface. The first answer afterwards does not go on with the speed of
/// before.
#[test]
fn a_contact_continues_from_the_ramp_of_the_watchdog() {
    let robot = sawyer();
    let settings = ContactSettings { approach_speed: Some(0.1), ..ContactSettings::default() };
    let tasks = vec![task(&[Axis::Z], contact(&[-30.0], settings)), task(&OTHERS, position(5, 3.0))];
    let mut world = World::new(&robot, &NOMINAL, pressing(&robot, tasks), &[]);
    world.run(0.5, 1);
    let (velocity, hold) = world.answer();
    let valid_s = hold.valid_for_ms(100) as f64 / 1e3;
    for k in 0..250 {
        let late = (f64::from(k + 1) * PERIOD - valid_s).max(0.0);
        let ramp = |(u, joint): (&f64, &revprio_robot::Joint)| {
            (u.abs() - ramp_deceleration(&joint.limits, *u, hold.stop_time_s) * late).max(0.0).copysign(*u)
        };
        let sent: Vec<f64> = velocity.iter().zip(robot.joints()).map(ramp).collect();
        world.arm.follow(&sent, PERIOD);
        world.time += PERIOD;
    }
    // The tool rests 0.6 mm deep: 60 N.
    let depth = world.start[2] - world.tool().tool_pose().translation.vector.z;
    world.walls = vec![(2, depth - 6e-4, -1.0, 1e5)];
    world.update_force();
    let mut measured = world.arm.measure(world.time);
    measured.wrench[2] = world.force[2];
    let command = world.stepper.step(&mut world.memory, &measured).unwrap();
    let (wanted, achieved) = (command.targets[0].velocity[0], command.resolution.tasks[0].achieved[0]);
    assert!(wanted > 0.0 && achieved > 0.0, "{achieved} m/s of {wanted}");
}

/// Another controller that reverses a retreat would bring the tool back to where it is replaced.
#[test]
fn a_retreat_is_not_reversed_while_its_force_is_there() {
    let robot = sawyer();
    let first = press_down(&robot, limited(60.0));
    let mut world = World::new(&robot, &NOMINAL, press_down(&robot, limited(60.0)), &[(2, 0.005, -1.0, 1e4)]);
    world.run(1.5, 1);
    world.walls = vec![(2, -0.005, -1.0, 1e4)];
    let up = vec![task(&[Axis::Z], contact(&[20.0], limited(60.0))), task(&OTHERS, position(5, 3.0))];
    let reversed = pressing(&robot, up);
    let (mut refused, mut accepted) = (0, 0);
    for _ in 0..500 {
        world.run(PERIOD, 1);
        let memory = world.memory.as_ref().unwrap();
        let axis = &memory.contacts[0];
        if axis.phase == ContactPhase::Fault(FaultCause::ForceLimit) {
            let presses = axis.force > limited(60.0).threshold();
            let answer = reversed.continue_from(&first, memory, &world.arm.q).map(drop);
            let expected = if presses { Err(TransitionError::Reverses { task: 0 }) } else { Ok(()) };
            assert_eq!(answer, expected, "{} N", axis.force);
            *(if presses { &mut refused } else { &mut accepted }) += 1;
        }
    }
    assert!(refused > 5 && accepted > 5, "{refused} {accepted}");
}

/// On a tilted surface, the tool presses along the normal that it has learnt.
#[test]
fn the_direction_that_may_not_be_reversed_is_the_normal_of_the_surface() {
    let robot = sawyer();
    let following = |controller: Controller| {
        let mut config = controller.config().clone();
        let Law::Contact(law) = &config.tasks[0].law else { unreachable!() };
        let settings = SurfaceSettings { max_tilt: 1.0 };
        config.tasks[0].law = Law::Contact(ContactLaw::with_surface(law.clone(), settings).unwrap());
        Controller::new(config).unwrap()
    };
    let first = following(press_down(&robot, ContactSettings::default()));
    let mut world = World::new(
        &robot,
        &NOMINAL,
        following(press_down(&robot, ContactSettings::default())),
        &[(2, 0.005, -1.0, 1e4)],
    );
    world.run(1.5, 1);
    let mut memory = world.memory.clone().unwrap();
    assert_eq!(memory.contacts[0].phase, ContactPhase::Contact);
    let along_x = |force: f64| {
        let tasks =
            vec![task(&[Axis::X], contact(&[force], ContactSettings::default())), task(&[Axis::Z], position(1, 3.0))];
        pressing(&robot, tasks)
    };
    memory.contacts[0].normal.normal = Vector3::new(1.0, 0.0, -1.0).normalize();
    let refused = along_x(-5.0).continue_from(&first, &memory, &world.arm.q).unwrap_err();
    assert_eq!(refused, TransitionError::Reverses { task: 0 });
    assert!(along_x(5.0).continue_from(&first, &memory, &world.arm.q).is_ok());
    memory.contacts[0].normal.normal = Vector3::new(0.1, 0.0, -1.0).normalize();
    assert!(along_x(-5.0).continue_from(&first, &memory, &world.arm.q).is_ok());
}
