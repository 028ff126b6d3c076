//! The contact law on arms: several directions, other tasks, limits of the joints, faults and late states.

use std::sync::Arc;

use revprio_core::controller::{Controller, ControllerConfig, Memory, Stepper, TaskConfig, TransitionError};
use revprio_core::law::{
    AxisInput, ContactAxis, ContactLaw, ContactPhase, ContactSettings, ContactTiming, FaultCause, Law, Profile,
    unavoidable_peak,
};
use revprio_core::limits::{Drive, Hold, braking_deceleration, ramp_deceleration};
use revprio_core::rows::{TaskRows, ToolRows};
use revprio_core::streaming::{StreamedTarget, StreamedValue};
use revprio_robot::kinematics::{Axis, AxisSelection, BodyFrame, Configuration, TaskBody, TaskFrame};
use revprio_robot::{Joint, RobotModel, built_in};

use super::arms::{NOMINAL, Random, config, constant, contact, controller, position, sawyer, task};
use super::drives::LaggingArm;
use super::two_arms::{HOME, two_pandas, two_pandas_on_a_waist};

/// T, s.
pub(super) const PERIOD: f64 = 0.002;

const DRIVE: Drive = Drive { lag_s: 0.01, delay_periods: 1 };

pub(super) fn panda() -> Arc<RobotModel> {
    let found = built_in().iter().find(|robot| robot.name() == "panda");
    Arc::clone(found.unwrap())
}

/// A controller of an arm behind [`DRIVE`] with these tasks.
pub(super) fn pressing(robot: &Arc<RobotModel>, tasks: Vec<TaskConfig>) -> Controller {
    controller(ControllerConfig {
        period_s: PERIOD,
        drive: DRIVE,
        ..ControllerConfig::new(Arc::clone(robot), PERIOD, tasks)
    })
}

/// A wall: axis of the base, place along the pressing direction from the start, m, direction and stiffness, N/m.
pub(super) type Wall = (usize, f64, f64, f64);

/// An arm before walls.
pub(super) struct World {
    pub(super) arm: LaggingArm,
    robot: Arc<RobotModel>,
    pub(super) walls: Vec<Wall>,
    pub(super) start: [f64; 3],
    pub(super) stepper: Stepper,
    pub(super) memory: Option<Memory>,
    pub(super) time: f64,
    /// Forces of the last period, N, and the largest ones.
    pub(super) force: [f64; 3],
    peak: [f64; 3],
    phase: Vec<ContactPhase>,
    /// What arrives with the next state.
    targets: Vec<StreamedTarget>,
}

impl World {
    pub(super) fn new(robot: &Arc<RobotModel>, q: &[f64], controller: Controller, walls: &[Wall]) -> Self {
        let start = Configuration::new(robot, q).unwrap().tool_pose().translation.vector.into();
        Self {
            arm: LaggingArm::at_rest(q, DRIVE, 0.0, 1),
            robot: Arc::clone(robot),
            walls: walls.to_vec(),
            start,
            stepper: Stepper::new(controller).unwrap(),
            memory: None,
            time: 0.0,
            force: [0.0; 3],
            peak: [0.0; 3],
            phase: Vec::new(),
            targets: Vec::new(),
        }
    }

    pub(super) fn tool(&self) -> Configuration {
        Configuration::new(&self.robot, &self.arm.q).unwrap()
    }

    /// Returns the largest force, N, if no answer comes after a command: the watchdog holds it for a time (s), then it brakes as the hold says.
    fn force_after_silence(&mut self, velocity: &[f64], hold: &Hold, valid_s: f64) -> f64 {
        let (arm, mut largest) = (self.arm.clone(), 0.0_f64);
        for k in 0..100 {
            let late = (f64::from(k + 1) * PERIOD - valid_s).max(0.0);
            let ramp = |(u, joint): (&f64, &Joint)| {
                (u.abs() - ramp_deceleration(&joint.limits, *u, hold.stop_time_s) * late).max(0.0).copysign(*u)
            };
            let sent: Vec<f64> = velocity.iter().zip(self.robot.joints()).map(ramp).collect();
            self.arm.follow(&sent, PERIOD);
            self.update_force();
            largest = largest.max(self.force[2].abs());
        }
        self.arm = arm;
        largest
    }

    /// Returns the command of a period, n, and its hold. Nothing moves yet.
    pub(super) fn answer(&mut self) -> (Vec<f64>, Hold) {
        self.update_force();
        let mut measured = self.arm.measure(self.time);
        measured.wrench[2] = self.force[2];
        let command = self.stepper.step(&mut self.memory, &measured).unwrap();
        (command.resolution.joint_velocity.as_slice().to_vec(), command.hold.clone())
    }

    pub(super) fn update_force(&mut self) {
        let at = self.tool().tool_pose().translation.vector;
        self.force = [0.0; 3];
        for &(axis, place, direction, stiffness) in &self.walls {
            let depth = direction * (at[axis] - self.start[axis]) - place;
            self.force[axis] += direction * stiffness * depth.max(0.0);
        }
        for (peak, force) in self.peak.iter_mut().zip(self.force) {
            *peak = peak.max(force.abs());
        }
    }

    /// Runs for a time, s; a state arrives every `every` periods.
    pub(super) fn run(&mut self, time: f64, every: usize) {
        let end = self.time + time - 0.5 * PERIOD;
        while self.time < end {
            self.update_force();
            let [x, y, z] = self.force;
            let mut measured = self.arm.measure(self.time);
            measured.wrench = [x, y, z, 0.0, 0.0, 0.0];
            measured.targets = std::mem::take(&mut self.targets);
            let command = self.stepper.step(&mut self.memory, &measured).unwrap();
            self.phase = command.targets.iter().flat_map(|target| &target.contact).map(|report| report.phase).collect();
            for _ in 0..every {
                self.arm.follow(command.resolution.joint_velocity.as_slice(), PERIOD);
            }
            self.time += PERIOD * every as f64;
        }
    }
}

pub(super) const OTHERS: [Axis; 5] = [Axis::X, Axis::Y, Axis::Rx, Axis::Ry, Axis::Rz];

/// z presses downwards with 30 N at 1 cm/s, the others hold their pose.
pub(super) fn press_down(robot: &Arc<RobotModel>, settings: ContactSettings) -> Controller {
    let settings = ContactSettings { approach_speed: Some(0.01), ..settings };
    pressing(robot, vec![task(&[Axis::Z], contact(&[-30.0], settings)), task(&OTHERS, position(5, 3.0))])
}

#[test]
fn arms_press_on_walls_of_unknown_stiffness_and_hold_their_pose() {
    let posture = [0.0, -0.4, 0.0, -2.2, 0.0, 1.8, 0.8];
    for (robot, q) in [(sawyer(), NOMINAL), (panda(), posture)] {
        for stiffness in [1e3, 1e4, 1e5] {
            let walls = [(2, 0.01, -1.0, stiffness)];
            let mut world = World::new(&robot, &q, press_down(&robot, ContactSettings::default()), &walls);
            world.run(2.0 + 1.5 * 30.0 / (stiffness * 0.01), 1);
            assert!((world.force[2] + 30.0).abs() < 0.1, "{stiffness}: {:?}", world.force);
            assert!(world.peak[2] < 36.0, "{stiffness}: {:?}", world.peak);
            let moved = world.tool().tool_pose().translation.vector - nalgebra::Vector3::from(world.start);
            assert!(moved.x.hypot(moved.y) < 1e-4, "{stiffness}: {moved}");
        }
    }
}

#[test]
fn two_directions_press_at_once() {
    let robot = sawyer();
    let settings = ContactSettings { approach_speed: Some(0.02), ..ContactSettings::default() };
    let others = [Axis::Y, Axis::Rx, Axis::Ry, Axis::Rz];
    let tasks = vec![task(&[Axis::X, Axis::Z], contact(&[20.0, -10.0], settings)), task(&others, position(4, 3.0))];
    let walls = [(0, 0.01, 1.0, 2e4), (2, 0.005, -1.0, 5e4)];
    let mut world = World::new(&robot, &NOMINAL, pressing(&robot, tasks), &walls);
    world.run(2.0, 1);
    let [x, _, z] = world.force;
    assert!((x - 20.0).abs() < 0.1 && (z + 10.0).abs() < 0.1, "{:?}", world.force);
    // Every impact has its moment in a period, and costs at least the unavoidable peak of it.
    let timing = ContactTiming::new(PERIOD, DRIVE, settings.sensor_lag, 0.0);
    let unavoidable = |stiffness| unavoidable_peak(&settings, &timing, (stiffness, settings.max_acceleration), 0.02);
    let allowed =
        [(20.0, 2e4), (10.0, 5e4)].map(|(target, stiffness)| f64::max(1.2 * target, 1.1 * unavoidable(stiffness)));
    assert!(world.peak[0] < allowed[0] && world.peak[2] < allowed[1], "{:?} {allowed:?}", world.peak);
}

/// The law is told the velocity that the joints achieve, so it does not wind up, and reaches its force all the same.
#[test]
fn slow_joints_only_delay_the_contact() {
    let robot = sawyer();
    let slow = robot.joints().iter().map(|joint| {
        let mut joint = joint.clone();
        (joint.limits.velocity, joint.limits.acceleration) = (0.02, 0.2);
        joint
    });
    let robot = Arc::new(RobotModel::new("slow", "", slow.collect(), *robot.tool()).unwrap());
    let walls = [(2, 0.005, -1.0, 1e4)];
    let mut world = World::new(&robot, &NOMINAL, press_down(&robot, ContactSettings::default()), &walls);
    world.run(4.0, 1);
    assert!((world.force[2] + 30.0).abs() < 0.1 && world.peak[2] < 36.0, "{:?} {:?}", world.force, world.peak);
}

/// A wall that lets the force exceed the limit of [`pressing_below_a_pose`].
const TOO_STIFF: [Wall; 1] = [(2, -0.001, -1.0, 5e4)];

/// The pose above keeps z where it is; only a fault by force lets it go.
fn pressing_below_a_pose(robot: &Arc<RobotModel>) -> Controller {
    let settings = ContactSettings { approach_speed: Some(0.03), max_force: 40.0, ..ContactSettings::default() };
    let tasks = vec![task(&Axis::ALL, position(6, 3.0)), task(&[Axis::Z], contact(&[-30.0], settings))];
    pressing(robot, tasks)
}

#[test]
fn a_force_above_its_limit_overrules_higher_tasks() {
    let robot = sawyer();
    let mut world = World::new(&robot, &NOMINAL, pressing_below_a_pose(&robot), &TOO_STIFF);
    world.run(0.5, 1);
    assert_eq!(world.phase, [ContactPhase::Fault(FaultCause::ForceLimit)]);
    let walls_reached = world.peak[2];
    assert!(walls_reached < 51.0, "{:?}", world.peak);
    let raised = |world: &World| world.tool().tool_pose().translation.vector.z - world.start[2];
    assert!(raised(&world) > 5e-4, "{}", raised(&world));
    // The tasks above do not bring the tool back.
    world.run(1.0, 1);
    let rest = raised(&world);
    for _ in 0..10 {
        world.run(0.1, 1);
        assert!((raised(&world) - rest).abs() < 1e-5, "{} {rest}", raised(&world));
    }
}

/// The tasks ask for nothing then. They move all the same, and the arm is not at a singularity.
#[test]
fn tasks_that_a_retreat_has_released_report_how_they_move() {
    let robot = sawyer();
    let mut world = World::new(&robot, &NOMINAL, pressing_below_a_pose(&robot), &TOO_STIFF);
    let mut fastest = 0.0_f64;
    for _ in 0..250 {
        world.update_force();
        let mut measured = world.arm.measure(world.time);
        measured.wrench[2] = world.force[2];
        let command = world.stepper.step(&mut world.memory, &measured).unwrap();
        let velocity = command.resolution.joint_velocity.as_slice().to_vec();
        if matches!(command.targets[1].contact[0].phase, ContactPhase::Fault(_)) {
            let outcome = &command.resolution.tasks[0];
            // Both tasks have the same row z.
            let [achieved, pressed] = [outcome.achieved[2], command.resolution.tasks[1].achieved[0]];
            assert!((achieved - pressed).abs() < 1e-9, "{achieved} {pressed}");
            assert!((outcome.residual_norm - outcome.achieved.norm()).abs() < 1e-12 && outcome.rank == 6);
            fastest = fastest.max(achieved);
        }
        world.arm.follow(&velocity, PERIOD);
        world.time += PERIOD;
    }
    assert!(fastest > 0.01, "the tool retreats at {fastest} m/s");
}

/// A contact that has a fault below another one at rest leaves all the same.
#[test]
fn a_fault_below_does_not_keep_a_contact_from_its_own_retreat() {
    let robot = sawyer();
    let limit =
        |max_force: f64| ContactSettings { approach_speed: Some(0.03), max_force, ..ContactSettings::default() };
    let tasks = vec![task(&[Axis::X], contact(&[20.0], limit(40.0))), task(&[Axis::Z], contact(&[-30.0], limit(40.0)))];
    let walls = [TOO_STIFF[0], (0, 0.1, 1.0, 5e4)];
    let mut world = World::new(&robot, &NOMINAL, pressing(&robot, tasks), &walls);
    world.run(1.0, 1);
    assert_eq!(world.phase[1], ContactPhase::Fault(FaultCause::ForceLimit));
    // A wall comes from the side, and pushes the tool that is released.
    let place = world.tool().tool_pose().translation.vector.x - world.start[0];
    for step in 0..500 {
        world.walls[1].1 = (place + 0.002 - 2e-5 * f64::from(step)).max(place - 0.003);
        world.run(PERIOD, 1);
    }
    assert_eq!(world.phase, [ContactPhase::Fault(FaultCause::ForceLimit); 2]);
    assert!(world.force[0].abs() < 1.0 && world.peak[0] < 60.0, "{:?} {:?}", world.force, world.peak);
}

/// The other arm shares no joint with the tool that retreats, or a waist that the retreat does not need.
#[test]
fn a_retreat_leaves_the_tasks_of_the_other_arm_alone() {
    let settings = ContactSettings { max_force: 40.0, ..ContactSettings::default() };
    for robot in [two_pandas(), two_pandas_on_a_waist()] {
        let of = |tip: &str, axes: &[Axis], law: Law| {
            let body = Some(TaskBody { body: BodyFrame::from(robot.tip(tip).unwrap()), relative_to: None });
            let frame = TaskFrame { body, ..TaskFrame::default() };
            let rows = ToolRows { frame, ..ToolRows::new(AxisSelection::new(axes).unwrap()) };
            TaskConfig { name: format!("{tip} {axes:?}"), rows: TaskRows::Tool(rows), ..task(axes, law) }
        };
        let tasks = vec![
            of("right", &[Axis::Z], contact(&[-30.0], settings)),
            of("left", &[Axis::X], position(1, 3.0)),
            of("left", &[Axis::Z], contact(&[-30.0], settings)),
        ];
        let waist = vec![0.0; robot.joint_count() - HOME.len()];
        let mut world = World::new(&robot, &[&waist, &HOME[..]].concat(), pressing(&robot, tasks), &[]);
        let mut measured = world.arm.measure(0.0);
        // The left tool, which is the first tip, presses too hard.
        measured.wrench[2] = -80.0;
        let command = world.stepper.step(&mut world.memory, &measured).unwrap();
        let released: Vec<_> = command.targets.iter().map(|target| target.released_by).collect();
        assert_eq!(released, [None, Some(2), None]);
        let approach = &command.resolution.tasks[0].achieved;
        assert!(approach[0] < 0.0 && (approach[0] - command.targets[0].velocity[0]).abs() < 1e-9, "{approach:?}");
    }
}

/// Of a task that retreats along one axis above another retreat, the other axes are released.
#[test]
fn only_the_axes_that_retreat_stay_above_another_retreat() {
    let robot = sawyer();
    let limit = |max_force: f64| ContactSettings { max_force, ..ContactSettings::default() };
    let above = ContactLaw::new(constant(&[20.0, -20.0]), vec![limit(40.0); 2]).unwrap();
    let tasks = vec![task(&[Axis::X, Axis::Z], Law::Contact(above)), task(&[Axis::Y], contact(&[20.0], limit(40.0)))];
    let mut world = World::new(&robot, &NOMINAL, pressing(&robot, tasks), &[]);
    let mut measured = world.arm.measure(0.0);
    measured.wrench = [80.0, 80.0, 0.0, 0.0, 0.0, 0.0];
    let command = world.stepper.step(&mut world.memory, &measured).unwrap();
    assert_eq!(command.targets[0].released_by, Some(1));
    let [above, below] = [0, 1].map(|k| command.targets[k].velocity.as_slice().to_vec());
    assert!(above[0] < 0.0 && above[1] == 0.0 && below[0] < 0.0, "{above:?} {below:?}");
    let achieved = &command.resolution.tasks;
    assert!(achieved[0].achieved[0] < 0.0 && achieved[1].achieved[0] < 0.0, "{achieved:?}");
}

/// A retreat ends at what it meets.
#[test]
fn a_retreat_does_not_press_on_what_is_behind_the_tool() {
    let robot = sawyer();
    for (gap, most) in [(0.004, 40.0), (0.02, 1.0), (0.03, 1.0)] {
        let settings = ContactSettings { approach_speed: Some(0.03), max_force: 60.0, ..ContactSettings::default() };
        let tasks = vec![task(&[Axis::Z], contact(&[-20.0], settings)), task(&OTHERS, position(5, 3.0))];
        let walls = [(2, 0.005, -1.0, 3e4), (2, gap, 1.0, 3e4)];
        let mut world = World::new(&robot, &NOMINAL, pressing(&robot, tasks), &walls);
        world.run(2.0, 1);
        let (floor, mut behind) = (world.walls[0].1, 0.0_f64);
        for step in 0..1000 {
            // The floor comes up by 6 mm at 0.1 m/s.
            world.walls[0].1 = floor - (0.1 * PERIOD * f64::from(step)).min(0.006);
            world.run(PERIOD, 1);
            behind = behind.max(world.force[2]);
        }
        assert_eq!(world.phase, [ContactPhase::Fault(FaultCause::ForceLimit)], "{gap}");
        assert!(behind < most && world.force[2].abs() <= most, "{gap}: {behind} N, {:?}", world.force);
    }
}

/// The retreat of a lower task may push a released tool, whose force nobody controls then.
#[test]
fn an_answer_is_valid_for_a_short_time_while_a_contact_is_released() {
    let robot = sawyer();
    let settings = ContactSettings { approach_speed: Some(0.03), max_force: 40.0, ..ContactSettings::default() };
    let tasks = vec![
        task(&[Axis::X], contact(&[20.0], ContactSettings::default())),
        task(&[Axis::Z], contact(&[-30.0], settings)),
    ];
    let mut world = World::new(&robot, &NOMINAL, pressing(&robot, tasks), &TOO_STIFF);
    let mut retreats = 0;
    for _ in 0..250 {
        world.update_force();
        let mut measured = world.arm.measure(world.time);
        measured.wrench[2] = world.force[2];
        let command = world.stepper.step(&mut world.memory, &measured).unwrap();
        if matches!(command.targets[1].contact[0].phase, ContactPhase::Fault(_)) {
            assert_eq!(command.hold.valid_for_ms(100), 10);
            retreats += 1;
        }
        let velocity = command.resolution.joint_velocity.as_slice().to_vec();
        world.arm.follow(&velocity, PERIOD);
        world.time += PERIOD;
    }
    assert!(retreats > 100, "{retreats}");
}

/// So a turned tool whose readings are stated in the axes of the base reads a wall below it sideways.
#[test]
fn a_force_beside_the_axis_counts_for_the_limit_of_an_approach() {
    let robot = sawyer();
    let settings = ContactSettings { max_force: 50.0, ..ContactSettings::default() };
    let walls = [(2, 0.005, -1.0, 1e5)];
    let run = |max_force: f64, forces: [[f64; 3]; 3]| {
        let settings = ContactSettings { max_force, ..settings };
        let mut world = World::new(&robot, &NOMINAL, press_down(&robot, settings), &walls);
        let mut peak = 0.0_f64;
        for _ in 0..1500 {
            world.update_force();
            peak = peak.max(world.force[2].abs());
            let mut measured = world.arm.measure(world.time);
            for (entry, row) in measured.wrench.iter_mut().zip(forces) {
                *entry = row.iter().zip(world.force).map(|(share, force)| share * force).sum();
            }
            let command = world.stepper.step(&mut world.memory, &measured).unwrap();
            world.phase =
                command.targets.iter().flat_map(|target| &target.contact).map(|report| report.phase).collect();
            let velocity = command.resolution.joint_velocity.as_slice().to_vec();
            world.arm.follow(&velocity, PERIOD);
            world.time += PERIOD;
        }
        (world.phase[0], peak)
    };
    let swapped = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]];
    let (phase, peak) = run(50.0, swapped);
    assert_eq!(phase, ContactPhase::Fault(FaultCause::ForceLimit));
    assert!(peak < 80.0, "{peak}");
    // Friction beside a contact does not count.
    let with_friction = [[1.0, 0.0, 0.6], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let (phase, peak) = run(34.0, with_friction);
    assert_eq!(phase, ContactPhase::Contact, "{peak}");
}

/// The service falls silent in any period of the touch. The watchdog holds the last command while it is valid.
#[test]
fn a_silence_at_the_touch_costs_the_way_of_its_hold_and_of_the_drive() {
    let robot = sawyer();
    for (stiffest, speed) in [(1e6, None), (1e5, None), (1e5, Some(0.03))] {
        let settings = ContactSettings { approach_speed: speed, stiffest, ..ContactSettings::default() };
        let tasks = vec![task(&[Axis::Z], contact(&[-30.0], settings)), task(&OTHERS, position(5, 3.0))];
        let walls = [(2, 0.005, -1.0, stiffest)];
        let mut world = World::new(&robot, &NOMINAL, pressing(&robot, tasks), &walls);
        let [mut worst, mut usual, mut fastest] = [0.0_f64; 3];
        for _ in 0..2000 {
            world.update_force();
            usual = usual.max(world.force[2].abs());
            let mut measured = world.arm.measure(world.time);
            measured.wrench[2] = world.force[2];
            let command = world.stepper.step(&mut world.memory, &measured).unwrap();
            let velocity = command.resolution.joint_velocity.as_slice().to_vec();
            let hold = command.hold.clone();
            let valid_s = hold.valid_for_ms(100) as f64 / 1e3;
            fastest = fastest.max(command.targets[0].contact[0].approach_speed);
            worst = worst.max(world.force_after_silence(&velocity, &hold, valid_s));
            world.arm.follow(&velocity, PERIOD);
            world.time += PERIOD;
        }
        // 10 ms at the speed of the approach, if that is more than the target, and the time until the drive follows the brake.
        let more = (stiffest * fastest * 0.01).max(30.0) + stiffest * fastest * (DRIVE.lag_s + PERIOD);
        assert!(
            worst < usual.max(30.0) + more,
            "{stiffest} {speed:?}: {worst} N, {usual} N without a silence, {fastest} m/s"
        );
        assert!(worst > usual + 10.0, "{stiffest} {speed:?}: no silence at the touch");
    }
}

/// Joints that keep their speeds lead a tool that slides along a surface on an arc into it. What braking adds afterwards is another matter:
/// each joint stops by itself.
#[test]
fn the_hold_of_a_tool_that_slides_adds_no_more_than_the_target() {
    let (robot, target, stiffness) = (panda(), 20.0, 1e5);
    let start = [0.0, -0.3, 0.0, -2.1, 0.0, 1.8, 0.8];
    let mut worst = 0.0_f64;
    for (axis, speed) in [(Axis::Y, 0.1), (Axis::Y, 0.3), (Axis::X, 0.1), (Axis::X, -0.1), (Axis::X, -0.2)] {
        let settings = ContactSettings { stiffest: stiffness, ..ContactSettings::default() };
        let slide = Profile::ramp(vec![0.0], vec![speed], 0.5, 0.5).unwrap();
        let tasks = vec![task(&[Axis::Z], contact(&[-target], settings)), task(&[axis], Law::Velocity(slide))];
        let mut world = World::new(&robot, &start, pressing(&robot, tasks), &[(2, 5e-4, -1.0, stiffness)]);
        let [mut usual, mut together, mut apart, mut longest] = [0.0_f64; 4];
        while world.time < 2.0 {
            let (velocity, hold) = world.answer();
            let valid_s = hold.valid_for_ms(100) as f64 / 1e3;
            if world.time > 0.5 {
                let force = world.force[2].abs();
                let after = [PERIOD, valid_s, 0.1].map(|time| world.force_after_silence(&velocity, &hold, time));
                assert!(after[1] <= after[0].max(force) + target, "{axis:?} {speed}: {after:?} N, {force} N");
                usual = usual.max(force);
                (together, longest) = (together.max(after[1]), longest.max(after[2]));
                let each = Hold { stop_time_s: None, ..hold };
                apart = apart.max(world.force_after_silence(&velocity, &each, valid_s));
            }
            world.arm.follow(&velocity, PERIOD);
            world.time += PERIOD;
        }
        println!(
            "{axis:?} {speed} m/s: {usual:.0} N; after a silence {together:.0} N, if each joint brakes as fast as it can {apart:.0} N, after 100 ms {longest:.0} N"
        );
        assert!(together < usual + 1.1 * target, "{axis:?} {speed}: {together} N");
        worst = worst.max(apart);
    }
    assert!(worst > 100.0, "the slides do not show what joints that stop one by one do: {worst} N");
}

/// A tool that comes in goes on for longer if all joints stop together; one that slides is turned if each stops by itself. The answer tells
/// which of the ramps presses less.
#[test]
fn the_ramp_that_presses_less_is_told() {
    let stiffness = 1e5;
    for (robot, start) in [(sawyer(), NOMINAL), (panda(), [0.0, -0.3, 0.0, -2.1, 0.0, 1.8, 0.8])] {
        for (axis, speed) in [(Axis::X, 0.2), (Axis::Y, 0.2), (Axis::X, -0.2), (Axis::Y, -0.2)] {
            let settings =
                ContactSettings { stiffest: stiffness, approach_speed: Some(0.02), ..ContactSettings::default() };
            let slide = Profile::ramp(vec![0.0], vec![speed], 0.3, 0.3).unwrap();
            let tasks = vec![task(&[Axis::Z], contact(&[-20.0], settings)), task(&[axis], Law::Velocity(slide))];
            let mut world = World::new(&robot, &start, pressing(&robot, tasks), &[(2, 0.01, -1.0, stiffness)]);
            let [mut told, mut together, mut each] = [0.0_f64; 3];
            while world.time < 1.5 {
                let (velocity, hold) = world.answer();
                let valid_s = hold.valid_for_ms(100) as f64 / 1e3;
                let ratio = |(u, joint): (&f64, &Joint)| u.abs() / braking_deceleration(&joint.limits);
                let stop = velocity.iter().zip(robot.joints()).map(ratio).fold(0.0, f64::max);
                let mut after =
                    |stop_time_s| world.force_after_silence(&velocity, &Hold { stop_time_s, ..hold.clone() }, valid_s);
                told = told.max(after(hold.stop_time_s));
                together = together.max(after(Some(stop).filter(|stop| *stop > 0.0)));
                each = each.max(after(None));
                world.arm.follow(&velocity, PERIOD);
                world.time += PERIOD;
            }
            let name = robot.name();
            println!(
                "{name} {axis:?} {speed} m/s: {told:.0} N; all together {together:.0} N, each by itself {each:.0} N"
            );
            assert!(told < together.min(each) + 20.0, "{name} {axis:?} {speed}: {told} N, not {together} or {each} N");
        }
    }
}

/// The surface may stand by now: nobody knows before the next touch.
#[test]
fn the_speed_of_a_lost_surface_lengthens_no_hold() {
    let robot = panda();
    let settings = ContactSettings { stiffest: 1e5, ..ContactSettings::default() };
    let q = [0.0, -0.4, 0.0, -2.2, 0.0, 1.8, 0.8];
    let mut world = World::new(&robot, &q, press_down(&robot, settings), &[]);
    world.run(0.5, 1);
    let mut held = |receding: f64| {
        let memory = world.memory.clone();
        world.memory.as_mut().unwrap().contacts[0].motion.velocity = receding;
        let hold = world.answer().1;
        world.memory = memory;
        hold.time_s
    };
    let [standing, receding] = [0.0, 0.05].map(&mut held);
    assert!(standing < 0.05, "{standing}");
    assert_eq!(receding, standing);
}

/// A period without force may be the first of a loss. The phase changes later.
#[test]
fn the_speed_of_a_surface_without_force_lengthens_no_hold() {
    let robot = panda();
    let settings = ContactSettings { stiffest: 1e5, ..ContactSettings::default() };
    let q = [0.0, -0.4, 0.0, -2.2, 0.0, 1.8, 0.8];
    let mut world = World::new(&robot, &q, press_down(&robot, settings), &[(2, 0.002, -1.0, 1e5)]);
    world.run(1.0, 1);
    assert_eq!(world.phase, [ContactPhase::Contact]);
    world.memory.as_mut().unwrap().contacts[0].motion.velocity = 0.05;
    let memory = world.memory.clone();
    let with_force = world.answer().1.time_s;
    world.walls.clear();
    world.memory = memory;
    let without = world.answer().1.time_s;
    assert_eq!(world.memory.as_ref().unwrap().contacts[0].phase, ContactPhase::Contact);
    assert!(with_force > 1.0 && without < 0.05, "{with_force} s, {without} s without force");
}

/// A tare in such a moment would take the force of the surface for a bias. That of a sensor in free space looks like a contact for ever.
#[test]
fn a_tool_presses_surely_before_the_contact_is_held_and_never_with_a_bias() {
    let robot = sawyer();
    let surely = |walls: &[Wall], bias: f64| {
        let controller = press_down(&robot, ContactSettings::default());
        let config = controller.config().clone();
        let mut world = World::new(&robot, &NOMINAL, controller, walls);
        let (mut early, mut random) = (0, Random(5));
        for _ in 0..1000 {
            world.update_force();
            let mut measured = world.arm.measure(world.time);
            measured.wrench[2] = world.force[2] - bias + 0.35 * random.signed();
            let velocity = world.stepper.step(&mut world.memory, &measured).unwrap().resolution.joint_velocity.clone();
            let contacts = &world.memory.as_ref().unwrap().contacts;
            early += u32::from(config.presses_surely(contacts) && !contacts[0].is_held());
            world.arm.follow(velocity.as_slice(), PERIOD);
            world.time += PERIOD;
        }
        early
    };
    let early = surely(&[(2, 0.005, -1.0, 1e4)], 0.0);
    assert!(early > 20, "{early} periods");
    for bias in [3.0, 8.0, 20.0] {
        assert_eq!(surely(&[], bias), 0, "{bias} N");
    }
}

/// A tool that leaves a surface because of its force still presses on it for some periods.
#[test]
fn a_tool_presses_surely_while_it_retreats_from_a_surface_and_not_with_a_large_bias() {
    let robot = sawyer();
    let settings = ContactSettings { max_force: 40.0, ..ContactSettings::default() };
    let config = press_down(&robot, settings).config().clone();
    let mut world = World::new(&robot, &NOMINAL, press_down(&robot, settings), &[(2, 0.005, -1.0, 1e4)]);
    world.run(2.0, 1);
    world.walls = vec![(2, -0.005, -1.0, 1e4)];
    let mut retreats = 0;
    for _ in 0..1000 {
        world.run(PERIOD, 1);
        let contacts = &world.memory.as_ref().unwrap().contacts;
        let is_fault = contacts[0].phase == ContactPhase::Fault(FaultCause::ForceLimit);
        let presses = is_fault && contacts[0].force > 2.0;
        retreats += u32::from(presses);
        assert!(config.presses_surely(contacts) || !presses, "{:?}", contacts[0]);
    }
    assert!(retreats > 5 && !config.presses_surely(&world.memory.as_ref().unwrap().contacts), "{retreats} periods");

    let mut world = World::new(&robot, &NOMINAL, press_down(&robot, settings), &[]);
    for _ in 0..1000 {
        let mut measured = world.arm.measure(world.time);
        measured.wrench[2] = -60.0;
        let velocity = world.stepper.step(&mut world.memory, &measured).unwrap().resolution.joint_velocity.clone();
        assert!(!config.presses_surely(&world.memory.as_ref().unwrap().contacts));
        world.arm.follow(velocity.as_slice(), PERIOD);
        world.time += PERIOD;
    }
    let contacts = &world.memory.as_ref().unwrap().contacts;
    assert_eq!(contacts[0].phase, ContactPhase::Fault(FaultCause::ForceLimit));
}

/// A contact goes on when streamed forces fail to come, and a fault retreats then, too.
#[test]
fn a_contact_and_its_fault_go_on_when_streamed_forces_fail_to_come() {
    let robot = sawyer();
    let (walls, raised) = ([(2, 0.005, -1.0, 1e4)], [(2, -0.005, -1.0, 1e4)]);
    let settings = ContactSettings { max_force: 60.0, ..ContactSettings::default() };
    let mut world = World::new(&robot, &NOMINAL, press_down(&robot, settings), &walls);
    world.run(1.5, 1);
    let value = StreamedValue::Force(vec![-20.0]);
    world.targets = vec![StreamedTarget { task: 0, time_s: world.time, value, velocity: None, ahead: Vec::new() }];
    world.run(4.0, 1);
    assert_eq!(world.phase, [ContactPhase::Contact]);
    assert!((world.force[2] + 20.0).abs() < 0.1, "{:?}", world.force);
    world.walls = raised.to_vec();
    world.run(2.0, 1);
    assert_eq!(world.phase, [ContactPhase::Fault(FaultCause::ForceLimit)]);
    assert!(world.force[2] == 0.0, "{:?}", world.force);
}

/// In free space, noise of the stated size is no pull; a steady one is.
#[test]
fn one_sample_of_noise_is_no_pull() {
    let robot = sawyer();
    let mut stepper = Stepper::new(press_down(&robot, ContactSettings::default())).unwrap();
    let mut memory = None;
    for (period, (force, is_fault)) in [(0.0, false), (1.3, false), (0.0, false), (2.0, true)].into_iter().enumerate() {
        let mut measured = LaggingArm::at_rest(&NOMINAL, DRIVE, 0.0, 1).measure(period as f64 * PERIOD);
        measured.wrench[2] = force;
        let command = stepper.step(&mut memory, &measured).unwrap();
        let phase = command.targets[0].contact[0].phase;
        assert_eq!(matches!(phase, ContactPhase::Fault(FaultCause::Pull)), is_fault, "{force} N: {phase:?}");
    }
}

/// The arm is measured to stand for a while, whatever its commands say, and then it has moved.
#[test]
fn the_tank_pays_for_the_measured_motion() {
    let robot = sawyer();
    let height = |position: &[f64]| Configuration::new(&robot, position).unwrap().tool_pose().translation.vector.z;
    let mut stepper = Stepper::new(press_down(&robot, ContactSettings::default())).unwrap();
    let mut memory = None;
    for period in 0..10 {
        let mut measured = LaggingArm::at_rest(&NOMINAL, DRIVE, 0.0, 1).measure(f64::from(period) * PERIOD);
        measured.wrench[2] = -100.0;
        if period == 9 {
            measured.joint_position[1] -= 1e-3;
        }
        stepper.step(&mut memory, &measured).unwrap();
        let way = height(&NOMINAL) - height(&measured.joint_position);
        let expected = (100.0 * way - 30.0 * 0.05 * PERIOD).max(0.0);
        let spent = memory.as_ref().unwrap().contacts[0].spent;
        assert!((spent - expected).abs() <= 0.01 * expected, "{period}: {spent} {expected}");
        assert!(period < 9 || way > 1e-4, "{way}");
    }
}

/// The clock of a held contact never runs below zero, however long a period is.
#[test]
fn the_memory_stays_valid_with_long_periods() {
    let Law::Contact(law) = contact(&[30.0], ContactSettings::default()) else { unreachable!() };
    let timing = ContactTiming::new(1.0, Drive { lag_s: 0.0, delay_periods: 0 }, 0.002, 0.0);
    let mut axis = ContactAxis { phase: ContactPhase::Contact, hold_time: 0.2, ..ContactAxis::START };
    axis.estimate.upper = 1e6;
    let input = AxisInput {
        force: 90.0,
        limited_force: 90.0,
        target: 30.0,
        moved: [0.0, 1.0],
        to_rest: 0.0,
        last_velocity: 0.0,
        acceleration: 5.0,
    };
    law.step(0, &timing, input, &mut axis);
    assert_eq!(axis.hold_time, 0.0);
}

#[test]
fn states_that_come_late_keep_the_model_of_the_arm() {
    let robot = sawyer();
    for every in [2, 3] {
        let walls = [(2, 0.01, -1.0, 1e4)];
        let settings = ContactSettings::default();
        let mut world = World::new(&robot, &NOMINAL, press_down(&robot, settings), &walls);
        world.run(2.0, every);
        assert!((world.force[2] + 30.0).abs() < 0.3 && world.peak[2] < 36.0, "{every}: {:?}", world.force);
        // The model is where the arm is.
        let moved = world.start[2] - world.tool().tool_pose().translation.vector.z;
        let modelled = world.memory.as_ref().unwrap().contacts[0].position;
        assert!((moved - modelled).abs() < 2e-4, "{every}: {moved} {modelled}");
    }
}

#[test]
fn the_same_controller_goes_on_from_its_contact_and_ends_a_fault() {
    let robot = sawyer();
    let walls = [(2, 0.005, -1.0, 1e4)];
    let settings = ContactSettings { max_force: 60.0, ..ContactSettings::default() };
    let (first, second) = (press_down(&robot, settings), press_down(&robot, settings));
    let mut world = World::new(&robot, &NOMINAL, press_down(&robot, settings), &walls);
    world.run(1.5, 1);
    let memory = world.memory.clone().unwrap();
    let kept = second.continue_from(&first, &memory, &world.arm.q).unwrap();
    assert_eq!(kept.contacts, memory.contacts);
    let mut faulty = memory.clone();
    faulty.contacts[0].phase = ContactPhase::Fault(FaultCause::Pull);
    let kept = second.continue_from(&first, &faulty, &world.arm.q).unwrap();
    assert_eq!(kept.contacts[0].phase, ContactPhase::Approach);
    let settings = ContactSettings { approach_speed: Some(0.01), ..settings };
    let up = vec![task(&[Axis::Z], contact(&[30.0], settings)), task(&OTHERS, position(5, 3.0))];
    let reversed = pressing(&robot, up);
    let refused = reversed.continue_from(&first, &memory, &world.arm.q).unwrap_err();
    assert_eq!(refused, TransitionError::Reverses { task: 0 });
    // Neither another name nor another way to state the frame hides it.
    let mut renamed = vec![task(&[Axis::Z], contact(&[30.0], settings)), task(&OTHERS, position(5, 3.0))];
    renamed[0].name = "lift".to_owned();
    let both = vec![
        task(&[Axis::Y, Axis::Z], contact(&[5.0, 30.0], settings)),
        task(&[Axis::X, Axis::Rx, Axis::Ry, Axis::Rz], position(4, 3.0)),
    ];
    for tasks in [renamed, both] {
        let refused = pressing(&robot, tasks).continue_from(&first, &memory, &world.arm.q).unwrap_err();
        assert_eq!(refused, TransitionError::Reverses { task: 0 });
    }
    let sideways =
        pressing(&robot, vec![task(&[Axis::X], contact(&[5.0], settings)), task(&[Axis::Z], position(1, 3.0))]);
    assert!(sideways.continue_from(&first, &memory, &world.arm.q).is_ok());
    let mut free = memory.clone();
    free.contacts[0].phase = ContactPhase::Approach;
    let started = reversed.continue_from(&first, &free, &world.arm.q).unwrap();
    assert_eq!(started.contacts, [ContactAxis::START], "the memory is along the pressing direction");
    let mut damaged = memory;
    damaged.contacts[0].estimate.upper = f64::NAN;
    let mut measured = world.arm.measure(world.time);
    measured.wrench[2] = -30.0;
    assert!(world.stepper.step(&mut Some(damaged), &measured).is_err());
}

#[test]
fn a_law_without_direction_or_with_impossible_numbers_does_not_exist() {
    let law = |force: f64, settings| ContactLaw::new(constant(&[force]), vec![settings]);
    let settings = ContactSettings::default();
    assert!(law(30.0, settings).is_ok() && law(0.0, settings).is_err());
    for wrong in [
        ContactSettings { noise: 0.0, ..settings },
        ContactSettings { stiffest: 10.0, ..settings },
        ContactSettings { max_force: 0.5, ..settings },
        ContactSettings { approach_speed: Some(f64::NAN), ..settings },
        ContactSettings { bias: -1.0, ..settings },
    ] {
        assert!(law(30.0, wrong).is_err(), "{wrong:?}");
    }
    // The robot config of the tests is the slow one of most arms.
    let tasks = vec![task(&[Axis::Z], contact(&[-30.0], settings))];
    assert!(Controller::new(config(&sawyer(), tasks)).is_ok());
}
